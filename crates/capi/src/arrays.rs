//! Arrays and texts of the caller's: the pointers that the compiler cannot check.

use crate::status::Fault;
use core::ffi::{CStr, c_char};
use core::mem::MaybeUninit;
use core::slice;
use std::path::Path;

/// An array to be read, of `count` elements. Null is fine for none.
///
/// # Safety
/// `pointer` is null or points to `count` elements that nothing writes to as long as the slice
/// lives, and every pattern of bits is a value of `T`.
pub(crate) unsafe fn array<'a, T>(
    pointer: *const T,
    count: usize,
    what: &'static str,
) -> Result<&'a [T], Fault> {
    if count == 0 {
        return Ok(&[]);
    }
    check(pointer, count, what)?;
    // SAFETY: not null, aligned and no longer than memory, as checked; the rest is the caller's
    // promise.
    Ok(unsafe { slice::from_raw_parts(pointer, count) })
}

/// Whether there is memory for so many things of so many bytes each. Asked before what would end
/// the program without.
pub(crate) fn find_room<const N: usize>(things: [(usize, usize); N]) -> Result<(), Fault> {
    let sum =
        |sum: usize, (count, bytes): (usize, usize)| sum.checked_add(count.checked_mul(bytes)?);
    let bytes = things
        .into_iter()
        .try_fold(0, sum)
        .ok_or(Fault::OutOfMemory)?;
    Vec::<u8>::new()
        .try_reserve_exact(bytes)
        .map_err(|_| Fault::OutOfMemory)
}

/// The path of a file, in UTF-8.
///
/// # Safety
/// `pointer` is null or points to a text that ends with a zero byte, and that nothing writes to as
/// long as the path lives.
pub(crate) unsafe fn path<'a>(
    pointer: *const c_char,
    what: &'static str,
) -> Result<&'a Path, Fault> {
    // SAFETY: the caller's promise.
    unsafe { text(pointer, what) }.map(Path::new)
}

/// A text in UTF-8.
///
/// # Safety
/// As [`path`].
pub(crate) unsafe fn text<'a>(
    pointer: *const c_char,
    what: &'static str,
) -> Result<&'a str, Fault> {
    if pointer.is_null() {
        return Err(Fault::Null(what));
    }
    // SAFETY: not null; the rest is the caller's promise.
    let text = unsafe { CStr::from_ptr(pointer) };
    text.to_str().map_err(|_| Fault::NotUtf8(what))
}

/// An array to be written.
///
/// # Safety
/// `pointer` is null or points to room for `capacity` elements that nothing else uses as long as
/// the slice lives.
pub(crate) unsafe fn room<'a, T>(
    pointer: *mut T,
    capacity: usize,
    what: &'static str,
) -> Result<&'a mut [MaybeUninit<T>], Fault> {
    if capacity == 0 {
        return Ok(&mut []);
    }
    check(pointer, capacity, what)?;
    // SAFETY: as in `array`; `MaybeUninit` needs no value to be there.
    Ok(unsafe { slice::from_raw_parts_mut(pointer.cast(), capacity) })
}

/// Writes as many items as there is room for. How many items there are.
///
/// # Safety
/// `pointer` is null or points to room for `capacity` elements that nothing else uses during the
/// call.
pub(crate) unsafe fn fill<T>(
    pointer: *mut T,
    capacity: usize,
    what: &'static str,
    mut items: impl Iterator<Item: Into<T>>,
) -> Result<usize, Fault> {
    // SAFETY: the caller's promise.
    let room = unsafe { room(pointer, capacity, what) }?;
    let mut written = 0;
    for (place, item) in room.iter_mut().zip(&mut items) {
        place.write(item.into());
        written += 1;
    }
    Ok(written + items.count())
}

/// [`fill`], and how many items there are is written to `count`.
///
/// # Safety
/// That of [`fill`].
pub(crate) unsafe fn list<T>(
    pointer: *mut T,
    capacity: usize,
    what: &'static str,
    count: &mut MaybeUninit<usize>,
    items: impl Iterator<Item: Into<T>>,
) -> Result<(), Fault> {
    // SAFETY: the caller's promise.
    count.write(unsafe { fill(pointer, capacity, what, items) }?);
    Ok(())
}

/// Whether there may be so many elements.
pub(crate) fn check<T>(pointer: *const T, count: usize, what: &'static str) -> Result<(), Fault> {
    if pointer.is_null() {
        return Err(Fault::Null(what));
    }
    let fits = count
        .checked_mul(size_of::<T>())
        .is_some_and(|bytes| bytes <= isize::MAX as usize);
    if fits && pointer.is_aligned() {
        Ok(())
    } else {
        Err(Fault::Array(what))
    }
}
