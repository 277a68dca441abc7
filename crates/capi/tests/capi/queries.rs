//! Queries: outcomes, pairs, certificates, estimates and memories.

use std::ffi::c_void;
use std::mem::MaybeUninit;
use std::ptr::null_mut;
use std::time::Duration;

use super::call::*;
use super::common::{MODES, ORDERS};
use punctual::clock::ManualClock;
use punctual::intersection::{Intersection, Order};
use punctual::prediction::CostModel;
use punctual::{
    Budget, Mode, PairMemory, Query, Stats, StopReason, Tree, Verdict, Workspace, shapes,
};
use punctual_capi::{punctual_status as Status, *};

fn same(ours: &punctual_outcome, theirs: &punctual::Answer<punctual::Verdict>) {
    let (verdict, witness) = told(theirs.value);
    assert_eq!(
        (ours.verdict, [ours.witness.a, ours.witness.b], ours.found),
        (verdict, witness, theirs.stats.found)
    );
    // The names are the same on both sides.
    assert_eq!(format!("{:?}", ours.stop), format!("{:?}", theirs.stop));
    same_stats(&ours.stats, &theirs.stats);
}

pub fn same_stats(x: &punctual_stats, y: &Stats) {
    assert_eq!(
        [x.bv_tests, x.primitive_tests, x.exact_tests],
        [y.bv_tests, y.primitive_tests, y.exact_tests]
    );
    assert_eq!((x.work, x.queue_peak), (y.work, y.queue_peak));
    assert_eq!(
        x.elapsed,
        y.elapsed.map_or(-1, |time| time.as_nanos() as i64)
    );
}

/// A verdict and its witness as C is told them.
pub fn told(verdict: Verdict) -> (punctual_verdict, [u32; 2]) {
    match verdict {
        Verdict::Undecided => (punctual_verdict::Undecided, [0; 2]),
        Verdict::Separated => (punctual_verdict::Separated, [0; 2]),
        Verdict::Intersecting { witness } => (punctual_verdict::Intersecting, witness),
        Verdict::Within { witness, .. } => (punctual_verdict::Within, witness),
        Verdict::Contained { inner } => {
            let inner = u32::from(inner == punctual::intersection::Operand::B);
            (punctual_verdict::Contained, [inner, 0])
        }
    }
}

/// The number that stands for each order in C.
fn number(order: Order) -> u32 {
    match order {
        Order::Penetration => 0,
        Order::LowAlpha => 1,
        Order::DepthFirst => 2,
        _ => unreachable!(),
    }
}

unsafe extern "C" fn tick(context: *mut c_void) -> u64 {
    // SAFETY: the context is a number that nobody else uses.
    let now = unsafe { &mut *context.cast::<u64>() };
    *now += 700;
    *now
}

/// A query in C and the same in Rust.
struct Both<'t> {
    query: punctual_query<'t>,
    workspace: &'t mut punctual_workspace,
    memory: Box<punctual_memory>,
    native: Query<'t, Intersection>,
    other: &'t mut Workspace,
    remembered: PairMemory,
}

impl<'t> Both<'t> {
    fn new(
        (ours, workspace): (&'t punctual_tree, &'t mut punctual_workspace),
        (theirs, other): (&'t Tree, &'t mut Workspace),
        mode: Mode,
        order: Order,
    ) -> Self {
        let mut query = punctual_query_new(Some(ours), Some(ours), raw(&tilted()));
        (query.mode, query.order) = (u32::from(mode == Mode::All), number(order));
        (query.pair_limit, query.prior) = (30, 0.2);
        let native = Query::intersection(theirs, theirs, tilted())
            .mode(mode)
            .order(order);
        let native = native.pair_limit(30).prior(0.2);

        let (memory, remembered) = (owned(|out| punctual_memory_new(out)), PairMemory::new());
        let [bv_test, triangle_test, box_update, setup] = [0.5, 8.0, 30.0, 200.0];
        let costs = punctual_cost_model {
            bv_test,
            triangle_test,
            box_update,
            setup,
            ..Default::default()
        };
        works(unsafe { punctual_workspace_set_cost_model(Some(workspace), asked(&costs)) });
        // SAFETY: of the size that it says.
        assert_eq!(
            made(|out| unsafe { punctual_workspace_cost_model(Some(workspace), slot(out)) }),
            costs
        );
        other.set_cost_model(CostModel::new([bv_test, triangle_test, box_update, setup]));
        Self {
            query,
            workspace,
            memory,
            native,
            other,
            remembered,
        }
    }

    /// Runs, and resumes to the end.
    fn run(&mut self, budget: punctual_budget, native_budget: Budget) {
        let (budget, native_budget) = (
            punctual_budget {
                poll_interval: 1000,
                ..budget
            },
            native_budget.poll_interval(1000),
        );
        let mut time = 0u64;
        let clock = punctual_clock {
            now: Some(tick),
            context: (&raw mut time).cast(),
        };
        let native_clock = || ManualClock::ticking(Duration::from_nanos(700));
        let mut outcome = made(|outcome| {
            let (workspace, memory) = (Some(&mut *self.workspace), Some(&mut *self.memory));
            // SAFETY: the time is there as long as the clock.
            unsafe {
                punctual_query_run(
                    asked(Some(&self.query)),
                    workspace,
                    memory,
                    budget,
                    Some(&clock),
                    slot(outcome),
                )
            }
        });
        let remembered = Some(&mut self.remembered);
        let mut expected = self
            .native
            .with_memory(remembered)
            .run(self.other, native_budget.clock(&native_clock()));
        loop {
            same(&outcome, &expected);
            self.same_pairs();
            self.same_certificate();
            self.same_forecasts();
            if matches!(expected.stop, StopReason::Finished | StopReason::FirstHit) {
                break;
            }
            works(punctual_workspace_drain_pairs(Some(&mut *self.workspace)));
            drop(self.other.drain_pairs());
            outcome = made(|outcome| {
                let (workspace, memory) = (Some(&mut *self.workspace), Some(&mut *self.memory));
                // SAFETY: as above.
                unsafe {
                    punctual_query_resume(
                        asked(Some(&self.query)),
                        workspace,
                        memory,
                        budget,
                        Some(&clock),
                        slot(outcome),
                    )
                }
            });
            let remembered = Some(&mut self.remembered);
            expected = self
                .native
                .with_memory(remembered)
                .resume(self.other, native_budget.clock(&native_clock()))
                .unwrap();
        }
    }

    fn same_pairs(&self) {
        let (mut pairs, mut count) = (MaybeUninit::uninit(), MaybeUninit::uninit());
        let status =
            punctual_workspace_pairs(Some(self.workspace), Some(&mut pairs), Some(&mut count));
        assert_eq!(status, Status::Ok);
        // SAFETY: written, and not used again meanwhile.
        let pairs = unsafe { std::slice::from_raw_parts(pairs.assume_init(), count.assume_init()) };
        assert!(
            pairs
                .iter()
                .map(|pair| [pair.a, pair.b])
                .eq(self.other.pairs().iter().copied())
        );
    }

    fn same_certificate(&self) {
        same_certificate!(
            punctual_query_certificate,
            punctual_query_open_boxes,
            Some(&self.query),
            self.workspace,
            self.native.certificate(self.other).unwrap()
        );
    }

    fn same_forecasts(&self) {
        let (query, memory) = (Some(&self.query), Some(&*self.memory));
        let prediction = made(|out| unsafe { punctual_query_predict(asked(query), memory, out) });
        let estimate = made(|out| unsafe {
            punctual_query_estimate(asked(query), Some(self.workspace), memory, slot(out))
        });
        let expectation = self.native.predict(Some(&self.remembered));
        let left = self
            .native
            .estimate(self.other, Some(&self.remembered))
            .unwrap();
        assert_eq!(
            [estimate.probability, estimate.recall],
            [left.probability, left.recall]
        );
        let costs = [CostModel::default(), self.other.cost_model()];
        let both = [
            (prediction, expectation),
            (estimate.remaining, left.remaining),
        ];
        for ((ours, theirs), costs) in both.into_iter().zip(&costs) {
            assert_eq!(
                [ours.bv_tests.p10, ours.triangle_tests.p50],
                [theirs.bv_tests.p10, theirs.triangle_tests.p50]
            );
            assert_eq!(
                [ours.work.p90, ours.time.p50],
                [theirs.work.p90, theirs.time(costs).p50]
            );
        }
        let facts =
            made(|facts| unsafe { punctual_memory_describe(Some(&self.memory), slot(facts)) });
        assert_eq!(
            facts.last_verdict,
            self.remembered.last_verdict().map_or(-1, i32::from)
        );
        assert_eq!(
            facts.last_bv_tests,
            self.remembered
                .last_bv_tests()
                .map_or(-1, |tests| tests as i64)
        );
        assert_eq!(facts.frames_undecided, self.remembered.frames_undecided());
        assert_eq!(facts.change_rate, self.remembered.change_rate());
    }
}

/// Every mode, order, budget and option, stopped and resumed: the outcome, the pairs, the certificate and the memory are those
/// of Rust.
#[test]
fn queries_answer_as_in_rust() {
    let (ours, theirs) = knots();
    let mut workspace = owned(|workspace| punctual_workspace_with_capacity(32, 40, workspace));
    let mut other = Workspace::with_capacity(32, 40);
    for (mode, order) in MODES
        .into_iter()
        .flat_map(|mode| ORDERS.map(|order| (mode, order)))
    {
        let mut both = Both::new((&ours, &mut workspace), (&theirs, &mut other), mode, order);
        for (budget, native_budget) in [
            (punctual_budget_work(3_000), Budget::work(3_000)),
            (
                punctual_budget_time(5_000),
                Budget::time(Duration::from_nanos(5_000)),
            ),
            (punctual_budget_unlimited(), Budget::unlimited()),
        ] {
            both.run(budget, native_budget);
            let (workspace, out) = (Some(&mut *both.workspace), Some(&mut MaybeUninit::uninit()));
            // SAFETY: no clock of the caller's.
            refuses! {
                punctual_query_resume(asked(Some(&both.query)), workspace, None, budget, None, slot(out))
                    => NotResumable "punctual_query_resume: the workspace does not hold a run of this query (same trees, pose and options)";
            }
        }
    }
}

/// Stopped and resumed in a workspace that is soon full: outcomes, pairs, certificates and what
/// remains are those of Rust.
#[test]
fn self_queries_answer_as_in_rust() {
    let mesh = owned(|mesh| punctual_shape_torus_knot(2, 3, 0.7, 96, mesh));
    let theirs = Tree::new(shapes::torus_knot(2, 3, 0.7, 96));
    let ours = tree_of(&mesh);
    let mut workspace = owned(|workspace| punctual_workspace_with_capacity(32, 400, workspace));
    let mut other = Workspace::with_capacity(32, 400);
    let (mut query, native) = (
        punctual_self_query_new(Some(&ours)),
        Query::self_intersections(&theirs),
    );
    query.pair_limit = 5;
    let native = native.pair_limit(5);
    let ask = (
        asked(Some(&query)),
        punctual_budget_work(50_000),
        Budget::work(50_000),
    );
    let mut outcome = made(|out| {
        // SAFETY: no clock of the caller's.
        unsafe { punctual_self_query_run(ask.0, Some(&mut workspace), ask.1, None, slot(out)) }
    });
    let mut expected = native.run(&mut other, ask.2);
    let mut full = 0;
    loop {
        same(&outcome, &expected);
        // SAFETY: of the sizes that they say.
        let (open, left): (punctual_certificate, punctual_remaining) = unsafe {
            (
                made(|out| punctual_self_query_certificate(ask.0, Some(&workspace), slot(out))),
                made(|out| punctual_self_query_remaining(ask.0, Some(&workspace), slot(out))),
            )
        };
        let certificate = native.certificate(&other).unwrap();
        assert_eq!(open.upper_bound, certificate.upper_bound());
        assert_eq!(
            left.work.p50,
            native.remaining(&other, None).unwrap().work.p50
        );
        // SAFETY: no box is asked for.
        let boxes = made(|count| unsafe {
            punctual_self_query_open_boxes(ask.0, Some(&workspace), null_mut(), 0, count)
        });
        assert_eq!(boxes, certificate.boxes().count());
        if expected.stop == StopReason::Finished {
            break;
        }
        full += usize::from(expected.stop == StopReason::PairsFull);
        works(punctual_workspace_drain_pairs(Some(&mut workspace)));
        drop(other.drain_pairs());
        outcome = made(|out| {
            // SAFETY: as above.
            unsafe {
                punctual_self_query_resume(ask.0, Some(&mut workspace), ask.1, None, slot(out))
            }
        });
        expected = native.resume(&mut other, ask.2).unwrap();
    }
    assert!(full > 2 && expected.stats.found > 100, "{full}");
    let (no_tree, bad) = (
        punctual_self_query_new(None),
        punctual_self_query { mode: 9, ..query },
    );
    let (workspace, out) = (&mut *workspace, &mut MaybeUninit::uninit());
    refuses! {
        punctual_self_query_run(asked(&no_tree), Some(workspace), ask.1, None, slot(Some(out)))
            => null "query->tree";
        punctual_self_query_run(asked(None), Some(workspace), ask.1, None, slot(Some(out)))
            => null "query";
        punctual_self_query_resume(ask.0, None, ask.1, None, slot(Some(out))) => null "workspace";
        punctual_self_query_run(asked(&bad), Some(workspace), ask.1, None, slot(Some(out)))
            => BadArgument "punctual_self_query_run: query->mode has no value 9";
    }
}

#[test]
fn the_portable_kernels_give_the_same_bits() {
    let tree = tree_of(&knot());
    let mut query = punctual_query_new(Some(&tree), Some(&tree), raw(&tilted()));
    query.mode = punctual_mode::All as u32;
    let mut workspace = owned(|out| punctual_workspace_new(out));
    let answer = |workspace: &mut punctual_workspace| {
        made(|outcome| {
            run(
                &query,
                Some(workspace),
                punctual_budget_unlimited(),
                outcome,
            )
        })
    };
    let fast = answer(&mut workspace);
    works(punctual_workspace_use_portable_kernels(Some(
        &mut workspace,
    )));
    assert_eq!(answer(&mut workspace), fast);
}
