//! Meshes, trees, poses and triangles.

use super::World;
use super::call::{Call, any, asked as raw, begun};
use libfuzzer_sys::arbitrary::{Result, Unstructured};
use punctual::glam::{DMat3, DQuat, DVec3, Vec3};
use punctual::{Mesh, Pose, shapes};
use punctual_capi::{punctual_status as Status, *};
use punctual_fuzz::{Numbers, oracle};
use std::sync::atomic::{AtomicU64, Ordering};

/// A mesh, and the same of Rust.
pub struct Surface {
    pub handle: Box<punctual_mesh>,
    mesh: Mesh,
}

/// What a tree is of, and which state of it: trees of the same version are the same for a query that is resumed.
#[derive(Clone)]
pub struct Shape {
    pub mesh: Mesh,
    pub version: u64,
}

impl Shape {
    pub fn new(mesh: Mesh) -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Self {
            mesh,
            version: NEXT.fetch_add(1, Ordering::Relaxed),
        }
    }
}

/// A tree.
pub struct Grown {
    pub handle: Box<punctual_tree>,
    pub shape: Shape,
}

/// Now and then one of few handles goes.
fn gone<T>(bytes: &mut Unstructured, list: &mut Vec<T>) -> Result<Option<T>> {
    let goes = list.len() >= 4 || bytes.ratio(1, 8)?;
    Ok(if goes {
        any(bytes, list)?.map(|at| list.swap_remove(at))
    } else {
        None
    })
}

/// The largest coordinate: 2^1000.
const LARGEST: f64 = f64::from_bits((1023 + 1000) << 52);

/// Makes a mesh, and frees one if there are many.
pub fn change(world: &mut World, bytes: &mut Unstructured) -> Result<()> {
    if let Some(surface) = gone(bytes, &mut world.surfaces)? {
        punctual_mesh_free(Some(surface.handle));
    }
    let made = if bytes.ratio(1, 3)? {
        generated(bytes)?
    } else {
        given(bytes)?
    };
    let Some(surface) = made else { return Ok(()) };
    check(&surface, bytes)?;
    world.surfaces.push(surface);
    Ok(())
}

fn generated(bytes: &mut Unstructured) -> Result<Option<Surface>> {
    let call = Call::default();
    let numbers = if bytes.arbitrary()? {
        Numbers::Fraction
    } else {
        Numbers::arbitrary(bytes)?
    };
    let [x, y, z] = numbers.point(bytes)?.map(|x| x as f32);
    let few = bytes.int_in_range(0..=3)?;
    let (handle, mesh) = match bytes.int_in_range(0..=5)? {
        0 => (
            call.own(bytes, |out| punctual_shape_icosphere(few % 2, out))?,
            shapes::icosphere(few % 2),
        ),
        1 => (
            call.own(bytes, |out| punctual_shape_cuboid(x, y, z, few, out))?,
            shapes::cuboid(Vec3::new(x, y, z), few),
        ),
        2 => (
            call.own(bytes, |out| punctual_shape_torus(x, y, few, out))?,
            shapes::torus(x, y, few),
        ),
        3 => {
            // The more windings, the more triangles, and the judge looks at all pairs.
            let (p, q) = (bytes.int_in_range(0..=3)?, bytes.int_in_range(0..=3)?);
            let handle = call.own(bytes, |out| punctual_shape_torus_knot(p, q, x, few, out))?;
            (handle, shapes::torus_knot(p, q, x, few))
        }
        4 => (
            call.own(bytes, |out| punctual_shape_gear(few, 0, out))?,
            shapes::gear(few, 0),
        ),
        _ => {
            let seed = bytes.arbitrary()?;
            (
                call.own(bytes, |out| punctual_shape_height_field(few, seed, out))?,
                shapes::height_field(few, seed),
            )
        }
    };
    Ok(handle.map(|handle| Surface { handle, mesh }))
}

fn given(bytes: &mut Unstructured) -> Result<Option<Surface>> {
    let numbers = Numbers::arbitrary(bytes)?;
    let vertices = (0..bytes.int_in_range(0..=10)?)
        .map(|_| numbers.point(bytes))
        .collect::<Result<Vec<_>>>()?;
    let last = u32::try_from(vertices.len())
        .expect("few")
        .saturating_sub(1);
    let mut index = || Ok(bytes.int_in_range(0..=last)? + u32::from(bytes.ratio(1, 500)?));
    let mut triangles = (0..12)
        .map(|_| Ok([index()?, index()?, index()?]))
        .collect::<Result<Vec<_>>>()?;
    triangles.truncate(bytes.int_in_range(0..=12)?);
    let mut call = Call::default();
    let (faces, face_count) =
        call.array(bytes, triangles.as_ptr().cast_mut().cast(), triangles.len())?;
    let (handle, mesh) = if bytes.arbitrary()? {
        let mesh = Mesh::from_f64(vertices.iter().copied(), triangles.iter().copied());
        call.fault(mesh.is_err(), Status::BadMesh);
        let (first, count) =
            call.array(bytes, vertices.as_ptr().cast_mut().cast(), vertices.len())?;
        // SAFETY: as long as said, or refused.
        (
            call.own(bytes, |out| unsafe {
                punctual_mesh_new_f64(first, count, faces, face_count, out)
            })?,
            mesh,
        )
    } else {
        let vertices: Vec<[f32; 3]> = vertices
            .iter()
            .map(|vertex| vertex.map(|x| x as f32))
            .collect();
        let mesh = Mesh::new(vertices.iter().copied(), triangles.iter().copied());
        call.fault(mesh.is_err(), Status::BadMesh);
        let (first, count) =
            call.array(bytes, vertices.as_ptr().cast_mut().cast(), vertices.len())?;
        // SAFETY: the same.
        (
            call.own(bytes, |out| unsafe {
                punctual_mesh_new_f32(first, count, faces, face_count, out)
            })?,
            mesh,
        )
    };
    Ok(handle
        .zip(mesh.ok())
        .map(|(handle, mesh)| Surface { handle, mesh }))
}

/// Numbers, indices and vertices are those of the model.
fn check(Surface { handle, mesh }: &Surface, bytes: &mut Unstructured) -> Result<()> {
    let mut call = Call::default();
    let asked = call.given(bytes, &**handle)?;
    if let Some(facts) = call.fill(bytes, |out| unsafe { punctual_mesh_describe(asked, out) })? {
        assert_eq!(
            (facts.triangles, facts.vertices),
            (mesh.len(), mesh.vertex_count())
        );
        assert_eq!((facts.bytes, facts.is_f32), (mesh.bytes(), mesh.is_f32()));
    }
    let mut call = Call::default();
    let asked = call.given(bytes, &**handle)?;
    if let Some(indices) = call.make(bytes, |out| punctual_mesh_indices(asked, out))? {
        // SAFETY: three for each triangle of a mesh that is there.
        let indices = unsafe { std::slice::from_raw_parts(indices, 3 * mesh.len()) };
        assert_eq!(indices, mesh.triangles().as_flattened());
    }
    let mut call = Call::default();
    let asked = call.given(bytes, &**handle)?;
    let index = if bytes.ratio(1, 16)? {
        bytes.arbitrary()?
    } else {
        bytes.int_in_range(0..=mesh.vertex_count())?
    };
    call.fault(index >= mesh.vertex_count(), Status::BadArgument);
    if let Some(vertex) = call.make(bytes, |out| punctual_mesh_vertex(asked, index, out))?
        && mesh.triangles().as_flattened().contains(&(index as u32))
    {
        assert_eq!(
            [vertex.x, vertex.y, vertex.z],
            mesh.vertex(index).to_array()
        );
    }
    Ok(())
}

/// A pose: mostly a turn and a small shift, now and then any numbers. And what it is, if it is one.
pub fn pose(bytes: &mut Unstructured) -> Result<(punctual_pose, Option<Pose>)> {
    let m = if bytes.ratio(1, 16)? {
        let mut m = [0.0; 12];
        for entry in &mut m {
            *entry = Numbers::arbitrary(bytes)?.read(bytes)?;
        }
        m
    } else {
        let [x, y, z] = Numbers::Fraction.point(bytes)?;
        let turn = if bytes.arbitrary()? {
            DQuat::IDENTITY
        } else {
            DQuat::from_xyzw(x, y, z, 0.7).normalize()
        };
        let numbers = if bytes.ratio(1, 8)? {
            Numbers::arbitrary(bytes)?
        } else {
            Numbers::Fraction
        };
        let (rows, shift) = (
            DMat3::from_quat(turn).transpose().to_cols_array_2d(),
            numbers.point(bytes)?,
        );
        let mut m = [0.0; 12];
        for axis in 0..3 {
            m[4 * axis..4 * axis + 3].copy_from_slice(&rows[axis]);
            m[4 * axis + 3] = shift[axis];
        }
        m
    };
    Ok((punctual_pose { m }, Pose::from_row_major(m).ok()))
}

/// Poses and triangles, which need no handle.
pub fn numbers(bytes: &mut Unstructured) -> Result<()> {
    let ((x, of_x), (y, of_y)) = (pose(bytes)?, pose(bytes)?);
    let mut call = Call::default();
    call.fault(of_x.is_none() || of_y.is_none(), Status::BadPose);
    call.doubt(Status::BadPose);
    if let Some(made) = call.make(bytes, |out| punctual_pose_compose(x, y, out))? {
        assert!(Pose::from_row_major(made.m).is_ok());
    }
    let mut call = Call::default();
    call.fault(of_x.is_none(), Status::BadPose);
    call.doubt(Status::BadPose);
    if let Some(made) = call.make(bytes, |out| punctual_pose_inverse(x, out))? {
        assert!(Pose::from_row_major(made.m).is_ok());
    }
    let numbers = Numbers::arbitrary(bytes)?;
    let ([x, y, z], w, shift) = (
        numbers.point(bytes)?,
        numbers.read(bytes)?,
        numbers.point(bytes)?,
    );
    let translation = punctual_point {
        x: shift[0],
        y: shift[1],
        z: shift[2],
    };
    let mut call = Call::default();
    call.doubt(Status::BadPose);
    if let Some(made) = call.make(bytes, |out| {
        punctual_pose_from_quaternion(x, y, z, w, translation, out)
    })? {
        assert!(Pose::from_row_major(made.m).is_ok());
    }
    let mut corners = || {
        Ok([
            numbers.point(bytes)?,
            numbers.point(bytes)?,
            numbers.point(bytes)?,
        ])
    };
    let [a, b] = [corners()?, corners()?];
    let mut call = Call::default();
    let fine = |x: &f64| x.abs() <= LARGEST;
    call.fault(!a.iter().chain(&b).flatten().all(fine), Status::BadArgument);
    let (first, second) = (
        punctual_triangle { corners: a },
        punctual_triangle { corners: b },
    );
    if let Some(intersect) = call.make(bytes, |out| {
        punctual_triangles_intersect(first, second, out)
    })? {
        assert_eq!(
            intersect,
            oracle::intersects(&a.map(DVec3::from), &b.map(DVec3::from)),
            "{a:?} {b:?}"
        );
    }
    Ok(())
}

/// Makes, changes, reads or frees a tree.
pub fn grow(world: &mut World, bytes: &mut Unstructured) -> Result<()> {
    let Some(at) = any(bytes, &world.trees)? else {
        return plant(world, bytes);
    };
    match bytes.int_in_range(0..=5)? {
        0 | 1 => plant(world, bytes),
        2 => refit(&mut world.trees[at], bytes),
        3 => tell(&world.trees[at], bytes),
        4 => copy(world, at, bytes),
        _ => ship(world, at, bytes),
    }
}

fn plant(world: &mut World, bytes: &mut Unstructured) -> Result<()> {
    if let Some(tree) = gone(bytes, &mut world.trees)? {
        punctual_tree_free(Some(tree.handle));
    }
    let Some(at) = any(bytes, &world.surfaces)? else {
        return change(world, bytes);
    };
    let mut call = Call::default();
    let Surface { handle, mesh } = &world.surfaces[at];
    let asked = call.given(bytes, &**handle)?;
    // SAFETY: the place is as large as said.
    let mut options = begun(|place, size| unsafe { punctual_build_options_init(place, size) });
    let chosen = bytes.arbitrary::<bool>()?;
    if chosen {
        options.effort = call.value(bytes, 3)?;
        (options.frames, options.threads) = (bytes.arbitrary::<u8>()?.into(), bytes.arbitrary()?);
    }
    let made = call.own(bytes, |out| unsafe {
        punctual_tree_new(asked, raw(chosen.then_some(&options)), out)
    })?;
    if let Some(handle) = made {
        assert_eq!(punctual_tree_validate(Some(&handle)), Status::Ok);
        world.trees.push(Grown {
            handle,
            shape: Shape::new(mesh.clone()),
        });
    }
    Ok(())
}

/// New vertices for a mesh, mostly as many as it has.
pub fn vertices(mesh: &Mesh, bytes: &mut Unstructured) -> Result<Vec<[f64; 3]>> {
    let numbers = Numbers::arbitrary(bytes)?;
    let count = if bytes.ratio(1, 16)? {
        bytes.int_in_range(0..=20)?
    } else {
        mesh.vertex_count()
    };
    (0..count).map(|_| numbers.point(bytes)).collect()
}

/// The mesh with other vertices, if they fit.
pub fn moved(mesh: &Mesh, vertices: &[[f64; 3]]) -> Option<Mesh> {
    let fit = vertices.len() == mesh.vertex_count();
    let moved = Mesh::from_f64(vertices.iter().copied(), mesh.triangles().iter().copied());
    moved.ok().filter(|_| fit)
}

/// Rounded to float, as both widths.
pub fn narrowed(vertices: &mut [[f64; 3]]) -> Vec<[f32; 3]> {
    let narrow: Vec<[f32; 3]> = vertices
        .iter()
        .map(|vertex| vertex.map(|x| x as f32))
        .collect();
    vertices
        .iter_mut()
        .zip(&narrow)
        .for_each(|(wide, narrow)| *wide = narrow.map(f64::from));
    narrow
}

fn refit(Grown { handle, shape }: &mut Grown, bytes: &mut Unstructured) -> Result<()> {
    let mut call = Call::default();
    let mut wide = vertices(&shape.mesh, bytes)?;
    let is_narrow = bytes.arbitrary()?;
    let narrow = if is_narrow {
        narrowed(&mut wide)
    } else {
        Vec::new()
    };
    let new = moved(&shape.mesh, &wide);
    call.fault(new.is_none(), Status::BadMesh);
    let tree = call.given(bytes, &mut **handle)?;
    // SAFETY: as long as said, or refused.
    let status = unsafe {
        if is_narrow {
            let (first, count) =
                call.array(bytes, narrow.as_ptr().cast_mut().cast(), narrow.len())?;
            punctual_tree_refit_f32(tree, first, count)
        } else {
            let (first, count) = call.array(bytes, wide.as_ptr().cast_mut().cast(), wide.len())?;
            punctual_tree_refit_f64(tree, first, count)
        }
    };
    if call.judge(status) {
        *shape = Shape::new(new.expect("it fits"));
    }
    assert_eq!(punctual_tree_validate(Some(handle)), Status::Ok);
    Ok(())
}

fn tell(Grown { handle, shape }: &Grown, bytes: &mut Unstructured) -> Result<()> {
    let mut call = Call::default();
    let tree = call.given(bytes, &**handle)?;
    let Some(facts) = call.fill(bytes, |out| unsafe { punctual_tree_describe(tree, out) })? else {
        return Ok(());
    };
    assert_eq!(facts.triangles, shape.mesh.len());
    let mut call = Call::default();
    let tree = call.given(bytes, &**handle)?;
    let mut levels = vec![
        punctual_tree_level {
            nodes: 0,
            alpha: [0.0; 3],
            levels: 0.0
        };
        bytes.int_in_range(0..=4)?
    ];
    let (first, capacity) = call.array(bytes, levels.as_mut_ptr(), levels.len())?;
    // SAFETY: there is room for as many as said, or it is refused.
    let count = call.make(bytes, |out| unsafe {
        punctual_tree_levels(tree, first, size_of::<punctual_tree_level>(), capacity, out)
    })?;
    assert!(count.is_none_or(|count| count == facts.depth));
    Ok(())
}

/// The mesh of a tree is a new handle.
fn copy(world: &mut World, at: usize, bytes: &mut Unstructured) -> Result<()> {
    let mut call = Call::default();
    let Grown { handle, shape } = &world.trees[at];
    let tree = call.given(bytes, &**handle)?;
    let Some(handle) = call.own(bytes, |out| punctual_tree_mesh(tree, out))? else {
        return Ok(());
    };
    let facts = Call::default().fill(bytes, |out| unsafe {
        punctual_mesh_describe(Some(&handle), out)
    })?;
    let (triangles, vertices) = (shape.mesh.len(), shape.mesh.vertex_count());
    assert!(facts.is_none_or(|facts| (facts.triangles, facts.vertices) == (triangles, vertices)));
    punctual_mesh_free(Some(handle));
    Ok(())
}

/// A tree goes into bytes and comes back, unless they are damaged.
fn ship(world: &mut World, at: usize, bytes: &mut Unstructured) -> Result<()> {
    let mut call = Call::default();
    let Grown { handle, shape } = &world.trees[at];
    let Some(length) =
        // SAFETY: nothing is written.
        Call::default().make(bytes, |out| unsafe { punctual_tree_to_bytes(Some(handle), std::ptr::null_mut(), 0, out) })?
    else {
        return Ok(());
    };
    let tree = call.given(bytes, &**handle)?;
    let mut file = vec![
        0xa5_u8;
        if bytes.ratio(1, 8)? {
            bytes.int_in_range(0..=length + 9)?
        } else {
            length
        }
    ];
    let (first, capacity) = call.array(bytes, file.as_mut_ptr(), file.len())?;
    // SAFETY: there is room for as many as said, or it is refused.
    if call.make(bytes, |out| unsafe {
        punctual_tree_to_bytes(tree, first, capacity, out)
    })? != Some(length)
    {
        return Ok(());
    }
    assert!(
        file.iter().skip(length).all(|&byte| byte == 0xa5),
        "written beyond the last"
    );
    let mut damaged = file.len() != length;
    if !file.is_empty() && bytes.ratio(1, 4)? {
        let (place, change) = (bytes.choose_index(file.len())?, bytes.arbitrary::<u8>()?);
        file[place] ^= change;
        damaged |= change != 0;
    }
    let mut call = Call::default();
    call.fault(damaged, Status::BadFile);
    let (first, count) = call.array(bytes, file.as_mut_ptr(), file.len())?;
    // SAFETY: as long as said, or refused.
    if let Some(handle) = call.own(bytes, |out| unsafe {
        punctual_tree_from_bytes(first, count, out)
    })? {
        let grown = Grown {
            handle,
            shape: Shape::new(shape.mesh.clone()),
        };
        tell(&grown, bytes)?;
        let old = std::mem::replace(&mut world.trees[at], grown);
        punctual_tree_free(Some(old.handle));
    }
    Ok(())
}
