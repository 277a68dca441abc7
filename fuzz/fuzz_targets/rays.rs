//! Any few triangles and any rays: a segment hits what the exact triangle test says, nothing is false at any stop, a batch
//! says the same.
#![no_main]

use libfuzzer_sys::arbitrary::{Result, Unstructured};
use libfuzzer_sys::fuzz_target;
use punctual::clock::ManualClock;
use punctual::geom::triangles_intersect;
use punctual::rays::{RayHit, RayMode};
use punctual::{Budget, Mesh, Query, Ray, StopReason, Tree, Workspace};
use punctual_fuzz::Numbers;

fn tree(bytes: &mut Unstructured) -> Result<Option<Tree>> {
    let numbers = Numbers::arbitrary(bytes)?;
    let vertices = (0..bytes.int_in_range(1..=8)?)
        .map(|_| numbers.point(bytes))
        .collect::<Result<Vec<_>>>()?;
    let last = vertices.len() as u32 - 1;
    let mut triangles = Vec::new();
    for _ in 0..bytes.int_in_range(0..=12)? {
        triangles.push([
            bytes.int_in_range(0..=last)?,
            bytes.int_in_range(0..=last)?,
            bytes.int_in_range(0..=last)?,
        ]);
    }
    Ok(Mesh::from_f64(vertices, triangles).ok().map(Tree::new))
}

fn ask(bytes: &mut Unstructured) -> Result<()> {
    let Some(tree) = tree(bytes)? else {
        return Ok(());
    };
    let numbers = Numbers::arbitrary(bytes)?;
    let (from, to) = (numbers.point(bytes)?, numbers.point(bytes)?);
    let Ok(ray) = (if bytes.arbitrary()? {
        Ray::segment(from, to)
    } else {
        Ray::new(from, to)
    }) else {
        return Ok(());
    };
    let (mut workspace, clock) = (Workspace::with_capacity(0, 1), ManualClock::new());
    if bytes.arbitrary()? {
        workspace.use_portable_kernels();
    }
    let query = Query::ray(&tree, ray).mode(RayMode::All);
    let all = query.run(&mut workspace, Budget::unlimited().clock(&clock));
    if all.stop == StopReason::FlushedToZero {
        return Ok(());
    }
    let hits: Vec<RayHit> = workspace.ray_hits().to_vec();
    if ray.is_segment() {
        let segment = [from, to, to].map(punctual::glam::DVec3::from_array);
        for id in 0..tree.mesh().len() {
            let is_hit = hits.iter().any(|hit| hit.triangle == id as u32);
            assert_eq!(
                is_hit,
                triangles_intersect(&tree.mesh().triangle(id), &segment),
                "triangle {id}"
            );
        }
    }
    let nearest = hits
        .iter()
        .copied()
        .min_by(|a, b| a.t.total_cmp(&b.t).then(a.triangle.cmp(&b.triangle)));
    let query = query.mode(RayMode::Nearest);
    let piece = Budget::work(bytes.int_in_range(1..=600)?);
    let mut said = query.run(&mut workspace, piece.clock(&clock));
    while said.stop == StopReason::WorkLimit {
        let told = said.value.hit.map_or(f64::INFINITY, |hit| hit.t);
        assert!(
            hits.iter()
                .all(|hit| hit.t >= said.value.free_until.min(told)),
            "{said:?} {hits:?}"
        );
        said = query
            .resume(&mut workspace, piece.clock(&clock))
            .expect("the workspace holds a stopped run");
    }
    assert_eq!(said.value.hit, nearest);
    let _ = Query::rays(&tree, &[ray, ray]).run(&mut workspace, Budget::unlimited().clock(&clock));
    assert_eq!(workspace.first_hits(), [nearest; 2]);
    Ok(())
}

fuzz_target!(|data: &[u8]| {
    let _ = ask(&mut Unstructured::new(data));
});
