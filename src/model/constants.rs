//! The fitted constants of the model; made by `punctual fit`, not by hand.
//!
//! On 2026-11-21, on x86_64 linux, by version 0.1.0, from 4385 poses (43508 moments of queries) of:
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
    [-0.017153, 1.0018, -1.6368],
    [-0.019651, 1.0026, -0.099199],
    [0.0032068, 1.0041, 1.3134],
];

/// 90 % quantile of log2 of a whole query from log2 of the cost of its roots at the deepest: intercept, slope.
#[rustfmt::skip]
pub(super) const ROOT_MOST: [f64; 2] = [2.6801, 0.95688];

/// The same if the first hit ends the query, weights of `features_of_any`.
#[rustfmt::skip]
pub(super) const ANY_LEFT: [[f64; 6]; 3] = [
    [-0.069154, 1.0403, 0.10767, 0.72139, -0.75747, 0.73264],
    [-0.29729, 1.0434, 3.7467, 2.6153, -0.38733, -8.2960],
    [0.018497, 0.99799, 4.1260, -0.16444, 0.025935, -6.5334],
];

/// Quantiles of log2 (BV tests of a frame / those of the frame before).
#[rustfmt::skip]
pub(super) const ALL_AFTER: [f64; 3] = [-0.29149, -0.0038481, 0.24794];

/// The same if the first hit ends the query.
#[rustfmt::skip]
pub(super) const ANY_AFTER: [f64; 3] = [-2.8628, 0.0013534, 2.1425];

/// log2 of opened node pairs: intercept, slope in log2 of BV tests.
#[rustfmt::skip]
pub(super) const OPENINGS_OF_BV_TESTS: [f64; 2] = [-4.9703, 1.0497];

/// log2 of triangle tests: the same.
#[rustfmt::skip]
pub(super) const TRIANGLE_TESTS_OF_BV_TESTS: [f64; 2] = [-2.7086, 0.89111];

/// Logit of a hit, weights of `hit_features`.
#[rustfmt::skip]
pub(super) const HIT: [f64; 13] = [-2.8974, 0.41948, -0.12211, 0.32082, 0.14727, 0.10604, 0.71821, -0.30308, 0.16811, -0.080910, 0.28149, -0.19111, -0.84232];

/// The same with the verdict of the frame before, weights of `history_features`.
#[rustfmt::skip]
pub(super) const HIT_AFTER_HISTORY: [f64; 4] = [0.18215, 1.3143, 0.73502, 0.22472];

/// Share of poses with a hit.
#[rustfmt::skip]
pub(super) const BASE_RATE: f64 = 0.59532;

/// Logit of the recall, weights of `recall_features`.
#[rustfmt::skip]
pub(super) const RECALL: [f64; 9] = [-1.9096, -0.20335, 0.28059, 0.11357, 0.0073007, 0.11152, -0.43820, -0.24212, 0.058174];

/// Cost of a BV test, a triangle test, an opened node pair and a query, by `CostModel::measure`.
#[rustfmt::skip]
pub(super) const NANOSECONDS: [f64; 4] = [0.37815, 17.140, 16.068, 59.631];
