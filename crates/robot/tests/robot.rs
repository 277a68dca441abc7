//! The promises of the crate, on an arm with every kind of joint and shape.

mod cell;

use std::path::Path;
use std::sync::Arc;

use cell::*;
use punctual::glam::{DMat3, DVec3};
use punctual::{Budget, Pose, Query, Tree, Verdict, Workspace, shapes};
use punctual_robot::{
    Checker, ClearanceOptions, Collision, Description, Edge, EdgeAnswer, EdgeOptions, Joint,
    JointKind, Mimic, Model, RobotError, Scope, Shape, ShapeId, UrdfOptions, braking_time,
    safe_speed,
};

#[test]
fn links_are_where_the_joints_bring_them() {
    let arm = arm();
    assert_eq!(arm.name(), "arm");
    assert_eq!(arm.joint_names(), ["pan", "lift", "elbow", "grip"]);
    assert_eq!(arm.joint_limits()[..2], [None, Some([-2.0, 2.0])]);
    let poses = arm.link_poses(&[1.0, 0.5, -0.7, 0.04]).unwrap();
    let turn = |axis, angle| DMat3::from_axis_angle(axis, angle);
    let upper = turn(DVec3::Z, 1.0) * turn(DVec3::Y, 0.5);
    let fore = upper * turn(DVec3::Y, -0.7);
    let elbow = DVec3::new(0.0, 0.0, 0.3) + upper * DVec3::new(0.0, 0.0, 0.65);
    let palm = elbow + fore * DVec3::new(0.0, 0.0, 0.55);
    let across = fore * turn(DVec3::Z, 1.5) * DVec3::Y;
    for (link, want) in [
        ("upper", DVec3::new(0.0, 0.0, 0.3)),
        ("fore", elbow),
        ("palm", palm),
        ("left", palm + across * 0.04),
        ("right", palm - across * (0.5 * 0.04 + 0.06)),
    ] {
        let at = arm.link_names().position(|name| name == link).unwrap();
        let found = poses[at].translation();
        assert!(found.distance(want) < 1e-14, "{link}: {found} {want}");
    }
}

#[test]
fn links_that_the_robot_does_not_have_are_noted() {
    let arm = arm();
    let notices = arm.notices();
    assert_eq!(notices.len(), 1, "{notices:?}");
    assert!(
        notices[0].contains("arm.srdf:4") && notices[0].contains("tail"),
        "{notices:?}"
    );
}

/// What is told by a refusal.
fn told<T>(result: Result<T, RobotError>) -> String {
    result.err().expect("refused").to_string()
}

#[track_caller]
fn assert_has(text: &str, words: &str) {
    assert!(text.contains(words), "{text}");
}

/// Writes a robot of two links with these collision elements and joint, and reads it.
fn read(folder: &Path, before: &str, link: &str, joint: &str) -> Result<Model, RobotError> {
    std::fs::create_dir_all(folder).unwrap();
    let text = format!(
        "{before}<robot name=\"two\"><link name=\"base\"/>\n<link name=\"tip\">{link}</link>\n\
         {joint}<joint name=\"own\" type=\"revolute\"><parent link=\"base\"/><child link=\"tip\"/>\
         <limit lower=\"-1\" upper=\"1\"/></joint></robot>"
    );
    std::fs::write(folder.join("two.urdf"), text).unwrap();
    let options = UrdfOptions::default().packages(folder);
    let model = Model::from_urdf(folder.join("two.urdf"), &options);
    std::fs::remove_dir_all(folder).unwrap();
    model
}

/// Pinocchio makes a capsule of a cylinder that `collision_checking` names.
#[test]
fn elements_that_are_passed_over_are_noted_and_harmless_ones_are_not() {
    let collision = |inner: &str| format!("<collision><geometry>{inner}</geometry></collision>");
    let cylinder = collision("<cylinder radius=\"1\" length=\"2\"/>");
    let capsule = "<collision_checking>\n<capsule name=\"tip\"/></collision_checking>";
    let harmless = "<inertial/><visual/><!-- a comment -->";
    let link = format!("{harmless}{cylinder}\n{capsule}{capsule}");
    let joint = "<gazebo/><transmission/><unheard_of/>";
    let model = read(&folder("capsule"), "", &link, joint);
    let notices = model.unwrap().notices().to_vec();
    assert_eq!(notices.len(), 2, "{notices:?}");
    for (notice, end) in notices.iter().zip([
        "two.urdf:6: `unheard_of` in a `robot` is passed over",
        "two.urdf:3: link tip: `collision_checking` in a `link` is passed over",
    ]) {
        assert!(notice.ends_with(end), "{notice}");
    }
    let two = collision("<sphere radius=\"1\"/><sphere radius=\"2\"/>");
    let error = told(read(&folder("shapes"), "", &two, ""));
    assert_has(&error, "two.urdf:2: link tip: a geometry of several shapes");
}

#[test]
fn a_late_declaration_and_other_encodings_are_read() {
    for before in [
        "\n <?xml version=\"1.0\"?>\n",
        "<!-- made by hand -->\n<?xml version=\"1.0\"\n encoding=\"utf-8\"?>",
        "\u{feff}<?xml version=\"1.0\"?><?xml-stylesheet href=\"a\"?>",
    ] {
        let model = read(&folder("late"), before, "", "").unwrap();
        assert_eq!(model.name(), "two", "{before}");
        let error = told(read(&folder("late"), before, "<collision/>", ""));
        let line = before.matches('\n').count() + 2;
        assert_has(&error, &format!("two.urdf:{line}: link tip"));
    }
}

/// A joint may follow one that stands behind it in the file.
#[test]
fn a_mimic_may_come_before_its_joint() {
    let link = "</link><link name=\"after\">";
    let joint = "<joint name=\"early\" type=\"revolute\"><parent link=\"tip\"/><child link=\"after\"/>\
                 <axis xyz=\"0 0 1\"/><mimic joint=\"own\" multiplier=\"-2\"/></joint>\n";
    let model = read(&folder("mimic"), "", link, joint).unwrap();
    assert_eq!(model.joint_names(), ["own"]);
    let poses = model.link_poses(&[0.25]).unwrap();
    let want = DMat3::from_axis_angle(DVec3::X, 0.25) * DMat3::from_axis_angle(DVec3::Z, -0.5);
    assert!(poses[2].rotation().abs_diff_eq(want, 1e-15), "{poses:?}");
}

#[test]
fn packages_are_found_by_the_name_in_package_xml() {
    let mesh = |name: &str| {
        let place = format!("<mesh filename=\"package://{name}/meshes/wedge.obj\"/>");
        format!("<collision><geometry>{place}</geometry></collision>")
    };
    let root = folder("packages");
    // The URDF file is in the package, beside it, or elsewhere; folders have other names.
    for (of_urdf, package) in [
        ("src/a_folder/urdf", "src/a_folder"),
        ("src/b/urdf", "src/a_folder"),
        ("elsewhere", "elsewhere/src/deep/er/a_folder"),
    ] {
        let package = root.join(package);
        std::fs::create_dir_all(package.join("meshes")).unwrap();
        std::fs::copy(file("wedge.obj"), package.join("meshes/wedge.obj")).unwrap();
        let text = "\n<?xml version=\"1.0\"?><package format=\"2\"><name> arms </name></package>";
        std::fs::write(package.join("package.xml"), text).unwrap();
        let model = read(&root.join(of_urdf), "", &mesh("arms"), "").unwrap();
        assert_eq!(model.description().links[1].shapes.len(), 1, "{of_urdf}");
        let error = read(&root.join("src/b"), "", &mesh("legs"), "").unwrap_err();
        assert_has(
            &error.to_string(),
            "package://legs/meshes/wedge.obj: not found",
        );
        let kind = Some(std::io::ErrorKind::NotFound);
        assert!(matches!(error, RobotError::File { kind: found, .. } if found == kind));
        let _ = std::fs::remove_dir_all(&root);
    }
}

#[test]
fn files_that_do_not_exist_are_told_from_bad_ones() {
    let kind_of = |error| match error {
        RobotError::File { kind, .. } => kind,
        error => panic!("{error}"),
    };
    let missing = Some(std::io::ErrorKind::NotFound);
    let none = Model::from_urdf("none.urdf", &UrdfOptions::default()).unwrap_err();
    assert_eq!(kind_of(none), missing);
    let mesh = |name: &str| {
        format!("<collision><geometry><mesh filename=\"{name}\"/></geometry></collision>")
    };
    let error = read(&folder("missing"), "", &mesh("none.obj"), "").unwrap_err();
    assert_has(&error.to_string(), "two.urdf:2: link tip: ");
    assert_eq!(kind_of(error), missing);
    let error = read(&folder("bad"), "", &mesh("two.urdf"), "").unwrap_err();
    assert_eq!(kind_of(error), None);
    let srdf = UrdfOptions::default().srdf("none.srdf");
    let arm = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/arm7.urdf");
    assert_eq!(kind_of(Model::from_urdf(arm, &srdf).unwrap_err()), missing);
}

/// Obstacles that are added, attached, moved and removed one by one, against all pairs listed anew.
#[test]
fn a_change_of_one_obstacle_is_as_good_as_pairing_all_anew() {
    let mut random = random(5);
    let mut checker = Checker::new(arm());
    let mut known: Vec<ShapeId> = Vec::new();
    let queries = configurations(40, 9);
    let (mut free, mut pairs, mut again) = (0, Vec::new(), Vec::new());
    for step in 0..120 {
        let place = at(2.0 * random() - 1.0, 2.0 * random() - 1.0, 1.5 * random());
        let shape = match step % 3 {
            0 => sphere(0.02 + 0.1 * random()),
            1 => cuboid([0.1, 0.2, 0.03]),
            _ => Shape::mesh(shapes::icosphere(1)),
        };
        match step % 7 {
            // Far away, which widens the slack of the filters.
            3 => {
                let id = known[step / 2 % known.len()];
                checker.move_to(id, at(1e4, 0.0, 0.0)).unwrap();
            }
            4 => checker
                .move_to(known[step / 3 % known.len()], place)
                .unwrap(),
            5 if step % 2 == 0 => {
                let id = known.swap_remove(step % known.len());
                checker.remove(id).unwrap();
            }
            6 => {
                let near = at(0.1 * random(), 0.1, 0.1 * random());
                let id = checker.attach("load", "palm", near, sphere(0.05), &["fore"]);
                known.push(id.unwrap());
            }
            2 => {
                let id = checker.attach("still", None, place, shape, &["upper", "base"]);
                known.push(id.unwrap());
            }
            _ => known.push(checker.add("still", place, shape).unwrap()),
        }
        // A removal lists all pairs anew.
        let mut fresh = checker.clone();
        let last = fresh.add("last", Pose::IDENTITY, sphere(1e-3)).unwrap();
        fresh.remove(last).unwrap();
        assert!(checker.pairs().eq(fresh.pairs()), "{step}");
        for q in queries.iter().skip(step % 8).step_by(8) {
            let one = checker.collide_all(q, UNLIMITED, &mut pairs).unwrap().value;
            let other = fresh.collide_all(q, UNLIMITED, &mut again).unwrap().value;
            assert_eq!((one, &pairs), (other, &again), "{step}");
            free += u32::from(one == Collision::Free);
            let [one, other] = [&mut checker, &mut fresh].map(|checker| clearance(checker, q));
            assert_eq!((one.low, one.high), (other.low, other.high), "{step}");
        }
    }
    assert!(free > 20 && known.len() > 50, "{free} {}", known.len());
}

#[test]
fn an_obstacle_in_the_world_may_touch_the_links_that_are_named() {
    let mut checker = Checker::new(arm());
    let q = [0.0; 4];
    let cube = || cuboid([0.2; 3]);
    let inside = at(0.0, 0.0, 0.6);
    let id = checker.add("cube", inside, cube()).unwrap();
    let met = collide(&mut checker, &q);
    assert!(
        matches!(met, Collision::Contact(pair) if pair.contains(&id)),
        "{met:?}"
    );
    checker.remove(id).unwrap();
    checker
        .attach("cube", None, inside, cube(), &["upper"])
        .unwrap();
    assert_eq!(collide(&mut checker, &q), Collision::Free);
    let pairs = checker.pairs().len();
    for link in [None, Some("palm")] {
        let refused = checker.attach("it", link, inside, cube(), &["upper", "nose"]);
        let error = refused.unwrap_err().to_string();
        assert_eq!(error, "obstacle it: may_touch: there is no link nose");
    }
    assert_eq!(checker.pairs().len(), pairs);
}

#[test]
fn neighbours_are_not_asked_without_srdf() {
    let text = std::fs::read_to_string(file("arm.urdf")).unwrap();
    let folder = folder("alone");
    std::fs::create_dir_all(folder.join("arm")).unwrap();
    for name in ["wedge.obj", "arm/wedge.obj"] {
        std::fs::copy(file("wedge.obj"), folder.join(name)).unwrap();
    }
    std::fs::write(folder.join("arm.urdf"), text).unwrap();
    let model = Model::from_urdf(folder.join("arm.urdf"), &UrdfOptions::default()).unwrap();
    let checker = Checker::new(model.into());
    let names = |pair: [ShapeId; 2]| pair.map(|id| checker.name(id).unwrap());
    let pairs: Vec<_> = checker.pairs().map(names).collect();
    for (pair, is_asked) in [
        (["base", "fore"], true),
        (["base", "upper"], true),
        (["left", "right"], true),
        // The palm is fixed to the forearm, so both fingers are its neighbours.
        (["upper", "fore"], false),
        (["fore", "left"], false),
        (["fore", "right"], false),
    ] {
        assert_eq!(pairs.contains(&pair), is_asked, "{pair:?}");
    }
}

#[test]
fn every_pair_is_asked_exactly() {
    let mut checker = cell();
    let (mut free, mut met, mut inside, mut pairs) = (0, 0, 0, Vec::new());
    for q in configurations(400, 1) {
        let found = checker.collide_all(&q, UNLIMITED, &mut pairs).unwrap();
        let any = checker.collide(&q, UNLIMITED).unwrap();
        assert_eq!(any.value == Collision::Free, pairs.is_empty());
        assert_eq!(found.value == Collision::Free, pairs.is_empty());
        if let Collision::Contact(pair) = any.value {
            assert!(pairs.contains(&pair));
        }
        for (pair, distance) in surfaces(&checker, &q) {
            let says = pairs.contains(&pair);
            // Boxes are rounded to f32 here, so up to 1e-7 both are right.
            assert!(distance > 0.0 || says, "{pair:?} {q:?}");
            inside += u32::from(says && distance > 1e-7);
            free += u32::from(!says);
            met += u32::from(says && distance == 0.0);
        }
    }
    // Few are wholly inside a solid.
    assert!(free > 1000 && met > 40 && inside < 5, "{free}");
}

#[test]
fn solids_hold_what_is_inside_them_and_surfaces_do_not() {
    let small = || Shape::mesh(shapes::icosphere(1));
    let cube = |half: f32| Shape::mesh(shapes::cuboid([half; 3], 1));
    let meets = |robot: Shape, obstacle: Shape, x: f64| {
        let slide = joint(
            "slide",
            JointKind::Prismatic,
            ["base", "body"],
            [1.0, 0.0, 0.0],
        );
        let description = Description {
            links: vec![
                link("base", vec![]),
                link("body", vec![(Pose::IDENTITY, robot)]),
            ],
            joints: vec![slide],
            ..Description::default()
        };
        let mut checker = Checker::new(Model::new(&description).unwrap().into());
        checker.add("it", Pose::IDENTITY, obstacle).unwrap();
        let found = collide(&mut checker, &[x]) != Collision::Free;
        let near = clearance(&mut checker, &[x]);
        assert_eq!(found, near.low == 0.0, "{near:?}");
        found
    };
    assert!(!meets(small(), cube(4.0), 0.0));
    for solid in [
        cuboid([8.0; 3]),
        sphere(4.0),
        Shape::cylinder(4.0, 8.0).unwrap(),
    ] {
        assert!(meets(small(), solid.clone(), 0.0) && meets(solid.clone(), small(), 0.0));
        assert!(!meets(small(), solid.clone(), 5.01) && meets(small(), solid, 4.9));
    }
    // Two parts, of which only the second is inside.
    let mut vertices: Vec<[f64; 3]> = Vec::new();
    let mut triangles = Vec::new();
    for x in [10.0, 0.0] {
        let first = vertices.len() as u32;
        let ball = shapes::icosphere(0);
        let moved = |i| (ball.vertex(i) * 0.1 + DVec3::X * x).to_array();
        vertices.extend((0..ball.vertex_count()).map(moved));
        triangles.extend(ball.triangles().iter().map(|t| t.map(|i| i + first)));
    }
    let two = Shape::mesh(punctual::Mesh::from_f64(vertices, triangles).unwrap());
    assert!(meets(two.clone(), cuboid([2.0; 3]), 0.0));
    assert!(!meets(two, cuboid([2.0; 3]), 3.0));
    // Meshes as solids: a torus has a hole, and what faces inwards is turned.
    let mesh = shapes::cuboid([4.0; 3], 1);
    let vertices = (0..mesh.vertex_count()).map(|i| mesh.vertex(i).to_array());
    let inside_out = mesh.triangles().iter().map(|&[a, b, c]| [a, c, b]);
    let inside_out = punctual::Mesh::from_f64(vertices.clone(), inside_out).unwrap();
    let open = punctual::Mesh::from_f64(vertices, mesh.triangles()[1..].iter().copied()).unwrap();
    for (solid, is_solid) in [(mesh, true), (inside_out, true), (open, false)] {
        let solid = Shape::solid(solid);
        assert_eq!(solid.is_solid(), is_solid);
        assert_eq!(meets(small(), solid.clone(), 0.0), is_solid);
        assert_eq!(meets(solid.clone(), small(), 0.0), is_solid);
        assert!(!meets(small(), solid.clone(), 5.01) && meets(small(), solid, 4.9));
    }
    let torus = || Shape::solid(shapes::torus(3.0, 1.5, 64));
    let pea = || sphere(0.1);
    assert!(!meets(pea(), torus(), 0.0));
    assert!(meets(pea(), torus(), 3.0) && meets(torus(), pea(), -3.0));
    let options = punctual::BuildOptions::default().solid(punctual::tree::Solid::Keep);
    let tree = Tree::with_options(shapes::icosphere(2), &options);
    assert!(meets(pea(), Shape::tree(tree.into()), 0.0));
}

#[test]
fn meshes_of_files_are_solids_if_asked_scaled_and_mirrored_ones_too() {
    let mut options = UrdfOptions::default();
    options.solids = true;
    let solids = read_arm("solids", &options);
    let q = [0.3, -0.4, 0.2, 0.05];
    for (link, z) in [("fore", 0.25), ("right", 0.0)] {
        for (model, meets) in [(arm(), false), (Arc::clone(&solids), true)] {
            let number = model.link_names().position(|name| name == link).unwrap();
            let pose = model.link_poses(&q).unwrap()[number];
            let place = pose.compose(&at(0.0, 0.0, z)).unwrap();
            let mut checker = Checker::new(model);
            let pea = checker.add("pea", place, sphere(0.001)).unwrap();
            let met = Collision::Contact([checker.find(link).unwrap(), pea]);
            let found = collide(&mut checker, &q);
            assert_eq!(found, if meets { met } else { Collision::Free });
        }
    }
}

#[test]
fn clearance_is_the_least_distance() {
    let mut checker = cell();
    let ids = ["base", "post"].map(|name| checker.find(name).unwrap());
    let options = ClearanceOptions::default().tolerance(1e-9);
    let mut measured = 0;
    for q in configurations(150, 2) {
        let found = checker.clearance(&q, &options, UNLIMITED).unwrap().value;
        let all = surfaces(&checker, &q);
        let least = all.iter().map(|pair| pair.1).fold(f64::INFINITY, f64::min);
        assert!(found.low <= found.high, "{found:?}");
        assert!(found.low <= least + 1e-7, "{found:?} {least}");
        if found.low == 0.0 {
            assert!(collide(&mut checker, &q) != Collision::Free);
            continue;
        }
        let pair = found.pair.unwrap();
        let [p, r] = found.points;
        assert!((r - p).distance(found.normal * p.distance(r)) < 1e-12);
        if !ids.iter().any(|id| pair.contains(id)) {
            let of_pair = all.iter().find(|other| other.0 == pair).unwrap().1;
            assert!(found.high - found.low <= 1.001e-9 && (of_pair - found.high).abs() < 1e-7);
            assert!((p.distance(r) - found.high).abs() < 1e-9);
            measured += 1;
        }
    }
    assert!(measured > 30, "{measured}");
}

#[test]
fn scopes_divide_the_pairs() {
    let mut checker = cell();
    let load = checker.find("load").unwrap();
    for q in configurations(50, 3) {
        let mut of = |scope| {
            let options = ClearanceOptions::default().tolerance(0.0).scope(scope);
            checker.clearance(&q, &options, UNLIMITED).unwrap().value
        };
        let [all, robot, obstacles] = [Scope::All, Scope::Robot, Scope::Obstacles].map(&mut of);
        assert_eq!(all.low, robot.low.min(obstacles.low));
        let load_only = of(Scope::Shape(load));
        assert!(load_only.pair.is_none_or(|pair| pair.contains(&load)) && load_only.low >= all.low);
    }
}

#[test]
fn what_a_stopped_call_says_is_true() {
    let mut checker = cell();
    for q in configurations(40, 4) {
        let options = ClearanceOptions::default();
        let whole = checker.collide(&q, UNLIMITED).unwrap();
        let least = checker.clearance(&q, &options, UNLIMITED).unwrap();
        let none = checker.collide(&q, Budget::work(0)).unwrap();
        assert_eq!(none.value, Collision::Undecided);
        let most = 2 * (whole.work + least.work);
        for work in (0..).map(|i| 1 << i).take_while(|&work| work < most) {
            let part = checker.collide(&q, Budget::work(work)).unwrap();
            match part.value {
                Collision::Undecided => assert!(part.stop != punctual::StopReason::Finished),
                value => assert_eq!(value == Collision::Free, whole.value == Collision::Free),
            }
            let part = checker
                .clearance(&q, &options, Budget::work(work))
                .unwrap()
                .value;
            assert!(
                part.low <= least.value.high && part.high >= least.value.low,
                "{part:?}"
            );
        }
    }
}

fn edges(count: usize) -> Vec<[Vec<f64>; 2]> {
    let ends = configurations(count, 6);
    let near = |(from, to): (Vec<f64>, Vec<f64>)| [from.clone(), between(&from, &to, 0.3)];
    configurations(count, 5)
        .into_iter()
        .zip(ends)
        .map(near)
        .collect()
}

#[test]
fn edges_are_never_contradicted_by_samples() {
    let mut checker = cell();
    let mut counts = [0; 3];
    for [from, to] in edges(120) {
        let [any, first] = [EdgeOptions::any(), EdgeOptions::first()]
            .map(|options| checker.edge(&from, &to, &options, UNLIMITED).unwrap().value);
        let dense = first_contact(&mut checker, [&from, &to], 400);
        for edge in [any, first] {
            counts[edge.answer as usize] += 1;
            let (at, free_until) = (edge.touching_at, edge.free_until);
            let meets = |t| collide(&mut checker, &between(&from, &to, t)) != Collision::Free;
            assert_eq!(edge.answer == EdgeAnswer::Contact, at.is_some());
            assert!(at.is_none_or(meets) && free_until <= at.unwrap_or(1.0));
            assert!(dense.is_none_or(|t| free_until <= t), "{edge:?} {dense:?}");
            let is_free = free_until == 1.0 && at.is_none();
            assert_eq!(edge.answer == EdgeAnswer::Free, is_free);
        }
        assert!(dense.is_none_or(|dense| first.touching_at.unwrap() <= dense + 1e-6));
    }
    let [free, contact, open] = counts;
    assert!(free > 30 && contact > 60 && open < 5, "{counts:?}");
}

/// A chain of balls on joints of random kinds and axes, among balls.
fn random_chain(seed: u64) -> Checker {
    let mut random = random(seed);
    let mut within = |size: f64| (2.0 * random() - 1.0) * size;
    let (mut links, mut joints) = (Vec::new(), Vec::new());
    for i in 0..7 {
        let pose = at(within(0.2), within(0.2), within(0.2));
        let ball = sphere(0.03 + within(0.02));
        let [name, next] = [i, i + 1].map(|i| format!("link{i}"));
        links.push(link(&name, vec![(pose, ball)]));
        let kind = match within(1.0) < -0.5 {
            true => JointKind::Prismatic,
            false => JointKind::Continuous,
        };
        let origin = at(within(0.1), within(0.1), within(0.4));
        let axis = [within(1.0), within(1.0), within(1.0)];
        joints.push(Joint {
            origin,
            ..joint(&format!("joint{i}"), kind, [&name, &next], axis)
        });
    }
    joints.pop();
    let robot = Description {
        links,
        joints,
        allows_neighbours: true,
        ..Description::default()
    };
    let mut checker = Checker::new(Model::new(&robot).unwrap().into());
    for i in 0..4 {
        let pose = at(within(0.8), within(0.8), within(0.8));
        let ball = sphere(0.1);
        checker.add(&format!("ball{i}"), pose, ball).unwrap();
    }
    checker
}

#[test]
fn random_chains_never_meet_where_they_are_proven_free() {
    let (mut free, mut touching) = (0, 0);
    for seed in 1..60 {
        let mut checker = random_chain(seed);
        let mut random = random(seed + 100);
        let mut row = || Vec::from_iter((0..6).map(|_| 2.0 * random() - 1.0));
        for (from, to) in (0..6).map(|_| (row(), row())).collect::<Vec<_>>() {
            let edge = checker.edge(&from, &to, &EdgeOptions::first(), UNLIMITED);
            let edge = edge.unwrap().value;
            let dense = first_contact(&mut checker, [&from, &to], 300);
            let meets = |t| collide(&mut checker, &between(&from, &to, t)) != Collision::Free;
            assert!(dense.is_none_or(|t| edge.free_until <= t), "{seed}");
            assert!(edge.touching_at.is_none_or(meets));
            free += u32::from(edge.answer == EdgeAnswer::Free);
            touching += u32::from(edge.touching_at.is_some());
        }
    }
    assert!(free > 50 && touching > 50, "{free} {touching}");
}

#[test]
fn a_path_is_free_if_its_lines_are() {
    let mut checker = cell();
    let mut counts = [0; 2];
    for (i, lines) in edges(60).chunks(3).enumerate() {
        // The second half of each path leads back.
        let mut knots: Vec<f64> = lines[0].concat();
        knots.extend(&lines[i % 3][1]);
        knots.extend(&lines[0][0]);
        for options in [EdgeOptions::any(), EdgeOptions::first()] {
            let path = checker.path(&knots, &options, UNLIMITED).unwrap().value;
            let each = [0, 1, 2].map(|line| {
                let (from, to) = knots[4 * line..4 * line + 8].split_at(4);
                checker.edge(from, to, &options, UNLIMITED).unwrap().value
            });
            let first = each.iter().position(|edge| edge.answer != EdgeAnswer::Free);
            counts[usize::from(first.is_some())] += 1;
            let Some(first) = first else {
                assert_eq!((path.answer, path.free_until), (EdgeAnswer::Free, 3.0));
                continue;
            };
            assert_eq!(path.answer, EdgeAnswer::Contact);
            assert!(path.free_until <= path.touching_at.unwrap());
            let at = first as f64 + each[first].touching_at.unwrap();
            assert!(path.free_until <= at);
            let late = (path.touching_at.unwrap() - at).abs();
            assert!(!options.first || late < 2e-6 && at - path.free_until < 2e-4);
        }
    }
    assert!(counts.iter().all(|&count| count >= 4), "{counts:?}");
    let error = told(checker.path(&[0.0; 4], &EdgeOptions::any(), UNLIMITED));
    assert_has(&error, "two configurations");
    let error = checker.path(&[0.0; 6], &EdgeOptions::any(), UNLIMITED);
    let (expected, found) = (4, 2);
    assert_eq!(error, Err(RobotError::Length { expected, found }));
}

#[test]
fn a_horizon_is_true_and_leaves_room_to_stop() {
    let mut checker = cell();
    let mut counts = [0; 2];
    for (i, [from, to]) in edges(120).into_iter().enumerate() {
        let velocity: Vec<f64> = from.iter().zip(&to).map(|(a, b)| b - a).collect();
        let place = |t: f64| between(&from, &to, t);
        let seconds = [0.5, 1.5][i % 2];
        let budget = [UNLIMITED, Budget::work(20_000)][i / 2 % 2];
        let ahead = checker.horizon(&from, &velocity, seconds, budget).unwrap();
        let ahead = ahead.value;
        let mut meets = |t: f64| collide(&mut checker, &place(t)) != Collision::Free;
        assert!((0.0..=seconds).contains(&ahead.free_until));
        for t in (0..200).map(|i| ahead.free_until * f64::from(i) / 200.0) {
            assert!(ahead.free_until == 0.0 || !meets(t), "{ahead:?} {t}");
        }
        assert_eq!(ahead.touching_at.is_some(), ahead.pair.is_some());
        assert!(ahead.touching_at.is_none_or(|t| t >= ahead.free_until));
        let braking = braking_time(&velocity, &[3.0; 4]);
        let share = safe_speed(ahead.free_until, 0.01, braking);
        let way = share * 0.01 + share * share * braking / 2.0;
        assert!((0.0..=1.0).contains(&share) && way <= ahead.free_until);
        assert!(share == 1.0 || way >= ahead.free_until * (1.0 - 1e-9));
        counts[usize::from(ahead.free_until == seconds)] += 1;

        let mut part = checker.clone();
        let cut = part.horizon(&from, &velocity, seconds, Budget::work(1));
        let mut cut = cut.unwrap();
        while cut.stop != punctual::StopReason::Finished {
            cut = part.resume_edge(Budget::work(3_000)).unwrap();
        }
        let whole = checker
            .clone()
            .horizon(&from, &velocity, seconds, UNLIMITED);
        assert_eq!(cut.value, whole.unwrap().value);
    }
    assert!(counts.iter().all(|&count| count > 20), "{counts:?}");
    let still = checker.horizon(&[0.0; 4], &[0.0; 4], 1.0, UNLIMITED);
    assert_eq!(still.unwrap().value.free_until, 1.0);
    let at_once = braking_time(&[0.0; 4], &[1.0; 4]);
    assert_eq!(safe_speed(1.0, 0.0, at_once), 1.0);
    let error = told(checker.horizon(&[0.0; 4], &[f64::NAN; 4], 1.0, UNLIMITED));
    assert_has(&error, "joint pan");
}

/// What is not known to stop has no speed.
#[test]
fn a_robot_that_cannot_brake_stands_still() {
    for (velocity, decelerations) in [
        (&[1.0, 0.5][..], &[10.0, 0.0][..]),
        (&[1.0, 0.5], &[10.0, -3.0]),
        (&[1.0, 0.5], &[10.0, f64::NAN]),
        (&[1.0, 0.5], &[10.0]),
        (&[1.0, f64::NAN], &[10.0, 3.0]),
        (&[f64::INFINITY], &[f64::INFINITY]),
    ] {
        let braking = braking_time(velocity, decelerations);
        assert_eq!(braking, f64::INFINITY, "{velocity:?} {decelerations:?}");
        assert_eq!(safe_speed(0.5, 0.001, braking), 0.0);
    }
    assert_eq!(braking_time(&[2.0, 0.0], &[10.0, 0.0]), 0.2);
    assert_eq!(braking_time(&[], &[]), 0.0);
    let nan = f64::NAN;
    for [free, delay, braking] in [
        [0.5, 0.001, nan],
        [0.5, nan, 0.1],
        [nan, 0.001, 0.1],
        [-1.0, 0.0, 0.0],
    ] {
        assert_eq!(safe_speed(free, delay, braking), 0.0);
    }
    assert_eq!(safe_speed(f64::INFINITY, 0.001, f64::INFINITY), 1.0);
    assert!(safe_speed(0.1, 0.001, 0.5) < 1.0);
}

#[test]
fn a_cut_edge_ends_with_the_same_answer() {
    let mut checker = cell();
    for options in [EdgeOptions::any(), EdgeOptions::first()] {
        for [from, to] in edges(25) {
            // The order must be the same, too.
            let mut other = checker.clone();
            let whole = other.edge(&from, &to, &options, UNLIMITED).unwrap();
            for step in [1, 700, 20_000] {
                let mut part = checker.clone();
                let mut known = part.edge(&from, &to, &options, Budget::work(step)).unwrap();
                let mut free_until = 0.0;
                while known.stop != punctual::StopReason::Finished {
                    let Edge {
                        free_until: now,
                        touching_at,
                        ..
                    } = known.value;
                    assert!(now >= free_until || touching_at.is_some());
                    free_until = now;
                    known = part.resume_edge(Budget::work(step)).unwrap();
                }
                assert_eq!(known.value, whole.value);
                let over = part.resume_edge(UNLIMITED);
                assert_eq!(over, Err(RobotError::NothingToResume));
            }
            let _ = checker.collide(&from, UNLIMITED);
        }
    }
}

#[test]
fn batches_have_the_same_bits_on_any_number_of_threads() {
    let rows: Vec<f64> = configurations(700, 7).concat();
    let ends = edges(60);
    let [from, to] = [0, 1].map(|end| {
        ends.iter()
            .flat_map(|edge| edge[end].clone())
            .collect::<Vec<_>>()
    });
    for budget in [UNLIMITED, Budget::work(3_000)] {
        let all = [1, 2, 3].map(|threads| {
            let mut checker = cell();
            let labels = checker.collide_batch(&rows, budget, threads).unwrap();
            let options = ClearanceOptions::default();
            let near = checker.clearance_batch(&rows, &options, budget, threads);
            let edges = checker.edge_batch(&from, &to, &EdgeOptions::any(), budget, threads);
            (labels, near.unwrap(), edges.unwrap())
        });
        assert!(all[0] == all[1] && all[0] == all[2]);
        assert_eq!((all[0].0.len(), all[0].2.len()), (700, 60));
        let mut checker = cell();
        for (row, label) in rows.chunks(4).zip(&all[0].0) {
            let is_free = collide(&mut checker, row) == Collision::Free;
            let is_right = is_free == (label.value == Collision::Free);
            assert!(is_right || label.value == Collision::Undecided);
        }
    }
}

#[test]
fn obstacles_come_move_and_go() {
    let mut checker = Checker::new(arm());
    let q = [0.0; 4];
    assert_eq!(collide(&mut checker, &q), Collision::Free);
    let pairs = checker.pairs().len();
    let upper = checker.find("upper").unwrap();
    let ball = checker.add("ball", at(0.3, 0.0, 0.6), sphere(0.1)).unwrap();
    assert_eq!(collide(&mut checker, &q), Collision::Free);
    checker.move_to(ball, at(0.1, 0.0, 0.6)).unwrap();
    assert_eq!(collide(&mut checker, &q), Collision::Contact([upper, ball]));
    checker.remove(ball).unwrap();
    assert_eq!(collide(&mut checker, &q), Collision::Free);
    assert_eq!(checker.pairs().len(), pairs);
    let none = Err(RobotError::NoObstacle);
    assert_eq!(checker.move_to(ball, at(0.0, 0.0, 0.0)), none);
    assert_eq!((checker.remove(upper), checker.name(ball)), (none, None));
    // In the hand, it turns with the arm, and hits a wall that the arm does not reach.
    let (rod, place) = (cuboid([0.02, 0.02, 1.0]), at(0.0, 0.0, 0.6));
    let rod = checker
        .attach("rod", "palm", place, rod, &["left", "right"])
        .unwrap();
    let wall = checker
        .add("wall", at(2.0, 0.0, 1.0), cuboid([0.1, 2.0, 2.0]))
        .unwrap();
    assert_eq!(collide(&mut checker, &q), Collision::Free);
    let bent = collide(&mut checker, &[0.0, 1.5, 0.0, 0.0]);
    assert_eq!(bent, Collision::Contact([rod, wall]));
}

#[test]
fn cylinders_are_within_their_band() {
    let shape = Shape::cylinder(0.5, 1.0).unwrap();
    assert!(shape.band() > 0.0 && shape.band() < 3.03e-4 * 0.5);
    let mesh = shape.surface().mesh();
    for t in 0..mesh.len() {
        let corners = mesh.triangle(t);
        // The chord of a side comes nearest to the axis.
        let middles = [(0, 1), (0, 2), (1, 2)].map(|(i, j)| (corners[i] + corners[j]) / 2.0);
        for p in corners.iter().chain(&middles) {
            let radius = p.truncate().length();
            let is_end = (p.z.abs() - 0.5).abs() < 1e-15;
            assert!(radius <= 0.5 + shape.band());
            assert!(radius >= 0.5 || (is_end && radius < 0.5), "{radius}");
        }
    }
}

#[test]
fn what_is_wrong_is_named() {
    let folder = folder("faults");
    std::fs::create_dir_all(&folder).unwrap();
    let urdf = folder.join("robot.urdf");
    let robot = |inside: &str, words: &[&str]| {
        std::fs::write(&urdf, format!("<robot name=\"r\">{inside}</robot>")).unwrap();
        let error = told(Model::from_urdf(&urdf, &UrdfOptions::default()));
        words.iter().for_each(|words| assert_has(&error, words));
    };
    let hand = |shape: &str, words: [&str; 2]| {
        let shape = format!("<collision><geometry>{shape}</geometry></collision>");
        let link = format!("<link name=\"hand\">{shape}</link>");
        robot(&link, &["link hand", words[0], words[1]]);
    };
    let knee = |kind: &str, inner: &str, words: [&str; 2]| {
        let joint = format!(
            "<link name=\"hand\"/><link name=\"arm\"/><joint name=\"knee\" type=\"{kind}\">\n\
             <parent link=\"arm\"/><child link=\"hand\"/>{inner}</joint>"
        );
        robot(&joint, &["joint knee", words[0], words[1]]);
    };
    hand(
        "<mesh filename=\"none.stl\"/>",
        ["robot.urdf:1", "none.stl"],
    );
    hand("<mesh filename=\"a.dae\"/>", ["robot.urdf:1", "a.dae"]);
    hand(
        "<mesh filename=\"package://p/a.stl\"/>",
        ["package://p/a.stl", "not found"],
    );
    hand("<cone radius=\"1\"/>", ["cone", "robot.urdf:1"]);
    hand("<capsule radius=\"1\"/>", ["length", "robot.urdf:1"]);
    hand("<box size=\"1 2\"/>", ["size", "3 numbers"]);
    hand("<sphere radius=\"-1\"/>", ["sphere", "radius is -1"]);
    hand("", ["without geometry", "robot.urdf:1"]);
    let revolute = "revolute";
    knee("spherical", "", ["spherical", "robot.urdf:1"]);
    knee(revolute, "<axis xyz=\"0 0 0\"/>", ["axis", "direction"]);
    knee(
        revolute,
        "<mimic joint=\"toe\"/>",
        ["mimics toe", "robot.urdf"],
    );
    knee(
        revolute,
        "<mimic joint=\"knee\"/>",
        ["mimics itself", "robot.urdf"],
    );
    knee(
        "fixed",
        "\n<origin xyz=\"0 x 0\"/>",
        ["xyz", "robot.urdf:3"],
    );
    let two = |a: &str, b: &str| format!("<link name=\"{a}\"/><link name=\"{b}\"/>");
    robot(
        &two("a", "b"),
        &["links a and b", "not connected", "child of no joint"],
    );
    robot(&two("a", "a"), &["two links", "named a", "robot.urdf"]);
    robot("<link>", &["robot.urdf:1", "link", "expected"]);
    let error = Model::from_urdf(folder.join("no.urdf"), &UrdfOptions::default());
    assert_has(&told(error), "no.urdf");
    let mut checker = Checker::new(arm());
    let (expected, found) = (4, 3);
    let short = RobotError::Length { expected, found };
    assert_eq!(checker.collide(&[0.0; 3], UNLIMITED), Err(short));
    let mut rows = [0.0; 8];
    rows[5] = f64::NAN;
    let error = told(checker.collide_batch(&rows, UNLIMITED, 1));
    assert_has(&error, "configuration 1");
    assert_has(&error, "joint lift");
    let error = checker.attach("x", "nose", Pose::IDENTITY, sphere(1.0), &[]);
    assert_has(&told(error), "nose");
}

#[test]
fn mimics_of_mimics_and_of_fixed_joints_follow() {
    let slides = JointKind::Prismatic;
    let follows = |name: &str, kind, child: &str, mimic: Option<(&str, f64, f64)>| Joint {
        mimic: mimic.map(|(joint, multiplier, offset)| Mimic {
            joint: joint.into(),
            multiplier,
            offset,
        }),
        ..joint(name, kind, ["w", child], [0.0, 0.0, 1.0])
    };
    let model = Model::new(&Description {
        links: ["w", "a", "b", "c", "d", "e"]
            .map(|name| link(name, vec![]))
            .into(),
        joints: vec![
            follows("to_b", slides, "b", Some(("to_a", 2.0, 0.5))),
            follows("to_a", slides, "a", None),
            follows("to_c", slides, "c", Some(("to_b", -1.0, 0.25))),
            follows("to_d", JointKind::Fixed, "d", None),
            follows("to_e", slides, "e", Some(("to_d", 7.0, 0.125))),
        ],
        ..Description::default()
    });
    let model = model.unwrap();
    assert_eq!(model.joint_names(), ["to_a"]);
    let poses = model.link_poses(&[3.0]).unwrap();
    let z: Vec<f64> = poses.iter().map(|pose| pose.translation().z).collect();
    assert_eq!(z, [0.0, 3.0, 6.5, -6.25, 0.0, 0.125]);
}

#[test]
fn models_and_checkers_go_to_threads() {
    fn goes<T: Send + Sync>() {}
    goes::<Model>();
    goes::<Checker>();
    goes::<Edge>();
    let [a, b] = [1, 2].map(|_| cuboid([1.0; 3]));
    let query = Query::intersection(a.surface(), b.surface(), Pose::IDENTITY);
    assert!(query.run(&mut Workspace::new(), UNLIMITED).value != Verdict::Separated);
}

/// A cloud against as many triangles without extent, and points inside of solid links.
#[test]
fn a_cloud_is_an_obstacle() {
    let mut random = random(66);
    let mut point = || DVec3::from_array([(); 3].map(|()| 2.0 * random() - 1.0));
    let points: Vec<_> = (0..400).map(|_| point()).collect();
    let corners = (0..400).map(|i| [i; 3]);
    let mesh = punctual::Mesh::from_f64(points.iter().copied(), corners).unwrap();
    let cloud = Tree::from_points_f64(points).unwrap();
    let [mut one, mut other] = [cloud, Tree::new(mesh)].map(|tree| {
        let mut checker = Checker::new(arm());
        let shape = Shape::tree(Arc::new(tree));
        checker.add("scan", Pose::IDENTITY, shape).unwrap();
        checker
    });
    let (mut hit, mut pairs, mut again) = (0, Vec::new(), Vec::new());
    for q in configurations(60, 3) {
        let [a, b] = [(&mut one, &mut pairs), (&mut other, &mut again)]
            .map(|(checker, pairs)| checker.collide_all(&q, UNLIMITED, pairs).unwrap().value);
        assert_eq!((a, &pairs), (b, &again));
        hit += u32::from(a != Collision::Free);
        let [a, b] = [&mut one, &mut other].map(|checker| clearance(checker, &q));
        assert!(a.low <= b.high + 1e-9 && b.low <= a.high + 1e-9, "{a:?}");
    }
    assert!(hit > 0, "{hit}");
}

#[test]
fn planar_and_floating_joints_are_chains_of_their_axes() {
    let shape = r#"<capsule radius="0.1" length="0.6"/>"#;
    let robot = format!(
        r#"<robot name="rover"><link name="world"/>
        <link name="base"><collision><geometry>{shape}</geometry></collision></link>
        <joint name="drive" type="planar"><parent link="world"/><child link="base"/>
        <origin xyz="0 0 0.5"/><axis xyz="0 0 2"/></joint>
        <link name="drone"><collision><geometry>{shape}</geometry></collision></link>
        <joint name="fly" type="floating"><parent link="world"/><child link="drone"/></joint>
        </robot>"#
    );
    let file = folder("rover");
    std::fs::write(&file, robot).unwrap();
    let model = Model::from_urdf(&file, &UrdfOptions::default()).unwrap();
    std::fs::remove_file(&file).unwrap();
    let ends = ["x", "y", "z", "yaw", "pitch", "roll"];
    let drive = ["drive/x", "drive/y", "drive/yaw"].map(String::from);
    let flies = ends.map(|end| format!("fly/{end}"));
    let names: Vec<String> = drive.into_iter().chain(flies).collect();
    let [mut found, mut sorted] = [model.joint_names(), &names].map(<[String]>::to_vec);
    found.sort_unstable();
    sorted.sort_unstable();
    assert_eq!(found, sorted);
    let (yaw, pitch, roll) = (0.4f64, -0.7f64, 0.9f64);
    let values = [1.0, 2.0, 0.3, -1.0, -2.0, 3.0, yaw, pitch, roll];
    let of = |name: &String| values[names.iter().position(|other| other == name).unwrap()];
    let q: Vec<f64> = model.joint_names().iter().map(of).collect();
    let poses = model.link_poses(&q).unwrap();
    let pose = |link: &str| poses[model.link_names().position(|name| name == link).unwrap()];
    assert_eq!(pose("base").translation(), DVec3::new(1.0, 2.0, 0.5));
    let turned = DMat3::from_rotation_z(0.3);
    assert!((*pose("base").rotation() - turned).abs_diff_eq(DMat3::ZERO, 1e-15));
    let rotation =
        DMat3::from_rotation_z(yaw) * DMat3::from_rotation_y(pitch) * DMat3::from_rotation_x(roll);
    assert_eq!(pose("drone").translation(), DVec3::new(-1.0, -2.0, 3.0));
    assert!((*pose("drone").rotation() - rotation).abs_diff_eq(DMat3::ZERO, 1e-15));
    // The capsules, one above the other, touch where their ends meet.
    let mut checker = Checker::new(model.into());
    let mut at = |height: f64| {
        let heights = |name: &String| if name == "fly/z" { height } else { 0.0 };
        let q: Vec<f64> = checker.model().joint_names().iter().map(heights).collect();
        checker.collide(&q, Budget::unlimited()).unwrap().value != Collision::Free
    };
    assert!(at(1.299_999) && !at(1.300_001) && at(0.5));
}
