//! The numbers of a page as binary data: arrays of words of 32 bits, in which ranges are named.

use serde_json::{Value, json};

/// Arrays that grow side by side and are packed one after the other. A range is `[array, start, count]`, in words.
#[derive(Default)]
pub struct Arrays(Vec<Vec<u32>>);

impl Arrays {
    /// A new array, empty.
    pub fn add(&mut self) -> usize {
        self.0.push(Vec::new());
        self.0.len() - 1
    }

    /// Appends to an array; the range of what was appended.
    pub fn extend(&mut self, array: usize, words: impl IntoIterator<Item = u32>) -> Value {
        let start = self.0[array].len();
        self.0[array].extend(words);
        json!([array, start, self.0[array].len() - start])
    }

    /// [`Arrays::extend`] by floats.
    pub fn extend_floats(&mut self, array: usize, floats: impl IntoIterator<Item = f32>) -> Value {
        self.extend(array, floats.into_iter().map(f32::to_bits))
    }

    /// The range of all that an array has by now.
    pub fn so_far(&self, array: usize) -> Value {
        json!([array, 0, self.0[array].len()])
    }

    /// Where each array begins when they are packed.
    pub fn starts(&self) -> Vec<usize> {
        let lengths = self.0.iter().map(Vec::len);
        lengths
            .scan(0, |end, length| Some(std::mem::replace(end, *end + length)))
            .collect()
    }

    /// All words, little-endian.
    pub fn bytes(&self) -> impl Iterator<Item = u8> {
        self.0.iter().flatten().flat_map(|word| word.to_le_bytes())
    }
}
