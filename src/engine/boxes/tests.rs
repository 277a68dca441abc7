use super::relative_pose::{RelativePose, Views};
use super::*;
use crate::mesh::shapes;
use crate::tree::Tree;
use glam::{DMat3, DVec3};
use punctual_geom::Pose;
use punctual_geom::lanes::{Instructions, Kernel};

struct EightAndOne<'t>(Triangles<'t>);

impl Kernel for EightAndOne<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let Triangles {
            rows,
            view,
            rotation_error,
        } = &self.0;
        let planes = Planes::new(lanes, &self.0);
        for (i, row) in rows.iter().enumerate() {
            assert_eq!(planes.at(i), Plane::new(row, view, *rotation_error));
        }
    }
}

#[test]
fn a_triangle_alone_has_the_same_bits_as_among_eight() {
    let (a, b) = (
        Tree::new(shapes::torus_knot(2, 3, 0.2, 16)),
        Tree::new(shapes::gear(9, 2)),
    );
    let pose = Pose::new(
        DMat3::from_rotation_x(0.7) * DMat3::from_rotation_z(0.4),
        DVec3::new(0.3, 0.1, -0.2),
    );
    let relative = RelativePose::new(&a, &b, &pose.unwrap());
    for (eight, node) in a
        .triangles()
        .chunks_exact(WIDTH)
        .zip(b.nodes().iter().cycle())
    {
        let view = Views::between(&a.nodes()[0], node, &relative).triangles(true, node, &relative);
        for instructions in [Instructions::detect(), Instructions::PORTABLE] {
            let rows = core::array::from_fn(|i| &eight[i].0);
            instructions.run(EightAndOne(Triangles {
                rows,
                view,
                rotation_error: relative.rotation_error,
            }));
        }
    }
}
