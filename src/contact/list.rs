//! The contacts that a query has found, in the order of their distances: a list of limited room that never moves them.

use super::Contact;
use alloc::vec::Vec;
use core::cmp::Ordering;

/// Contacts, nearest first. Adding one takes a search and the move of some indices, so that no call ends with a sort.
#[derive(Debug, Default)]
pub(crate) struct ContactList {
    /// In the order in which they were found. Those of a list that was drained stay until the next is added.
    contacts: Vec<Contact>,
    /// Which they are, nearest first.
    order: Vec<u32>,
    /// Most contacts at a time, if there is room for them.
    limit: usize,
    /// Triangle pairs this close are contacts; `None` if the query at hand does not look for any.
    margin: Option<f64>,
}

impl ContactList {
    /// Makes room for at least so many.
    pub fn reserve(&mut self, contacts: usize) {
        let contacts = contacts.min(u32::MAX as usize);
        self.contacts.reserve(contacts.saturating_sub(self.contacts.len()));
        self.order.reserve(contacts.saturating_sub(self.order.len()));
    }

    /// How many there is room for.
    pub fn capacity(&self) -> usize {
        self.contacts.capacity().min(self.order.capacity())
    }

    /// Forgets all contacts, and what is looked for.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.order.clear();
        self.margin = None;
    }

    /// Looks for triangle pairs this close, at most `limit` at a time.
    pub fn begin(&mut self, margin: f64, limit: usize) {
        (self.margin, self.limit) = (Some(margin), limit);
    }

    /// How close a contact is, at most; `None` if contacts are not looked for.
    #[inline(always)]
    pub fn margin(&self) -> Option<f64> {
        self.margin
    }

    /// Whether contacts are looked for, and there is no room for any more.
    #[inline(always)]
    pub fn is_full(&self) -> bool {
        self.margin.is_some() && self.order.len() >= self.limit.min(self.capacity())
    }

    /// Adds a contact; there must be room.
    pub fn push(&mut self, contact: Contact) {
        debug_assert!(!self.is_full());
        if self.order.is_empty() {
            self.contacts.clear();
        }
        let at = self.order.partition_point(|&i| compare(&self.contacts[i as usize], &contact) == Ordering::Less);
        self.order.insert(at, self.contacts.len() as u32);
        self.contacts.push(contact);
    }

    /// All of them, nearest first.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &Contact> + Clone {
        self.order.iter().map(|&i| &self.contacts[i as usize])
    }

    /// Takes all of them out, nearest first.
    pub fn drain(&mut self) -> impl ExactSizeIterator<Item = Contact> {
        self.order.drain(..).map(|i| self.contacts[i as usize])
    }
}

impl Clone for ContactList {
    fn clone(&self) -> Self {
        let mut clone = Self { limit: self.limit, margin: self.margin, ..Self::default() };
        // A cloned vector has no room beyond what it holds.
        clone.reserve(self.capacity());
        clone.contacts.extend_from_slice(&self.contacts);
        clone.order.extend_from_slice(&self.order);
        clone
    }
}

/// By distance; equal ones by their triangles.
fn compare(x: &Contact, y: &Contact) -> Ordering {
    x.distance.total_cmp(&y.distance).then(x.triangles.cmp(&y.triangles))
}
