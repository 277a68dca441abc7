//! Where the bytes of a glTF document are: in the binary chunk, in data URIs, in files beside it.

use std::cell::OnceCell;
use std::path::PathBuf;

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use percent_encoding::percent_decode_str;

use super::json::Buffer;
use crate::ReadOptions;

pub struct Buffers<'a> {
    list: &'a [Buffer],
    /// The binary chunk, which is buffer 0 unless that has an address.
    chunk: Option<&'a [u8]>,
    options: &'a ReadOptions,
    /// Each from its first use on, so that files with images only need not be there.
    read: Vec<OnceCell<Result<Vec<u8>, String>>>,
}

impl<'a> Buffers<'a> {
    pub fn new(list: &'a [Buffer], chunk: Option<&'a [u8]>, options: &'a ReadOptions) -> Self {
        Self {
            list,
            chunk,
            options,
            read: list.iter().map(|_| OnceCell::new()).collect(),
        }
    }

    /// The bytes of a buffer; nothing if it has no address, as buffers of some extensions.
    pub fn get(&self, index: usize) -> Result<Option<&[u8]>, String> {
        let buffer = self
            .list
            .get(index)
            .ok_or_else(|| format!("buffer {index} does not exist"))?;
        let Some(uri) = &buffer.uri else {
            return Ok(self.chunk.filter(|_| index == 0));
        };
        let bytes = self.read[index].get_or_init(|| match uri.strip_prefix("data:") {
            Some(data) => {
                decode(data).ok_or_else(|| format!("buffer {index}: its data URI is no base64"))
            }
            None => self
                .load(uri)
                .map_err(|what| super::within(format_args!("buffer {index}"), &what)),
        });
        bytes
            .as_ref()
            .map(|bytes| Some(&bytes[..]))
            .map_err(String::clone)
    }

    /// Bytes read so far from elsewhere than the file.
    pub fn bytes_read(&self) -> usize {
        self.read
            .iter()
            .filter_map(|cell| cell.get()?.as_ref().ok())
            .map(Vec::len)
            .sum()
    }

    fn load(&self, uri: &str) -> Result<Vec<u8>, String> {
        let name = percent_decode_str(uri).decode_utf8_lossy();
        let name = PathBuf::from(&*name);
        if uri.contains("://") || name.is_absolute() {
            return Err(
                "needs a file that is named by a full address, which is not supported".into(),
            );
        }
        let Some(folder) = &self.options.folder else {
            return Err(
                "it is a file of its own, and the folder of the document is not known".into(),
            );
        };
        let file = folder.join(name);
        let fault = |what: &dyn std::fmt::Display| format!("{}: {what}", file.display());
        // Devices and pipes have no end.
        let metadata = std::fs::metadata(&file).map_err(|error| fault(&error))?;
        if !metadata.is_file() {
            return Err(fault(&"no file"));
        }
        // A document can name a large file again and again.
        let (before, limit) = (self.bytes_read(), self.options.limits.unpacked);
        if before > 0 && metadata.len() > limit.saturating_sub(before) as u64 {
            return Err(fault(&format_args!("buffers of more than {limit} bytes")));
        }
        let bytes = std::fs::read(&file).map_err(|error| fault(&error))?;
        crate::refuse_pointer(&bytes).map_err(|error| fault(&error))?;
        Ok(bytes)
    }
}

/// The bytes of a data URI, without its scheme.
fn decode(data: &str) -> Option<Vec<u8>> {
    let (kind, text) = data.split_once(',')?;
    let config = GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true);
    kind.ends_with(";base64")
        .then(|| GeneralPurpose::new(&STANDARD, config).decode(text).ok())
        .flatten()
}
