//! What the last frame cost, blended with what this one is predicted to.
//!
//! On coherent motion the cost of the previous query of a pair is by far the best predictor of this one's; the further this
//! one has come, the less it says about the rest.

/// `w`, how much of it is gone: 0 at first, 1 from the cost of the previous query on.
pub fn weight(previous: f64, used: f64) -> f64 {
    (used / previous.max(1.0)).clamp(0.0, 1.0)
}

/// BV tests still to be made, from those of the whole previous query and of this one so far, and the prediction of the
/// model for the rest (at least 1 each; a prediction below 1 counts as 1):
/// `log2 E = (1 - w) log2 max(previous - used, 1) + w log2 model`, `w = clamp(used / previous, 0, 1)`.
pub fn blend(previous: f64, used: f64, model: f64) -> f64 {
    let weight = weight(previous, used);
    let left = (previous.max(1.0) - used).max(1.0);
    libm::exp2((1.0 - weight) * libm::log2(left) + weight * libm::log2(model.max(1.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn at_first_the_history_counts_and_at_last_the_model() {
        assert_eq!(blend(1024.0, 0.0, 8.0), 1024.0);
        assert_eq!(blend(1024.0, 512.0, 8.0), 64.0);
        for used in [1024.0, 1e6] {
            assert_eq!(blend(1024.0, used, 8.0), 8.0);
        }
    }

    #[test]
    fn small_numbers_do_no_harm() {
        assert_eq!(blend(0.0, 0.0, 0.0), 1.0);
        assert_eq!(blend(0.0, 5.0, 32.0), 32.0);
        assert_eq!(blend(100.0, 100.0, 0.0), 1.0);
    }
}
