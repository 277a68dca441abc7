//! A robot from a URDF file: a tree for each link, and where the links are for angles of the joints.

use std::error::Error;
use std::path::Path;

use punctual::glam::{DMat3, DVec3};
use punctual::{Pose, PoseError, Tree};
use urdf_rs::{Joint, JointType};

use crate::shapes::Surface;

/// What the collision geometry of a link is, all in its frame.
pub struct Link {
    pub name: String,
    pub tree: Tree,
}

pub struct Robot {
    pub links: Vec<Link>,
    /// From the root to the hands: each after the joint that moves its parent.
    joints: Vec<Moved>,
    /// Pairs of links that may meet, the lower number first.
    pub pairs: Vec<[usize; 2]>,
}

/// A joint, with the links it joins by number, and its place among the angles; none if it is fixed.
struct Moved {
    joint: Joint,
    parent: usize,
    child: usize,
    angle: Option<usize>,
}

impl Robot {
    /// Reads a robot; an error names the link or the joint.
    pub fn load(file: &Path) -> Result<Self, Box<dyn Error>> {
        let folder = file.parent().unwrap_or(Path::new(""));
        let read =
            urdf_rs::read_file(file).map_err(|error| format!("{}: {error}", file.display()))?;
        let link = |link: &urdf_rs::Link| {
            let tree =
                tree(link, folder).map_err(|error| format!("link {}: {error}", link.name))?;
            Ok(Link {
                name: link.name.clone(),
                tree,
            })
        };
        let links = read
            .links
            .iter()
            .map(link)
            .collect::<Result<Vec<_>, String>>()?;
        let joints = sorted(read.joints, &links)?;
        let pairs = pairs(links.len(), &joints);
        Ok(Self {
            links,
            joints,
            pairs,
        })
    }

    /// Where the links are; an angle in radians, or a way in metres, for each joint that moves, from the root on.
    pub fn poses(&self, angles: &[f64]) -> Result<Vec<Pose>, PoseError> {
        let mut poses = vec![Pose::IDENTITY; self.links.len()];
        for Moved {
            joint,
            parent,
            child,
            angle,
        } in &self.joints
        {
            let axis = DVec3::from_array(joint.axis.xyz.0).normalize_or_zero();
            let by = angle.map_or(0.0, |at| angles[at]);
            let moved = match joint.joint_type {
                JointType::Prismatic => Pose::new(DMat3::IDENTITY, by * axis)?,
                _ if axis == DVec3::ZERO => Pose::IDENTITY,
                _ => Pose::new(DMat3::from_axis_angle(axis, by), DVec3::ZERO)?,
            };
            poses[*child] = poses[*parent]
                .compose(&origin(&joint.origin)?)?
                .compose(&moved)?;
        }
        Ok(poses)
    }

    /// Angles of the joints that move, from the root on: how many.
    pub fn freedom(&self) -> usize {
        self.joints
            .iter()
            .filter(|moved| moved.angle.is_some())
            .count()
    }

    /// No point of a link moves farther than this, relative to any other link, while the angles change by `step` (each by no
    /// more): the sum over the joints of what each may move, which is its step times the reach of all that hangs on it.
    pub fn farthest(&self, step: &[f64]) -> f64 {
        // How far a link reaches from the joint that holds it, with all that hangs on it.
        let mut reach: Vec<f64> = self.links.iter().map(|link| radius(&link.tree)).collect();
        let mut sum = 0.0;
        for Moved {
            joint,
            parent,
            child,
            angle,
        } in self.joints.iter().rev()
        {
            let by = angle.map_or(0.0, |at| step[at].abs());
            let slides = joint.joint_type == JointType::Prismatic;
            sum += by * if slides { 1.0 } else { reach[*child] };
            let slide = if slides {
                joint.limit.upper.abs().max(joint.limit.lower.abs())
            } else {
                0.0
            };
            let from_parent =
                DVec3::from_array(joint.origin.xyz.0).length() + slide + reach[*child];
            reach[*parent] = reach[*parent].max(from_parent);
        }
        sum
    }
}

/// The distance of the farthest corner from the origin of the frame.
fn radius(tree: &Tree) -> f64 {
    (0..tree.mesh().vertex_count())
        .map(|i| tree.mesh().vertex(i).length())
        .fold(0.0, f64::max)
}

/// The collision geometry of a link as one tree.
fn tree(link: &urdf_rs::Link, folder: &Path) -> Result<Tree, Box<dyn Error>> {
    let mut surface = Surface::default();
    for part in &link.collision {
        surface.add(
            &Surface::new(&part.geometry, folder)?,
            &origin(&part.origin)?,
        );
    }
    Ok(Tree::new(surface.mesh()?))
}

/// URDF turns about x, then y, then z, all fixed.
fn origin(pose: &urdf_rs::Pose) -> Result<Pose, PoseError> {
    let [roll, pitch, yaw] = pose.rpy.0;
    let turn =
        DMat3::from_rotation_z(yaw) * DMat3::from_rotation_y(pitch) * DMat3::from_rotation_x(roll);
    Pose::new(turn, pose.xyz.0)
}

/// The joints by numbers of links, parents first.
fn sorted(mut joints: Vec<Joint>, links: &[Link]) -> Result<Vec<Moved>, String> {
    let number = |name: &str, joint: &Joint| {
        let at = links.iter().position(|link| link.name == name);
        at.ok_or_else(|| format!("joint {}: there is no link {name}", joint.name))
    };
    // No joint is left to move these.
    let is_placed = |link: &str, left: &[Joint]| !left.iter().any(|joint| joint.child.link == link);
    let (mut sorted, mut angles) = (Vec::new(), 0..);
    while !joints.is_empty() {
        let next = joints
            .iter()
            .position(|joint| is_placed(&joint.parent.link, &joints));
        let joint = joints.remove(next.ok_or("the joints go round in a circle")?);
        let (parent, child) = (
            number(&joint.parent.link, &joint)?,
            number(&joint.child.link, &joint)?,
        );
        let angle = match joint.joint_type {
            JointType::Fixed => None,
            JointType::Revolute | JointType::Continuous | JointType::Prismatic => angles.next(),
            _ => {
                return Err(format!(
                    "joint {}: only fixed, revolute, continuous and prismatic ones are moved",
                    joint.name
                ));
            }
        };
        sorted.push(Moved {
            joint,
            parent,
            child,
            angle,
        });
    }
    Ok(sorted)
}

/// All pairs of links that may meet. Those that a fixed joint holds together count as one, and neighbours touch where they are
/// joined.
fn pairs(links: usize, joints: &[Moved]) -> Vec<[usize; 2]> {
    let mut groups: Vec<usize> = (0..links).collect();
    for joint in joints.iter().filter(|joint| joint.angle.is_none()) {
        groups[joint.child] = groups[joint.parent];
    }
    let neighbours: Vec<[usize; 2]> = joints
        .iter()
        .map(|joint| [groups[joint.parent], groups[joint.child]])
        .collect();
    let may_meet = |&[i, j]: &[usize; 2]| {
        let [x, y] = [groups[i], groups[j]];
        x != y && !neighbours.contains(&[x, y]) && !neighbours.contains(&[y, x])
    };
    (0..links)
        .flat_map(|j| (0..j).map(move |i| [i, j]))
        .filter(may_meet)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;
    use std::fs;

    fn arm() -> Robot {
        Robot::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/robot/arm.urdf")).unwrap()
    }

    #[test]
    fn links_are_where_the_joints_bring_them() {
        let arm = arm();
        assert_eq!((arm.links.len(), arm.freedom()), (6, 4));
        for (angles, hand) in [
            ([0.0; 4], DVec3::new(0.0, 0.0, 1.07)),
            ([0.0, FRAC_PI_2, 0.0, 0.0], DVec3::new(0.81, 0.0, 0.26)),
            (
                [FRAC_PI_2, FRAC_PI_2, -FRAC_PI_2, 2.0],
                DVec3::new(0.0, 0.4, 0.67),
            ),
        ] {
            let pose = arm.poses(&angles).unwrap()[5];
            assert!(
                (pose.translation() - hand).length() < 1e-12,
                "{angles:?}: {}",
                pose.translation()
            );
        }
    }

    #[test]
    fn nothing_moves_farther_than_the_bound() {
        let (arm, mut random) = (arm(), oorandom::Rand64::new(7));
        let mut closest: f64 = 0.0;
        for _ in 0..200 {
            let angles: [f64; 4] = std::array::from_fn(|_| 4.0 * random.rand_float() - 2.0);
            let step: [f64; 4] = std::array::from_fn(|_| 0.1 * random.rand_float());
            let after: [f64; 4] = std::array::from_fn(|i| angles[i] + step[i]);
            let poses = [angles, after].map(|angles| arm.poses(&angles).unwrap());
            for (at, link) in arm.links.iter().enumerate() {
                let mesh = link.tree.mesh();
                for point in (0..mesh.vertex_count()).map(|i| mesh.vertex(i)) {
                    let way = poses[0][at]
                        .transform_point(point)
                        .distance(poses[1][at].transform_point(point));
                    closest = closest.max(way / arm.farthest(&step));
                }
            }
        }
        assert!(0.5 < closest && closest <= 1.0, "{closest}");
    }

    #[test]
    fn neighbours_are_not_compared() {
        let arm = arm();
        let number = |name: &str| arm.links.iter().position(|link| link.name == name).unwrap();
        let may_meet = |a: &str, b: &str| {
            let pair = [number(a), number(b)];
            arm.pairs
                .contains(&[pair[0].min(pair[1]), pair[0].max(pair[1])])
        };
        assert!(
            may_meet("base", "forearm")
                && may_meet("upper_arm", "tool")
                && may_meet("tool", "base")
        );
        for [a, b] in [
            ["base", "shoulder"],
            ["wrist", "tool"],
            ["forearm", "wrist"],
            ["forearm", "tool"],
        ] {
            assert!(!may_meet(a, b), "{a} and {b}");
        }
    }

    #[test]
    fn what_is_wrong_with_a_file_is_named() {
        let file = std::env::temp_dir().join(format!("punctual-robot-{}.urdf", std::process::id()));
        let sphere = r#"<collision><geometry><sphere radius="1"/></geometry></collision>"#;
        let ball = format!(r#"<link name="ball">{sphere}</link>"#);
        let mesh = r#"<link name="hand"><collision><geometry><mesh filename="none.stl"/></geometry></collision></link>"#;
        let joint = |name: &str, kind: &str, child: &str| {
            format!(
                r#"<joint name="{name}" type="{kind}"><parent link="ball"/><child link="{child}"/></joint>"#
            )
        };
        for (inside, words) in [
            (mesh.to_owned(), ["link hand", "none.stl"]),
            (
                format!("{ball}{}", joint("knee", "fixed", "foot")),
                ["joint knee", "no link foot"],
            ),
            (
                format!("{ball}{ball}{}", joint("slide", "planar", "ball")),
                ["joints", "circle"],
            ),
            ("<link>".to_owned(), ["punctual-robot", "urdf"]),
        ] {
            fs::write(&file, format!(r#"<robot name="r">{inside}</robot>"#)).unwrap();
            let error = Robot::load(&file)
                .err()
                .map(|error| error.to_string())
                .unwrap_or_default();
            assert!(words.iter().all(|word| error.contains(word)), "{error}");
        }
        fs::remove_file(&file).unwrap();
    }
}
