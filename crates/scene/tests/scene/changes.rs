//! Everything about a scene changes while its frames are cut: all that it says against every pair of bodies.

use std::collections::BTreeMap;
use std::time::Duration;

use crate::common::check::{ENOUGH, run_to_end};
use crate::distances::{ROUNDING, distance};
use crate::world::{Group, TOLERANCE, World};
use crate::{Model, assert_certificates, assert_sound, assert_witness, contacts, rays};
use punctual::clock::ManualClock;
use punctual::glam::DVec3;
use punctual::{Budget, Mode, Motion, Query, Verdict};
use punctual_scene::{Body, BodyId, Report, SceneError};

impl World {
    /// A frame, and all that it says.
    fn check(&mut self) -> bool {
        self.check_before();
        let (budget, most) = self.budget();
        let clock = ManualClock::ticking(Duration::from_nanos(1 << self.random.below(11)));
        let report = match self.threads {
            1 => self.scene.detect(budget.clock(&clock)),
            _ => self.scene.detect(budget),
        }
        .clone();
        let is_unlimited = budget == Budget::unlimited();
        assert!(
            report.work <= most && report.broad_phase_work <= most.saturating_add(65_536),
            "{most}: {} {} frame {} mode {:?}",
            report.work,
            report.broad_phase_work,
            report.frame,
            self.mode
        );
        assert_eq!(report.elapsed.is_some(), most == u64::MAX && !is_unlimited);
        assert!(report.is_whole() || !(is_unlimited && self.has_room));
        assert!(!report.is_full || report.unpaired > 0);
        let complete = is_unlimited && report.is_whole();
        let truth = self.compare(&report);
        self.check_pairs(&report);
        assert_sound(&report, &truth, complete);
        self.ledger.check(&report, &self.model(), &truth, complete);
        assert_certificates(&self.scene, &truth);
        self.check_distances(&report, is_unlimited);
        self.check_groups(&report, complete);
        self.check_passages(&report, complete);
        self.check_contacts(true);
        for id in self.born.keys().filter(|&&id| self.scene.body(id).is_err()) {
            assert_eq!(
                self.scene.partners_known(*id),
                Err(SceneError::NoSuchBody { body: *id })
            );
        }
        complete
    }

    fn model(&self) -> Model {
        let bodies = self
            .scene
            .bodies()
            .map(|(id, body)| (id, body.clone()))
            .collect();
        Model {
            bodies,
            removed: Vec::new(),
        }
    }

    /// What is said of the bodies where they are, before there is a frame of it.
    fn check_before(&mut self) {
        self.check_contacts(false);
        let truth = self.model().truth(&mut self.workspace);
        for pair @ [a, b] in self.pairs() {
            let found = truth
                .iter()
                .find(|&&(x, y, _)| (x, y) == (a.index(), b.index()))
                .map_or(0, |found| found.2);
            assert!(
                self.scene.certificate(a, b).unwrap().upper_bound >= found,
                "{pair:?} {found}"
            );
            let report = self.scene.report();
            let is_known = pair
                .iter()
                .all(|&id| self.scene.partners_known(id).unwrap())
                && report.unlisted == 0;
            let is_passed_by = is_known && self.may_meet(pair) && report.pair(a, b).is_none();
            assert!(found == 0 || !is_passed_by, "{pair:?} is missing");
        }
        if self.random.below(4) == 0 {
            let model = self.model();
            rays::check(
                &mut self.scene,
                &model,
                &mut self.random,
                &mut self.workspace,
            );
        }
    }

    /// Every pair of bodies with what is said of it: those that meet, and in how many pairs of triangles.
    fn compare(&mut self, report: &Report) -> Vec<(usize, usize, u64)> {
        let mut truth = Vec::new();
        let mut gaps = BTreeMap::new();
        for pair @ [a, b] in self.pairs() {
            let [x, y] = pair.map(|id| self.scene.body(id).unwrap());
            let b_in_a = x.pose.inverse().unwrap().compose(&y.pose).unwrap();
            let query = Query::all_pairs(&x.tree, &y.tree, b_in_a);
            let (_, found) = run_to_end(&query, &mut self.workspace, ENOUGH);
            assert!(self.scene.certificate(a, b).unwrap().upper_bound >= found.len() as u64);
            let margins = x.margin + y.margin;
            let gap = distance(&self.scene, a, b, &mut self.workspace) - margins;
            gaps.insert(pair, gap.max(0.0));
            let meets = !found.is_empty() || margins > 0.0 && gap <= 0.0;
            let told = report.pair(a, b);
            assert!(told.is_none() || self.may_meet(pair), "{told:?}");
            if meets && self.may_meet(pair) && (self.is_compared(pair) || told.is_some()) {
                truth.push((a.index(), b.index(), found.len().max(1) as u64));
                let is_known = pair
                    .into_iter()
                    .all(|id| self.scene.partners_known(id).unwrap());
                assert!(
                    told.is_some() || !is_known || report.unlisted > 0,
                    "{pair:?} is missing"
                );
            }
            let Some(told) = told else { continue };
            let is_plain = margins == 0.0
                && !self.is_measured(pair)
                && !pair.iter().any(|id| self.motions.contains_key(id));
            if self.mode == Mode::All && told.complete && is_plain {
                assert_eq!(told.found, found.len() as u64, "{told:?}");
            }
            let is_moving = pair.iter().any(|id| self.motions.contains_key(id));
            if let (Verdict::Intersecting { witness }, false) = (told.verdict, is_moving) {
                assert!(found.contains(&witness), "{told:?}");
            }
            assert_witness(&self.scene, told);
        }
        self.gaps.push(gaps);
        truth
    }

    fn check_pairs(&self, report: &Report) {
        // A pair twice.
        assert!(report.pairs.is_sorted_by(|x, y| (x.a, x.b) < (y.a, y.b)));
        assert_eq!(
            report.complete,
            report.pairs.iter().filter(|pair| pair.complete).count()
        );
        for pair in &report.pairs {
            assert!(
                pair.a.index() < pair.b.index()
                    && [pair.a, pair.b]
                        .iter()
                        .all(|&id| self.scene.body(id).is_ok())
            );
            let certain = pair.verdict != Verdict::Undecided;
            assert!(
                (0.0..=1.0).contains(&pair.probability) && (0.0..=1.0).contains(&pair.recall),
                "{pair:?}"
            );
            assert!(
                !certain
                    || pair.probability == f64::from(u8::from(pair.verdict != Verdict::Separated)),
                "{pair:?}"
            );
            assert_eq!(
                (pair.recall == 1.0, pair.recall == 0.0),
                (pair.complete, !pair.complete && pair.found == 0),
                "{pair:?}"
            );
            assert!(!pair.complete || certain && pair.recall == 1.0, "{pair:?}");
            // Never decided, it counts from the frame before its boxes met.
            let born = self.born[&pair.a].max(self.born[&pair.b]);
            assert!(pair.age <= report.frame + 1 - born, "{pair:?} {born}");
        }
    }

    fn check_distances(&self, report: &Report, is_unlimited: bool) {
        assert!(
            self.scene
                .distances()
                .map(|found| [found.a, found.b])
                .eq(self.measured.iter().copied())
        );
        for found in self.scene.distances() {
            let pair = [found.a, found.b];
            match self.gaps[(report.frame - found.age) as usize].get(&pair) {
                Some(&gap) => assert!(
                    found.low <= gap + ROUNDING && gap <= found.high + ROUNDING,
                    "{found:?} {gap}"
                ),
                None => assert!(
                    found.low == 0.0 && found.high == f64::INFINITY,
                    "{found:?} is of other bodies"
                ),
            }
            let is_known = found.age == 0
                && (found.high - found.low <= 1.001 * TOLERANCE || found.low == found.high);
            assert!(
                !is_unlimited || is_known || !self.may_meet(pair),
                "{found:?} {:?}",
                report.pair(found.a, found.b)
            );
        }
    }

    fn check_groups(&self, report: &Report, complete: bool) {
        let gaps = &self.gaps[report.frame as usize];
        assert_eq!(report.group_distances.len(), self.groups.len());
        for Group { id, bodies: [x, y] } in &self.groups {
            let found = report
                .group_distances
                .iter()
                .find(|found| found.id == *id)
                .unwrap();
            let pairs = x
                .iter()
                .flat_map(|&a| y.iter().map(move |&b| [a.min(b), a.max(b)]));
            let least = pairs
                .filter(|pair| gaps.contains_key(pair) && self.may_meet(*pair))
                .map(|pair| gaps[&pair]);
            let least = least.fold(f64::INFINITY, f64::min);
            assert!(
                found.low <= least + ROUNDING && least <= found.high + ROUNDING,
                "{found:?} {least}"
            );
            assert!(
                found
                    .bodies
                    .is_none_or(|pair| gaps[&pair] <= found.high + ROUNDING),
                "{found:?}"
            );
            let is_known = found.low == found.high || found.high - found.low <= 1.001 * TOLERANCE;
            assert!(!complete || found.open == 0, "{found:?}");
            assert!(found.open > 0 || is_known, "{found:?}");
        }
    }

    fn check_passages(&mut self, report: &Report, complete: bool) {
        for pair @ [a, b] in self.pairs() {
            let moves = pair.iter().any(|id| self.motions.contains_key(id));
            let told = self
                .scene
                .passages()
                .find(|found| [found.a, found.b] == pair);
            assert_eq!(told.is_some(), moves && report.pair(a, b).is_some());
            if !moves || !self.may_meet(pair) || !self.is_compared(pair) {
                continue;
            }
            let [x, y] = pair.map(|id| self.scene.body(id).unwrap());
            let motion = |id: BodyId, body: &Body| {
                self.motions
                    .get(&id)
                    .copied()
                    .unwrap_or_else(|| Motion::straight(body.pose, [0.0; 3]).unwrap())
            };
            let query = Query::impact_of_both([&x.tree, &y.tree], [motion(a, x), motion(b, y)]);
            let query = query.margins([x.margin, y.margin]);
            let truth = query.run(
                &mut self.workspace,
                Budget::unlimited().clock(&ManualClock::new()),
            );
            let Some(told) = told else {
                assert!(
                    truth.value.upper.is_none() || !report.is_whole(),
                    "{pair:?} is missing: {truth:?}"
                );
                continue;
            };
            assert!(
                told.free_until <= truth.value.upper.unwrap_or(1.0),
                "{told:?} {truth:?}"
            );
            assert!(
                told.touching_at
                    .is_none_or(|time| time >= truth.value.lower),
                "{told:?} {truth:?}"
            );
            assert!(
                !complete || told.touching_at.is_some() == truth.value.upper.is_some(),
                "{told:?} {truth:?}"
            );
        }
    }

    /// Where bodies touch is of these bodies, and true if it is of `now`, before anything has changed.
    fn check_contacts(&mut self, now: bool) {
        let frame = self.scene.report().frame;
        for pair @ [a, b] in self.pairs() {
            let found = self.scene.contacts(a, b).unwrap();
            let since = frame - found.age;
            let is_told = !found.points.is_empty() || found.is_whole;
            assert!(
                !is_told || pair.iter().all(|id| self.born[id] <= since),
                "{pair:?} {found:?} is of other bodies"
            );
            if is_told && found.drift == 0.0 && now {
                contacts::assert_told(&self.scene, pair, &mut self.workspace);
            }
        }
    }
}

#[test]
fn what_is_said_holds_whatever_changes_while_frames_are_cut() {
    for (seed, origin, threads) in [
        (0, 0.0, 1),
        (1, 0.0, 1),
        (2, 0.0, 1),
        (3, 0.0, 1),
        (4, 1e5, 1),
        (5, 0.0, 2),
        (6, 0.0, 3),
    ] {
        let mut world = World::new(seed, DVec3::splat(origin));
        #[cfg(feature = "parallel")]
        world.scene.use_threads(threads).unwrap();
        world.threads = threads;
        if seed % 2 == 1 {
            world.scene.find_contacts();
        }
        let mut complete = 0;
        for _ in 0..200 {
            for _ in 0..world.random.below(8) {
                world.change();
            }
            complete += usize::from(world.check());
        }
        assert!(
            complete > 5 && world.ledger.told.iter().all(|&told| told > 10),
            "{complete}, {:?}",
            world.ledger.told
        );
    }
}
