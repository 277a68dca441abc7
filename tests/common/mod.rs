//! What the contract tests share: random input, input from files, the reference answer, and the checks
//! that every outcome must pass.
#![allow(
    dead_code,
    reason = "each test file is a crate of its own and uses a part"
)]

pub mod ask;
pub mod check;
pub mod files;
pub mod meshes;
pub mod random;
pub mod reference;
pub mod steps;

use punctual::Mode;
use punctual::intersection::Order;

pub const MODES: [Mode; 2] = [Mode::Any, Mode::All];

pub const ORDERS: [Order; 3] = [Order::Penetration, Order::LowAlpha, Order::DepthFirst];
