//! Ids of patches: a patch keeps the id of the one of the frame before with which it has most triangles in common.

use super::Patch;
use crate::contact::Contact;
use alloc::vec::Vec;

/// Gives ids to patches.
#[derive(Clone, Debug, Default)]
pub(super) struct Identities {
    pub before: PatchMemory,
    /// The triangles of the patches of the frame at hand.
    now: Vec<Share>,
    /// How much a patch of the frame at hand has in common with one before.
    links: Vec<Link>,
}

/// The triangles of the patches of a frame, and the ids that were given out.
#[derive(Clone, Debug, Default)]
pub(crate) struct PatchMemory {
    /// Sorted.
    known: Vec<Share>,
    /// In the order of the patches.
    ids: Vec<u64>,
    next: u64,
}

impl PatchMemory {
    /// Makes room for the patches of so many contacts.
    pub fn reserve(&mut self, contacts: usize) {
        self.known.reserve_exact((2 * contacts).saturating_sub(self.known.len()));
        self.ids.reserve_exact(contacts.saturating_sub(self.ids.len()));
    }

    /// Forgets the patches. No id is given out again.
    pub fn forget(&mut self) {
        self.known.clear();
        self.ids.clear();
    }

    /// The next id that is given out.
    pub fn next(&self) -> u64 {
        self.next
    }

    /// Gives out ids from this one on.
    pub fn begin_at(&mut self, next: u64) {
        self.next = next;
    }
}

/// A triangle of a patch, and how many contacts it has there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Share {
    /// The triangles of A come first.
    triangle: (u8, u32),
    patch: u32,
    contacts: u32,
}

#[derive(Clone, Copy, Debug)]
struct Link {
    before: u32,
    now: u32,
    contacts: u32,
}

/// A triangle that is in more pairs of patches than this is ignored.
const MOST_LINKS: usize = 4096;

impl Identities {
    /// Makes room for the patches of so many contacts.
    pub fn reserve(&mut self, contacts: usize) {
        self.before.reserve(contacts);
        self.now.reserve(2 * contacts);
        // Some of the triangles that a few contacts have may be in many patches.
        self.links.reserve(4 * contacts + 2 * MOST_LINKS);
    }

    /// Gives ids to patches with these contacts, and remembers them.
    pub fn assign(&mut self, patches: &mut [Patch], contacts: &[Contact]) {
        self.list(patches, contacts);
        self.link();
        let PatchMemory { known, ids, next } = &mut self.before;
        patches.iter_mut().for_each(|patch| patch.id = u64::MAX);
        for link in &self.links {
            let (patch, id) = (&mut patches[link.now as usize], &mut ids[link.before as usize]);
            if patch.id == u64::MAX && *id != u64::MAX {
                patch.id = core::mem::replace(id, u64::MAX);
            }
        }
        ids.clear();
        for patch in patches {
            if patch.id == u64::MAX {
                patch.id = *next;
                *next += 1;
            }
            ids.push(patch.id);
        }
        core::mem::swap(known, &mut self.now);
    }

    /// The triangles of all patches, each once, sorted.
    fn list(&mut self, patches: &[Patch], contacts: &[Contact]) {
        self.now.clear();
        for (patch, of) in (0..).zip(patches) {
            for contact in &contacts[of.range()] {
                let share = |(side, triangle)| Share { triangle: (side, triangle), patch, contacts: 1 };
                self.now.extend((0..).zip(contact.triangles).map(share));
            }
        }
        self.now.sort_unstable();
        self.now.dedup_by(|next, kept| {
            let is_same = (next.triangle, next.patch) == (kept.triangle, kept.patch);
            kept.contacts += u32::from(is_same);
            is_same
        });
    }

    /// What patches of both frames have in common, most first.
    fn link(&mut self) {
        let Self { before, now, links } = self;
        links.clear();
        let mut rest = &before.known[..];
        for of_now in now.chunk_by(|x, y| x.triangle == y.triangle) {
            let triangle = of_now[0].triangle;
            rest = &rest[rest.partition_point(|share| share.triangle < triangle)..];
            let of_before = &rest[..rest.partition_point(|share| share.triangle == triangle)];
            if of_now.len() * of_before.len() > MOST_LINKS {
                continue;
            }
            for before in of_before {
                let contacts = |now: &Share| before.contacts.min(now.contacts);
                let link = |now: &Share| Link { before: before.patch, now: now.patch, contacts: contacts(now) };
                links.extend(of_now.iter().map(link));
            }
        }
        links.sort_unstable_by_key(|link| (link.before, link.now));
        links.dedup_by(|next, kept| {
            let is_same = (next.before, next.now) == (kept.before, kept.now);
            kept.contacts += if is_same { next.contacts } else { 0 };
            is_same
        });
        links.sort_unstable_by_key(|link| (core::cmp::Reverse(link.contacts), link.before, link.now));
    }
}
