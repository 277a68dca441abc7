//! What a page shows, brought to one frame and one scale: the bodies together lie in a ball of radius 1 around the origin, so
//! that `f32` is enough for them wherever they are and however large.

use punctual::glam::DVec3;
use punctual::{Aabb, Certificate, Mesh, Pose, Stats, Tree};
use serde_json::{Value, json};

use crate::arrays::Arrays;

/// Boxes of a step that are drawn, the largest.
pub const MOST_BOXES: usize = 500;

/// Meshes, poses and boxes, as arrays of the page.
pub struct Stage {
    pub arrays: Arrays,
    middle: DVec3,
    radius: f64,
    meshes: Vec<Shown>,
    poses: usize,
    boxes: usize,
}

/// A mesh whose vertices are stored relative to their middle.
struct Shown {
    middle: DVec3,
    vertices: Value,
    triangles: Value,
}

/// Length of a normal, over half of the diagonal of all that is shown.
pub const NORMAL: f64 = 0.06;

/// What boxes are called, of a certificate narrowed by [`aside`].
pub const NARROWED: &str = "boxes still open, after a tenth more work";

/// Work that narrows the certificate of a query: a tenth of its own.
pub fn aside(stats: &Stats) -> u64 {
    stats.work / 10
}

/// The box of a mesh that lies at a pose.
pub fn placed(mesh: &Mesh, pose: &Pose) -> Aabb {
    let Aabb { min, max, .. } = mesh.aabb();
    let side = |i: u8, bit: u8, from: f64, to: f64| if i & bit == 0 { from } else { to };
    let corner = |i| DVec3::new(side(i, 1, min.x, max.x), side(i, 2, min.y, max.y), side(i, 4, min.z, max.z));
    if mesh.is_empty() { Aabb::EMPTY } else { Aabb::from_points((0..8).map(|i| pose.transform_point(corner(i)))) }
}

impl Stage {
    /// For bodies that stay within these bounds.
    pub fn new(bounds: Aabb) -> Self {
        let (middle, radius) =
            if bounds.is_empty() { (DVec3::ZERO, 1.0) } else { (bounds.center(), 0.5 * bounds.extents().length()) };
        let mut arrays = Arrays::default();
        let (poses, boxes) = (arrays.add(), arrays.add());
        Self { arrays, middle, radius: if radius > 0.0 { radius } else { 1.0 }, meshes: Vec::new(), poses, boxes }
    }

    /// The meshes of A and, at its pose, of B: of each, the numbers of mesh and pose.
    pub fn bodies(&mut self, trees: [&Tree; 2], b_in_a: &Pose) -> [[usize; 2]; 2] {
        let [a, b] = trees.map(|tree| self.mesh(tree.mesh()));
        [[a, self.pose(a, &Pose::IDENTITY)], [b, self.pose(b, b_in_a)]]
    }

    /// Adds a mesh; its number.
    pub fn mesh(&mut self, mesh: &Mesh) -> usize {
        let middle = if mesh.is_empty() { DVec3::ZERO } else { mesh.aabb().center() };
        let array = self.arrays.add();
        let vertices = (0..mesh.vertex_count()).flat_map(|i| self.scaled(mesh.vertex(i) - middle));
        let vertices: Vec<_> = vertices.collect();
        let vertices = self.arrays.extend_floats(array, vertices);
        let array = self.arrays.add();
        let triangles = self.arrays.extend(array, mesh.triangles().iter().flatten().copied());
        self.meshes.push(Shown { middle, vertices, triangles });
        self.meshes.len() - 1
    }

    /// Adds a place for a mesh; its number. The page has its rotation row by row and where the middle of the mesh comes to lie.
    pub fn pose(&mut self, mesh: usize, pose: &Pose) -> usize {
        let rows = pose.to_row_major();
        let shift = self.point(pose.transform_point(self.meshes[mesh].middle));
        let row = |i: usize| [rows[4 * i] as f32, rows[4 * i + 1] as f32, rows[4 * i + 2] as f32, shift[i]];
        let range = self.arrays.extend_floats(self.poses, (0..3).flat_map(row));
        range[1].as_u64().unwrap_or_default() as usize / 12
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

    /// Appends triangles of a mesh to an array.
    pub fn triangles(&mut self, array: usize, mesh: &Mesh, triangles: impl IntoIterator<Item = u32>) -> Value {
        self.arrays.extend(array, triangles.into_iter().flat_map(|id| mesh.triangles()[id as usize]))
    }

    /// Appends segments to an array.
    pub fn segments(&mut self, array: usize, segments: impl IntoIterator<Item = [DVec3; 2]>) -> Value {
        let floats: Vec<_> = segments.into_iter().flatten().flat_map(|point| self.point(point)).collect();
        self.arrays.extend_floats(array, floats)
    }

    /// The largest boxes of a certificate, and the line that tells of them.
    pub fn open_boxes(&mut self, certificate: &Certificate) -> (Value, Fact) {
        let mut boxes: Vec<_> =
            certificate.boxes().filter(|open| open.min.is_finite() && open.max.is_finite()).collect();
        boxes.sort_by(|a, b| b.extents().max_element().total_cmp(&a.extents().max_element()));
        let all = boxes.len();
        boxes.truncate(MOST_BOXES);
        let told = if all > MOST_BOXES {
            format!("{}, the {MOST_BOXES} largest drawn", count(all as u64))
        } else {
            count(all as u64)
        };
        let floats: Vec<_> = boxes.iter().flat_map(|open| [open.min, open.max]).flat_map(|p| self.point(p)).collect();
        (self.arrays.extend_floats(self.boxes, floats), fact("Open boxes", told))
    }

    /// A ball that the button for what was found brings into sight; nothing if nothing was.
    pub fn focus(&self, found: &Aabb) -> Value {
        if found.is_empty() {
            return Value::Null;
        }
        let radius = 0.5 * found.extents().length() / self.radius;
        json!([self.point(found.center()), radius as f32])
    }

    /// Half of the diagonal of what is shown.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// What the page has to know of meshes and poses.
    pub fn describe(&self) -> Value {
        let ranges = |mesh: &Shown| json!({ "vertices": mesh.vertices, "triangles": mesh.triangles });
        let meshes: Vec<_> = self.meshes.iter().map(ranges).collect();
        json!({ "meshes": meshes, "poses": self.arrays.so_far(self.poses), "starts": self.arrays.starts() })
    }
}

/// A line of the table beside the picture.
pub type Fact = (&'static str, String);

/// A line of the table.
pub fn fact(name: &'static str, value: impl Into<String>) -> Fact {
    (name, value.into())
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

/// A share for people.
pub fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}
