//! The header of a PLY file: what elements there are, of what properties, and how they are written.

use super::{AXES, CORNER_LISTS, STRIPS};
use crate::notice::Notices;
use crate::text::{decode, shorten};
use crate::{Place, ReadError};

#[derive(Clone, Copy, PartialEq)]
pub enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// A type of numbers.
#[derive(Clone, Copy, PartialEq)]
pub enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

pub struct Property {
    pub name: String,
    /// The type of the number of values, if the property is a list.
    pub count: Option<Kind>,
    pub kind: Kind,
}

pub struct Element {
    pub name: String,
    pub count: usize,
    pub properties: Vec<Property>,
}

pub struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// Lines of the header.
    pub lines: usize,
    /// Where the body begins.
    pub end: usize,
    /// The byte that ends a line.
    pub line_end: u8,
}

impl Kind {
    fn of(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// A type of whole numbers.
    fn whole(name: &str) -> Option<Self> {
        Self::of(name).filter(|kind| !matches!(kind, Self::F32 | Self::F64))
    }
}

impl Header {
    pub fn parse(bytes: &[u8], notices: &mut Notices) -> Result<Self, ReadError> {
        let mut encoding = None;
        let mut elements = Vec::new();
        let (mut lines, mut end) = (0, 0);
        let line_end = line_end(bytes);
        for line in bytes.split_inclusive(|&byte| byte == line_end) {
            (lines, end) = (lines + 1, end + line.len());
            let fault = |what: String| ReadError::at_line(lines, what);
            let text = decode(line);
            let fields: Vec<&str> = text.split_ascii_whitespace().collect();
            match fields[..] {
                ["ply"] if lines == 1 => {}
                _ if lines == 1 => {
                    return Err(fault("the first line of a PLY file must be `ply`".into()));
                }
                ["comment" | "obj_info", ..] | [] => {}
                ["format", name, ..] => encoding = Some(format(name).map_err(fault)?),
                ["element", name, count] => {
                    add_element(&mut elements, name, count).map_err(fault)?
                }
                ["property", ref kind @ .., name] => {
                    add_property(&mut elements, name, kind).map_err(fault)?
                }
                ["end_header"] => {
                    let encoding =
                        encoding.ok_or_else(|| fault("the header names no format".into()))?;
                    check(&elements, bytes.len()).map_err(fault)?;
                    return Ok(Self {
                        encoding,
                        elements,
                        lines,
                        end,
                        line_end,
                    });
                }
                // They say what the body holds.
                ["element" | "property" | "format", ..] => {
                    return Err(fault(format!(
                        "`{}` is no statement of a PLY header",
                        shorten(text.trim())
                    )));
                }
                [name, ..] => {
                    let what = format!(
                        "unknown statement `{}` in the header passed over",
                        shorten(name)
                    );
                    notices.add(Place::Line(lines), what);
                }
            }
        }
        Err(ReadError::new("no PLY file: its header has no end"))
    }
}

/// A carriage return if it ends the first line alone, as on old computers; else the line feed.
fn line_end(bytes: &[u8]) -> u8 {
    let mut ends = bytes
        .iter()
        .skip_while(|&&byte| byte != b'\n' && byte != b'\r');
    match (ends.next(), ends.next()) {
        (Some(b'\r'), next) if next != Some(&b'\n') => b'\r',
        _ => b'\n',
    }
}

fn format(name: &str) -> Result<Encoding, String> {
    match name {
        "ascii" => Ok(Encoding::Ascii),
        "binary_little_endian" => Ok(Encoding::LittleEndian),
        "binary_big_endian" => Ok(Encoding::BigEndian),
        _ => Err(format!("`{}` is no format of PLY files", shorten(name))),
    }
}

fn add_element(elements: &mut Vec<Element>, name: &str, count: &str) -> Result<(), String> {
    let count = count
        .parse()
        .map_err(|_| format!("`{}` is no number of elements", shorten(count)))?;
    if elements.iter().any(|element| element.name == name) {
        return Err(format!("element `{}` a second time", shorten(name)));
    }
    elements.push(Element {
        name: name.to_owned(),
        count,
        properties: Vec::new(),
    });
    Ok(())
}

fn add_property(elements: &mut [Element], name: &str, types: &[&str]) -> Result<(), String> {
    let (count, kind) = match types {
        ["list", count, kind] => (Kind::whole(count).map(Some), Kind::of(kind)),
        [kind] => (Some(None), Kind::of(kind)),
        _ => (None, None),
    };
    let (Some(count), Some(kind)) = (count, kind) else {
        return Err(format!(
            "property `{}` is of no type that there is",
            shorten(name)
        ));
    };
    let element = elements.last_mut().ok_or("a property of no element")?;
    let is_twice = element
        .properties
        .iter()
        .any(|property| property.name == name);
    if is_twice && (AXES.contains(&name) || CORNER_LISTS.contains(&name)) {
        return Err(format!("property `{}` a second time", shorten(name)));
    }
    element.properties.push(Property {
        name: name.to_owned(),
        count,
        kind,
    });
    Ok(())
}

/// Whether there is what a surface needs, and no more than a file of so many bytes can hold.
fn check(elements: &[Element], bytes: usize) -> Result<(), String> {
    if let Some(Element { name, count, .. }) = elements.iter().find(|element| element.count > bytes)
    {
        return Err(format!(
            "{count} elements `{}` do not fit into {bytes} bytes",
            shorten(name)
        ));
    }
    let named = |name: &str| elements.iter().find(|element| element.name == name);
    let vertex = named("vertex").ok_or("the file has no element `vertex`")?;
    let is_number = |axis: &str| {
        vertex
            .properties
            .iter()
            .any(|p| p.name == axis && p.count.is_none())
    };
    if !AXES.into_iter().all(is_number) {
        return Err("element `vertex` must have the properties x, y and z".into());
    }
    let faces = elements
        .iter()
        .filter(|element| ["face", STRIPS].contains(&element.name.as_str()));
    for Element {
        name: element,
        properties,
        ..
    } in faces
    {
        let is_list = |p: &&Property| CORNER_LISTS.contains(&p.name.as_str()) && p.count.is_some();
        match properties.iter().find(is_list) {
            None => {
                return Err(format!(
                    "element `{element}` must have a list `vertex_indices`"
                ));
            }
            Some(Property {
                kind: Kind::F32 | Kind::F64,
                name,
                ..
            }) => {
                return Err(format!("`{name}` must be a list of whole numbers"));
            }
            Some(_) => {}
        }
    }
    Ok(())
}
