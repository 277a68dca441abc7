use glam::DVec3;
pub(crate) fn intersects(_a: &[DVec3; 3], _b: &[DVec3; 3]) -> bool {
    true
}
