//! What a page shows, brought to one frame and one scale: the bodies together lie in a ball of radius 1 around the origin, so
//! that `f32` is enough for them wherever they are and however large.

use punctual::glam::DVec3;
use punctual::{Aabb, Certificate, Pose, Stats, Tree};
use serde_json::{Value, json};

use crate::Bodies;
use crate::arrays::Arrays;
use crate::round;
use crate::up::{self, Guess};

/// Boxes of a step that are drawn, the largest.
pub const MOST_BOXES: usize = 500;

/// Meshes, poses and boxes, as arrays of the page.
pub struct Stage {
    pub arrays: Arrays,
    /// Which way is up, if nobody tells.
    pub up: Guess,
    bounds: Aabb,
    /// Around the boxes that were open at the last look.
    open: Aabb,
    middle: DVec3,
    radius: f64,
    meshes: Vec<Shown>,
    poses: usize,
    boxes: usize,
    grids: Vec<Value>,
}

/// A mesh whose vertices are stored relative to their middle.
struct Shown {
    middle: DVec3,
    vertices: Value,
    triangles: Value,
    /// How many triangles are drawn for each of the tree, or for each point.
    each: usize,
    what: &'static str,
}

/// Squares of a grid along one direction: a tenth of the longest extent is rounded up, and its ends are rounded out.
const MOST_SQUARES: f64 = 12.0;

/// Length of a normal, over half of the diagonal of all that is shown.
pub const NORMAL: f64 = 0.06;

/// Radius of the points of a cloud without one, over the same.
const SPECK: f64 = 0.004;

/// What the boxes of a certificate are called.
pub const OPEN_BOXES: &str = "boxes still open";

/// The box of a body that lies at a pose.
pub fn placed(tree: &Tree, pose: &Pose) -> Aabb {
    let mesh = tree.mesh();
    let Aabb { min, max, .. } = mesh.aabb();
    let (min, max) = (min - tree.radius(), max + tree.radius());
    let side = |i: u8, bit: u8, from: f64, to: f64| if i & bit == 0 { from } else { to };
    let corner = |i| {
        DVec3::new(
            side(i, 1, min.x, max.x),
            side(i, 2, min.y, max.y),
            side(i, 4, min.z, max.z),
        )
    };
    if mesh.is_empty() {
        Aabb::EMPTY
    } else {
        Aabb::from_points((0..8).map(|i| pose.transform_point(corner(i))))
    }
}

impl Stage {
    /// For bodies that stay within these bounds.
    pub fn new(bounds: Aabb) -> Self {
        let (middle, radius) = if bounds.is_empty() {
            (DVec3::ZERO, 1.0)
        } else {
            (bounds.center(), 0.5 * bounds.extents().length())
        };
        let mut arrays = Arrays::default();
        let (poses, boxes) = (arrays.add(), arrays.add());
        let radius = if radius > 0.0 { radius } else { 1.0 };
        let up = up::guess([].into_iter(), &[]);
        let (meshes, grids) = Default::default();
        let mut stage = Self {
            arrays,
            up,
            bounds,
            open: Aabb::EMPTY,
            middle,
            radius,
            meshes,
            poses,
            boxes,
            grids,
        };
        stage.add_grids();
        stage
    }

    /// The meshes of A and, at its pose, of B: of each, the numbers of mesh and pose.
    pub fn bodies(&mut self, bodies: &Bodies, b_in_a: &Pose) -> [[usize; 2]; 2] {
        let [a, b] = bodies.trees.map(|tree| self.mesh(tree));
        let names = bodies.names.iter().map(String::as_str);
        self.up = up::guess(names, &[(bodies.trees[0].mesh(), &Pose::IDENTITY)]);
        [
            [a, self.pose(a, &Pose::IDENTITY)],
            [b, self.pose(b, b_in_a)],
        ]
    }

    /// Adds the mesh of a tree, or what is drawn for its points; its number.
    pub fn mesh(&mut self, tree: &Tree) -> usize {
        let (mesh, around) = (tree.mesh(), round::around(tree));
        let middle = if mesh.is_empty() {
            DVec3::ZERO
        } else {
            mesh.aabb().center()
        };
        let array = self.arrays.add();
        let vertices: Vec<DVec3> = match &around {
            Some(around) => {
                let radius = tree.radius().max(SPECK * self.radius);
                round::vertices(tree, around, radius)
            }
            None => (0..mesh.vertex_count()).map(|i| mesh.vertex(i)).collect(),
        };
        let vertices = vertices.into_iter().flat_map(|v| self.scaled(v - middle));
        let vertices: Vec<_> = vertices.collect();
        let vertices = self.arrays.extend_floats(array, vertices);
        let array = self.arrays.add();
        let triangles = self.triangles(array, tree, 0..mesh.len() as u32);
        self.meshes.push(Shown {
            middle,
            vertices,
            triangles,
            each: around.map_or(1, |around| around.len()),
            what: if mesh.is_cloud() { "point" } else { "triangle" },
        });
        self.meshes.len() - 1
    }

    /// Adds a place for a mesh; its number. The page has its rotation row by row and where the middle of the mesh comes to lie.
    pub fn pose(&mut self, mesh: usize, pose: &Pose) -> usize {
        let mut rows = self.rows(pose, self.meshes[mesh].middle).map(|x| x as f32);
        let shift = self.point(pose.transform_point(self.meshes[mesh].middle));
        (0..3).for_each(|i| rows[4 * i + 3] = shift[i]);
        let range = self.arrays.extend_floats(self.poses, rows);
        range[1].as_u64().unwrap_or_default() as usize / 12
    }

    /// The rows of [R|t] of a pose within another frame that brings the origin to this point; lengths are those of the page.
    pub fn rows(&self, pose: &Pose, point: DVec3) -> [f64; 12] {
        let mut rows = pose.to_row_major();
        let shift = pose.transform_point(point) / self.radius;
        (0..3).for_each(|i| rows[4 * i + 3] = shift[i]);
        rows
    }

    /// The point of a mesh that its vertices are stored relative to.
    pub fn middle_of(&self, mesh: usize) -> DVec3 {
        self.meshes[mesh].middle
    }

    /// A point of A's frame as the page has it.
    pub fn point(&self, point: DVec3) -> [f32; 3] {
        self.scaled(point - self.middle)
    }

    fn scaled(&self, vector: DVec3) -> [f32; 3] {
        (vector / self.radius).as_vec3().to_array()
    }

    /// A mesh at a place, in the colour of a layer of the key.
    pub fn whole(&self, layer: &str, [mesh, pose]: [usize; 2]) -> Value {
        json!([layer, mesh, pose, self.meshes[mesh].triangles])
    }

    /// A and B, where they lie.
    pub fn both(&self, &[a, b]: &[[usize; 2]; 2]) -> Vec<Value> {
        vec![self.whole("a", a), self.whole("b", b)]
    }

    /// Appends triangles of a tree, or what is drawn for its points, to an array.
    pub fn triangles(
        &mut self,
        array: usize,
        tree: &Tree,
        triangles: impl IntoIterator<Item = u32>,
    ) -> Value {
        let drawn = match round::around(tree) {
            Some(around) => round::triangles(&around, triangles),
            None => {
                let all = tree.mesh().triangles();
                triangles.into_iter().map(|id| all[id as usize]).collect()
            }
        };
        self.arrays.extend(array, drawn.into_iter().flatten())
    }

    /// Appends segments to an array.
    pub fn segments(
        &mut self,
        array: usize,
        segments: impl IntoIterator<Item = [DVec3; 2]>,
    ) -> Value {
        let floats: Vec<_> = segments
            .into_iter()
            .flatten()
            .flat_map(|point| self.point(point))
            .collect();
        self.arrays.extend_floats(array, floats)
    }

    /// The largest boxes of a certificate, the lines that tell of what is open, and a remark to the second.
    ///
    /// What was missed lies where the bodies are, so boxes are drawn as far as these reach: those of a distance without
    /// an
    /// upper bound have no end of their own.
    pub fn open_boxes(&mut self, certificate: &Certificate) -> (Value, [Fact; 2], Option<Fact>) {
        let open = certificate.open_pairs();
        let mut boxes: Vec<_> = certificate.boxes().collect();
        let all = boxes.len();
        let is_bounded = boxes.iter().all(|open| open.extents().is_finite());
        boxes
            .iter_mut()
            .for_each(|open| *open = open.intersection(&self.bounds));
        self.open = boxes.iter().fold(Aabb::EMPTY, |all, open| all.union(open));
        boxes.sort_by(|a, b| {
            b.extents()
                .max_element()
                .total_cmp(&a.extents().max_element())
        });
        boxes.dedup();
        boxes.truncate(MOST_BOXES);
        let remark = match all {
            0 if open > 0 => Some("boxes of all open pairs are apart".to_owned()),
            _ if !is_bounded => Some("anywhere: nothing bounds them yet".to_owned()),
            _ if all > MOST_BOXES => Some(format!("the {MOST_BOXES} largest are drawn")),
            _ => None,
        };
        let floats: Vec<_> = boxes
            .iter()
            .flat_map(|open| [open.min, open.max])
            .flat_map(|p| self.point(p))
            .collect();
        let [pairs, name] = ["Open pairs", "Open boxes"];
        let facts = [
            fact(pairs, count(open as u64)),
            fact(name, count(all as u64)),
        ];
        (
            self.arrays.extend_floats(self.boxes, floats),
            facts,
            remark.map(|text| fact(name, text)),
        )
    }

    /// For each axis, squares on the ground below all that is shown if that axis is up: their side, and their lines.
    fn add_grids(&mut self) {
        let array = self.arrays.add();
        self.grids = (0..3).map(|up| self.grid(up, array)).collect();
    }

    fn grid(&mut self, up: usize, array: usize) -> Value {
        let along = [(up + 1) % 3, (up + 2) % 3];
        let Aabb { min, max, .. } = self.bounds;
        let longest = along
            .map(|axis| max[axis] - min[axis])
            .into_iter()
            .fold(0.0, f64::max);
        let side = round_length(if longest > 0.0 { longest } else { self.radius } / 10.0);
        let [first, last] = [min, max].map(|end| along.map(|axis| end[axis] / side));
        let (first, last) = (first.map(f64::floor), last.map(f64::ceil));
        let mut ground = min;
        // Clear of a body that stands on it.
        ground[up] -= 0.01 * self.radius;
        let at = |i: f64, j: f64| {
            let mut point = ground;
            (point[along[0]], point[along[1]]) = (i * side, j * side);
            point
        };
        let steps = |axis: usize| {
            let number = (last[axis] - first[axis]).clamp(0.0, MOST_SQUARES) as u32;
            (0..=number).map(move |i| first[axis] + f64::from(i))
        };
        let lines = steps(0).map(|i| [at(i, first[1]), at(i, last[1])]);
        let lines = lines.chain(steps(1).map(|j| [at(first[0], j), at(last[0], j)]));
        let lines: Vec<_> = lines
            .filter(|ends| ends.iter().all(|end| end.is_finite()))
            .collect();
        json!([plain(side), self.segments(array, lines)])
    }

    /// A ball that the button for what was found brings into sight; nothing if nothing was.
    pub fn focus(&self, found: &Aabb) -> Value {
        if found.is_empty() {
            return Value::Null;
        }
        let radius = 0.5 * found.extents().length() / self.radius;
        json!([self.point(found.center()), radius as f32])
    }

    /// The same of the boxes that were open at the last look.
    pub fn focus_on_open(&self) -> Value {
        self.focus(&self.open)
    }

    /// Half of the diagonal of what is shown.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// What the page has to know of meshes and poses.
    pub fn describe(&self) -> Value {
        let ranges = |mesh: &Shown| {
            json!({
                "vertices": mesh.vertices, "triangles": mesh.triangles, "each": mesh.each, "what": mesh.what
            })
        };
        let meshes: Vec<_> = self.meshes.iter().map(ranges).collect();
        let Aabb { min, max, .. } = if self.bounds.is_empty() {
            Aabb::from_points([DVec3::ZERO])
        } else {
            self.bounds
        };
        let (bounds, poses) = (
            [min, max].map(|end| self.point(end)),
            self.arrays.so_far(self.poses),
        );
        json!({ "meshes": meshes, "bounds": bounds, "grids": self.grids, "poses": poses, "starts": self.arrays.starts() })
    }
}

/// A line of the table beside the picture.
pub type Fact = (&'static str, String);

/// A line of the table.
pub fn fact(name: &'static str, value: impl Into<String>) -> Fact {
    (name, value.into())
}

/// The lines of what a query did.
pub fn tests(stats: &Stats) -> [Fact; 2] {
    [
        fact("Box tests", count(stats.bv_tests)),
        fact("Triangle tests", count(stats.primitive_tests)),
    ]
}

/// A whole number for people.
pub fn count(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::with_capacity(2 * digits.len());
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// A length for people: five significant digits.
pub fn length(number: f64) -> String {
    let decimals = || (4.0 - number.abs().log10().floor()).clamp(0.0, 8.0) as usize;
    match number.abs() {
        0.0 => "0".to_owned(),
        size if !size.is_finite() => "not bounded".to_owned(),
        1e-4..1e6 => format!("{number:.0$}", decimals()),
        _ => format!("{number:.4e}"),
    }
}

/// The least of 1, 2, 5, 10, 20, 50, ... and their decimal parts that is not below a length.
pub fn round_length(length: f64) -> f64 {
    let decade = length.log10().floor();
    let round = |digit: u32| format!("{digit}e{decade}").parse().unwrap_or(length);
    [1, 2, 5, 10]
        .map(round)
        .into_iter()
        .find(|&round| round >= length)
        .unwrap_or(length)
}

/// A round length for people.
fn plain(length: f64) -> String {
    if (1e-4..1e6).contains(&length) {
        length.to_string()
    } else {
        format!("{length:e}")
    }
}

/// A share for people.
pub fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}
