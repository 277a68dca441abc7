//! The buffers of a query.

use crate::arrays::find_room;
use crate::handle::{change, get};
use crate::rays::Rays;
use crate::sized::{place, read};
use crate::status::{Fault, given};
use crate::verbs::{calls, handles, types};
use core::mem::MaybeUninit;
use punctual::Workspace;
use punctual::prediction::CostModel;

handles! {
    /// Every buffer that a query needs, and what the last query found and left open. Allocated
    /// once: queries do not allocate. One thread at a time may use it.
    punctual_workspace(Workspace, Rays);

    /// Frees a workspace; null is fine.
    punctual_workspace_free(workspace);
}

types! {
    /// Two triangles that intersect: ids of the input meshes, from 0.
    plain punctual_triangle_pair {
        /// Triangle of A.
        a: u32,
        /// Triangle of B.
        b: u32,
    }
}

impl From<[u32; 2]> for punctual_triangle_pair {
    fn from([a, b]: [u32; 2]) -> Self {
        Self { a, b }
    }
}

// `[u32; 2]` is handed out as this.
const _: () =
    assert!(size_of::<punctual_triangle_pair>() == 8 && align_of::<punctual_triangle_pair>() == 4);

calls! {
    /// Makes a workspace with room for 4,096 queued node pairs and 65,536 found pairs, about 960
    /// kB.
    make punctual_workspace_new() -> workspace: punctual_workspace = Workspace::new();

    /// Makes a workspace with room for `queue` node pairs (a full queue costs order, no answer) and
    /// `pairs` found pairs, at least 1 (when they are full, the query stops with PAIRS_FULL, to be
    /// drained and resumed): `20 queue + 8 pairs` bytes and about 320 kB.
    ///
    /// Fails with OUT_OF_MEMORY if there is not that much.
    make punctual_workspace_with_capacity(queue: usize, pairs: usize)
        -> workspace: punctual_workspace = {
            find_room([(queue, 20), (pairs, 8), (1, 1 << 19)])?;
            Workspace::with_capacity(queue, pairs)
        };
}

calls! {
    /// Uses the portable kernels from now on, whatever the machine offers: slower, the same bits.
    change punctual_workspace_use_portable_kernels(workspace: punctual_workspace) =
        workspace.use_portable_kernels();

    /// The intersecting pairs that the last query found, in order of discovery, without those
    /// drained. They stay the workspace's, and are valid until it is used again.
    fn punctual_workspace_pairs(
        workspace: Option<&punctual_workspace>,
        pairs: Option<&mut MaybeUninit<*const punctual_triangle_pair>>,
        count: Option<&mut MaybeUninit<usize>>
    ) {
        let workspace = get(workspace, "workspace")?;
        let (pairs, count) = (given(pairs, "pairs")?, given(count, "count")?);
        pairs.write(workspace.pairs().as_ptr().cast());
        count.write(workspace.pairs().len());
        Ok(())
    }

    /// Forgets the found pairs, so that a query that stopped with PAIRS_FULL can be resumed. Copy
    /// them first.
    change punctual_workspace_drain_pairs(workspace: punctual_workspace) =
        drop(workspace.drain_pairs());
}

types! {
    /// What the steps of a query cost, in nanoseconds.
    told punctual_cost_model(setup) from (costs: CostModel) {
        /// One BV test.
        bv_test: f64 = costs.bv_test,
        /// One triangle pair.
        triangle_test: f64 = costs.triangle_test,
        /// One node pair that is opened.
        box_update: f64 = costs.box_update,
        /// One query.
        setup: f64 = costs.setup,
    }
}

impl Default for punctual_cost_model {
    fn default() -> Self {
        CostModel::default().into()
    }
}

calls! {
    /// The costs by which queries in this workspace go now.
    unsafe fn punctual_workspace_cost_model(
        workspace: Option<&punctual_workspace>, costs: *mut punctual_cost_model
    ) {
        let workspace = get(workspace, "workspace")?;
        // SAFETY: the contract of the header for structs.
        unsafe { place(costs, "costs") }?.write(workspace.cost_model().into());
        Ok(())
    }

    /// Lets queries in this workspace begin with these costs; they change with each query under a
    /// time budget.
    ///
    /// Fails with BAD_ARGUMENT if one is not finite.
    unsafe fn punctual_workspace_set_cost_model(
        workspace: Option<&mut punctual_workspace>, costs: *const punctual_cost_model
    ) {
        // SAFETY: the contract of the header for structs.
        let costs = unsafe { read(costs, "costs") }?;
        let costs = [costs.bv_test, costs.triangle_test, costs.box_update, costs.setup];
        if let Some(&bad) = costs.iter().find(|cost| !cost.is_finite()) {
            return Err(Fault::Number("a cost", bad));
        }
        change(workspace, "workspace", |workspace| {
            workspace.set_cost_model(CostModel::new(costs));
            Ok(())
        })
    }
}
