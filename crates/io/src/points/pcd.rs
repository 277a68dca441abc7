//! PCD, the files of the Point Cloud Library: a header in text, then the fields of each point as text, as records, or
//! field by field and compressed.

use crate::text::{number, shorten};
use crate::{Place, ReadError};

/// Where a coordinate is in a record, and of what kind.
#[derive(Clone, Copy)]
struct Field {
    /// Numbers before it, in text.
    number: usize,
    /// Bytes before it, in a record.
    byte: usize,
    size: usize,
    kind: u8,
}

pub fn parse(bytes: &[u8], limit: usize) -> Result<Vec<[f64; 3]>, ReadError> {
    let header = Header::parse(bytes)?;
    let Header {
        axes,
        size,
        count,
        data,
        body,
        ..
    } = &header;
    let rest = &bytes[*body..];
    match data.as_str() {
        "ascii" => header.text(rest),
        "binary" => {
            let needed = size
                .checked_mul(*count)
                .filter(|&needed| needed <= rest.len());
            let Some(needed) = needed else {
                return Err(ReadError::at(
                    Place::Byte(bytes.len()),
                    format!("end of file before the last of {count} points"),
                ));
            };
            let records = rest[..needed].chunks_exact((*size).max(1));
            Ok(records
                .map(|record| axes.map(|axis| axis.value(&record[axis.byte..])))
                .collect())
        }
        "binary_compressed" => {
            let at = |what: &str| ReadError::at(Place::Byte(*body), what);
            let (sizes, packed) = rest
                .split_at_checked(8)
                .ok_or_else(|| at("end of file before the compressed points"))?;
            let word = |i: usize| {
                u32::from_le_bytes([sizes[i], sizes[i + 1], sizes[i + 2], sizes[i + 3]]) as usize
            };
            let [length, unpacked] = [word(0), word(4)];
            let packed = packed
                .get(..length)
                .ok_or_else(|| at("end of file within the compressed points"))?;
            if Some(unpacked) != size.checked_mul(*count) || unpacked > limit {
                return Err(at(&format!(
                    "{unpacked} bytes when unpacked, for {count} points of {size}, at most {limit}"
                )));
            }
            let fields = lzf(packed, unpacked).ok_or_else(|| at("damaged compression"))?;
            // Field by field: all x, then all y.
            let value =
                |axis: Field, i: usize| axis.value(&fields[axis.byte * count + i * axis.size..]);
            Ok((0..*count)
                .map(|i| axes.map(|axis| value(axis, i)))
                .collect())
        }
        other => Err(ReadError::needs(format!("DATA {}", shorten(other)))),
    }
}

struct Header {
    axes: [Field; 3],
    /// Bytes of a point.
    size: usize,
    count: usize,
    data: String,
    /// Where the points begin, and on which line.
    body: usize,
    line: usize,
}

impl Header {
    fn parse(bytes: &[u8]) -> Result<Self, ReadError> {
        let (mut names, mut sizes, mut kinds, mut counts) = (vec![], vec![], vec![], None);
        let (mut points, mut grid) = (None, [None; 2]);
        let (mut body, mut line) = (0, 0);
        let data = loop {
            let Some(end) = bytes[body..].iter().position(|&byte| byte == b'\n') else {
                return Err(ReadError::at_line(line + 1, "end of file before DATA"));
            };
            let text = String::from_utf8_lossy(&bytes[body..body + end]);
            line += 1;
            body += end + 1;
            let mut words = text.split_ascii_whitespace();
            let keyword = words.next().unwrap_or_default();
            let number = |words: &mut dyn Iterator<Item = &str>| {
                let word = words.next().unwrap_or_default();
                let count = word
                    .parse()
                    .ok()
                    .filter(|&count: &usize| count <= bytes.len().saturating_mul(1 << 12));
                count.ok_or_else(|| {
                    ReadError::at_line(line, format!("{keyword} `{}` is no count", shorten(word)))
                })
            };
            match keyword {
                "FIELDS" | "COLUMNS" => names = words.map(str::to_owned).collect(),
                "SIZE" | "COUNT" => {
                    let mut list = Vec::new();
                    let mut words = words.peekable();
                    while words.peek().is_some() {
                        list.push(number(&mut words)?);
                    }
                    match keyword {
                        "SIZE" => sizes = list,
                        _ => counts = Some(list),
                    }
                }
                "TYPE" => kinds = words.map(|word| word.as_bytes()[0]).collect(),
                "WIDTH" => grid[0] = Some(number(&mut words)?),
                "HEIGHT" => grid[1] = Some(number(&mut words)?),
                "POINTS" => points = Some(number(&mut words)?),
                "DATA" => break words.next().unwrap_or_default().to_owned(),
                "" | "VERSION" | "VIEWPOINT" => {}
                word if word.starts_with('#') => {}
                word => {
                    return Err(ReadError::at_line(
                        line,
                        format!("`{}` is no entry of a PCD header", shorten(word)),
                    ));
                }
            }
        };
        let at = |what: String| ReadError::at_line(line, what);
        let counts = counts.unwrap_or_else(|| vec![1; names.len()]);
        if [sizes.len(), kinds.len(), counts.len()] != [names.len(); 3] {
            return Err(at("FIELDS, SIZE, TYPE and COUNT differ in length".into()));
        }
        let mut axes = [None; 3];
        let (mut before, mut size) = (0_usize, 0_usize);
        for (i, name) in names.iter().enumerate() {
            if let Some(axis) = ["x", "y", "z"].iter().position(|axis| axis == name) {
                let (number, byte, size, kind) = (before, size, sizes[i], kinds[i]);
                let is_known = matches!((kind, size), (b'F', 4 | 8) | (b'I' | b'U', 1 | 2 | 4 | 8));
                if !is_known || counts[i] != 1 {
                    return Err(at(format!(
                        "field `{name}` of {} numbers of type {} and {size} bytes",
                        counts[i],
                        char::from(kind)
                    )));
                }
                axes[axis] = Some(Field {
                    number,
                    byte,
                    size,
                    kind,
                });
            }
            let bytes = sizes[i].checked_mul(counts[i]);
            let sum = bytes.and_then(|bytes| size.checked_add(bytes));
            size = sum.ok_or_else(|| at("a point of too many bytes".into()))?;
            before = before.saturating_add(counts[i]);
        }
        let [Some(x), Some(y), Some(z)] = axes else {
            return Err(at("no fields x, y and z".into()));
        };
        let of_grid = match grid {
            [Some(width), Some(height)] => Some(width.saturating_mul(height)),
            _ => None,
        };
        let count = points
            .or(of_grid)
            .ok_or_else(|| at("neither POINTS nor WIDTH and HEIGHT".into()))?;
        Ok(Self {
            axes: [x, y, z],
            size,
            count,
            data,
            body,
            line,
        })
    }

    fn text(&self, bytes: &[u8]) -> Result<Vec<[f64; 3]>, ReadError> {
        let text = String::from_utf8_lossy(bytes);
        let mut points = Vec::new();
        for (line, at) in text.lines().zip(self.line + 1..) {
            let words: Vec<_> = line.split_ascii_whitespace().collect();
            if words.is_empty() || points.len() == self.count {
                continue;
            }
            let mut point = [0.0; 3];
            for (x, axis) in point.iter_mut().zip(self.axes) {
                let word = words.get(axis.number).ok_or_else(|| {
                    ReadError::at_line(
                        at,
                        format!(
                            "point of {} numbers, must be {}",
                            words.len(),
                            axis.number + 1
                        ),
                    )
                })?;
                *x = number(word).map_err(|what| ReadError::at_line(at, what))?;
            }
            points.push(point);
        }
        if points.len() < self.count {
            let what = format!(
                "end of file after {} of {} points",
                points.len(),
                self.count
            );
            return Err(ReadError::at_line(self.line + text.lines().count(), what));
        }
        Ok(points)
    }
}

impl Field {
    /// The number at the start of these bytes, in the order of most machines, as the library writes it.
    fn value(self, bytes: &[u8]) -> f64 {
        let mut word = [0; 8];
        word[..self.size].copy_from_slice(&bytes[..self.size]);
        let unsigned = u64::from_le_bytes(word);
        let unused = 64 - 8 * self.size as u32;
        match (self.kind, self.size) {
            (b'F', 4) => f32::from_bits(unsigned as u32).into(),
            (b'F', _) => f64::from_bits(unsigned),
            (b'I', _) => (unsigned.wrapping_shl(unused) as i64 >> unused) as f64,
            _ => unsigned as f64,
        }
    }
}

/// Unpacks Marc Lehmann's LZF: runs of bytes as they are, and copies of what was unpacked before; `None` if it does not
/// give so many bytes.
fn lzf(packed: &[u8], length: usize) -> Option<Vec<u8>> {
    let mut out = Vec::new();
    let mut bytes = packed.iter().map(|&byte| usize::from(byte));
    while let Some(control) = bytes.next() {
        if control < 32 {
            for _ in 0..=control {
                out.push(bytes.next()? as u8);
            }
        } else {
            let more = if control >> 5 == 7 { bytes.next()? } else { 0 };
            let back = ((control & 31) << 8) + bytes.next()? + 1;
            let start = out.len().checked_sub(back)?;
            for i in start..start + (control >> 5) + more + 2 {
                out.push(out[i]);
            }
        }
        if out.len() > length {
            return None;
        }
    }
    (out.len() == length).then_some(out)
}
