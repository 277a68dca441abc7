//! Questions about a scene between frames: many rays, a shape on its way, overlaps, the closest
//! body; and named groups.

use crate::arrays::{list, text};
use crate::body::punctual_body_id;
use crate::budget::{punctual_budget, punctual_clock};
use crate::handle::change;
use crate::motion::punctual_motion;
use crate::outcome::{nanoseconds, punctual_stop_reason, punctual_verdict, verdict};
use crate::pose::punctual_point;
use crate::query::check_mode;
use crate::scene::punctual_scene;
use crate::scene_answers::{punctual_scene_ray, punctual_scene_ray_cast};
use crate::sized::{fill_rows, place, read, read_all, rows};
use crate::status::{Fault, given};
use crate::tree::punctual_tree;
use crate::verbs::{calls, inits, types};
use crate::workspace::punctual_triangle_pair;
use ::punctual_scene::{
    BodyOverlap, Closest, Filter, GroupId, Overlap, Scene, SceneError, SceneShape, ShapeCast,
    ShapeHit,
};
use core::ffi::c_char;
use core::mem::MaybeUninit;
use punctual::clock::ClockedBudget;

/// No group of a scene.
pub const PUNCTUAL_NO_GROUP: u64 = u64::MAX;

types! {
    /// What is asked about the bodies of a scene: a tree at a pose or on its way, or a point. Plain
    /// data, made by `punctual_scene_shape_new`.
    asked punctual_scene_shape<'t>(body) {
        /// Not 0: only other bodies are asked that `body` may meet.
        has_body: u32 = 0,
        /// Its tree; null for a point, the start of `motion`, which then has no turn.
        tree: Option<&'t punctual_tree> = None,
        /// Its way from time 0 to 1, in the coordinates of the scene. All questions but that of a
        /// cast are about its start.
        motion: punctual_motion = punctual_motion::STILL,
        /// A length by which it is thickened: a point is then a ball; 0 by default.
        margin: f64 = 0.0,
        /// Only bodies that a body of these groups and this mask may meet are asked; all by
        /// default.
        groups: u32 = Filter::default().groups,
        /// See `groups`; all by default.
        mask: u32 = Filter::default().mask,
        /// See `has_body`.
        body: punctual_body_id = punctual_body_id::default(),
        /// 0.
        reserved: u32 = 0,
    }

    /// Where a shape touches a body, or is closest to it.
    plain punctual_shape_hit from (hit: Option<ShapeHit>) {
        /// The body; zeros without one.
        body: punctual_body_id = hit.map_or_else(Default::default, |hit| hit.body.into()),
        /// Whether there is a body.
        is_there: bool = hit.is_some(),
        /// Whether triangles and points were found; not if one is inside the other. If not, they
        /// are zeros.
        has_points: bool = hit.is_some_and(|hit| hit.points.is_some()),
        /// Whether there is a normal; not where the triangles intersect. If not, it is zero.
        has_normal: bool = hit.is_some_and(|hit| hit.normal.is_some()),
        /// Triangle of the body, triangle of the shape.
        triangles: punctual_triangle_pair =
            hit.and_then(|hit| hit.triangles).unwrap_or_default().into(),
        /// Their closest points in the coordinates of the scene, of the body and of the shape, each
        /// moved towards the other by its margin.
        points: [punctual_point; 2] =
            hit.and_then(|hit| hit.points).unwrap_or_default().map(Into::into),
        /// Unit vector from the body to the shape.
        normal: punctual_point = hit.and_then(|hit| hit.normal).unwrap_or_default().into(),
    }

    /// What a shape meets on its way; times from 0 to 1.
    told punctual_shape_cast(work) from (cast: ShapeCast) {
        /// Why it returned.
        stop: punctual_stop_reason = cast.stop.into(),
        /// Proven: it meets no body before. 1 without a hit: it is free to its end.
        free_until: f64 = cast.free_until,
        /// Proven: it meets the body of `hit` at this time; 0 without one.
        touching_at: f64 = cast.touching_at.unwrap_or(0.0),
        /// The body, with points and normal just before.
        hit: punctual_shape_hit = cast.hit.into(),
        /// Work done.
        work: u64 = cast.work,
        /// Time of the call in nanoseconds; -1 if it was not measured, which it is only under a
        /// time budget.
        elapsed: i64 = nanoseconds(cast.elapsed),
    }

    /// The body closest to a shape, wherever the search stopped.
    told punctual_closest_body(work) from (closest: Closest) {
        /// Why it returned.
        stop: punctual_stop_reason = closest.stop.into(),
        /// Proven: no body is closer, margins subtracted; infinite if there is none at all.
        low: f64 = closest.low,
        /// Proven: the body of `hit` is no farther; 0 if they meet, infinite if none was found.
        high: f64 = closest.high,
        /// The closest body found.
        hit: punctual_shape_hit = closest.hit.into(),
        /// Work done.
        work: u64 = closest.work,
        /// Time of the call in nanoseconds; -1 if it was not measured, which it is only under a
        /// time budget.
        elapsed: i64 = nanoseconds(closest.elapsed),
    }

    /// A body that a shape meets.
    row punctual_body_overlap(verdict) from (met: &BodyOverlap) {
        /// The body.
        body: punctual_body_id = met.body.into(),
        /// How they meet.
        verdict: punctual_verdict = verdict(met.verdict).0,
        /// Triangles of the body and of the shape that prove it; as of `punctual_outcome`.
        witness: punctual_triangle_pair = verdict(met.verdict).1,
    }

    /// How many bodies a shape meets, wherever the search stopped.
    told punctual_overlap(work) from (overlap: Overlap<'_>) {
        /// Why it returned.
        stop: punctual_stop_reason = overlap.stop.into(),
        /// How many bodies are proven to meet it.
        met: u64 = overlap.met.len() as u64,
        /// How many bodies have boxes that overlap its own and were not decided.
        undecided: u64 = overlap.undecided.len() as u64,
        /// 1: all other bodies are proven not to meet it. 0 if the budget ended before all boxes
        /// were compared, or of MODE_ANY, if a first body was enough.
        is_whole: u64 = overlap.is_whole.into(),
        /// Work done.
        work: u64 = overlap.work,
        /// Time of the call in nanoseconds; -1 if it was not measured, which it is only under a
        /// time budget.
        elapsed: i64 = nanoseconds(overlap.elapsed),
    }
}

inits! {
    /// A shape without a margin, which asks all bodies. `tree` may be null: a point. Checked when
    /// it is asked about.
    punctual_scene_shape_init(
        shape: punctual_scene_shape<'t>, tree: Option<&'t punctual_tree>, motion: punctual_motion
    ) { tree, motion }
}

impl punctual_scene_shape<'_> {
    fn check(&self) -> Result<SceneShape<'_>, Fault> {
        let motion = self.motion.check()?;
        let shape = match self.tree {
            Some(tree) => SceneShape::moving(tree.0.get("shape->tree")?, motion),
            None => SceneShape::point(motion.start().translation())?.along(motion.velocity())?,
        };
        let shape = shape
            .margin(self.margin)
            .filter(Filter::new(self.groups, self.mask));
        Ok(match self.has_body {
            0 => shape,
            _ => shape.of_body(self.body.into()),
        })
    }

    /// Asks about a shape of the caller's.
    ///
    /// # Safety
    /// The contract of the header for structs and clocks.
    unsafe fn ask<R>(
        shape: *const Self,
        scene: Option<&mut punctual_scene>,
        budget: punctual_budget,
        clock: Option<&punctual_clock>,
        ask: impl FnOnce(&mut Scene, &SceneShape, ClockedBudget<'_>) -> Result<R, SceneError>,
    ) -> Result<R, Fault> {
        // SAFETY: the caller's promise.
        unsafe {
            let shape = read(shape, "shape")?;
            let shape = shape.check()?;
            budget.spend(clock, |budget| {
                change(scene, "scene", |scene| Ok(ask(scene, &shape, budget)?))
            })
        }
    }
}

calls! {
    /// Finds which body a shape meets first on its way, within a budget of its own. `clock` may be
    /// null: the clock of the system. Bodies are where they were put last; their own motions do not
    /// count. Their margins do.
    ///
    /// Fails with BAD_POSE or BAD_ARGUMENT if the shape is refused, and with NO_SUCH_BODY.
    unsafe fn punctual_scene_cast_shape(
        scene: Option<&mut punctual_scene>, shape: *const punctual_scene_shape<'_>,
        budget: punctual_budget, clock: Option<&punctual_clock>, cast: *mut punctual_shape_cast
    ) {
        // SAFETY: the contract of the header for structs and clocks.
        let (cast, found) = unsafe {
            let found =
                punctual_scene_shape::ask(shape, scene, budget, clock, |scene, shape, budget| {
                    scene.cast_shape(shape, budget)
                })?;
            (place(cast, "cast")?, found)
        };
        cast.write(found.into());
        Ok(())
    }

    /// Finds the body that is closest to a shape and no farther than `within`, 0 to infinity.
    /// Otherwise as `punctual_scene_cast_shape`.
    unsafe fn punctual_scene_closest(
        scene: Option<&mut punctual_scene>, shape: *const punctual_scene_shape<'_>, within: f64,
        budget: punctual_budget, clock: Option<&punctual_clock>,
        closest: *mut punctual_closest_body
    ) {
        // SAFETY: the contract of the header for structs and clocks.
        let (closest, found) = unsafe {
            let found =
                punctual_scene_shape::ask(shape, scene, budget, clock, |scene, shape, budget| {
                    scene.closest(shape, within, budget)
                })?;
            (place(closest, "closest")?, found)
        };
        closest.write(found.into());
        Ok(())
    }

    /// Finds the bodies that a shape meets, MODE_ALL or MODE_ANY of them; of two solids, what is
    /// inside meets. As many as there is room for are written to `met` and to `undecided`, by
    /// index; how many there are is in `overlap`. Otherwise as `punctual_scene_cast_shape`.
    unsafe fn punctual_scene_overlap(
        scene: Option<&mut punctual_scene>, shape: *const punctual_scene_shape<'_>, mode: u32,
        budget: punctual_budget, clock: Option<&punctual_clock>, met: *mut punctual_body_overlap,
        met_size: usize, met_capacity: usize, undecided: *mut punctual_body_id,
        undecided_capacity: usize, overlap: *mut punctual_overlap
    ) {
        let mode = check_mode(mode, "mode")?;
        // SAFETY: the contract of the header for structs, arrays and clocks.
        unsafe {
            let overlap = place(overlap, "overlap")?;
            let mut written = Ok(());
            let found =
                punctual_scene_shape::ask(shape, scene, budget, clock, |scene, shape, budget| {
                    let found = scene.overlap(shape, mode, budget)?;
                    let open = found.undecided.iter().copied();
                    let (room, mut count) = (undecided_capacity, MaybeUninit::uninit());
                    written = fill_rows(met, met_size, met_capacity, "met", found.met.iter())
                        .and(list(undecided, room, "undecided", &mut count, open));
                    Ok(punctual_overlap::from(found))
                })?;
            written?;
            overlap.write(found);
        }
        Ok(())
    }

    /// Casts `count` rays one after another within one budget, each as `punctual_scene_cast`, and
    /// writes their answers to `casts`. How many of them are answered, from the first, is written
    /// to `done`; the others are free until 0. With threads of the scene, a batch of more than 64
    /// rays is shared among them, unless work is limited or the clock is the caller's; a budget of
    /// work, or none, gives the same bits on any number of them.
    ///
    /// Fails with BAD_ARGUMENT for the first ray that is refused.
    unsafe fn punctual_scene_cast_rays(
        scene: Option<&mut punctual_scene>, rays: *const punctual_scene_ray, count: usize,
        budget: punctual_budget, clock: Option<&punctual_clock>,
        casts: *mut punctual_scene_ray_cast, casts_size: usize,
        done: Option<&mut MaybeUninit<usize>>
    ) {
        let done = given(done, "done")?;
        // SAFETY: the contract of the header for arrays.
        let rays = unsafe { read_all(rays, count, "rays") }?;
        let rays: Vec<_> = rays.iter().map(punctual_scene_ray::check).collect::<Result<_, _>>()?;
        let cast = |budget: ClockedBudget<'_>| change(scene, "scene", |scene| {
            let found = scene.cast_rays(&rays, budget)?;
            let is_done = |stop: punctual_stop_reason| {
                use punctual_stop_reason as stops;
                matches!(stop, stops::Finished | stops::FirstHit)
            };
            let first = found.iter().take_while(|cast| is_done(cast.stop.into()));
            done.write(first.count());
            let mut written = MaybeUninit::uninit();
            let found = found.iter().copied();
            // SAFETY: the contract of the header for arrays.
            unsafe { rows(casts, casts_size, count, "casts", &mut written, found) }
        });
        // SAFETY: that for clocks.
        unsafe { budget.spend(clock, cast) }
    }

    /// The group of this name, a text in UTF-8; made if the scene has none yet.
    unsafe fn punctual_scene_group(
        scene: Option<&mut punctual_scene>, name: *const c_char,
        group: Option<&mut MaybeUninit<u64>>
    ) {
        let group = given(group, "group")?;
        // SAFETY: the contract of the header for texts.
        let name = unsafe { text(name, "name") }?;
        let found = change(scene, "scene", |scene| Ok(scene.group(name)))?;
        group.write(found.to_bits());
        Ok(())
    }

    /// Moves a body to a group, or with PUNCTUAL_NO_GROUP out of its group.
    ///
    /// Fails with BAD_ARGUMENT if the scene has no such group.
    change punctual_scene_set_group(scene: punctual_scene, id: punctual_body_id, group: u64) = {
        let group = (group != PUNCTUAL_NO_GROUP).then(|| GroupId::from_bits(group));
        scene.set_group(id.into(), group)?
    };

    /// Ignores all pairs of a body of one group and a body of the other from the next frame on, or
    /// (`ignores` is false) does no longer; twice the same group: its bodies do not meet each
    /// other.
    ///
    /// Fails with BAD_ARGUMENT if the scene has no such group.
    change punctual_scene_ignore_groups(scene: punctual_scene, x: u64, y: u64, ignores: bool) =
        scene.ignore_groups(GroupId::from_bits(x), GroupId::from_bits(y), ignores)?;
}
