//! COLLADA: the meshes that the scene shows, moved by their nodes in f64.
//!
//! Coordinates are brought to metres by the unit of the file. Its up axis turns nothing: robot descriptions count on
//! that, and `ReadOptions::up` is there for others.

use std::collections::HashMap;
use std::str::FromStr;

use punctual::glam::{DAffine3, DMat4, DQuat, DVec3};
use roxmltree::{Document, Node};

use crate::notice::Notices;
use crate::text::{decode, shorten, without_late_declaration};
use crate::xml::{attribute, child, line};
use crate::{Limits, Place, ReadError, ReadOptions, Surface, polygon};

/// Most nodes within one another.
const DEEPEST: usize = 100;

pub(crate) fn parse(
    bytes: &[u8],
    options: &ReadOptions,
    notices: &mut Notices,
) -> Result<Surface, ReadError> {
    let text = decode(bytes);
    let text = without_late_declaration(&text);
    let document = Document::parse(&text).map_err(|error| {
        let line = error.pos().row as usize;
        ReadError::at_line(line, error.to_string())
    })?;
    let root = document.root_element();
    if !root.has_tag_name("COLLADA") {
        return fail(root, "the outermost element is not `COLLADA`");
    }
    let by_id = |node: Node<'_, '_>| Some((node.attribute("id")?.to_owned(), node.id()));
    let asset = child(root, "asset");
    let unit = asset.and_then(|asset| child(asset, "unit")?.attribute("meter"));
    let unit = unit.map_or(Ok(1.0), str::parse).unwrap_or(f64::NAN);
    if !(unit > 0.0 && unit.is_finite()) {
        return fail(root, "the unit has no length above 0");
    }
    if let Some(up) = asset.and_then(|asset| child(asset, "up_axis"))
        && up.text().map(str::trim) != Some("Z_UP")
    {
        notices.add(
            place(up),
            "up axis other than Z: coordinates stay as they are",
        );
    }
    let least = |limit: usize| limit.max(bytes.len());
    let mut scene = Scene {
        ids: root.descendants().filter_map(by_id).collect(),
        limits: Limits::new(
            least(options.limits.vertices),
            least(options.limits.triangles),
        ),
        nodes: 0,
        surface: Surface::default(),
        notices,
    };
    let shown = child(root, "scene").and_then(|scene| child(scene, "instance_visual_scene"));
    let first = || child(child(root, "library_visual_scenes")?, "visual_scene");
    let shown = shown.map(|instance| scene.target(instance, "url"));
    if let Some(shown) = shown.transpose()?.or_else(first) {
        scene.visit(shown, DAffine3::from_scale(DVec3::splat(unit)), 0)?;
    }
    Ok(scene.surface)
}

/// The surface as far as it is put together.
struct Scene<'n> {
    ids: HashMap<String, roxmltree::NodeId>,
    limits: Limits,
    /// Nodes, as often as they were visited.
    nodes: usize,
    surface: Surface,
    notices: &'n mut Notices,
}

impl Scene<'_> {
    /// The element that an attribute refers to, in this file.
    fn target<'a, 'd>(&self, node: Node<'a, 'd>, name: &str) -> Result<Node<'a, 'd>, ReadError> {
        let url = attribute(node, name)?;
        let found = url.strip_prefix('#').and_then(|id| self.ids.get(id));
        match found.and_then(|&id| node.document().get_node(id)) {
            Some(found) => Ok(found),
            None => fail(node, format!("`{}` is not in this file", shorten(url))),
        }
    }

    /// Adds what a node or scene shows.
    fn visit(&mut self, node: Node, mut at: DAffine3, depth: usize) -> Result<(), ReadError> {
        self.nodes += 1;
        if depth > DEEPEST || self.nodes > self.limits.triangles {
            return fail(node, "too many nodes within nodes");
        }
        for part in node.children().filter(Node::is_element) {
            match part.tag_name().name() {
                "matrix" => {
                    let rows = DMat4::from_cols_array(&fixed(part)?).transpose();
                    if rows.row(3) != DVec3::ZERO.extend(1.0) {
                        return fail(part, "a matrix whose last row is not 0 0 0 1");
                    }
                    at *= DAffine3::from_mat4(rows);
                }
                "translate" => at *= DAffine3::from_translation(fixed(part)?.into()),
                "scale" => at *= DAffine3::from_scale(fixed(part)?.into()),
                "rotate" => {
                    let [x, y, z, angle]: [f64; 4] = fixed(part)?;
                    let axis = DVec3::new(x, y, z).normalize_or_zero();
                    at *= DAffine3::from_quat(DQuat::from_axis_angle(axis, angle.to_radians()));
                }
                "node" => self.visit(part, at, depth + 1)?,
                "instance_node" => self.visit(self.target(part, "url")?, at, depth + 1)?,
                "instance_geometry" => self.add(self.target(part, "url")?, at)?,
                kind @ ("instance_controller" | "lookat" | "skew") => {
                    return Err(ReadError::needs(format_args!("COLLADA's {kind}")));
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Adds a geometry.
    fn add(&mut self, geometry: Node, at: DAffine3) -> Result<(), ReadError> {
        let Some(mesh) = geometry.children().find(Node::is_element) else {
            return fail(geometry, "a geometry without a mesh");
        };
        // A convex mesh has the parts of a mesh, or names the geometry whose hull it is.
        let kind = mesh.tag_name().name();
        if !matches!(kind, "mesh" | "convex_mesh") || mesh.has_attribute("convex_hull_of") {
            return Err(ReadError::needs(match kind {
                "convex_mesh" => "COLLADA's convex_mesh with convex_hull_of",
                _ => "a COLLADA geometry other than `mesh` and `convex_mesh`",
            }));
        }
        let first = self.surface.triangles.len();
        let base = self.surface.vertices.len();
        if let Some(vertices) = child(mesh, "vertices") {
            let moved = |p: [f64; 3]| at.transform_point3(p.into()).to_array();
            let positions = self.positions(vertices)?;
            self.surface
                .vertices
                .extend(positions.into_iter().map(moved));
        }
        for part in mesh.children().filter(Node::is_element) {
            match part.tag_name().name() {
                "triangles" | "polylist" | "polygons" | "tristrips" | "trifans" => {
                    self.add_primitive(part, base)?;
                }
                "lines" | "linestrips" => self.notices.add(place(part), "lines passed over"),
                _ => {}
            }
        }
        let Surface {
            vertices,
            triangles,
            ..
        } = &mut self.surface;
        if at.matrix3.determinant() < 0.0 {
            triangles[first..]
                .iter_mut()
                .for_each(|triangle| triangle.swap(1, 2));
        }
        if vertices.len() > self.limits.vertices || triangles.len() > self.limits.triangles {
            return fail(
                geometry,
                "too large, since nodes use meshes again and again",
            );
        }
        Ok(())
    }

    fn positions(&self, vertices: Node) -> Result<Vec<[f64; 3]>, ReadError> {
        let source = self.target(input(vertices, "POSITION")?, "source")?;
        let accessor = source
            .descendants()
            .find(|node| node.has_tag_name("accessor"));
        let Some(accessor) = accessor else {
            return fail(source, "a source without an accessor");
        };
        let number = |name, missing| accessor.attribute(name).map_or(Ok(missing), str::parse);
        let (Ok(stride), Ok(offset)) = (number("stride", 1), number("offset", 0)) else {
            return fail(accessor, "stride and offset must be whole numbers");
        };
        let floats: Vec<f64> = numbers(self.target(accessor, "source")?)?;
        if stride < 3 || offset > floats.len() {
            return fail(accessor, "positions that are not three numbers each");
        }
        let each = floats[offset..].chunks(stride);
        Ok(each.filter_map(|p| Some(*p.first_chunk::<3>()?)).collect())
    }

    fn add_primitive(&mut self, part: Node, base: usize) -> Result<(), ReadError> {
        let offsets = part.children().filter_map(|node| node.attribute("offset"));
        let stride = offsets
            .filter_map(|offset| offset.parse::<usize>().ok())
            .max();
        let vertex = attribute(input(part, "VERTEX")?, "offset")?;
        let (Ok(offset), Some(stride)) = (vertex.parse::<usize>(), stride) else {
            return fail(part, "offsets must be whole numbers");
        };
        let kind = part.tag_name().name();
        if kind == "polygons" && child(part, "ph").is_some() {
            return Err(ReadError::needs("a COLLADA polygon with holes"));
        }
        let counts = match child(part, "vcount").filter(|_| kind == "polylist") {
            Some(counts) => numbers(counts)?,
            None => Vec::new(),
        };
        let Surface {
            vertices,
            triangles,
            ..
        } = &mut self.surface;
        for list in part.children().filter(|node| node.has_tag_name("p")) {
            let indices: Vec<usize> = numbers(list)?;
            let mut corners = Vec::with_capacity(indices.len() / (stride + 1));
            for corner in indices.chunks(stride + 1) {
                match corner
                    .get(offset)
                    .and_then(|&index| index.checked_add(base))
                {
                    Some(index) if index < vertices.len() => corners.push(index as u32),
                    _ => return fail(list, "a vertex that there is not"),
                }
            }
            let mut polygon = |corners: &[u32]| {
                if let Some(oddity) = polygon::fill(corners, vertices, triangles) {
                    self.notices.add(place(list), oddity);
                }
            };
            match kind {
                "triangles" => corners.chunks(3).for_each(polygon),
                "polylist" => {
                    let mut rest = &corners[..];
                    for &count in &counts {
                        let Some((own, others)) = rest.split_at_checked(count) else {
                            return fail(list, "ends before the last polygon");
                        };
                        polygon(own);
                        rest = others;
                    }
                }
                "tristrips" => polygon::strip(&corners, vertices, triangles),
                "trifans" => {
                    let fan = corners.windows(2).skip(1);
                    triangles.extend(fan.map(|edge| [corners[0], edge[0], edge[1]]));
                }
                _ => polygon(&corners),
            }
        }
        Ok(())
    }
}

fn place(node: Node) -> Place {
    Place::Line(line(node) as usize)
}

fn fail<T>(node: Node, what: impl Into<String>) -> Result<T, ReadError> {
    Err(ReadError::at(place(node), what))
}

fn input<'a, 'd>(node: Node<'a, 'd>, semantic: &str) -> Result<Node<'a, 'd>, ReadError> {
    let mut inputs = node.children().filter(|node| node.has_tag_name("input"));
    match inputs.find(|input| input.attribute("semantic") == Some(semantic)) {
        Some(input) => Ok(input),
        None => fail(node, format!("no input {semantic}")),
    }
}

/// The numbers of an element's text.
fn numbers<T: FromStr>(node: Node) -> Result<Vec<T>, ReadError> {
    let words = node.text().unwrap_or_default().split_ascii_whitespace();
    let number = |word: &str| match word.parse() {
        Ok(number) => Ok(number),
        Err(_) => fail(
            node,
            format!("\"{}\" is not a number it can have", shorten(word)),
        ),
    };
    words.map(number).collect()
}

fn fixed<const N: usize>(node: Node) -> Result<[f64; N], ReadError> {
    match numbers(node)?.try_into() {
        Ok(numbers) => Ok(numbers),
        Err(_) => fail(node, format!("must have {N} numbers")),
    }
}
