//! Every question about two trees, answered with a hash each.

use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use core::fmt::{Debug, Write};
use punctual::distance::Bounds;
use punctual::glam::DVec3;
use punctual::impact::TimeOfImpact;
use punctual::rays::RayMode;
use punctual::tree::TreeStats;
use punctual::{
    Answer, Budget, Motion, PairMemory, Pose, Query, Ray, Stats, Tree, Verdict, Workspace,
};
use punctual_depenetrate::{PenetrationQuery, PenetrationWorkspace};

const ENOUGH: Budget = Budget::work(1 << 40);

/// FNV-1a. The text of a number tells its bits.
struct Hash(u64);

impl Write for Hash {
    fn write_str(&mut self, text: &str) -> core::fmt::Result {
        self.bytes(text.as_bytes());
        Ok(())
    }
}

impl Hash {
    fn bytes(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}

/// Lines `case question hash`.
pub struct Answers<'c> {
    pub lines: String,
    pub case: &'c str,
}

impl Answers<'_> {
    pub fn tell(&mut self, what: &str, answer: impl Debug) {
        self.tell_bytes(what, format!("{answer:?}").as_bytes());
    }

    pub fn tell_bytes(&mut self, what: &str, bytes: &[u8]) {
        let mut hash = Hash(0xcbf2_9ce4_8422_2325);
        hash.bytes(bytes);
        self.lines += &format!("{} {what} {:016x}\n", self.case, hash.0);
    }
}

/// Statistics without what was added to them since the answers were frozen, and is 0 for surfaces.
pub struct Frozen(pub TreeStats);

impl Debug for Frozen {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&format!("{:?}", self.0).replace(", bytes_solid: 0", ""))
    }
}

/// The counts of a query, without their names, which may change.
fn counts(stats: &Stats) -> impl Debug {
    let tests = [
        stats.bv_tests,
        stats.primitive_tests,
        stats.exact_tests,
        stats.work,
    ];
    (tests, stats.queue_peak)
}

fn outcome(outcome: &Answer<Verdict>) -> impl Debug {
    (
        outcome.value,
        outcome.stop,
        outcome.stats.found,
        counts(&outcome.stats),
    )
}

fn bounds(found: &Answer<Bounds>) -> impl Debug {
    let nearest = found
        .value
        .nearest
        .map(|nearest| (nearest.triangles, nearest.points));
    (
        [found.value.low, found.value.high],
        nearest,
        found.stop,
        counts(&found.stats),
    )
}

fn times(found: &Answer<TimeOfImpact>) -> impl Debug {
    let times = (found.value.lower, found.value.upper, found.value.triangles);
    (times, found.stop, counts(&found.stats))
}

/// Every question about two trees.
pub fn ask(answers: &mut Answers, [a, b]: [&Tree; 2], pose: Pose, mut workspace: Workspace) {
    let mut memory = PairMemory::new();
    let any = Query::intersection(a, b, pose);
    answers.tell("any", outcome(&any.run(&mut workspace, ENOUGH)));
    let all = Query::all_pairs(a, b, pose);
    answers.tell("predict", (any.predict(None), all.predict(None)));
    let cut = all.run(&mut workspace, Budget::work(1_500));
    answers.tell("cut", (outcome(&cut), workspace.pairs()));
    let certificate = all.certificate(&workspace).expect("of this query");
    answers.tell(
        "certificate",
        (
            certificate.upper_bound(),
            certificate.boxes().collect::<Vec<_>>(),
        ),
    );
    answers.tell("estimate", all.estimate(&workspace, None));
    let whole = all.with_memory(&mut memory).run(&mut workspace, ENOUGH);
    answers.tell("all", (outcome(&whole), workspace.pairs()));
    answers.tell(
        "again",
        outcome(&any.with_memory(&mut memory).run(&mut workspace, ENOUGH)),
    );

    let distance = Query::distance(a, b, pose);
    answers.tell(
        "distance-cut",
        bounds(&distance.run(&mut workspace, Budget::work(2_500))),
    );
    answers.tell(
        "distance-estimate",
        (distance.predict(None), distance.estimate(&workspace, None)),
    );
    answers.tell("distance", bounds(&distance.run(&mut workspace, ENOUGH)));

    let contacts = Query::contacts(a, b, pose).margin(0.02);
    let found = contacts.run(&mut workspace, ENOUGH);
    answers.tell(
        "contacts",
        (
            (
                found.value.low,
                found.stats.found,
                found.stop,
                counts(&found.stats),
            ),
            workspace.contacts().collect::<Vec<_>>(),
        ),
    );

    let mut penetration = PenetrationWorkspace::with_engine(workspace.clone());
    for (name, push_only) in [("push-out", true), ("penetration", false)] {
        let query = PenetrationQuery::new(a, b, pose).push_only(push_only);
        let found = query.run(&mut penetration, Budget::work(300_000));
        let told = (found.value, found.stop, counts(&found.stats));
        answers.tell(name, told);
    }

    let start = pose.translation() * 3.0 + DVec3::new(0.1, 0.0, 4.0);
    let start = Pose::new(pose.rotation(), start).expect("the same rotation");
    let velocity = pose.translation() - start.translation();
    let motion = Motion::turning(start, velocity, [0.3, 0.8, -0.4], start.translation())
        .expect("small numbers");
    let query = Query::impact(a, b, motion).tolerance(1e-3);
    answers.tell(
        "motion-cut",
        times(&query.run(&mut workspace, Budget::work(20_000))),
    );
    answers.tell(
        "motion",
        times(&query.run(&mut workspace, Budget::work(200_000))),
    );

    let place = |i: u32| {
        pose.transform_point(DVec3::new(f64::from(i % 7), f64::from(i % 5), 9.0) * 0.3 - 0.6)
    };
    let rays: Vec<Ray> = (0..40)
        .filter_map(|i| Ray::new(place(i), DVec3::splat(0.07) - place(3 * i)).ok())
        .collect();
    let done = Query::rays(a, &rays).run(&mut workspace, ENOUGH);
    let hits = workspace.first_hits();
    answers.tell("rays", ((done.value, done.stop, counts(&done.stats)), hits));
    let through = Ray::segment([-5.0, 0.01, 0.02], [5.0, -0.01, 0.03]).expect("two points");
    let cast = Query::ray(a, through)
        .mode(RayMode::All)
        .run(&mut workspace, ENOUGH);
    let told = (
        cast.value.hit,
        cast.stats.found,
        cast.value.free_until,
        cast.stop,
    );
    answers.tell(
        "all-hits",
        (told, counts(&cast.stats), workspace.ray_hits()),
    );
}
