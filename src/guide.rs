//! Guides and figures: the pages of `docs` in the repository. Their programs are compiled and run
//! as tests.

/// Makes a module of a page. The first definition of a link wins: these lead to modules, those at
/// the end of the page lead to files of the repository.
macro_rules! page {
    ($name:ident, $path:literal) => {
        /// [benchmarking]: crate::guide::benchmarking
        /// [benchmarks]: crate::guide::benchmarks
        /// [contacts]: crate::guide::contacts
        /// [error-against-work]: crate::guide::benchmarks#error-against-work
        /// [frame-within-a-budget]: crate::guide::benchmarks#a-frame-within-a-budget
        /// [games]: crate::guide::games
        /// [guarantees]: crate::guide::guarantees
        /// [lateness]: crate::guide::real_time#measured
        /// [memory-needed]: crate::guide::real_time#memory-needed
        /// [model]: crate::guide::model
        /// [performance]: crate::guide::performance
        /// [real-time]: crate::guide::real_time
        /// [robots]: crate::guide::robots
        /// [scene-guaranteed]: crate::guide::scenes#what-is-guaranteed
        /// [scene-threads]: crate::guide::scenes#threads
        /// [scenes]: crate::guide::scenes
        #[doc = include_str!(concat!("../docs/", $path))]
        pub mod $name {}
    };
}

page!(guarantees, "guide/guarantees.md");
page!(games, "guide/games.md");
page!(controllers, "guide/controllers.md");
page!(robots, "guide/robots.md");
page!(motion, "guide/motion.md");
page!(contacts, "guide/contacts.md");
page!(rays, "guide/rays.md");
page!(solids, "guide/solids.md");
page!(clouds, "guide/clouds.md");
page!(shapes, "guide/shapes.md");
page!(push_out, "guide/push_out.md");
page!(scenes, "scene.md");
page!(performance, "performance.md");
page!(real_time, "real-time.md");
page!(model, "model.md");
page!(benchmarks, "benchmarks.md");
page!(benchmarking, "guide/benchmarking.md");
