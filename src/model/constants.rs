//! The fitted constants of the model; made by `punctual fit`, not by hand.
//!
//! On 2026-11-21, on x86_64 linux, by version 0.1.0, from 4385 poses (43811 moments of queries) of:
//! delta_armadillo1k delta_armadillo4k delta_armadillo16k delta_armadillo86k delta_armadillo256k
//! delta_propeller1k delta_propeller4k delta_propeller16k delta_propeller64k contact_gear_ring_pinion
//! contact_spider_side contact_env_rob contact_spot_spot graze_env_rob tilted_env_rob tilted_gear_ring_pinion
//! coincident_gear_side path_env_rob_sweep path_roll_gear_side_pinion approach_spot_6k_gear_spider_12k
//! approach_armadillo_16k_gear_stand_3k approach_robots16_iiwa2_robots16_iiwa5
//! approach_robots16_iiwa7_robots16_iiwa3 approach_robots16_iiwa0_spot_6k approach_propeller_16k_propeller_16k
//! approach_armadillo_4k_armadillo_4k approach_gear_ring_58k_gear_ring_58k
//! approach_propeller_stl_7k_armadillo_86k approach_env_gear_pinion_15k approach_pile200_gear_pile200_quadknot
//! approach_rob_spot_6k approach_robots16_iiwa1_robots16_iiwa4 approach_robots16_iiwa6_gear_pinion_15k
//! approach_armadillo_86k_gear_spider_12k approach_propeller_16k_spot_6k approach_spot_6k_env
//! approach_propeller_4k_gear_side_12k approach_armadillo_16k_propeller_64k
//! approach_pile200_armadillo_robots16_iiwa4 approach_gear_side_12k_gear_side_12k

/// Quantiles of the BV tests left, for each the weights of `features_of_all`.
#[rustfmt::skip]
pub(super) const ALL_LEFT: [[f64; 3]; 3] = [
    [-0.017449, 1.0018, -1.6245],
    [-0.019735, 1.0026, -0.12061],
    [0.0046677, 1.0074, 1.5669],
];

/// 90 % quantile of log2 of a whole query from log2 of the cost of its roots at the deepest: intercept, slope.
#[rustfmt::skip]
pub(super) const ROOT_MOST: [f64; 2] = [2.4574, 1.0382];

/// The same if the first hit ends the query, weights of `features_of_any`.
#[rustfmt::skip]
pub(super) const ANY_LEFT: [[f64; 6]; 3] = [
    [-0.075945, 1.0236, -2.4776, 1.1113, -0.70136, 4.0153],
    [-0.24120, 1.0337, 3.6060, 2.7285, -0.38425, -7.4579],
    [-0.038236, 1.0044, 4.5369, 1.2567, -0.11439, -6.3663],
];

/// Quantiles of log2 (BV tests of a frame / those of the frame before).
#[rustfmt::skip]
pub(super) const ALL_AFTER: [f64; 3] = [-0.29149, -0.0038481, 0.42103];

/// The same if the first hit ends the query.
#[rustfmt::skip]
pub(super) const ANY_AFTER: [f64; 3] = [-4.7952, 0.0040171, 5.5955];

/// log2 of opened node pairs: intercept, slope in log2 of BV tests.
#[rustfmt::skip]
pub(super) const OPENINGS_OF_BV_TESTS: [f64; 2] = [-4.9933, 1.0525];

/// log2 of triangle tests: the same.
#[rustfmt::skip]
pub(super) const TRIANGLE_TESTS_OF_BV_TESTS: [f64; 2] = [-2.5284, 0.87710];

/// Logit of a hit, weights of `hit_features`.
#[rustfmt::skip]
pub(super) const HIT: [f64; 13] = [-3.0126, 0.41350, 0.0077423, 0.46141, 0.083106, -0.57913, 1.4651, -0.50506, -0.25127, -0.58097, 0.32098, -0.38501, -0.78790];

/// The same before the query.
#[rustfmt::skip]
pub(super) const HIT_BEFORE: [f64; 13] = [-3.2030, 0.75953, 0.0, 0.56137, 0.027721, 0.60233, 1.7058, -0.82757, 0.22816, -0.046876, -0.038381, 0.0, -1.3677];

/// The same with the verdict of the frame before, weights of `history_features`.
#[rustfmt::skip]
pub(super) const HIT_AFTER_HISTORY: [f64; 6] = [0.34642, 1.6874, 0.77742, 0.18369, -2.4346, 0.67469];

/// Share of poses with a hit.
#[rustfmt::skip]
pub(super) const BASE_RATE: f64 = 0.59532;

/// Logit of the recall, weights of `recall_features`.
#[rustfmt::skip]
pub(super) const RECALL: [f64; 9] = [-2.2001, -0.10534, 0.32089, 0.061233, 0.052297, 0.014263, -0.58047, -3.4141, 0.27734];

/// Cost of a BV test, a triangle test, an opened node pair and a query, by `CostModel::measure`.
#[rustfmt::skip]
pub(super) const NANOSECONDS: [f64; 4] = [0.43416, 16.854, 15.225, 57.872];
