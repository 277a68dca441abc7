//! What else scenes tell: margins, contacts that last, distances, motions until the next frame, and
//! rays.

use crate::body::punctual_body_id;
use crate::budget::{punctual_budget, punctual_clock};
use crate::handle::change;
use crate::motion::punctual_motion;
use crate::outcome::{nanoseconds, punctual_stop_reason};
use crate::rays::{check_mode, punctual_ray, punctual_ray_hit, punctual_ray_query};
use crate::scene::punctual_scene;
use crate::sized::{place, read};
use crate::status::Fault;
use crate::verbs::{calls, inits, lists, types};
use crate::workspace::punctual_triangle_pair;
use ::punctual_scene::{
    BodyContact, BodyHit, ContactPhase, Filter, PairDistance, PairPassage, SceneCast, SceneRay,
};

types! {
    /// What becomes of a contact of two bodies in a frame.
    enum punctual_contact_phase from ContactPhase {
        /// They touched when it was last decided, and this frame has not decided it.
        Undecided = 0,
        /// They are proven to touch in this frame, and were not known to before.
        Began = 1,
        /// They are proven to touch again.
        Persists = 2,
        /// They are proven to be apart, or one was removed, or they may not meet any more, or both
        /// are fixed and their distance is asked for no more.
        Ended = 3,
    }

    /// A contact of two bodies. It begins and ends in frames that prove it; between two of them
    /// bodies may have parted and met again unseen.
    row punctual_body_contact(phase) from (contact: &BodyContact) {
        /// The body of the lower index.
        a: punctual_body_id = contact.a.into(),
        /// The other one.
        b: punctual_body_id = contact.b.into(),
        /// What becomes of it in this frame.
        phase: punctual_contact_phase = contact.phase.into(),
        /// Frames since it began: 0 in the frame in which it did.
        age: u64 = contact.age,
    }

    /// What is known of the distance of two bodies, in the length unit of the scene.
    row punctual_pair_distance(high) from (pair: PairDistance) {
        /// The body of the lower index.
        a: punctual_body_id = pair.a.into(),
        /// The other one.
        b: punctual_body_id = pair.b.into(),
        /// Proven: no point of one surface was closer to the other; 0 if nothing is known.
        low: f64 = pair.low,
        /// Proven: the distance of `triangles`, and 0 only if the surfaces met; infinite if nothing
        /// is known.
        high: f64 = pair.high,
        /// Whether triangles were found; if not, they are zeros.
        has_triangles: bool = pair.triangles.is_some(),
        /// The closest triangles that were found.
        triangles: punctual_triangle_pair = pair.triangles.unwrap_or_default().into(),
        /// Frames since this was proven: 0 if it holds for the bodies where they are in this frame.
        /// As many as there were if nothing is known.
        age: u64 = pair.age,
    }

    /// Until when two bodies are apart, of which one or both move; times from 0, this frame, to 1,
    /// the end of their motions. If their distance is asked for too, that is the one at time 0.
    row punctual_pair_passage(free_until) from (pair: PairPassage) {
        /// The body of the lower index.
        a: punctual_body_id = pair.a.into(),
        /// The other one.
        b: punctual_body_id = pair.b.into(),
        /// Proven: they meet at no time before. 1 without a contact: they are free to the end. 0 if
        /// the budget did not reach the pair.
        free_until: f64 = pair.free_until,
        /// Whether a contact was found (yet); if not, its time and the triangles are zeros.
        touches: bool = pair.touching_at.is_some(),
        /// Proven: they meet at this time.
        touching_at: f64 = pair.touching_at.unwrap_or(0.0),
        /// The triangles that meet then.
        triangles: punctual_triangle_pair = pair.triangles.unwrap_or_default().into(),
    }

    /// The question which body a ray hits. Plain data, made by `punctual_scene_ray_new`.
    asked punctual_scene_ray(ray) {
        /// A `punctual_ray_mode`; RAY_MODE_NEAREST by default.
        mode: u32 = punctual_ray_query::default().mode,
        /// The ray, in the coordinates of the scene.
        ray: punctual_ray = punctual_ray_query::default().ray,
        /// Only bodies that a body of these groups and this mask may meet are asked; all by
        /// default.
        groups: u32 = Filter::default().groups,
        /// See `groups`; all by default.
        mask: u32 = Filter::default().mask,
        /// See `has_body`.
        body: punctual_body_id = punctual_body_id::default(),
        /// Not 0: only other bodies are asked that `body` may meet.
        has_body: u32 = 0,
    }

    /// A triangle of a body that a ray meets.
    plain punctual_body_hit from (hit: Option<BodyHit>) {
        /// The body; zeros without a hit.
        body: punctual_body_id = hit.map_or_else(Default::default, |hit| hit.body.into()),
        /// The triangle, or PUNCTUAL_NO_TRIANGLE, and the parameter of the ray, which is the same
        /// in the scene.
        on_body: punctual_ray_hit = hit.map(|hit| hit.on_body).into(),
    }

    /// Which body a ray hits, wherever the search stopped.
    told punctual_scene_ray_cast(hit) from (cast: SceneCast) {
        /// The nearest hit of those found; for RAY_MODE_ANY the one found.
        hit: punctual_body_hit = cast.hit.into(),
        /// How many triangles were found to be hit; for RAY_MODE_ALL those of
        /// `punctual_scene_ray_hits`.
        found: u64 = cast.found,
        /// Proven: no hit that was not found lies before this parameter. Of a nearest hit that is
        /// known, its own; infinite if nothing is left to be found.
        free_until: f64 = cast.free_until,
        /// Why it returned.
        stop: punctual_stop_reason = cast.stop.into(),
        /// Work done.
        work: u64 = cast.work,
        /// Time of the call in nanoseconds; -1 if it was not measured, which it is only under a
        /// time budget.
        elapsed: i64 = nanoseconds(cast.elapsed),
    }
}

calls! {
    /// Thickens a body by a margin, a length. Its pairs are said to meet when they come within the
    /// sum of their margins.
    ///
    /// Fails with BAD_ARGUMENT if the margin is not from 0 to 2^1000.
    change punctual_scene_set_margin(scene: punctual_scene, id: punctual_body_id, margin: f64) =
        scene.set_margin(id.into(), margin)?;

    /// From the next frame on `punctual_scene_contacts` tells which pairs of bodies begin to touch,
    /// go on, and part. Off by default.
    change punctual_scene_track_contacts(scene: punctual_scene) = scene.track_contacts();

    /// Asks for the distance of two bodies in every frame from now on, wherever they are, if they
    /// may meet by their filters; their margins count. The pair is in the report as well and shares
    /// the budget like any other. A frame is done with it when `high - low` is no more than
    /// `tolerance`, a length. Asked again, it has another tolerance.
    ///
    /// Fails with BAD_ARGUMENT if both bodies are the same, or the tolerance is not from 0 to
    /// 2^1000.
    change punctual_scene_measure(
        scene: punctual_scene, x: punctual_body_id, y: punctual_body_id, tolerance: f64
    ) = scene.measure(x.into(), y.into(), tolerance)?;

    /// Asks for the distance of two bodies no more. Nothing changes if it was not asked for. Fails
    /// with BAD_ARGUMENT if both are the same.
    change punctual_scene_stop_measuring(
        scene: punctual_scene, x: punctual_body_id, y: punctual_body_id
    ) = scene.stop_measuring(x.into(), y.into())?;

    /// Moves a body to where a motion begins, and says where it goes until the next frame, time 1.
    /// It stays so until `punctual_scene_set_pose` or another motion. A pair whose distance is
    /// asked for has both: its distance at time 0, and its time of impact.
    ///
    /// Fails with BAD_POSE or BAD_ARGUMENT if the motion is refused; the body then stays where it
    /// was.
    change punctual_scene_set_motion(
        scene: punctual_scene, id: punctual_body_id, motion: punctual_motion
    ) = scene.set_motion(id.into(), motion.check()?)?;
}

inits! {
    /// The question for the nearest hit of a ray in a scene. Checked when it is cast.
    punctual_scene_ray_init(scene_ray: punctual_scene_ray, ray: punctual_ray) { ray }
}

calls! {
    /// Casts a ray within a budget of its own. `clock` may be null: the clock of the system. Every
    /// body is seen at the pose that was set last, whether there was a frame since or not; those
    /// that changed since are looked at one by one, so cast rays after `punctual_scene_detect`
    /// rather than before it. It allocates only in a scene with more bodies, or for more hits, than
    /// any before.
    ///
    /// Fails with BAD_ARGUMENT if the ray is refused, or has no image in the coordinates of a
    /// body's mesh.
    unsafe fn punctual_scene_cast(
        scene: Option<&mut punctual_scene>, ray: *const punctual_scene_ray, budget: punctual_budget,
        clock: Option<&punctual_clock>, cast: *mut punctual_scene_ray_cast
    ) {
        // SAFETY: the contract of the header for structs and clocks.
        unsafe {
            let (ray, cast) = (read(ray, "ray")?.check()?, place(cast, "cast")?);
            let found = budget.spend(clock, |budget| {
                change(scene, "scene", |scene| Ok(scene.cast(&ray, budget)?))
            })?;
            cast.write(found.into());
        }
        Ok(())
    }
}

impl punctual_scene_ray {
    pub(crate) fn check(&self) -> Result<SceneRay, Fault> {
        let ray = SceneRay::new(self.ray.check("ray->ray", None)?)
            .mode(check_mode(self.mode, "ray->mode")?)
            .filter(Filter::new(self.groups, self.mask));
        Ok(match self.has_body {
            0 => ray,
            _ => ray.of_body(self.body.into()),
        })
    }
}

lists! {
    /// The contacts of the last frame, ascending by index. None unless they are tracked.
    rows punctual_scene_contacts(scene: punctual_scene)
        -> contacts: punctual_body_contact, contacts_size = scene.report().contacts.iter();

    /// The distances of the last frame that are asked for, ascending by index, whether their pairs
    /// had a turn or not.
    rows punctual_scene_distances(scene: punctual_scene)
        -> distances: punctual_pair_distance, distances_size = scene.distances();

    /// Until when the pairs of the last frame are free of which one or both bodies have a motion,
    /// ascending by index. Others, if `unplaced`, `unpaired` and `unlisted` of the report are 0, do
    /// not meet on their way.
    rows punctual_scene_passages(scene: punctual_scene)
        -> passages: punctual_pair_passage, passages_size = scene.passages();

    /// The hits of the last cast, if it was for all hits: of one body after the other, in order of
    /// discovery.
    list punctual_scene_ray_hits(scene: punctual_scene) -> hits: punctual_body_hit =
        scene.ray_hits().iter().map(|&hit| Some(hit));
}
