//! One frame, step by step.

use super::body::{Bodies, Placed};
use super::broad::Broad;
use super::broad::bounds;
use super::pair::frame::Frame;
use super::schedule::Found;
use super::schedule::executor::Executor;
use super::schedule::share::{PAIR, PLACE, Share};
use super::{BodyKind, Reach, Scene};
use crate::cost::{WORK_PER_BOX, WORK_PER_SWEPT_BOX};
use alloc::sync::Arc;
use core::hint::black_box;
use core::mem;
use core::time::Duration;
use punctual::engine::Deadline;
use punctual::{Budget, Clock};
use punctual_geom::Aabb;

/// With fewer known pairs than this, other threads are not woken before there is a batch.
const SHARED_PAIRS: usize = 64;

impl Scene {
    /// Runs a frame; `executor` runs its batches.
    pub(super) fn frame(&mut self, budget: Budget, clock: &dyn Clock, executor: &dyn Executor) {
        let started = budget.time_limit().map(|_| clock.now());
        self.report.frame += 1;
        let is_same = mem::replace(&mut self.is_same, true);
        let is_still = is_same
            && self.bodies.are_settled()
            && self.broad.open == 0
            && !self.broad.has_cropped();
        if is_still && self.report.is_final() && self.schedule.open == 0 {
            return self.report_again(started, clock);
        }
        if self.pairs.len() >= SHARED_PAIRS {
            executor.call();
        }
        let times = black_box(
            started
                .zip(budget.time_limit())
                .map_or([Duration::ZERO; 2], |(start, limit)| [start, limit]),
        );
        let (number, mode, asked_since, rest) =
            (self.report.frame, self.mode, self.asked_since, self.rest);
        let (cut, moved) = (!self.report.is_whole(), self.bodies.changed > 0);
        let reach = self.reach;
        let Self {
            pairs,
            broad,
            bodies,
            schedule,
            scratch,
            report,
            events,
            ..
        } = self;
        let frame = Frame {
            number,
            mode,
            asked_since,
            rest,
            cut,
            moved,
            is_still,
            budget,
            times,
            clock,
            bodies,
            executor,
        };
        let left = schedule.revisit(&frame, broad, pairs, scratch);
        let mut share = Share::new(budget, left, schedule.revisit.found.len(), clock);
        share.run(PLACE, |deadline| {
            place_changed(Arc::make_mut(bodies), broad, reach, number, deadline);
        });
        share.run(PAIR, |deadline| {
            pairs.update(broad, bodies, deadline);
            Arc::make_mut(bodies).begin_groups(report.frame, deadline);
        });
        (report.unplaced, report.unpaired, report.is_full) =
            (bodies.changed, broad.open, broad.has_cropped());
        let frame = Frame {
            number,
            mode,
            asked_since,
            rest,
            cut,
            moved,
            is_still,
            budget,
            times,
            clock,
            bodies,
            executor,
        };
        let mut found = Found {
            broad,
            pairs,
            events,
        };
        let ended = schedule.run(&frame, &mut found, &mut share, report, scratch);
        let requests = &mut Arc::make_mut(bodies).distance_requests;
        schedule.reported.hand_on(requests, number);
        report.broad_phase_work = share.spent;
        report.elapsed = ended
            .zip(started)
            .map(|(ended, started)| ended.saturating_sub(started));
        if is_still {
            self.rest = [schedule.began_list, number];
        }
    }

    /// Repeats the report of the last frame, because nothing has changed. Only the ages of contacts
    /// grow.
    fn report_again(&mut self, started: Option<Duration>, clock: &dyn Clock) {
        self.rest = [self.schedule.began_list, self.report.frame];
        let report = &mut self.report;
        (report.work, report.bv_tests, report.broad_phase_work) = (0, 0, 0);
        self.events.report(&self.bodies, &self.broad, report);
        report.elapsed = started.map(|started| clock.now().saturating_sub(started));
    }
}

/// Updates the boxes of bodies that were moved, inserted or removed.
fn place_changed(
    bodies: &mut Bodies,
    broad: &mut Broad,
    reach: Reach,
    frame: u64,
    deadline: &mut Deadline,
) {
    let work = match reach == Reach::Swept || bodies.has_special {
        true => WORK_PER_SWEPT_BOX,
        false => WORK_PER_BOX,
    };
    while deadline.has_room(work)
        && let Some((index, news)) = bodies.take_pending()
    {
        deadline.spend(work);
        let facts = *bodies.facts(index);
        let (mut bounds, mut moving, mut moves) = (Aabb::EMPTY, false, false);
        if let Some(Placed {
            body, last, motion, ..
        }) = bodies.at(index)
        {
            moving = body.kind == BodyKind::Moving;
            moves = reach == Reach::Swept && facts.changed == frame && *last != body.pose;
            bounds = match moves {
                true => bounds::swept(&body.tree, last, &body.pose),
                false => body.tree.aabb_at(&body.pose),
            };
            if let Some(motion) = motion {
                bounds = bounds.union(&bounds::on_way(&body.tree, motion));
            }
            bounds = bounds::thickened(bounds, body.margin);
        }
        broad.place(index, bounds, moving, news, facts.importance);
        bodies.spots[index as usize].bounds = bounds;
        if moves {
            bodies.settling.push(index);
        }
    }
    bodies.end_changes();
}
