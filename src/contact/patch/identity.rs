//! Ids of patches: a patch inherits the id of the patch of the previous frame with which it shares
//! most triangles.
//!
//! A triangle links every previous patch that contains it with every current one. A triangle in
//! many patches, such as a floor under many feet, links two patches only through contacts that also
//! have the same triangle on the other side. So there are at most a few links per contact.

use super::Patch;
use crate::contact::Contact;
use alloc::vec::Vec;

/// Assigns ids to patches.
#[derive(Clone, Debug, Default)]
pub(super) struct Identities {
    pub before: PatchMemory,
    /// The triangles of the patches of the current frame.
    now: Vec<Part>,
    /// Pairs of a previous and a current patch, with the number of contacts that they have in
    /// common.
    links: Vec<Link>,
}

/// The triangles of the patches of a frame, and their ids.
#[derive(Clone, Debug, Default)]
pub struct PatchMemory {
    /// Sorted by triangle.
    known: Vec<Part>,
    /// In the order of the patches.
    ids: Vec<u64>,
    next: u64,
}

impl PatchMemory {
    /// Reserves room for the patches of `contacts` contacts.
    pub fn reserve(&mut self, contacts: usize) {
        self.known
            .reserve_exact((2 * contacts).saturating_sub(self.known.len()));
        self.ids
            .reserve_exact(contacts.saturating_sub(self.ids.len()));
    }

    /// Forgets the patches. No id is used again.
    pub fn forget(&mut self) {
        self.known.clear();
        self.ids.clear();
    }

    /// The next id.
    pub fn next(&self) -> u64 {
        self.next
    }

    /// Starts the ids at `next`.
    pub fn begin_at(&mut self, next: u64) {
        self.next = next;
    }
}

/// One side of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Part {
    /// 0 for a triangle of A, 1 for one of B; then the id of the triangle.
    triangle: (u8, u32),
    patch: u32,
    /// The triangle of the other side.
    other: u32,
}

#[derive(Clone, Copy, Debug)]
struct Link {
    before: u32,
    now: u32,
    contacts: u32,
}

/// A triangle links all patches that contain it, unless that makes more links per patch than this.
const LINKS_PER_PATCH: usize = 4;

/// The id of a patch that has none yet, or has passed its id on.
const NO_ID: u64 = u64::MAX;

impl Identities {
    /// Reserves room for the patches of `contacts` contacts.
    pub fn reserve(&mut self, contacts: usize) {
        self.before.reserve(contacts);
        self.now.reserve(2 * contacts);
        // For each contact, a frame has at most two pairs of a triangle and a patch that contains
        // it. Over both frames, each such pair makes at most [`LINKS_PER_PATCH`] links.
        self.links.reserve(4 * LINKS_PER_PATCH * contacts);
    }

    /// Assigns ids to the patches of these contacts, and remembers them.
    pub fn assign(&mut self, patches: &mut [Patch], contacts: &[Contact]) {
        self.list(patches, contacts);
        self.link();
        let Self {
            before: PatchMemory { known, ids, next },
            now,
            links,
        } = self;
        patches.iter_mut().for_each(|patch| patch.id = NO_ID);
        for link in links {
            hand_down(
                &mut ids[link.before as usize],
                &mut patches[link.now as usize],
            );
        }
        if patches.iter().any(|patch| patch.id == NO_ID) {
            // The remaining patches share no contacts with a previous patch, only triangles that
            // many patches contain. They take the free ids of those patches in order.
            for [before, now] in common(known, now) {
                let mut left = before.iter().map(|part| part.patch as usize);
                for part in now.iter() {
                    let patch = &mut patches[part.patch as usize];
                    if patch.id != NO_ID {
                        continue;
                    }
                    let Some(free) = left.find(|&patch| ids[patch] != NO_ID) else {
                        break;
                    };
                    hand_down(&mut ids[free], patch);
                }
            }
        }
        ids.clear();
        for patch in patches {
            if patch.id == NO_ID {
                patch.id = *next;
                *next += 1;
            }
            ids.push(patch.id);
        }
        core::mem::swap(known, now);
    }

    /// Lists both sides of all contacts, sorted.
    fn list(&mut self, patches: &[Patch], contacts: &[Contact]) {
        self.now.clear();
        for (patch, of) in (0..).zip(patches) {
            for &Contact {
                triangles: [a, b], ..
            } in &contacts[of.range()]
            {
                self.now.push(Part {
                    triangle: (0, a),
                    patch,
                    other: b,
                });
                self.now.push(Part {
                    triangle: (1, b),
                    patch,
                    other: a,
                });
            }
        }
        self.now.sort_unstable();
    }

    /// Lists the links between the patches of both frames, sorted by the number of common contacts,
    /// largest first.
    fn link(&mut self) {
        let Self { before, now, links } = self;
        links.clear();
        for [before, now] in common(&mut before.known, now) {
            let [patches_before, patches_now] =
                [&*before, &*now].map(|parts| by_patch(parts).count());
            if patches_before * patches_now <= LINKS_PER_PATCH * (patches_before + patches_now) {
                for before in by_patch(before) {
                    links.extend(
                        by_patch(now)
                            .map(|now| Link::new(before[0], now[0], before.len().min(now.len()))),
                    );
                }
            } else {
                link_contacts(before, now, links);
            }
        }
        links.sort_unstable_by_key(|link| (link.before, link.now));
        links.dedup_by(|next, kept| {
            let is_same = (next.before, next.now) == (kept.before, kept.now);
            kept.contacts += if is_same { next.contacts } else { 0 };
            is_same
        });
        links.sort_unstable_by_key(|link| {
            (core::cmp::Reverse(link.contacts), link.before, link.now)
        });
    }
}

impl Link {
    fn new(before: Part, now: Part, contacts: usize) -> Self {
        Self {
            before: before.patch,
            now: now.patch,
            contacts: contacts as u32,
        }
    }
}

/// Moves an id to a patch, if the patch has none.
fn hand_down(id: &mut u64, patch: &mut Patch) {
    if patch.id == NO_ID {
        patch.id = core::mem::replace(id, NO_ID);
    }
}

/// Splits the parts of a triangle by patch.
fn by_patch(parts: &[Part]) -> impl Iterator<Item = &[Part]> {
    parts.chunk_by(|x, y| x.patch == y.patch)
}

/// For each triangle that occurs in both frames, its parts in the previous frame, then in this one.
fn common<'p>(
    before: &'p mut [Part],
    now: &'p mut [Part],
) -> impl Iterator<Item = [&'p mut [Part]; 2]> {
    let mut rest = before;
    now.chunk_by_mut(|x, y| x.triangle == y.triangle)
        .filter_map(move |now| {
            let triangle = now[0].triangle;
            let from = core::mem::take(&mut rest);
            let start = from.partition_point(|part| part.triangle < triangle);
            let end = start + from[start..].partition_point(|part| part.triangle == triangle);
            let (head, tail) = from.split_at_mut(end);
            rest = tail;
            (start < end).then(|| [&mut head[start..], now])
        })
}

/// Links patches by those contacts of a triangle that occur in both frames.
fn link_contacts(before: &mut [Part], now: &mut [Part], links: &mut Vec<Link>) {
    before.sort_unstable_by_key(|part| part.other);
    now.sort_unstable_by_key(|part| part.other);
    let mut rest = &before[..];
    for part in now.iter() {
        rest = &rest[rest.partition_point(|before| before.other < part.other)..];
        if let [first, after @ ..] = rest
            && first.other == part.other
        {
            links.push(Link::new(*first, *part, 1));
            rest = after;
        }
    }
    now.sort_unstable();
}
