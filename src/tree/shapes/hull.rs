//! The convex hull of points, by exact signs: each face keeps the points above it, and the farthest
//! of them replaces all faces below it by a fan to their rim.
//!
//! Faces in one plane have the same sign, so those strictly below a point hang together and have
//! one rim, and no triangle of the fan is degenerate. A point that was above a removed face and is
//! still outside is above a face of the fan: if it is above a face that stays, it is above both
//! faces of some edge of the rim, and the normal of the new face there is a sum of theirs with
//! weights that are not negative.

use alloc::collections::BTreeMap;
use alloc::vec::Vec;
use glam::DVec3;
use punctual_geom::triangle::side_of_plane;

struct Face {
    corners: [u32; 3],
    /// Points above its plane; each is kept by one face.
    above: Vec<u32>,
    is_gone: bool,
}

struct Hull<'p> {
    points: &'p [DVec3],
    faces: Vec<Face>,
    /// The face that has an edge in this direction.
    faces_at: BTreeMap<[u32; 2], usize>,
}

/// Triangles of the hull that face outwards; `None` if the points lie in one plane.
pub(crate) fn hull(points: &[DVec3]) -> Option<Vec<[u32; 3]>> {
    let mut hull = Hull {
        points,
        faces: Vec::new(),
        faces_at: BTreeMap::new(),
    };
    let [a, b, c, d] = tetrahedron(points)?;
    for corners in [[a, b, c], [b, a, d], [c, b, d], [a, c, d]] {
        hull.add(corners);
    }
    hull.share(0, (0..points.len() as u32).collect());
    let mut at = 0;
    while at < hull.faces.len() {
        match hull.farthest_above(at) {
            Some(point) => hull.reach(at, point),
            None => at += 1,
        }
    }
    let left = hull.faces.iter().filter(|face| !face.is_gone);
    Some(left.map(|face| face.corners).collect())
}

/// Four points that are not in one plane, the last one below the triangle of the others.
fn tetrahedron(points: &[DVec3]) -> Option<[u32; 4]> {
    let farthest = |is_apart: &dyn Fn(DVec3) -> bool, size: &dyn Fn(DVec3) -> f64| {
        let apart = (0..points.len()).filter(|&i| is_apart(points[i]));
        apart.max_by(|&i, &j| size(points[i]).total_cmp(&size(points[j])))
    };
    let p = *points.first()?;
    let b = farthest(&|q| q != p, &|q| p.distance_squared(q))?;
    let u = points[b] - p;
    let is_off_line = |q: DVec3| {
        // No plane holds all four.
        let probes = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let is_side = |probe| side_of_plane(&[p, points[b], q], probe) != 0;
        probes.into_iter().any(is_side)
    };
    let c = farthest(&is_off_line, &|q| u.cross(q - p).length_squared())?;
    let (plane, normal) = ([p, points[b], points[c]], u.cross(points[c] - p));
    let is_off_plane = |q| side_of_plane(&plane, q) != 0;
    let d = farthest(&is_off_plane, &|q| normal.dot(q - p).abs())?;
    let [b, c] = if side_of_plane(&plane, points[d]) < 0 {
        [b, c]
    } else {
        [c, b]
    };
    Some([0, b as u32, c as u32, d as u32])
}

impl Hull<'_> {
    fn add(&mut self, corners: [u32; 3]) {
        for edge in edges(corners) {
            self.faces_at.insert(edge, self.faces.len());
        }
        let (above, is_gone) = (Vec::new(), false);
        self.faces.push(Face {
            corners,
            above,
            is_gone,
        });
    }

    fn corners(&self, face: usize) -> [DVec3; 3] {
        self.faces[face].corners.map(|i| self.points[i as usize])
    }

    fn is_above(&self, face: usize, point: u32) -> bool {
        side_of_plane(&self.corners(face), self.points[point as usize]) > 0
    }

    /// Gives each point to a face below it, from `first` on; those inside to none.
    fn share(&mut self, first: usize, points: Vec<u32>) {
        for point in points {
            let mut faces = first..self.faces.len();
            if let Some(face) = faces.find(|&face| self.is_above(face, point)) {
                self.faces[face].above.push(point);
            }
        }
    }

    fn farthest_above(&self, face: usize) -> Option<u32> {
        let [p, q, r] = self.corners(face);
        let normal = (q - p).cross(r - p);
        let height = |i: u32| normal.dot(self.points[i as usize] - p);
        let above = self.faces[face].above.iter().copied();
        above.max_by(|&i, &j| height(i).total_cmp(&height(j)))
    }

    /// Extends the hull to a point above a face.
    fn reach(&mut self, face: usize, point: u32) {
        let (mut gone, mut rim, mut points) = (alloc::vec![face], Vec::new(), Vec::new());
        self.faces[face].is_gone = true;
        let mut next = 0;
        while let Some(&face) = gone.get(next) {
            next += 1;
            points.append(&mut self.faces[face].above);
            for edge in edges(self.faces[face].corners) {
                let [from, to] = edge;
                let other = self.faces_at[&[to, from]];
                if self.faces[other].is_gone {
                    continue;
                }
                if self.is_above(other, point) {
                    self.faces[other].is_gone = true;
                    gone.push(other);
                } else {
                    rim.push(edge);
                }
            }
        }
        let first = self.faces.len();
        for [from, to] in rim {
            self.add([from, to, point]);
        }
        self.share(first, points);
    }
}

fn edges([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}
