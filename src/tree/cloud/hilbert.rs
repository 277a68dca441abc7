//! Places along a Hilbert curve: points that follow each other are near each other, without the
//! jumps of a Morton curve.
//!
//! A curve through the eight parts of a cell is a Gray code, rotated and mirrored by the part of
//! the cell above that it fills (Hamilton, "Compact Hilbert indices", 2006).

/// Number of bits of a coordinate.
pub(crate) const BITS: u32 = 10;

/// The place of a cell along the curve, from its Morton code. Takes two levels at a time.
#[inline(always)]
pub(crate) fn place(morton: u32) -> u32 {
    let (mut place, mut state) = (0, 0);
    for level in (0..BITS / 2).rev() {
        let part = (morton >> (6 * level)) & 63;
        let step = TWO_STEPS[(state << 6 | part as usize) % TWO_STEPS.len()];
        place = place << 6 | u32::from(step & 63);
        state = usize::from(step >> 6);
    }
    place
}

/// The next state and the place of a part of a part of a cell, by the state and the parts.
static TWO_STEPS: [u16; 2048] = two_steps();

const fn two_steps() -> [u16; 2048] {
    let (one, mut two) = (steps(), [0; 2048]);
    let mut i = 0;
    while i < two.len() {
        let first = one[i >> 6 << 3 | (i >> 3 & 7)] as u16;
        let second = one[(first >> 3 << 3) as usize | (i & 7)] as u16;
        two[i] = second >> 3 << 6 | (first & 7) << 3 | (second & 7);
        i += 1;
    }
    two
}

/// The next state and the place of a part of a cell, by the state and the part. A state is the
/// first part, times four, and the axis along which the curve leaves.
const fn steps() -> [u8; 256] {
    let mut steps = [0; 256];
    let mut i = 0;
    while i < 256 {
        let (first, axis, part) = (i >> 5, (i >> 3 & 3) as u32 % 3, i & 7);
        let gray = turned(part ^ first, 2 - axis);
        let place = gray ^ gray >> 1 ^ gray >> 2;
        let entry = if place == 0 { 0 } else { (place - 1) & 6 };
        let next = first ^ turned(entry ^ entry >> 1, axis + 1);
        let along = match place {
            0 => 0,
            even if even & 1 == 0 => (even - 1).trailing_ones(),
            odd => odd.trailing_ones(),
        };
        steps[i] = (next << 5 | ((axis + along + 1) as usize % 3) << 3 | place) as u8;
        i += 1;
    }
    steps
}

/// Three bits rotated to the left.
const fn turned(bits: usize, by: u32) -> usize {
    let by = by % 3;
    (bits << by | bits >> (3 - by)) & 7
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_that_follow_each_other_share_a_face() {
        let mut cells = alloc::vec![None; 1 << 12];
        for morton in 0..1 << 12 {
            // The curve through the first cells of a large cube is one of a small cube.
            let place = place(morton) as usize;
            let cell = [0, 1, 2].map(|axis| {
                (0..4).fold(0_i32, |x, bit| {
                    x | ((morton >> (3 * bit + axis) & 1) as i32) << bit
                })
            });
            assert_eq!(cells[place].replace(cell), None);
        }
        for two in cells.windows(2) {
            let [from, to] = [two[0].unwrap(), two[1].unwrap()];
            let apart: i32 = (0..3).map(|k| (from[k] - to[k]).abs()).sum();
            assert_eq!(apart, 1, "{from:?} {to:?}");
        }
    }
}
