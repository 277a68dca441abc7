//! The fitted constants of the model; made by `punctual fit`, not by hand.
//!
//! Fitted on 2026-11-29, on x86_64 linux, by version 0.1.0,
//! from 4385 poses (199167 moments of queries) of:
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
//! The constants of distance, motion, contact and batch queries, and of queries that trace curves,
//! were fitted on the same day from 1908 poses of these cases and of clear_env_rob clear_spot_spot
//! clear_gear_ring_pinion. The approaches, coincident copies and delta_armadillo256k were left out.

/// Quantiles of log2 of the BV tests left if all hits are wanted: for each, the weights of
/// `features_of_all`.
pub(super) const ALL_LEFT: [[f64; 7]; 3] = [
    [0.0015451, 0.99894, -3.5175, 2.3178, -1.1131, 0.20642, 0.0010717],
    [-0.0094540, 1.0016, -0.79867, -0.15943, -0.84750, 0.20284, -0.00089169],
    [0.000030123, 1.0012, 1.3075, -1.0368, -0.29442, 0.13398, -0.0013526],
];

/// `ALL_LEFT` before the query.
pub(super) const ALL_BEFORE: [[f64; 7]; 3] = [
    [0.20678, 0.95576, -2.2461, 0.91548, -1.0335, 0.32531, 0.020497],
    [-0.049270, 1.0075, -1.3043, 0.25329, -0.84211, 0.31323, -0.0020263],
    [0.27290, 1.0073, 1.4167, -1.9447, -0.64267, 0.39230, -0.0038370],
];

/// 90 % quantile of log2 of the BV tests of a whole query: intercept, and slope in log2 of the pair
/// cost of the roots at their deepest penetration.
pub(super) const ROOT_MOST: [f64; 2] = [2.6610, 1.0170];

/// `ALL_LEFT` if the first hit ends the query: for each, the weights of `features_of_any`.
pub(super) const ANY_LEFT: [[f64; 10]; 3] = [
    [0.34416, 1.0250, 0.44012, -2.3903, -0.66251, 0.10367, -0.095041, -3.6968, -0.25649, -3.4816],
    [0.037799, 1.0171, 0.98557, -4.4058, -0.74603, 0.19762, 0.053990, -0.56425, -0.15630, -1.1574],
    [0.0089371, 0.99924, 2.5639, -2.5057, -0.18151, 0.10402, -0.00062521, -0.014100, 0.0018774, -3.1062],
];

/// `ANY_LEFT` before the query.
pub(super) const ANY_BEFORE: [[f64; 10]; 3] = [
    [-0.41192, 1.0559, -1.4172, 1.2643, -0.56326, 0.18610, -0.0061560, 6.1752, -0.92084, -1.0450],
    [-0.40016, 1.0484, 4.1985, -0.095780, -0.39848, 0.11426, -0.076752, 6.5320, -0.78166, -7.3076],
    [-0.33959, 1.0397, 5.3203, -3.7100, 0.30434, -0.0086800, -0.045810, 6.2255, -0.67117, -3.7848],
];

/// Quantiles of log2 (BV tests of a query / BV tests of the query in the frame before).
pub(super) const ALL_AFTER: [f64; 3] = [-0.28242, 0.00077439, 0.47595];

/// `ALL_AFTER` if the first hit ends the query.
pub(super) const ANY_AFTER: [f64; 3] = [-4.1912, 0.0066589, 5.8926];

/// log2 of opened node pairs: intercept, and slope in log2 of BV tests.
pub(super) const OPENINGS_OF_BV_TESTS: [f64; 2] = [-4.4930, 1.0211];

/// log2 of triangle tests: intercept, and slope in log2 of BV tests.
pub(super) const TRIANGLE_TESTS_OF_BV_TESTS: [f64; 2] = [-3.0670, 0.94232];

/// Logit of a hit after a part of the query: weights of `hit_features`.
pub(super) const HIT: [f64; 13] = [-2.0300, 0.15955, -0.015340, 0.27755, 0.085277, -0.62109, 1.0802, -0.56488, -0.57816, -0.22608, 0.46305, -0.36871, -0.42351];

/// Logit of a hit before the query: weights of `hit_features`.
pub(super) const HIT_BEFORE: [f64; 13] = [-2.5318, 0.63051, 0.0, 0.52441, 0.018923, 0.48023, 1.6610, -0.88714, 0.039863, -0.24913, -0.022648, 0.0, -1.2531];

/// Logit of a hit with the verdict of the frame before: weights of `history_features`.
pub(super) const HIT_AFTER_HISTORY: [f64; 6] = [0.76448, 2.4481, 0.79807, 0.19423, -2.9445, 0.95547];

/// Fraction of poses with a hit.
pub(super) const BASE_RATE: f64 = 0.59532;

/// Logit of the recall: weights of `recall_features`.
pub(super) const RECALL: [f64; 9] = [0.37842, -0.61847, 0.17011, 0.10383, 0.36476, 0.0048750, 0.27167, -0.25893, 0.13975];

/// Logit of the recall of queries that trace curves: weights of `tracing_features`.
pub(super) const RECALL_TRACING: [f64; 16] = [-2.7643, -0.87036, 0.28172, 0.034710, -0.27742, -0.029249, 0.37296, -0.065535, 0.069166, 2.0079, -0.36317, -1.4739, 0.13632, 0.33502, -0.038218, 0.84296];

/// Quantiles of log2 of the work left in a distance query without a limit: for each, the weights of
/// `closing_features`.
pub(super) const DISTANCE_LEFT: [[f64; 7]; 3] = [
    [10.945, 0.025070, -0.13434, 1.2203, 1.4608, 0.038658, 0.29510],
    [10.123, 0.071241, 0.025200, 0.52050, 1.8185, -1.0457, 1.2621],
    [9.9855, 0.21420, -0.070192, 0.58144, 1.4354, -0.70436, 0.70846],
];

/// Quantiles of log2 of the work left in a distance query with a limit: for each, the weights of
/// `closing_features`.
pub(super) const LIMIT_LEFT: [[f64; 7]; 3] = [
    [7.9260, 0.10863, -0.021806, 1.0605, -0.92352, 0.082484, -1.3215],
    [9.5989, 0.049259, 0.087962, -0.53360, -0.34237, -0.19821, 0.14550],
    [9.3797, 0.11951, 0.18270, -1.9903, -0.55140, -0.78617, 0.071912],
];

/// Quantiles of log2 (work of a distance query / work of the query in the frame before).
pub(super) const DISTANCE_AFTER: [f64; 3] = [-1.8186, -0.0000060017, 2.2590];

/// Quantiles of the distance, scaled to 0 at its lower bound and 1 at its upper bound: for each,
/// the weights of `between_features`.
pub(super) const DISTANCE_BETWEEN: [[f64; 4]; 3] = [
    [-0.044345, 0.0036722, -0.096102, 0.81014],
    [-0.082254, 0.0078323, 0.54271, 0.43905],
    [0.95729, 0.0029875, 0.0011183, 0.010844],
];

/// Quantiles of log2 of the work left in a motion query: for each, the weights of
/// `passing_features`.
pub(super) const MOTION_LEFT: [[f64; 9]; 3] = [
    [2.7675, 0.067072, 0.12823, 0.61537, 1.1564, -3.3652, 0.66564, 0.70742, -0.0039642],
    [8.1066, 0.15969, 0.17504, 1.0128, -0.99540, -0.29433, 0.17559, -0.34424, 0.030590],
    [11.268, 0.14267, 0.43416, 0.84065, -1.3776, -0.035026, 0.078624, -0.74981, 0.051820],
];

/// Quantiles of log2 (work of a motion query / work of the query for the motion before).
pub(super) const MOTION_AFTER: [f64; 3] = [-0.25998, -0.18699, 2.0463];

/// Quantiles of log2 of the work left in a contact query: for each, the weights of
/// `listing_features`.
pub(super) const CONTACTS_LEFT: [[f64; 7]; 3] = [
    [2.7829, -0.10554, 0.65810, 0.066100, 0.30382, 0.43859, 0.0],
    [11.819, -0.14129, 0.010360, 0.54307, 0.47595, 0.56465, 0.0],
    [18.160, 0.13776, -0.69549, 1.0440, 0.21945, 0.41013, 0.0],
];

/// `CONTACTS_LEFT` of a manifold query.
pub(super) const MANIFOLDS_LEFT: [[f64; 7]; 3] = [
    [2.4129, -0.061958, 0.63667, 0.078970, 0.41352, 0.36220, -6.4492],
    [8.7626, -0.011621, 0.19147, 0.44007, 0.41724, 0.34420, -9.9763],
    [16.347, 0.17713, -0.38938, 1.0349, -0.0058066, 0.19266, -4.8280],
];

/// Quantiles of log2 of the work left for each ray of a batch, before one is done: for each, the
/// weights of `single_features`.
pub(super) const RAY_WORK: [[f64; 5]; 3] = [
    [5.3091, 0.065037, 0.25353, 0.71640, -1.3308],
    [8.3846, 0.12133, -0.16550, 1.2843, -0.37511],
    [7.5882, 0.21112, -0.12550, 0.89522, 0.43147],
];

/// `RAY_WORK` of points.
pub(super) const POINT_WORK: [[f64; 5]; 3] = [
    [0.52723, 0.0010209, 0.11502, 9.7230, -1.4849],
    [6.7827, -0.14047, 0.42306, 3.4563, -0.99182],
    [19.790, -0.47267, -0.010286, 0.11241, -0.024480],
];

/// Quantiles of log2 of the work left in a batch over the mean of those done times those left: for
/// each, the weights of `batch_features`.
pub(super) const BATCH_LEFT: [[f64; 3]; 3] = [
    [-0.013839, -0.72808, -0.15375],
    [0.065488, -0.25496, 0.11607],
    [0.036497, 0.72758, 0.44998],
];
