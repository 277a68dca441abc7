//! Loading a tree against building it: `cargo bench -p punctual-benches --bench tree_file`. One thread; the least of interleaved repetitions.

use std::hint::black_box;
use std::time::Instant;

use punctual::glam::DVec3;
use punctual::{Mesh, Tree, shapes};

fn milliseconds(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    1e3 * start.elapsed().as_secs_f64()
}

fn measure(name: &str, mesh: &Mesh) {
    let tree = Tree::new(mesh.clone());
    let bytes = tree.to_bytes();
    let mut least = [f64::INFINITY; 3];
    for _ in 0..15 {
        let again = mesh.clone();
        let times = [
            milliseconds(|| _ = black_box(Tree::new(again))),
            milliseconds(|| _ = black_box(tree.to_bytes())),
            milliseconds(|| _ = black_box(Tree::from_bytes(&bytes)).expect("it was just written")),
        ];
        for (least, time) in least.iter_mut().zip(times) {
            *least = least.min(time);
        }
    }
    let [build, save, load] = least;
    let per_triangle = |bytes: usize| bytes as f64 / mesh.len() as f64;
    println!(
        "{name:<20} {:>9} {build:>8.2} {save:>8.2} {load:>8.2} {:>11.2} {:>12.1} {:>14.1}",
        mesh.len(),
        build / load,
        per_triangle(bytes.len()),
        per_triangle(tree.stats().bytes()),
    );
}

fn main() {
    println!(
        "mesh                 triangles build ms  save ms  load ms  build/load  B/triangle  B/tr. in memory"
    );
    measure("icosphere(6)", &shapes::icosphere(6));
    measure("torus_knot(256)", &shapes::torus_knot(2, 3, 0.2, 256));
    measure("gear(64, 24)", &shapes::gear(64, 24));
    measure("height_field(256)", &shapes::height_field(256, 7));
    let sphere = shapes::icosphere(6);
    let stretched =
        (0..sphere.vertex_count()).map(|i| sphere.vertex(i) * DVec3::new(0.1, 0.3, 0.7));
    let wide = Mesh::from_f64(stretched, sphere.triangles().iter().copied()).expect("finite");
    measure("the sphere in f64", &wide);
}
