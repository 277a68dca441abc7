//! Every question about two trees, answered with a hash each.

use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use core::fmt::{Debug, Write};
use punctual::glam::DVec3;
use punctual::{
    Budget, ContactQuery, DistanceQuery, Mode, Motion, MotionQuery, PairMemory, Patches, Pose,
    PushOutQuery, Query, Ray, RayBatch, RayMode, RayQuery, Tree, Workspace,
};

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

/// Every question about two trees.
pub fn ask(answers: &mut Answers, [a, b]: [&Tree; 2], pose: Pose, mut workspace: Workspace) {
    let mut memory = PairMemory::new();
    let any = Query::new(a, b, pose);
    answers.tell("any", any.run(&mut workspace, ENOUGH));
    let all = Query::new(a, b, pose).mode(Mode::All);
    answers.tell("predict", (any.predict(None), all.predict(None)));
    let cut = all.run(&mut workspace, Budget::work(1_500));
    answers.tell("cut", (cut, workspace.pairs()));
    let certificate = all.certificate(&workspace).expect("of this query");
    answers.tell(
        "certificate",
        (
            certificate.upper_bound(),
            certificate.boxes().collect::<Vec<_>>(),
        ),
    );
    answers.tell("estimate", all.estimate(&workspace, None));
    let whole = all.run_with_memory(&mut workspace, &mut memory, ENOUGH);
    answers.tell("all", (whole, workspace.pairs()));
    answers.tell(
        "again",
        any.run_with_memory(&mut workspace, &mut memory, ENOUGH),
    );

    let distance = DistanceQuery::new(a, b, pose);
    answers.tell(
        "distance-cut",
        distance.run(&mut workspace, Budget::work(2_500)),
    );
    answers.tell(
        "distance-estimate",
        (distance.predict(None), distance.estimate(&workspace, None)),
    );
    answers.tell("distance", distance.run(&mut workspace, ENOUGH));

    let contacts = ContactQuery::new(a, b, pose).margin(0.02);
    let found = contacts.run(&mut workspace, ENOUGH);
    answers.tell(
        "contacts",
        (found, workspace.contacts().collect::<Vec<_>>()),
    );
    let mut patches = Patches::new();
    patches.update(a, b, workspace.contacts());
    answers.tell("patches", patches.as_slice());

    let push = PushOutQuery::new(a, b, pose)
        .query_limit(12)
        .run(&mut workspace, Budget::work(300_000));
    answers.tell("push-out", push);

    let start = pose.translation() * 3.0 + DVec3::new(0.1, 0.0, 4.0);
    let start = Pose::new(pose.rotation(), start).expect("the same rotation");
    let velocity = pose.translation() - start.translation();
    let motion = Motion::turning(start, velocity, [0.3, 0.8, -0.4], start.translation())
        .expect("small numbers");
    let query = MotionQuery::new(a, b, motion).tolerance(1e-3);
    answers.tell(
        "motion-cut",
        query.run(&mut workspace, Budget::work(20_000)),
    );
    answers.tell("motion", query.run(&mut workspace, Budget::work(200_000)));

    let place = |i: u32| {
        pose.transform_point(DVec3::new(f64::from(i % 7), f64::from(i % 5), 9.0) * 0.3 - 0.6)
    };
    let rays: Vec<Ray> = (0..40)
        .filter_map(|i| Ray::new(place(i), DVec3::splat(0.07) - place(3 * i)).ok())
        .collect();
    let mut hits = [None; 40];
    let done = RayBatch::new(a, &rays).run(&mut workspace, &mut hits, ENOUGH);
    answers.tell("rays", (done, hits));
    let through = Ray::segment([-5.0, 0.01, 0.02], [5.0, -0.01, 0.03]).expect("two points");
    let cast = RayQuery::new(a, through)
        .mode(RayMode::All)
        .run(&mut workspace, ENOUGH);
    answers.tell("all-hits", (cast, workspace.ray_hits()));
}
