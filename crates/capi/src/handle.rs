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
}

/// What a handle of the interface holds: one is a tuple whose first field is a [`Handle`].
pub(crate) trait Holds {
    type Value;
    fn handle(&self) -> &Handle<Self::Value>;
    fn handle_mut(&mut self) -> &mut Handle<Self::Value>;
}

/// The value of a handle, if there is one and it is sound.
pub(crate) fn get<'h, H: Holds>(
    handle: Option<&'h H>,
    what: &'static str,
) -> Result<&'h H::Value, Fault> {
    given(handle, what)?.handle().get(what)
}

/// [`Handle::change`] of a handle, if there is one.
pub(crate) fn change<H: Holds, R>(
    handle: Option<&mut H>,
    what: &'static str,
    change: impl FnOnce(&mut H::Value) -> Result<R, Fault>,
) -> Result<R, Fault> {
    given(handle, what)?.handle_mut().change(what, change)
}

/// Makes a value and hands it over, if there is a place for it.
pub(crate) fn put<T: Into<H>, H>(
    out: Option<&mut MaybeUninit<Option<Box<H>>>>,
    make: impl FnOnce() -> Result<T, Fault>,
) -> Result<(), Fault> {
    let made = make()?.into();
    given(out, "the place for the new handle")?.write(Some(Box::new(made)));
    Ok(())
}
