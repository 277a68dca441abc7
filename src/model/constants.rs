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
    [0.0044142, 1.0058, 1.5326],
];

/// 90 % quantile of log2 of a whole query from log2 of the cost of its roots at the deepest: intercept, slope.
#[rustfmt::skip]
pub(super) const ROOT_MOST: [f64; 2] = [2.6050, 1.0125];

/// The same if the first hit ends the query, weights of `features_of_any`.
#[rustfmt::skip]
pub(super) const ANY_LEFT: [[f64; 6]; 3] = [
    [-0.058359, 1.0352, -0.40249, 0.60245, -0.73984, 1.4805],
    [-0.30117, 1.0442, 3.2870, 2.6750, -0.39735, -7.4290],
    [0.022077, 0.99778, 4.7899, -0.16107, 0.026910, -7.2304],
];

/// Quantiles of log2 (BV tests of a frame / those of the frame before).
#[rustfmt::skip]
pub(super) const ALL_AFTER: [f64; 3] = [-0.29149, -0.0038481, 0.35669];

/// The same if the first hit ends the query.
#[rustfmt::skip]
pub(super) const ANY_AFTER: [f64; 3] = [-2.8628, 0.0013534, 8.6705];

/// log2 of opened node pairs: intercept, slope in log2 of BV tests.
#[rustfmt::skip]
pub(super) const OPENINGS_OF_BV_TESTS: [f64; 2] = [-4.9703, 1.0497];

/// log2 of triangle tests: the same.
#[rustfmt::skip]
pub(super) const TRIANGLE_TESTS_OF_BV_TESTS: [f64; 2] = [-2.7086, 0.89111];

/// Logit of a hit, weights of `hit_features`.
#[rustfmt::skip]
pub(super) const HIT: [f64; 13] = [-2.9461, 0.43067, -0.11813, 0.34911, 0.10891, 0.27736, 1.6032, -0.51537, -0.11491, -0.16063, 0.28163, -0.18944, -0.91326];

/// The same with the verdict of the frame before, weights of `history_features`.
#[rustfmt::skip]
pub(super) const HIT_AFTER_HISTORY: [f64; 4] = [0.22925, 1.3486, 0.85529, 0.19226];

/// Share of poses with a hit.
#[rustfmt::skip]
pub(super) const BASE_RATE: f64 = 0.59532;

/// Logit of the recall, weights of `recall_features`.
#[rustfmt::skip]
pub(super) const RECALL: [f64; 9] = [-1.9847, -0.15284, 0.29678, 0.086089, 0.028578, 0.063551, -1.0654, -0.69777, 0.17699];

/// Cost of a BV test, a triangle test, an opened node pair and a query, by `CostModel::measure`.
#[rustfmt::skip]
pub(super) const NANOSECONDS: [f64; 4] = [0.51521, 22.145, 20.458, 74.183];
