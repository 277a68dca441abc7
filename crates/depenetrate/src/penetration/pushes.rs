//! The steps of a penetration query, and those that look for a push: contacts give directions,
//! whose lengths are bisected.

use super::{
    AXES, Asking, CONTACTS, GROWTH, Heard, Job, Machine, PAIRS, SHORTER, WIDTH, WORK_PER_NEW_PAIR,
};
use crate::cover::Pair;
use crate::directions::Segments;
use glam::DVec3;

impl Machine<'_, '_, '_, '_> {
    /// Does one step, and returns its work: less than [`STEP`].
    pub(super) fn step(&mut self) -> u64 {
        match self.state.job {
            Job::Over => 0,
            Job::Contacts => self.ask(Asking::Contacts {
                at: DVec3::ZERO,
                most: CONTACTS,
            }),
            Job::Read(next) => self.read(next),
            Job::Explore => self.explore(),
            Job::Lengthen {
                direction, length, ..
            } => self.ask(Asking::Apart {
                at: direction * length,
            }),
            Job::Shorten {
                direction,
                low,
                high,
            } => {
                if high - low <= WIDTH * high {
                    self.state.job = self.next_job();
                    return 64;
                }
                self.ask(Asking::Apart {
                    at: direction * (0.5 * (low + high)),
                })
            }
            Job::About(index) => self.about(index),
            Job::Start => self.start(),
            Job::Seek(index) => self.seek(index),
            Job::Climb(climb) => self.climb(climb),
            Job::Pick => self.pick(),
            Job::Advance(task) => self.work_on(task),
        }
    }

    /// Takes the answer to the question of the job.
    pub(super) fn hear(&mut self, heard: Heard) {
        match (self.state.job, heard) {
            (Job::Contacts, Heard::Contacts(0)) => {
                // The surfaces are apart; solids may still be in one another.
                self.state.asking = self.asked.solid.then_some((
                    Asking::Contained {
                        at: DVec3::ZERO,
                        next: 0,
                    },
                    false,
                ));
                if !self.asked.solid {
                    self.are_apart();
                }
            }
            (Job::Contacts, Heard::Contacts(_)) => {
                let [first, ..] = *self.engine.pairs() else {
                    return;
                };
                let origin = self.corners(first)[0][0];
                let size = self.size();
                self.state.segments = Some(Segments::new(origin, size));
                self.state.job = Job::Read(0);
            }
            (Job::Contacts, Heard::Apart) => self.are_apart(),
            (Job::Contacts, Heard::Blocked(_)) => {
                self.state.likely.extend(AXES);
                self.add_sample_points();
                self.state.job = Job::Explore;
            }
            (
                Job::Lengthen {
                    direction,
                    length,
                    longest,
                },
                heard,
            ) => self.lengthened(direction, length, longest, heard),
            (
                Job::Shorten {
                    direction,
                    low,
                    high,
                },
                heard,
            ) => {
                let middle = 0.5 * (low + high);
                let [low, high] = if let Heard::Blocked(pair) = heard {
                    pair.inspect(|&pair| self.learn(pair, direction));
                    [
                        self.state.blocked.free_from(direction, middle, high).0,
                        high,
                    ]
                } else {
                    self.state.separates(direction, middle);
                    [low, middle]
                };
                self.state.job = Job::Shorten {
                    direction,
                    low,
                    high,
                };
            }
            (Job::About(index), Heard::Near(distance, nearest)) => {
                if let Some(ball) = self.add_ball(index, DVec3::ZERO, distance, nearest) {
                    self.raise_low(ball.radius.min(ball.longest));
                }
                self.state.job = Job::About(index + 1);
            }
            (Job::Climb(climb), Heard::Near(distance, _)) => self.climbed(climb, distance),
            (Job::Advance(task), heard) => self.worked_on(task, heard),
            _ => {}
        }
    }

    pub(super) fn are_apart(&mut self) {
        (self.state.low, self.state.high, self.state.is_apart) = (0.0, 0.0, true);
        self.state.job = Job::Over;
    }

    /// The longest extent of both meshes.
    pub(super) fn size(&self) -> f64 {
        let [a, b] = [self.asked.a, self.asked.b].map(|tree| tree.mesh().aabb().extents());
        a.max(b).max_element().max(f64::MIN_POSITIVE)
    }

    /// Reads some of the contacts at the pose.
    pub(super) fn read(&mut self, next: usize) -> u64 {
        const EACH: usize = 4;
        let count = self.engine.pairs().len();
        let last = (next + EACH).min(count);
        for i in next..last {
            let pair = self.engine.pairs()[i];
            let corners = self.corners(pair);
            if let Some(segments) = &mut self.state.segments {
                segments.add(&corners[0], &corners[1]);
            }
            let number = self.state.add_pair(pair, corners);
            let margin = self.state.pairs[number].margin();
            if margin > self.state.widest.0 {
                self.state.widest = (margin, number);
            }
            if i % (count / 8).max(1) == 0 {
                self.state.blocked.add(&corners[0], &corners[1]);
            }
        }
        self.state.job = Job::Read(last);
        if last == count {
            let likely = self.state.segments.as_ref().map(Segments::directions);
            self.state.likely.extend(likely.into_iter().flatten());
            self.state.job = Job::Explore;
        }
        (last - next) as u64 * (WORK_PER_NEW_PAIR + 600)
    }

    /// Of all triangles known, the corners that are deepest in the other body for the best push.
    pub(super) fn add_deepest_corners(&mut self) {
        let direction = self.state.direction;
        for of_b in [false, true] {
            if self.state.inner[usize::from(!of_b)] == 0.0 {
                continue;
            }
            let toward = if of_b { -direction } else { direction };
            let depth = |pair: &Pair| {
                let [p, q, r] = pair.corners[usize::from(of_b)].map(|corner| corner.dot(toward));
                p.max(q).max(r)
            };
            let pairs = self.state.pairs.iter();
            let deepest = pairs.max_by(|x, y| depth(x).total_cmp(&depth(y)));
            if let Some(corners) = deepest.map(|pair| pair.corners[usize::from(of_b)]) {
                self.state.add_point(of_b, &corners, direction);
            }
        }
    }

    /// The corners of the first components, in case the bodies do not touch.
    pub(super) fn add_sample_points(&mut self) {
        for of_b in [false, true] {
            let tree = if of_b { self.asked.b } else { self.asked.a };
            let components = tree
                .solid()
                .map_or(&[][..], |solidity| solidity.components());
            for component in components.iter().take(4) {
                let corners = tree.mesh().triangle(component.first_triangle as usize);
                let corners = if of_b {
                    corners.map(|p| self.asked.b_in_a.transform_point(p))
                } else {
                    corners
                };
                self.state.add_point(of_b, &corners, DVec3::X);
            }
        }
    }

    /// What follows a direction.
    pub(super) fn next_job(&self) -> Job {
        if self.state.number > 0 {
            Job::Pick
        } else {
            Job::Explore
        }
    }

    /// Begins with the next of the likely directions.
    pub(super) fn explore(&mut self) -> u64 {
        let Some(&direction) = self.state.likely.get(self.state.explored) else {
            self.add_deepest_corners();
            self.state.job = Job::About(0);
            return PAIRS as u64 * 4;
        };
        self.state.explored += 1;
        let longest = 1.001 * self.parting_length(direction) + 64.0 * self.state.rounding;
        let known = self.state.high < f64::INFINITY;
        let (low, work) = self.state.blocked.free_from(direction, 0.0, f64::INFINITY);
        let length = if known {
            self.state.high * SHORTER
        } else {
            let guess = self
                .state
                .segments
                .as_ref()
                .map_or(0.0, |s| s.extent(direction));
            (1.1 * low).max(guess.min(3.0 * low)).max(1e-3 * longest)
        };
        self.state.job = if known && low >= length {
            Job::Explore
        } else {
            Job::Lengthen {
                direction,
                length: length.min(longest),
                longest,
            }
        };
        work + 64
    }

    pub(super) fn lengthened(&mut self, direction: DVec3, length: f64, longest: f64, heard: Heard) {
        let Heard::Blocked(pair) = heard else {
            self.state.separates(direction, length);
            let low = self.state.blocked.free_from(direction, 0.0, length).0;
            self.state.job = Job::Shorten {
                direction,
                low,
                high: length,
            };
            return;
        };
        pair.inspect(|&pair| self.learn(pair, direction));
        let low = self
            .state
            .blocked
            .free_from(direction, length, f64::INFINITY)
            .0;
        self.state.job = if self.state.high < f64::INFINITY || length >= longest {
            Job::Explore
        } else {
            Job::Lengthen {
                direction,
                length: (GROWTH * length).max(1.05 * low).min(longest),
                longest,
            }
        };
    }

    /// Length of a push after which the boxes are apart, up to rounding.
    pub(super) fn parting_length(&self, direction: DVec3) -> f64 {
        let a = self.asked.a.mesh().aabb();
        let b = self.asked.b.aabb_at(&self.asked.b_in_a);
        let forward = direction.cmpgt(DVec3::ZERO);
        let farthest = DVec3::select(forward, a.max - b.min, a.min - b.max);
        farthest.dot(direction).max(0.0)
    }
}
