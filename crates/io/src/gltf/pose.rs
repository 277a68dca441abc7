//! Where nodes, instances, morphs and skins put vertices.

use std::cell::OnceCell;
use std::collections::HashMap;

use punctual::glam::{DAffine3, DMat4, DQuat, DVec3};

use super::POSITION;
use super::accessor::Accessors;
use super::json::{Extensions, Instancing, Node, Primitive, Root};
use crate::notice::Notices;

/// The nodes of the default scene, parents first, with their transforms to the scene.
pub struct Placed {
    pub nodes: Vec<(usize, DAffine3)>,
}

impl Placed {
    pub fn new(root: &Root, notices: &mut Notices) -> Result<Self, String> {
        let mut waiting: Vec<_> = top_nodes(root, notices)?
            .into_iter()
            .rev()
            .map(|node| (node, DAffine3::IDENTITY))
            .collect();
        let mut is_placed = vec![false; root.nodes.len()];
        let mut nodes = Vec::new();
        while let Some((index, parent)) = waiting.pop() {
            let node = root
                .nodes
                .get(index)
                .ok_or_else(|| format!("node {index} does not exist"))?;
            let fault = |what: &str| format!("node {index}: {what}");
            if std::mem::replace(&mut is_placed[index], true) {
                return Err(fault("it is there twice, so the nodes form no tree"));
            }
            let transform = parent * local_transform(node).map_err(fault)?;
            if !transform.is_finite() {
                return Err(fault("its transform is not finite"));
            }
            waiting.extend(node.children.iter().rev().map(|&child| (child, transform)));
            nodes.push((index, transform));
        }
        Ok(Self { nodes })
    }
}

/// The nodes of the default scene that have no parents; without a scene, all that have none.
fn top_nodes(root: &Root, notices: &mut Notices) -> Result<Vec<usize>, String> {
    if root.scenes.is_empty() {
        let mut has_parent = vec![false; root.nodes.len()];
        let children = root.nodes.iter().flat_map(|node| &node.children);
        children.for_each(|&child| {
            has_parent
                .get_mut(child)
                .into_iter()
                .for_each(|has| *has = true)
        });
        if root.nodes.is_empty() {
            return Err("the file has no scene".into());
        }
        notices.add(None, "the file has no scene; all its nodes are read");
        return Ok((0..root.nodes.len())
            .filter(|&node| !has_parent[node])
            .collect());
    }
    let default = root.scene.unwrap_or(0);
    let scene = root
        .scenes
        .get(default)
        .ok_or_else(|| format!("scene {default} does not exist"))?;
    if root.scenes.len() > 1 {
        let what = format!(
            "{} scenes other than scene {default} passed over",
            root.scenes.len() - 1
        );
        notices.add(None, what);
    }
    Ok(scene.nodes.clone())
}

/// How far the last row of an affine matrix, written by a program that rounds, may be from 0 0 0 1.
const ROUNDING: f64 = 1e-5;

fn local_transform(node: &Node) -> Result<DAffine3, &'static str> {
    if let Some(matrix) = &node.matrix {
        return affine(matrix).ok_or("its matrix is no affine map: the last row must be 0 0 0 1");
    }
    let vector = |given: &Option<Box<[f64; 3]>>, default| {
        given.as_ref().map_or(default, |v| DVec3::from_array(**v))
    };
    let (translation, scale) = (
        vector(&node.translation, DVec3::ZERO),
        vector(&node.scale, DVec3::ONE),
    );
    Ok(decomposed(
        translation,
        node.rotation.as_deref().copied(),
        scale,
    ))
}

fn decomposed(translation: DVec3, rotation: Option<[f64; 4]>, scale: DVec3) -> DAffine3 {
    // Its entries are often f32: without this the rotation would also scale, by up to 1e-7.
    let rotation = rotation.map_or(DQuat::IDENTITY, |rotation| {
        DQuat::from_array(rotation).normalize()
    });
    DAffine3::from_scale_rotation_translation(scale, rotation, translation)
}

fn affine(matrix: &[f64; 16]) -> Option<DAffine3> {
    let row = [3, 7, 11, 15].map(|i| matrix[i]);
    let is_affine = row
        .into_iter()
        .zip([0.0, 0.0, 0.0, 1.0])
        .all(|(entry, exact)| (entry - exact).abs() <= ROUNDING);
    is_affine.then(|| DAffine3::from_mat4(DMat4::from_cols_array(matrix)))
}

/// The transforms by which a node uses its mesh: one that changes nothing, or those of its instances.
pub fn instances(accessors: &Accessors<'_>, node: &Node) -> Result<Vec<DAffine3>, String> {
    let Some(instancing) = node.extensions.get("EXT_mesh_gpu_instancing") else {
        return Ok(vec![DAffine3::IDENTITY]);
    };
    let Instancing { attributes } =
        serde_json::from_value(instancing.clone()).map_err(|error| error.to_string())?;
    let vectors = |name: &str| {
        attributes
            .get(name)
            .map(|&index| accessors.read::<3>(index, &node.extensions))
            .transpose()
    };
    let rotations = attributes
        .get("ROTATION")
        .map(|&index| accessors.read::<4>(index, &node.extensions))
        .transpose()?;
    let (translations, scales) = (vectors("TRANSLATION")?, vectors("SCALE")?);
    let lengths = [&translations, &scales].map(|vectors| vectors.as_ref().map(Vec::len));
    let mut lengths = lengths
        .into_iter()
        .chain([rotations.as_ref().map(Vec::len)])
        .flatten();
    let count = lengths.next().unwrap_or(0);
    if lengths.any(|other| other != count) {
        return Err("the attributes of its instances have different lengths".into());
    }
    let vector = |vectors: &Option<Vec<[f64; 3]>>, i: usize, default: DVec3| {
        vectors
            .as_ref()
            .map_or(default, |vectors| DVec3::from_array(vectors[i]))
    };
    let instance = |i| {
        let rotation = rotations.as_ref().map(|rotations| rotations[i]);
        decomposed(
            vector(&translations, i, DVec3::ZERO),
            rotation,
            vector(&scales, i, DVec3::ONE),
        )
    };
    Ok((0..count).map(instance).collect())
}

/// Moves vertices by the morph targets that have a weight.
pub fn morph(
    accessors: &Accessors<'_>,
    primitive: &Primitive,
    weights: &[f64],
    positions: &mut [[f64; 3]],
) -> Result<(), String> {
    for (target, &weight) in primitive.targets.iter().zip(weights) {
        let Some(&offsets) = target.get(POSITION).filter(|_| weight != 0.0) else {
            continue;
        };
        let offsets = accessors.read::<3>(offsets, &primitive.extensions)?;
        if offsets.len() != positions.len() {
            return Err(format!(
                "a morph target of {} vertices, must be {}",
                offsets.len(),
                positions.len()
            ));
        }
        let moved = positions
            .as_flattened_mut()
            .iter_mut()
            .zip(offsets.as_flattened());
        moved.for_each(|(x, offset)| *x += weight * offset);
    }
    Ok(())
}

/// The joints of the skins of a document, where its nodes put them.
pub struct Skins<'a> {
    accessors: &'a Accessors<'a>,
    placed: HashMap<usize, DAffine3>,
    /// Of each skin the transforms of its joints from the mesh to the scene, from its first use on.
    joints: Vec<OnceCell<Result<Vec<DAffine3>, String>>>,
}

impl<'a> Skins<'a> {
    pub fn new(accessors: &'a Accessors<'a>, placed: &Placed) -> Self {
        let joints = accessors
            .root
            .skins
            .iter()
            .map(|_| OnceCell::new())
            .collect();
        // Without skins nobody asks.
        let placed = if accessors.root.skins.is_empty() {
            HashMap::new()
        } else {
            placed.nodes.iter().copied().collect()
        };
        Self {
            accessors,
            placed,
            joints,
        }
    }

    /// Puts vertices where the joints of a skin take them, and tells whether that mirrors the mesh, as its first joint
    /// does. The
    /// node of the mesh has no say in it.
    pub fn bend(
        &self,
        skin: usize,
        primitive: &Primitive,
        positions: &mut [[f64; 3]],
    ) -> Result<bool, String> {
        let joints = self
            .joints
            .get(skin)
            .ok_or_else(|| format!("skin {skin} does not exist"))?;
        let joints = joints
            .get_or_init(|| self.transforms(skin))
            .as_ref()
            .map_err(String::clone)?;
        let mut moved = vec![(DVec3::ZERO, 0.0); positions.len()];
        for set in 0.. {
            let accessor = |name: &str| primitive.attributes.get(&format!("{name}_{set}"));
            let (Some(&numbers), Some(&weights)) = (accessor("JOINTS"), accessor("WEIGHTS")) else {
                break;
            };
            let numbers = self.accessors.read::<4>(numbers, &primitive.extensions)?;
            let weights = self.accessors.read::<4>(weights, &primitive.extensions)?;
            if [numbers.len(), weights.len()] != [positions.len(); 2] {
                return Err("joints or weights of another number than the vertices".into());
            }
            for (((point, sum), position), (numbers, weights)) in moved
                .iter_mut()
                .zip(&*positions)
                .zip(numbers.into_iter().zip(weights))
            {
                for (number, weight) in numbers
                    .into_iter()
                    .zip(weights)
                    .filter(|&(_, weight)| weight != 0.0)
                {
                    let joint = joints
                        .get(number as usize)
                        .ok_or_else(|| format!("skin {skin} has no joint {number}"))?;
                    *point += weight * joint.transform_point3(DVec3::from_array(*position));
                    *sum += weight;
                }
            }
        }
        for (position, (point, sum)) in positions.iter_mut().zip(moved) {
            // Their sum is 1 but for rounding, which would scale.
            *position = (point / sum).to_array();
        }
        Ok(joints
            .first()
            .is_some_and(|joint| joint.matrix3.determinant() < 0.0))
    }

    fn transforms(&self, skin: usize) -> Result<Vec<DAffine3>, String> {
        let json = &self.accessors.root.skins[skin];
        let inverse = json
            .inverse_bind_matrices
            .map(|index| self.accessors.read::<16>(index, &Extensions::new()));
        let inverse = inverse.transpose()?;
        let transform = |(i, joint): (usize, &usize)| {
            let fault = |what: &str| format!("skin {skin}: {what}");
            let placed = self
                .placed
                .get(joint)
                .ok_or_else(|| fault("a joint is no node of the scene"))?;
            let Some(inverse) = &inverse else {
                return Ok(*placed);
            };
            let matrix = inverse
                .get(i)
                .ok_or_else(|| fault("fewer bind matrices than joints"))?;
            Ok(*placed * affine(matrix).ok_or_else(|| fault("a bind matrix is no affine map"))?)
        };
        json.joints.iter().enumerate().map(transform).collect()
    }
}
