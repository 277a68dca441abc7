//! Motions of all joints, piece after piece, each a polynomial of time.

use smallvec::{SmallVec, smallvec};

use crate::RobotError;
use crate::error::refuse;
use crate::model::LARGEST;

/// A motion of all joints: pieces one after the other, each with a polynomial of time for each
/// joint. Splines are such motions, and so is braking.
///
/// ```
/// # use punctual_robot::Trajectory;
/// let (q, v) = ([0.0, 0.5], [1.0, -0.4]);
/// // 10 ms at this velocity; then the joints brake in proportion, and stop after 0.2 s.
/// let then = [0.01, 0.5 - 0.004];
/// let slower = v.map(|v| -0.5 * v / 0.2);
/// let mut motion = Trajectory::default();
/// motion.push(0.01, &[&q, &v])?;
/// motion.push(0.2, &[&then, &v, &slower])?;
/// assert!((motion.at(motion.seconds())[0] - 0.11).abs() < 1e-15);
/// # Ok::<(), punctual_robot::RobotError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trajectory {
    pieces: Vec<Piece>,
    /// Coefficients of powers of the share of a piece, a row of joints for each.
    numbers: Vec<f64>,
    width: usize,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Piece {
    pub begin: f64,
    pub seconds: f64,
    /// Its coefficients in [`Trajectory::numbers`].
    first: usize,
    last: usize,
}

/// The motion of a joint within half of an interval: its way at the speed of the middle, the way at
/// its largest speed, and the change of it by its largest acceleration.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Move {
    pub way: f64,
    pub size: f64,
    pub bend: f64,
}

impl Trajectory {
    /// Adds a piece of this duration: row `k` has the coefficients of the k-th power of the time in
    /// seconds since the piece began, one for each joint (rad or m). It is not checked whether
    /// pieces join.
    ///
    /// # Errors
    /// [`RobotError::Model`], which names the piece: no row, rows of other lengths than the first
    /// one of all, a duration that is not above 0, numbers that are not finite or larger than
    /// [`LARGEST`] within the piece.
    pub fn push(&mut self, seconds: f64, rows: &[&[f64]]) -> Result<(), RobotError> {
        let width = rows.first().map_or(0, |row| row.len());
        let fail = |what: String| refuse(format!("piece {}: {what}", self.pieces.len()));
        if rows.is_empty() || !(self.pieces.is_empty() || width == self.width) {
            return fail(format!("{} rows, the first of {width} numbers", rows.len()));
        }
        if !(seconds > 0.0 && seconds <= LARGEST) {
            return fail(format!(
                "{seconds} s, must be above 0 and at most {LARGEST:e}"
            ));
        }
        for (power, row) in (0..).zip(rows) {
            let most = LARGEST / seconds.powi(power).max(1.0);
            let joint = row.iter().position(|x| x.is_nan() || x.abs() > most);
            if row.len() != width || joint.is_some() {
                let what = joint.map_or(format!("{} numbers, must be {width}", row.len()), |i| {
                    format!("joint {i}: {}, allowed is {most:e}", row[i])
                });
                return fail(format!("power {power}: {what}"));
            }
        }
        let powers = rows.iter().zip(0..);
        self.add(
            width,
            seconds,
            powers.flat_map(|(row, power)| {
                let unit = seconds.powi(power);
                // 0 stays 0, however long the piece is.
                row.iter()
                    .map(move |&x| if x == 0.0 { 0.0 } else { x * unit })
            }),
        );
        Ok(())
    }

    /// The duration, in seconds.
    pub fn seconds(&self) -> f64 {
        self.pieces
            .last()
            .map_or(0.0, |piece| piece.begin + piece.seconds)
    }

    /// The configuration at a time, from the beginning to the end.
    pub fn at(&self, seconds: f64) -> Vec<f64> {
        let mut found = Vec::new();
        if !self.pieces.is_empty() {
            let (piece, share) = self.find(seconds);
            self.put(piece, share, &mut found);
        }
        found
    }

    pub(crate) fn width(&self) -> usize {
        self.width
    }

    /// Takes all pieces away, and keeps their memory.
    pub fn clear(&mut self) {
        self.pieces.clear();
        self.numbers.clear();
    }

    /// Becomes a copy, in the memory that it has.
    pub(crate) fn copy(&mut self, from: &Self) {
        self.pieces.clone_from(&from.pieces);
        self.numbers.clone_from(&from.numbers);
        self.width = from.width;
    }

    /// Adds a piece by its coefficients of powers of its share.
    pub(crate) fn add(&mut self, width: usize, seconds: f64, numbers: impl Iterator<Item = f64>) {
        let (begin, first) = (self.seconds(), self.numbers.len());
        self.numbers.extend(numbers);
        self.width = width;
        self.pieces.push(Piece {
            begin,
            seconds,
            first,
            last: self.numbers.len(),
        });
    }

    pub(crate) fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// The piece of a time, and the share of it that has passed.
    pub(crate) fn find(&self, seconds: f64) -> (u32, f64) {
        let at = self.pieces.partition_point(|piece| piece.begin <= seconds);
        let at = at.max(1) - 1;
        let piece = self.pieces[at];
        let share = (seconds - piece.begin) / piece.seconds;
        // A piece may take no time.
        (at as u32, if share > 0.0 { share.min(1.0) } else { 0.0 })
    }

    /// The rows of a piece, those of high powers first.
    fn rows(&self, piece: u32) -> impl Iterator<Item = &[f64]> + Clone {
        let Piece { first, last, .. } = self.pieces[piece as usize];
        self.numbers[first..last].chunks(self.width.max(1)).rev()
    }

    /// The two rows of a piece that is a straight line.
    fn line(&self, piece: u32) -> Option<[&[f64]; 2]> {
        let Piece { first, last, .. } = self.pieces[piece as usize];
        let (from, ways) = self.numbers[first..last].split_at(self.width);
        (ways.len() == self.width).then_some([from, ways])
    }

    /// The configuration at a share of a piece.
    pub(crate) fn put(&self, piece: u32, share: f64, out: &mut Vec<f64>) {
        out.clear();
        if let Some([from, ways]) = self.line(piece) {
            return out.extend(from.iter().zip(ways).map(|(x, way)| x + share * way));
        }
        out.resize(self.width, 0.0);
        for row in self.rows(piece) {
            for (value, x) in out.iter_mut().zip(row) {
                *value = x + share * *value;
            }
        }
    }

    /// Appends a part of a plan that starts at a time of the plan. During the part's `seconds` the
    /// speed along the plan changes linearly from `speeds[0]` to `speeds[1]` (shares of its own).
    pub(crate) fn add_part(
        &mut self,
        plan: &Self,
        at: &mut f64,
        mut seconds: f64,
        speeds: [f64; 2],
    ) {
        let [mut speed, last] = speeds;
        let rate = (last - speed) / seconds;
        while seconds > 0.0 {
            let (number, begin) = plan.find(*at);
            let piece = plan.pieces[number as usize];
            let (left, way) = (
                piece.begin + piece.seconds - *at,
                0.5 * (speed + last) * seconds,
            );
            let mut time = seconds;
            let is_last = number as usize + 1 == plan.pieces.len();
            if way <= left || is_last {
                *at += way;
            } else {
                // The time at which the part leaves the piece.
                let end = (speed * speed + 2.0 * rate * left).max(0.0).sqrt();
                time = (2.0 * left / (speed + end)).min(seconds);
                *at = piece.begin + piece.seconds;
            }
            let steady = speed * time / piece.seconds;
            let bent = 0.5 * rate * time * time / piece.seconds;
            self.add_composed(plan, number, time, [begin, steady, bent]);
            speed += rate * time;
            seconds -= time;
        }
    }

    /// Adds a piece of another trajectory, whose share is a polynomial of the share here.
    fn add_composed(&mut self, plan: &Self, piece: u32, seconds: f64, share: [f64; 3]) {
        let (width, rows) = (plan.width, plan.rows(piece));
        let powers = 2 * rows.clone().count().max(1) - 1;
        let first = self.numbers.len();
        self.add(width, seconds, std::iter::repeat_n(0.0, powers * width));
        for joint in 0..width {
            let mut found: SmallVec<[f64; 16]> = SmallVec::new();
            for row in rows.clone() {
                let mut next: SmallVec<[f64; 16]> = smallvec![0.0; found.len() + 2];
                for (k, x) in found.iter().enumerate() {
                    share
                        .iter()
                        .zip(&mut next[k..])
                        .for_each(|(s, to)| *to += s * x);
                }
                next.truncate(found.len().max(1) + 2 * usize::from(!found.is_empty()));
                next[0] += row[joint];
                found = next;
            }
            for (k, x) in found.iter().enumerate() {
                self.numbers[first + k * width + joint] = *x;
            }
        }
    }

    /// The motion of a joint within `half` of a piece about a share of it.
    pub(crate) fn moves(&self, piece: u32, joint: usize, share: f64, half: f64) -> Move {
        let rows = self.rows(piece);
        if let Some([_, speed]) = self.line(piece) {
            let way = speed[joint] * half;
            let (size, bend) = (way.abs(), 0.0);
            return Move { way, size, bend };
        }
        let size = rows.clone().map(|row| row[joint].abs()).fold(0.0, f64::max);
        let mut shifted: SmallVec<[f64; 8]> = rows.map(|row| row[joint]).collect();
        shifted.reverse();
        // The coefficients of powers of the distance from the middle.
        for first in 0..shifted.len() {
            for k in (first..shifted.len() - 1).rev() {
                shifted[k] += share * shifted[k + 1];
            }
        }
        let (mut faster, mut bend, mut unit) = (0.0, 0.0, 1.0);
        for (k, x) in shifted.iter().enumerate().skip(2) {
            let k = k as f64;
            // The shift rounds all coefficients.
            let x = x.abs() + 1e-14 * size;
            bend += k * (k - 1.0) * x * unit;
            unit *= half;
            faster += k * x * unit;
        }
        let way = shifted.get(1).map_or(0.0, |speed| speed * half);
        Move {
            way,
            size: way.abs() + faster * half,
            bend: bend * half * half,
        }
    }
}
