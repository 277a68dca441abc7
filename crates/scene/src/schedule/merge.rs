//! Merges the pairs that the broad phase finds into the known ones, in steps, so that a frame may
//! end between any two of them.

use super::known::Known;
use super::pairs::Pairs;
use crate::body::Bodies;
use crate::broad::Broad;
use crate::cost::WORK_PER_MERGED_PAIR;
use crate::facts::Change;
use crate::id::bodies_of;
use core::mem;
use punctual::engine::Deadline;

/// Pairs per step.
const STEP: usize = 32;

impl Pairs {
    /// Updates the list of known pairs, as far as the deadline allows.
    pub fn update(&mut self, broad: &mut Broad, bodies: &Bodies, deadline: &mut Deadline) {
        if broad.has_cropped() && self.len() < self.most - self.most / 8 {
            broad.retry(bodies, deadline);
        }
        while broad
            .find(bodies, [self.len(), self.most], deadline)
            .is_some()
            && self.merge(broad, bodies, deadline)
        {
            mem::swap(&mut self.known, &mut self.merged);
            self.merged.clear();
            broad.end_portion(mem::take(&mut self.merge).left_out);
        }
    }

    /// Merges a portion of new pairs with the known ones; true if done. Before the first portion of
    /// a generation, drops pairs of its newcomers whose fat AABBs no longer overlap.
    fn merge(&mut self, broad: &Broad, bodies: &Bodies, deadline: &mut Deadline) -> bool {
        let found = &broad.found;
        const WORK: u64 = STEP as u64 * WORK_PER_MERGED_PAIR;
        while self.merge.known < self.known.len() || self.merge.found < found.len() {
            if !deadline.has_room(WORK) {
                return false;
            }
            deadline.spend(WORK);
            for _ in 0..STEP {
                let (known, new) = (
                    self.known.get(self.merge.known).copied(),
                    found.get(self.merge.found).copied(),
                );
                match (known, new) {
                    (Some(mut known), new) if new.is_none_or(|new| known.key <= new) => {
                        let news = broad.news(bodies_of(known.key));
                        self.merge.known += 1;
                        let again = new == Some(known.key);
                        if self.stays(&mut known, news, again, broad, bodies) {
                            self.merge.found += usize::from(again);
                            self.merged.push(known);
                        }
                    }
                    (_, Some(key)) => {
                        self.merge.found += 1;
                        if self.merged.len() + self.known.len() - self.merge.known < self.most {
                            self.merged.push(Known::new(key));
                        } else {
                            self.merge.left_out = true;
                        }
                    }
                    _ => break,
                }
            }
        }
        true
    }

    /// True if a pair stays. `again`: it was found again. If it does not stay, its state is
    /// released.
    #[inline]
    fn stays(
        &mut self,
        known: &mut Known,
        news: Change,
        again: bool,
        broad: &Broad,
        bodies: &Bodies,
    ) -> bool {
        let pair = bodies_of(known.key);
        let stays = broad.purged
            || match news {
                Change::Settle | Change::None => true,
                Change::Place => again || !broad.has_found_all() && broad.overlap(bodies, pair),
                Change::Body => false,
            };
        if stays {
            return true;
        }
        let is_measured = bodies.distance_requests.has(known.key);
        if !is_measured || news == Change::Body {
            self.release(known.end());
        }
        is_measured
    }
}
