//! Contacts that begin, persist and end.
//!
//! Merges the contacts of the last frame with the pairs of this one, both ascending. If a frame
//! leaves a pair undecided, its contact keeps the last proven state.

use super::Scene;
use super::body::Bodies;
use super::broad::Broad;
use super::id::BodyId;
use super::report::{BodyContact, ContactPhase, PairReport, Report};
use super::room::reserve;
use alloc::vec::Vec;
use core::mem;
use punctual::Verdict;

/// The state of contact tracking.
#[derive(Debug, Default)]
pub(super) struct Events {
    /// True if contacts are tracked.
    on: bool,
    /// The contacts of the last frame.
    last: Vec<BodyContact>,
}

impl Scene {
    /// From the next frame on, [`Report::contacts`] reports which pairs of bodies begin to touch,
    /// still touch, and separate.
    ///
    /// Adds to a frame time linear in the listed pairs and the contacts, within its budget of time,
    /// and no work. Off by default.
    ///
    /// ```
    /// use punctual::glam::DMat3;
    /// use punctual::{Budget, Pose, Tree, shapes};
    /// use punctual_scene::{Body, ContactPhase, Scene};
    /// use std::sync::Arc;
    ///
    /// let ball = Arc::new(Tree::new(shapes::icosphere(2)));
    /// let mut scene = Scene::new();
    /// scene.track_contacts();
    /// scene.insert(Body::fixed(Arc::clone(&ball), Pose::IDENTITY))?;
    /// let id = scene.insert(Body::moving(ball, Pose::IDENTITY))?;
    /// let mut phases = Vec::new();
    /// for place in [2.5, 1.9, 1.8, 2.5] {
    ///     scene.set_pose(id, Pose::new(DMat3::IDENTITY, [place, 0.0, 0.0])?)?;
    ///     phases.extend(scene.detect(Budget::unlimited()).contacts.iter().map(|contact| (contact.phase, contact.age)));
    /// }
    /// assert_eq!(phases, [(ContactPhase::Began, 0), (ContactPhase::Persists, 1), (ContactPhase::Ended, 2)]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn track_contacts(&mut self) {
        (self.events.on, self.is_same) = (true, false);
        self.events.reserve(self.pairs.room(), &mut self.report);
        record!(self, TrackContacts);
    }
}

impl Events {
    /// If contacts are tracked, reserves room for the contacts of this many pairs, and for as many
    /// that end.
    pub fn reserve(&mut self, pairs: usize, report: &mut Report) {
        if self.on {
            reserve(&mut report.contacts, 2 * pairs);
            reserve(&mut self.last, 2 * pairs);
        }
    }

    /// Number of known contacts; the time to report them grows with it.
    pub fn len(&self) -> usize {
        self.last.len()
    }

    pub fn report(&mut self, bodies: &Bodies, broad: &Broad, report: &mut Report) {
        if !self.on {
            return;
        }
        mem::swap(&mut self.last, &mut report.contacts);
        report.contacts.clear();
        let all_listed = report.unlisted == 0;
        let unlisted = |contact| unlisted_phase(contact, bodies, broad, all_listed);
        let Report {
            pairs, contacts, ..
        } = report;
        let mut last = self
            .last
            .iter()
            .filter(|contact| contact.phase != ContactPhase::Ended)
            .peekable();
        for pair in &*pairs {
            let at = key([pair.a, pair.b]);
            while let Some(contact) = last.next_if(|contact| key([contact.a, contact.b]) < at) {
                contacts.push(older(contact, unlisted(contact)));
            }
            let before = last.next_if(|contact| key([contact.a, contact.b]) == at);
            contacts.extend(listed(pair, before));
        }
        contacts.extend(last.map(|contact| older(contact, unlisted(contact))));
    }
}

/// Contacts and pairs are in this order: by index, that of a removed body first.
fn key([a, b]: [BodyId; 2]) -> [u32; 4] {
    [a.index, b.index, a.generation, b.generation]
}

/// A contact one frame later.
fn older(contact: &BodyContact, phase: ContactPhase) -> BodyContact {
    BodyContact {
        phase,
        age: contact.age + 1,
        ..*contact
    }
}

/// The contact of a pair that is in the report; `None` if it has none.
fn listed(pair: &PairReport, before: Option<&BodyContact>) -> Option<BodyContact> {
    let phase = match pair.verdict {
        Verdict::Intersecting { .. } | Verdict::Within { .. } | Verdict::Contained { .. } => {
            ContactPhase::Persists
        }
        Verdict::Separated => ContactPhase::Ended,
        Verdict::Undecided => ContactPhase::Undecided,
    };
    let began = || BodyContact {
        a: pair.a,
        b: pair.b,
        phase: ContactPhase::Began,
        age: 0,
    };
    match before {
        Some(contact) => Some(older(contact, phase)),
        None => (phase == ContactPhase::Persists).then(began),
    }
}

/// The state of a contact whose pair is not in the report. `all_listed`: all other known pairs are
/// in the report.
fn unlisted_phase(
    contact: &BodyContact,
    bodies: &Bodies,
    broad: &Broad,
    all_listed: bool,
) -> ContactPhase {
    let pair = [contact.a, contact.b];
    let is_there = |id: BodyId| bodies.get(id).is_ok();
    if !pair.into_iter().all(is_there) {
        return ContactPhase::Ended;
    }
    let [a, b] = pair.map(|id| bodies.facts(id.index));
    // Boxes prove a separation only if they are up to date.
    let are_placed = !a.is_changed() && !b.is_changed();
    let are_apart = are_placed && !bodies.overlap([contact.a.index, contact.b.index]);
    // Two fixed bodies are not compared once their distance is no longer measured.
    let are_passed_by =
        all_listed && are_placed && pair.into_iter().all(|id| broad.is_closed(id.index));
    if are_apart || are_passed_by || !bodies.may_meet([contact.a.index, contact.b.index]) {
        ContactPhase::Ended
    } else {
        ContactPhase::Undecided
    }
}
