//! Distance queries against the exact distance of all pairs of triangles. A file that uses this has `exact_distance.rs` and
//! `reference.rs` beside it.
#![allow(
    dead_code,
    unused_imports,
    reason = "each test file is a crate of its own and uses a part"
)]

use std::cmp::Ordering;
use std::collections::HashMap;

use punctual::distance::{Bounds, Distance, Nearest};
use punctual::glam::DVec3;
use punctual::{Aabb, Answer, Budget, Pose, Query, StopReason, Tree};

pub use super::common::ask::{answer, resume, run, run_with_memory};
use super::exact_distance;
use super::reference::posed_triangles;

type Triangle = [DVec3; 3];

/// More than any query of these tests needs: one that does not end fails.
pub const ENOUGH: Budget = Budget::work(1_000_000_000);

/// What a query asks, besides trees and pose.
#[derive(Clone, Copy, Debug, Default)]
pub struct Question {
    /// The default tolerance if `None`.
    pub absolute: Option<f64>,
    pub relative: f64,
    pub margins: [f64; 2],
    pub closer_than: Option<f64>,
    /// Whether it may be left open if surfaces meet that are within the absolute tolerance.
    pub contact_open: bool,
}

impl Question {
    pub const EXACT: Self = Self {
        absolute: Some(0.0),
        relative: 0.0,
        margins: [0.0; 2],
        closer_than: None,
        contact_open: false,
    };

    pub fn closer_than(limit: f64) -> Self {
        Self {
            closer_than: Some(limit),
            ..Self::default()
        }
    }

    pub fn query<'t>(&self, a: &'t Tree, b: &'t Tree, pose: Pose) -> Query<'t, Distance> {
        let query = Query::distance(a, b, pose)
            .relative_tolerance(self.relative)
            .margins(self.margins);
        let query = query.leave_contact_open(self.contact_open);
        let query = self
            .absolute
            .map_or(query, |length| query.absolute_tolerance(length));
        self.closer_than
            .map_or(query, |limit| query.closer_than(limit))
    }
}

/// All that is true of the distance of two meshes at a pose.
pub struct Truth {
    a: Vec<Triangle>,
    b: Vec<Triangle>,
    exact: exact_distance::Distance,
    /// Distances of other pairs that were asked for.
    known: HashMap<[u32; 2], exact_distance::Distance>,
    /// Extents of both meshes and their distance together: what bounds are rounded to.
    size: f64,
    /// The largest coordinate: what points are rounded to.
    reach: f64,
    /// The tolerance of a query that asks for none.
    tolerance: f64,
}

impl Truth {
    /// Brute force over all pairs, the least gap of boxes first, until that is more than the least distance found. Neither
    /// mesh may be empty.
    pub fn new(a: &Tree, b: &Tree, pose: &Pose) -> Self {
        let tolerance = 1e-6 * a.unit_length().max(b.unit_length());
        let (a, b) = (
            posed_triangles(a.mesh(), &Pose::IDENTITY),
            posed_triangles(b.mesh(), pose),
        );
        let boxes = [&a, &b].map(|triangles| {
            triangles
                .iter()
                .map(|t| Aabb::from_points(*t))
                .collect::<Vec<_>>()
        });
        let all = (0..a.len()).flat_map(|i| (0..b.len()).map(move |j| [i, j]));
        let mut pairs: Vec<_> = all
            .map(|[i, j]| (least_gap(&boxes[0][i], &boxes[1][j]), [i, j]))
            .collect();
        pairs.sort_by(|(gap, _), (other, _)| gap.total_cmp(other));
        let of = |[i, j]: [usize; 2]| exact_distance::Distance::of(&a[i], &b[j]);
        let mut exact = of(pairs[0].1);
        for &(gap, pair) in &pairs[1..] {
            if exact.is_zero() || exact.order_of(gap) == Ordering::Greater {
                break;
            }
            let other = of(pair);
            exact = if other.is_less(&exact) { other } else { exact };
        }
        let extents = [&a, &b]
            .map(|triangles| Aabb::from_points(triangles.iter().flatten().copied()).extents());
        let size = extents[0].max_element() + extents[1].max_element() + exact.rounded();
        let coordinates = a.iter().chain(&b).flatten().map(|v| v.abs().max_element());
        let reach = coordinates.fold(0.0, f64::max);
        Self {
            a,
            b,
            exact,
            known: HashMap::new(),
            size,
            reach,
            tolerance,
        }
    }

    /// The distance, rounded a few times.
    pub fn distance(&self) -> f64 {
        self.exact.rounded()
    }

    pub fn meet(&self) -> bool {
        self.exact.is_zero()
    }

    /// How exactly `f64` can tell a distance here.
    pub fn rounding(&self) -> f64 {
        5e-14 * self.size + f64::MIN_POSITIVE
    }

    /// What must be true wherever a query stopped.
    #[track_caller]
    pub fn assert_sound(&mut self, asked: &Question, said: &Answer<Bounds>) {
        let [m, n] = asked.margins;
        let distance = self.distance();
        let order = |bound: f64| self.exact.order_of_sum(&[bound, m, n]);
        assert!(
            said.value.low == 0.0 || order(said.value.low) != Ordering::Greater,
            "low: {asked:?} {said:?}, is {distance:e}"
        );
        let is_high = said.value.high == f64::INFINITY || order(said.value.high) != Ordering::Less;
        assert!(is_high, "high: {asked:?} {said:?}, is {distance:e}");
        assert!(said.value.low <= said.value.high, "{said:?}");
        if let Some(closer) = said.value.closer {
            let limit = asked.closer_than.expect("told only if asked");
            assert_eq!(order(limit) != Ordering::Less, closer, "{asked:?}");
        }
        match said.value.nearest {
            Some(nearest) => self.assert_nearest(asked, said.value.high, nearest),
            None => assert_eq!(
                said.value.high,
                f64::INFINITY,
                "of which triangles? {said:?}"
            ),
        }
    }

    /// The triangles are as close as `high` says, the points lie on them, and are as close.
    fn assert_nearest(
        &mut self,
        asked: &Question,
        high: f64,
        Nearest {
            triangles, points, ..
        }: Nearest,
    ) {
        let [i, j] = triangles.map(|triangle| triangle as usize);
        let (a, b) = (&self.a[i], &self.b[j]);
        let exact = self
            .known
            .entry(triangles)
            .or_insert_with(|| exact_distance::Distance::of(a, b));
        let [m, n] = asked.margins;
        assert_ne!(exact.order_of_sum(&[high, m, n]), Ordering::Less);
        assert!(points.iter().all(|point| point.is_finite()), "{points:?}");
        let rounding = self.size * 1e-13 + (self.reach + m + n) * 2e-15 + f64::MIN_POSITIVE;
        for ((point, triangle), margin) in points.iter().zip([a, b]).zip(asked.margins) {
            let off = exact_distance::Distance::of(&[*point; 3], triangle);
            assert_ne!(off.order_of_sum(&[margin, rounding]), Ordering::Less);
        }
        if high > 0.0 {
            let apart = exact_distance::Distance::of(&[points[0]; 3], &[points[1]; 3]);
            assert_ne!(apart.order_of_sum(&[high, rounding]), Ordering::Less);
        }
    }

    /// What must be true of a query that nothing stopped.
    #[track_caller]
    pub fn assert_complete(&mut self, asked: &Question, said: &Answer<Bounds>) {
        self.assert_sound(asked, said);
        assert_eq!(said.stop, StopReason::Finished, "{asked:?} {said:?}");
        let margin = asked.margins[0] + asked.margins[1];
        let (distance, rounding) = (self.distance(), self.rounding() + 1e-15 * margin);
        if let Some(limit) = asked.closer_than {
            let close_call = (distance - (limit + margin)).abs() <= rounding;
            assert!(said.value.closer.is_some() || close_call, "{asked:?}");
            return;
        }
        let absolute = asked.absolute.unwrap_or(self.tolerance);
        let is_told = said.value.high == 0.0 || asked.contact_open && said.value.high <= absolute;
        assert!(!self.meet() || is_told, "they meet: {asked:?} {said:?}");
        assert!(distance > margin - rounding || is_told, "{asked:?}");
        let tolerance = absolute.max(said.value.low * asked.relative) + rounding;
        assert!(said.value.high - said.value.low <= tolerance, "{asked:?}");
    }

    /// Questions of every kind about these meshes.
    pub fn questions(&self) -> Vec<Question> {
        let (distance, exact) = (self.distance(), Question::EXACT);
        let [part, rest] = [0.3 * distance, 0.45 * distance];
        let close = if self.meet() {
            0.1 * self.size
        } else {
            distance
        };
        let mut questions = vec![
            Question::default(),
            exact,
            Question {
                absolute: Some(1e-2 * self.size),
                ..exact
            },
            Question {
                relative: 1e-2,
                ..exact
            },
            Question {
                relative: 0.5,
                absolute: Some(1e-3 * self.size),
                ..exact
            },
            Question {
                absolute: Some(1e-2 * self.size),
                contact_open: true,
                ..exact
            },
            Question {
                contact_open: true,
                ..Question::default()
            },
            Question {
                margins: [part, rest],
                ..exact
            },
            Question {
                margins: [0.0, close],
                ..Question::default()
            },
            Question {
                margins: [0.6 * close, 0.6 * close],
                ..exact
            },
        ];
        let limits = [
            0.0,
            0.9 * close,
            1.1 * close,
            distance,
            distance.next_down().max(0.0),
            distance.next_up(),
        ];
        questions.extend(limits.map(Question::closer_than));
        questions.push(Question {
            absolute: Some(2.0 * close),
            ..Question::closer_than(0.9 * close)
        });
        let thick = |limit| Question {
            margins: [part, rest],
            closer_than: Some(limit),
            ..exact
        };
        questions.extend([0.2, 0.3, 1.0 - 0.3 - 0.45].map(|share| thick(share * distance)));
        questions
    }
}

/// No more than the distance of the boxes.
pub fn least_gap(a: &Aabb, b: &Aabb) -> f64 {
    let gaps = (a.min - b.max).max(b.min - a.max).max(DVec3::ZERO);
    let largest = gaps.max_element();
    // Where nothing can underflow, and neither can the squares.
    if largest > 1e-290 {
        largest * (gaps / largest).length() * (1.0 - 8.0 * f64::EPSILON)
    } else {
        largest
    }
}
