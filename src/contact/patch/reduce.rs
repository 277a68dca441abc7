//! Representative contacts of a patch: the nearest, and those that span most of its area.

use crate::contact::Contact;
use alloc::collections::BinaryHeap;
use alloc::vec::Vec;
use core::cmp::Ordering;
use glam::{DVec2, DVec3};
use smallvec::{SmallVec, smallvec};

/// The buffers of the choice.
#[derive(Clone, Debug, Default)]
pub(super) struct Reduction {
    /// The midpoints of all contacts, projected along the normal. They are relative to the first
    /// one, and scaled so that no square overflows or underflows.
    places: Vec<DVec2>,
    /// The polygon of the chosen contacts, counterclockwise: predecessor and successor of each.
    ring: Vec<[u32; 2]>,
    /// Edges of the polygon with a contact outside. Some of them may have left the polygon since.
    edges: BinaryHeap<Edge>,
    /// Number of edges that have searched for their farthest contact.
    looks: usize,
    hull: Hull,
}

/// An edge of the polygon, and the contact farthest outside of it.
#[derive(Clone, Copy, Debug)]
struct Edge {
    /// Twice the area of the triangle of the edge and the contact.
    gain: f64,
    contact: u32,
    /// Ends of the edge, as indices of the chosen contacts.
    ends: [u32; 2],
}

/// Orders by gain. Of equal gains, that of the earlier contact is greater, so a heap returns it
/// first.
impl Ord for Edge {
    fn cmp(&self, other: &Self) -> Ordering {
        let key = |edge: &Self| (edge.contact, edge.ends);
        self.gain
            .total_cmp(&other.gain)
            .then_with(|| key(other).cmp(&key(self)))
    }
}

impl PartialOrd for Edge {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Edge {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Edge {}

/// Lengths below this fraction of the extent count as rounding, and so do gains below this fraction
/// of its square.
const ROUNDING: f64 = 1e-12;

/// Number of edges that search all contacts. Later edges search the convex hull: a few linear
/// searches cost less than the hull.
const LOOKS: usize = 4;

impl Reduction {
    pub fn reserve(&mut self, contacts: usize) {
        self.places.reserve(contacts);
        self.ring.reserve(LOOKS);
        self.edges.reserve(2 * LOOKS);
    }

    /// Indices of the representatives of these contacts, which must be sorted nearest first: at
    /// least one, at most `limit`.
    ///
    /// They are chosen in the projection along the normal. The first is contact 0, and the second
    /// is the one farthest from it. Each further one has the largest triangle with an edge of the
    /// convex polygon of those chosen before. Of equal ones the first is taken, and none that gains
    /// less than [`ROUNDING`]. `O(n)` for up to four points, `O(n log n)` for any number.
    pub fn points(
        &mut self,
        contacts: &[Contact],
        normal: DVec3,
        limit: usize,
    ) -> SmallVec<[u32; 4]> {
        let mut chosen: SmallVec<[u32; 4]> = smallvec![0];
        if limit == 1 || !self.place(contacts, normal) {
            return chosen;
        }
        let lengths = (0..).zip(self.places.iter().map(|place| place.length()));
        let farthest = lengths.reduce(|best, other| if other.1 > best.1 { other } else { best });
        let Some((second, _)) = farthest.filter(|(_, length)| *length > ROUNDING) else {
            return chosen;
        };
        chosen.push(second);
        self.ring.extend([[1, 1], [0, 0]]);
        self.look([[0, 1], [1, 0]], &chosen);
        while chosen.len() < limit
            && let Some(Edge { contact, ends, .. }) = self.edges.pop()
        {
            if self.ring[ends[0] as usize][1] == ends[1] {
                let new = chosen.len() as u32;
                chosen.push(contact);
                let ends = self.insert(new, ends, &chosen);
                if chosen.len() < limit {
                    self.look([[ends[0], new], [new, ends[1]]], &chosen);
                }
            }
        }
        chosen
    }

    /// Clears the buffers and projects the contacts. Returns false if all are at one point.
    fn place(&mut self, contacts: &[Contact], normal: DVec3) -> bool {
        self.ring.clear();
        self.edges.clear();
        self.places.clear();
        self.hull.clear();
        self.looks = 0;
        let (x, y) = normal.any_orthonormal_pair();
        let middle = |contact: &Contact| 0.5 * contact.points[0] + 0.5 * contact.points[1];
        let from_first = |contact: &Contact| middle(contact) - middle(&contacts[0]);
        let reach = contacts
            .iter()
            .map(|contact| from_first(contact).abs().max_element())
            .fold(0.0, f64::max);
        let places = contacts.iter().map(|contact| from_first(contact) / reach);
        self.places
            .extend(places.map(|v| DVec2::new(x.dot(v), y.dot(v))));
        reach > 0.0
    }

    /// Queues the new edges that have a contact outside.
    fn look(&mut self, edges: [[u32; 2]; 2], chosen: &[u32]) {
        for ends in edges {
            let [from, to] = ends.map(|i| self.places[chosen[i as usize] as usize]);
            let gain = |place: DVec2| (place - from).perp_dot(to - from);
            self.looks += 1;
            let contact = if self.looks <= LOOKS {
                let gains = (0..).zip(self.places.iter().map(|&place| gain(place)));
                gains
                    .fold(
                        (0, 0.0),
                        |best, other| if other.1 > best.1 { other } else { best },
                    )
                    .0
            } else {
                self.hull.farthest(&self.places, to - from)
            };
            let gain = gain(self.places[contact as usize]);
            if gain > ROUNDING {
                self.edges.push(Edge {
                    gain,
                    contact,
                    ends,
                });
            }
        }
    }

    /// Inserts a chosen contact into the polygon. It replaces an edge, and the adjacent corners
    /// that are no longer corners. Returns its neighbors.
    fn insert(&mut self, new: u32, [mut from, mut to]: [u32; 2], chosen: &[u32]) -> [u32; 2] {
        let place = |i: u32| self.places[chosen[i as usize] as usize];
        let is_outside =
            |from: u32, to: u32| (place(new) - place(from)).perp_dot(place(to) - place(from)) > 0.0;
        loop {
            let [before, _] = self.ring[from as usize];
            if before == to || !is_outside(before, from) {
                break;
            }
            self.ring[from as usize] = [from; 2];
            from = before;
        }
        loop {
            let [_, after] = self.ring[to as usize];
            if after == from || !is_outside(to, after) {
                break;
            }
            self.ring[to as usize] = [to; 2];
            to = after;
        }
        self.ring.push([from, to]);
        self.ring[from as usize][1] = new;
        self.ring[to as usize][0] = new;
        [from, to]
    }
}

/// The convex hull of points: the lower chain from left to right, the upper from right to left.
#[derive(Clone, Debug, Default)]
struct Hull {
    sorted: Vec<u32>,
    chains: [Vec<u32>; 2],
}

impl Hull {
    fn clear(&mut self) {
        self.sorted.clear();
    }

    fn find(&mut self, places: &[DVec2]) {
        let Self { sorted, chains } = self;
        let place = |i: u32| places[i as usize];
        sorted.extend(0..places.len() as u32);
        let order = |p: DVec2, q: DVec2| p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y));
        sorted.sort_unstable_by(|&i, &j| order(place(i), place(j)).then(i.cmp(&j)));
        sorted.dedup_by(|next, kept| place(*next) == place(*kept));
        for chain in chains {
            chain.clear();
            for &i in &*sorted {
                while let [.., j, k] = chain[..]
                    && (place(k) - place(j)).perp_dot(place(i) - place(k)) <= 0.0
                {
                    chain.pop();
                }
                chain.push(i);
            }
            sorted.reverse();
        }
    }

    /// The point farthest to the right of a direction.
    fn farthest(&mut self, places: &[DVec2], direction: DVec2) -> u32 {
        if self.sorted.is_empty() {
            self.find(places);
        }
        let chain = &self.chains[usize::from(direction.x < 0.0)];
        let place = |i: usize| places[chain[i] as usize];
        let (mut first, mut last) = (0, chain.len() - 1);
        while first < last {
            let middle = (first + last) / 2;
            if (place(middle + 1) - place(middle)).perp_dot(direction) > 0.0 {
                first = middle + 1;
            } else {
                last = middle;
            }
        }
        chain[first]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;

    fn at(x: f64, y: f64) -> Contact {
        Contact {
            triangles: [0; 2],
            points: [DVec3::new(x, y, 0.0), DVec3::new(x, y, -0.1)],
            normal: DVec3::Z,
            distance: 0.1,
            segment: None,
        }
    }

    #[test]
    fn the_nearest_and_the_corners_of_a_square() {
        let mut contacts: Vec<_> = (0..49)
            .map(|i| at(f64::from(i % 7), f64::from(i / 7)))
            .collect();
        // The nearest is in the middle.
        contacts.swap(0, 24);
        let mut chosen = Reduction::default().points(&contacts, DVec3::Z, 5);
        assert_eq!(chosen[0], 0);
        chosen.sort_unstable();
        assert_eq!(
            chosen[..],
            [0, 6, 24, 42, 48],
            "index 24 holds what was first: a corner"
        );
        for limit in 1..5 {
            assert_eq!(
                Reduction::default()
                    .points(&contacts, DVec3::Z, limit)
                    .len(),
                limit
            );
        }
    }

    #[test]
    fn a_line_has_two_ends_and_a_point_is_alone() {
        let line: Vec<_> = (0..9)
            .map(|i| at(0.1 * f64::from(i), 0.3 * f64::from(i)))
            .collect();
        assert_eq!(Reduction::default().points(&line, DVec3::Z, 4)[..], [0, 8]);
        assert_eq!(
            Reduction::default().points(&[at(1.0, 2.0); 3], DVec3::Z, 4)[..],
            [0]
        );
    }

    /// Searches all contacts and all edges of the polygon in every step.
    fn naive(places: &[DVec2], limit: usize) -> Vec<u32> {
        let place = |i: u32| places[i as usize];
        let gain = |i: u32, [from, to]: [u32; 2]| {
            (place(i) - place(from)).perp_dot(place(to) - place(from))
        };
        let best =
            |best: (u32, f64), other: (u32, f64)| if other.1 > best.1 { other } else { best };
        let all = 0..places.len() as u32;
        let mut chosen = Vec::from([
            0,
            all.clone()
                .map(|i| (i, place(i).length()))
                .fold((0, 0.0), best)
                .0,
        ]);
        while chosen.len() < limit {
            let pairs = chosen
                .iter()
                .flat_map(|&i| chosen.iter().map(move |&j| [i, j]));
            let is_edge = |&[from, to]: &[u32; 2]| {
                from != to && chosen.iter().all(|&k| gain(k, [from, to]) < 1e-13)
            };
            let edges: Vec<_> = pairs.filter(is_edge).collect();
            let most = |i| edges.iter().map(|&edge| gain(i, edge)).fold(0.0, f64::max);
            let (next, gain) = all.clone().map(|i| (i, most(i))).fold((0, 0.0), best);
            if gain < 1e-10 {
                break;
            }
            chosen.push(next);
        }
        chosen
    }

    #[test]
    fn the_largest_triangle_each_time_for_any_limit() {
        let mut state = 1_u64;
        let mut random = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f64 / (1 << 23) as f64 - 1.0
        };
        let mut longest = 0;
        for trial in 0..60 {
            // Points in a square, on a circle, and on a narrow ellipse.
            let place = |_| match (trial % 3, random(), random()) {
                (0, x, y) => DVec2::new(x, y),
                (kind, angle, depth) => {
                    let (sin, cos) = (core::f64::consts::PI * angle).sin_cos();
                    (1.0 - 0.03 * depth * depth)
                        * DVec2::new(cos, if kind == 1 { sin } else { 0.01 * sin })
                }
            };
            let mut places: Vec<DVec2> = (0..60).map(place).collect();
            let first = places[0];
            places.iter_mut().for_each(|place| *place -= first);
            let contacts: Vec<_> = places.iter().map(|place| at(place.x, place.y)).collect();
            let mut reduction = Reduction::default();
            let all = reduction.points(&contacts, DVec3::Z, usize::MAX);
            assert_eq!(
                all[..],
                naive(&reduction.places, usize::MAX),
                "trial {trial}"
            );
            for limit in 1..all.len() {
                assert_eq!(
                    reduction.points(&contacts, DVec3::Z, limit)[..],
                    all[..limit]
                );
            }
            longest = longest.max(all.len());
        }
        assert!(longest > 30, "{longest} points at most");
    }
}
