//! One call: which of its arguments are wrong, and what it may answer then.

use std::ffi::CStr;
use std::mem::MaybeUninit;
use std::ptr::{null, null_mut};
use std::slice;

use libfuzzer_sys::arbitrary::{Result, Unstructured};
use punctual_capi::{punctual_last_error, punctual_status as Status};

/// How wrong a call is.
#[derive(Default)]
pub struct Call {
    /// One of these it must answer, if there is any.
    faults: Vec<Status>,
    /// One of these it may answer.
    doubts: Vec<Status>,
}

impl Call {
    /// A fault of this call, if `wrong`.
    pub fn fault(&mut self, wrong: bool, status: Status) {
        if wrong {
            self.faults.push(status);
        }
    }

    /// What the model does not foretell.
    pub fn doubt(&mut self, status: Status) {
        self.doubts.push(status);
    }

    /// The pointer, or now and then null.
    pub fn given<P>(&mut self, bytes: &mut Unstructured, pointer: P) -> Result<Option<P>> {
        let null = bytes.ratio(1, 64)?;
        self.fault(null, Status::Null);
        Ok((!null).then_some(pointer))
    }

    /// One of `known` values of an enumeration, or now and then another.
    pub fn value(&mut self, bytes: &mut Unstructured, known: u32) -> Result<u32> {
        let value = if bytes.ratio(1, 64)? {
            bytes.arbitrary()?
        } else {
            bytes.int_in_range(0..=known - 1)?
        };
        self.fault(value >= known, Status::BadArgument);
        Ok(value)
    }

    /// Pointer and length of an array, or now and then null, an odd address or a length that no memory has.
    pub fn array<T>(
        &mut self,
        bytes: &mut Unstructured,
        pointer: *mut T,
        count: usize,
    ) -> Result<(*mut T, usize)> {
        if count == 0 || !bytes.ratio(1, 16)? {
            return Ok((if count == 0 { null_mut() } else { pointer }, count));
        }
        let kind = bytes.int_in_range(0..=if align_of::<T>() > 1 { 2 } else { 1 })?;
        self.fault(
            true,
            if kind == 0 {
                Status::Null
            } else {
                Status::BadArgument
            },
        );
        Ok(match kind {
            0 => (null_mut(), count),
            1 => (pointer, usize::MAX - count),
            _ => (pointer.wrapping_byte_add(1), count),
        })
    }

    /// Makes a call that writes to one place: what it wrote, unless it failed.
    pub fn make<T>(
        mut self,
        bytes: &mut Unstructured,
        call: impl FnOnce(Option<&mut MaybeUninit<T>>) -> Status,
    ) -> Result<Option<T>> {
        let mut out = MaybeUninit::<T>::uninit();
        // SAFETY: any bytes may be in a place without a value.
        unsafe {
            out.as_mut_ptr()
                .cast::<u8>()
                .write_bytes(0xa5, size_of::<T>())
        };
        let place = self.given(bytes, &mut out)?;
        if self.judge(call(place)) {
            // SAFETY: a call that succeeds has written its output.
            return Ok(Some(unsafe { out.assume_init() }));
        }
        // SAFETY: the bytes from above, or others that a call wrote against its word, which the sanitizer sees.
        let left = unsafe { slice::from_raw_parts(out.as_ptr().cast::<u8>(), size_of::<T>()) };
        assert!(
            left.iter().all(|&byte| byte == 0xa5),
            "a failure wrote an output"
        );
        Ok(None)
    }

    /// As [`make`](Self::make) for a struct that begins with its size.
    pub fn fill<T>(
        mut self,
        bytes: &mut Unstructured,
        call: impl FnOnce(*mut T) -> Status,
    ) -> Result<Option<T>> {
        let mut out = sized(0xa5);
        let place = self.given(bytes, out.as_mut_ptr())?.unwrap_or(null_mut());
        if self.judge(call(place)) {
            // SAFETY: a call that succeeds has written its output.
            return Ok(Some(unsafe { out.assume_init() }));
        }
        // SAFETY: all of it was written, or overwritten against the call's word.
        let left = unsafe { slice::from_raw_parts(out.as_ptr().cast::<u8>(), size_of::<T>()) };
        assert!(
            left[size_of::<u32>()..].iter().all(|&byte| byte == 0xa5),
            "a failure wrote an output"
        );
        Ok(None)
    }

    /// As [`make`](Self::make) for a handle.
    pub fn own<T>(
        self,
        bytes: &mut Unstructured,
        call: impl FnOnce(Option<&mut MaybeUninit<Option<Box<T>>>>) -> Status,
    ) -> Result<Option<Box<T>>> {
        Ok(self
            .make(bytes, call)?
            .map(|handle| handle.expect("a call that succeeds makes a handle")))
    }

    /// Whether the call succeeded, as it must if nothing was wrong.
    pub fn judge(self, status: Status) -> bool {
        // SAFETY: the text ends with a zero byte and is copied before the next call.
        let text = || {
            unsafe { CStr::from_ptr(punctual_last_error()) }
                .to_str()
                .expect("UTF-8")
                .to_owned()
        };
        if status == Status::Ok {
            assert!(
                self.faults.is_empty(),
                "succeeded in spite of {:?}",
                self.faults
            );
            return true;
        }
        let expected = self.faults.contains(&status) || self.doubts.contains(&status);
        assert!(
            expected,
            "{status:?}, not {:?} or {:?}: {}",
            self.faults,
            self.doubts,
            text()
        );
        assert!(text().starts_with("punctual_"), "{}", text());
        false
    }
}

/// A place for a struct that begins with its size; all other bytes are alike.
pub fn sized<T>(byte: u8) -> MaybeUninit<T> {
    let mut out = MaybeUninit::<T>::uninit();
    // SAFETY: any bytes may be in a place without a value, and the struct is longer than its size.
    unsafe {
        out.as_mut_ptr()
            .cast::<u8>()
            .write_bytes(byte, size_of::<T>());
        out.as_mut_ptr().cast::<u32>().write(size_of::<T>() as u32);
    }
    out
}

/// A struct as an `_init` of the interface makes it.
pub fn begun<T>(init: impl FnOnce(*mut T, usize)) -> T {
    let mut out = MaybeUninit::uninit();
    init(out.as_mut_ptr(), size_of::<T>());
    // SAFETY: it writes as many bytes as it is told.
    unsafe { out.assume_init() }
}

/// A struct of the caller's, or null.
pub fn asked<T>(question: Option<&T>) -> *const T {
    question.map_or(null(), |question| question)
}

/// An index into a list that is not empty.
pub fn any<T>(bytes: &mut Unstructured, list: &[T]) -> Result<Option<usize>> {
    if list.is_empty() {
        Ok(None)
    } else {
        bytes.choose_index(list.len()).map(Some)
    }
}
