//! Connected components of contacts: union-find over corners that contacts share on both sides.

use crate::contact::Contact;
use crate::mesh::Mesh;
use crate::sets::unite;
use alloc::vec::Vec;
use glam::DVec3;

/// Groups of contacts, and the buffers of the search for them.
#[derive(Clone, Debug, Default)]
pub(super) struct Joined {
    /// Union-find parents: for each contact an earlier one of its group, or itself if it is the
    /// first.
    parents: Vec<u32>,
    /// For each side and each corner of each contact, the first corner at the same position.
    corners: [Vec<u32>; 2],
    firsts: Firsts,
    /// The end of each group in `members`, and all members, group after group.
    ends: Vec<u32>,
    members: Vec<u32>,
}

impl Joined {
    pub fn reserve(&mut self, contacts: usize) {
        self.parents.reserve(contacts);
        self.corners
            .iter_mut()
            .for_each(|corners| corners.reserve(3 * contacts));
        self.firsts
            .slots
            .reserve((18 * contacts).next_power_of_two());
        self.ends.reserve(contacts);
        self.members.reserve(contacts);
    }

    /// Finds the groups of these contacts, and returns their number.
    pub fn join(&mut self, meshes: [&Mesh; 2], contacts: &[Contact]) -> usize {
        for (side, mesh) in meshes.into_iter().enumerate() {
            self.find_corners(side, mesh, contacts);
        }
        let corners = &self.corners;
        let pair = |i: u32| {
            let (contact, combination) = (i / 9 * 3, i % 9);
            [
                corners[0][(contact + combination / 3) as usize],
                corners[1][(contact + combination % 3) as usize],
            ]
        };
        self.parents.clear();
        self.parents.extend(0..contacts.len() as u32);
        self.firsts.clear(9 * contacts.len());
        for i in 0..9 * contacts.len() as u32 {
            let [x, y] = pair(i);
            let hash = mixed(u64::from(x) | u64::from(y) << 32);
            let first = self.firsts.first(hash, i, |other| pair(other) == [x, y]);
            unite(&mut self.parents, first / 9, i / 9);
        }
        self.sort_by_group()
    }

    /// Merges corners at the same position, also if the mesh has several vertices there.
    fn find_corners(&mut self, side: usize, mesh: &Mesh, contacts: &[Contact]) {
        // Contacts of another mesh may name triangles that do not exist. Their corners are NaN,
        // which equals nothing, so these contacts have no neighbors.
        let triangle = |contact: &Contact| {
            let id = contact.triangles[side] as usize;
            if id < mesh.len() {
                mesh.triangle(id)
            } else {
                [DVec3::NAN; 3]
            }
        };
        self.firsts.clear(3 * contacts.len());
        self.corners[side].clear();
        for (contact, i) in contacts.iter().zip((0..).step_by(3)) {
            for (corner, i) in triangle(contact).into_iter().zip(i..) {
                let same = |j: u32| triangle(&contacts[j as usize / 3])[j as usize % 3] == corner;
                self.corners[side].push(self.firsts.first(hash(corner), i, same));
            }
        }
    }

    /// Lists the members group by group. Groups are in the order of their first members.
    fn sort_by_group(&mut self) -> usize {
        let Self {
            parents,
            ends,
            members,
            ..
        } = self;
        ends.clear();
        // From here on `parents` holds group numbers. The first of each group comes before the
        // others.
        for i in 0..parents.len() {
            if parents[i] == i as u32 {
                parents[i] = ends.len() as u32;
                ends.push(0);
            } else {
                parents[i] = parents[parents[i] as usize];
            }
            ends[parents[i] as usize] += 1;
        }
        let mut start = 0;
        for end in ends.iter_mut() {
            start += core::mem::replace(end, start);
        }
        members.clear();
        members.resize(parents.len(), 0);
        for (member, &group) in (0..).zip(parents.iter()) {
            members[ends[group as usize] as usize] = member;
            ends[group as usize] += 1;
        }
        ends.len()
    }

    /// The members of each group, in the order of the contacts.
    pub fn groups(&self, count: usize) -> impl Iterator<Item = &[u32]> {
        (0..count).map(|group| {
            let start = if group == 0 { 0 } else { self.ends[group - 1] };
            &self.members[start as usize..self.ends[group] as usize]
        })
    }
}

/// Finds the first of equal items: a hash table with linear probing.
#[derive(Clone, Debug, Default)]
struct Firsts {
    slots: Vec<u32>,
}

impl Firsts {
    const FREE: u32 = u32::MAX;

    /// Empties the table and makes room for `count` items.
    fn clear(&mut self, count: usize) {
        self.slots.clear();
        self.slots
            .resize((2 * count).next_power_of_two(), Self::FREE);
    }

    /// Returns the first item equal to `i`, or `i` itself if there is none.
    fn first(&mut self, hash: u64, i: u32, is_same: impl Fn(u32) -> bool) -> u32 {
        let mask = self.slots.len() - 1;
        let mut slot = hash as usize & mask;
        while self.slots[slot] != Self::FREE && !is_same(self.slots[slot]) {
            slot = (slot + 1) & mask;
        }
        if self.slots[slot] == Self::FREE {
            self.slots[slot] = i;
        }
        self.slots[slot]
    }
}

/// -0.0 and 0.0 have the same hash.
fn hash(point: DVec3) -> u64 {
    (point + DVec3::ZERO)
        .to_array()
        .into_iter()
        .fold(0, |hash, x| mixed(hash ^ x.to_bits()))
}

/// Mixes the bits: each bit of the result depends on all bits of `x`.
fn mixed(x: u64) -> u64 {
    let x = (x ^ x >> 32).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ x >> 29).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x ^ x >> 32
}
