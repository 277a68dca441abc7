//! The contacts that a query has found, in the order of their distances: a list of limited room
//! that never moves them.

use super::Contact;
use alloc::vec::Vec;
use arrayvec::ArrayVec;

/// Contacts that are sorted in together: enough that moving the others costs little, and few enough
/// for one step.
const BLOCK: usize = 16;

/// Contacts, nearest first once they are [sorted](Self::sort).
///
/// Under a budget of time they are sorted block by block as they come, so that no call ends with
/// much to sort. Otherwise all are sorted at the end, which takes less.
#[derive(Debug, Default)]
pub(crate) struct ContactList {
    /// In the order in which they were found. Those of a list that was drained stay until the next
    /// is added.
    contacts: Vec<Contact>,
    /// Their places: those that are sorted, nearest first, then the latest.
    order: Vec<Place>,
    sorted: usize,
    /// For the sorting: where the contacts of each part of the margin begin.
    starts: Vec<u32>,
    /// Whether the call has a budget of time.
    is_timed: bool,
    /// Most contacts at a time, if there is room for them.
    limit: usize,
    /// Triangle pairs this close are contacts; `None` if the query at hand does not look for any.
    margin: Option<f64>,
}

/// Where a contact stands, in the order of distances and then of triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Place {
    /// The bits of the distance, which is not negative, and both triangles: compared without a look
    /// at the contact.
    distance: u64,
    triangles: u64,
    contact: u32,
}

impl Place {
    fn new(contact: &Contact, index: usize) -> Self {
        let [a, b] = contact.triangles.map(u64::from);
        Self {
            distance: contact.distance.to_bits(),
            triangles: a << 32 | b,
            contact: index as u32,
        }
    }
}

impl ContactList {
    pub fn reserve(&mut self, contacts: usize) {
        let contacts = contacts.min(u32::MAX as usize);
        self.contacts
            .reserve(contacts.saturating_sub(self.contacts.len()));
        self.order
            .reserve(contacts.saturating_sub(self.order.len()));
        self.starts
            .reserve(contacts.saturating_sub(self.starts.len()));
    }

    pub fn capacity(&self) -> usize {
        self.contacts
            .capacity()
            .min(self.order.capacity())
            .min(self.starts.capacity())
    }

    /// Forgets all contacts, and what is looked for.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.order.clear();
        self.sorted = 0;
        self.margin = None;
    }

    /// Looks for triangle pairs this close, at most `limit` at a time.
    pub fn begin(&mut self, margin: f64, limit: usize) {
        (self.margin, self.limit) = (Some(margin), limit);
    }

    /// Before a call, with a limit of time or without.
    pub fn hurry(&mut self, is_timed: bool) {
        self.is_timed = is_timed;
    }

    /// How close a contact is, at most; `None` if contacts are not looked for.
    #[inline(always)]
    pub fn margin(&self) -> Option<f64> {
        self.margin
    }

    /// Whether contacts are looked for, and there is no room for any more.
    #[inline(always)]
    pub fn is_full(&self) -> bool {
        self.margin.is_some() && self.room() == 0
    }

    /// How many more there is room for.
    #[inline(always)]
    pub fn room(&self) -> usize {
        self.limit
            .min(self.capacity())
            .saturating_sub(self.order.len())
    }

    /// Adds a contact; there must be room.
    #[inline]
    pub fn push(&mut self, contact: Contact) {
        debug_assert!(!self.is_full());
        if self.order.is_empty() {
            self.contacts.clear();
        }
        self.order.push(Place::new(&contact, self.contacts.len()));
        self.contacts.push(contact);
        if self.is_timed && self.order.len() == self.sorted + BLOCK {
            self.sort();
        }
    }

    /// Sorts the latest in. A few are inserted, the farthest first: a search for each, and each of
    /// the others moves once.
    pub fn sort(&mut self) {
        let mut end = core::mem::replace(&mut self.sorted, self.order.len());
        let latest = &mut self.order[end..];
        if latest.len() > BLOCK || end == 0 {
            return self.sort_all();
        }
        latest.sort_unstable();
        let latest: ArrayVec<Place, BLOCK> = latest.iter().copied().collect();
        for (before, new) in latest.into_iter().enumerate().rev() {
            let at = self.order[..end].partition_point(|old| *old < new);
            self.order.copy_within(at..end, at + before + 1);
            self.order[at + before] = new;
            end = at;
        }
    }

    /// Sorts all: each into its part of the margin, of which there are as many as contacts, then
    /// those of each part. Expected linear time where distances are spread over the margin.
    fn sort_all(&mut self) {
        let Self {
            contacts,
            order,
            starts,
            ..
        } = self;
        let Some(margin) = self.margin.filter(|margin| *margin > 0.0) else {
            return order.sort_unstable();
        };
        let count = order.len();
        let parts_per_length = count as f64 / margin;
        let part = |place: &Place| {
            ((f64::from_bits(place.distance) * parts_per_length) as usize).min(count - 1)
        };
        starts.clear();
        starts.resize(count, 0);
        order.iter().for_each(|place| starts[part(place)] += 1);
        let mut end = 0;
        for start in starts.iter_mut() {
            end += *start;
            *start = end;
        }
        // Each moves down from the end of its part to its place.
        for (index, contact) in contacts.iter().enumerate().take(count) {
            let place = Place::new(contact, index);
            let start = &mut starts[part(&place)];
            *start -= 1;
            order[*start as usize] = place;
        }
        let mut end = count;
        for start in starts.iter().rev().map(|start| *start as usize) {
            if end - start > 1 {
                order[start..end].sort_unstable();
            }
            end = start;
        }
    }

    /// All of them, nearest first, if they are sorted.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &Contact> + Clone {
        debug_assert!(self.sorted == self.order.len());
        self.order
            .iter()
            .map(|place| &self.contacts[place.contact as usize])
    }

    /// Takes all of them out, nearest first, if they are sorted.
    pub fn drain(&mut self) -> impl ExactSizeIterator<Item = Contact> {
        debug_assert!(self.sorted == self.order.len());
        self.sorted = 0;
        self.order
            .drain(..)
            .map(|place| self.contacts[place.contact as usize])
    }
}

impl Clone for ContactList {
    fn clone(&self) -> Self {
        let Self {
            sorted,
            limit,
            margin,
            ..
        } = *self;
        let mut clone = Self {
            sorted,
            limit,
            margin,
            ..Self::default()
        };
        // A cloned vector has no room beyond what it holds.
        clone.reserve(self.capacity());
        clone.contacts.extend_from_slice(&self.contacts);
        clone.order.extend_from_slice(&self.order);
        clone
    }
}
