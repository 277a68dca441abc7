use super::*;
use crate::mesh::Mesh;
use crate::tree::Tree;
use glam::{DMat3, DQuat};
use punctual_geom::Pose;
use punctual_geom::random::Random;

fn vector(random: &mut Random) -> DVec3 {
    DVec3::from_array(core::array::from_fn(|_| random.between(-1.0, 1.0)))
}

fn rotation(random: &mut Random) -> DMat3 {
    let axis = vector(random).try_normalize().unwrap_or(DVec3::X);
    DMat3::from_quat(DQuat::from_axis_angle(axis, random.between(-3.0, 3.0)))
}

/// Triangles with a common corner, all on the side of it to which `normal` points, and nearly flat.
fn fan(random: &mut Random, corner: DVec3, normal: DVec3) -> Tree {
    let height = libm::pow(10.0, random.between(-9.0, -6.0));
    let size = libm::pow(10.0, random.between(-1.5, 0.0));
    let count = 1 + random.bits() as usize % 30;
    let mut vertices = alloc::vec![corner];
    for _ in 0..2 * count {
        let aside = vector(random) * size;
        vertices.push(corner + aside + normal * (random.fraction() * height - aside.dot(normal)));
    }
    // A distant triangle, so that the fan is not around the middle.
    vertices.extend(
        [1.0, 1.01, 1.02].map(|far| corner + normal * far - far * corner.dot(normal) * normal),
    );
    let apart = 2 * count as u32 + 1;
    let triangles = (0..count as u32)
        .map(|i| [0, 2 * i + 1, 2 * i + 2])
        .chain([[apart, apart + 1, apart + 2]]);
    Tree::new(Mesh::from_f64(vertices, triangles).unwrap())
}

/// Two surfaces with a common point, on opposite sides of a plane there.
struct Touching {
    trees: [Tree; 2],
    relative: RelativePose,
    normal: DVec3,
}

impl Touching {
    fn new(random: &mut Random) -> Self {
        let drift = [0.0, 1e-6, 3e-4][random.bits() as usize % 3];
        let skewed =
            DMat3::from_cols_array(&core::array::from_fn(|_| drift * random.between(-1.0, 1.0)));
        let turn = rotation(random) * (DMat3::IDENTITY + skewed);
        let pose = Pose::new(turn, 2.0 * vector(random)).unwrap();
        let normal = if random.bits().is_multiple_of(4) {
            DVec3::Y
        } else {
            vector(random).try_normalize().unwrap_or(DVec3::Z)
        };
        let in_b = turn.transpose() * normal;
        let corner = vector(random);
        let b = fan(random, corner, in_b.normalize());
        // The same bits as the placed corner of B.
        let a = fan(random, pose.transform_point(corner), -normal);
        let relative = RelativePose::new(&a, &b, &pose);
        Self {
            trees: [a, b],
            relative,
            normal,
        }
    }

    /// Pairs of nodes that contain triangles of the fans.
    fn pairs(&self) -> impl Iterator<Item = [&Node; 2]> {
        let [a, b] = [0, 1].map(|side| {
            let tree = &self.trees[side];
            let apart = tree.triangles().len() as u32 - 1;
            let holds = move |node: &&Node| {
                tree.ids()[node.triangle_range()]
                    .iter()
                    .any(|&id| id != apart)
            };
            tree.nodes().iter().filter(holds)
        });
        a.flat_map(move |a| b.clone().map(move |b| [a, b]))
    }
}

/// The rounding allowance is needed: none, a 16th or an eighth of it would not suffice.
#[test]
fn boxes_with_a_common_point_are_never_parted() {
    let mut random = Random::new(31);
    let (mut without, mut all) = ([0; 3], 0);
    for case in 0..20_000 {
        let touching = Touching::new(&mut random);
        let Touching {
            relative, normal, ..
        } = &touching;
        for [a, b] in touching.pairs() {
            let views = Views::between(a, b, relative);
            assert!(gap(a, b, &views, relative) <= 0.0, "case {case}");
            let off = *normal + 1e-6 * vector(&mut random);
            let DMat3 {
                x_axis,
                y_axis,
                z_axis,
            } = a.rotation().as_dmat3();
            for direction in [*normal, off, x_axis, y_axis, z_axis] {
                assert!(
                    gap_of([a, b], relative, direction, ROUNDING) <= 0.0,
                    "case {case}"
                );
                for (count, part) in without.iter_mut().zip([0.0, 1.0 / 16.0, 1.0 / 8.0]) {
                    *count +=
                        usize::from(gap_of([a, b], relative, direction, part * ROUNDING) > 0.0);
                }
                all += 1;
            }
        }
    }
    assert!(
        without.iter().all(|&count| count > 10),
        "{without:?} of {all} lost"
    );
}
