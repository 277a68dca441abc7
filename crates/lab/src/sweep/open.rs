//! What a stopped query leaves open: whether its certificate is true, and how much room is left in it.

use punctual::glam::DVec3;
use punctual::{Aabb, Certificate, Pose};

use super::case::Case;
use super::truth::Truth;

/// Points by which a volume is measured: off by about .02.
const POINTS: u32 = 512;

/// Points spread evenly in the overlap of the boxes of two meshes, along A's axes; none if these are apart.
pub struct Overlap {
    points: Vec<DVec3>,
}

impl Overlap {
    pub fn new(case: &Case, pose: &Pose) -> Self {
        let [a, b] = case.boxes(pose);
        let both = a.intersection(&b);
        // The sequence of M. Roberts, by powers of the root of x^4 = x + 1.
        const ROOT: f64 = 1.220_744_084_605_759_5;
        let step = DVec3::new(ROOT.recip(), ROOT.powi(-2), ROOT.powi(-3));
        let points = if both.is_empty() { 0 } else { POINTS };
        let point = |i| both.min + both.extents() * (0.5 + step * f64::from(i)).fract();
        Self {
            points: (1..=points).map(point).collect(),
        }
    }

    /// Share of the overlap in which the certificate does not rule out a missed intersection; not a number if there is no
    /// overlap.
    pub fn volume_left(&self, certificate: &Certificate) -> f64 {
        let boxes: Vec<_> = certificate.boxes().collect();
        let open = |p: &&DVec3| boxes.iter().any(|open| open.contains(**p));
        self.points.iter().filter(open).count() as f64 / self.points.len() as f64
    }
}

/// What is false in a certificate, in words: its bound on the number of intersections, or its boxes, none of which holds
/// an intersecting pair that is `missing`.
pub fn fault(
    certificate: &Certificate,
    case: &Case,
    pose: usize,
    truth: &Truth,
    missing: Option<[u32; 2]>,
) -> Option<String> {
    let (bound, count) = (certificate.upper_bound(), truth.pairs.len() as u64);
    if bound < count {
        return Some(format!(
            "at most {bound} pairs intersect, it says, but {count} do"
        ));
    }
    let pair = missing?;
    let place = meeting(case, &case.poses[pose], pair);
    // By rounding it may be empty.
    let held = certificate
        .boxes()
        .any(|open| open.min.cmple(place.max).all() && place.min.cmple(open.max).all());
    (!held).then(|| format!("the pair {pair:?} intersects outside of all open boxes"))
}

/// Where the boxes of two triangles overlap, along A's axes.
pub fn meeting(case: &Case, pose: &Pose, [a, b]: [u32; 2]) -> Aabb {
    let [a, b] = [
        case.a.mesh().triangle(a as usize),
        case.b.mesh().triangle(b as usize),
    ];
    let b = b.map(|v| pose.transform_point(v));
    Aabb::from_points(a).intersection(&Aabb::from_points(b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use punctual::{Budget, Query, Workspace, shapes};

    #[test]
    fn all_is_open_at_first_and_nothing_in_the_end() {
        let pose = Pose::new(punctual::glam::DMat3::IDENTITY, DVec3::new(0.8, 0.1, 0.2)).unwrap();
        let case = Case::new(
            "spheres",
            shapes::icosphere(3),
            shapes::icosphere(3),
            vec![pose],
        );
        let overlap = Overlap::new(&case, &pose);
        let query = Query::all_pairs(&case.a, &case.b, pose);
        let mut workspace = Workspace::new();
        let full = query.run(&mut workspace, Budget::unlimited()).stats.work;
        let mut left = |percent| {
            let _ = query.run(&mut workspace, Budget::work(full * percent / 100));
            overlap.volume_left(&query.certificate(&workspace).unwrap())
        };
        let (first, last) = (left(0), left(200));
        assert!(first > 0.99 && last == 0.0, "{first} {last}");
        assert!((1..100).any(|percent| (0.1..0.9).contains(&left(percent))));
        let apart = Pose::new(punctual::glam::DMat3::IDENTITY, DVec3::splat(9.0)).unwrap();
        assert!(
            Overlap::new(&case, &apart)
                .volume_left(&query.certificate(&workspace).unwrap())
                .is_nan()
        );
    }

    #[test]
    fn a_certificate_that_omits_a_pair_is_detected() {
        let case = Case::new(
            "spheres",
            shapes::icosphere(2),
            shapes::icosphere(2),
            vec![Pose::IDENTITY],
        );
        let query = Query::all_pairs(&case.a, &case.b, Pose::IDENTITY);
        let mut workspace = Workspace::new();
        let _ = query.run(&mut workspace, Budget::unlimited());
        let certificate = query.certificate(&workspace).unwrap();
        let pairs = workspace.pairs().to_vec();
        let regions = 0;
        let truth = Truth {
            region: vec![0; pairs.len()],
            pairs,
            regions,
        };
        assert_eq!(fault(&certificate, &case, 0, &truth, None), None);
        // As if a pair had not been reported: a finished query has no open box.
        assert!(
            fault(&certificate, &case, 0, &truth, Some(truth.pairs[0]))
                .unwrap()
                .contains("outside")
        );
        let more = Truth {
            pairs: [truth.pairs.clone(), vec![[9, 9]]].concat(),
            region: vec![],
            regions,
        };
        assert!(
            fault(&certificate, &case, 0, &more, None)
                .unwrap()
                .contains("at most")
        );
    }
}
