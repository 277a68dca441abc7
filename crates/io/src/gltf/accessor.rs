//! The numbers of an accessor, of any type and packing, as f64, which holds all of them exactly.

use std::cell::Cell;

use super::buffers::Buffers;
use super::json::{Accessor, Extensions, Root, View};

/// A type of numbers.
#[derive(Clone, Copy)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
    F64,
}

impl Component {
    fn of(code: u32) -> Result<Self, String> {
        Ok(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            5130 => Self::F64,
            _ => return Err(format!("{code} is no type of numbers")),
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The number in the first bytes, of which there are enough.
    fn number(self, bytes: &[u8]) -> f64 {
        let mut low = [0; 8];
        low[..self.size()].copy_from_slice(&bytes[..self.size()]);
        let bits = u64::from_le_bytes(low);
        match self {
            Self::I8 => f64::from(bits as i8),
            Self::I16 => f64::from(bits as i16),
            Self::U8 | Self::U16 | Self::U32 => bits as f64,
            Self::F32 => f64::from(f32::from_bits(bits as u32)),
            Self::F64 => f64::from_bits(bits),
        }
    }

    /// The number that stands for 1 where whole numbers are shares.
    fn one(self) -> f64 {
        match self {
            Self::I8 => 127.0,
            Self::U8 => 255.0,
            Self::I16 => 32_767.0,
            Self::U16 => 65_535.0,
            Self::U32 | Self::F32 | Self::F64 => 1.0,
        }
    }
}

/// Reads accessors of a document.
pub struct Accessors<'a> {
    pub root: &'a Root,
    pub buffers: Buffers<'a>,
    /// Most elements of an accessor without bytes, which is all zeros.
    pub most_zeros: usize,
    /// Elements that may still be read. Parts that are used again and again are read as often.
    pub left: Cell<usize>,
}

impl Accessors<'_> {
    /// The elements of an accessor of `N` numbers each; `user`: extensions that may be why it has no bytes.
    pub fn read<const N: usize>(
        &self,
        index: usize,
        user: &Extensions,
    ) -> Result<Vec<[f64; N]>, String> {
        let accessor = self
            .root
            .accessors
            .get(index)
            .ok_or_else(|| format!("accessor {index} does not exist"))?;
        self.elements(accessor, user)
            .map_err(|what| super::within(format_args!("accessor {index}"), &what))
    }

    /// The one number of each element, for indices.
    pub fn read_indices(&self, index: usize, user: &Extensions) -> Result<Vec<u32>, String> {
        let numbers = self.read::<1>(index, user)?;
        let whole = |&[number]: &[f64; 1]| {
            (number >= 0.0 && number.fract() == 0.0).then_some(number as u32)
        };
        let whole: Option<Vec<u32>> = numbers.iter().map(whole).collect();
        whole.ok_or_else(|| format!("accessor {index}: indices must be u8, u16 or u32"))
    }

    fn elements<const N: usize>(
        &self,
        accessor: &Accessor,
        user: &Extensions,
    ) -> Result<Vec<[f64; N]>, String> {
        let Accessor {
            byte_offset,
            count,
            ref kind,
            ..
        } = *accessor;
        let numbers = match kind.as_str() {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" | "MAT2" => 4,
            "MAT3" => 9,
            "MAT4" => 16,
            _ => 0,
        };
        if numbers != N {
            return Err(format!(
                "its type is `{}`, must have {N} numbers",
                crate::text::shorten(kind)
            ));
        }
        let component = Component::of(accessor.component_type)?;
        let mut elements = match accessor.buffer_view {
            Some(view) => self.packed(view, byte_offset, component, count)?,
            None if !user.is_empty() => return Err(needs(user)),
            None if count > self.most_zeros => {
                return Err(format!("{count} elements without bytes are too many"));
            }
            None => vec![[0.0; N]; count],
        };
        let left = self.left.get().checked_sub(count);
        self.left
            .set(left.ok_or("too many elements, since parts are used again and again")?);
        if let Some(sparse) = &accessor.sparse {
            let (at, values) = (&sparse.indices, &sparse.values);
            let indices: Vec<[f64; 1]> = self.packed(
                at.buffer_view,
                at.byte_offset,
                Component::of(at.component_type)?,
                sparse.count,
            )?;
            let values: Vec<[f64; N]> = self.packed(
                values.buffer_view,
                values.byte_offset,
                component,
                sparse.count,
            )?;
            for ([index], value) in indices.into_iter().zip(values) {
                let fault =
                    || format!("its sparse index {index} is out of range: {count} elements");
                *elements
                    .get_mut(index as usize)
                    .filter(|_| index >= 0.0)
                    .ok_or_else(fault)? = value;
            }
        }
        if accessor.normalized {
            let one = component.one();
            elements
                .as_flattened_mut()
                .iter_mut()
                .for_each(|x| *x = (*x / one).max(-1.0));
        }
        Ok(elements)
    }

    /// Elements that lie in a buffer view, after a check that all of them lie in the buffer.
    fn packed<const N: usize>(
        &self,
        view: usize,
        offset: usize,
        component: Component,
        count: usize,
    ) -> Result<Vec<[f64; N]>, String> {
        let View {
            buffer,
            byte_offset,
            byte_length,
            byte_stride,
            ref extensions,
        } = *self
            .root
            .buffer_views
            .get(view)
            .ok_or_else(|| format!("buffer view {view} does not exist"))?;
        let bytes = match self.buffers.get(buffer)? {
            Some(bytes) => bytes,
            None if !extensions.is_empty() => return Err(needs(extensions)),
            None => return Err(format!("buffer {buffer} has no bytes")),
        };
        if count == 0 {
            return Ok(Vec::new());
        }
        let size = N * component.size();
        let stride = byte_stride.filter(|&stride| stride > 0).unwrap_or(size);
        let last = stride
            .checked_mul(count - 1)
            .and_then(|last| last.checked_add(offset)?.checked_add(size));
        let start = byte_offset.checked_add(offset);
        let end = last
            .filter(|&last| last <= byte_length)
            .and_then(|last| last.checked_add(byte_offset));
        let elements = match (start, end) {
            (Some(start), Some(end)) if stride >= size => bytes.get(start..end),
            _ => None,
        };
        let elements = elements
            .ok_or_else(|| format!("reaches outside buffer view {view} or buffer {buffer}"))?;
        let number = |element: &[u8], k: usize| component.number(&element[k * component.size()..]);
        Ok(elements
            .chunks(stride)
            .map(|element| std::array::from_fn(|k| number(element, k)))
            .collect())
    }
}

/// Why something has no bytes: an extension packs them.
fn needs(extensions: &Extensions) -> String {
    let names: Vec<&str> = extensions.keys().map(String::as_str).collect();
    format!("needs {}, which is not supported", names.join(" or "))
}
