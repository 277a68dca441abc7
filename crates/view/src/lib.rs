//! Pages that show what a query of [`punctual`] knows: both meshes, what was found after each of a ladder of budgets of work,
//! and the boxes that had not been looked at by then.
//!
//! A page is one HTML file with a small program of its own; it needs no other file and no network. The query is run anew for
//! it, from budget to budget, which changes no answer.
//!
//! ```
//! use punctual::{Budget, Mode, Pose, Query, Tree, Workspace, shapes};
//! use punctual_view::Bodies;
//!
//! let (a, b) = (Tree::new(shapes::torus(1.0, 0.4, 16)), Tree::new(shapes::icosphere(2)));
//! let query = Query::all_pairs(&a, &b, Pose::IDENTITY);
//! let outcome = query.run(&mut Workspace::new(), Budget::work(500));
//! let bodies = Bodies::new(["ring".into(), "ball".into()], [&a, &b]);
//! let page = punctual_view::pair(&bodies, query, &Pose::IDENTITY, Mode::All, &outcome)?.html()?;
//! assert!(page.contains("Where two meshes meet: ring and ball"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![deny(missing_docs, unsafe_code)]

mod arrays;
mod contacts;
mod distance;
mod document;
mod ladder;
mod motion;
mod page;
mod pair;
mod robot;
mod round;
mod scene;
mod stage;
mod up;

pub use contacts::contacts;
pub use distance::distance;
pub use document::{document, escape};
pub use motion::motion;
pub use page::View;
pub use pair::pair;
pub use robot::{Obstacle, robot};
pub use scene::{Frame, Known, Shown, scene, stride};
pub use stage::{Fact, count, fact};
pub use up::Up;

use punctual::Tree;

/// Two trees, and what their meshes are called.
pub struct Bodies<'t> {
    names: [String; 2],
    trees: [&'t Tree; 2],
}

impl<'t> Bodies<'t> {
    /// A and B.
    pub fn new(names: [String; 2], trees: [&'t Tree; 2]) -> Self {
        Self { names, trees }
    }

    /// A and B.
    pub fn trees(&self) -> [&'t Tree; 2] {
        self.trees
    }

    fn title(&self, what: &str) -> String {
        format!("{what}: {} and {}", self.names[0], self.names[1])
    }

    /// Their lines of the key.
    fn key(&self) -> [(&'static str, String); 2] {
        let [a, b] = self.names.clone();
        [("a", format!("A: {a}")), ("b", format!("B: {b}"))]
    }
}
