//! The parts of a glTF document that say where its triangles are. All else is skipped, so that a damaged material does
//! no harm.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde_json::Value;

/// Extensions by name, where they stand in the document.
pub type Extensions = BTreeMap<String, Value>;

#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct Root {
    pub asset: Asset,
    pub extensions_required: Vec<String>,
    pub scene: Option<usize>,
    pub scenes: Vec<Scene>,
    pub nodes: Vec<Node>,
    pub skins: Vec<Skin>,
    pub meshes: Vec<Mesh>,
    pub accessors: Vec<Accessor>,
    pub buffer_views: Vec<View>,
    pub buffers: Vec<Buffer>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub struct Asset {
    pub version: String,
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub struct Scene {
    pub nodes: Vec<usize>,
    pub extensions: Extensions,
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub struct Node {
    pub children: Vec<usize>,
    pub mesh: Option<usize>,
    pub skin: Option<usize>,
    pub weights: Option<Vec<f64>>,
    // In boxes, since most nodes lack most of them.
    pub matrix: Option<Box<[f64; 16]>>,
    pub translation: Option<Box<[f64; 3]>>,
    pub rotation: Option<Box<[f64; 4]>>,
    pub scale: Option<Box<[f64; 3]>>,
    pub extensions: Extensions,
}

#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct Skin {
    pub inverse_bind_matrices: Option<usize>,
    pub joints: Vec<usize>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub struct Mesh {
    pub primitives: Vec<Primitive>,
    pub weights: Option<Vec<f64>>,
    pub extensions: Extensions,
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub struct Primitive {
    pub attributes: BTreeMap<String, usize>,
    pub indices: Option<usize>,
    pub mode: Option<u32>,
    pub targets: Vec<BTreeMap<String, usize>>,
    pub extensions: Extensions,
}

/// `EXT_mesh_gpu_instancing` of a node.
#[derive(Default, Deserialize)]
#[serde(default)]
pub struct Instancing {
    pub attributes: BTreeMap<String, usize>,
}

#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct Accessor {
    pub buffer_view: Option<usize>,
    pub byte_offset: usize,
    pub component_type: u32,
    pub normalized: bool,
    pub count: usize,
    #[serde(rename = "type")]
    pub kind: String,
    pub sparse: Option<Sparse>,
    pub extensions: Extensions,
}

/// Values that replace some of an accessor's.
#[derive(Default, Deserialize)]
#[serde(default)]
pub struct Sparse {
    pub count: usize,
    pub indices: SparsePart,
    pub values: SparsePart,
}

#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct SparsePart {
    pub buffer_view: usize,
    pub byte_offset: usize,
    pub component_type: u32,
}

#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct View {
    pub buffer: usize,
    pub byte_offset: usize,
    pub byte_length: usize,
    pub byte_stride: Option<usize>,
    pub extensions: Extensions,
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub struct Buffer {
    pub uri: Option<String>,
    pub extensions: Extensions,
}

impl Root {
    /// The names of extensions that stand where a surface is described, with repetition.
    pub fn extensions_of_geometry(&self) -> impl Iterator<Item = &str> {
        let scenes = self.scenes.iter().map(|scene| &scene.extensions);
        let nodes = self.nodes.iter().map(|node| &node.extensions);
        let meshes = self.meshes.iter().map(|mesh| &mesh.extensions);
        let primitives = self
            .meshes
            .iter()
            .flat_map(|mesh| &mesh.primitives)
            .map(|primitive| &primitive.extensions);
        let accessors = self.accessors.iter().map(|accessor| &accessor.extensions);
        let views = self.buffer_views.iter().map(|view| &view.extensions);
        let buffers = self.buffers.iter().map(|buffer| &buffer.extensions);
        let all = scenes
            .chain(nodes)
            .chain(meshes)
            .chain(primitives)
            .chain(accessors)
            .chain(views)
            .chain(buffers);
        all.flat_map(|extensions| extensions.keys())
            .map(String::as_str)
    }
}
