//! A program without `std`: two meshes, one query under a deadline, with memory, clock and output of its own.
//!
//! Only the C library is linked, as a small operating system or a hypervisor would have it; on a machine without any, replace
//! the four functions in [`c`]. `.ci/run` runs it and looks for symbols of `std` in it.

#![no_std]
#![no_main]

extern crate alloc;

use core::alloc::{GlobalAlloc, Layout};
use core::panic::PanicInfo;
use core::time::Duration;

use alloc::format;
use punctual::glam::{DMat3, DVec3};
use punctual::{
    Budget, Clock, PairMemory, Pose, Query, StopReason, Tree, Verdict, Workspace, shapes,
};

/// What this program asks of the outside.
mod c {
    use core::ffi::{c_int, c_long, c_void};

    #[repr(C)]
    pub struct Time {
        pub seconds: i64,
        pub nanoseconds: c_long,
    }

    pub const MONOTONIC: c_int = 1;

    #[link(name = "c")]
    unsafe extern "C" {
        pub fn aligned_alloc(alignment: usize, size: usize) -> *mut c_void;
        pub fn free(pointer: *mut c_void);
        pub fn write(file: c_int, bytes: *const c_void, count: usize) -> isize;
        pub fn clock_gettime(clock: c_int, time: *mut Time) -> c_int;
        pub fn abort() -> !;
    }
}

struct Heap;

// SAFETY: `aligned_alloc` gives `size` bytes so aligned, or null, and `free` takes what it gave. Alignments are powers of
// two, and the size is rounded up to a multiple, as C11 asks.
unsafe impl GlobalAlloc for Heap {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let layout = layout.pad_to_align();
        // SAFETY: any numbers are allowed.
        unsafe { c::aligned_alloc(layout.align(), layout.size()).cast() }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, _: Layout) {
        // SAFETY: it came from `alloc`.
        unsafe { c::free(pointer.cast()) }
    }
}

#[global_allocator]
static HEAP: Heap = Heap;

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    // SAFETY: it may be called at any time.
    unsafe { c::abort() }
}

// The `alloc` that comes with Rust for this machine is compiled to unwind and asks for these two; nothing here unwinds.
#[unsafe(no_mangle)]
extern "C" fn rust_eh_personality() {}

#[unsafe(no_mangle)]
extern "C" fn _Unwind_Resume() -> ! {
    // SAFETY: it may be called at any time.
    unsafe { c::abort() }
}

struct Monotonic;

impl Clock for Monotonic {
    fn now(&self) -> Duration {
        let mut time = c::Time {
            seconds: 0,
            nanoseconds: 0,
        };
        // SAFETY: `time` is one, and outlives the call.
        unsafe { c::clock_gettime(c::MONOTONIC, &raw mut time) };
        Duration::new(time.seconds as u64, time.nanoseconds as u32)
    }
}

fn print(text: &str) {
    // SAFETY: the pointer and the length are those of `text`.
    unsafe { c::write(1, text.as_ptr().cast(), text.len()) };
}

/// Whether the answers are those that are known.
fn ask() -> Result<bool, alloc::boxed::Box<dyn core::error::Error>> {
    let knot = Tree::new(shapes::torus_knot(2, 3, 0.2, 64));
    let ball = Tree::from_bytes(&Tree::new(shapes::icosphere(4)).to_bytes())?;
    let mut workspace = Workspace::new();
    let mut memory = PairMemory::new();
    let mut as_expected = true;
    for (shift, meet) in [(0.8, true), (9.0, false)] {
        let query = Query::all_pairs(&knot, &ball, Pose::new(DMat3::IDENTITY, DVec3::X * shift)?);
        let budget = Budget::time(Duration::from_secs(1));
        let outcome = query
            .with_memory(&mut memory)
            .run(&mut workspace, budget.clock(&Monotonic));
        let spent = outcome.stats.elapsed.unwrap_or_default();
        print(&format!(
            "{:?}, {} pairs, {} BV tests, {spent:?}\n",
            outcome.value, outcome.stats.found, outcome.stats.bv_tests
        ));
        as_expected &=
            outcome.stop == StopReason::Finished && meet == (outcome.value != Verdict::Separated);
        // A budget of work needs no clock.
        let stopped = query.run(&mut workspace, Budget::work(50));
        as_expected &= query.certificate(&workspace)?.upper_bound()
            >= outcome.stats.found.max(stopped.stats.found);
    }
    // Without one there is no time: such a call does nothing, and says so.
    let query = Query::intersection(&knot, &ball, Pose::IDENTITY);
    let untimed = query.run(&mut workspace, Budget::time(Duration::from_secs(1)));
    as_expected &= untimed.stop == StopReason::Deadline && untimed.stats.work == 0;
    as_expected &= query.resume(&mut workspace, Budget::unlimited())?.value != Verdict::Undecided;
    Ok(as_expected)
}

#[unsafe(no_mangle)]
extern "C" fn main() -> i32 {
    match ask() {
        Ok(true) => 0,
        Ok(false) => 1,
        Err(error) => {
            print(&format!("{error}\n"));
            2
        }
    }
}
