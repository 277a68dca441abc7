//! The pairs of bodies whose distances are requested, individually or as pairs of two groups.

use crate::error::SceneError;
use crate::id::{MeasureId, PairKey, SceneNumber, bodies_of};
use crate::pair::bounds::{Bounds, Near};
use alloc::vec::Vec;

/// The source of a distance request: the pair itself, or two groups, by number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Asker {
    Pair,
    Groups(u32),
}

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
    /// Number of pairs of bodies.
    pub pairs: usize,
    /// The closest pair found, the bounds proven for it, and the frame of the proof.
    pub closest: Option<(PairKey, Bounds, u64)>,
    /// Upper bound of the distance of the groups, proven for the current frame before any query.
    pub ceiling: f64,
}

impl Group {
    const FREE: Self = Self {
        id: None,
        pairs: 0,
        closest: None,
        ceiling: f64::INFINITY,
    };

    fn forget(&mut self, key: PairKey) {
        self.pairs -= 1;
        self.closest = self.closest.filter(|&(closest, ..)| closest != key);
    }
}

#[derive(Clone, Debug, Default)]
pub(crate) struct DistanceRequests {
    /// Ascending, each with its tolerance.
    pairs: Vec<(PairKey, Asker, f64)>,
    /// Number of requests of single pairs.
    pub of_pairs: usize,
    pub groups: Vec<Group>,
    /// Number of groups requested so far.
    count: u64,
}

impl DistanceRequests {
    fn place(&self, key: PairKey, asker: Asker) -> Result<usize, usize> {
        self.pairs
            .binary_search_by_key(&(key, asker), |&(key, asker, _)| (key, asker))
    }

    /// The sources of the distance requests of a pair, each with its tolerance.
    pub fn askers(&self, key: PairKey) -> impl Iterator<Item = (Asker, f64)> {
        let from = self.pairs.partition_point(|&(other, ..)| other < key);
        let of_pair = self.pairs[from..]
            .iter()
            .take_while(move |&&(other, ..)| other == key);
        of_pair.map(|&(_, asker, tolerance)| (asker, tolerance))
    }

    /// The combined distance request of a pair, if there is one.
    pub fn wanted(&self, key: PairKey) -> Option<DistanceRequest> {
        let all = self.askers(key).map(|(asker, tolerance)| match asker {
            Asker::Pair => DistanceRequest {
                tolerance,
                ceiling: f64::INFINITY,
                by_itself: true,
                of_groups: false,
            },
            Asker::Groups(number) => {
                let ceiling = self.groups[number as usize].ceiling;
                DistanceRequest {
                    tolerance,
                    ceiling,
                    by_itself: false,
                    of_groups: true,
                }
            }
        });
        all.reduce(|x, y| DistanceRequest {
            tolerance: x.tolerance.min(y.tolerance),
            ceiling: x.ceiling.max(y.ceiling),
            by_itself: x.by_itself || y.by_itself,
            of_groups: x.of_groups || y.of_groups,
        })
    }

    /// True if the distance of a pair is requested.
    pub fn has(&self, key: PairKey) -> bool {
        self.askers(key).next().is_some()
    }

    pub fn insert(&mut self, key: PairKey, asker: Asker, tolerance: f64) {
        match self.place(key, asker) {
            Ok(at) => self.pairs[at].2 = tolerance,
            Err(at) => {
                self.pairs.insert(at, (key, asker, tolerance));
                self.of_pairs += usize::from(asker == Asker::Pair);
            }
        }
    }

    pub fn remove(&mut self, key: PairKey, asker: Asker) {
        if let Ok(at) = self.place(key, asker) {
            self.pairs.remove(at);
            self.of_pairs -= usize::from(asker == Asker::Pair);
        }
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
            pairs: keys.len(),
            ..Group::FREE
        };
        self.pairs.extend(
            keys.iter()
                .map(|&key| (key, Asker::Groups(number as u32), tolerance)),
        );
        self.pairs.sort_by_key(|&(key, asker, _)| (key, asker));
        id
    }

    /// Ends the request of groups. Returns the bodies of their pairs.
    pub fn remove_groups(&mut self, id: MeasureId) -> Result<Vec<u32>, SceneError> {
        let number = self
            .groups
            .iter()
            .position(|group| group.id.is_some_and(|known| known.is(id)));
        let number = number.ok_or(SceneError::NoSuchMeasure { measure: id })?;
        self.groups[number] = Group::FREE;
        let of_it = Asker::Groups(number as u32);
        let mut bodies: Vec<_> = self.keys(of_it).flat_map(bodies_of).collect();
        bodies.sort_unstable();
        bodies.dedup();
        self.pairs.retain(|&(_, asker, _)| asker != of_it);
        Ok(bodies)
    }

    pub fn forget(&mut self, body: u32) {
        let Self {
            pairs,
            groups,
            of_pairs,
            ..
        } = self;
        pairs.retain(|&(key, asker, _)| {
            let stays = !bodies_of(key).contains(&body);
            match asker {
                _ if stays => {}
                Asker::Groups(number) => groups[number as usize].forget(key),
                Asker::Pair => *of_pairs -= 1,
            }
            stays
        });
    }

    pub fn has_body(&self, body: u32) -> bool {
        self.pairs
            .iter()
            .any(|&(key, ..)| bodies_of(key).contains(&body))
    }

    pub fn keys(&self, of: Asker) -> impl Iterator<Item = PairKey> {
        self.pairs
            .iter()
            .filter(move |&&(_, asker, _)| asker == of)
            .map(|&(key, ..)| key)
    }
}
