//! The pairs of bodies whose distances are requested, individually or as pairs of two groups.

use crate::error::SceneError;
use crate::id::{MeasureId, PairKey, SceneNumber, bodies_of};
use crate::pair::bounds::{Bounds, Near};
use alloc::collections::{BTreeMap, BTreeSet};
use alloc::vec::Vec;
use core::mem;

/// The distance request of a pair.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DistanceRequest {
    pub tolerance: f64,
    /// Distances beyond it are not resolved.
    pub ceiling: f64,
    /// True if the pair itself is requested; true if groups request it.
    pub by_itself: bool,
    pub of_groups: bool,
}

impl DistanceRequest {
    /// True if the distance is measured as required, or if the pair is known to be no closer than
    /// its groups, up to the tolerance.
    pub fn is_settled(&self, near: &Near) -> bool {
        let Bounds {
            low, high, below, ..
        } = near.bounds;
        let is_measured = near.is_of_query
            && (high == 0.0 || below > 0.0 && (high <= below || below >= self.ceiling));
        is_measured || !self.by_itself && low >= self.ceiling - self.tolerance
    }
}

/// Two groups of bodies whose least distance is requested, with their state at the begin of a
/// frame.
#[derive(Clone, Debug)]
pub(crate) struct Group {
    /// `None` for the free slot of a group whose request has ended.
    pub id: Option<MeasureId>,
    /// The pairs of bodies, ascending.
    pub keys: Vec<PairKey>,
    /// The index of the pair whose boxes are looked at next, and the pair with the nearest boxes so
    /// far.
    pub next: usize,
    pub nearest: Option<PairKey>,
    /// The closest pair found, the bounds proven for it, and the frame of the proof.
    pub closest: Option<(PairKey, Bounds, u64)>,
    /// Upper bound of the distance of the groups, proven for the current frame before any query.
    pub ceiling: f64,
}

impl Group {
    const FREE: Self = Self {
        id: None,
        keys: Vec::new(),
        next: 0,
        nearest: None,
        closest: None,
        ceiling: f64::INFINITY,
    };

    fn forget(&mut self, body: u32) {
        let stays = |key| !bodies_of(key).contains(&body);
        self.keys.retain(|&key| stays(key));
        self.nearest = self.nearest.filter(|&nearest| stays(nearest));
        self.closest = self.closest.filter(|&(closest, ..)| stays(closest));
    }
}

#[derive(Clone, Debug, Default)]
pub(crate) struct DistanceRequests {
    /// The pairs requested individually, each with its tolerance.
    pub pairs: BTreeMap<PairKey, f64>,
    /// The pairs of groups, each with the number of the groups and the tolerance, ascending.
    of_groups: Vec<(PairKey, u32, f64)>,
    pub groups: Vec<Group>,
    /// The groups whose boxes are looked at next.
    pub next: usize,
    /// Number of groups requested so far.
    count: u64,
}

impl DistanceRequests {
    /// The numbers of the groups that a pair belongs to, each with its tolerance.
    pub fn groups_of(&self, key: PairKey) -> impl Iterator<Item = (u32, f64)> {
        let from = self.of_groups.partition_point(|&(other, ..)| other < key);
        let of_pair = self.of_groups[from..]
            .iter()
            .take_while(move |&&(other, ..)| other == key);
        of_pair.map(|&(_, number, tolerance)| (number, tolerance))
    }

    /// The combined distance request of a pair, if there is one.
    pub fn wanted(&self, key: PairKey) -> Option<DistanceRequest> {
        let mut wanted = self.pairs.get(&key).map(|&tolerance| DistanceRequest {
            tolerance,
            ceiling: f64::INFINITY,
            by_itself: true,
            of_groups: false,
        });
        for (number, tolerance) in self.groups_of(key) {
            let ceiling = self.groups[number as usize].ceiling;
            let before = wanted.unwrap_or(DistanceRequest {
                tolerance,
                ceiling,
                by_itself: false,
                of_groups: true,
            });
            wanted = Some(DistanceRequest {
                tolerance: before.tolerance.min(tolerance),
                ceiling: before.ceiling.max(ceiling),
                of_groups: true,
                ..before
            });
        }
        wanted
    }

    /// True if the distance of a pair is requested.
    pub fn has(&self, key: PairKey) -> bool {
        self.pairs.contains_key(&key) || self.groups_of(key).next().is_some()
    }

    /// Requests the least distance of pairs of bodies, given in ascending order.
    pub fn insert_groups(
        &mut self,
        keys: &[PairKey],
        tolerance: f64,
        scene: SceneNumber,
    ) -> MeasureId {
        let id = MeasureId::new(self.count, scene);
        self.count += 1;
        let free = self.groups.iter().position(|group| group.id.is_none());
        let number = free.unwrap_or_else(|| {
            self.groups.push(Group::FREE);
            self.groups.len() - 1
        });
        self.groups[number] = Group {
            id: Some(id),
            keys: keys.to_vec(),
            ..Group::FREE
        };
        let new = keys.iter().map(|&key| (key, number as u32, tolerance));
        self.of_groups.extend(new);
        self.of_groups
            .sort_by_key(|&(key, number, _)| (key, number));
        id
    }

    /// Ends the request of groups. Returns the bodies of their pairs.
    pub fn remove_groups(&mut self, id: MeasureId) -> Result<BTreeSet<u32>, SceneError> {
        let is_it = |group: &Group| group.id.is_some_and(|known| known.is(id));
        let number = self.groups.iter().position(is_it);
        let number = number.ok_or(SceneError::NoSuchMeasure { measure: id })?;
        let ended = mem::replace(&mut self.groups[number], Group::FREE);
        let bodies = ended.keys.into_iter().flat_map(bodies_of).collect();
        self.of_groups
            .retain(|&(_, other, _)| other as usize != number);
        Ok(bodies)
    }

    pub fn forget(&mut self, body: u32) {
        let Self {
            pairs,
            of_groups,
            groups,
            ..
        } = self;
        pairs.retain(|&key, _| !bodies_of(key).contains(&body));
        of_groups.retain(|&(key, ..)| !bodies_of(key).contains(&body));
        groups.iter_mut().for_each(|group| group.forget(body));
    }

    pub fn has_body(&self, body: u32) -> bool {
        let of_groups = self.of_groups.iter().map(|(key, ..)| key);
        let mut keys = self.pairs.keys().chain(of_groups);
        keys.any(|&key| bodies_of(key).contains(&body))
    }
}
