//! Vectors that keep their room when they are cloned: a buffer that was full would stop every
//! query.

use alloc::vec::Vec;
use core::ops::{Deref, DerefMut};

/// A vector whose clone has the same capacity.
#[derive(Debug)]
pub(crate) struct Room<T>(Vec<T>);

impl<T> Room<T> {
    pub fn new(capacity: usize) -> Self {
        Self(Vec::with_capacity(capacity))
    }

    /// Makes room for at least `count` items in total.
    pub fn reserve_all(&mut self, count: usize) {
        self.0.reserve_exact(count.saturating_sub(self.0.len()));
    }
}

impl<T> Default for Room<T> {
    fn default() -> Self {
        Self::new(0)
    }
}

impl<T: Clone> Clone for Room<T> {
    fn clone(&self) -> Self {
        let mut clone = Self::new(self.capacity());
        clone.extend_from_slice(self);
        clone
    }
}

impl<T> Deref for Room<T> {
    type Target = Vec<T>;

    fn deref(&self) -> &Vec<T> {
        &self.0
    }
}

impl<T> DerefMut for Room<T> {
    fn deref_mut(&mut self) -> &mut Vec<T> {
        &mut self.0
    }
}
