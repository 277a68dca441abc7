//! The separating axis test of two triangles in f32, for peers that bring none.

use punctual::glam::Vec3A;

pub type Triangle = [Vec3A; 3];

/// Whether no axis parts them: the two normals first, then the nine products of edges. Coplanar triangles are parted by
/// none of these, and so count as intersecting if they are in one plane: no case here has them.
pub fn intersect(p: &Triangle, q: &Triangle) -> bool {
    let origin = p[0];
    let (p, q) = (p.map(|v| v - origin), q.map(|v| v - origin));
    let edges = |t: &Triangle| [t[1] - t[0], t[2] - t[1], t[0] - t[2]];
    let (e, f) = (edges(&p), edges(&q));
    let parts = |axis: Vec3A| {
        let span = |t: &Triangle| {
            let [a, b, c] = t.map(|v| axis.dot(v));
            (a.min(b).min(c), a.max(b).max(c))
        };
        let ((low, high), (from, to)) = (span(&p), span(&q));
        low > to || from > high
    };
    if parts(e[0].cross(e[1])) || parts(f[0].cross(f[1])) {
        return false;
    }
    !e.iter().any(|e| f.iter().any(|f| parts(e.cross(*f))))
}
