//! Fixed-capacity list of the contacts that a query has found, sorted by distance. Contacts never
//! move; only their order does.

use super::contact::Contact;
use crate::engine::workspace::Workspace;
use crate::room::Room;
use arrayvec::ArrayVec;

/// Number of contacts that are inserted together. A larger block moves the other contacts less
/// often; a smaller one keeps the step short.
const BLOCK: usize = 16;

/// Contacts, nearest first once they are [sorted](Self::sort).
///
/// Under a budget of time the list is sorted block by block as contacts arrive, so that no call
/// ends with a long sort. Otherwise it is sorted once at the end, which costs less.
#[derive(Clone, Debug, Default)]
pub(crate) struct ContactList {
    /// In order of discovery. Drained contacts stay here until the next one is added.
    contacts: Room<Contact>,
    /// The sort keys: `order[..sorted]` is nearest first, the rest in order of discovery.
    order: Room<Place>,
    sorted: usize,
    /// Scratch of `sort_all`: the start of each bucket.
    starts: Room<u32>,
    /// True if the call has a budget of time.
    is_timed: bool,
    /// Maximum number of contacts, if the capacity allows it.
    limit: usize,
    /// Number of contacts that are kept elsewhere.
    held: usize,
    /// Triangle pairs no farther apart than this are contacts. `None` if the query does not search
    /// for contacts. Radii are a part of it.
    margin: Option<f64>,
    /// Distances of contacts are not below minus this: the sum of the radii.
    radii: f64,
    /// True if the query asks for pairs, which go to another list.
    pub lists_pairs: bool,
}

/// Sort key of a contact: by distance, then by triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Place {
    /// The bits of the distance, those of a negative one inverted, so that they are ordered as the
    /// distance is.
    distance: u64,
    triangles: u64,
    contact: u32,
}

impl Place {
    fn new(contact: &Contact, index: usize) -> Self {
        let [a, b] = contact.triangles.map(u64::from);
        Self {
            distance: ordered(contact.distance.to_bits()),
            triangles: a << 32 | b,
            contact: index as u32,
        }
    }
}

const SIGN: u64 = 1 << 63;

fn ordered(bits: u64) -> u64 {
    if bits & SIGN == 0 { bits | SIGN } else { !bits }
}

fn unordered(bits: u64) -> u64 {
    if bits & SIGN == 0 { !bits } else { bits ^ SIGN }
}

impl ContactList {
    pub fn reserve(&mut self, contacts: usize) {
        let contacts = contacts.min(u32::MAX as usize);
        self.contacts.reserve_all(contacts);
        self.order.reserve_all(contacts);
        self.starts.reserve_all(contacts);
    }

    pub fn capacity(&self) -> usize {
        self.contacts
            .capacity()
            .min(self.order.capacity())
            .min(self.starts.capacity())
    }

    /// Removes all contacts and the margin.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.order.clear();
        self.sorted = 0;
        self.held = 0;
        self.margin = None;
        self.lists_pairs = false;
    }

    /// Counts a contact that is kept elsewhere.
    pub fn hold(&mut self) {
        self.held += 1;
    }

    /// Starts a search for triangle pairs of the cores within `margin`, which contains the radii,
    /// at most `limit` in the list at a time.
    pub fn begin(&mut self, margin: f64, radii: f64, limit: usize) {
        (self.margin, self.radii, self.limit) = (Some(margin), radii, limit);
    }

    /// Prepares for a call of a query. `is_timed`: the call has a budget of time.
    pub fn hurry(&mut self, is_timed: bool) {
        self.is_timed = is_timed;
    }

    /// Maximum distance of a contact. `None` if the query does not search for contacts.
    #[inline(always)]
    pub fn margin(&self) -> Option<f64> {
        self.margin
    }

    /// True if the query searches for contacts and the list is full.
    #[inline(always)]
    pub fn is_full(&self) -> bool {
        self.margin.is_some() && self.room() == 0
    }

    /// Number of contacts that can be added.
    #[inline(always)]
    pub fn room(&self) -> usize {
        self.limit
            .min(self.capacity())
            .saturating_sub(self.order.len() + self.held)
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

    /// Sorts in the contacts added since the last sort. Up to [`BLOCK`] contacts are inserted, the
    /// farthest first: each needs one binary search, and every other key moves once. More contacts
    /// are sorted together with all others.
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

    /// Bucket sort: the margin is divided into as many buckets as there are contacts, and each
    /// bucket is sorted. Expected linear time if distances are spread over the margin.
    fn sort_all(&mut self) {
        let Self {
            contacts,
            order,
            starts,
            radii,
            ..
        } = self;
        let Some(margin) = self.margin.filter(|margin| *margin > 0.0) else {
            return order.sort_unstable();
        };
        let count = order.len();
        let parts_per_length = count as f64 / margin;
        let part = |place: &Place| {
            let distance = f64::from_bits(unordered(place.distance)) + *radii;
            ((distance * parts_per_length) as usize).min(count - 1)
        };
        starts.clear();
        starts.resize(count, 0);
        order.iter().for_each(|place| starts[part(place)] += 1);
        let mut end = 0;
        for start in starts.iter_mut() {
            end += *start;
            *start = end;
        }
        // Fills each bucket from its end.
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

    /// All contacts, nearest first. The list must be sorted.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &Contact> + Clone {
        debug_assert!(self.sorted == self.order.len());
        self.order
            .iter()
            .map(|place| &self.contacts[place.contact as usize])
    }

    /// Removes and returns all contacts, nearest first. The list must be sorted.
    pub fn drain(&mut self) -> impl ExactSizeIterator<Item = Contact> {
        debug_assert!(self.sorted == self.order.len());
        self.sorted = 0;
        self.order
            .drain(..)
            .map(|place| self.contacts[place.contact as usize])
    }
}

impl Workspace {
    /// The contacts that the last query found, if it was a contact query, without drained ones:
    /// nearest first, at equal distance by the ids of their triangles.
    pub fn contacts(&self) -> impl ExactSizeIterator<Item = &Contact> + Clone {
        self.state.contacts.iter()
    }

    /// Removes and returns the contacts, nearest first, so that a query stopped with
    /// [`crate::StopReason::PairsFull`] can be resumed.
    pub fn drain_contacts(&mut self) -> impl ExactSizeIterator<Item = Contact> {
        self.state.contacts.drain()
    }

    /// Reserves room for at least `contacts` contacts, 170 bytes each. If there is no room at all,
    /// the first contact query reserves room for 4,096. After more room is reserved, a query
    /// stopped with [`crate::StopReason::PairsFull`] can be resumed without draining.
    pub fn reserve_contacts(&mut self, contacts: usize) {
        self.state.contacts.reserve(contacts);
    }
}
