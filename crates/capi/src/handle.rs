//! What an opaque pointer points to.

use crate::status::{Fault, given};
use core::mem::{MaybeUninit, replace};

/// A value that is poisoned when a panic interrupts a change.
#[derive(Debug)]
pub(crate) struct Handle<T> {
    value: T,
    poisoned: bool,
}

impl<T> Handle<T> {
    pub fn new(value: T) -> Self {
        Self {
            value,
            poisoned: false,
        }
    }

    /// The value, if it is sound; `what` names it for the error.
    pub fn get(&self, what: &'static str) -> Result<&T, Fault> {
        if self.poisoned {
            Err(Fault::Poisoned(what))
        } else {
            Ok(&self.value)
        }
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

    /// Changes the value in a way that cannot fail.
    pub fn set(&mut self, what: &'static str, change: impl FnOnce(&mut T)) -> Result<(), Fault> {
        self.change(what, |value| {
            change(value);
            Ok(())
        })
    }
}

/// Makes a value and hands it over, if there is a place for it.
pub(crate) fn put<T: Into<H>, H>(
    out: Option<&mut MaybeUninit<Option<Box<H>>>>,
    make: impl FnOnce() -> Result<T, Fault>,
) -> Result<(), Fault> {
    let out = given(out, "the place for the new handle")?;
    out.write(Some(Box::new(make()?.into())));
    Ok(())
}
