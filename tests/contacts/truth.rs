//! Contact sets against the exact distances of all pairs of triangles.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};

use punctual::contacts::{Contact, ContactBounds};
use punctual::glam::DVec3;
use punctual::{Aabb, Answer, Budget, Pose, StopReason, Tree, Workspace};

pub use crate::common::ask::{answer, resume, run};
use crate::distance::least_gap;
use crate::exact_distance::Distance;
use crate::reference::posed_triangles;

type Triangle = [DVec3; 3];

/// More than any query of these tests needs: one that does not end fails.
pub const ENOUGH: Budget = Budget::work(1_000_000_000);

/// Nearest first, then by triangles.
pub fn order(x: &Contact, y: &Contact) -> Ordering {
    let by_distance = x.distance.total_cmp(&y.distance);
    by_distance.then(x.triangles.cmp(&y.triangles))
}

/// What the workspace holds, in its order.
pub fn listed(workspace: &Workspace) -> Vec<Contact> {
    workspace.contacts().copied().collect()
}

/// All pairs of two meshes at a pose, and the distances of those that were asked for.
pub struct Truth {
    a: Vec<Triangle>,
    b: Vec<Triangle>,
    /// No two triangles of the pair are closer than this.
    gaps: Vec<(f64, [u32; 2])>,
    known: BTreeMap<[u32; 2], Distance>,
    /// How exactly `f64` can tell a distance of two triangles, and a point.
    pub rounding: f64,
    point_rounding: f64,
    /// By how much normals of slivers may be off, as far as the triangles reach.
    pub off_slivers: f64,
    pub size: f64,
}

impl Truth {
    pub fn new(a: &Tree, b: &Tree, pose: &Pose) -> Self {
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
        let pairs = (0..a.len()).flat_map(|i| (0..b.len()).map(move |j| [i, j]));
        let gaps = pairs
            .map(|[i, j]| (least_gap(&boxes[0][i], &boxes[1][j]), [i as u32, j as u32]))
            .collect();
        let all = Aabb::from_points(a.iter().chain(&b).flatten().copied());
        let size = all.extents().max_element();
        let reach = all.min.abs().max(all.max.abs()).max_element();
        let rounding = 1e-13 * size + f64::MIN_POSITIVE;
        let (point_rounding, off_slivers) = (rounding + 1e-12 * reach, 2.0 * rounding);
        Self {
            a,
            b,
            gaps,
            known: BTreeMap::new(),
            rounding,
            point_rounding,
            off_slivers,
            size,
        }
    }

    pub fn distance(&mut self, pair: [u32; 2]) -> &Distance {
        let [a, b] = [&self.a[pair[0] as usize], &self.b[pair[1] as usize]];
        self.known.entry(pair).or_insert_with(|| Distance::of(a, b))
    }

    /// Whether a pair is within the margin; `None` if `f64` need not tell.
    fn is_within(&mut self, pair: [u32; 2], margin: f64) -> Option<bool> {
        let rounding = self.rounding;
        let distance = self.distance(pair);
        if distance.order_of(margin) != Ordering::Less {
            return Some(true);
        }
        (margin == 0.0 || distance.order_of(margin + rounding) == Ordering::Less).then_some(false)
    }

    /// The set has all contacts and nothing else, nearest first.
    #[track_caller]
    pub fn assert_complete(&mut self, margin: f64, set: &[Contact]) {
        self.assert_true(margin, set);
        let found: BTreeSet<_> = set.iter().map(|contact| contact.triangles).collect();
        for i in 0..self.gaps.len() {
            let (gap, pair) = self.gaps[i];
            if gap <= margin && !found.contains(&pair) {
                assert_ne!(self.is_within(pair, margin), Some(true), "{pair:?}");
            }
        }
    }

    /// Each contact is one, the nearest is the first, and none is there twice.
    #[track_caller]
    pub fn assert_true(&mut self, margin: f64, set: &[Contact]) {
        assert!(
            set.windows(2)
                .all(|two| order(&two[0], &two[1]) == Ordering::Less),
            "{set:?}"
        );
        let found: BTreeSet<_> = set.iter().map(|contact| contact.triangles).collect();
        assert_eq!(found.len(), set.len(), "a pair is there twice");
        set.iter()
            .for_each(|contact| self.assert_is_contact(margin, contact));
    }

    #[track_caller]
    fn assert_is_contact(&mut self, margin: f64, contact: &Contact) {
        let Contact {
            triangles,
            points,
            normal,
            distance,
            segment,
            ..
        } = *contact;
        assert_ne!(self.is_within(triangles, margin), Some(false));
        let (rounding, point_rounding) = (self.rounding, self.point_rounding);
        let exact = self.distance(triangles);
        assert_eq!(exact.is_zero(), distance == 0.0, "{contact:?}");
        assert_ne!(exact.order_of(distance), Ordering::Less, "{contact:?}");
        assert_ne!(
            exact.order_of((distance - rounding).max(0.0)),
            Ordering::Greater,
            "{contact:?} is closer"
        );
        let (a, b) = (self.a[triangles[0] as usize], self.b[triangles[1] as usize]);
        let on = |point: DVec3, triangle: &Triangle| {
            let off = Distance::of(&[point; 3], triangle);
            assert_ne!(off.order_of(point_rounding), Ordering::Less, "{point}");
        };
        points
            .into_iter()
            .zip([&a, &b])
            .for_each(|(point, triangle)| on(point, triangle));
        assert_eq!(segment.is_some(), distance == 0.0, "{contact:?}");
        segment
            .into_iter()
            .flatten()
            .for_each(|end| [&a, &b].into_iter().for_each(|triangle| on(end, triangle)));
        assert!((normal.length() - 1.0).abs() < 1e-14, "{contact:?}");
        if distance > 0.0 {
            let apart = Distance::of(&[points[0]; 3], &[points[1]; 3]);
            assert_ne!(
                apart.order_of_sum(&[distance, point_rounding]),
                Ordering::Less,
                "{contact:?}: its points"
            );
        }
        if distance > 10.0 * rounding {
            // All of A is ahead of all of B, relative to a corner, where nothing cancels.
            let ahead = |triangle: &Triangle| triangle.map(|corner| normal.dot(corner - a[0]));
            let of_a = ahead(&a).into_iter().fold(f64::INFINITY, f64::min);
            let of_b = ahead(&b).into_iter().fold(f64::NEG_INFINITY, f64::max);
            let off = if is_thin(&a) || is_thin(&b) {
                self.off_slivers
            } else {
                2.0 * rounding
            };
            assert!(of_a - of_b >= distance - off, "{contact:?} {a:?} {b:?}");
        }
    }

    /// What is missing from a part of a set is as far as was said.
    #[track_caller]
    pub fn assert_missing(&mut self, whole: &[Contact], part: &[Contact], low: f64) {
        let found: BTreeSet<_> = part.iter().map(|contact| contact.triangles).collect();
        let mut missing = whole
            .iter()
            .filter(|contact| !found.contains(&contact.triangles));
        // Exactly for the nearest one only: that is the dear part.
        if let Some(nearest) = missing.next()
            && low > 0.0
        {
            let order = self.distance(nearest.triangles).order_of(low);
            assert_ne!(order, Ordering::Greater, "{nearest:?} {low:e}");
            assert!(missing.all(|contact| low <= contact.distance), "{low:e}");
        }
    }

    /// The set of a query that nothing stopped.
    #[track_caller]
    pub fn assert_finished(
        &mut self,
        margin: f64,
        said: &Answer<ContactBounds>,
        workspace: &Workspace,
    ) {
        assert_eq!(
            (said.stop, said.value.low),
            (StopReason::Finished, f64::INFINITY)
        );
        assert_eq!(said.stats.found, workspace.contacts().len() as u64);
        self.assert_complete(margin, &listed(workspace));
    }
}

/// Whether a triangle is a segment or a point, or all but that.
fn is_thin(t: &Triangle) -> bool {
    let (x, y) = (t[1] - t[0], t[2] - t[0]);
    let longest = x.abs().max(y.abs()).max((y - x).abs()).max_element();
    longest == 0.0 || (x / longest).cross(y / longest).length() < 1e-12
}
