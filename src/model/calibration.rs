//! Probabilities that learn: a correction of what the model tells of one pair of parts, from what came true of it.
//!
//! The constants of [`super::confidence`] are right on a mixture of meshes and off on any single pair. The correction is
//! `logit P' = offset + slope logit P` (Platt), learned one moment at a time by Bayesian logistic regression: both numbers
//! have a Gaussian prior at (0, 1), and after each moment the posterior is again taken as Gaussian, with the curvature at its
//! mode as evidence. Older moments fade once the evidence has reached [`FULL`], so a pair that changes is followed.

use libm::{exp, log};

/// Evidence of the prior on each of the two numbers. A moment told .5 adds .25.
///
/// This and [`FULL`] were chosen on nine pairs of meshes and reported on others (`docs/model.md`); between half and twice as
/// much changes little.
const PRIOR: f64 = 2.0;

/// Most evidence on the offset that is kept: that of 160 moments told .5, or of more that were told with less doubt.
const FULL: f64 = 40.0;

/// What is learned from a logit beyond this is what would be from this one, so that one surprise does not outweigh a hundred
/// moments.
const LARGEST_LOGIT: f64 = 4.0;

/// Bounds of the two numbers, and of a corrected logit, so that what is not certain stays so.
const LARGEST_OFFSET: f64 = 8.0;
const SLOPES: [f64; 2] = [0.125, 8.0];
const LARGEST_CORRECTED: f64 = 30.0;

/// A correction of probabilities, learned on the caller's own work: one for each pair of parts whose queries are stopped.
///
/// It is fed with what [`crate::Query::estimate`] told of a stopped query and what turned out later. Plain data: copy it,
/// store it (feature `serde`), go on with it the next day. [`crate::Scene`] keeps one and feeds it by itself.
///
/// ```
/// use punctual::{Calibration, DEFAULT_PRIOR};
/// let mut calibration = Calibration::default();
/// assert_eq!(calibration.apply(0.65), 0.65);
/// for moment in 0..200 {
///     calibration.learn(0.65, moment % 7 != 0);
/// }
/// assert!((calibration.apply(0.65) - 6.0 / 7.0).abs() < 0.02);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(try_from = "Unchecked"))]
pub struct Calibration {
    offset: f64,
    slope: f64,
    /// Sums of `h`, `h z` and `h z^2` over the moments learned, faded: `z` the logit told, `h = p (1 - p)` at the corrected one.
    evidence: [f64; 3],
}

impl Default for Calibration {
    /// Knows nothing and changes nothing.
    fn default() -> Self {
        Self {
            offset: 0.0,
            slope: 1.0,
            evidence: [0.0; 3],
        }
    }
}

impl Calibration {
    /// What is added to the logit, -8 to 8; 0 at first.
    pub fn offset(&self) -> f64 {
        self.offset
    }

    /// What the logit is multiplied with, 1/8 to 8; 1 at first.
    pub fn slope(&self) -> f64 {
        self.slope
    }

    /// The corrected probability. It rises with the one given, and only 0 and 1 become 0 and 1; what is beyond counts as
    /// these, and NaN, which tells nothing, as .5.
    #[must_use]
    pub fn apply(&self, probability: f64) -> f64 {
        let told = if probability.is_nan() {
            0.5
        } else {
            probability.clamp(0.0, 1.0)
        };
        if told == 0.0 || told == 1.0 || (self.offset, self.slope) == (0.0, 1.0) {
            return told;
        }
        logistic(
            self.corrected(logit(told))
                .clamp(-LARGEST_CORRECTED, LARGEST_CORRECTED),
        )
    }

    /// Learns from a moment: the probability that the model told then, before [`Calibration::apply`], and whether the surfaces
    /// met at that pose. What was told as certain (0 or 1, or beyond, or NaN) teaches nothing.
    ///
    /// About a microsecond, no allocation, the same bits on every machine.
    pub fn learn(&mut self, told: f64, met: bool) {
        if !(told > 0.0 && told < 1.0) {
            return;
        }
        let z = logit(told).clamp(-LARGEST_LOGIT, LARGEST_LOGIT);
        let truth = f64::from(u8::from(met));
        let [one, both, square] = self.evidence;
        let (one, square) = (one + PRIOR, square + PRIOR);
        // The step is along the covariance times (1, z); `spread` is the variance of the corrected logit.
        let determinant = one * square - both * both;
        let [along_offset, along_slope] = [
            (square - both * z) / determinant,
            (one * z - both) / determinant,
        ];
        let spread = along_offset + along_slope * z;
        let before = self.corrected(z);
        // The mode of the posterior, by steps that never overshoot, since the curvature is at most 1/4.
        let mut after = before;
        for _ in 0..16 {
            after -= (after - before - spread * (truth - logistic(after))) / (1.0 + 0.25 * spread);
        }
        let p = logistic(after);
        let h = p * (1.0 - p);
        self.offset =
            (self.offset + along_offset * (truth - p)).clamp(-LARGEST_OFFSET, LARGEST_OFFSET);
        self.slope = (self.slope + along_slope * (truth - p)).clamp(SLOPES[0], SLOPES[1]);
        let [one, both, square] = self.evidence;
        let fading = (FULL / (one + h)).min(1.0);
        self.evidence = [one + h, both + h * z, square + h * z * z].map(|sum| fading * sum);
    }

    /// All of it in five numbers, to be stored where serde is not at hand: offset, slope and three of evidence.
    pub fn to_array(&self) -> [f64; 5] {
        let [one, both, square] = self.evidence;
        [self.offset, self.slope, one, both, square]
    }

    /// That of [`Calibration::to_array`]; `None` if nothing that can be learned has these numbers.
    pub fn from_array([offset, slope, one, both, square]: [f64; 5]) -> Option<Self> {
        Self::checked(offset, slope, [one, both, square]).ok()
    }

    /// A calibration that can be learned, or which number is out of range.
    fn checked(offset: f64, slope: f64, evidence: [f64; 3]) -> Result<Self, (&'static str, f64)> {
        // Sums that are as large as they can be may have been rounded up.
        let most = FULL * (1.0 + 1e-9);
        let [one, both, square] = evidence;
        let ranges = [
            ("offset", offset, [-LARGEST_OFFSET, LARGEST_OFFSET]),
            ("slope", slope, SLOPES),
            ("evidence[0]", one, [0.0, most]),
            (
                "evidence[1]",
                both,
                [-LARGEST_LOGIT * most, LARGEST_LOGIT * most],
            ),
            (
                "evidence[2]",
                square,
                [0.0, LARGEST_LOGIT * LARGEST_LOGIT * most],
            ),
        ];
        if let Some((name, value, _)) = ranges
            .into_iter()
            .find(|(_, x, [low, high])| !(low..=high).contains(&x))
        {
            return Err((name, value));
        }
        if both * both > one * square * (1.0 + 1e-9) {
            return Err(("evidence[1]", both));
        }
        Ok(Self {
            offset,
            slope,
            evidence,
        })
    }

    fn corrected(&self, logit: f64) -> f64 {
        self.offset + self.slope * logit
    }
}

fn logit(p: f64) -> f64 {
    log(p / (1.0 - p))
}

fn logistic(x: f64) -> f64 {
    1.0 / (1.0 + exp(-x))
}

/// A deserialized calibration, refused unless it is one that can be learned.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
#[serde(rename = "Calibration", deny_unknown_fields)]
struct Unchecked {
    offset: f64,
    slope: f64,
    evidence: [f64; 3],
}

#[cfg(feature = "serde")]
impl TryFrom<Unchecked> for Calibration {
    type Error = alloc::string::String;

    fn try_from(
        Unchecked {
            offset,
            slope,
            evidence,
        }: Unchecked,
    ) -> Result<Self, Self::Error> {
        Self::checked(offset, slope, evidence)
            .map_err(|(name, value)| alloc::format!("{name} {value:?} is out of range"))
    }
}
