//! The broad phase: finds the pairs of bodies that may meet.
//!
//! Each body has its box and a fat AABB around it. While the box stays inside the fat AABB, nothing
//! else is done. Bodies that have left theirs wait, and go through the tree of fat AABBs
//! ([`fat_tree`]) as a *generation* of newcomers. Their leaves are renewed. The tree is refitted
//! along their paths, or completely, or rebuilt. Then one descent of the tree against itself finds
//! the pairs of overlapping fat AABBs of which one is new. It skips all subtrees without a new one,
//! and pairs of fixed bodies. The pairs found are sorted and merged into the known pairs
//! ([`super::schedule::pairs`]), which stay until one of their bodies leaves its fat AABB again.
//!
//! Every step ends with its share of the frame, and continues in the next frame. A body whose
//! generation is unfinished is *open*: some of its partners may be unknown. If many pairs are
//! found, they are merged in portions, so that the first of them are known long before the last.
//!
//! Cost: nothing for bodies that rest; `O(log n)` expected for a body that leaves its fat AABB, and
//! as much, spread over the frames, for rebuilding the tree after its bodies have moved.

pub(crate) mod bounds;
mod build;
pub(crate) mod fat_tree;
mod node;
mod sort;

use super::body::Bodies;
use super::facts::Change;
use super::id::PairKey;
use super::room::reserve;
use super::waiting::Waiting;
use crate::cost::{WORK_PER_NEW_PLACE, WORK_PER_REFIT};
use alloc::vec::Vec;
use bounds::widened;
use core::mem;
use fat_tree::FatTree;
use node::{NONE, Proxy};
use punctual::engine::Deadline;
use punctual_geom::Aabb;
use sort::Sort;

/// Widening of a moving body's box to its fat AABB, on each side, relative to its longest edge.
const SLACK: f64 = 0.05;

/// Number of newcomers of a generation if time or work is limited: at least `GENERATION`, one for
/// each `GENERATION_PART` known pairs, and as many as there is room for. Finding the pairs of one
/// newcomer takes about as long as merging `GENERATION_PART` pairs.
const GENERATION: usize = 64;
const GENERATION_PART: usize = 64;
const WORK_PER_NEWCOMER: u64 = 350;

/// Bodies per step.
const STEP: usize = 16;

/// Pairs per portion: at least `PORTION`, and at least one for each `PORTION_PART` known pairs.
const PORTION: usize = 4096;
const PORTION_PART: usize = 4;

/// The next step for the newcomers of a generation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Stage {
    /// Takes waiting bodies as newcomers, and puts them into the tree.
    #[default]
    Renew,
    Build,
    Refit,
    Search,
    /// Sorts a portion; `last` if it is the last one.
    Sort {
        last: bool,
    },
    Merge {
        last: bool,
    },
    /// Ends the newcomer state, starting with the last of them.
    Settle,
}

#[derive(Clone, Debug, Default)]
pub(crate) struct Broad {
    proxies: Vec<Proxy>,
    /// The news of each body in this generation: one byte, because it is read for both bodies of
    /// all known pairs.
    news: Vec<Change>,
    waiting: Waiting,
    newcomers: Vec<u32>,
    stage: Stage,
    tree: FatTree,
    /// A portion of pairs, ascending.
    pub found: Vec<PairKey>,
    sort: Sort,
    /// True if pairs of this generation were left out; and the open bodies of such generations.
    crops: bool,
    cropped: Vec<u32>,
    /// True if the earlier pairs of the newcomers were removed: the first portion of this
    /// generation was merged.
    pub purged: bool,
    /// Number of open bodies, with possibly unknown partners.
    pub open: usize,
}

impl Broad {
    /// The news of a pair of bodies in this generation.
    pub fn news(&self, pair: [u32; 2]) -> Change {
        let [x, y] = pair.map(|body| self.news[body as usize]);
        x.max(y)
    }

    /// True if the slot had another body when the known pairs were found.
    #[inline(always)]
    fn is_another(&self, body: u32) -> bool {
        self.proxies[body as usize].next == Change::Body
            || !self.purged && self.news[body as usize] == Change::Body
    }

    /// True if the results of a pair belong to another body than it has now.
    #[inline(always)]
    pub fn is_of_another(&self, bodies: &Bodies, pair: [u32; 2]) -> bool {
        pair.into_iter()
            .any(|body| bodies.facts(body).is_another() || self.is_another(body))
    }

    /// True if a pair is compared even if its distance is not measured: one of its bodies was a
    /// moving one when it was last placed.
    #[inline(always)]
    pub fn compares(&self, [a, b]: [u32; 2]) -> bool {
        self.proxies[a as usize].moving | self.proxies[b as usize].moving
    }

    /// True if the current portion contains all pairs of its generation.
    pub fn has_found_all(&self) -> bool {
        !self.purged && self.stage == (Stage::Merge { last: true })
    }

    /// True if all partners of a body are known.
    pub fn is_closed(&self, body: u32) -> bool {
        self.proxies
            .get(body as usize)
            .is_some_and(|proxy| !proxy.open)
    }

    /// True if there were more pairs than allowed.
    pub fn has_cropped(&self) -> bool {
        !self.cropped.is_empty()
    }

    /// True if two bodies overlap and may meet, by their state in the tree.
    pub fn overlap(&self, bodies: &Bodies, [a, b]: [u32; 2]) -> bool {
        let [x, y] = [a, b].map(|body| &self.proxies[body as usize]);
        (x.moving || y.moving)
            && self.tree.bounds(x).intersects(&self.tree.bounds(y))
            && bodies.may_meet([a, b])
    }

    /// The tree, whose boxes contain those of all bodies except the
    /// [unsettled](Broad::is_unsettled) ones. `None` during a rebuild.
    pub fn tree(&self) -> Option<&FatTree> {
        (self.stage != Stage::Build).then_some(&self.tree)
    }

    /// True if the box of a body may not be in the tree.
    pub fn is_unsettled(&self, body: u32) -> bool {
        self.proxies[body as usize].waiting || self.news[body as usize] != Change::None
    }

    /// The unsettled bodies, each once.
    pub fn unsettled(&self) -> impl Iterator<Item = u32> {
        let newcomers = self
            .newcomers
            .iter()
            .copied()
            .filter(|&body| !self.proxies[body as usize].waiting);
        self.waiting
            .iter()
            .chain(newcomers.filter(|&body| self.is_unsettled(body)))
    }

    /// Reserves room for bodies of indices below `bodies`.
    pub fn reserve(&mut self, bodies: usize) {
        reserve(&mut self.proxies, bodies);
        reserve(&mut self.news, bodies);
        reserve(&mut self.newcomers, bodies);
        reserve(&mut self.cropped, bodies);
        self.waiting.reserve(bodies);
        self.tree.reserve(bodies);
    }

    /// Reserves room for this many pairs found in a frame.
    pub fn reserve_found(&mut self, pairs: usize) {
        reserve(&mut self.found, pairs);
    }

    /// Inserts a body without a box.
    pub fn insert(&mut self, body: u32) {
        if body as usize == self.proxies.len() {
            self.proxies.push(Proxy::NOWHERE);
            self.news.push(Change::None);
        }
    }

    /// Sets the box of a body; an empty box removes it.
    pub fn place(&mut self, body: u32, bounds: Aabb, moving: bool, news: Change, importance: f32) {
        let proxy = &mut self.proxies[body as usize];
        proxy.moving = moving;
        let inside = proxy.fat.min.cmple(bounds.min).all() && bounds.max.cmple(proxy.fat.max).all();
        if inside && news <= Change::None && !bounds.is_empty() {
            return;
        }
        proxy.fat = match moving {
            true => widened(bounds, SLACK * bounds.extents().max_element()),
            false => bounds,
        };
        proxy.next = proxy.next.max(news).max(Change::Place);
        if !proxy.waiting {
            self.waiting.push(body, importance);
            proxy.waiting = true;
        }
        self.open += usize::from(!proxy.open);
        proxy.open = true;
    }

    /// Requeues bodies whose pairs were left out for lack of room.
    pub fn retry(&mut self, bodies: &Bodies, deadline: &mut Deadline) {
        while deadline.has_room(WORK_PER_NEW_PLACE)
            && let Some(body) = self.cropped.pop()
        {
            deadline.spend(WORK_PER_NEW_PLACE);
            let proxy = &mut self.proxies[body as usize];
            proxy.cropped = NONE;
            if !proxy.waiting {
                (proxy.waiting, proxy.next) = (true, Change::Place);
                self.waiting.push(body, bodies.facts(body).importance);
            }
        }
    }

    /// Finds pairs that may meet, of overlapping fat AABBs of which one is new, and puts a portion
    /// of them into [`Broad::found`]. `None` if none is left, or the deadline came first. `known`:
    /// the number of known pairs, and its maximum.
    pub fn find(
        &mut self,
        bodies: &Bodies,
        known: [usize; 2],
        deadline: &mut Deadline,
    ) -> Option<()> {
        loop {
            self.stage = match self.stage {
                Stage::Renew => self.renew(known[0], deadline)?,
                Stage::Build => self
                    .tree
                    .build(&mut self.proxies, &self.news, deadline)
                    .then_some(Stage::Refit)?,
                Stage::Refit => self.tree.refit(deadline).then_some(Stage::Search)?,
                Stage::Search => {
                    let enough = portion(known, deadline);
                    let Self { tree, found, .. } = self;
                    let last = tree.search(bodies, found, enough, deadline)?;
                    Stage::Sort { last }
                }
                Stage::Sort { last } => self
                    .sort
                    .advance(&mut self.found, deadline)
                    .then_some(Stage::Merge { last })?,
                Stage::Merge { .. } => return Some(()),
                Stage::Settle => self.settle(deadline)?,
            };
        }
    }

    /// Ends a portion that was merged. `left_out`: some of its pairs were left out for lack of
    /// room.
    pub fn end_portion(&mut self, left_out: bool) {
        // If pairs were left out, the next portions have no room either.
        let is_last = left_out || self.stage == (Stage::Merge { last: true });
        self.stage = if is_last {
            Stage::Settle
        } else {
            Stage::Search
        };
        (self.crops, self.purged) = (left_out, true);
        self.found.clear();
    }

    fn renew(&mut self, known: usize, deadline: &mut Deadline) -> Option<Stage> {
        let room = usize::try_from(deadline.room() / WORK_PER_NEWCOMER).unwrap_or(usize::MAX);
        let most = if is_limited(deadline) {
            GENERATION.max(known / GENERATION_PART).max(room)
        } else {
            usize::MAX
        };
        while self.newcomers.len() < most && !self.waiting.is_empty() {
            if !deadline.has_room(WORK_PER_NEW_PLACE) {
                return None;
            }
            deadline.spend(WORK_PER_NEW_PLACE);
            if self.newcomers.is_empty() {
                self.tree.begin_generation(self.waiting.len().min(most));
            }
            let body = self.waiting.pop()?;
            let proxy = &mut self.proxies[body as usize];
            proxy.waiting = false;
            self.tree.renew(body, proxy);
            let news = &mut self.news[body as usize];
            if *news == Change::None {
                self.newcomers.push(body);
            }
            *news = mem::replace(&mut proxy.next, Change::None).max(*news);
        }
        let begin = || match self.tree.begin_update(self.proxies.len()) {
            true => Stage::Build,
            false => Stage::Refit,
        };
        (!self.newcomers.is_empty()).then(begin)
    }

    /// Ends a generation.
    fn settle(&mut self, deadline: &mut Deadline) -> Option<Stage> {
        loop {
            if !deadline.has_room(STEP as u64 * WORK_PER_REFIT) {
                return None;
            }
            deadline.spend(STEP as u64 * WORK_PER_REFIT);
            let rest = self.newcomers.len().saturating_sub(STEP);
            for body in self.newcomers.drain(rest..) {
                let proxy = &mut self.proxies[body as usize];
                self.news[body as usize] = Change::None;
                if self.crops {
                    if proxy.cropped == NONE {
                        proxy.cropped = self.cropped.len() as u32;
                        self.cropped.push(body);
                    }
                } else if !proxy.waiting {
                    self.open -= usize::from(mem::take(&mut proxy.open));
                    let at = mem::replace(&mut proxy.cropped, NONE);
                    if at != NONE {
                        self.cropped.swap_remove(at as usize);
                        if let Some(&moved) = self.cropped.get(at as usize) {
                            self.proxies[moved as usize].cropped = at;
                        }
                    }
                }
            }
            if self.newcomers.is_empty() {
                (self.crops, self.purged) = (false, false);
                return Some(Stage::Renew);
            }
        }
    }
}

/// Number of pairs of the next portion.
fn portion([known, most]: [usize; 2], deadline: &Deadline) -> usize {
    let portion = PORTION.max(known / PORTION_PART);
    match is_limited(deadline) {
        true => portion.min(most),
        false => most,
    }
}

fn is_limited(deadline: &Deadline) -> bool {
    deadline.is_timed() || deadline.work_left() < u64::MAX / 2
}
