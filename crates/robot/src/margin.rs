//! Margins: how far apart the shapes of a pair must be to count as free.

use std::collections::BTreeMap;

use crate::model::{LARGEST, PlacedShape};
use crate::{Checker, Model, RobotError};

/// The pairs that a margin is for. Names are those of links and obstacles; a link stands for all
/// its shapes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Margin<N> {
    /// All pairs.
    All,
    /// Each pair of a link or an obstacle, in addition to [`Margin::All`].
    Of(N),
    /// Each pair of this link, or of what is attached to one, and an obstacle in the world, in
    /// addition to the others: the padding of MoveIt, which does not count within the robot.
    Padding(N),
    /// Each pair of these two links or obstacles, in place of all other margins.
    Pair(N, N),
}

impl<'n> Margin<&'n str> {
    fn names(self) -> impl Iterator<Item = &'n str> {
        let names = match self {
            Self::All => [None, None],
            Self::Of(name) | Self::Padding(name) => [Some(name), None],
            Self::Pair(a, b) => [Some(a), Some(b)],
        };
        names.into_iter().flatten()
    }

    fn owned(self) -> Margin<String> {
        match self {
            Self::All => Margin::All,
            Self::Of(name) => Margin::Of(name.into()),
            Self::Padding(name) => Margin::Padding(name.into()),
            // Either order names the same pair.
            Self::Pair(a, b) => Margin::Pair(a.min(b).into(), a.max(b).into()),
        }
    }
}

/// All margins that were set, in metres.
#[derive(Clone, Debug, Default)]
pub(crate) struct Margins(BTreeMap<Margin<String>, f64>);

impl Margins {
    /// The margins that a shape adds to each of its pairs, and to those with obstacles.
    pub fn of(&self, model: &Model, shape: &PlacedShape) -> [f64; 2] {
        let (mut all, mut padding) = (0.0, 0.0);
        for (margin, metres) in &self.0 {
            match margin {
                Margin::Of(name) if model.is_named(shape, name) => all += metres,
                Margin::Padding(name) if model.is_named(shape, name) => padding += metres,
                _ => {}
            }
        }
        [all, padding]
    }

    /// The margin of a pair.
    pub fn of_pair(&self, model: &Model, [a, b]: [&PlacedShape; 2]) -> f64 {
        let pairs = self.0.iter().rev();
        let is = |shape, name: &str| model.is_named(shape, name);
        let own = pairs.map_while(|(margin, metres)| match margin {
            Margin::Pair(x, y) => Some((is(a, x) && is(b, y) || is(a, y) && is(b, x), *metres)),
            _ => None,
        });
        if let Some((_, metres)) = own.into_iter().find(|own| own.0) {
            return metres;
        }
        let padding = |x: &PlacedShape, y: &PlacedShape| {
            let body = model.bodies.get(y.body as usize);
            let is_attached = body.is_some_and(|body| !body.chain.is_empty());
            let is_padded = y.link.is_none() && !is_attached;
            if is_padded { x.margins[1] } else { 0.0 }
        };
        let all = self.0.get(&Margin::All).copied().unwrap_or(0.0);
        all + (a.margins[0] + b.margins[0]) + (padding(a, b) + padding(b, a))
    }
}

impl Checker {
    /// Sets how far apart shapes must be, in metres: 0 at first. Shapes that are no farther apart
    /// than their margin count as in contact, in all answers: labels, edges, paths and horizons. A
    /// clearance is the distance above the margin. Obstacles that are added later follow the
    /// margins set for their names. Lists no pair anew; complexity: a pass over all pairs.
    ///
    /// ```
    /// # use punctual_robot::{Checker, Margin, RobotError};
    /// # fn set(checker: &mut Checker) -> Result<(), RobotError> {
    /// checker.set_margin(Margin::All, 0.01)?;
    /// checker.set_margin(Margin::Of("hand"), 0.005)?;
    /// checker.set_margin(Margin::Pair("hand", "table"), 0.0)?;
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`RobotError::Model`] if there is no link or obstacle of a name, or the margin is negative,
    /// NaN or larger than [`LARGEST`]. Nothing is changed then.
    pub fn set_margin(&mut self, of: Margin<&str>, metres: f64) -> Result<(), RobotError> {
        let world = &mut self.world;
        let fail = |what: String| Err(RobotError::Model(format!("margin: {what}")));
        if let Some(name) = of.names().find(|name| !world.knows(name)) {
            return fail(format!("there is no link or obstacle {name}"));
        }
        if !(0.0..=LARGEST).contains(&metres) {
            return fail(format!(
                "{metres} m for {of:?}, allowed is 0 to {LARGEST:e}"
            ));
        }
        world.margins.0.insert(of.owned(), metres);
        world.measure_margins();
        self.room.begin();
        Ok(())
    }
}
