//! A character walks over hills and slides along walls: a capsule that is moved as far as is proven
//! free, along what is left of its way when the parts into walls and ground are taken out.

#[path = "common/mod.rs"]
mod common;

use std::error::Error;
use std::io::Write;

use punctual::glam::{DMat3, DVec3};
use punctual::{Budget, Motion, Pose, PoseError, Query, Tree, Workspace};

/// The gap that the character keeps, between half and all of this.
const SKIN: f64 = 0.02;

/// Of a frame.
const STEP: f64 = 0.08;

struct Walker<'l> {
    level: &'l [Tree],
    capsule: Tree,
    at: DVec3,
    workspace: Workspace,
}

fn main() -> Result<(), Box<dyn Error>> {
    common::write(|out| {
        let hill =
            |i: u32| 0.3 * (0.35 * f64::from(i % 61)).sin() * (0.3 * f64::from(i / 61)).cos();
        let field = Tree::height_field((0..61 * 61).map(hill), 61, [0.5; 2])?;
        // A wall askew across the way, and a pillar behind its end.
        let block = |[a, b, c, d]: [[f64; 2]; 4]| {
            let ends = [-1.0, 4.0].map(|z| [a, b, c, d].map(|[x, y]| [x, y, z]));
            Tree::hull(ends.into_iter().flatten())
        };
        let wall = block([[10.0, 8.0], [18.0, 16.0], [17.5, 16.5], [9.5, 8.5]])?;
        let pillar = block([[18.0, 14.0], [19.0, 15.0], [18.0, 16.0], [17.0, 15.0]])?;
        let level = [field, wall, pillar];
        let mut walker = Walker {
            level: &level,
            capsule: Tree::capsule(0.3, 1.0)?,
            at: DVec3::new(3.0, 12.0, 3.0),
            workspace: Workspace::new(),
        };
        while walker.advance(DVec3::Z * -STEP)? == 1.0 {}
        // East to the wall and along it, slowly around its end, along the pillar, and away.
        for (name, way, frames) in [
            ("east", DVec3::X, 200),
            ("south-east", DVec3::new(0.8, -0.6, 0.0), 240),
            ("north-east", DVec3::new(0.8, 0.6, 0.0), 120),
        ] {
            let mut least = f64::INFINITY;
            for _ in 0..frames {
                let before = walker.at;
                walker.walk(way * STEP)?;
                assert!(walker.gap()? > 0.0, "never sunk in");
                least = least.min((walker.at - before).truncate().length());
            }
            let (at, gap) = (walker.at, walker.gap()?);
            writeln!(out, "{name}: now at {at:.2}, gap {gap:.3}")?;
            writeln!(
                out,
                "  moved at least {:.0} % of a step in each frame",
                100.0 * least / STEP
            )?;
            assert!(least > 0.05 * STEP, "does not stick");
        }
        Ok(())
    })
}

impl Walker<'_> {
    /// Moves it along the ground and the walls, then down to the ground.
    fn walk(&mut self, step: DVec3) -> Result<(), Box<dyn Error>> {
        let mut left = step;
        for _ in 0..4 {
            let near = self.near()?;
            self.keep_off(&near)?;
            // Takes out what leads towards any surface that is near, until nothing is left of it.
            for _ in 0..16 {
                for (normal, _) in &near {
                    left -= *normal * normal.dot(left).min(0.0);
                }
            }
            let share = self.advance(left)?;
            left *= 1.0 - share;
            if share == 1.0 {
                break;
            }
        }
        self.advance(DVec3::Z * -STEP)?;
        Ok(())
    }

    /// Normals of the surfaces within the skin, away from them, and their distances.
    fn near(&mut self) -> Result<Vec<(DVec3, f64)>, PoseError> {
        let (pose, mut near) = (self.pose()?, Vec::new());
        for tree in self.level {
            let query = Query::contacts(tree, &self.capsule, pose).margin(SKIN);
            let _ = query.run(&mut self.workspace, Budget::unlimited());
            let contacts = self.workspace.contacts();
            near.extend(contacts.map(|contact| (-contact.normal, contact.distance)));
        }
        Ok(near)
    }

    /// Moves it away from what is nearer than the skin.
    fn keep_off(&mut self, near: &[(DVec3, f64)]) -> Result<(), Box<dyn Error>> {
        let mut push = DVec3::ZERO;
        for _ in 0..16 {
            for (normal, distance) in near {
                push += *normal * (0.9 * SKIN - distance - normal.dot(push)).max(0.0);
            }
        }
        let free = self.free(push, 0.0)?;
        self.at += push * if free < 1.0 { 0.5 * free } else { 1.0 };
        Ok(())
    }

    /// Moves it as far as it keeps half the skin. Returns the share of the step that it moved.
    fn advance(&mut self, step: DVec3) -> Result<f64, Box<dyn Error>> {
        let free = self.free(step, 0.5 * SKIN)?;
        self.at += step * free;
        Ok(free)
    }

    /// The share of a step that is proven to keep the margin.
    fn free(&mut self, step: DVec3, margin: f64) -> Result<f64, Box<dyn Error>> {
        let motion = Motion::straight(self.pose()?, step)?;
        let mut free = 1.0_f64;
        for tree in self.level {
            let query = Query::impact(tree, &self.capsule, motion).margins([margin, 0.0]);
            let query = query.tolerance(0.01 * SKIN);
            let found = query.run(&mut self.workspace, Budget::unlimited());
            free = free.min(found.value.lower);
        }
        Ok(free)
    }

    /// Proven lower bound of its distance from everything.
    fn gap(&mut self) -> Result<f64, PoseError> {
        let (pose, mut gap) = (self.pose()?, f64::INFINITY);
        for tree in self.level {
            let query = Query::distance(tree, &self.capsule, pose);
            let found = query.run(&mut self.workspace, Budget::unlimited());
            gap = gap.min(found.value.low);
        }
        Ok(gap)
    }

    fn pose(&self) -> Result<Pose, PoseError> {
        Pose::new(DMat3::IDENTITY, self.at)
    }
}
