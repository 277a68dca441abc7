//! The fitted constants of the model; made by `punctual fit`, not by hand.
//!
//! Fitted on 2026-11-21, on x86_64 linux, by version 0.1.0,
//! from 4385 poses (43562 moments of queries) of:
//! delta_armadillo1k delta_armadillo4k delta_armadillo16k delta_armadillo86k delta_armadillo256k
//! delta_propeller1k delta_propeller4k delta_propeller16k delta_propeller64k
//! contact_gear_ring_pinion contact_spider_side contact_env_rob contact_spot_spot graze_env_rob
//! tilted_env_rob tilted_gear_ring_pinion coincident_gear_side path_env_rob_sweep
//! path_roll_gear_side_pinion approach_spot_6k_gear_spider_12k approach_armadillo_16k_gear_stand_3k
//! approach_robots16_iiwa2_robots16_iiwa5 approach_robots16_iiwa7_robots16_iiwa3
//! approach_robots16_iiwa0_spot_6k approach_propeller_16k_propeller_16k
//! approach_armadillo_4k_armadillo_4k approach_gear_ring_58k_gear_ring_58k
//! approach_propeller_stl_7k_armadillo_86k approach_env_gear_pinion_15k
//! approach_pile200_gear_pile200_quadknot approach_rob_spot_6k
//! approach_robots16_iiwa1_robots16_iiwa4 approach_robots16_iiwa6_gear_pinion_15k
//! approach_armadillo_86k_gear_spider_12k approach_propeller_16k_spot_6k approach_spot_6k_env
//! approach_propeller_4k_gear_side_12k approach_armadillo_16k_propeller_64k
//! approach_pile200_armadillo_robots16_iiwa4 approach_gear_side_12k_gear_side_12k
//!
//! The constants of distance queries were fitted on 2026-11-22, from 1908 poses of these cases and
//! of clear_env_rob clear_spot_spot clear_gear_ring_pinion. The approaches, coincident copies and
//! delta_armadillo256k were left out.
//!
//! The constants of motion queries were fitted on 2026-11-23, from the motions from pose to pose of
//! these cases and from the sweeps env_rob and spot_spot. The motions of a propeller, coincident
//! copies and delta_armadillo256k were left out.
//!
//! The constants of queries that trace curves were fitted on 2026-11-25, from 1865 poses of these
//! cases. The approaches were left out.

/// Quantiles of log2 of the BV tests left if all hits are wanted: for each, the weights of
/// `features_of_all`.
pub(super) const ALL_LEFT: [[f64; 7]; 3] = [
    [-0.025026, 1.0026, -1.6487, 0.0, 0.0, 0.0, 0.0],
    [-0.039575, 1.0050, -0.10988, 0.0, 0.0, 0.0, 0.0],
    [0.14354, 0.99455, 1.7445, 0.0, 0.0, 0.0, 0.0],
];

/// `ALL_LEFT` before the query.
pub(super) const ALL_BEFORE: [[f64; 7]; 3] = [
    [-0.025026, 1.0026, -1.6487, 0.0, 0.0, 0.0, 0.0],
    [-0.039575, 1.0050, -0.10988, 0.0, 0.0, 0.0, 0.0],
    [0.14354, 0.99455, 1.7445, 0.0, 0.0, 0.0, 0.0],
];

/// 90 % quantile of log2 of the BV tests of a whole query: intercept, and slope in log2 of the pair
/// cost of the roots at their deepest penetration.
pub(super) const ROOT_MOST: [f64; 2] = [2.3561, 1.0466];

/// `ALL_LEFT` if the first hit ends the query: for each, the weights of `features_of_any`.
pub(super) const ANY_LEFT: [[f64; 10]; 3] = [
    [-0.11789, 1.0316, -3.4804, 0.0, 0.0, 0.0, 0.0, 2.6199, -0.93492, 6.9775],
    [-0.30612, 1.0419, 3.5469, 0.0, 0.0, 0.0, 0.0, 3.0504, -0.42183, -7.3675],
    [-0.038696, 1.0048, 5.6575, 0.0, 0.0, 0.0, 0.0, 1.2483, -0.11526, -7.9252],
];

/// `ANY_LEFT` before the query.
pub(super) const ANY_BEFORE: [[f64; 10]; 3] = [
    [-0.11789, 1.0316, -3.4804, 0.0, 0.0, 0.0, 0.0, 2.6199, -0.93492, 6.9775],
    [-0.30612, 1.0419, 3.5469, 0.0, 0.0, 0.0, 0.0, 3.0504, -0.42183, -7.3675],
    [-0.038696, 1.0048, 5.6575, 0.0, 0.0, 0.0, 0.0, 1.2483, -0.11526, -7.9252],
];

/// Quantiles of log2 (BV tests of a query / BV tests of the query in the frame before).
pub(super) const ALL_AFTER: [f64; 3] = [-0.29039, -0.0029708, 0.43043];

/// `ALL_AFTER` if the first hit ends the query.
pub(super) const ANY_AFTER: [f64; 3] = [-5.3305, 0.0078160, 5.9325];

/// log2 of opened node pairs: intercept, and slope in log2 of BV tests.
pub(super) const OPENINGS_OF_BV_TESTS: [f64; 2] = [-4.9203, 1.0445];

/// log2 of triangle tests: intercept, and slope in log2 of BV tests.
pub(super) const TRIANGLE_TESTS_OF_BV_TESTS: [f64; 2] = [-2.5719, 0.88080];

/// Logit of a hit after a part of the query: weights of `hit_features`.
pub(super) const HIT: [f64; 13] = [-3.0251, 0.44342, 0.021767, 0.39432, 0.10233, -0.37516, 0.96049, -0.43527, -0.45667, -0.48038, 0.25316, -0.40518, -0.72371];

/// Logit of a hit before the query: weights of `hit_features`.
pub(super) const HIT_BEFORE: [f64; 13] = [-3.1240, 0.75563, 0.0, 0.54019, 0.037195, 0.65239, 1.6749, -0.79392, 0.049332, -0.11954, -0.11479, 0.0, -1.3529];

/// Logit of a hit with the verdict of the frame before: weights of `history_features`.
pub(super) const HIT_AFTER_HISTORY: [f64; 6] = [0.34550, 1.7943, 0.77020, 0.15686, -1.7552, 0.60292];

/// Fraction of poses with a hit.
pub(super) const BASE_RATE: f64 = 0.59532;

/// Logit of the recall: weights of `recall_features`.
pub(super) const RECALL: [f64; 9] = [0.24755, -0.59158, 0.27036, -0.073537, 0.48435, -0.031655, -0.14588, -0.66470, 0.13313];

/// Logit of the recall of queries that trace curves: weights of `tracing_features`.
pub(super) const RECALL_TRACING: [f64; 16] = [2.7915, -0.71107, 0.32200, -0.0068241, -0.20890, 0.013899, 0.46217, -0.0092937, 1.0719, -3.1585, 1.0856, -2.0559, 0.29183, 0.0, 0.0, 0.0];

/// Quantiles of log2 of the work left in a distance query without a limit: for each, the weights of
/// `closing_features`.
pub(super) const DISTANCE_LEFT: [[f64; 7]; 3] = [
    [11.602, 0.020537, -0.11780, 0.58089, 0.60319, 0.99577, 0.19815],
    [10.452, 0.065289, 0.024336, 0.52276, 1.6783, -1.2556, 1.2662],
    [10.291, 0.19286, -0.039584, 0.57409, 1.3414, -0.91433, 0.68986],
];

/// Quantiles of log2 of the work left in a distance query with a limit: for each, the weights of
/// `closing_features`.
pub(super) const LIMIT_LEFT: [[f64; 7]; 3] = [
    [7.6567, 0.10200, 0.017550, 1.2767, -0.86463, 0.10738, -1.2700],
    [9.1266, 0.049469, 0.14256, -0.55719, -0.42540, -0.24797, 0.18299],
    [8.8680, 0.12851, 0.25060, -2.1664, -0.69089, -0.87985, -0.064677],
];

/// Quantiles of log2 (work of a distance query / work of the query in the frame before).
pub(super) const DISTANCE_AFTER: [f64; 3] = [-1.6650, -0.0023899, 2.1417];

/// Quantiles of the distance, scaled to 0 at its lower bound and 1 at its upper bound: for each,
/// the weights of `between_features`.
pub(super) const DISTANCE_BETWEEN: [[f64; 4]; 3] = [
    [-0.060312, 0.0048440, -0.079538, 0.79467],
    [-0.16459, 0.015051, 0.50353, 0.46545],
    [0.97398, 0.0019116, -0.0012752, 0.0092845],
];

/// Quantiles of log2 of the work left in a motion query: for each, the weights of
/// `passing_features`.
pub(super) const MOTION_LEFT: [[f64; 9]; 3] = [
    [5.3179, 0.12719, 0.10194, 0.82308, 0.29305, -2.3285, 0.37442, 1.0658, -0.029714],
    [9.6852, 0.12962, 0.13778, 1.0666, -0.76250, -0.22955, 0.10888, 1.6587, -0.088122],
    [11.348, 0.15721, 0.39135, 0.84391, -0.96966, -0.47490, 0.059743, 3.5382, -0.18787],
];

/// Quantiles of log2 (work of a motion query / work of the query for the motion before).
pub(super) const MOTION_AFTER: [f64; 3] = [-0.42837, -0.26026, 2.0847];

/// Quantiles of log2 of the work left in a contact query: for each, the weights of
/// `listing_features`.
pub(super) const CONTACTS_LEFT: [[f64; 7]; 3] = [[0.0; 7]; 3];

/// `CONTACTS_LEFT` of a manifold query.
pub(super) const MANIFOLDS_LEFT: [[f64; 7]; 3] = [[0.0; 7]; 3];

/// Quantiles of log2 of the work left for each ray of a batch, before one is done: for each, the
/// weights of `single_features`.
pub(super) const RAY_WORK: [[f64; 5]; 3] = [[0.0; 5]; 3];

/// `RAY_WORK` of points.
pub(super) const POINT_WORK: [[f64; 5]; 3] = [[0.0; 5]; 3];

/// Quantiles of log2 of the work left in a batch over the mean of those done times those left: for
/// each, the weights of `batch_features`.
pub(super) const BATCH_LEFT: [[f64; 3]; 3] = [[0.0; 3]; 3];
