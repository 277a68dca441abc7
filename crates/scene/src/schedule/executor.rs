//! Runs the batches of a frame: on the calling thread alone, or on several.

use crate::body::Bodies;
use crate::pair::batch::{Batch, Round};
use alloc::boxed::Box;
use alloc::sync::Arc;
use punctual::{Clock, Workspace};

pub(crate) trait Executor {
    /// Number of threads, including the calling one.
    fn threads(&self) -> usize;

    /// Announces batches, so that no thread sleeps when they come.
    fn call(&self);

    /// Gives the batches that are not empty to free threads. The first of them has the number
    /// `first`. They are back after [`Executor::finish`].
    fn begin(&self, first: usize, batches: &mut [Batch], round: &Round, bodies: &Arc<Bodies>);

    /// Runs all started batches that no thread has taken, and waits for the others. Passes each to
    /// `back` when it has ended. `scratch` is a workspace of the calling thread.
    fn finish(
        &self,
        batches: &mut [Batch],
        round: &Round,
        bodies: &Arc<Bodies>,
        scratch: &mut Box<Workspace>,
        back: &mut dyn FnMut(&mut Batch),
    );

    /// Runs all batches.
    fn run(
        &self,
        batches: &mut [Batch],
        round: &Round,
        bodies: &Arc<Bodies>,
        scratch: &mut Box<Workspace>,
    ) {
        self.begin(0, batches, round, bodies);
        self.finish(batches, round, bodies, scratch, &mut |_| ());
    }
}

/// The calling thread alone.
pub(crate) struct Alone<'c>(pub &'c dyn Clock);

impl Executor for Alone<'_> {
    fn threads(&self) -> usize {
        1
    }

    fn call(&self) {}

    fn begin(&self, _: usize, _: &mut [Batch], _: &Round, _: &Arc<Bodies>) {}

    fn finish(
        &self,
        batches: &mut [Batch],
        round: &Round,
        bodies: &Arc<Bodies>,
        scratch: &mut Box<Workspace>,
        back: &mut dyn FnMut(&mut Batch),
    ) {
        for batch in batches.iter_mut().filter(|batch| !batch.is_empty()) {
            batch.run(bodies, scratch, round, self.0);
            back(batch);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Body, Scene};
    use core::cell::RefCell;
    use glam::{DMat3, DVec3};
    use punctual::Budget;
    use punctual::Tree;
    use punctual::clock::ManualClock;
    use punctual_geom::Pose;

    /// Acts as two threads, and records the number of turns of each batch it receives.
    struct Two<'c>(Alone<'c>, RefCell<Vec<usize>>);

    impl Executor for Two<'_> {
        fn threads(&self) -> usize {
            2
        }

        fn call(&self) {}

        fn begin(&self, _: usize, batches: &mut [Batch], _: &Round, _: &Arc<Bodies>) {
            self.1.borrow_mut().extend(
                batches
                    .iter()
                    .map(|batch| batch.turns.len())
                    .filter(|&turns| turns > 0),
            );
        }

        fn finish(
            &self,
            batches: &mut [Batch],
            round: &Round,
            bodies: &Arc<Bodies>,
            scratch: &mut Box<Workspace>,
            back: &mut dyn FnMut(&mut Batch),
        ) {
            self.0.finish(batches, round, bodies, scratch, back);
        }
    }

    #[test]
    fn threads_share_the_first_frame() {
        let tree = Arc::new(Tree::new(punctual::shapes::icosphere(1)));
        let (mut scene, clock) = (Scene::new(), ManualClock::new());
        for place in 0..20 {
            let pose = Pose::new(
                DMat3::IDENTITY,
                DVec3::new(0.1 * f64::from(place), 0.0, 0.0),
            )
            .unwrap();
            scene.insert(Body::moving(tree.clone(), pose)).unwrap();
        }
        let executor = Two(Alone(&clock), RefCell::default());
        scene.frame(Budget::unlimited(), &clock, &executor);
        assert!(scene.report().is_final());
        let assigned = executor.1.into_inner();
        let (most, all) = (
            assigned.iter().max().unwrap(),
            assigned.iter().sum::<usize>(),
        );
        assert!(all > 100 && 4 * most < all, "{assigned:?}");
    }
}
