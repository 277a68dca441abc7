//! Scenes: bodies that come, change and go, and frames between them.

use super::World;
use super::call::{Call, any, asked, begun, sized};
use super::queries::{budget, clock};
use super::surfaces::{Grown, Shape, moved, narrowed, pose, vertices};
use libfuzzer_sys::arbitrary::{Result, Unstructured};
use punctual::Pose;
use punctual_capi::{punctual_status as Status, *};
use punctual_fuzz::reference;
use std::mem::MaybeUninit;
use std::ptr::null_mut;

/// A scene, its bodies as a plain list, and the ids that are no longer valid.
pub struct Stage {
    pub scene: Box<punctual_scene>,
    mode: u32,
    actors: Vec<Actor>,
    removed: Vec<punctual_body_id>,
}

struct Actor {
    id: punctual_body_id,
    shape: Shape,
    body: punctual_body<'static>,
}

/// Some calls of one scene.
pub fn play(world: &mut World, bytes: &mut Unstructured) -> Result<()> {
    if world.stages.is_empty() || (world.stages.len() < 2 && bytes.ratio(1, 16)?) {
        open(world, bytes)?;
    }
    let Some(at) = any(bytes, &world.stages)? else {
        return Ok(());
    };
    match bytes.int_in_range(0..=31)? {
        0 => {
            let stage = world.stages.swap_remove(at);
            punctual_scene_free(Some(stage.scene));
        }
        1 => {
            let mut call = Call::default();
            let threads = if bytes.arbitrary()? {
                bytes.int_in_range(0..=2)?
            } else {
                bytes.int_in_range(1025..=usize::MAX)?
            };
            call.fault(threads > 1024, Status::BadArgument);
            call.doubt(Status::NoThread);
            let scene = call.given(bytes, &mut *world.stages[at].scene)?;
            call.judge(punctual_scene_use_threads(scene, threads));
        }
        2..=20 => change(world, at, bytes)?,
        _ => world.stages[at].detect(bytes)?,
    }
    Ok(())
}

fn open(world: &mut World, bytes: &mut Unstructured) -> Result<()> {
    let mut call = Call::default();
    let (mode, reach) = (call.value(bytes, 2)?, call.value(bytes, 2)?);
    let made = call.own(bytes, |out| punctual_scene_new(mode, reach, out))?;
    world.stages.extend(made.map(|scene| Stage {
        scene,
        mode,
        actors: Vec::new(),
        removed: Vec::new(),
    }));
    Ok(())
}

/// The model does not foretell where a scene allows less than a query.
fn place(call: &mut Call, bytes: &mut Unstructured) -> Result<punctual_pose> {
    let (pose, valid) = pose(bytes)?;
    call.fault(valid.is_none(), Status::BadPose);
    call.doubt(Status::BadPose);
    Ok(pose)
}

fn importance(call: &mut Call, bytes: &mut Unstructured) -> Result<f32> {
    let importance = f32::from_bits(bytes.arbitrary()?);
    call.fault(importance.is_nan(), Status::BadArgument);
    Ok(importance)
}

fn change(world: &mut World, at: usize, bytes: &mut Unstructured) -> Result<()> {
    let (stage, trees) = (&mut world.stages[at], &mut world.trees);
    let Some(tree) = any(bytes, trees)? else {
        return super::surfaces::grow(world, bytes);
    };
    let Some(actor) = any(bytes, &stage.actors)?
        .filter(|&actor| actor >= 8 || !bytes.ratio(1, 3).unwrap_or(false))
    else {
        return stage.insert(&trees[tree], bytes);
    };
    let mut call = Call::default();
    let id = stage.id(actor, &mut call, bytes)?;
    let (known, scene) = (&mut stage.actors[actor], &mut *stage.scene);
    match bytes.int_in_range(0..=9)? {
        0 => {
            let scene = call.given(bytes, scene)?;
            if call.judge(punctual_scene_remove(scene, id)) {
                stage.removed.push(stage.actors.swap_remove(actor).id);
            }
        }
        1 | 2 => {
            let pose = place(&mut call, bytes)?;
            let scene = call.given(bytes, scene)?;
            if call.judge(punctual_scene_set_pose(scene, id, pose)) {
                known.body.pose = pose;
            }
        }
        3 => {
            let (scene, handle) = (
                call.given(bytes, scene)?,
                call.given(bytes, &*trees[tree].handle)?,
            );
            if call.judge(punctual_scene_set_tree(scene, id, handle)) {
                known.shape = trees[tree].shape.clone();
            }
        }
        4 => {
            let (groups, mask) = (bytes.int_in_range(0..=3)?, bytes.int_in_range(0..=3)?);
            let scene = call.given(bytes, scene)?;
            if call.judge(punctual_scene_set_filter(scene, id, groups, mask)) {
                (known.body.groups, known.body.mask) = (groups, mask);
            }
        }
        5 => {
            let importance = importance(&mut call, bytes)?;
            let scene = call.given(bytes, scene)?;
            if call.judge(punctual_scene_set_importance(scene, id, importance)) {
                known.body.importance = importance;
            }
        }
        6 => {
            let scene = call.given(bytes, &*scene)?;
            if let Some(body) =
                call.fill(bytes, |out| unsafe { punctual_scene_body(scene, id, out) })?
            {
                known.compare(&body);
            }
        }
        7 => {
            let scene = call.given(bytes, &*scene)?;
            if let Some(handle) = call.own(bytes, |out| punctual_scene_tree(scene, id, out))? {
                let old = std::mem::replace(
                    &mut trees[tree],
                    Grown {
                        handle,
                        shape: known.shape.clone(),
                    },
                );
                punctual_tree_free(Some(old.handle));
            }
        }
        _ => known.refit(scene, id, call, bytes)?,
    }
    Ok(())
}

impl Actor {
    fn compare(&self, body: &punctual_body) {
        let has = (
            body.pose,
            body.kind,
            body.groups,
            body.mask,
            body.importance,
        );
        let of = &self.body;
        assert_eq!(has, (of.pose, of.kind, of.groups, of.mask, of.importance));
        assert!(body.tree.is_none());
    }

    fn refit(
        &mut self,
        scene: &mut punctual_scene,
        id: punctual_body_id,
        mut call: Call,
        bytes: &mut Unstructured,
    ) -> Result<()> {
        let mut wide = vertices(&self.shape.mesh, bytes)?;
        let is_narrow = bytes.arbitrary()?;
        let narrow = if is_narrow {
            narrowed(&mut wide)
        } else {
            Vec::new()
        };
        let new = moved(&self.shape.mesh, &wide);
        call.fault(new.is_none(), Status::BadMesh);
        let scene = call.given(bytes, scene)?;
        // SAFETY: as long as said, or refused.
        let status = unsafe {
            if is_narrow {
                let (first, count) =
                    call.array(bytes, narrow.as_ptr().cast_mut().cast(), narrow.len())?;
                punctual_scene_refit_f32(scene, id, first, count)
            } else {
                let (first, count) =
                    call.array(bytes, wide.as_ptr().cast_mut().cast(), wide.len())?;
                punctual_scene_refit_f64(scene, id, first, count)
            }
        };
        if call.judge(status) {
            self.shape = Shape::new(new.expect("it fits"));
        }
        Ok(())
    }
}

impl Stage {
    /// The id of an actor; now and then of a body that is gone, or never was.
    fn id(
        &self,
        actor: usize,
        call: &mut Call,
        bytes: &mut Unstructured,
    ) -> Result<punctual_body_id> {
        let stranger = bytes.ratio(1, 12)?;
        call.fault(stranger, Status::NoSuchBody);
        Ok(match (stranger, any(bytes, &self.removed)?) {
            (false, _) => self.actors[actor].id,
            (true, Some(gone)) if bytes.arbitrary()? => self.removed[gone],
            (true, _) => punctual_body_id {
                index: bytes.int_in_range(0..=9)?,
                generation: 0xdead,
                scene: 0,
            },
        })
    }

    fn insert(&mut self, tree: &Grown, bytes: &mut Unstructured) -> Result<()> {
        let mut call = Call::default();
        let pose = place(&mut call, bytes)?;
        // SAFETY: the place is as large as said.
        let mut body = begun(|place, size| unsafe { punctual_body_init(place, size, None, pose) });
        body.kind = call.value(bytes, 2)?;
        if bytes.arbitrary()? {
            body.importance = importance(&mut call, bytes)?;
            (body.groups, body.mask) = (bytes.int_in_range(0..=3)?, bytes.int_in_range(0..=3)?);
        }
        let with = punctual_body {
            tree: call.given(bytes, &*tree.handle)?,
            ..body
        };
        let (scene, with) = (
            call.given(bytes, &mut *self.scene)?,
            call.given(bytes, &with)?,
        );
        if let Some(id) = call.make(bytes, |out| unsafe {
            punctual_scene_insert(scene, asked(with), out)
        })? {
            let used = self
                .actors
                .iter()
                .map(|actor| &actor.id)
                .chain(&self.removed)
                .any(|other| *other == id);
            assert!(!used, "{id:?} was in use before");
            self.actors.push(Actor {
                id,
                shape: tree.shape.clone(),
                body,
            });
        }
        Ok(())
    }

    /// A frame; then what it says of every two bodies.
    fn detect(&mut self, bytes: &mut Unstructured) -> Result<()> {
        let mut call = Call::default();
        let mut context = [0; 2];
        let clock = clock(&mut call, bytes, &mut context)?;
        let (budget, unlimited) = budget(&mut call, bytes)?;
        let scene = call.given(bytes, &mut *self.scene)?;
        // The report may be null, so this is not a call that must write.
        let mut out = sized(0);
        let place = if bytes.ratio(1, 16)? {
            null_mut()
        } else {
            out.as_mut_ptr()
        };
        // SAFETY: `context` outlives the call.
        if !call.judge(unsafe { punctual_scene_detect(scene, budget, clock.as_ref(), place) }) {
            return Ok(());
        }
        let mut call = Call::default();
        let scene = call.given(bytes, &*self.scene)?;
        let Some(report) = call.fill(bytes, |out| unsafe { punctual_scene_report(scene, out) })?
        else {
            return Ok(());
        };
        let mut pairs: Vec<punctual_pair_report> = Vec::with_capacity(report.pair_count);
        let (first, room, size) = (
            pairs.as_mut_ptr(),
            pairs.capacity(),
            size_of::<punctual_pair_report>(),
        );
        let mut call = Call::default();
        let scene = call.given(bytes, &*self.scene)?;
        // SAFETY: there is room for as many as said.
        let count = call.make(bytes, |out| unsafe {
            punctual_scene_pairs(scene, first, size, room, out)
        })?;
        let Some(count) = count else { return Ok(()) };
        assert_eq!(count, report.pair_count);
        // SAFETY: as many were written.
        unsafe { pairs.set_len(count) };
        let decided = pairs
            .iter()
            .filter(|pair| pair.verdict != punctual_verdict::Undecided)
            .count();
        let intersecting = pairs
            .iter()
            .filter(|pair| pair.verdict == punctual_verdict::Intersecting)
            .count();
        assert_eq!(
            (report.decided, report.intersecting),
            (decided, intersecting)
        );
        self.actors.sort_by_key(|actor| actor.id.index);
        self.list(bytes)?;
        let whole = (report.unplaced, report.unpaired, report.unlisted) == (0, 0, 0);
        let mut listed = 0;
        for (i, a) in self.actors.iter().enumerate() {
            for b in &self.actors[i + 1..] {
                let pair = pairs.iter().find(|pair| (pair.a, pair.b) == (a.id, b.id));
                listed += usize::from(pair.is_some());
                self.check(a, b, pair, [unlimited, whole], bytes)?;
            }
        }
        assert_eq!(listed, pairs.len(), "pairs of bodies that are not there");
        Ok(())
    }

    fn list(&self, bytes: &mut Unstructured) -> Result<()> {
        let mut call = Call::default();
        let scene = call.given(bytes, &*self.scene)?;
        let mut ids = Vec::<punctual_body_id>::with_capacity(bytes.int_in_range(0..=9)?);
        let (first, capacity) = call.array(bytes, ids.as_mut_ptr(), ids.capacity())?;
        // SAFETY: there is room for as many as said, or it is refused.
        let count = call.make(bytes, |out| unsafe {
            punctual_scene_bodies(scene, first, capacity, out)
        })?;
        let Some(count) = count else { return Ok(()) };
        assert_eq!(count, self.actors.len());
        // SAFETY: as many were written as there is room for.
        unsafe { ids.set_len(count.min(capacity)) };
        assert!(
            ids.iter()
                .zip(&self.actors)
                .all(|(id, actor)| *id == actor.id)
        );
        Ok(())
    }

    fn check(
        &self,
        a: &Actor,
        b: &Actor,
        pair: Option<&punctual_pair_report>,
        [unlimited, whole]: [bool; 2],
        bytes: &mut Unstructured,
    ) -> Result<()> {
        let mut call = Call::default();
        let scene = call.given(bytes, &*self.scene)?;
        let (mut again, size) = (
            MaybeUninit::<punctual_pair_report>::uninit(),
            size_of::<punctual_pair_report>(),
        );
        let place = call.given(bytes, again.as_mut_ptr())?.unwrap_or(null_mut());
        let listed = call.make(bytes, |out| unsafe {
            punctual_scene_pair(scene, b.id, a.id, place, size, out)
        })?;
        if let Some(listed) = listed {
            assert_eq!(listed, pair.is_some());
            // SAFETY: written if it is listed.
            assert!(!listed || pair == Some(&unsafe { again.assume_init() }));
        }
        let (x, y) = (&a.body, &b.body);
        let moving = x.kind == punctual_body_kind::Moving as u32
            || y.kind == punctual_body_kind::Moving as u32;
        if !moving || x.groups & y.mask == 0 || y.groups & x.mask == 0 {
            assert!(pair.is_none(), "they may not meet");
            return Ok(());
        }
        let [of_a, of_b] =
            [x, y].map(|body| Pose::from_row_major(body.pose.m).expect("the scene took it"));
        let b_in_a = of_a.inverse().and_then(|inverse| inverse.compose(&of_b));
        let b_in_a = b_in_a.expect("any two bodies have a relative pose");
        let truth = reference::all_pairs(&a.shape.mesh, &b.shape.mesh, &b_in_a);
        let Some(pair) = pair else {
            assert!(truth.is_empty() || !whole, "they meet and are not listed");
            return Ok(());
        };
        let witness = [pair.witness.a, pair.witness.b];
        match pair.verdict {
            punctual_verdict::Intersecting => {
                assert!(truth.binary_search(&witness).is_ok(), "a false witness")
            }
            punctual_verdict::Within => {
                assert!(x.margin > 0.0 || y.margin > 0.0, "within no margins")
            }
            punctual_verdict::Separated => {
                assert!(truth.is_empty() && witness == [0; 2], "they meet")
            }
            punctual_verdict::Contained => panic!("trees of surfaces"),
            punctual_verdict::Undecided => assert!(!unlimited, "undecided"),
        }
        assert!(
            (0.0..=1.0).contains(&pair.probability) && (0.0..=1.0).contains(&pair.recall),
            "{pair:?}"
        );
        let found = truth.len() as u64;
        assert!(pair.found <= found);
        assert!(!pair.complete || self.mode == punctual_mode::Any as u32 || pair.found == found);
        let mut call = Call::default();
        let scene = call.given(bytes, &*self.scene)?;
        if let Some(open) = call.fill(bytes, |out| unsafe {
            punctual_scene_certificate(scene, b.id, a.id, out)
        })? {
            assert!(open.upper_bound >= found || (pair.complete && open.upper_bound >= pair.found));
        }
        Ok(())
    }
}
