//! PLY, ASCII and binary of both byte orders. Coordinates may be of any number type; `double` is kept.
//!
//! Read here and not by a crate: the maintained one refuses numbers such as `.25` and does not say where in a binary file a
//! fault is. Elements other than `vertex` and `face` are skipped, and so are their properties other than the coordinates and
//! the list of corners. In ASCII an element has a line; blank lines are skipped.

mod body;
mod header;

use crate::{Place, ReadError, Surface, polygon};
use body::Body;
use header::{Element, Header};

const AXES: [&str; 3] = ["x", "y", "z"];
const CORNER_LISTS: [&str; 2] = ["vertex_indices", "vertex_index"];

pub(crate) fn parse(bytes: &[u8]) -> Result<Surface, ReadError> {
    let header = Header::parse(bytes)?;
    let mut body = Body::new(bytes, &header);
    let mut surface = Surface::default();
    let mut faces = Faces::default();
    for element in &header.elements {
        for _ in 0..element.count {
            let place = body.begin(element)?;
            match element.name.as_str() {
                "vertex" => {
                    surface.vertices.push(vertex(&mut body, element)?);
                    surface.places.push(place);
                }
                "face" => {
                    corners(&mut body, element, &mut faces.corners)?;
                    faces.ends.push((faces.corners.len(), place));
                }
                _ => element.properties.iter().try_for_each(|property| body.skip(property))?,
            }
            body.end()?;
        }
    }
    body.finish()?;
    faces.fill(&mut surface)?;
    Ok(surface)
}

fn vertex(body: &mut Body<'_>, element: &Element) -> Result<[f64; 3], ReadError> {
    let mut vertex = [f64::NAN; 3];
    for property in &element.properties {
        match AXES.iter().position(|axis| *axis == property.name) {
            Some(axis) => vertex[axis] = body.number(property.kind)?,
            None => body.skip(property)?,
        }
    }
    Ok(vertex)
}

fn corners(body: &mut Body<'_>, element: &Element, corners: &mut Vec<f64>) -> Result<(), ReadError> {
    for property in &element.properties {
        match property.count {
            Some(count) if CORNER_LISTS.contains(&property.name.as_str()) => {
                for _ in 0..body.count(count)? {
                    corners.push(body.number(property.kind)?);
                }
            }
            _ => body.skip(property)?,
        }
    }
    Ok(())
}

/// Faces as they stand in the file, where they may come before the vertices.
#[derive(Default)]
struct Faces {
    /// The corners of all faces, one face after the other.
    corners: Vec<f64>,
    /// Where each face ends in `corners`, and where it stands in the file.
    ends: Vec<(usize, Place)>,
}

impl Faces {
    fn fill(&self, surface: &mut Surface) -> Result<(), ReadError> {
        let Surface { vertices, triangles, .. } = surface;
        let count = vertices.len();
        let index = |&corner: &f64| match corner >= 0.0 && corner < count as f64 {
            true => Ok(corner as u32),
            false => Err(format!("vertex index {corner} is out of range: {count} vertices, counted from 0")),
        };
        let mut start = 0;
        for &(end, place) in &self.ends {
            let indices: Result<Vec<u32>, String> = self.corners[start..end].iter().map(index).collect();
            let filled = indices.and_then(|indices| polygon::fill(&indices, vertices, triangles));
            filled.map_err(|what| ReadError::at(place, what))?;
            start = end;
        }
        Ok(())
    }
}
