//! Probabilities that are corrected by what came true.

use crate::handle::{change, get};
use crate::scene::punctual_scene;
use crate::sized::{place, read};
use crate::status::{Fault, given};
use crate::verbs::{calls, inits, types};
use core::mem::MaybeUninit;
use punctual::prediction::Calibration;

types! {
    /// A correction of the probabilities that estimates tell, learned on the caller's own work: one
    /// for each pair of parts whose queries are stopped, or for a scene, which learns by itself.
    /// Plain data: to go on with it another day, store its numbers.
    #[derive(PartialEq)]
    asked punctual_calibration(evidence) from (learned: Calibration) {
        /// What is added to the logit of a probability, -8 to 8; 0 at first.
        offset: f64 = learned.to_array()[0],
        /// What the logit is multiplied with before, 1/8 to 8; 1 at first.
        slope: f64 = learned.to_array()[1],
        /// What both go by: sums over the moments learned.
        evidence: [f64; 3] = {
            let [_, _, evidence @ ..] = learned.to_array();
            evidence
        },
    }
}

impl Default for punctual_calibration {
    fn default() -> Self {
        Calibration::default().into()
    }
}

impl punctual_calibration {
    fn check(self) -> Result<Calibration, Fault> {
        let [one, both, square] = self.evidence;
        Calibration::from_array([self.offset, self.slope, one, both, square])
            .ok_or(Fault::Calibration)
    }
}

inits! {
    /// One that knows nothing and changes nothing.
    punctual_calibration_init(calibration: punctual_calibration) {}
}

calls! {
    /// The corrected probability. It rises with the one given, and only 0 and 1 become 0 and 1;
    /// what is beyond counts as these, and NaN as .5.
    ///
    /// Fails with BAD_ARGUMENT if the numbers of the calibration are none that can be learned.
    unsafe fn punctual_calibration_apply(
        calibration: *const punctual_calibration, probability: f64,
        corrected: Option<&mut MaybeUninit<f64>>
    ) {
        let corrected = given(corrected, "corrected")?;
        // SAFETY: the contract of the header for structs.
        corrected.write(unsafe { read(calibration, "calibration") }?.check()?.apply(probability));
        Ok(())
    }

    /// Learns from a moment: the probability that `punctual_query_estimate` told then, before
    /// `punctual_calibration_apply`, and whether the surfaces met at that pose: 0 or not 0. What
    /// was told as certain, or NaN, teaches nothing. Takes about a microsecond.
    ///
    /// Fails as `punctual_calibration_apply`.
    unsafe fn punctual_calibration_learn(
        calibration: *mut punctual_calibration, told: f64, met: u32
    ) {
        // SAFETY: the contract of the header for structs.
        let (before, after) = unsafe {
            (read(calibration.cast_const(), "calibration")?, place(calibration, "calibration")?)
        };
        let mut learned = before.check()?;
        learned.learn(told, met != 0);
        after.write(learned.into());
        Ok(())
    }

    /// What a scene has learned: the probability of a pair whose query was stopped includes it.
    unsafe fn punctual_scene_calibration(
        scene: Option<&punctual_scene>, calibration: *mut punctual_calibration
    ) {
        let scene = get(scene, "scene")?;
        // SAFETY: the contract of the header for structs.
        unsafe { place(calibration, "calibration") }?.write(scene.calibration().into());
        Ok(())
    }

    /// Goes on with what was learned before, by another scene with parts of the same kind, say.
    ///
    /// Fails as `punctual_calibration_apply`.
    unsafe fn punctual_scene_set_calibration(
        scene: Option<&mut punctual_scene>, calibration: *const punctual_calibration
    ) {
        // SAFETY: the contract of the header for structs.
        let calibration = unsafe { read(calibration, "calibration") }?.check()?;
        change(scene, "scene", |scene| {
            scene.set_calibration(calibration);
            Ok(())
        })
    }
}
