//! glTF binary, by `gltf`: every triangle primitive of the default scene, moved by its node's transform in f64.
//!
//! The crate checks the document, but not that accessors stay inside the buffer, nor that the nodes form a tree; both
//! are checked here before anything is read. Skins and morphs are refused: they have no surface without a pose.

use gltf::accessor::{DataType, Dimensions, Iter};
use gltf::buffer::Source;
use gltf::mesh::Mode;
use gltf::scene::Transform;
use gltf::{Accessor, Document, Gltf, Node, Primitive, Semantic};
use punctual::glam::{DAffine3, DMat4, DQuat, DVec3};

use super::{Fault, Surface};

const HEADER: u32 = 12;

pub fn parse(bytes: &[u8]) -> Result<Surface, Fault> {
    // The crate subtracts the size of the header from the length without a look.
    let length = bytes.get(8..12).map(|n| u32::from_le_bytes([n[0], n[1], n[2], n[3]]));
    if !bytes.starts_with(b"glTF") || length.is_none_or(|length| length < HEADER) {
        return Err(Fault::new("no glTF binary: the header is damaged"));
    }
    let Gltf { document, blob } = read_document(bytes).map_err(|error| Fault::new(error.to_string()))?;
    let blob = blob.unwrap_or_default();
    let mut surface = Surface::default();
    for (node, transform) in placed_nodes(&document)? {
        let Some(mesh) = node.mesh() else { continue };
        let weights = node.weights().or(mesh.weights()).unwrap_or_default();
        if node.skin().is_some() || weights.iter().any(|&weight| weight != 0.0) {
            return Err(Fault::new(format!("node {}: skins and morphs are not supported", node.index())));
        }
        for primitive in mesh.primitives() {
            add(&mut surface, &primitive, transform, &blob).map_err(|what| {
                Fault::new(format!("mesh {}, primitive {}: {what}", mesh.index(), primitive.index()))
            })?;
        }
    }
    Ok(surface)
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
fn placed_nodes(document: &Document) -> Result<Vec<(Node<'_>, DAffine3)>, Fault> {
    let scene = document.default_scene().or_else(|| document.scenes().next());
    let scene = scene.ok_or_else(|| Fault::new("the file has no scene"))?;
    let mut waiting: Vec<_> = scene.nodes().map(|node| (node, DAffine3::IDENTITY)).collect();
    waiting.reverse();
    let mut placed = Vec::new();
    while let Some((node, parent)) = waiting.pop() {
        let transform = parent * local_transform(&node);
        let first_child = waiting.len();
        waiting.extend(node.children().map(|child| (child, transform)));
        waiting[first_child..].reverse();
        placed.push((node, transform));
        if placed.len() + waiting.len() > document.nodes().len() {
            return Err(Fault::new("the nodes form no tree"));
        }
    }
    Ok(placed)
}

fn local_transform(node: &Node<'_>) -> DAffine3 {
    match node.transform() {
        Transform::Matrix { matrix } => {
            DAffine3::from_mat4(DMat4::from_cols_array_2d(&matrix.map(|column| column.map(f64::from))))
        }
        Transform::Decomposed { translation, rotation, scale } => {
            let rotation = DQuat::from_array(rotation.map(f64::from));
            let [translation, scale] = [translation, scale].map(|v| DVec3::from_array(v.map(f64::from)));
            // Its entries are f32: without this the rotation would also scale, by up to 1e-7.
            DAffine3::from_scale_rotation_translation(scale, rotation.normalize(), translation)
        }
    }
}

fn add(surface: &mut Surface, primitive: &Primitive<'_>, transform: DAffine3, blob: &[u8]) -> Result<(), String> {
    if !matches!(primitive.mode(), Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
        return Ok(());
    }
    let positions = primitive.get(&Semantic::Positions).ok_or("no POSITION")?;
    if (positions.data_type(), positions.dimensions()) != (DataType::F32, Dimensions::Vec3) {
        return Err("POSITION must be three f32".into());
    }
    let positions: Vec<[f32; 3]> = values(positions, blob)?;
    let indices = match primitive.indices() {
        Some(accessor) => indices(accessor, blob)?,
        None => (0..positions.len() as u32).collect(),
    };
    if let Some(index) = indices.iter().find(|&&index| index as usize >= positions.len()) {
        return Err(format!("vertex index {index} is out of range: {} vertices", positions.len()));
    }
    let base = surface.vertices.len();
    u32::try_from(base + positions.len()).map_err(|_| "more than 2^32 vertices")?;
    let moved = positions.iter().map(|p| transform.transform_point3(DVec3::from_array(p.map(f64::from))));
    surface.vertices.extend(moved.map(|p| p.to_array()));
    let corners = |corners: [u32; 3]| corners.map(|corner| corner + base as u32);
    match primitive.mode() {
        Mode::TriangleStrip => surface.triangles.extend(indices.windows(3).map(|w| corners([w[0], w[1], w[2]]))),
        Mode::TriangleFan => {
            let fan = indices.windows(2).skip(1);
            surface.triangles.extend(fan.map(|edge| corners([indices[0], edge[0], edge[1]])));
        }
        _ if indices.len() % 3 != 0 => {
            return Err(format!("{} corners are no triangles", indices.len()));
        }
        _ => surface.triangles.extend(indices.chunks_exact(3).map(|c| corners([c[0], c[1], c[2]]))),
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
