//! glTF binary, by `gltf`: every triangle primitive of the default scene, moved by its node's transform in f64.
//!
//! The crate checks the document, but not that accessors stay inside the buffer, that the nodes form a tree, nor how large all
//! uses of a mesh become; this is checked here before anything is read. Skins and morphs are refused: they have no surface
//! without a pose.

use gltf::accessor::{DataType, Dimensions, Iter};
use gltf::buffer::Source;
use gltf::mesh::Mode;
use gltf::scene::Transform;
use gltf::{Accessor, Document, Gltf, Node, Primitive, Semantic};
use punctual::glam::{DAffine3, DMat4, DQuat, DVec3};

use crate::{Limits, ReadError, Surface};

const HEADER: u32 = 12;

pub(crate) fn parse(bytes: &[u8], limits: &Limits) -> Result<Surface, ReadError> {
    // The crate subtracts the size of the header from the length without a look.
    let length = bytes.get(8..12).map(|n| u32::from_le_bytes([n[0], n[1], n[2], n[3]]));
    if !bytes.starts_with(b"glTF") || length.is_none_or(|length| length < HEADER) {
        return Err(ReadError::new("no glTF binary: the header is damaged"));
    }
    let Gltf { document, blob } = read_document(bytes).map_err(|error| ReadError::new(error.to_string()))?;
    let [vertices, triangles] = [limits.vertices, limits.triangles].map(|n| n.max(bytes.len()).min(u32::MAX as usize));
    let mut scene = Scene {
        blob: blob.unwrap_or_default(),
        limits: Limits::new(vertices, triangles),
        primitives: 0,
        surface: Surface::default(),
    };
    for (node, transform) in placed_nodes(&document)? {
        scene.add(&node, transform).map_err(|what| ReadError::new(format!("node {}: {what}", node.index())))?;
    }
    Ok(scene.surface)
}

fn read_document(bytes: &[u8]) -> Result<Gltf, Box<dyn std::error::Error>> {
    let Gltf { document, blob } = Gltf::from_slice_without_validation(bytes)?;
    let root = document.into_json();
    // The crate's own validation indexes the accessors of positions before it has checked that they exist.
    let primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let mut accessors = primitives.flat_map(|primitive| primitive.attributes.values());
    if let Some(missing) = accessors.find(|index| index.value() >= root.accessors.len()) {
        return Err(format!("accessor {} does not exist", missing.value()).into());
    }
    Ok(Gltf { document: Document::from_json(root)?, blob })
}

/// The nodes of the default scene, parents first, with their transforms to the scene.
fn placed_nodes(document: &Document) -> Result<Vec<(Node<'_>, DAffine3)>, ReadError> {
    let scene = document.default_scene().or_else(|| document.scenes().next());
    let scene = scene.ok_or_else(|| ReadError::new("the file has no scene"))?;
    let mut waiting: Vec<_> = scene.nodes().map(|node| (node, DAffine3::IDENTITY)).collect();
    waiting.reverse();
    let mut is_placed = vec![false; document.nodes().len()];
    let mut placed = Vec::new();
    while let Some((node, parent)) = waiting.pop() {
        let fault = |what: &str| ReadError::new(format!("node {}: {what}", node.index()));
        if std::mem::replace(&mut is_placed[node.index()], true) {
            return Err(fault("it is there twice, so the nodes form no tree"));
        }
        let transform = parent * local_transform(&node).map_err(fault)?;
        if !transform.is_finite() {
            return Err(fault("its transform is not finite"));
        }
        let first_child = waiting.len();
        waiting.extend(node.children().map(|child| (child, transform)));
        waiting[first_child..].reverse();
        placed.push((node, transform));
    }
    Ok(placed)
}

fn local_transform(node: &Node<'_>) -> Result<DAffine3, &'static str> {
    match node.transform() {
        Transform::Matrix { matrix } => match matrix.map(|column| column[3]) {
            [0.0, 0.0, 0.0, 1.0] => {
                let columns = matrix.map(|column| column.map(f64::from));
                Ok(DAffine3::from_mat4(DMat4::from_cols_array_2d(&columns)))
            }
            _ => Err("its matrix is no affine map: the last row must be 0 0 0 1"),
        },
        Transform::Decomposed { translation, rotation, scale } => {
            let rotation = DQuat::from_array(rotation.map(f64::from));
            let [translation, scale] = [translation, scale].map(|v| DVec3::from_array(v.map(f64::from)));
            // Its entries are f32: without this the rotation would also scale, by up to 1e-7.
            Ok(DAffine3::from_scale_rotation_translation(scale, rotation.normalize(), translation))
        }
    }
}

/// The surface as far as it is put together.
struct Scene {
    blob: Vec<u8>,
    limits: Limits,
    /// Primitives, as often as they were used.
    primitives: usize,
    surface: Surface,
}

impl Scene {
    fn add(&mut self, node: &Node<'_>, transform: DAffine3) -> Result<(), String> {
        let Some(mesh) = node.mesh() else { return Ok(()) };
        let weights = node.weights().or(mesh.weights()).unwrap_or_default();
        if node.skin().is_some() || weights.iter().any(|&weight| weight != 0.0) {
            return Err("skins and morphs are not supported".into());
        }
        for primitive in mesh.primitives() {
            let added = self.add_primitive(&primitive, transform);
            added.map_err(|what| format!("mesh {}, primitive {}: {what}", mesh.index(), primitive.index()))?;
        }
        Ok(())
    }

    fn add_primitive(&mut self, primitive: &Primitive<'_>, transform: DAffine3) -> Result<(), String> {
        let Self { blob, surface, .. } = self;
        if matches!(primitive.mode(), Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            let positions = primitive.get(&Semantic::Positions).ok_or("no POSITION")?;
            if (positions.data_type(), positions.dimensions()) != (DataType::F32, Dimensions::Vec3) {
                return Err("POSITION must be three f32".into());
            }
            let positions: Vec<[f32; 3]> = values(positions, blob)?;
            let base = surface.vertices.len();
            let moved = positions.iter().map(|p| transform.transform_point3(DVec3::from_array(p.map(f64::from))));
            surface.vertices.extend(moved.map(|p| p.to_array()));
            let corners = match primitive.indices() {
                Some(accessor) => indices(accessor, blob)?,
                None => (0..positions.len() as u32).collect(),
            };
            for &corner in &corners {
                let vertex = surface.vertices.get(base + corner as usize);
                let vertex = vertex.ok_or_else(|| out_of_range(corner, positions.len()))?;
                if !vertex.iter().all(|x| x.is_finite()) {
                    return Err(format!("vertex {corner} is not finite where its node puts it"));
                }
            }
            add_triangles(&mut surface.triangles, primitive.mode(), &corners, base as u32)?;
        }
        self.primitives += 1;
        self.check_limits()
    }

    /// Whether all uses of all meshes so far are within the limits. What one use adds is in the file as it is.
    fn check_limits(&self) -> Result<(), String> {
        let Self { limits, surface, primitives, .. } = self;
        let counts = [
            (surface.vertices.len(), limits.vertices, "vertices"),
            (surface.triangles.len(), limits.triangles, "triangles"),
            (*primitives, limits.triangles, "primitives"),
        ];
        match counts.into_iter().find(|(count, limit, _)| count > limit) {
            Some((_, limit, what)) => Err(format!("more than {limit} {what}, since nodes use meshes again and again")),
            None => Ok(()),
        }
    }
}

fn out_of_range(index: u32, count: usize) -> String {
    format!("vertex index {index} is out of range: {count} vertices")
}

fn add_triangles(triangles: &mut Vec<[u32; 3]>, mode: Mode, corners: &[u32], base: u32) -> Result<(), String> {
    let vertices = |corners: [u32; 3]| corners.map(|corner| corner + base);
    match mode {
        Mode::TriangleStrip => triangles.extend(corners.windows(3).map(|w| vertices([w[0], w[1], w[2]]))),
        Mode::TriangleFan => {
            let fan = corners.windows(2).skip(1);
            triangles.extend(fan.map(|edge| vertices([corners[0], edge[0], edge[1]])));
        }
        _ if !corners.len().is_multiple_of(3) => return Err(format!("{} corners are no triangles", corners.len())),
        _ => triangles.extend(corners.chunks_exact(3).map(|c| vertices([c[0], c[1], c[2]]))),
    }
    Ok(())
}

fn indices(accessor: Accessor<'_>, blob: &[u8]) -> Result<Vec<u32>, String> {
    match (accessor.data_type(), accessor.dimensions()) {
        (DataType::U8, Dimensions::Scalar) => Ok(values::<u8>(accessor, blob)?.into_iter().map(u32::from).collect()),
        (DataType::U16, Dimensions::Scalar) => Ok(values::<u16>(accessor, blob)?.into_iter().map(u32::from).collect()),
        (DataType::U32, Dimensions::Scalar) => values(accessor, blob),
        _ => Err("vertex indices must be u8, u16 or u32".into()),
    }
}

/// The values of an accessor, after a check that all of them lie inside the binary chunk.
fn values<T: gltf::accessor::Item>(accessor: Accessor<'_>, blob: &[u8]) -> Result<Vec<T>, String> {
    let name = accessor.index();
    let view = accessor.view().ok_or_else(|| format!("accessor {name} has no buffer view"))?;
    if accessor.sparse().is_some() {
        return Err(format!("accessor {name} is sparse, which is not supported"));
    }
    if !matches!(view.buffer().source(), Source::Bin) {
        return Err(format!("accessor {name} reads another file; pack it into the .glb"));
    }
    if accessor.count() == 0 {
        return Ok(Vec::new());
    }
    let size = size_of::<T>();
    let stride = view.stride().unwrap_or(size);
    let last = stride.checked_mul(accessor.count() - 1);
    let end = last.and_then(|last| last.checked_add(accessor.offset())?.checked_add(size));
    let fits = end.is_some_and(|end| end <= view.length())
        && view.offset().checked_add(view.length()).is_some_and(|end| end <= blob.len());
    if stride < size || !fits {
        return Err(format!("accessor {name} reaches outside the binary chunk"));
    }
    let values = Iter::new(accessor, |_| Some(blob)).ok_or("accessor cannot be read")?;
    Ok(values.collect())
}
