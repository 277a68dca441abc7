//! Bodies that move as one, distances of groups, and where bodies touch.

use crate::arrays::{array, list};
use crate::body::{punctual_body, punctual_body_id};
use crate::handle::{change, get};
use crate::motion::punctual_motion;
use crate::pose::{punctual_point, punctual_pose};
use crate::scene::punctual_scene;
use crate::sized::{fill_rows, place, read_all};
use crate::status::{given, value_of};
use crate::verbs::{calls, lists, types};
use crate::workspace::punctual_triangle_pair;
use ::punctual_scene::{
    BodyId, CompoundId, ContactPoint, Filter, GroupDistance, MeasureId, PairQuestion,
};
use core::mem::MaybeUninit;

types! {
    /// What a scene asks of a pair of bodies.
    enum punctual_pair_question {
        /// Whether they meet.
        Meet = 0,
        /// How far apart they are.
        Distance = 1,
        /// Until when they are free.
        Motion = 2,
        /// Where they touch.
        Contacts = 3,
    }

    /// What is known of the least distance between two groups of bodies, in the length unit of the
    /// scene. It holds for the bodies where they are in this frame, whatever the budget reached.
    row punctual_group_distance(high) from (found: &GroupDistance) {
        /// Of which groups: the id of `punctual_scene_measure_groups`.
        id: u64 = found.id.to_bits(),
        /// Proven: no point of one group is closer to the other; 0 if nothing is known, and
        /// infinite if no two of their bodies may meet.
        low: f64 = found.low,
        /// Proven: the groups are no farther apart, and 0 only if bodies of them met; infinite if
        /// nothing is known.
        high: f64 = found.high,
        /// Whether bodies prove `high`; if not, it is that of boxes, and the bodies and triangles
        /// are zeros.
        has_bodies: bool = found.bodies.is_some(),
        /// These bodies, the lower index first.
        bodies: [punctual_body_id; 2] =
            found.bodies.map_or_else(Default::default, |pair| pair.map(Into::into)),
        /// Their closest triangles that were found; zeros for none.
        triangles: punctual_triangle_pair = found.triangles.unwrap_or_default().into(),
        /// How many pairs of bodies may still be closer, or are to be measured. 0: `high - low` is
        /// within the tolerance.
        open: usize = found.open,
    }

    /// A point where two bodies touch: one of at most four of a manifold, fixed to both bodies.
    row punctual_contact_point(points) from (point: &ContactPoint) {
        /// The manifold that it belongs to: the same from frame to frame while the manifold keeps a
        /// point.
        manifold: u64 = point.manifold,
        /// The same from frame to frame while the point stays near its place on one of the bodies.
        id: u64 = point.id,
        /// The point on the body of the lower index, in the coordinates of its mesh, and on the
        /// other one, in those of its own.
        points: [punctual_point; 2] = point.points.map(Into::into),
        /// Unit vector in the coordinates of the first body, from the second to the first.
        normal: punctual_point = point.normal.into(),
        /// Signed distance along the normal where it was found, without margins; negative where the
        /// bodies are sunk into each other.
        distance: f64 = point.distance,
    }

    /// Where two bodies touch.
    told punctual_contact_points(count) {
        /// How many points there are; at most 16.
        count: usize,
        /// The surfaces were at least so far apart wherever no point stands for a contact when the
        /// points were found, margins not subtracted; 0 if one body is within the other, or nothing
        /// is known.
        low: f64,
        /// How far the surfaces have moved relative to each other since then, at most; infinite if
        /// nothing is known.
        drift: f64,
        /// Frames since this was found. As many as there were if nothing is known.
        age: u64,
        /// 1 if the body of the lower index was inside the other, 2 if the other was inside it, or
        /// had a vertex in it, while their surfaces did not meet; else 0. No point stands for that.
        within: u64,
    }
}

calls! {
    /// Puts bodies into the scene as the parts of one compound, which is at `pose`: the pose of
    /// each is its place in the frame of the compound. Parts are bodies like others, but those of
    /// one compound never meet. Where a part is, is the product of both poses, rounded; one that is
    /// moved by itself goes back into its place with the next pose or motion of the compound.
    ///
    /// Fails as `punctual_scene_insert`; the scene is then as it was.
    unsafe fn punctual_scene_insert_compound(
        scene: Option<&mut punctual_scene>, pose: punctual_pose, parts: *const punctual_body<'_>,
        part_count: usize, compound: Option<&mut MaybeUninit<u64>>
    ) {
        let (pose, compound) = (pose.check()?, given(compound, "compound")?);
        // SAFETY: the contract of the header for arrays.
        let parts = unsafe { read_all(parts, part_count, "parts") }?;
        let parts = parts.into_iter().map(punctual_body::check).collect::<Result<Vec<_>, _>>()?;
        let id = change(scene, "scene", |scene| Ok(scene.insert_compound(pose, parts)?))?;
        compound.write(id.to_bits());
        Ok(())
    }

    /// The parts of a compound, in the order in which they were given, without those that were
    /// removed: as many as `capacity` allows are written to `ids`, and how many there are to
    /// `count`. As for all that follows, fails with BAD_ARGUMENT if the compound is not in the
    /// scene.
    unsafe fn punctual_scene_parts(
        scene: Option<&punctual_scene>, compound: u64, ids: *mut punctual_body_id, capacity: usize,
        count: Option<&mut MaybeUninit<usize>>
    ) {
        let (scene, count) = (get(scene, "scene")?, given(count, "count")?);
        let parts = scene.parts(CompoundId::from_bits(compound))?;
        // SAFETY: the contract of the header for arrays.
        unsafe { list(ids, capacity, "ids", count, parts) }
    }

    /// The compound that a body is a part of. `is_part` says whether there is one; if not,
    /// `compound` is left alone.
    fn punctual_scene_compound_of(
        scene: Option<&punctual_scene>, id: punctual_body_id,
        compound: Option<&mut MaybeUninit<u64>>, is_part: Option<&mut MaybeUninit<bool>>
    ) {
        let (compound, is_part) = (given(compound, "compound")?, given(is_part, "is_part")?);
        let found = get(scene, "scene")?.compound_of(id.into())?;
        is_part.write(found.is_some());
        found.map(|found| compound.write(found.to_bits()));
        Ok(())
    }

    /// Moves all parts of a compound.
    ///
    /// Fails with BAD_POSE if a part cannot be where it would be; all then stay where they were.
    change punctual_scene_set_compound_pose(
        scene: punctual_scene, compound: u64, pose: punctual_pose
    ) = scene.set_compound_pose(CompoundId::from_bits(compound), pose.check()?)?;

    /// Gives a compound a motion: each of its parts goes with it, about the same axis.
    ///
    /// Fails with BAD_POSE or BAD_ARGUMENT if the motion is refused, or a part cannot be where it
    /// would be at its beginning or end; all then stay where they were.
    change punctual_scene_set_compound_motion(
        scene: punctual_scene, compound: u64, motion: punctual_motion
    ) = scene.set_compound_motion(CompoundId::from_bits(compound), motion.check()?)?;

    /// Takes a compound out of the scene, with all of its parts.
    change punctual_scene_remove_compound(scene: punctual_scene, compound: u64) =
        scene.remove_compound(CompoundId::from_bits(compound))?;

    /// Asks for the least distance between two groups of bodies in every frame from now on; margins
    /// count, and pairs that may not meet by their filters do not. No pair is asked about that is
    /// farther apart than the closest less the tolerance, a length.
    ///
    /// Both groups may have bodies in common, or be one: a body has no distance from itself.
    ///
    /// Fails with BAD_ARGUMENT if both are one and the same body, or the tolerance not from 0 to
    /// 2^1000.
    unsafe fn punctual_scene_measure_groups(
        scene: Option<&mut punctual_scene>, x: *const punctual_body_id, x_count: usize,
        y: *const punctual_body_id, y_count: usize, tolerance: f64,
        id: Option<&mut MaybeUninit<u64>>
    ) {
        let id = given(id, "id")?;
        // SAFETY: the contract of the header for arrays.
        let (x, y) = unsafe { (array(x, x_count, "x")?, array(y, y_count, "y")?) };
        let [x, y] = [x, y].map(|ids| ids.iter().map(|&id| id.into()).collect::<Vec<BodyId>>());
        let groups =
            change(scene, "scene", |scene| Ok(scene.measure_groups(&x, &y, tolerance)?))?;
        id.write(groups.to_bits());
        Ok(())
    }

    /// Asks for the distance of two groups no more.
    ///
    /// Fails with BAD_ARGUMENT if it is not asked for.
    change punctual_scene_stop_measuring_groups(scene: punctual_scene, id: u64) =
        scene.stop_measuring_groups(MeasureId::from_bits(id))?;

    /// Ignores a pair of bodies from the next frame on, or does no longer: it may not meet, as if
    /// filters excluded it. Forgotten with one of its bodies. Fails with BAD_ARGUMENT if both
    /// bodies are the same.
    change punctual_scene_ignore(
        scene: punctual_scene, x: punctual_body_id, y: punctual_body_id, ignores: bool
    ) = scene.ignore(x.into(), y.into(), ignores)?;

    /// Finds where bodies touch from the next frame on, of all pairs that meet:
    /// `punctual_scene_contact_points`.
    change punctual_scene_find_contacts(scene: punctual_scene) = scene.find_contacts();

    /// The same of two bodies, whenever they meet. Fails with BAD_ARGUMENT if both are the same.
    change punctual_scene_find_contacts_of(
        scene: punctual_scene, x: punctual_body_id, y: punctual_body_id
    ) = scene.find_contacts_of(x.into(), y.into())?;

    /// Finds where bodies touch of all pairs of which one is in the groups `groups` and the other
    /// in `mask`, by their own filters (`punctual_scene_set_filter`), from the next frame on.
    /// Several calls add up; all bits for both are `punctual_scene_find_contacts`.
    change punctual_scene_find_contacts_between(scene: punctual_scene, groups: u32, mask: u32) =
        scene.find_contacts_between(Filter::new(groups, mask));

    /// Ends `punctual_scene_find_contacts_between` of these groups, or, with all bits for both,
    /// `punctual_scene_find_contacts`. Nothing changes if there was no such call. Contacts of pairs
    /// that are asked for otherwise are found as before.
    change punctual_scene_stop_finding_contacts_between(
        scene: punctual_scene, groups: u32, mask: u32
    ) = scene.stop_finding_contacts_between(Filter::new(groups, mask));

    /// Does not ask for the contacts of two bodies any more, but as one of all pairs or of those
    /// between groups. Fails with BAD_ARGUMENT if both are the same.
    change punctual_scene_stop_finding_contacts_of(
        scene: punctual_scene, x: punctual_body_id, y: punctual_body_id
    ) = scene.stop_finding_contacts_of(x.into(), y.into())?;

    /// Where two bodies touch, as far as the frames up to the last have found, if that is asked
    /// for; no points if they were found apart. As many as `capacity` allows are written to
    /// `points`, the deepest manifold first, and what is known of all to `found`. Fails with
    /// BAD_ARGUMENT if both bodies are the same.
    unsafe fn punctual_scene_contact_points(
        scene: Option<&punctual_scene>, x: punctual_body_id, y: punctual_body_id,
        points: *mut punctual_contact_point, points_size: usize, capacity: usize,
        found: *mut punctual_contact_points
    ) {
        let scene = get(scene, "scene")?;
        // SAFETY: the contract of the header for structs.
        let found = unsafe { place(found, "found") }?;
        let known = scene.contacts(x.into(), y.into())?;
        // SAFETY: that for arrays.
        let count =
            unsafe { fill_rows(points, points_size, capacity, "points", known.points.iter()) }?;
        let size = punctual_contact_points::SIZE;
        found.write(punctual_contact_points {
            size,
            count,
            low: known.low,
            drift: known.drift,
            age: known.age,
            within: known.within.map_or(0, |inner| {
                let inner = punctual_body_id::from(inner).index;
                1 + u64::from(inner == x.index.max(y.index))
            }),
        });
        Ok(())
    }

    /// Sets how far apart bodies are found out to be whose contacts are asked for and that have
    /// none, besides their margins: up to so far, or to four fifths of their distance, `low` of
    /// `punctual_contact_points` tells it. 0 by default.
    ///
    /// Fails with BAD_ARGUMENT if it is not from 0 to 2^1000.
    change punctual_scene_set_look_ahead(scene: punctual_scene, length: f64) =
        scene.set_look_ahead(length)?;

    /// How far a body may move from where it is before it could touch another one where no contact
    /// point stands, or sink into it there by more than `sink`; at most `stride`. If all moving
    /// bodies move no farther after each frame, and the fixed ones rest, none sinks in deeper
    /// there, whatever the budgets. Pairs whose contacts are not asked for do not count.
    change punctual_scene_may_move(
        scene: punctual_scene, id: punctual_body_id, stride: f64, sink: f64,
        most: Option<&mut MaybeUninit<f64>>
    ) = given(most, "most")?.write(scene.may_move(id.into(), stride, sink)?);

    /// Says how much a question, a `punctual_pair_question`, matters beside the bodies that it is
    /// asked of; 0 by default.
    ///
    /// Fails with BAD_ARGUMENT if the question is unknown, or the importance infinite or NaN.
    change punctual_scene_set_question_importance(
        scene: punctual_scene, question: u32, importance: f32
    ) = {
        use PairQuestion::{Contacts, Distance, Meet, Motion};
        let question = value_of(question, "question", &[Meet, Distance, Motion, Contacts])?;
        scene.set_question_importance(question, importance)?
    };
}

lists! {
    /// The distances of groups of the last frame.
    rows punctual_scene_group_distances(scene: punctual_scene)
        -> distances: punctual_group_distance, distances_size =
            scene.report().group_distances.iter();
}
