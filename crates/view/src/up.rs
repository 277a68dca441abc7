//! Which way is up in the picture: told, or guessed from the files and the shapes.

use punctual::glam::{DVec3, Vec3Swizzles};
use punctual::{Aabb, Mesh, Pose};

/// The axis that points up in the picture of a page. A reader of the page can choose another.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Up {
    /// By the first of these rules that holds; the page says which one:
    ///
    /// 1. Files of glTF have y up, as their format says.
    /// 2. What is flat lies: up is the axis along which mesh A is less than a quarter as long as along each of the others. Of a
    ///    scene this is asked of its fixed bodies in the first frame, or of all bodies if none is fixed.
    /// 3. What stands has a flat base: the triangles that lie wholly at one end of an axis, within a fiftieth of the longest
    ///    extent, are projected along that axis. It is up if the areas at its ends differ by at least a twentieth of the side
    ///    of the bounding box there, and by twice as much as on the other axes.
    /// 4. z.
    #[default]
    Guess,
    /// The x axis.
    X,
    /// The y axis.
    Y,
    /// The z axis.
    Z,
}

impl Up {
    /// Its number, from 0, or what was guessed; and why.
    pub(crate) fn axis(self, guess: Guess) -> Guess {
        match self {
            Self::Guess => guess,
            told => (told as usize - 1, "as told"),
        }
    }
}

/// An axis, from 0, and why that one.
pub(crate) type Guess = (usize, &'static str);

/// Thickness of what counts as flat, over the extents across it.
const FLAT: f64 = 0.25;
/// Height of a base, over the longest extent.
const BASE: f64 = 0.02;
/// Least difference between the areas at both ends of an axis, over a side of the bounding box, and over that of other axes.
const CLEAR: [f64; 2] = [0.05, 2.0];

/// The rule of [`Up::Guess`], for files of these names, and bodies that may lie or stand.
pub(crate) fn guess<'n>(
    mut files: impl Iterator<Item = &'n str>,
    standing: &[(&Mesh, &Pose)],
) -> Guess {
    let is_gltf = |name: &str| {
        let name = name.to_lowercase();
        [".glb", ".gltf"]
            .iter()
            .any(|end| name.trim_end_matches(".gz").ends_with(end))
    };
    if files.any(is_gltf) {
        return (1, "glTF files have y up");
    }
    let triangles = triangles(standing);
    let bounds = Aabb::from_points(triangles.iter().flatten().copied());
    let (extents, areas) = (bounds.extents(), bases(&triangles, &bounds));
    let others = |values: DVec3, axis: usize| [values[(axis + 1) % 3], values[(axis + 2) % 3]];
    let is_flat = |&axis: &usize| {
        others(extents, axis)
            .iter()
            .all(|&other| extents[axis] < FLAT * other)
    };
    let [least, ratio] = CLEAR;
    let has_base = |&axis: &usize| {
        areas[axis] >= least
            && others(areas, axis)
                .iter()
                .all(|other| areas[axis] >= ratio * other)
    };
    match ((0..3).find(is_flat), (0..3).find(has_base)) {
        (Some(axis), _) => (axis, "it is flat across that"),
        (None, Some(axis)) => (axis, "it has a flat base across that"),
        (None, None) => (2, "nothing says otherwise"),
    }
}

fn triangles(standing: &[(&Mesh, &Pose)]) -> Vec<[DVec3; 3]> {
    let bodies = standing
        .iter()
        .flat_map(|(mesh, pose)| (0..mesh.len()).map(move |i| (mesh.triangle(i), pose)));
    bodies
        .map(|(corners, pose)| corners.map(|corner| pose.transform_point(corner)))
        .collect()
}

/// For each axis, how much the areas at its two ends differ, over the side of the bounding box there.
fn bases(triangles: &[[DVec3; 3]], &Aabb { min, max, .. }: &Aabb) -> DVec3 {
    let (extents, mut ends) = (max - min, DVec3::ZERO);
    let height = BASE * extents.max_element();
    for &[p, q, r] in triangles {
        let area = 0.5 * (q - p).cross(r - p).abs();
        let at_top = p.min(q).min(r).cmpge(max - height);
        let at_bottom = p.max(q).max(r).cmple(min + height);
        ends +=
            DVec3::select(at_top, area, DVec3::ZERO) - DVec3::select(at_bottom, area, DVec3::ZERO);
    }
    ends.abs() / (extents.yzx() * extents.zxy())
}

#[cfg(test)]
mod tests {
    use super::*;
    use punctual::shapes;

    fn of(mesh: &Mesh, pose: Pose) -> usize {
        guess([].into_iter(), &[(mesh, &pose)]).0
    }

    /// A pyramid that stands on the plane across an axis, its base made of two triangles.
    fn pyramid(up: usize) -> Mesh {
        let point = |a: f64, b: f64, height: f64| {
            let mut point = [0.0; 3];
            (point[(up + 1) % 3], point[(up + 2) % 3], point[up]) = (a, b, height);
            point
        };
        let vertices = [
            (0.0, 0.0, 0.0),
            (1.0, 0.0, 0.0),
            (1.0, 1.0, 0.0),
            (0.0, 1.0, 0.0),
            (0.4, 0.6, 1.0),
        ];
        let triangles = vec![
            [0, 2, 1],
            [0, 3, 2],
            [0, 1, 4],
            [1, 2, 4],
            [2, 3, 4],
            [3, 0, 4],
        ];
        Mesh::from_f64(
            vertices.map(|(a, b, height)| point(a, b, height)).to_vec(),
            triangles,
        )
        .unwrap()
    }

    #[test]
    fn what_is_flat_lies_and_what_has_a_base_stands() {
        let ring = shapes::torus(1.0, 0.1, 24);
        let turned = |rows: [f64; 12]| Pose::from_row_major(rows).unwrap();
        assert_eq!(of(&ring, Pose::IDENTITY), 2);
        assert_eq!(
            of(
                &ring,
                turned([1., 0., 0., 5., 0., 0., -1., 0., 0., 1., 0., 0.])
            ),
            1
        );
        for up in 0..3 {
            assert_eq!(of(&pyramid(up), Pose::IDENTITY), up);
            // Standing on its head it tells the same axis.
            assert_eq!(
                of(
                    &pyramid(up),
                    turned([1., 0., 0., 0., 0., -1., 0., 0., 0., 0., -1., 0.])
                ),
                up
            );
        }
    }

    #[test]
    fn without_a_sign_z_is_up_and_what_is_told_goes_first() {
        let ball = shapes::icosphere(2);
        let guessed = guess(["a.obj", "b.stl"].into_iter(), &[(&ball, &Pose::IDENTITY)]);
        assert_eq!(guessed, (2, "nothing says otherwise"));
        assert_eq!(guess([].into_iter(), &[]).0, 2);
        for name in ["a.glb", "A.GLTF", "3: a.glb.gz"] {
            assert_eq!(
                guess(
                    ["b.obj", name].into_iter(),
                    &[(&pyramid(0), &Pose::IDENTITY)]
                )
                .0,
                1,
                "{name}"
            );
        }
        assert_eq!(Up::default().axis(guessed), guessed);
        assert_eq!(
            [Up::X, Up::Y, Up::Z].map(|up| up.axis(guessed)),
            [0, 1, 2].map(|axis| (axis, "as told"))
        );
    }
}
