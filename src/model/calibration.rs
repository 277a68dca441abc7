//! A correction of the model's probabilities for one pair of parts, learned from outcomes.
//!
//! The constants of [`super::confidence`] are right on a mixture of meshes and off on any single
//! pair. The correction is `logit P' = offset + slope logit P` (Platt), learned by Bayesian
//! logistic regression. It learns from one moment at a time: a predicted probability and its
//! outcome. Offset and slope have a Gaussian prior at (0, 1). After each moment the posterior is
//! approximated by a Gaussian, with the curvature at its mode as evidence. Once the evidence has
//! reached [`FULL`], older moments fade, so the correction follows a pair that changes.

use libm::{exp, log};

/// Evidence of the prior on the offset, and on the slope. A moment with the prediction .5 adds .25
/// to the evidence on the offset.
///
/// This and [`FULL`] were chosen on nine pairs of meshes and reported on others (`docs/model.md`).
/// Half or twice as much changes little.
const PRIOR: f64 = 2.0;

/// Maximum evidence on the offset. It is reached after 160 moments with the prediction .5, or after
/// more moments with predictions that are more certain.
const FULL: f64 = 40.0;

/// Predicted logits are clamped to this magnitude before learning, so that one surprise does not
/// outweigh a hundred moments.
const LARGEST_LOGIT: f64 = 4.0;

/// Bounds of the offset, the slope and the corrected logit. They keep an uncertain prediction
/// uncertain.
const LARGEST_OFFSET: f64 = 8.0;
const SLOPES: [f64; 2] = [0.125, 8.0];
const LARGEST_CORRECTED: f64 = 30.0;

/// A correction of predicted probabilities, learned from the caller's own queries. Use one for each
/// pair of parts whose queries are stopped.
///
/// It learns from predictions of [`crate::Query::estimate`] for stopped queries, and from their
/// later outcomes. It is plain data: copy it, store it (feature `serde`), continue with it in
/// another process. `punctual_scene::Scene` keeps one and trains it by itself.
///
/// ```
/// use punctual::prediction::{Calibration, DEFAULT_PRIOR};
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
    /// Sums of `h`, `h z` and `h z^2` over the moments learned, faded. `z` is the predicted logit.
    /// `h` is `p (1 - p)`, where `p` is the probability corrected by that moment.
    evidence: [f64; 3],
}

impl Default for Calibration {
    /// Has learned nothing and changes nothing.
    fn default() -> Self {
        Self {
            offset: 0.0,
            slope: 1.0,
            evidence: [0.0; 3],
        }
    }
}

impl Calibration {
    /// The number added to the logit, -8 to 8; 0 at first.
    pub fn offset(&self) -> f64 {
        self.offset
    }

    /// The factor of the logit, 1/8 to 8; 1 at first.
    pub fn slope(&self) -> f64 {
        self.slope
    }

    /// The corrected probability. It rises with `probability`. It is 0 or 1 only if `probability`
    /// is. Values below 0 count as 0, values above 1 as 1. NaN carries no information and counts as
    /// .5.
    #[must_use]
    pub fn apply(&self, probability: f64) -> f64 {
        let predicted = if probability.is_nan() {
            0.5
        } else {
            probability.clamp(0.0, 1.0)
        };
        if predicted == 0.0 || predicted == 1.0 || (self.offset, self.slope) == (0.0, 1.0) {
            return predicted;
        }
        logistic(
            self.corrected(logit(predicted))
                .clamp(-LARGEST_CORRECTED, LARGEST_CORRECTED),
        )
    }

    /// Learns from one moment. `predicted` is the probability that the model predicted, before
    /// [`Calibration::apply`]. `met` is true if the surfaces met at that pose. A prediction teaches
    /// nothing if it is certain (0 or less, 1 or more) or NaN.
    ///
    /// Takes about a microsecond, allocates nothing, and gives the same bits on every machine.
    pub fn learn(&mut self, predicted: f64, met: bool) {
        if !(predicted > 0.0 && predicted < 1.0) {
            return;
        }
        let z = logit(predicted).clamp(-LARGEST_LOGIT, LARGEST_LOGIT);
        let truth = f64::from(u8::from(met));
        let [one, both, square] = self.evidence;
        let (one, square) = (one + PRIOR, square + PRIOR);
        // The step is along the covariance times (1, z). `spread` is the variance of the corrected
        // logit.
        let determinant = one * square - both * both;
        let [along_offset, along_slope] = [
            (square - both * z) / determinant,
            (one * z - both) / determinant,
        ];
        let spread = along_offset + along_slope * z;
        let before = self.corrected(z);
        // The mode of the posterior. The steps never overshoot, because the curvature is at most
        // 1/4.
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

    /// All state in five numbers, to be stored without serde: offset, slope and three numbers of
    /// evidence.
    pub fn to_array(&self) -> [f64; 5] {
        let [one, both, square] = self.evidence;
        [self.offset, self.slope, one, both, square]
    }

    /// The inverse of [`Calibration::to_array`]; `None` if learning cannot produce these numbers.
    pub fn from_array([offset, slope, one, both, square]: [f64; 5]) -> Option<Self> {
        Self::checked(offset, slope, [one, both, square]).ok()
    }

    /// A calibration with these numbers. If learning cannot produce them, the name and value of a
    /// number that is out of range.
    fn checked(offset: f64, slope: f64, evidence: [f64; 3]) -> Result<Self, (&'static str, f64)> {
        // Rounding may leave a sum at its maximum slightly above it.
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

/// A deserialized calibration, to be refused if learning cannot produce its numbers.
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
