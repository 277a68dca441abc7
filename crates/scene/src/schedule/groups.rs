//! Collects the distance bounds of groups in a frame.
//!
//! The least lower bound of all pairs of two groups is a lower bound of their distance; any upper
//! bound of a pair is an upper bound. Pairs that are farther apart than the least upper bound need
//! no query. At the begin of a frame, the *ceiling* stands for this least upper bound: the upper
//! bound of the last frame, corrected for displacements. All of this holds wherever the frame is
//! cut.

use crate::ask::distance_requests::DistanceRequests;
use crate::body::Bodies;
use crate::id::{PairKey, bodies_of};
use crate::pair::bounds::{Bounds, Near};
use crate::pair::frame::Frame;
use crate::pair::state::PairState;
use crate::report::{GroupDistance, Report};
use crate::room::reserve;
use alloc::vec::Vec;

/// The bounds of two groups.
#[derive(Clone, Copy, Debug)]
struct BoundsOfGroup {
    /// The least lower bound of the pairs examined.
    low: f64,
    /// The closest pair that was queried.
    closest: Option<(PairKey, Bounds)>,
    counted: usize,
    /// Number of the pairs examined that may be closer.
    open: usize,
}

#[derive(Debug, Default)]
pub(crate) struct BoundsOfGroups(Vec<BoundsOfGroup>);

impl BoundsOfGroups {
    pub fn reserve(&mut self, groups: usize) {
        reserve(&mut self.0, groups);
    }

    pub fn begin(&mut self, requests: &DistanceRequests) {
        self.0.clear();
        let nothing = BoundsOfGroup {
            low: f64::INFINITY,
            closest: None,
            counted: 0,
            open: 0,
        };
        self.0.extend(requests.groups.iter().map(|_| nothing));
    }

    /// Copies other bounds.
    pub fn copy(&mut self, other: &Self) {
        self.0.clone_from(&other.0);
    }

    /// Adds a pair. `None`: its bodies may not meet, so it does not count.
    pub fn add(
        &mut self,
        requests: &DistanceRequests,
        key: PairKey,
        near: Option<&Near>,
        is_settled: bool,
    ) {
        for (number, _) in requests.groups_of(key) {
            let of_group = &mut self.0[number as usize];
            of_group.counted += 1;
            let Some(near) = near else { continue };
            of_group.open += usize::from(!is_settled);
            of_group.low = of_group.low.min(near.bounds.low);
            let high = of_group
                .closest
                .map_or(requests.groups[number as usize].ceiling, |(_, bounds)| {
                    bounds.high
                });
            if near.is_of_query && near.bounds.high <= high {
                of_group.closest = Some((key, near.bounds));
            }
        }
    }

    /// Adds the bounds in the state of a pair.
    pub fn read(&mut self, key: PairKey, state: &PairState, frame: &Frame) {
        let requests = &frame.bodies.distance_requests;
        let near = (frame.bodies).near(key, state, frame.changed(key), frame.number);
        let wanted = requests.wanted(key);
        let is_settled = wanted.is_none_or(|wanted| wanted.is_settled(&near));
        self.add(requests, key, Some(&near), is_settled);
    }

    /// Reports the bounds at the end of a frame.
    pub fn report(&self, bodies: &Bodies, report: &mut Report) {
        for (of_group, group) in self.0.iter().zip(&bodies.distance_requests.groups) {
            let Some(id) = group.id else { continue };
            let ceiling = group.ceiling;
            let low = match of_group.counted == group.keys.len() {
                true => of_group.low,
                false => 0.0,
            };
            let carried = group.closest.filter(|_| ceiling < f64::INFINITY);
            let carried = carried.map(|(key, bounds, _)| {
                (
                    key,
                    Bounds {
                        high: ceiling,
                        ..bounds
                    },
                )
            });
            let closest = of_group.closest.or(carried);
            let high = closest.map_or(ceiling, |(_, bounds)| bounds.high);
            let bodies = closest.map(|(key, _)| bodies_of(key).map(|body| bodies.id(body)));
            let triangles = closest.and_then(|(_, bounds)| bounds.triangles);
            report.group_distances.push(GroupDistance {
                id,
                low: low.min(high),
                high,
                bodies,
                triangles,
                open: of_group.open + group.keys.len() - of_group.counted,
            });
        }
    }

    /// Passes the closest pairs of this frame on to the next frames.
    pub fn hand_on(&self, requests: &mut DistanceRequests, frame: u64) {
        for (of_group, group) in self.0.iter().zip(&mut requests.groups) {
            if let Some((key, bounds)) = of_group.closest {
                group.closest = Some((key, bounds, frame));
            }
        }
    }
}
