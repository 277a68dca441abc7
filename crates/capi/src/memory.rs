//! What one frame tells the next about a pair.

use crate::handle::get;
use crate::pose::punctual_pose;
use crate::sized::place;
use crate::status::{Fault, given};
use crate::tree::punctual_tree;
use crate::verbs::{calls, handles, types};
use core::mem::MaybeUninit;
use punctual::PairMemory;

handles! {
    /// Memory of one pair of trees between frames. It changes the speed of an answer, never the
    /// answer; handed to another pair of trees, it forgets everything; refitted trees it takes for
    /// the same. One thread at a time may use it.
    punctual_memory(PairMemory);

    /// Frees a memory; null is fine.
    punctual_memory_free(memory);
}

types! {
    /// What is remembered.
    told punctual_memory_facts(last_verdict) {
        /// When it was last decided: 1 if the surfaces met, 0 if not; -1 if it never was.
        last_verdict: i32,
        /// Frames since it was last decided.
        frames_undecided: u32,
        /// BV tests of the last query that ran to its end; -1 if none did.
        last_bv_tests: i64,
        /// How often the verdict changes from one decided frame to the next, 0 to 1: a mean over
        /// about the last 20.
        change_rate: f64,
    }
}

pub(crate) fn known(memory: Option<&punctual_memory>) -> Result<Option<&PairMemory>, Fault> {
    memory.map(|memory| memory.0.get("memory")).transpose()
}

calls! {
    /// Makes a memory that knows nothing, of about 1 kB.
    make punctual_memory_new() -> memory: punctual_memory =
        PairMemory::new();
}

calls! {
    /// Tells what is remembered.
    unsafe fn punctual_memory_describe(
        memory: Option<&punctual_memory>, facts: *mut punctual_memory_facts
    ) {
        let memory = get(memory, "memory")?;
        // SAFETY: the contract of the header for structs.
        let facts = unsafe { place(facts, "facts") }?;
        facts.write(punctual_memory_facts {
            size: punctual_memory_facts::SIZE,
            last_verdict: memory.last_verdict().map_or(-1, i32::from),
            frames_undecided: memory.frames_undecided(),
            last_bv_tests: memory.last_bv_tests()
                .map_or(-1, |tests| tests.min(i64::MAX as u64) as i64),
            change_rate: memory.change_rate(),
        });
        Ok(())
    }

    /// Proven: how far apart the surfaces are at least at this pose, in the unit of the meshes, as
    /// far as distance queries with this memory have shown it of these trees: what they proved,
    /// less the longest way of a point of B since then. 0 if nothing is known. Costs some 50
    /// operations. While it is more than 0, a `punctual_query` with this memory answers
    /// VERDICT_SEPARATED at once.
    ///
    /// Fails with NULL, BAD_POSE or POISONED.
    fn punctual_memory_clearance(
        memory: Option<&punctual_memory>, a: Option<&punctual_tree>, b: Option<&punctual_tree>,
        b_in_a: punctual_pose, clearance: Option<&mut MaybeUninit<f64>>
    ) {
        let memory = get(memory, "memory")?;
        let (a, b) = (get(a, "a")?, get(b, "b")?);
        let clearance = given(clearance, "clearance")?;
        clearance.write(memory.clearance(a, b, &b_in_a.check()?));
        Ok(())
    }
}
