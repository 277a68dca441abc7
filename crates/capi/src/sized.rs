//! Structs that may grow: what a caller and a library of different versions read and write of them.
//!
//! Such a struct begins with its size, as the caller knows it; of an array the size of one element
//! is an argument beside its length. New fields come at the end, and 0 in them means what the
//! library did before it had them. So of an older, shorter struct no byte behind its end is
//! touched, and the fields that it lacks have their defaults. In a newer, longer one, what is not
//! known here has to be 0 where it is read, and becomes 0 where it is written.

use crate::arrays::{check, room};
use crate::status::Fault;
use core::mem::MaybeUninit;
use core::{ptr, slice};

/// No struct is larger: a size beyond this was never set.
const LARGEST: usize = 1024;

/// A struct to which fields may be added.
///
/// # Safety
/// It is `repr(C)`, and every pattern of bits is a value of it, but for its pointers.
pub(crate) unsafe trait Grows: Copy {
    /// The size of the fields that every caller has.
    const LEAST: usize;
}

/// One that begins with `size: u32`.
///
/// # Safety
/// It does.
pub(crate) unsafe trait Sized32: Grows {}

/// `grows!(T: needed.. fields)`: every caller has the fields up to `needed`. Nothing follows the
/// last one, so that a new field makes the struct longer rather than to fill its end.
macro_rules! grows {
    ($type:ident $(<$life:lifetime>)?: size, $needed:ident.. $($field:ident)*) => {
        $crate::sized::grows!($type $(<$life>)?: $needed.. $($field)*);
        // SAFETY: checked below.
        unsafe impl $(<$life>)? $crate::sized::Sized32 for $type $(<$life>)? {}
        impl $(<$life>)? $type $(<$life>)? {
            pub(crate) const SIZE: u32 = size_of::<Self>() as u32;
        }
        const _: () = assert!(core::mem::offset_of!($type, size) == 0);
    };
    ($type:ident $(<$life:lifetime>)?: $needed:ident.. $($field:ident)*) => {
        // SAFETY: `repr(C)` and plain, as all structs of the header.
        unsafe impl $(<$life>)? $crate::sized::Grows for $type $(<$life>)? {
            const LEAST: usize = $crate::sized::end(
                core::mem::offset_of!($type, $needed), |it: &$type| &it.$needed
            );
        }
        const _: () = {
            let ends = [$($crate::sized::end(
                core::mem::offset_of!($type, $field), |it: &$type| &it.$field
            )),*];
            assert!(ends[ends.len() - 1] == size_of::<$type>());
        };
    };
}
pub(crate) use grows;

/// Where a field ends.
pub(crate) const fn end<T, F>(offset: usize, _: fn(&T) -> &F) -> usize {
    offset + size_of::<F>()
}

/// A struct of the caller's; what it lacks has its default.
///
/// # Safety
/// `pointer` is null, or points to as many bytes as the struct there says, which nothing writes to
/// meanwhile.
pub(crate) unsafe fn read<T: Sized32 + Default>(
    pointer: *const T,
    what: &'static str,
) -> Result<T, Fault> {
    // SAFETY: the caller's promise.
    let size = unsafe { size_at(pointer, what) }?;
    let known = size.min(size_of::<T>());
    // SAFETY: as long as it says.
    let unknown = unsafe { slice::from_raw_parts(pointer.cast::<u8>().add(known), size - known) };
    if unknown.iter().any(|&byte| byte != 0) {
        return Err(Fault::Newer(what));
    }
    let mut value = T::default();
    // SAFETY: both are so long, and every pattern of bits is a value.
    unsafe { ptr::copy_nonoverlapping(pointer.cast::<u8>(), (&raw mut value).cast::<u8>(), known) };
    Ok(value)
}

/// An array of structs that each begin with their size, the same for all.
///
/// # Safety
/// `pointer` is null or points to `count` of them; see [`read`].
pub(crate) unsafe fn read_all<T: Sized32 + Default>(
    pointer: *const T,
    count: usize,
    what: &'static str,
) -> Result<Vec<T>, Fault> {
    if count == 0 {
        return Ok(Vec::new());
    }
    // SAFETY: the caller's promise.
    let size = unsafe { size_at(pointer, what) }?;
    if count.checked_mul(size).is_none() {
        return Err(Fault::Array(what));
    }
    let mut all = Vec::new();
    all.try_reserve_exact(count)
        .map_err(|_| Fault::OutOfMemory)?;
    for index in 0..count {
        // SAFETY: the caller's promise: they are so far apart.
        let element = unsafe { pointer.byte_add(index * size) };
        // SAFETY: the same.
        match unsafe { size_at(element, what) }? {
            // SAFETY: the same.
            same if same == size => all.push(unsafe { read(element, what) }?),
            other => return Err(Fault::Size(what, other)),
        }
    }
    Ok(all)
}

/// A struct of the caller's that is to be written.
pub(crate) struct Place<T> {
    at: *mut T,
    size: usize,
}

/// The place for a struct, of the size that it says.
///
/// # Safety
/// As [`read`], and nothing else uses it until it is written.
pub(crate) unsafe fn place<T: Sized32>(
    pointer: *mut T,
    what: &'static str,
) -> Result<Place<T>, Fault> {
    // SAFETY: the caller's promise.
    let size = unsafe { size_at(pointer, what) }?;
    Ok(Place { at: pointer, size })
}

impl<T: Sized32> Place<T> {
    pub fn write(self, value: T) {
        let size = self.size as u32;
        // SAFETY: there are as many bytes, by the promise made to `place` or `begin`.
        let bytes =
            unsafe { slice::from_raw_parts_mut(self.at.cast::<MaybeUninit<u8>>(), self.size) };
        copy(value, bytes);
        // SAFETY: the struct begins with its size.
        unsafe { self.at.cast::<u32>().write(size) };
    }
}

/// Makes a struct of so many bytes what it is by default. Nothing is written if it cannot be of
/// that size.
///
/// # Safety
/// `pointer` is null or points to as many bytes, which nothing else uses meanwhile.
pub(crate) unsafe fn begin<T: Sized32>(pointer: *mut T, size: usize, value: T) {
    if check(pointer, 1, "").is_ok() && check_size::<T>(size, "").is_ok() {
        Place { at: pointer, size }.write(value);
    }
}

/// Writes as many items as there is room for, each to `size` bytes. How many items there are.
///
/// # Safety
/// `pointer` is null or points to room for `capacity` elements of that size, which nothing else
/// uses meanwhile.
pub(crate) unsafe fn fill_rows<T: Grows>(
    pointer: *mut T,
    size: usize,
    capacity: usize,
    what: &'static str,
    mut items: impl Iterator<Item: Into<T>>,
) -> Result<usize, Fault> {
    let mut written = 0;
    if capacity > 0 {
        check(pointer, 1, what)?;
        check_size::<T>(size, what)?;
        let bytes = capacity.checked_mul(size).ok_or(Fault::Array(what))?;
        // SAFETY: the caller's promise.
        let room = unsafe { room(pointer.cast::<u8>(), bytes, what) }?;
        for (row, item) in room.chunks_exact_mut(size).zip(&mut items) {
            copy(item.into(), row);
            written += 1;
        }
    }
    Ok(written + items.count())
}

/// [`fill_rows`], and how many items there are is written to `count`.
///
/// # Safety
/// That of [`fill_rows`].
pub(crate) unsafe fn rows<T: Grows>(
    pointer: *mut T,
    size: usize,
    capacity: usize,
    what: &'static str,
    count: &mut MaybeUninit<usize>,
    items: impl Iterator<Item: Into<T>>,
) -> Result<(), Fault> {
    // SAFETY: the caller's promise.
    count.write(unsafe { fill_rows(pointer, size, capacity, what, items) }?);
    Ok(())
}

/// As much of a value as there is room for, and zeros behind it.
fn copy<T: Grows>(value: T, to: &mut [MaybeUninit<u8>]) {
    // SAFETY: the bytes of a value, some of them perhaps not initialised.
    let from = unsafe {
        slice::from_raw_parts((&raw const value).cast::<MaybeUninit<u8>>(), size_of::<T>())
    };
    let (known, unknown) = to.split_at_mut(from.len().min(to.len()));
    known.copy_from_slice(&from[..known.len()]);
    unknown.fill(MaybeUninit::new(0));
}

/// The size that a struct says.
///
/// # Safety
/// `pointer` is null or points to a struct that begins with it.
unsafe fn size_at<T: Sized32>(pointer: *const T, what: &'static str) -> Result<usize, Fault> {
    check(pointer, 1, what)?;
    // SAFETY: not null and aligned; the rest is the caller's promise.
    let size = unsafe { pointer.cast::<u32>().read() } as usize;
    check_size::<T>(size, what)?;
    Ok(size)
}

fn check_size<T: Grows>(size: usize, what: &'static str) -> Result<(), Fault> {
    let fits = (T::LEAST..=LARGEST).contains(&size) && size.is_multiple_of(align_of::<T>());
    if fits {
        Ok(())
    } else {
        Err(Fault::Size(what, size))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    crate::verbs::types! {
        /// A struct as it may be after two more versions.
        asked Grown(first) {
            /// Needed.
            first: u32 = 1,
            /// Newer.
            second: f64 = 2.0,
            /// Newest.
            third: u64 = 3,
        }
    }

    /// Eight words, of which the first is the size.
    fn words(size: u32) -> [u64; 8] {
        let mut words = [u64::MAX; 8];
        // SAFETY: room for a size.
        unsafe { words.as_mut_ptr().cast::<[u32; 2]>().write([size, 7]) };
        words
    }

    #[test]
    fn a_shorter_struct_has_defaults_for_what_it_lacks() {
        for (size, second, third) in [(8, 2.0, 3), (16, f64::from_bits(u64::MAX), 3)] {
            // SAFETY: there are more bytes than it says.
            let value = unsafe { read(words(size).as_ptr().cast::<Grown>(), "it") }.unwrap();
            assert_eq!((value.size, value.first, value.third), (size, 7, third));
            assert_eq!(value.second.to_bits(), second.to_bits());
        }
    }

    #[test]
    fn a_longer_struct_is_refused_if_it_asks_for_what_is_not_known() {
        let mut longer = words(40);
        (longer[3], longer[4]) = (0, 0);
        // SAFETY: there are more bytes than it says.
        let asked = |words: &[u64; 8]| unsafe { read(words.as_ptr().cast::<Grown>(), "it") };
        assert_eq!(asked(&longer).unwrap().third, u64::MAX);
        longer[4] = 1 << 63;
        assert_eq!(
            asked(&longer).unwrap_err().to_string(),
            "it has a field set that this library, 0.1.0, does not have"
        );
    }

    #[test]
    fn a_write_fills_the_struct_and_stays_within_it() {
        let value = Grown {
            size: Grown::SIZE,
            first: 4,
            second: 5.0,
            third: 6,
        };
        let all = [0, 5f64.to_bits(), 6, 0, 0, 0, 0, 0];
        for size in [8, 16, 24, 32, 64] {
            let mut room = words(size);
            // SAFETY: there are as many bytes as it says.
            unsafe { place(room.as_mut_ptr().cast::<Grown>(), "it") }
                .unwrap()
                .write(value);
            let known = size as usize / 8;
            assert_eq!(room[0], u64::from(size) | 4 << 32);
            assert_eq!(room[1..known], all[1..known]);
            assert!(room[known..].iter().all(|&word| word == u64::MAX));
        }
    }

    #[test]
    fn sizes_that_no_struct_has_are_refused() {
        for size in [0, 4, 7, 12, 1032, u32::MAX] {
            // SAFETY: refused before anything else is read.
            let error = unsafe { read(words(size).as_ptr().cast::<Grown>(), "it") }.unwrap_err();
            assert!(
                error
                    .to_string()
                    .starts_with(&format!("the size of it is given as {size}")),
                "{error}"
            );
        }
    }

    #[test]
    fn arrays_have_the_element_size_of_the_caller() {
        let items = [1, 2, 3].map(|first| Grown {
            first,
            ..Grown::default()
        });
        for size in [8, 24, 32] {
            let mut room = [u64::MAX; 16];
            // SAFETY: room for two of them.
            let count = unsafe {
                fill_rows(
                    room.as_mut_ptr().cast::<Grown>(),
                    size,
                    2,
                    "it",
                    items.into_iter(),
                )
            };
            assert_eq!(count.unwrap(), 3);
            assert_eq!([room[0] >> 32, room[size / 8] >> 32], [1, 2]);
            assert_eq!(
                room[size / 8 - 1],
                if size == 32 {
                    0
                } else {
                    [room[0], 0, 3][size / 8 - 1]
                }
            );
            assert!(room[size / 4..].iter().all(|&word| word == u64::MAX));
        }
    }
}
