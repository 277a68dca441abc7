//! punctual against parry3d and obvhs: the same generated meshes and poses in the same run, the least time of several sweeps
//! over all poses, interleaved; times in microseconds a query, and their ratio. `cargo run --release`
//!
//! Neither peer has a budget, so all queries are finished ones. parry walks with its own `leaf_pairs`; obvhs has no traversal
//! of two trees, so one is written here over its public nodes. Both get the plain separating axis test below, in f32.

mod triangle;

use std::hint::black_box;
use std::time::Instant;

use obvhs::bvh2::{Bvh2, builder::build_bvh2_from_tris};
use parry3d::partitioning::BvhNode;
use parry3d::shape::TriMesh;
use punctual::glam::{DMat3, DVec3, Mat3A, Vec3A};
use punctual::{Budget, Mesh, Mode, Pose, Query, Tree, Workspace, shapes};
use triangle::{Triangle, intersect};

const SWEEPS: usize = 9;

fn main() {
    println!(
        "case,mode,poses,hits,punctual_us,parry3d_us,obvhs_us,parry3d_ratio,obvhs_ratio,parry3d_differs,obvhs_differs"
    );
    let cases = [
        (
            "knot_sphere",
            shapes::torus_knot(2, 3, 0.2, 96),
            shapes::icosphere(5),
            2.9,
        ),
        ("gear_gear", shapes::gear(16, 4), shapes::gear(12, 4), 2.0),
        (
            "torus_torus",
            shapes::torus(1.0, 0.2, 96),
            shapes::torus(0.8, 0.3, 96),
            2.1,
        ),
        (
            "hills_hills",
            shapes::height_field(96, 1),
            shapes::height_field(96, 2),
            1.0,
        ),
    ];
    let mut logs = [0.0; 2];
    let mut rows = 0.0;
    for (name, a, b, reach) in cases {
        let poses = poses(reach);
        let ours = Ours {
            trees: [Tree::new(a.clone()), Tree::new(b.clone())],
            workspace: Workspace::new(),
        };
        let mut contenders: [Box<dyn Contender>; 3] = [
            Box::new(ours),
            Box::new(Parry([trimesh(&a), trimesh(&b)])),
            Box::new(Obvhs::new(&a, &b)),
        ];
        for mode in [Mode::Any, Mode::All] {
            let answers = contenders.each_mut().map(|contender| {
                poses
                    .iter()
                    .map(|pose| contender.count(pose, mode))
                    .collect::<Vec<_>>()
            });
            let hits = answers[0].iter().filter(|&&count| count > 0).count();
            let mut least = [f64::INFINITY; 3];
            for _ in 0..SWEEPS {
                for (contender, least) in contenders.iter_mut().zip(&mut least) {
                    let start = Instant::now();
                    poses.iter().for_each(|pose| {
                        black_box(contender.count(pose, mode));
                    });
                    *least = least.min(start.elapsed().as_secs_f64() * 1e6 / poses.len() as f64);
                }
            }
            let differs = [1, 2].map(|i| {
                answers[i]
                    .iter()
                    .zip(&answers[0])
                    .filter(|(x, y)| x != y)
                    .count()
            });
            let ratios = [least[1] / least[0], least[2] / least[0]];
            let [ours, parry, obvhs] = least;
            println!(
                "{name},{mode:?},{},{hits},{ours:.2},{parry:.2},{obvhs:.2},{:.2},{:.2},{},{}",
                poses.len(),
                ratios[0],
                ratios[1],
                differs[0],
                differs[1]
            );
            logs = [logs[0] + ratios[0].ln(), logs[1] + ratios[1].ln()];
            rows += 1.0;
        }
    }
    println!(
        "# geometric mean: parry3d {:.2}, obvhs {:.2}",
        (logs[0] / rows).exp(),
        (logs[1] / rows).exp()
    );
}

/// B tumbles through A along a line, from apart over contact to apart.
fn poses(reach: f64) -> Vec<Pose> {
    let turn = |i: i32| {
        DMat3::from_rotation_z(0.37 * f64::from(i)) * DMat3::from_rotation_x(0.23 * f64::from(i))
    };
    let pose = |i| {
        Pose::new(turn(i), DVec3::new(reach * f64::from(i) / 50.0, 0.1, 0.05)).expect("a rotation")
    };
    (-50..=50).map(pose).collect()
}

trait Contender {
    /// Intersecting pairs; for [`Mode::Any`] 1 if there are some.
    fn count(&mut self, pose: &Pose, mode: Mode) -> u64;
}

struct Ours {
    trees: [Tree; 2],
    workspace: Workspace,
}

impl Contender for Ours {
    fn count(&mut self, pose: &Pose, mode: Mode) -> u64 {
        let query = Query::intersection(&self.trees[0], &self.trees[1], *pose).mode(mode);
        let answer = query.run(&mut self.workspace, Budget::unlimited());
        answer.stats.found
    }
}

/// Rotation, its absolute values, and translation, in f32.
struct Place {
    rotation: Mat3A,
    spread: Mat3A,
    translation: Vec3A,
}

impl Place {
    fn new(pose: &Pose) -> Self {
        let (rotation, translation) = pose.to_f32();
        let rotation = Mat3A::from(rotation);
        let spread = Mat3A::from_cols(
            rotation.x_axis.abs(),
            rotation.y_axis.abs(),
            rotation.z_axis.abs(),
        );
        Self {
            rotation,
            spread,
            translation: translation.into(),
        }
    }

    /// Whether a box of A meets a box of B, on A's axes.
    #[inline]
    fn meets(&self, (low_a, high_a): (Vec3A, Vec3A), (low_b, high_b): (Vec3A, Vec3A)) -> bool {
        let distance =
            self.rotation * (low_b + high_b) * 0.5 + self.translation - (low_a + high_a) * 0.5;
        let reach = self.spread * (high_b - low_b) * 0.5 + (high_a - low_a) * 0.5;
        distance.abs().cmple(reach).all()
    }

    #[inline]
    fn moved(&self, triangle: &Triangle) -> Triangle {
        triangle.map(|v| self.rotation * v + self.translation)
    }
}

struct Parry([TriMesh; 2]);

fn trimesh(mesh: &Mesh) -> TriMesh {
    let vertex = |i| parry3d::math::Vector::from_array(mesh.vertex(i).as_vec3().to_array());
    TriMesh::new(
        (0..mesh.vertex_count()).map(vertex).collect(),
        mesh.triangles().to_vec(),
    )
    .expect("a mesh")
}

impl Contender for Parry {
    fn count(&mut self, pose: &Pose, mode: Mode) -> u64 {
        let place = Place::new(pose);
        let [a, b] = &self.0;
        let vector = |v: parry3d::math::Vector| Vec3A::from_array(v.to_array());
        let bounds = |node: &BvhNode| (vector(node.mins()), vector(node.maxs()));
        let triangle = |mesh: &TriMesh, i: u32| {
            let t = mesh.triangle(i);
            [t.a, t.b, t.c].map(vector)
        };
        let hits = a
            .bvh()
            .leaf_pairs(b.bvh(), |x: &BvhNode, y: &BvhNode| {
                place.meets(bounds(x), bounds(y))
            })
            .filter(|&(i, j)| intersect(&triangle(a, i), &place.moved(&triangle(b, j))));
        (if mode == Mode::Any {
            hits.take(1).count()
        } else {
            hits.count()
        }) as u64
    }
}

struct Obvhs {
    triangles: [Vec<Triangle>; 2],
    trees: [Bvh2; 2],
    stack: Vec<[u32; 2]>,
}

impl Obvhs {
    fn new(a: &Mesh, b: &Mesh) -> Self {
        let triangles = [a, b].map(|mesh| {
            (0..mesh.len())
                .map(|i| mesh.triangle(i).map(|v| v.as_vec3a()))
                .collect::<Vec<_>>()
        });
        let trees = triangles.each_ref().map(|triangles| {
            let soup: Vec<_> = triangles
                .iter()
                .map(|triangle| triangle.map(|v| v.to_array().into()))
                .map(|[v0, v1, v2]| obvhs::triangle::Triangle { v0, v1, v2 })
                .collect();
            build_bvh2_from_tris(
                &soup,
                obvhs::BvhBuildParams::medium_build(),
                &mut Default::default(),
            )
        });
        Self {
            triangles,
            trees,
            stack: Vec::new(),
        }
    }
}

impl Contender for Obvhs {
    fn count(&mut self, pose: &Pose, mode: Mode) -> u64 {
        let place = Place::new(pose);
        let Self {
            triangles,
            trees: [a, b],
            stack,
        } = self;
        let bounds = |node: &obvhs::bvh2::node::Bvh2Node| {
            let aabb = node.aabb();
            [aabb.min, aabb.max]
                .map(|v| Vec3A::from_array(v.to_array()))
                .into()
        };
        let mut found = 0;
        stack.clear();
        stack.push([0, 0]);
        while let Some([i, j]) = stack.pop() {
            let (x, y) = (&a.nodes[i as usize], &b.nodes[j as usize]);
            if !place.meets(bounds(x), bounds(y)) {
                continue;
            }
            let of_a = if x.is_leaf() {
                i..i + 1
            } else {
                x.first_index..x.first_index + 2
            };
            let of_b = if y.is_leaf() {
                j..j + 1
            } else {
                y.first_index..y.first_index + 2
            };
            if !x.is_leaf() || !y.is_leaf() {
                stack.extend(of_a.flat_map(|i| of_b.clone().map(move |j| [i, j])));
                continue;
            }
            for &p in &a.primitive_indices[x.first_index as usize..][..x.prim_count as usize] {
                for &q in &b.primitive_indices[y.first_index as usize..][..y.prim_count as usize] {
                    let moved = place.moved(&triangles[1][q as usize]);
                    found += u64::from(intersect(&triangles[0][p as usize], &moved));
                    if found > 0 && mode == Mode::Any {
                        return 1;
                    }
                }
            }
        }
        found
    }
}
