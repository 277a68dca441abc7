use punctual::glam::{DMat3, DVec3};
use punctual::tree::Solid;
use punctual::{Budget, BuildOptions, Mesh, Pose, Tree};
use punctual_depenetrate::{PenetrationQuery, PenetrationWorkspace};
#[test]
fn bench() {
    let text = std::fs::read_to_string("/tmp/epa/pairs.txt").unwrap();
    let mut it = text.split_ascii_whitespace().map(|w| w.parse::<f64>().unwrap());
    let mut out = String::new();
    let mut ws = PenetrationWorkspace::new();
    while let Some(na) = it.next() {
        let mut n = || it.next().unwrap();
        let (na, fa, nb, fb) = (na as usize, n() as usize, n() as usize, n() as usize);
        let mut mesh = |v: usize, f: usize| {
            let p: Vec<DVec3> = (0..v).map(|_| DVec3::new(n(), n(), n())).collect();
            let t: Vec<[u32; 3]> = (0..f).map(|_| [n() as u32, n() as u32, n() as u32]).collect();
            Tree::with_options(Mesh::from_f64(p, t).unwrap(), &BuildOptions::default().solid(Solid::Keep))
        };
        let (a, b) = (mesh(na, fa), mesh(nb, fb));
        for t in [&a, &b] { let s = t.solid().unwrap(); for (c, x) in s.components().iter().zip(s.convex()) { if x.is_none() { println!("NOT {c:?} verts {}", t.mesh().vertex_count()); } else if s.components().len() > 1 { println!("MULTI"); } } }
        let r: Vec<f64> = (0..9).map(|_| n()).collect();
        let t = DVec3::new(n(), n(), n());
        let rot = DMat3::from_cols_array(&[r[0], r[3], r[6], r[1], r[4], r[7], r[2], r[5], r[8]]);
        let pose = Pose::new(rot, t).unwrap();
        let surf = std::env::var("SURF").is_ok();
        let q = PenetrationQuery::new(&a, &b, pose).solid(!surf);
        let mut best = f64::INFINITY;
        let mut ans = q.run(&mut ws, Budget::unlimited());
        let reps = if ans.stats.work > 300_000 { 1 } else { 20 };
        for _ in 0..(if std::env::var("ONCE").is_ok() { 0 } else { 15 }) {
            let t0 = std::time::Instant::now();
            for _ in 0..reps { ans = q.run(&mut ws, Budget::unlimited()); }
            best = best.min(t0.elapsed().as_nanos() as f64 * 1e-3 / reps as f64);
        }
        out += &format!("{best:.4} {:.12} {:.3e} {} {:?} {na} {nb}\n", ans.value.high, ans.value.high / ans.value.low - 1.0, ans.stats.work, ans.stop);
    }
    std::fs::write("/tmp/epa/ours.txt", out).unwrap();
}
