//! NumPy's files of one array: a header that describes it in Python's notation, then its numbers.

use crate::{Place, ReadError};

const MAGIC: &[u8] = b"\x93NUMPY";

pub fn parse(bytes: &[u8]) -> Result<Vec<[f64; 3]>, ReadError> {
    let rest = bytes
        .strip_prefix(MAGIC)
        .ok_or("no NumPy file: it does not begin with \\x93NUMPY")?;
    let (length, start) = match rest {
        [1, _, low, high, ..] => (
            usize::from(u16::from_le_bytes([*low, *high])),
            MAGIC.len() + 4,
        ),
        [2 | 3, _, a, b, c, d, ..] => (
            u32::from_le_bytes([*a, *b, *c, *d]) as usize,
            MAGIC.len() + 6,
        ),
        [version, ..] if *version > 3 => {
            return Err(ReadError::needs(format!(
                "version {version} of NumPy's format"
            )));
        }
        _ => return Err("end of file within the header".into()),
    };
    let end = start.checked_add(length).filter(|&end| end <= bytes.len());
    let end = end.ok_or("end of file within the header")?;
    let header = String::from_utf8_lossy(&bytes[start..end]);
    let value = |key: &str| {
        let (_, rest) = header.split_once(&format!("'{key}'"))?;
        Some(rest.split_once(':')?.1.trim_start())
    };
    let at_header = |what: String| ReadError::at(Place::Byte(start), what);
    let missing = |key: &str| at_header(format!("header without `{key}`"));
    let kind = value("descr").ok_or_else(|| missing("descr"))?;
    let kind = kind
        .trim_start_matches('\'')
        .split('\'')
        .next()
        .unwrap_or_default();
    let number: fn(&[u8]) -> f64 = match kind {
        "<f4" => |b| f32::from_le_bytes(b.try_into().unwrap_or_default()).into(),
        ">f4" => |b| f32::from_be_bytes(b.try_into().unwrap_or_default()).into(),
        "<f8" => |b| f64::from_le_bytes(b.try_into().unwrap_or_default()),
        ">f8" => |b| f64::from_be_bytes(b.try_into().unwrap_or_default()),
        _ => {
            return Err(at_header(format!(
                "numbers of kind `{kind}`, must be float32 or float64"
            )));
        }
    };
    let size = if kind.ends_with('4') { 4 } else { 8 };
    let is_turned = value("fortran_order").ok_or_else(|| missing("fortran_order"))?;
    if is_turned.starts_with("True") {
        return Err(ReadError::needs(
            "an array in Fortran order; save `numpy.ascontiguousarray(a)`",
        ));
    }
    let shape = value("shape").ok_or_else(|| missing("shape"))?;
    let shape = shape
        .trim_start_matches('(')
        .split(')')
        .next()
        .unwrap_or_default();
    let axes = shape
        .split(',')
        .map(str::trim)
        .filter(|axis| !axis.is_empty());
    let axes: Result<Vec<usize>, _> = axes.map(str::parse).collect();
    let axes = axes.map_err(|_| at_header(format!("shape `({shape})` is none")))?;
    let [.., columns] = axes[..] else {
        return Err(at_header("an array without axes, must be (n, 3)".into()));
    };
    if axes.len() < 2 || columns < 3 {
        return Err(at_header(format!(
            "shape ({shape}), must be (n, 3), or have more columns or axes"
        )));
    }
    let count = axes
        .iter()
        .try_fold(size, |product: usize, &axis| product.checked_mul(axis));
    let body = &bytes[end..];
    if count != Some(body.len()) {
        let has = body.len();
        return Err(ReadError::at(
            Place::Byte(end),
            format!("{has} bytes of numbers, shape ({shape}) of {kind} has others"),
        ));
    }
    // Without points, the columns may be any number.
    let rows = body.chunks_exact(size.saturating_mul(columns));
    Ok(rows
        .map(|row| [0, 1, 2].map(|k| number(&row[k * size..][..size])))
        .collect())
}
