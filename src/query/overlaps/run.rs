//! Runs the steps of the overlaps within a deadline.

use super::{ACROSS, Overlaps, Phase, REGION_LIMIT, STEP, Stage, is_closed};
use crate::contact::manifold::{Before, Shape};
use crate::model::cost::{
    WORK_PER_CURVE_PAIR, WORK_PER_LOOKUP, WORK_PER_RAY, WORK_PER_RAY_TEST, WORK_PER_REGION_TRIANGLE,
};
use crate::query::deadline::Deadline;
use crate::query::outcome::StopReason;
use crate::query::ray::cast_alone;
use crate::query::ray::state::RayHit;
use crate::query::workspace::Workspace;
use crate::tree::Tree;
use crate::tree::inside::inside;
use core::mem;
use glam::DVec3;
use punctual_geom::triangle::ray::Side;
use punctual_geom::{Pose, Ray};

/// Continues with the overlaps until they are done or the deadline stops.
pub(in crate::query) fn advance(
    shape: Shape,
    before: Before,
    to_b: &Pose,
    workspace: &mut Workspace,
    deadline: &mut Deadline,
) -> StopReason {
    let mut state = mem::take(&mut workspace.overlaps);
    let stop = loop {
        if state.phase == Phase::Done {
            break StopReason::Finished;
        }
        if !state.is_casting {
            deadline.begin(workspace.run.stats.work);
            let stop = deadline.stop(workspace.run.stats.work);
            if let Some(reason) = stop {
                break reason;
            }
        }
        let result = state.step(shape, before, to_b, workspace, deadline);
        deadline.end(workspace.run.stats.work);
        if let Err(reason) = result {
            break reason;
        }
    };
    workspace.overlaps = state;
    stop
}

impl Overlaps {
    /// One step of bounded work.
    fn step(
        &mut self,
        shape: Shape,
        before: Before,
        to_b: &Pose,
        workspace: &mut Workspace,
        deadline: &mut Deadline,
    ) -> Result<(), StopReason> {
        let (trees, count) = (shape.trees, self.cuts.len());
        let work = &mut workspace.run.stats.work;
        let until = |at: usize, end: usize| (at + STEP).min(end);
        match self.phase {
            Phase::Link(0) if self.cuts.is_empty() => self.phase = Phase::Done,
            Phase::Link(at) => {
                if at == 0 {
                    self.begin(trees);
                    *work += count as u64;
                }
                let end = until(at, count);
                (at..end).for_each(|at| self.link(trees, at));
                *work += (end - at) as u64 * WORK_PER_CURVE_PAIR;
                self.phase = if end == count {
                    Phase::Classify(0)
                } else {
                    Phase::Link(end)
                };
            }
            Phase::Classify(at) => {
                let end = until(at, count);
                (at..end).for_each(|at| self.classify(trees, at));
                *work += (end - at) as u64 * WORK_PER_CURVE_PAIR;
                self.phase = if end == count {
                    Phase::Test(0)
                } else {
                    Phase::Classify(end)
                };
            }
            Phase::Test(at) => {
                let Some(class) = self.classes.get(at).copied() else {
                    self.phase = Phase::Seed(0);
                    return Ok(());
                };
                if class.parent == at as u32 {
                    let side = usize::from(class.side);
                    let place = trees[side].mesh().vertices().get(class.vertex as usize);
                    let place = if side == 0 {
                        to_b.transform_point(place)
                    } else {
                        shape.b_in_a.transform_point(place)
                    };
                    let other = trees[1 - side];
                    self.classes[at].is_inside = if is_closed(other) {
                        *work += WORK_PER_RAY + 2 * WORK_PER_RAY_TEST;
                        deadline.allow_for_long_step();
                        inside(other, place).is_inside()
                    } else {
                        let hit = self.cast(other, place, ACROSS, workspace, deadline)?;
                        hit.is_some_and(|hit| hit.side == Side::Back)
                    };
                } else {
                    *work += WORK_PER_LOOKUP;
                }
                self.phase = Phase::Test(at + 1);
            }
            Phase::Seed(at) => {
                let end = until(at, count);
                (at..end).for_each(|at| self.seed(trees, at));
                *work += (end - at) as u64 * WORK_PER_CURVE_PAIR;
                self.phase = if end == count {
                    Phase::Flood(0)
                } else {
                    Phase::Seed(end)
                };
            }
            Phase::Flood(at) => {
                let end = until(at, self.region.len());
                (at..end).for_each(|at| self.flood(trees, at));
                *work += (end - at) as u64 * WORK_PER_REGION_TRIANGLE;
                self.phase = if end == self.region.len() {
                    Phase::Measure(0)
                } else {
                    Phase::Flood(end)
                };
            }
            Phase::Measure(at) => {
                let all = 2 * count + self.groups.len();
                let end = until(at, all.max(2 * count));
                for at in at..end {
                    if at < count {
                        self.gather(at);
                    } else if at < 2 * count {
                        let cut = &self.cuts[at - count];
                        self.groups[cut.group as usize].add_area(cut);
                    } else {
                        self.find_normal(shape, at - 2 * count);
                    }
                }
                *work += (end - at) as u64 * WORK_PER_CURVE_PAIR;
                self.phase = if end >= 2 * count + self.groups.len() {
                    Phase::Reduce(0)
                } else {
                    Phase::Measure(end)
                };
            }
            Phase::Reduce(at) => {
                let all = count + self.region.len();
                let end = until(at, all);
                (at..end).for_each(|at| self.reduce(shape, at));
                *work += (end - at) as u64 * WORK_PER_REGION_TRIANGLE;
                self.phase = if end == all {
                    Phase::Probe(0, 0, 0)
                } else {
                    Phase::Reduce(end)
                };
            }
            Phase::Probe(at, probe, ray) => {
                let Some(group) = self.groups.get(at) else {
                    self.phase = Phase::Done;
                    return Ok(());
                };
                if self.probing.stage == Stage::None {
                    self.probing.stage = Stage::Deep;
                    (self.probing.through, self.probing.is_unknown) = (0, false);
                    self.probing.found.clear();
                    self.probing.probes.clear();
                    if group.normal != DVec3::ZERO && !group.is_touching {
                        self.probing.probes = group.deep_probes();
                    }
                }
                let Some(&place) = self.probing.probes.get(probe) else {
                    *work += WORK_PER_CURVE_PAIR;
                    if self.probing.stage == Stage::Deep && probe > 0 {
                        self.probing.stage = Stage::Wide;
                        self.probing.probes = group.wide_probes(&mut self.probing.found, before);
                        self.phase = Phase::Probe(at, 0, 0);
                    } else {
                        let is_whole = self.region.len() < REGION_LIMIT;
                        self.done
                            .push(group.manifold(&mut self.probing, before, is_whole));
                        self.probing.stage = Stage::None;
                        self.phase = Phase::Probe(at + 1, 0, 0);
                    }
                    return Ok(());
                };
                let normal = group.normal;
                let Some((tree, origin, is_forth)) = self.probing.ray(place, normal, ray) else {
                    if let Some(place) = self.probing.take(place, normal) {
                        *work += 2 * WORK_PER_RAY;
                        let is_in_both = trees.into_iter().all(is_closed)
                            && inside(trees[0], place).is_inside()
                            && inside(trees[1], to_b.transform_point(place)).is_inside();
                        self.probing.is_unknown |= is_in_both;
                        self.probing.through += u32::from(!is_in_both);
                    }
                    self.phase = Phase::Probe(at, probe + 1, 0);
                    return Ok(());
                };
                let way = if is_forth { normal } else { -normal };
                let (origin, way) = if tree == 0 {
                    (origin, way)
                } else {
                    (to_b.transform_point(origin), *to_b.rotation() * way)
                };
                self.probing.hits[ray] =
                    self.cast(trees[tree], origin, way, workspace, deadline)?;
                self.phase = Phase::Probe(at, probe, ray + 1);
            }
            Phase::Done => {}
        }
        Ok(())
    }

    /// Casts a ray, or continues with it.
    fn cast(
        &mut self,
        tree: &Tree,
        place: DVec3,
        way: DVec3,
        workspace: &mut Workspace,
        deadline: &mut Deadline,
    ) -> Result<Option<RayHit>, StopReason> {
        let Ok(ray) = Ray::new(place, way) else {
            return Ok(None);
        };
        let found = cast_alone(tree, &ray, self.is_casting, workspace, deadline);
        self.is_casting = found.is_err();
        found
    }
}
