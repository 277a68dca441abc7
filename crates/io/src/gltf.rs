//! glTF: every triangle primitive of the default scene, moved by its node's transform in f64.
//!
//! The document is read by `serde_json` into the few parts that say where triangles are, and not by the crate `gltf`:
//! that one
//! refuses documents for what does not concern their triangles (required extensions of materials, missing bounds), and
//! without its validation it panics where an index is out of range. Here every index is looked up, and every range
//! checked,
//! before anything is read. The transform of a node that mirrors turns triangles over, so that fronts stay fronts. A
//! skin
//! and morph weights pose a mesh as the document says, without its animations.

mod accessor;
mod buffers;
mod container;
mod json;
mod pose;

use std::cell::Cell;
use std::fmt;

use punctual::glam::{DAffine3, DVec3};

use crate::notice::Notices;
use crate::{Limits, ReadError, ReadOptions, Surface, polygon};
use accessor::Accessors;
use buffers::Buffers;
use json::{Node, Primitive, Root};
use pose::{Placed, Skins};

const POSITION: &str = "POSITION";

pub(crate) fn parse(
    bytes: &[u8],
    options: &ReadOptions,
    notices: &mut Notices,
) -> Result<Surface, ReadError> {
    let (root, chunk) = container::open(bytes, notices)?;
    refuse_extensions(&root)?;
    let least = |limit: usize| limit.max(bytes.len()).min(u32::MAX as usize);
    let limits = Limits::new(
        least(options.limits.vertices),
        least(options.limits.triangles),
    );
    let accessors = Accessors {
        root: &root,
        buffers: Buffers::new(&root.buffers, chunk, options),
        // Those of files that are in order are morphs of meshes that have bytes, or none at all.
        most_zeros: limits.vertices.min(bytes.len().max(1 << 20)),
        left: Cell::new(
            limits
                .vertices
                .saturating_add(limits.triangles)
                .saturating_mul(8),
        ),
    };
    let placed = Placed::new(&root, notices).map_err(ReadError::new)?;
    let mut scene = Scene {
        skins: Skins::new(&accessors, &placed),
        accessors: &accessors,
        limits,
        primitives: 0,
        surface: Surface::default(),
    };
    for &(node, transform) in &placed.nodes {
        scene
            .add(&root.nodes[node], transform, notices)
            .map_err(|what| ReadError::new(within(format_args!("node {node}"), &what)))?;
    }
    Ok(scene.surface)
}

/// A message with its place: in front, but behind what says first that something is not supported.
fn within(place: fmt::Arguments<'_>, what: &str) -> String {
    if what.starts_with("needs ") {
        format!("{what} ({place})")
    } else {
        format!("{place}: {what}")
    }
}

/// Extensions that say where triangles are, and are read.
const READ: [&str; 3] = [
    "KHR_mesh_quantization",
    "EXT_mesh_gpu_instancing",
    "KHR_accessor_float64",
];
/// Parts of the names of extensions that may stand at nodes, meshes and buffers, but leave the triangles alone.
const HARMLESS: [&str; 17] = [
    "_lights_",
    "_materials_",
    "_texture_",
    "_xmp",
    "_audio",
    "_features",
    "_metadata",
    "_visibility",
    "_selectability",
    "_hoverability",
    "_physics",
    "_lod",
    "_primitive_outline",
    "_mesh_manifold",
    "_articulations",
    "VRM",
    "OMI_",
];

/// Refuses documents with extensions that are required and may hold triangles, or change them.
fn refuse_extensions(root: &Root) -> Result<(), ReadError> {
    let is_known =
        |name: &str| READ.contains(&name) || HARMLESS.iter().any(|part| name.contains(part));
    let is_used = |name: &str| root.extensions_of_geometry().any(|used| used == name);
    let required = root
        .extensions_required
        .iter()
        .take(100)
        .map(String::as_str);
    let refused: Vec<&str> = required
        .filter(|name| !is_known(name) && is_used(name))
        .collect();
    if refused.is_empty() {
        Ok(())
    } else {
        Err(ReadError::needs(refused.join(", ")))
    }
}

/// The surface as far as it is put together.
struct Scene<'a> {
    accessors: &'a Accessors<'a>,
    skins: Skins<'a>,
    limits: Limits,
    /// Primitives, as often as they were used.
    primitives: usize,
    surface: Surface,
}

impl Scene<'_> {
    fn add(
        &mut self,
        node: &Node,
        transform: DAffine3,
        notices: &mut Notices,
    ) -> Result<(), String> {
        let Some(index) = node.mesh else {
            return Ok(());
        };
        let mesh = self
            .accessors
            .root
            .meshes
            .get(index)
            .ok_or_else(|| format!("mesh {index} does not exist"))?;
        let weights = node
            .weights
            .as_ref()
            .or(mesh.weights.as_ref())
            .map_or(&[][..], Vec::as_slice);
        for instance in pose::instances(self.accessors, node)? {
            for (i, primitive) in mesh.primitives.iter().enumerate() {
                let added = self.add_primitive(
                    primitive,
                    weights,
                    node.skin,
                    transform * instance,
                    notices,
                );
                self.primitives += 1;
                added
                    .and_then(|()| self.check_limits())
                    .map_err(|what| within(format_args!("mesh {index}, primitive {i}"), &what))?;
            }
        }
        Ok(())
    }

    fn add_primitive(
        &mut self,
        primitive: &Primitive,
        weights: &[f64],
        skin: Option<usize>,
        transform: DAffine3,
        notices: &mut Notices,
    ) -> Result<(), String> {
        let mode = primitive.mode.unwrap_or(TRIANGLES);
        if !(TRIANGLES..=FAN).contains(&mode) {
            notices.add(None, "points or lines of a primitive passed over");
            return Ok(());
        }
        let Some(&positions) = primitive.attributes.get(POSITION) else {
            notices.add(None, "primitive without POSITION passed over");
            return Ok(());
        };
        let extensions = &primitive.extensions;
        let mut positions = self.accessors.read::<3>(positions, extensions)?;
        let corners = match primitive.indices {
            Some(indices) => self.accessors.read_indices(indices, extensions)?,
            None => (0..positions.len() as u32).collect(),
        };
        pose::morph(self.accessors, primitive, weights, &mut positions)?;
        let is_mirrored = match skin {
            Some(skin) => self.skins.bend(skin, primitive, &mut positions)?,
            None => {
                positions.iter_mut().for_each(|p| {
                    *p = transform.transform_point3(DVec3::from_array(*p)).to_array()
                });
                transform.matrix3.determinant() < 0.0
            }
        };
        let Surface {
            vertices,
            triangles,
            ..
        } = &mut self.surface;
        let (base, first) = (vertices.len(), triangles.len());
        let corners = checked(&corners, &positions, base as u32)?;
        vertices.extend(positions);
        if !add_triangles(triangles, vertices, mode, &corners) {
            notices.add(
                None,
                "incomplete triangle at the end of a primitive passed over",
            );
        }
        if is_mirrored {
            triangles[first..]
                .iter_mut()
                .for_each(|triangle| triangle.swap(1, 2));
        }
        Ok(())
    }

    /// Whether all uses of all meshes so far are within the limits. What one use adds is in the file as it is.
    fn check_limits(&self) -> Result<(), String> {
        let Self {
            limits,
            surface,
            primitives,
            ..
        } = self;
        let counts = [
            (surface.vertices.len(), limits.vertices, "vertices"),
            (surface.triangles.len(), limits.triangles, "triangles"),
            (*primitives, limits.triangles, "primitives"),
        ];
        // Buffers beside the document hold as much as they are long; they are counted only where the limits do not do.
        let is_over = |&(count, limit, _): &(usize, usize, &str)| {
            count > limit && count > self.accessors.buffers.bytes_read()
        };
        match counts.into_iter().find(is_over) {
            Some((_, limit, what)) => Err(format!(
                "more than {limit} {what}, since nodes use meshes again and again"
            )),
            None => Ok(()),
        }
    }
}

/// The vertices of corners among those of the whole surface.
fn checked(corners: &[u32], positions: &[[f64; 3]], base: u32) -> Result<Vec<u32>, String> {
    let vertex = |&corner: &u32| match positions.get(corner as usize) {
        None => Err(format!(
            "vertex index {corner} is out of range: {} vertices",
            positions.len()
        )),
        Some(position) if !position.iter().all(|x| x.is_finite()) => Err(format!(
            "vertex {corner} is not finite where its node puts it"
        )),
        Some(_) => Ok(corner + base),
    };
    corners.iter().map(vertex).collect()
}

/// Modes of primitives.
const TRIANGLES: u32 = 4;
const STRIP: u32 = 5;
const FAN: u32 = 6;

/// Adds the triangles of a primitive, and tells whether no corner is left over.
fn add_triangles(
    triangles: &mut Vec<[u32; 3]>,
    vertices: &[[f64; 3]],
    mode: u32,
    corners: &[u32],
) -> bool {
    match mode {
        STRIP => polygon::strip(corners, vertices, triangles),
        FAN => {
            let fan = corners.windows(2).skip(1);
            triangles.extend(fan.map(|edge| [corners[0], edge[0], edge[1]]));
        }
        _ => {
            let (whole, rest) = corners.as_chunks::<3>();
            triangles.extend(whole);
            return rest.is_empty();
        }
    }
    true
}
