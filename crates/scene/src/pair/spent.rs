//! Work done for a pair.

use punctual::Workspace;

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Spent {
    pub work: u64,
    pub bv_tests: u64,
}

impl Spent {
    /// All work of the query in a workspace.
    pub fn of(workspace: &Workspace) -> Self {
        Self {
            work: workspace.work(),
            bv_tests: workspace.bv_tests(),
        }
    }

    pub fn add(&mut self, other: Self) {
        self.work += other.work;
        self.bv_tests += other.bv_tests;
    }

    pub fn since(self, before: Self) -> Self {
        Self {
            work: self.work - before.work,
            bv_tests: self.bv_tests - before.bv_tests,
        }
    }
}

/// Work in 32 bits, saturating.
pub(crate) fn capped(work: u64) -> u32 {
    work.min(u64::from(u32::MAX)) as u32
}
