//! Scenes: many bodies, one budget a frame.

use crate::arrays::{array, find_room};
use crate::body::{punctual_body, punctual_body_id};
use crate::budget::{punctual_budget, punctual_clock};
use crate::handle::{change, get};
use crate::outcome::{nanoseconds, punctual_verdict, verdict};
use crate::pose::punctual_pose;
use crate::query::check_mode;
use crate::sized::{fill_rows, place, read};
use crate::status::{Fault, given, value_of};
use crate::tree::punctual_tree;
use crate::verbs::{calls, handles, lists, types};
use crate::workspace::punctual_triangle_pair;
use ::punctual_scene::{Filter, PairCertificate, PairReport, Reach, Report, Scene};
use core::mem::MaybeUninit;
use punctual::clock::ClockedBudget;
use std::sync::Arc;

handles! {
    /// Bodies that move, and the question which of them meet. One thread at a time may use it; it
    /// may start threads of its own.
    punctual_scene(Scene);

    /// Frees a scene and ends its threads; null is fine.
    punctual_scene_free(scene);
}

/// A slip of the caller's must not take all threads of the machine.
const MAX_THREADS: usize = 1024;

types! {
    /// Which boxes the broad phase compares.
    enum punctual_reach {
        /// Those around the bodies where they are: pairs that are not reported do not meet.
        Here = 0,
        /// Swept boxes: each covers a body's motion since the previous frame, at a constant
        /// velocity and turn between its two poses. Pairs that may have met in between are reported
        /// as well, with what is true of them here.
        Swept = 1,
    }

    /// What is known about two bodies whose boxes overlap.
    row punctual_pair_report(witness) from (pair: &PairReport) {
        /// The body of the lower index: A of the pair.
        a: punctual_body_id = pair.a.into(),
        /// The other one.
        b: punctual_body_id = pair.b.into(),
        /// Whether their surfaces meet, in this frame.
        verdict: punctual_verdict = verdict(pair.verdict).0,
        /// Whether nothing is left to find, of its distance and its time of impact too, if they are
        /// asked for. Undecided all the same if rounding hides whether bodies with margins meet, or
        /// bodies in motion at its start.
        complete: bool = pair.complete,
        /// If they meet, two triangles that do; if they come within their margins, two that do;
        /// else zeros.
        witness: punctual_triangle_pair = verdict(pair.verdict).1,
        /// How far apart the witness is at most, in the length unit of the scene, margins not
        /// subtracted: 0 if they intersect, above 0 and no more than the margins if they come
        /// within them, and infinite without a witness.
        witness_distance: f64 = pair.verdict.witness_distance().unwrap_or(f64::INFINITY),
        /// Intersecting pairs of triangles found; at most 1 for MODE_ANY, and of bodies with
        /// margins, whose witness counts.
        found: u64 = pair.found,
        /// Probability that the surfaces meet, 0 to 1; 0 or 1 if that is decided, 0.5 if the pair
        /// is complete all the same.
        probability: f64 = pair.probability,
        /// Expected share of the intersecting pairs of triangles that was found: 1 if complete, 0
        /// if nothing was found, and between them otherwise.
        recall: f64 = pair.recall,
        /// Frames since it was decided: 0 if it was in this one.
        age: u64 = pair.age,
    }
}

types! {
    /// What a frame found. If `unplaced`, `unpaired` and `unlisted` are 0, bodies that are not in
    /// `pairs` together, and may meet, do not: their boxes are apart. Otherwise the budget ended in
    /// the broad phase, which goes on in the next frame.
    told punctual_report(frame) from (report: &Report) {
        /// Frames so far, this one included.
        frame: u64 = report.frame,
        /// How many pairs `punctual_scene_pairs` has.
        pair_count: usize = report.pairs.len(),
        /// How many of them are decided in this frame; the others are undecided.
        decided: usize = report.decided,
        /// How many of them are proven to intersect.
        intersecting: usize = report.intersecting,
        /// How many of them are proven to come within their margins; not among the intersecting
        /// ones.
        within: usize = report.within,
        /// How many of them are complete.
        complete: usize = report.complete,
        /// The largest age of a pair.
        worst_age: u64 = report.worst_age,
        /// Bodies that changed or were removed and whose boxes are not up to date: the next frames
        /// place them.
        unplaced: usize = report.unplaced,
        /// Bodies that not all partners are known of: they moved on or were removed, and the search
        /// for pairs is not at its end.
        unpaired: usize = report.unpaired,
        /// Known pairs that were not looked at. They are not in `pairs`, and are undecided.
        unlisted: usize = report.unlisted,
        /// Whether pairs were left out because there are as many as a scene keeps, 1,048,576.
        is_full: bool = report.is_full,
        /// Work of the queries, and 250 units for each that was begun.
        work: u64 = report.work,
        /// Work of the broad phase: placing bodies, finding pairs and listing them.
        broad_phase_work: u64 = report.broad_phase_work,
        /// BV tests of the queries.
        bv_tests: u64 = report.bv_tests,
        /// Time of the frame in nanoseconds; -1 if it was not measured, which it is only under a
        /// time budget.
        elapsed: i64 = nanoseconds(report.elapsed),
    }

    /// What is not known about a pair.
    told punctual_pair_certificate(upper_bound) {
        /// No more triangle pairs than this intersect.
        upper_bound: u64,
        /// Each intersection that was not found lies in a box no longer than this, in the length
        /// unit of the scene.
        largest_extent: f64,
    }
}

fn check_reach(reach: u32) -> Result<Reach, Fault> {
    value_of(reach, "reach", &[Reach::Here, Reach::Swept])
}

calls! {
    /// Makes a scene without bodies. `mode` is a `punctual_mode` (any intersection of each pair, or
    /// the number of all), `reach` a `punctual_reach`.
    ///
    /// Fails with BAD_ARGUMENT if one of them is unknown.
    make punctual_scene_new(mode: u32, reach: u32) -> scene: punctual_scene = {
        let (mode, reach) = (check_mode(mode, "mode")?, check_reach(reach)?);
        let mut scene = Scene::new();
        scene.set_mode(mode);
        scene.set_reach(reach);
        scene
    };

    /// Asks from the next frame on for any intersection of each pair, or for the number of all, by
    /// a `punctual_mode`. What earlier frames found does not answer another question.
    ///
    /// Fails with BAD_ARGUMENT if it is unknown.
    change punctual_scene_set_mode(scene: punctual_scene, mode: u32) =
        scene.set_mode(check_mode(mode, "mode")?);

    /// Says which boxes the broad phase compares from the next frame on, by a `punctual_reach`.
    ///
    /// Fails with BAD_ARGUMENT if it is unknown.
    change punctual_scene_set_reach(scene: punctual_scene, reach: u32) =
        scene.set_reach(check_reach(reach)?);

    /// Keeps no more than so many pairs of near bodies; by default, and at most, 1,048,576. A pair
    /// takes 88 bytes, and about 430 more from its first turn on. Pairs beyond that are left out,
    /// and `is_full` of the report says so, until an eighth of the room is free again. Those that
    /// are kept already stay.
    change punctual_scene_set_max_pairs(scene: punctual_scene, pairs: usize) =
        scene.set_max_pairs(pairs);
}

calls! {
    /// Shares the work of `punctual_scene_detect` among `threads` threads, the caller's included.
    /// They wait between frames.
    ///
    /// Fails with BAD_ARGUMENT if they are more than 1024, with NO_THREAD if the operating system
    /// gives none; the scene then has those that it had.
    change punctual_scene_use_threads(scene: punctual_scene, threads: usize) = {
        if threads > MAX_THREADS {
            return Err(Fault::TooMany("threads", threads, MAX_THREADS));
        }
        scene.use_threads(threads)?
    };

    /// Makes room for this many bodies, and for this many pairs of them whose boxes overlap or
    /// nearly do. Within this room `punctual_scene_detect` does not allocate. Takes about 860 bytes
    /// a body and 960 a pair.
    ///
    /// Fails with OUT_OF_MEMORY if there is not so much; the scene has the room that it had then.
    change punctual_scene_reserve(scene: punctual_scene, bodies: usize, pairs: usize) = {
        find_room([(bodies, 2000), (pairs, 2000)])?; // more than it takes
        scene.reserve(bodies, pairs)
    };

    /// Puts a body into the scene.
    ///
    /// Fails with BAD_POSE if its pose is refused (a scene allows a little less than a query),
    /// BAD_ARGUMENT if its kind is unknown or its importance NaN.
    unsafe fn punctual_scene_insert(
        scene: Option<&mut punctual_scene>, body: *const punctual_body<'_>,
        id: Option<&mut MaybeUninit<punctual_body_id>>
    ) {
        // SAFETY: the contract of the header for structs.
        let body = unsafe { read(body, "body") }?.check()?;
        let id = given(id, "id")?;
        id.write(change(scene, "scene", |scene| Ok(scene.insert(body)?))?.into());
        Ok(())
    }

    /// Takes a body out of the scene. As for all that follows, fails with NO_SUCH_BODY if it is not
    /// in it.
    change punctual_scene_remove(scene: punctual_scene, id: punctual_body_id) =
        scene.remove(id.into())?;

    /// A body as it is now, but for `tree`, which is null: see `punctual_scene_tree`.
    unsafe fn punctual_scene_body(
        scene: Option<&punctual_scene>, id: punctual_body_id, body: *mut punctual_body<'_>
    ) {
        // SAFETY: the contract of the header for structs.
        let body = unsafe { place(body, "body") }?;
        body.write(get(scene, "scene")?.body(id.into())?.into());
        Ok(())
    }

    /// A new handle to the tree of a body, shared with the scene: the caller's, to be freed.
    make punctual_scene_tree(scene: Option<&punctual_scene>, id: punctual_body_id)
        -> tree: punctual_tree = Arc::clone(&get(scene, "scene")?.body(id.into())?.tree);

    /// Moves a body. Setting the pose that it already has is a no-op.
    ///
    /// Fails with BAD_POSE if the pose is refused; the body then stays where it was.
    change punctual_scene_set_pose(
        scene: punctual_scene, id: punctual_body_id, pose: punctual_pose
    ) = scene.set_pose(id.into(), pose.check()?)?;

    /// Gives a body another tree.
    change punctual_scene_set_tree(
        scene: punctual_scene, id: punctual_body_id, tree: Option<&punctual_tree>
    ) = scene.set_tree(id.into(), Arc::clone(get(tree, "tree")?))?;

    /// Moves the vertices of a body's mesh, as `punctual_tree_refit_f32`. If handles or other
    /// bodies share its tree, the body gets one of its own first.
    ///
    /// Fails with BAD_MESH if their number is another or a coordinate in use is not finite; the
    /// shape is unchanged then.
    unsafe fn punctual_scene_refit_f32(
        scene: Option<&mut punctual_scene>, id: punctual_body_id, vertices: *const f32,
        vertex_count: usize
    ) {
        // SAFETY: the contract of the header for arrays.
        let vertices = unsafe { array(vertices.cast::<[f32; 3]>(), vertex_count, "vertices") }?;
        change(scene, "scene", |scene| Ok(scene.tree_mut(id.into())?.refit(vertices)?))
    }

    /// Like `punctual_scene_refit_f32`.
    unsafe fn punctual_scene_refit_f64(
        scene: Option<&mut punctual_scene>, id: punctual_body_id, vertices: *const f64,
        vertex_count: usize
    ) {
        // SAFETY: the contract of the header for arrays.
        let vertices = unsafe { array(vertices.cast::<[f64; 3]>(), vertex_count, "vertices") }?;
        change(scene, "scene", |scene| Ok(scene.tree_mut(id.into())?.refit_f64(vertices)?))
    }

    /// Says whom a body may meet: `x` and `y` if `x.groups & y.mask` and `y.groups & x.mask` both
    /// have a bit set.
    change punctual_scene_set_filter(
        scene: punctual_scene, id: punctual_body_id, groups: u32, mask: u32
    ) = scene.set_filter(id.into(), Filter::new(groups, mask))?;

    /// Says how much the pairs of a body matter.
    ///
    /// Fails with BAD_ARGUMENT if the importance is NaN.
    change punctual_scene_set_importance(
        scene: punctual_scene, id: punctual_body_id, importance: f32
    ) = scene.set_importance(id.into(), importance)?;

    /// Finds out which bodies meet, within a budget for the whole frame. `clock` may be null: the
    /// clock of the system; with one of the caller's, all is done on the calling thread. `report`
    /// may be null.
    ///
    /// Under a time budget it ends in time as long as the broad phase alone does; under a work
    /// budget, which does not count the broad phase, it gives the same report on any number of
    /// threads. It allocates only as the scene grows: in a frame with more bodies, or with more
    /// pairs of overlapping boxes, than any before it, and in the 64 frames after it had more
    /// bodies than ever.
    unsafe fn punctual_scene_detect(
        scene: Option<&mut punctual_scene>, budget: punctual_budget, clock: Option<&punctual_clock>,
        report: *mut punctual_report
    ) {
        let report = match report.is_null() {
            true => None,
            // SAFETY: the contract of the header for structs.
            false => Some(unsafe { place(report, "report") }?),
        };
        let detect = |budget: ClockedBudget<'_>| change(scene, "scene", |scene| {
            let found = scene.detect(budget);
            if let Some(report) = report {
                report.write(found.into());
            }
            Ok(())
        });
        // SAFETY: that for clocks.
        unsafe { budget.spend(clock, detect) }
    }

    /// What the last frame found.
    unsafe fn punctual_scene_report(scene: Option<&punctual_scene>, report: *mut punctual_report) {
        let scene = get(scene, "scene")?;
        // SAFETY: the contract of the header for structs.
        unsafe { place(report, "report") }?.write(scene.report().into());
        Ok(())
    }

    /// What the last frame found about two bodies, by binary search. `listed` says whether it has
    /// the pair; if not, `pair` is left alone.
    unsafe fn punctual_scene_pair(
        scene: Option<&punctual_scene>, x: punctual_body_id, y: punctual_body_id,
        pair: *mut punctual_pair_report, pair_size: usize, listed: Option<&mut MaybeUninit<bool>>
    ) {
        let scene = get(scene, "scene")?;
        if pair.is_null() {
            return Err(Fault::Null("pair"));
        }
        let listed = given(listed, "listed")?;
        scene.body(x.into())?;
        scene.body(y.into())?;
        let found = scene.report().pair(x.into(), y.into());
        // SAFETY: the contract of the header for structs.
        let written = unsafe { fill_rows(pair, pair_size, 1, "pair", found.into_iter()) }?;
        listed.write(written == 1);
        Ok(())
    }

    /// Whether the last frame knew all bodies that this one may meet: it was placed where it is,
    /// and the search for its partners came to its end. Of two such bodies that may meet and are
    /// not in `punctual_scene_pairs` together the boxes are apart if `unlisted` of the report is 0.
    fn punctual_scene_partners_known(
        scene: Option<&punctual_scene>, id: punctual_body_id, known: Option<&mut MaybeUninit<bool>>
    ) {
        let (scene, known) = (get(scene, "scene")?, given(known, "known")?);
        known.write(scene.partners_known(id.into())?);
        Ok(())
    }

    /// What the last frame left open about two bodies. Takes time linear in what is open. Fails
    /// with BAD_ARGUMENT if both are the same.
    unsafe fn punctual_scene_certificate(
        scene: Option<&punctual_scene>, x: punctual_body_id, y: punctual_body_id,
        certificate: *mut punctual_pair_certificate
    ) {
        let scene = get(scene, "scene")?;
        // SAFETY: the contract of the header for structs.
        let certificate = unsafe { place(certificate, "certificate") }?;
        let PairCertificate {
            upper_bound,
            largest_extent,
            ..
        } = scene.certificate(x.into(), y.into())?;
        let size = punctual_pair_certificate::SIZE;
        certificate.write(punctual_pair_certificate {
            size,
            upper_bound,
            largest_extent,
        });
        Ok(())
    }
}

lists! {
    /// The ids of all bodies, by index.
    list punctual_scene_bodies(scene: punctual_scene) -> ids: punctual_body_id =
        scene.bodies().map(|(id, _)| id);

    /// The pairs of the last frame: all that may meet and whose boxes overlap, or whose distance is
    /// asked for, ascending by index, as far as they are known and listed.
    rows punctual_scene_pairs(scene: punctual_scene) -> pairs: punctual_pair_report, pairs_size =
        scene.report().pairs.iter();
}
