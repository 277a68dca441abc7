//! The buffers of a query.

use crate::arrays::find_room;
use crate::handle::{Handle, get, put, set};
use crate::rays::Rays;
use crate::sized::{grows, place, read};
use crate::status::{Fault, free, given};
use crate::verbs::calls;
use core::mem::MaybeUninit;
use punctual::Workspace;
use punctual::prediction::CostModel;

/// Every buffer that a query needs, and what the last query found and left open. Allocated once:
/// queries do not allocate. One thread at a time may use it.
#[derive(Debug)]
pub struct punctual_workspace(pub(crate) Handle<Workspace>, pub(crate) Rays);

/// Two triangles that intersect: ids of the input meshes, from 0.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct punctual_triangle_pair {
    /// Triangle of A.
    pub a: u32,
    /// Triangle of B.
    pub b: u32,
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
    fn punctual_workspace_new(
        workspace: Option<&mut MaybeUninit<Option<Box<punctual_workspace>>>>
    ) {
        put(workspace, || Ok(punctual_workspace(Handle::new(Workspace::new()), Rays::default())))
    }

    /// Makes a workspace with room for `queue` node pairs (a full queue costs order, no answer) and
    /// `pairs` found pairs, at least 1 (when they are full, the query stops with PAIRS_FULL, to be
    /// drained and resumed): `20 queue + 8 pairs` bytes and about 320 kB.
    ///
    /// Fails with OUT_OF_MEMORY if there is not that much.
    fn punctual_workspace_with_capacity(
        queue: usize, pairs: usize,
        workspace: Option<&mut MaybeUninit<Option<Box<punctual_workspace>>>>
    ) {
        put(workspace, || {
            find_room([(queue, 20), (pairs, 8), (1, 1 << 19)])?;
            Ok(punctual_workspace(
                Handle::new(Workspace::with_capacity(queue, pairs)),
                Rays::default(),
            ))
        })
    }
}

/// Frees a workspace; null is fine.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_workspace_free(workspace: Option<Box<punctual_workspace>>) {
    free(workspace);
}

calls! {
    /// Uses the portable kernels from now on, whatever the machine offers: slower, the same bits.
    fn punctual_workspace_use_portable_kernels(workspace: Option<&mut punctual_workspace>) {
        set(workspace, "workspace", |workspace| workspace.use_portable_kernels())
    }

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
    fn punctual_workspace_drain_pairs(workspace: Option<&mut punctual_workspace>) {
        set(workspace, "workspace", |workspace| drop(workspace.drain_pairs()))
    }
}

/// What the steps of a query cost, in nanoseconds.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct punctual_cost_model {
    /// Its size in bytes, to be set before the call.
    pub size: u32,
    /// One BV test.
    pub bv_test: f64,
    /// One triangle pair.
    pub triangle_test: f64,
    /// One node pair that is opened.
    pub box_update: f64,
    /// One query.
    pub setup: f64,
}

grows!(punctual_cost_model: size, setup..setup);

impl From<CostModel> for punctual_cost_model {
    fn from(
        CostModel {
            bv_test,
            triangle_test,
            box_update,
            setup,
            ..
        }: CostModel,
    ) -> Self {
        Self {
            size: Self::SIZE,
            bv_test,
            triangle_test,
            box_update,
            setup,
        }
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
        set(workspace, "workspace", |workspace| workspace.set_cost_model(CostModel::new(costs)))
    }
}
