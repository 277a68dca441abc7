//! The search for a short push: one direction after another, and for each the least length that
//! separates the surfaces.
//!
//! A direction is searched only if a push along it that is shorter than the best so far separates
//! the surfaces. Then its length is bisected. The pool of [`blocked`](super::blocked) translations
//! saves queries whose answer is known. In the end the best direction is varied. The budget decides
//! only where the search stops, not what it does before, so more budget of work never gives a
//! longer push.

use super::blocked::{Pool, ROOM, WORK_PER_ADDED, unit};
use super::directions::{Segments, WORK_PER_SEGMENT, all_around};
use super::{Push, PushOutQuery};
use arrayvec::ArrayVec;
use glam::DVec3;
use punctual::engine::Deadline;
use punctual::intersection::Intersection;
use punctual::{PairMemory, Query, StopReason, Tree, Verdict, Workspace};
use punctual_geom::{Aabb, Pose};

/// Maximum number of contacts searched for; of these, how many have their segments computed, and
/// how many start the pool.
const CONTACTS: usize = 1024;
const SEGMENTS: usize = 128;
const BLOCKED: usize = ROOM / 2;

/// The first push is at most this many times as long as the length known to be blocked.
const FIRST: f64 = 3.0;

/// A push that is too short is lengthened by this factor, which itself grows by the next factor
/// each time.
const GROWTH: f64 = 1.6;
const GROWTH_OF_GROWTH: f64 = 1.25;

/// A push in another direction must be shorter by this factor, and one in a variation of the best
/// direction by the next.
const SHORTER: f64 = 0.97;
const SHORTER_BESIDE: f64 = 0.98;

/// A bisected length is accepted if the surfaces are separated also after a push this many times as
/// long.
const BEYOND: f64 = 1.02;

/// Relative tolerances of the bisection, and of the last one.
const TOLERANCE: f64 = 0.05;
const LAST_TOLERANCE: f64 = 0.005;

/// Smallest and first angle by which the best direction is varied, radians.
const LEAST_TURN: f64 = 0.01;
const TURN: f64 = 0.3;

/// The least push, relative to the extent of the smaller mesh, and relative to the largest
/// coordinate.
const LEAST_PUSH: f64 = 1e-9;
const LEAST_STEP: f64 = 16.0 * f64::EPSILON;

/// The error is the reason why the search ends.
type Step<T> = Result<T, StopReason>;

pub(super) struct Search<'q, 'c> {
    asked: &'q PushOutQuery<'q>,
    workspace: &'q mut Workspace,
    deadline: &'q mut Deadline<'c>,
    memory: PairMemory,
    blocked: Pool,
    /// Boxes around A and B, in A's frame.
    boxes: [Aabb; 2],
    /// The longest extent of the larger box.
    size: f64,
    /// The least length of a push.
    least: f64,
    pub best: Option<Push>,
    pub queries: u32,
    pub work: u64,
}

impl<'q, 'c> Search<'q, 'c> {
    pub fn new(
        asked: &'q PushOutQuery<'q>,
        workspace: &'q mut Workspace,
        deadline: &'q mut Deadline<'c>,
    ) -> Self {
        let boxes = [asked.a.mesh().aabb(), box_in_a(asked.b, &asked.b_in_a)];
        let [x, y] = boxes.map(|aabb| aabb.extents().max_element());
        let (size, smaller) = (
            x.max(y).max(f64::MIN_POSITIVE),
            if x == 0.0 || y == 0.0 {
                x.max(y)
            } else {
                x.min(y)
            },
        );
        let largest = boxes
            .iter()
            .map(|aabb| aabb.min.abs().max(aabb.max.abs()).max_element())
            .fold(0.0, f64::max);
        let least = (LEAST_PUSH * smaller)
            .max(LEAST_STEP * largest)
            .max(f64::MIN_POSITIVE);
        let (memory, blocked) = (PairMemory::without_clearance(), Pool::default());
        Self {
            asked,
            workspace,
            deadline,
            memory,
            blocked,
            boxes,
            size,
            least,
            best: None,
            queries: 0,
            work: 0,
        }
    }

    pub fn run(&mut self) -> Step<()> {
        let Some(segments) = self.contacts()? else {
            return Ok(());
        };
        let likely = segments.directions();
        for &direction in &likely {
            self.explore(direction, segments.extent(direction), SHORTER)?;
        }
        // Normals are unreliable on meshes that are inside out or open, so the opposite directions
        // are tried too.
        let others = likely
            .into_iter()
            .map(|direction| -direction)
            .chain(all_around());
        let mut others: ArrayVec<_, 46> = others.map(|direction| (0.0, direction)).collect();
        let enough = self
            .best
            .map_or(f64::INFINITY, |best| best.distance * SHORTER);
        for (blocked, direction) in &mut others {
            *blocked = self.free_from(*direction, self.least, enough)?;
        }
        let order = |d: &DVec3, e: &DVec3| {
            d.x.total_cmp(&e.x)
                .then(d.y.total_cmp(&e.y))
                .then(d.z.total_cmp(&e.z))
        };
        others.sort_unstable_by(|(p, d), (q, e)| p.total_cmp(q).then(order(d, e)));
        for (_, direction) in others {
            self.explore(direction, self.least, SHORTER)?;
        }
        self.refine()?;
        let Some(Push {
            direction,
            distance,
            ..
        }) = self.best
        else {
            return Ok(());
        };
        let low = self.free_from(direction, self.least, f64::INFINITY)?;
        self.shorten(direction, [low, distance], LAST_TOLERANCE)
    }

    /// Sums over the segments of the contacts; `None` if the surfaces do not intersect.
    fn contacts(&mut self) -> Step<Option<Segments>> {
        let PushOutQuery { a, b, b_in_a, .. } = *self.asked;
        let query = Query::all_pairs(a, b, b_in_a)
            .surfaces()
            .pair_limit(CONTACTS);
        let Some([x, _]) = self.witness(&query, false)? else {
            self.best = Some(Push {
                direction: DVec3::X,
                distance: 0.0,
                b_in_a,
            });
            return Ok(None);
        };
        let mut segments = Segments::new(a.mesh().triangle(x as usize)[0], self.size);
        let found = self.workspace.pairs().len();
        let [step, blocked_step] = [SEGMENTS, BLOCKED].map(|most| found.div_ceil(most).max(1));
        for i in 0..found {
            let pair = self.workspace.pairs()[i];
            if i % step == 0 {
                self.pay(WORK_PER_SEGMENT)?;
                let [of_a, of_b] = self.corners(pair);
                segments.add(&of_a, &of_b);
            }
            if i % blocked_step == 0 {
                self.block(pair)?;
            }
        }
        Ok(Some(segments))
    }

    /// Finds the least push in a direction, if it is shorter than `share` times the best or there
    /// is no best yet. `guess` is its approximate length.
    fn explore(&mut self, direction: DVec3, guess: f64, share: f64) -> Step<()> {
        let Some(Push { distance, .. }) = self.best else {
            return self.explore_first(direction, guess);
        };
        let high = distance * share;
        let low = self.free_from(direction, self.least, high)?;
        if low < high && self.parts(direction, high)? {
            self.accept(direction, high);
            self.shorten(direction, [low, high], TOLERANCE)?;
        }
        Ok(())
    }

    /// Lengthens a push until the surfaces are separated.
    fn explore_first(&mut self, direction: DVec3, guess: f64) -> Step<()> {
        // At this length the boxes are apart.
        let longest = 1.001 * self.parting_length(direction) + self.least;
        let mut low = self.free_from(direction, self.least, f64::INFINITY)?;
        let mut length = (1.1 * low).max(guess.min(FIRST * low)).min(longest);
        let mut growth = GROWTH;
        while !self.parts(direction, length)? {
            if length >= longest {
                return Ok(());
            }
            low = self.free_from(direction, length, f64::INFINITY)?;
            length = (growth * length).max(1.05 * low).min(longest);
            growth *= GROWTH_OF_GROWTH;
        }
        self.accept(direction, length);
        self.shorten(direction, [low, length], TOLERANCE)
    }

    /// Bisects the length of a push between one that intersects and one that separates. If the gap
    /// found is too narrow, it continues beyond the gap.
    fn shorten(
        &mut self,
        direction: DVec3,
        [mut low, apart]: [f64; 2],
        tolerance: f64,
    ) -> Step<()> {
        loop {
            let mut high = apart;
            while high - low > tolerance * high {
                let middle = if low < high / 16.0 {
                    libm::sqrt(low) * libm::sqrt(high)
                } else {
                    0.5 * (low + high)
                };
                if self.parts(direction, middle)? {
                    high = middle;
                } else {
                    low = self.free_from(direction, middle, high)?;
                }
            }
            if high >= apart {
                return Ok(());
            }
            if self.parts(direction, BEYOND * high)? {
                self.accept(direction, high);
                return Ok(());
            }
            low = self.free_from(direction, BEYOND * high, apart)?;
        }
    }

    /// Varies the best direction by smaller and smaller angles.
    fn refine(&mut self) -> Step<()> {
        let mut turn = TURN;
        while let Some(best) = self.best
            && turn > LEAST_TURN
        {
            let u = best.direction.any_orthonormal_vector();
            let w = best.direction.cross(u);
            for side in [u, -u, w, -w, u + w, -u - w] {
                self.explore(
                    unit(best.direction + unit(side) * turn),
                    self.least,
                    SHORTER_BESIDE,
                )?;
            }
            if self.best == Some(best) {
                turn *= 0.5;
            }
        }
        Ok(())
    }

    /// Accepts a push that is known to separate the surfaces.
    fn accept(&mut self, direction: DVec3, distance: f64) {
        let push = self.pushed(direction, distance).map(|b_in_a| Push {
            direction,
            distance,
            b_in_a,
        });
        self.best = push.or(self.best);
    }

    fn pushed(&self, direction: DVec3, distance: f64) -> Option<Pose> {
        let pose = &self.asked.b_in_a;
        Pose::new(pose.rotation(), pose.translation() + direction * distance).ok()
    }

    /// True if the surfaces are proven separated after a push; false also if the push leads out of
    /// the range of poses.
    fn parts(&mut self, direction: DVec3, distance: f64) -> Step<bool> {
        let Some(pose) = self.pushed(direction, distance) else {
            return Ok(false);
        };
        let witness = self.witness(
            &Query::intersection(self.asked.a, self.asked.b, pose).surfaces(),
            true,
        )?;
        if let Some(pair) = witness {
            self.block(pair)?;
        }
        Ok(witness.is_none())
    }

    /// Two triangles that intersect, by an exact query; `None` proves that there are none.
    fn witness(&mut self, query: &Query<Intersection>, complete: bool) -> Step<Option<[u32; 2]>> {
        if self.queries >= self.asked.query_limit {
            return Err(StopReason::Finished);
        }
        self.queries += 1;
        query.begin_task(complete, 0, self.workspace, Some(&self.memory));
        let stop = query.search(self.workspace, Some(&mut self.memory), self.deadline);
        self.work += self.workspace.work();
        match self.workspace.verdict(stop) {
            Verdict::Undecided => Err(stop),
            verdict => Ok(verdict.witness()),
        }
    }

    fn block(&mut self, pair: [u32; 2]) -> Step<()> {
        self.pay(WORK_PER_ADDED)?;
        let [of_a, of_b] = self.corners(pair);
        self.blocked.add(&of_a, &of_b);
        Ok(())
    }

    /// [`Pool::free_from`], with its work charged to the budget.
    fn free_from(&mut self, direction: DVec3, from: f64, enough: f64) -> Step<f64> {
        self.need_room(self.blocked.work())?;
        let (length, work) = self.blocked.free_from(direction, from, enough);
        self.spend(work);
        Ok(length)
    }

    /// An error if there is no room for work outside of queries.
    fn need_room(&mut self, work: u64) -> Step<()> {
        if self.deadline.has_room(work) {
            Ok(())
        } else {
            Err(self.deadline.why(work))
        }
    }

    fn pay(&mut self, work: u64) -> Step<()> {
        self.need_room(work)?;
        self.spend(work);
        Ok(())
    }

    fn spend(&mut self, work: u64) {
        self.deadline.spend(work);
        self.work += work;
    }

    /// The corners of a triangle of A and of one of B, in A's frame, before the push.
    fn corners(&self, [x, y]: [u32; 2]) -> [[DVec3; 3]; 2] {
        let PushOutQuery { a, b, b_in_a, .. } = self.asked;
        [
            a.mesh().triangle(x as usize),
            b.mesh()
                .triangle(y as usize)
                .map(|p| b_in_a.transform_point(p)),
        ]
    }

    /// Length of a push after which the boxes are apart, up to rounding.
    fn parting_length(&self, direction: DVec3) -> f64 {
        let farthest =
            |aabb: &Aabb, d: DVec3| DVec3::select(d.cmpgt(DVec3::ZERO), aabb.max, aabb.min).dot(d);
        farthest(&self.boxes[0], direction) + farthest(&self.boxes[1], -direction)
    }
}

/// A box in A's frame around the mesh of B.
fn box_in_a(b: &Tree, b_in_a: &Pose) -> Aabb {
    let Aabb { min, max, .. } = b.mesh().aabb();
    let corner = |i: usize| {
        DVec3::from_array(core::array::from_fn(|k| {
            if i >> k & 1 == 0 { min[k] } else { max[k] }
        }))
    };
    Aabb::from_points((0..8).map(|i| b_in_a.transform_point(corner(i))))
}
