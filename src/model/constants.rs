//! The fitted constants of the model; made by `punctual fit`, not by hand.
//!
//! Fitted on 2026-11-29, on x86_64 linux, by version 0.1.0,
//! from 4529 poses (102055 moments of queries) of:
//! delta_armadillo1k delta_armadillo4k delta_armadillo16k delta_armadillo86k delta_propeller1k
//! delta_propeller4k delta_propeller16k delta_propeller64k contact_gear_ring_pinion
//! contact_spider_side contact_env_rob contact_spot_spot graze_env_rob tilted_env_rob
//! tilted_gear_ring_pinion delta_armadillo256k coincident_gear_side clear_env_rob clear_spot_spot
//! clear_gear_ring_pinion env_rob spot_spot path_env_rob_sweep path_roll_gear_side_pinion
//! approach_spot_6k_gear_spider_12k approach_armadillo_16k_gear_stand_3k
//! approach_robots16_iiwa2_robots16_iiwa5 approach_robots16_iiwa7_robots16_iiwa3
//! approach_robots16_iiwa0_spot_6k approach_propeller_16k_propeller_16k
//! approach_armadillo_4k_armadillo_4k approach_gear_ring_58k_gear_ring_58k
//! approach_propeller_stl_7k_armadillo_86k approach_env_gear_pinion_15k
//! approach_pile200_gear_pile200_quadknot approach_rob_spot_6k
//! approach_robots16_iiwa1_robots16_iiwa4 approach_robots16_iiwa6_gear_pinion_15k
//! approach_armadillo_86k_gear_spider_12k approach_propeller_16k_spot_6k approach_spot_6k_env
//! approach_propeller_4k_gear_side_12k approach_armadillo_16k_propeller_64k
//! approach_pile200_armadillo_robots16_iiwa4 approach_gear_side_12k_gear_side_12k

/// Quantiles of log2 of the BV tests left if all hits are wanted: for each, the weights of
/// `features_of_all`.
pub(super) const ALL_LEFT: [[f64; 7]; 3] = [
    [0.0016878, 0.99894, -3.5175, 2.3178, -1.1131, 0.20642, 0.0010717],
    [-0.0094509, 1.0016, -0.79867, -0.15943, -0.84750, 0.20284, -0.00089169],
    [0.000024452, 1.0012, 1.3075, -1.0368, -0.29442, 0.13398, -0.0013526],
];

/// `ALL_LEFT` before the query.
pub(super) const ALL_BEFORE: [[f64; 7]; 3] = [
    [0.18451, 0.95576, -2.2461, 0.91548, -1.0335, 0.32531, 0.020497],
    [-0.049013, 1.0075, -1.3043, 0.25329, -0.84211, 0.31323, -0.0020263],
    [0.31225, 1.0073, 1.4167, -1.9447, -0.64267, 0.39230, -0.0038370],
];

/// 90 % quantile of log2 of the BV tests of a whole query: intercept, and slope in log2 of the pair
/// cost of the roots at their deepest penetration.
pub(super) const ROOT_MOST: [f64; 2] = [2.6271, 1.0170];

/// `ALL_LEFT` if the first hit ends the query: for each, the weights of `features_of_any`.
pub(super) const ANY_LEFT: [[f64; 10]; 3] = [
    [0.22461, 1.0273, 1.7281, -2.9966, -0.18295, 0.018494, -0.15841, -2.6361, -0.30238, -6.3305],
    [-0.032112, 1.0256, 1.5497, -4.7077, -0.43770, 0.13728, 0.050665, 0.15097, -0.26020, -1.7022],
    [0.0091892, 0.99928, 2.5576, -2.2792, -0.19004, 0.10127, -0.00069321, -0.015756, 0.0020403, -3.2893],
];

/// `ANY_LEFT` before the query.
pub(super) const ANY_BEFORE: [[f64; 10]; 3] = [
    [-0.36558, 1.0482, -1.5608, 1.2486, -0.56040, 0.18318, -0.0078189, 6.1332, -0.91193, -0.84366],
    [-0.35032, 1.0424, 3.9020, -0.10826, -0.40344, 0.11419, -0.077664, 6.5704, -0.78395, -6.8974],
    [-0.27409, 1.0346, 5.0998, -3.6602, 0.30599, -0.0091110, -0.047171, 6.2636, -0.67464, -3.5182],
];

/// Quantiles of log2 (BV tests of a query / BV tests of the query in the frame before).
pub(super) const ALL_AFTER: [f64; 3] = [-0.28242, 0.00077439, 0.47595];

/// `ALL_AFTER` if the first hit ends the query.
pub(super) const ANY_AFTER: [f64; 3] = [-4.1912, 0.0066589, 5.8926];

/// log2 of opened node pairs: intercept, and slope in log2 of BV tests.
pub(super) const OPENINGS_OF_BV_TESTS: [f64; 2] = [-4.6670, 1.0287];

/// log2 of triangle tests: intercept, and slope in log2 of BV tests.
pub(super) const TRIANGLE_TESTS_OF_BV_TESTS: [f64; 2] = [-2.6668, 0.89237];

/// Logit of a hit after a part of the query: weights of `hit_features`.
pub(super) const HIT: [f64; 13] = [-2.0545, 0.14782, -0.014845, 0.26249, 0.093864, -0.55266, 0.89947, -0.64466, -0.49895, -0.28519, 0.49345, -0.40568, -0.43197];

/// Logit of a hit before the query: weights of `hit_features`.
pub(super) const HIT_BEFORE: [f64; 13] = [-2.6748, 0.65440, 0.0, 0.54428, 0.019640, 0.49843, 1.7240, -0.92075, 0.041373, -0.25857, -0.023506, 0.0, -1.3006];

/// Logit of a hit with the verdict of the frame before: weights of `history_features`.
pub(super) const HIT_AFTER_HISTORY: [f64; 6] = [0.81793, 2.3606, 0.86609, 0.19448, -2.7724, 0.98510];

/// Fraction of poses with a hit.
pub(super) const BASE_RATE: f64 = 0.59532;

/// Logit of the recall: weights of `recall_features`.
pub(super) const RECALL: [f64; 9] = [0.37842, -0.61847, 0.17011, 0.10383, 0.36476, 0.0048750, 0.27167, -0.25893, 0.13975];

/// Logit of the recall of queries that trace curves: weights of `tracing_features`.
pub(super) const RECALL_TRACING: [f64; 19] = [-3.5950, -0.95580, 0.28620, -0.20493, -0.21775, -0.11543, 0.55259, -0.056377, 0.0048529, 2.7916, -1.1454, -0.35844, -0.054772, 0.51518, 0.039268, 0.74783, 8.9976, 0.16617, -0.69348];

/// Quantiles of log2 of the work left in a distance query without a limit: for each, the weights of
/// `closing_features`.
pub(super) const DISTANCE_LEFT: [[f64; 7]; 3] = [
    [10.955, 0.025070, -0.13434, 1.2203, 1.4608, 0.038658, 0.29510],
    [10.151, 0.071241, 0.025200, 0.52050, 1.8185, -1.0457, 1.2621],
    [9.9802, 0.21420, -0.070192, 0.58144, 1.4354, -0.70436, 0.70846],
];

/// Quantiles of log2 of the work left in a distance query with a limit: for each, the weights of
/// `closing_features`.
pub(super) const LIMIT_LEFT: [[f64; 7]; 3] = [
    [7.9277, 0.10863, -0.021806, 1.0605, -0.92352, 0.082484, -1.3215],
    [9.6132, 0.049259, 0.087962, -0.53360, -0.34237, -0.19821, 0.14550],
    [9.3923, 0.11951, 0.18270, -1.9903, -0.55140, -0.78617, 0.071912],
];

/// Quantiles of log2 (work of a distance query / work of the query in the frame before).
pub(super) const DISTANCE_AFTER: [f64; 3] = [-1.8186, -0.0000060017, 2.2590];

/// Quantiles of the distance, scaled to 0 at its lower bound and 1 at its upper bound: for each,
/// the weights of `between_features`.
pub(super) const DISTANCE_BETWEEN: [[f64; 4]; 3] = [
    [-0.044348, 0.0036722, -0.096102, 0.81014],
    [-0.082411, 0.0078323, 0.54271, 0.43905],
    [0.95747, 0.0029875, 0.0011183, 0.010844],
];

/// Quantiles of log2 of the work left in a motion query: for each, the weights of
/// `passing_features`.
pub(super) const MOTION_LEFT: [[f64; 9]; 3] = [
    [2.8128, 0.068729, 0.071600, 0.90108, 0.90072, -3.4012, 0.67241, -0.29855, 0.060286],
    [7.9991, 0.16371, 0.16680, 0.94519, -0.31820, -0.92202, 0.17168, -0.49310, 0.041519],
    [10.993, 0.15441, 0.45579, 0.62993, -0.42072, -0.97802, 0.077464, -0.77776, 0.055078],
];

/// Quantiles of log2 (work of a motion query / work of the query for the motion before).
pub(super) const MOTION_AFTER: [f64; 3] = [-0.25998, -0.18699, 2.0463];

/// Quantiles of log2 of the work left in a contact query: for each, the weights of
/// `listing_features`.
pub(super) const CONTACTS_LEFT: [[f64; 6]; 3] = [
    [2.8068, -0.10554, 0.65810, 0.066100, 0.30382, 0.43859],
    [11.777, -0.14129, 0.010360, 0.54307, 0.47595, 0.56465],
    [18.142, 0.13776, -0.69549, 1.0440, 0.21945, 0.41013],
];

/// `CONTACTS_LEFT` of a manifold query.
pub(super) const MANIFOLDS_LEFT: [[f64; 6]; 3] = [
    [2.6484, -0.23844, 0.23570, 0.10764, 0.70037, 1.3332],
    [11.055, -0.36697, 0.10360, 0.31648, 0.67441, 1.2224],
    [16.771, 0.13963, -0.49495, 0.92321, 0.21289, 0.39631],
];

/// Quantiles of log2 of the work left for each ray of a batch, before one is done: for each, the
/// weights of `single_features`.
pub(super) const RAY_WORK: [[f64; 5]; 3] = [
    [7.5570, -0.0059655, 0.075194, 0.42716, -1.2919],
    [8.4968, 0.14223, -0.21281, 1.2596, -0.37749],
    [7.0986, 0.16689, -0.032727, 1.0373, 0.35170],
];

/// `RAY_WORK` of points.
pub(super) const POINT_WORK: [[f64; 5]; 3] = [
    [0.34280, -0.00056553, 0.14735, 9.7207, -1.5413],
    [6.8547, -0.16934, 0.48034, 3.5200, -1.0557],
    [19.776, -0.47154, -0.0098362, 0.096887, -0.027150],
];

/// Quantiles of log2 of the work left in a batch over the mean of those done times those left: for
/// each, the weights of `batch_features`.
pub(super) const BATCH_LEFT: [[f64; 3]; 3] = [
    [-0.015229, -0.81862, -0.029208],
    [0.059870, -0.22226, -0.026268],
    [0.058320, 0.65861, 0.48597],
];
