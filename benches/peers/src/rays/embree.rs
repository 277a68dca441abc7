//! As much of Embree 3 as single rays need: `rtcore.h` of 3.13.

use std::ffi::{c_char, c_int, c_uint, c_void};
use std::ptr;

use punctual::rays::RayHit;
use punctual::{Mesh, Ray};

const NONE: c_uint = c_uint::MAX;
const ROBUST: c_int = 1 << 2;
const BEST_QUALITY: c_int = 2;
const TRIANGLES: c_int = 0;
const INDICES: c_int = 0;
const VERTICES: c_int = 1;
const THREE_INDICES: c_int = 0x5003;
const THREE_FLOATS: c_int = 0x9003;

/// A ray and its hit, as `rtcIntersect1` takes them; the first half is what `rtcOccluded1` takes.
#[derive(Clone, Copy)]
#[repr(C, align(16))]
pub struct RayAndHit {
    origin: [f32; 3],
    near: f32,
    direction: [f32; 3],
    time: f32,
    far: f32,
    mask: c_uint,
    id: c_uint,
    flags: c_uint,
    normal: [f32; 3],
    place: [f32; 2],
    primitive: c_uint,
    geometry: c_uint,
    instance: c_uint,
}

const _: () = assert!(size_of::<RayAndHit>() == 80);

#[repr(C)]
struct Context {
    flags: c_int,
    filter: *const c_void,
    instance: c_uint,
}

#[link(name = "embree3")]
unsafe extern "C" {
    fn rtcNewDevice(config: *const c_char) -> *mut c_void;
    fn rtcReleaseDevice(device: *mut c_void);
    fn rtcNewScene(device: *mut c_void) -> *mut c_void;
    fn rtcReleaseScene(scene: *mut c_void);
    fn rtcSetSceneFlags(scene: *mut c_void, flags: c_int);
    fn rtcSetSceneBuildQuality(scene: *mut c_void, quality: c_int);
    fn rtcNewGeometry(device: *mut c_void, kind: c_int) -> *mut c_void;
    fn rtcReleaseGeometry(geometry: *mut c_void);
    fn rtcSetNewGeometryBuffer(
        geometry: *mut c_void,
        kind: c_int,
        slot: c_uint,
        format: c_int,
        stride: usize,
        count: usize,
    ) -> *mut c_void;
    fn rtcCommitGeometry(geometry: *mut c_void);
    fn rtcAttachGeometry(scene: *mut c_void, geometry: *mut c_void) -> c_uint;
    fn rtcCommitScene(scene: *mut c_void);
    fn rtcIntersect1(scene: *mut c_void, context: *mut Context, ray: *mut RayAndHit);
    fn rtcOccluded1(scene: *mut c_void, context: *mut Context, ray: *mut RayAndHit);
}

/// A scene of one mesh.
pub struct Embree {
    device: *mut c_void,
    scene: *mut c_void,
}

impl Embree {
    pub fn new(mesh: &Mesh, robust: bool) -> Self {
        let vertices: Vec<[f32; 3]> = (0..mesh.vertex_count())
            .map(|i| mesh.vertex(i).as_vec3().to_array())
            .collect();
        // SAFETY: the calls of a device, a scene and a geometry in their order; both buffers are as large as what is copied.
        unsafe {
            let device = rtcNewDevice(c"threads=1".as_ptr());
            assert!(!device.is_null(), "no device");
            let scene = rtcNewScene(device);
            rtcSetSceneFlags(scene, if robust { ROBUST } else { 0 });
            rtcSetSceneBuildQuality(scene, BEST_QUALITY);
            let geometry = rtcNewGeometry(device, TRIANGLES);
            let points =
                rtcSetNewGeometryBuffer(geometry, VERTICES, 0, THREE_FLOATS, 12, vertices.len());
            ptr::copy_nonoverlapping(vertices.as_ptr(), points.cast(), vertices.len());
            let corners =
                rtcSetNewGeometryBuffer(geometry, INDICES, 0, THREE_INDICES, 12, mesh.len());
            ptr::copy_nonoverlapping(mesh.triangles().as_ptr(), corners.cast(), mesh.len());
            rtcCommitGeometry(geometry);
            rtcAttachGeometry(scene, geometry);
            rtcReleaseGeometry(geometry);
            rtcCommitScene(scene);
            Self { device, scene }
        }
    }

    /// The nearest hit of each ray, one by one.
    pub fn nearest(&self, rays: &mut [RayAndHit]) {
        let mut context = Context {
            flags: 0,
            filter: ptr::null(),
            instance: NONE,
        };
        // SAFETY: the scene is committed, the rays are in Embree's format.
        rays.iter_mut()
            .for_each(|ray| unsafe { rtcIntersect1(self.scene, &raw mut context, ray) });
    }

    /// Whether each ray hits anything.
    pub fn occluded(&self, rays: &mut [RayAndHit]) {
        let mut context = Context {
            flags: 0,
            filter: ptr::null(),
            instance: NONE,
        };
        // SAFETY: as above.
        rays.iter_mut()
            .for_each(|ray| unsafe { rtcOccluded1(self.scene, &raw mut context, ray) });
    }
}

impl Drop for Embree {
    fn drop(&mut self) {
        // SAFETY: both were made by `new`, and nothing refers to them any more.
        unsafe {
            rtcReleaseScene(self.scene);
            rtcReleaseDevice(self.device);
        }
    }
}

/// Rays in Embree's format.
pub fn rays(rays: &[Ray]) -> Vec<RayAndHit> {
    let ray = |ray: &Ray| RayAndHit {
        origin: ray.origin().as_vec3().to_array(),
        near: 0.0,
        direction: ray.direction().as_vec3().to_array(),
        time: 0.0,
        far: f32::INFINITY,
        mask: c_uint::MAX,
        id: 0,
        flags: 0,
        normal: [0.0; 3],
        place: [0.0; 2],
        primitive: NONE,
        geometry: NONE,
        instance: NONE,
    };
    rays.iter().map(ray).collect()
}

/// How many rays hit here what they do not hit there: something or nothing, or another triangle that is not as far.
pub fn differing(ours: &[Option<RayHit>], theirs: &[RayAndHit]) -> usize {
    let is_other = |hit: &RayHit, ray: &RayAndHit| {
        ray.primitive != hit.triangle && (f64::from(ray.far) - hit.t).abs() > 1e-5 * hit.t.abs()
    };
    let differs = |(ours, theirs): &(&Option<RayHit>, &RayAndHit)| match (ours, theirs.geometry) {
        (None, NONE) => false,
        (Some(hit), 0) => is_other(hit, theirs),
        _ => true,
    };
    ours.iter().zip(theirs).filter(differs).count()
}
