//! Contact points of two bodies: the representatives of their contacts, kept from frame to frame.

use super::spent::Spent;
use crate::ask::contacts::ContactPoint;
use crate::body::Placed;
use crate::cost::{WORK_PER_PATCHED_CONTACT, WORK_PER_TOUCH};
use crate::room::{Room, reserve};
use alloc::boxed::Box;
use alloc::vec::Vec;
use arrayvec::ArrayVec;
use punctual::Workspace;
use punctual::clock::ManualClock;
use punctual::contacts::{Contact, Patch, Patches};
use punctual::engine::Deadline;
use punctual::engine::PatchMemory;
use punctual_geom::Pose;

/// Maximum number of contacts of a pair that are found, and of points that are kept.
pub(crate) const MOST_CONTACTS: usize = 256;
pub(crate) const MOST_POINTS: usize = 16;

/// The contact points of a pair.
#[derive(Clone, Debug)]
pub(crate) struct Touch {
    pub points: ArrayVec<ContactPoint, MOST_POINTS>,
    /// Lower bound of the distance of contacts that no point represents.
    pub low: f64,
    /// The frame of the proof; 0 if there is none.
    pub since: u64,
    /// The last frame that finished the question.
    pub completed: u64,
    /// Work of the last finished run; 0 if there was none.
    pub cost: u64,
    /// Work of forming patches for which there was no room at the end; 0 if there was room.
    pub left_out: u64,
    /// Work of the unfinished run.
    pub pending: Spent,
    memory: PatchMemory,
}

impl Touch {
    pub fn new() -> Box<Self> {
        let mut memory = PatchMemory::default();
        memory.reserve(MOST_CONTACTS);
        let (points, pending) = (ArrayVec::new(), Spent::default());
        Box::new(Self {
            points,
            low: 0.0,
            since: 0,
            completed: 0,
            cost: 0,
            left_out: 0,
            pending,
            memory,
        })
    }

    /// Buffers for the patches of a pair.
    pub fn patches() -> Box<Patches> {
        let mut patches = Patches::new();
        patches.reserve(MOST_CONTACTS);
        Box::new(patches)
    }

    pub fn clear(&mut self) {
        self.separate(0);
        (self.low, self.completed, self.cost, self.left_out) = (0.0, 0, 0, 0);
        self.pending = Spent::default();
    }

    /// Records that the bodies are separated in `frame`. Later contacts get new ids.
    pub fn separate(&mut self, frame: u64) {
        self.points.clear();
        self.memory.forget();
        (self.low, self.since) = (f64::INFINITY, frame);
    }

    /// Stores the nearest contacts of two bodies, as many as there is room to form patches of.
    /// Contacts not found are at least `low` away. Returns the number of contacts in patches.
    pub fn update(
        &mut self,
        [a, b]: [&Placed; 2],
        workspace: &Workspace,
        low: f64,
        patches: &mut Patches,
        room: u64,
    ) -> usize {
        let contacts = workspace.contacts();
        let count = contacts
            .len()
            .min((room / WORK_PER_PATCHED_CONTACT) as usize);
        let next = contacts
            .clone()
            .nth(count)
            .map_or(f64::INFINITY, |contact| contact.distance);
        self.low = low.min(next);
        patches.swap_memory(&mut self.memory);
        patches.update(&a.body.tree, &b.body.tree, contacts.take(count));
        patches.swap_memory(&mut self.memory);
        self.points.clear();
        for patch in patches.as_slice() {
            let left = self.points.remaining_capacity();
            if left == 0 {
                self.low = self.low.min(patch.distance);
            }
            let point = |contact: &Contact| in_scene(contact, patch, &a.body.pose);
            self.points
                .extend(patches.points_of(patch).take(left).map(point));
        }
        count
    }
}

/// Preallocated contact states for pairs.
#[derive(Debug, Default)]
pub(crate) struct Touches {
    #[allow(clippy::vec_box, reason = "they move in and out by their pointers")]
    free: Vec<Box<Touch>>,
    lent: usize,
    /// Number of pairs with room for contacts, and the number already made, which was paid for.
    room: Room,
    made: usize,
    /// The first patch id of pairs that get a state. It is above all ids of states that were
    /// returned before this frame. So ids do not depend on which pair gets which state, which in
    /// turn depends on the threads.
    next_id: u64,
    highest_id: u64,
}

impl Touches {
    /// True if pairs may have contact states.
    pub fn any(&self) -> bool {
        self.room.pairs > 0
    }

    /// Makes room for the contacts of at least this many pairs.
    pub fn ask(&mut self, pairs: usize) {
        self.room.ask(pairs.max(1));
        self.fill(&mut Deadline::at(None, u64::MAX, &ManualClock::new()));
    }

    /// Makes room for more pairs than are in use or soon will be.
    pub fn grow(&mut self, touching: usize, young: bool, deadline: &mut Deadline) {
        self.next_id = self.highest_id;
        if self.any() {
            self.room.grow(self.lent.max(touching), young);
            self.fill(deadline);
        }
    }

    fn fill(&mut self, deadline: &mut Deadline) {
        reserve(&mut self.free, self.room.pairs);
        while self.made < self.room.pairs && deadline.has_room(WORK_PER_TOUCH) {
            deadline.spend(WORK_PER_TOUCH);
            self.made += 1;
            // Some may have been made on demand.
            if self.free.len() + self.lent < self.made {
                self.free.push(Touch::new());
            }
        }
    }

    pub fn lend(&mut self) -> Box<Touch> {
        self.lent += 1;
        let mut touch = self.free.pop().unwrap_or_else(Touch::new);
        touch.memory.begin_at(self.next_id);
        touch
    }

    pub fn take_back(&mut self, mut touch: Box<Touch>) {
        self.highest_id = self.highest_id.max(touch.memory.next());
        touch.clear();
        self.lent -= 1;
        self.free.push(touch);
    }
}

/// A contact, mapped from the frame of a body to the scene.
fn in_scene(contact: &Contact, patch: &Patch, pose: &Pose) -> ContactPoint {
    let Contact {
        triangles,
        points,
        normal,
        distance,
        ..
    } = *contact;
    let (points, normal) = (
        points.map(|point| pose.transform_point(point)),
        *pose.rotation() * normal,
    );
    ContactPoint {
        patch: patch.id,
        triangles,
        points,
        normal,
        distance,
    }
}
