//! What the fuzz targets share: numbers made of bytes, and the judges of the contract tests.
//!
//! Run one with `cargo +nightly fuzz run triangles`. A find becomes a unit test, named after what went wrong.

#[path = "../../tests/common/ask.rs"]
pub mod ask;
#[path = "../../tests/common/check.rs"]
pub mod check;
/// Where the tests have it.
pub mod common {
    pub use crate::ask;
}
#[path = "../../tests/contacts/truth.rs"]
pub mod contacts;
#[path = "../../tests/common/distance.rs"]
pub mod distance;
#[path = "../../tests/common/exact_distance.rs"]
pub mod exact_distance;
#[path = "../../tests/common/oracle.rs"]
pub mod oracle;
#[path = "../../tests/common/reference.rs"]
pub mod reference;

use libfuzzer_sys::arbitrary::{Result, Unstructured};
use punctual::clock::ManualClock;
use punctual::contacts::Contact;
use punctual::glam::{DMat3, DQuat, DVec3};
use punctual::intersection::Order;
use punctual::{
    Budget, Certificate, Mesh, Mode, PairMemory, Pose, Query, StopReason, Tree, Workspace,
};

/// How coordinates are read from bytes.
#[derive(Clone, Copy)]
pub enum Numbers {
    /// Whole numbers from -4 to 4: touching, coplanar, degenerate.
    Whole,
    /// The same, each moved by a few units in the last place.
    NearWhole,
    /// Zeros, ones, denormals and huge numbers side by side.
    Extreme,
    /// Any fraction of 1.
    Fraction,
    /// Any bits: NaN and infinity too.
    Bits,
}

impl Numbers {
    pub fn arbitrary(bytes: &mut Unstructured) -> Result<Self> {
        bytes
            .choose(&[
                Self::Whole,
                Self::NearWhole,
                Self::Extreme,
                Self::Fraction,
                Self::Bits,
            ])
            .copied()
    }

    pub fn read(self, bytes: &mut Unstructured) -> Result<f64> {
        const LARGEST: f64 = f64::from_bits((1023 + 1000) << 52);
        const EXTREME: [f64; 8] = [
            0.0,
            5e-324,
            1.5e-323,
            1.0,
            1.0 + f64::EPSILON,
            1e-160,
            LARGEST,
            0.7 * LARGEST,
        ];
        let whole = |bytes: &mut Unstructured| Ok(f64::from(bytes.int_in_range(-4..=4_i8)?));
        match self {
            Self::Whole => whole(bytes),
            Self::NearWhole => {
                let value = whole(bytes)?;
                Ok(moved(value, bytes.int_in_range(-3..=3)?))
            }
            Self::Extreme => {
                let value = *bytes.choose(&EXTREME)?;
                Ok(if bytes.arbitrary()? { value } else { -value })
            }
            Self::Fraction => Ok(f64::from(bytes.arbitrary::<i32>()?) / f64::exp2(31.0)),
            Self::Bits => Ok(f64::from_bits(bytes.arbitrary()?)),
        }
    }

    pub fn point(self, bytes: &mut Unstructured) -> Result<[f64; 3]> {
        Ok([self.read(bytes)?, self.read(bytes)?, self.read(bytes)?])
    }
}

/// `value` moved by `steps` units in the last place.
pub fn moved(value: f64, steps: i8) -> f64 {
    let step = if steps < 0 {
        f64::next_down
    } else {
        f64::next_up
    };
    (0..steps.unsigned_abs()).fold(value, |value, _| step(value))
}

/// A mesh of up to twelve triangles, if its coordinates are in range.
pub fn few_triangles(bytes: &mut Unstructured) -> Result<Option<Tree>> {
    let numbers = Numbers::arbitrary(bytes)?;
    let vertices = (0..bytes.int_in_range(1..=9)?)
        .map(|_| numbers.point(bytes))
        .collect::<Result<Vec<_>>>()?;
    let last = vertices.len() as u32 - 1;
    let mut index = || bytes.int_in_range(0..=last);
    let mut triangles = Vec::new();
    for _ in 0..12 {
        triangles.push([index()?, index()?, index()?]);
    }
    triangles.truncate(bytes.int_in_range(1..=12)?);
    Ok(Mesh::from_f64(vertices, triangles).ok().map(Tree::new))
}

/// Any pose; the matrix may not quite be a rotation.
pub fn pose(bytes: &mut Unstructured) -> Result<Pose> {
    let [x, y, z] = Numbers::Fraction.point(bytes)?;
    let turn = if bytes.arbitrary()? {
        DQuat::IDENTITY
    } else {
        DQuat::from_xyzw(x, y, z, 0.7).normalize()
    };
    let mut turn = DMat3::from_quat(turn).to_cols_array();
    turn[bytes.int_in_range(0..=8)?] += if bytes.arbitrary()? { 2e-4 } else { 0.0 };
    let place = Numbers::arbitrary(bytes)?.point(bytes)?;
    Ok(
        Pose::new(DMat3::from_cols_array(&turn), DVec3::from_array(place))
            .unwrap_or(Pose::IDENTITY),
    )
}

/// A length that is 0, about a known one, or any.
pub fn length(known: f64, bytes: &mut Unstructured) -> Result<f64> {
    let part = f64::from(bytes.arbitrary::<u16>()?) / 32768.0;
    Ok(match bytes.int_in_range(0..=3)? {
        0 => 0.0,
        1 => part * known,
        2 => moved(known, bytes.int_in_range(-3..=3)?).max(0.0),
        _ => Numbers::arbitrary(bytes)?.read(bytes)?.abs().min(1e300),
    })
}

/// No more contacts than were said, and each one that is missing in a box.
pub fn assert_names(certificate: &Certificate, found: u64, missing: &[Contact]) {
    assert!(found + missing.len() as u64 <= certificate.upper_bound());
    let boxes: Vec<_> = certificate.boxes().collect();
    for contact in missing {
        let middle = 0.5 * contact.points[0] + 0.5 * contact.points[1];
        assert!(
            boxes
                .iter()
                .any(|b| b.min.cmple(middle).all() && middle.cmple(b.max).all()),
            "{contact:?}"
        );
    }
}

/// Runs a query in pieces of `work` units: sound and certified at every stop, and the truth in the end.
pub fn assert_query(a: &Tree, b: &Tree, pose: Pose, bytes: &mut Unstructured) -> Result<()> {
    let mode = *bytes.choose(&[Mode::Any, Mode::All])?;
    let orders = [Order::Penetration, Order::LowAlpha, Order::DepthFirst];
    let query = Query::intersection(a, b, pose)
        .mode(mode)
        .order(*bytes.choose(&orders)?);
    let work = u64::from(bytes.arbitrary::<u16>()?);
    let truth = reference::all_pairs(a.mesh(), b.mesh(), &pose);
    let mut workspace =
        Workspace::with_capacity(bytes.int_in_range(1..=64)?, bytes.int_in_range(1..=64)?);
    let (mut memory, clock) = (PairMemory::new(), ManualClock::new());
    // The second time, what met the first time is known.
    for _ in 0..2 {
        let mut pairs = Vec::new();
        let mut outcome =
            check::run_with_memory(&query, &mut workspace, &mut memory, Budget::work(work));
        for stop in 0..1000 {
            // To look through the boxes of a certificate takes far longer than the query.
            if stop < 16 {
                let certificate = query
                    .certificate(&workspace)
                    .expect("the workspace holds this query");
                check::assert_certificate(&certificate, &outcome, truth.len());
            }
            if matches!(outcome.stop, StopReason::Finished | StopReason::FirstHit) {
                break;
            }
            pairs.extend(workspace.drain_pairs());
            check::assert_sound(&outcome, &pairs, &truth);
            let resumed = query
                .with_memory(&mut memory)
                .resume(&mut workspace, Budget::work(work.max(1)).clock(&clock));
            outcome = resumed.expect("the workspace holds a stopped run");
        }
        pairs.extend(workspace.drain_pairs());
        if matches!(outcome.stop, StopReason::Finished | StopReason::FirstHit) {
            check::assert_complete(mode, &outcome, &pairs, &truth);
        }
    }
    Ok(())
}
