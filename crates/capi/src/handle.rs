//! What an opaque pointer points to.

use crate::status::Fault;
use core::mem::replace;

/// A value that is poisoned when a panic interrupts a change.
#[derive(Debug)]
pub(crate) struct Handle<T> {
    value: T,
    poisoned: bool,
}

impl<T> Handle<T> {
    pub fn new(value: T) -> Self {
        Self { value, poisoned: false }
    }

    /// The value, if it is sound; `what` names it for the error.
    pub fn get(&self, what: &'static str) -> Result<&T, Fault> {
        if self.poisoned { Err(Fault::Poisoned(what)) } else { Ok(&self.value) }
    }

    /// Changes the value. Poisoned stays what `change` does not return from.
    pub fn change<R>(
        &mut self,
        what: &'static str,
        change: impl FnOnce(&mut T) -> Result<R, Fault>,
    ) -> Result<R, Fault> {
        if replace(&mut self.poisoned, true) {
            return Err(Fault::Poisoned(what));
        }
        let result = change(&mut self.value);
        self.poisoned = false;
        result
    }
}
