//! What one frame tells the next about a pair.

use crate::handle::Handle;
use crate::mesh::put;
use crate::status::{door, free, given, punctual_status};
use core::mem::MaybeUninit;
use punctual::PairMemory;

/// Memory of one pair of trees between frames. It changes the speed of an answer, never the answer; handed to another pair of
/// trees, it forgets everything; refitted trees it takes for the same. One thread at a time may use it.
#[derive(Debug)]
pub struct punctual_memory(pub(crate) Handle<PairMemory>);

/// What is remembered.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct punctual_memory_facts {
    /// When it was last decided: 1 if the surfaces met, 0 if not; -1 if it never was.
    pub last_verdict: i32,
    /// Frames since it was last decided.
    pub frames_undecided: u32,
    /// BV tests of the last query that ran to its end; -1 if none did.
    pub last_bv_tests: i64,
}

/// Makes a memory that knows nothing, of about 100 bytes.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_memory_new(
    memory: Option<&mut MaybeUninit<Option<Box<punctual_memory>>>>,
) -> punctual_status {
    door("punctual_memory_new", || put(memory, || Ok(punctual_memory(Handle::new(PairMemory::new())))))
}

/// Frees a memory; null is fine.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_memory_free(memory: Option<Box<punctual_memory>>) {
    free(memory);
}

/// Tells what is remembered.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_memory_describe(
    memory: Option<&punctual_memory>,
    facts: Option<&mut MaybeUninit<punctual_memory_facts>>,
) -> punctual_status {
    door("punctual_memory_describe", || {
        let (memory, facts) = (given(memory, "memory")?.0.get("memory")?, given(facts, "facts")?);
        facts.write(punctual_memory_facts {
            last_verdict: memory.last_verdict().map_or(-1, i32::from),
            frames_undecided: memory.frames_undecided(),
            last_bv_tests: memory.last_bv_tests().map_or(-1, |tests| tests.min(i64::MAX as u64) as i64),
        });
        Ok(())
    })
}
