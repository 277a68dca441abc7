//! The fitted constants of the model; made by `punctual fit`, not by hand.
//!
//! On 2026-11-21, on x86_64 linux, by version 0.1.0, from 2873 poses (27196 moments of queries) of:
//! delta_armadillo1k delta_armadillo4k delta_armadillo16k delta_armadillo86k delta_armadillo256k
//! delta_propeller1k delta_propeller4k delta_propeller16k delta_propeller64k contact_gear_ring_pinion
//! contact_spider_side contact_env_rob contact_spot_spot graze_env_rob tilted_env_rob tilted_gear_ring_pinion
//! coincident_gear_side path_env_rob_sweep path_roll_gear_side_pinion approach_spot_6k_gear_spider_12k
//! approach_armadillo_16k_gear_stand_3k approach_robots16_iiwa2_robots16_iiwa5
//! approach_robots16_iiwa7_robots16_iiwa3 approach_robots16_iiwa0_spot_6k approach_propeller_16k_propeller_16k
//! approach_armadillo_4k_armadillo_4k approach_gear_ring_58k_gear_ring_58k
//! approach_propeller_stl_7k_armadillo_86k approach_env_gear_pinion_15k approach_pile200_gear_pile200_quadknot
//! approach_rob_spot_6k

/// Quantiles of the BV tests left, for each the weights of `features_of_all`.
#[rustfmt::skip]
pub(super) const ALL_LEFT: [[f64; 3]; 3] = [
    [-0.018072, 1.0022, -0.74265],
    [-0.018390, 1.0029, 0.063947],
    [-0.0074120, 1.0039, 1.5584],
];

/// The same if the first hit ends the query, weights of `features_of_any`.
#[rustfmt::skip]
pub(super) const ANY_LEFT: [[f64; 6]; 3] = [
    [-0.073611, 1.0220, -0.72269, 1.4321, -0.82934, 3.8249],
    [-0.29157, 1.0439, 3.1937, 4.1672, -0.62907, -4.9966],
    [-0.0035506, 1.0017, 4.5680, -0.060836, 0.0063930, -6.7081],
];

/// Quantiles of log2 (BV tests of a frame / those of the frame before).
#[rustfmt::skip]
pub(super) const ALL_AFTER: [f64; 3] = [-0.42074, 0.000012898, 0.44687];

/// log2 of opened node pairs: intercept, slope in log2 of BV tests.
#[rustfmt::skip]
pub(super) const OPENINGS_OF_BV_TESTS: [f64; 2] = [-5.6121, 1.0874];

/// log2 of triangle tests: the same.
#[rustfmt::skip]
pub(super) const TRIANGLE_TESTS_OF_BV_TESTS: [f64; 2] = [-6.0803, 1.1995];

/// Logit of a hit, weights of `hit_features`.
#[rustfmt::skip]
pub(super) const HIT: [f64; 13] = [-2.8804, 0.26942, -0.091174, 0.071658, 0.18335, 1.6817, 4.1017, -0.86849, -2.5272, -1.0120, 0.62574, -0.33591, -1.0648];

/// The same with the verdict of the frame before, weights of `history_features`.
#[rustfmt::skip]
pub(super) const HIT_AFTER_HISTORY: [f64; 3] = [-0.019306, 0.91984, 1.5510];

/// Share of poses with a hit.
#[rustfmt::skip]
pub(super) const BASE_RATE: f64 = 0.59972;

/// Logit of the recall, weights of `recall_features`.
#[rustfmt::skip]
pub(super) const RECALL: [f64; 9] = [-1.7167, -0.093424, 0.36926, 0.084076, 0.056986, -0.15167, 0.19693, -6.4371, 0.43985];

/// Cost of a BV test, a triangle test, an opened node pair and a query, by `CostModel::measure`.
#[rustfmt::skip]
pub(super) const NANOSECONDS: [f64; 4] = [0.32671, 17.944, 20.714, 59.412];

/// x
#[rustfmt::skip]
pub(super) const ROOT_MOST: [f64; 2] = [1.0, 1.0];

/// x
pub(super) const ANY_AFTER: [f64; 3] = [0.0; 3];
