//! A scene of bodies of all kinds, and all that may be done to it between two frames.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Duration;

use crate::common::random::Random;
use crate::events::Ledger;
use crate::{nudged, trees};
use punctual::glam::DVec3;
use punctual::{Budget, Mode, Motion, Pose, Tree, Workspace};
use punctual_scene::{
    Body, BodyId, BodyKind, CompoundId, Filter, MeasureId, PairQuestion, Reach, Scene, SceneError,
};

/// Bodies of a frame, the lower index first.
pub type Pair = [BodyId; 2];

pub struct Group {
    pub id: MeasureId,
    pub bodies: [Vec<BodyId>; 2],
}

/// A scene, and what was told to it that it cannot be asked about.
pub struct World {
    pub scene: Scene,
    /// How many play it; several go by the clock of the system.
    pub threads: usize,
    pub random: Random,
    pub workspace: Workspace,
    pub trees: Vec<Arc<Tree>>,
    /// Where all of it is.
    pub origin: DVec3,
    pub mode: Mode,
    /// The first frame of each body, those of removed ones too.
    pub born: BTreeMap<BodyId, u64>,
    pub motions: BTreeMap<BodyId, Motion>,
    pub compounds: Vec<(CompoundId, Vec<(BodyId, Pose)>)>,
    pub measured: BTreeSet<Pair>,
    pub groups: Vec<Group>,
    /// Whether all pairs may be kept.
    pub has_room: bool,
    /// How far all bodies were apart in each frame, margins counted.
    pub gaps: Vec<BTreeMap<Pair, f64>>,
    pub ledger: Ledger,
}

pub const TOLERANCE: f64 = 1e-3;

impl World {
    pub fn new(seed: u64, origin: DVec3) -> Self {
        let mut world = Self {
            scene: Scene::new(),
            threads: 1,
            random: Random::new(seed),
            workspace: Workspace::new(),
            trees: trees(),
            origin,
            mode: Mode::Any,
            born: BTreeMap::new(),
            motions: BTreeMap::new(),
            compounds: Vec::new(),
            measured: BTreeSet::new(),
            groups: Vec::new(),
            has_room: true,
            gaps: vec![BTreeMap::new()],
            ledger: Ledger::default(),
        };
        world.scene.track_contacts();
        world.workspace.reserve_contacts(1 << 15);
        world
    }

    fn ids(&self) -> Vec<BodyId> {
        self.scene.bodies().map(|(id, _)| id).collect()
    }

    pub fn pairs(&self) -> Vec<Pair> {
        let ids = self.ids();
        ids.iter()
            .enumerate()
            .flat_map(|(i, &a)| ids[i + 1..].iter().map(move |&b| [a, b]))
            .collect()
    }

    fn place(&mut self) -> Pose {
        Pose::new(
            self.random.rotation(),
            self.origin + 2.5 * self.random.vector(),
        )
        .unwrap()
    }

    fn body(&mut self, pose: Pose) -> Body {
        let random = &mut self.random;
        let tree = Arc::clone(&self.trees[random.below(self.trees.len())]);
        let body = if random.below(4) == 0 {
            Body::fixed(tree, pose)
        } else {
            Body::moving(tree, pose)
        };
        let body = body.importance(random.below(3) as f32);
        match random.below(6) {
            0 => body.margin(0.1 * random.unit()),
            1 => body.filter(Filter::new(1 << random.below(3), random.bits() as u32 | 1)),
            _ => body,
        }
    }

    fn insert(&mut self) -> BodyId {
        let place = self.place();
        let body = self.body(place);
        let id = self.scene.insert(body).unwrap();
        self.came(id);
        id
    }

    /// Another body in the slot of one, and in its place where distances are asked for.
    fn replace(&mut self, id: BodyId) {
        let of_it = self.measured.iter().filter(|pair| pair.contains(&id));
        let others: Vec<_> = of_it.map(|&[a, b]| if a == id { b } else { a }).collect();
        self.scene.remove(id).unwrap();
        self.left(id);
        let new = self.insert();
        assert_eq!(new.index(), id.index());
        others
            .into_iter()
            .for_each(|other| self.measure(other, new));
    }

    fn measure(&mut self, x: BodyId, y: BodyId) {
        self.scene.measure(x, y, TOLERANCE).unwrap();
        self.measured.insert([x.min(y), x.max(y)]);
    }

    fn came(&mut self, id: BodyId) {
        assert!(
            self.born.insert(id, self.gaps.len() as u64).is_none(),
            "{id} was in use before"
        );
    }

    fn left(&mut self, id: BodyId) {
        self.motions.remove(&id);
        self.measured.retain(|pair| !pair.contains(&id));
        self.compounds
            .iter_mut()
            .for_each(|(_, parts)| parts.retain(|&(part, _)| part != id));
    }

    /// One random change.
    pub fn change(&mut self) {
        let ids = self.ids();
        if ids.len() < 5 {
            self.insert();
            return;
        }
        let [id, other] = [0; 2].map(|_| ids[self.random.below(ids.len())]);
        let pair = [id.min(other), id.max(other)];
        let there = self.scene.body(id).unwrap().pose;
        let kind = self.random.below(34);
        let (scene, random) = (&mut self.scene, &mut self.random);
        match kind {
            0 if ids.len() > 11 => {
                scene.remove(id).unwrap();
                self.left(id);
            }
            1 => self.replace(id),
            2 if ids.len() < 16 => _ = self.insert(),
            3 => scene
                .set_tree(id, Arc::clone(&self.trees[random.below(self.trees.len())]))
                .unwrap(),
            4 => {
                let tree = scene.tree_mut(id).unwrap();
                let size = 0.9 + 0.2 * random.unit();
                let moved: Vec<[f64; 3]> = (0..tree.mesh().vertex_count())
                    .map(|i| (size * tree.mesh().vertex(i)).to_array())
                    .collect();
                tree.refit_f64(&moved).unwrap();
            }
            5 => scene
                .set_filter(
                    id,
                    Filter::new(1 << random.below(3), random.bits() as u32 | 1),
                )
                .unwrap(),
            6 | 7 => scene.set_filter(id, Filter::default()).unwrap(),
            8 => scene
                .set_margin(id, [0.0, 0.1 * random.unit()][random.below(2)])
                .unwrap(),
            9 => {
                self.mode = [Mode::Any, Mode::All][random.below(2)];
                scene.set_mode(self.mode);
            }
            10 => scene.set_reach([Reach::Here, Reach::Swept][random.below(2)]),
            11 => scene.set_importance(id, random.signed() as f32).unwrap(),
            12 => {
                let question = [
                    PairQuestion::Meet,
                    PairQuestion::Distance,
                    PairQuestion::Contacts,
                ][random.below(3)];
                scene
                    .set_question_importance(question, random.signed() as f32)
                    .unwrap();
            }
            13 if id != other => self.measure(other, id),
            14 if id != other => {
                scene.stop_measuring(id, other).unwrap();
                self.measured.remove(&pair);
            }
            15 if self.groups.len() < 3 => {
                let middle = 1 + random.below(ids.len() - 1);
                let bodies = [&ids[..middle], &ids[middle..]].map(<[BodyId]>::to_vec);
                let id = scene
                    .measure_groups(&bodies[1], &bodies[0], TOLERANCE)
                    .unwrap();
                self.groups.push(Group { id, bodies });
            }
            16 | 17 if !self.groups.is_empty() => {
                let gone = self.groups.swap_remove(random.below(self.groups.len()));
                scene.stop_measuring_groups(gone.id).unwrap();
            }
            18 if id != other => scene.find_contacts_of(id, other).unwrap(),
            19 if id != other => scene.stop_finding_contacts_of(id, other).unwrap(),
            20 => {
                self.has_room = random.below(4) > 0;
                scene.set_max_pairs(if self.has_room {
                    1 << 20
                } else {
                    random.below(40)
                });
            }
            21 if self.compounds.len() < 3 && ids.len() < 14 => self.insert_compound(),
            32 | 33 => {
                let filter = Filter::new(1 << random.below(3), 1 << random.below(3));
                match kind {
                    32 => scene.find_contacts_between(filter),
                    _ => scene.stop_finding_contacts_between(filter),
                }
            }
            22 | 23 if !self.compounds.is_empty() => self.change_compound(kind == 22),
            24 | 25 => {
                let motion = self.motion(there);
                self.scene.set_motion(id, motion).unwrap();
                self.motions.insert(id, motion);
            }
            _ => {
                let next = match kind {
                    26 => self.place(),
                    27 => there,
                    _ => nudged(&there, random),
                };
                self.scene.set_pose(id, next).unwrap();
                self.motions.remove(&id);
            }
        }
    }

    fn motion(&mut self, start: Pose) -> Motion {
        let (turn, way, end) = (
            2.0 * self.random.vector(),
            self.random.vector(),
            self.place(),
        );
        match self.random.below(3) {
            0 => Motion::straight(start, way),
            1 => Motion::screw(start, end),
            _ => Motion::turning(start, start.translation() + way, turn, way),
        }
        .unwrap()
    }

    fn insert_compound(&mut self) {
        let places = [
            Pose::IDENTITY,
            Pose::new(self.random.rotation(), self.random.vector()).unwrap(),
        ];
        let parts = places.map(|place| self.body(place));
        let at = self.place();
        let id = self.scene.insert_compound(at, parts).unwrap();
        let bodies: Vec<_> = self.scene.parts(id).unwrap().collect();
        bodies.iter().for_each(|&body| self.came(body));
        self.compounds
            .push((id, bodies.into_iter().zip(places).collect()));
    }

    fn change_compound(&mut self, goes: bool) {
        let at = self.random.below(self.compounds.len());
        let (id, parts) = self.compounds[at].clone();
        assert!(
            self.scene
                .parts(id)
                .unwrap()
                .eq(parts.iter().map(|&(part, _)| part))
        );
        let there = self.place();
        match self.random.below(3) {
            0 if goes => {
                self.scene.remove_compound(id).unwrap();
                self.compounds.swap_remove(at);
                parts.iter().for_each(|&(part, _)| self.left(part));
                assert!(matches!(
                    self.scene.set_compound_pose(id, there),
                    Err(SceneError::NoSuchCompound { .. })
                ));
            }
            1 => {
                let motion = self.motion(there);
                self.scene.set_compound_motion(id, motion).unwrap();
                self.motions.extend(
                    parts
                        .iter()
                        .map(|(part, place)| (*part, motion.of_part(place).unwrap())),
                );
            }
            _ => {
                self.scene.set_compound_pose(id, there).unwrap();
                self.motions
                    .retain(|id, _| !parts.iter().any(|(part, _)| part == id));
            }
        }
    }

    pub fn may_meet(&self, pair: Pair) -> bool {
        let [x, y] = pair.map(|id| self.scene.body(id).unwrap().filter);
        let [of_x, of_y] = pair.map(|id| self.scene.compound_of(id).unwrap());
        x.meets(y) && (of_x.is_none() || of_x != of_y)
    }

    /// Whether the distance of a pair is asked for, by itself or for groups.
    pub fn is_measured(&self, pair @ [a, b]: Pair) -> bool {
        let has = |group: &Group, [x, y]: [usize; 2]| {
            group.bodies[x].contains(&a) && group.bodies[y].contains(&b)
        };
        self.measured.contains(&pair)
            || self
                .groups
                .iter()
                .any(|group| has(group, [0, 1]) || has(group, [1, 0]))
    }

    pub fn is_compared(&self, pair: Pair) -> bool {
        let moves = |id| self.scene.body(id).unwrap().kind == BodyKind::Moving;
        pair.into_iter().any(moves) || self.is_measured(pair)
    }

    /// A budget, and the most work that it allows.
    pub fn budget(&mut self) -> (Budget, u64) {
        let work = [0, 1 << (8 + self.random.below(10))][self.random.below(2)];
        match self.random.below(6) {
            0 => (Budget::unlimited(), u64::MAX),
            1 | 2 => (Budget::work(work), work),
            3 => (Budget::time(Duration::ZERO), u64::MAX),
            _ => (
                Budget::time(Duration::from_nanos(1 << self.random.below(20))),
                u64::MAX,
            ),
        }
    }
}
