//! What a glTF file consists of: the document alone, or chunks with the document and bytes.

use serde::Deserialize;
use serde_json::Value;

use crate::notice::Notices;
use crate::text::{decode, without_padding};
use crate::{Place, ReadError};

use super::json::Root;

const HEADER: usize = 12;
const JSON: &[u8] = b"JSON";
const BINARY: &[u8] = b"BIN\0";

/// The document, and the bytes of the binary chunk, if there is one.
pub fn open<'b>(
    bytes: &'b [u8],
    notices: &mut Notices,
) -> Result<(Root, Option<&'b [u8]>), ReadError> {
    if !bytes.starts_with(b"glTF") {
        return Ok((document(bytes, notices, Place::Line)?, None));
    }
    match number(bytes, 4) {
        None => return Err(ReadError::new("no glTF binary: the header is damaged")),
        Some(1) => return Err(ReadError::needs("glTF 1")),
        Some(_) => {}
    }
    let mut at = HEADER;
    let json = chunk(bytes, &mut at)?.filter(|(kind, _)| *kind == JSON);
    let (_, json) = json.ok_or_else(|| ReadError::new("no glTF binary: the header is damaged"))?;
    let root = document(json, notices, |_| Place::Byte(HEADER + 8))?;
    let end = number(bytes, 8).unwrap_or(0).max(at);
    let mut binary = None;
    while binary.is_none() && at < end {
        let Some((kind, content)) = chunk(bytes, &mut at)? else {
            break;
        };
        binary = (kind == BINARY).then_some(content);
    }
    let rest = bytes.len().saturating_sub(end.max(at));
    if rest > 0 {
        notices.add(
            Place::Byte(bytes.len() - rest),
            format!("{rest} bytes after the end passed over"),
        );
    }
    Ok((root, binary))
}

fn number(bytes: &[u8], at: usize) -> Option<usize> {
    bytes
        .get(at..)?
        .first_chunk()
        .map(|&n| u32::from_le_bytes(n) as usize)
}

/// The kind and the content of a chunk.
type Chunk<'b> = (&'b [u8], &'b [u8]);

/// The next chunk. Nothing if fewer bytes are left than its head takes.
fn chunk<'b>(bytes: &'b [u8], at: &mut usize) -> Result<Option<Chunk<'b>>, ReadError> {
    let Some(length) = number(bytes, *at) else {
        return Ok(None);
    };
    let Some(kind) = bytes.get(*at + 4..*at + 8) else {
        return Ok(None);
    };
    let content = bytes[*at + 8..].get(..length).ok_or_else(|| {
        let what = format!(
            "a chunk of {length} bytes, of which the file has {}",
            bytes.len() - *at - 8
        );
        ReadError::at(Place::Byte(*at), what)
    })?;
    *at += 8 + length;
    Ok(Some((kind, content)))
}

/// Reads JSON; `place` says where in the file one of its lines is.
fn document(
    json: &[u8],
    notices: &mut Notices,
    place: impl Fn(usize) -> Place,
) -> Result<Root, ReadError> {
    let text = decode(json);
    let text = without_padding(&text, notices);
    let root = serde_json::from_str::<Root>(text);
    let fault = |error: serde_json::Error| {
        ReadError::at(place(error.line()), format!("invalid glTF: {error}"))
    };
    // The first version has another structure, so that it cannot be read as a whole.
    if root.as_ref().map_or_else(
        |_| is_first_version(text),
        |root| root.asset.version.starts_with("1."),
    ) {
        return Err(ReadError::needs("glTF 1"));
    }
    root.map_err(fault)
}

/// Whether a document is of glTF 1, in which the accessors have names.
fn is_first_version(text: &str) -> bool {
    #[derive(Deserialize)]
    struct Head {
        accessors: Value,
    }
    serde_json::from_str(text).is_ok_and(|head: Head| head.accessors.is_object())
}
