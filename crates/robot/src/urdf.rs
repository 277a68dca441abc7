//! Robots from URDF and SRDF files.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use punctual::Mesh;
use punctual::glam::DVec3;
use roxmltree::{Document, Node};

use crate::model::{Description, Joint, JointKind, LARGEST, Link, Mimic, Model};
use crate::transform::Transform;
use crate::{RobotError, Shape};

/// What belongs to a URDF file.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct UrdfOptions {
    /// The SRDF file, whose pairs of links are not asked. Without it, links that are joined by one
    /// moving joint are not asked.
    pub srdf: Option<PathBuf>,
    /// Folders in which packages are sought: `package://arm/hand.stl` is `FOLDER/arm/hand.stl`, or
    /// `FOLDER/hand.stl` if the folder is named `arm`. The folders above the URDF file follow.
    pub packages: Vec<PathBuf>,
}

impl UrdfOptions {
    /// The same with an SRDF file.
    #[must_use]
    pub fn srdf(self, file: impl Into<PathBuf>) -> Self {
        let srdf = Some(file.into());
        Self { srdf, ..self }
    }

    /// The same with one more folder of packages.
    #[must_use]
    pub fn packages(mut self, folder: impl Into<PathBuf>) -> Self {
        self.packages.push(folder.into());
        self
    }
}

impl Model {
    /// Reads a robot from a URDF file: the collision shapes, not the visual ones.
    ///
    /// # Errors
    /// [`RobotError::File`], which names the file, the line, and the link or joint: files that
    /// cannot be read, meshes of other formats than STL, OBJ, PLY, OFF and glTF, joints that are
    /// floating or planar, and the errors of [`Model::new`].
    pub fn from_urdf(file: impl AsRef<Path>, options: &UrdfOptions) -> Result<Self, RobotError> {
        let file = file.as_ref();
        let text = read(file)?;
        let document = parse(&text, file)?;
        let reader = Reader::new(file, &document);
        let mut description = reader.robot(options)?;
        description.allows_neighbours = options.srdf.is_none();
        let notices = match &options.srdf {
            Some(srdf) => allow(srdf, &mut description)?,
            None => Vec::new(),
        };
        let mut model = Self::new(&description).map_err(|error| error.within(file, None))?;
        model.notices = notices;
        Ok(model)
    }
}

struct Reader<'d> {
    file: &'d Path,
    document: &'d Document<'d>,
}

impl<'d> Reader<'d> {
    fn new(file: &'d Path, document: &'d Document<'d>) -> Self {
        Self { file, document }
    }

    fn fail<T>(&self, node: Node<'_, '_>, what: impl Into<String>) -> Result<T, RobotError> {
        let line = self.document.text_pos_at(node.range().start).row;
        Err(RobotError::file(self.file, Some(line), what))
    }

    fn root(&self) -> Result<Node<'d, 'd>, RobotError> {
        let root = self.document.root_element();
        if root.tag_name().name() != "robot" {
            return self.fail(root, "the outermost element is not `robot`");
        }
        Ok(root)
    }

    fn robot(&self, options: &UrdfOptions) -> Result<Description, RobotError> {
        let root = self.root()?;
        let is_macro = |node: &Node<'_, '_>| {
            let space = node.tag_name().namespace();
            space.is_some_and(|space| space.contains("xacro"))
        };
        if let Some(node) = root.descendants().find(is_macro) {
            return self.fail(node, "a xacro file; `xacro FILE` expands it to URDF");
        }
        let mut robot = Description {
            name: root.attribute("name").unwrap_or("").to_owned(),
            ..Description::default()
        };
        let mut meshes = Meshes {
            folder: self.file.parent().unwrap_or(Path::new("")),
            packages: &options.packages,
            read: HashMap::new(),
        };
        for node in elements(root) {
            match node.tag_name().name() {
                "link" => robot.links.push(self.link(node, &mut meshes)?),
                "joint" => robot.joints.push(self.joint(node)?),
                _ => {}
            }
        }
        Ok(robot)
    }

    fn link(&self, node: Node<'d, 'd>, meshes: &mut Meshes<'_>) -> Result<Link, RobotError> {
        let name = self.attribute(node, "name", "a link")?.to_owned();
        let of = format!("link {name}");
        let mut shapes = Vec::new();
        for collision in elements(node).filter(|node| node.has_tag_name("collision")) {
            let geometry = child(collision, "geometry");
            let Some(node) = geometry.and_then(|node| node.first_element_child()) else {
                return self.fail(collision, format!("{of}: a collision without geometry"));
            };
            let shape = self.shape(node, &of, meshes)?;
            shapes.push((self.origin(collision, &of)?.pose(), shape));
        }
        Ok(Link { name, shapes })
    }

    fn shape(
        &self,
        node: Node<'d, 'd>,
        of: &str,
        meshes: &mut Meshes<'_>,
    ) -> Result<Shape, RobotError> {
        let number = |name: &str| {
            let [number] = self.numbers(node, name, of, None)?;
            Ok::<_, RobotError>(number)
        };
        let shape = match node.tag_name().name() {
            "box" => Shape::cuboid(self.numbers(node, "size", of, None)?),
            "sphere" => Shape::sphere(number("radius")?),
            "cylinder" => Shape::cylinder(number("radius")?, number("length")?),
            "mesh" => {
                let name = self.attribute(node, "filename", of)?;
                let scale = self.numbers(node, "scale", of, Some([1.0; 3]))?;
                meshes.shape(name, scale)
            }
            other => Err(RobotError::model(format!(
                "a shape of the kind `{other}`, known are box, sphere, cylinder and mesh"
            ))),
        };
        let line = self.document.text_pos_at(node.range().start).row;
        shape.map_err(|error| RobotError::file(self.file, Some(line), format!("{of}: {error}")))
    }

    fn joint(&self, node: Node<'d, 'd>) -> Result<Joint, RobotError> {
        let name = self.attribute(node, "name", "a joint")?.to_owned();
        let of = format!("joint {name}");
        let kind = match self.attribute(node, "type", &of)? {
            "fixed" => JointKind::Fixed,
            "revolute" => JointKind::Revolute,
            "continuous" => JointKind::Continuous,
            "prismatic" => JointKind::Prismatic,
            other => {
                let known = "known are fixed, revolute, continuous and prismatic";
                return self.fail(node, format!("{of}: of the type `{other}`, {known}"));
            }
        };
        let link = |which: &str| match child(node, which) {
            Some(node) => Ok(self.attribute(node, "link", &of)?.to_owned()),
            None => self.fail(node, format!("{of}: no {which}")),
        };
        let axis = match child(node, "axis") {
            Some(node) => self.numbers(node, "xyz", &of, Some([1.0, 0.0, 0.0]))?,
            None => [1.0, 0.0, 0.0],
        };
        let limit = child(node, "limit").filter(|_| kind != JointKind::Continuous);
        let limits = match limit {
            Some(node) => {
                let [lower] = self.numbers(node, "lower", &of, Some([0.0]))?;
                let [upper] = self.numbers(node, "upper", &of, Some([0.0]))?;
                Some([lower, upper])
            }
            None => None,
        };
        let mimic = match child(node, "mimic") {
            Some(node) => {
                let [multiplier] = self.numbers(node, "multiplier", &of, Some([1.0]))?;
                let [offset] = self.numbers(node, "offset", &of, Some([0.0]))?;
                let joint = self.attribute(node, "joint", &of)?.to_owned();
                Some(Mimic {
                    joint,
                    multiplier,
                    offset,
                })
            }
            None => None,
        };
        Ok(Joint {
            kind,
            parent: link("parent")?,
            child: link("child")?,
            origin: self.origin(node, &of)?.pose(),
            axis,
            limits,
            mimic,
            name,
        })
    }

    fn origin(&self, node: Node<'d, 'd>, of: &str) -> Result<Transform, RobotError> {
        let Some(node) = child(node, "origin") else {
            return Ok(Transform::IDENTITY);
        };
        let rpy = self.numbers(node, "rpy", of, Some([0.0; 3]))?;
        let xyz = self.numbers(node, "xyz", of, Some([0.0; 3]))?;
        Ok(Transform::from_rpy(rpy, xyz))
    }

    fn attribute(&self, node: Node<'d, 'd>, name: &str, of: &str) -> Result<&'d str, RobotError> {
        match node.attribute(name) {
            Some(text) => Ok(text.trim()),
            None => {
                let tag = node.tag_name().name();
                self.fail(node, format!("{of}: `{tag}` without `{name}`"))
            }
        }
    }

    /// The numbers of an attribute, or what stands for them where it is missing.
    fn numbers<const N: usize>(
        &self,
        node: Node<'d, 'd>,
        name: &str,
        of: &str,
        missing: Option<[f64; N]>,
    ) -> Result<[f64; N], RobotError> {
        let text = match (node.attribute(name), missing) {
            (None, Some(missing)) => return Ok(missing),
            _ => self.attribute(node, name, of)?,
        };
        let numbers: Result<Vec<f64>, _> = text.split_whitespace().map(str::parse).collect();
        let numbers = numbers.ok().and_then(|numbers| numbers.try_into().ok());
        match numbers.filter(|numbers: &[f64; N]| numbers.iter().all(|x| x.abs() <= LARGEST)) {
            Some(numbers) => Ok(numbers),
            None => self.fail(
                node,
                format!("{of}: `{name}` is \"{text}\", must be {N} numbers of at most {LARGEST:e}"),
            ),
        }
    }
}

/// The mesh files of a robot, each scale of each read once.
struct Meshes<'o> {
    folder: &'o Path,
    packages: &'o [PathBuf],
    read: HashMap<(PathBuf, [u64; 3]), Shape>,
}

impl Meshes<'_> {
    fn shape(&mut self, name: &str, scale: [f64; 3]) -> Result<Shape, RobotError> {
        if scale.contains(&0.0) {
            return Err(RobotError::model(format!("mesh {name}: a scale of 0")));
        }
        let file = self.find(name)?;
        let key = (file, scale.map(f64::to_bits));
        if let Some(shape) = self.read.get(&key) {
            return Ok(shape.clone());
        }
        let extension = key.0.extension().map(|e| e.to_ascii_lowercase());
        if extension.is_some_and(|extension| extension == "dae") {
            return Err(RobotError::model(format!(
                "mesh {}: COLLADA is not read; convert it to STL, OBJ, PLY or glTF",
                key.0.display()
            )));
        }
        let loaded = punctual_io::load(&key.0);
        let mesh = loaded
            .map_err(|error| RobotError::model(error.to_string()))?
            .mesh;
        let mesh = scaled(mesh, scale)?;
        let shape = Shape::mesh(mesh);
        self.read.insert(key, shape.clone());
        Ok(shape)
    }

    /// The file of a name, which may be a URL.
    fn find(&self, name: &str) -> Result<PathBuf, RobotError> {
        let url = name
            .strip_prefix("package://")
            .or(name.strip_prefix("model://"));
        let Some(path) = url else {
            return Ok(self
                .folder
                .join(name.strip_prefix("file://").unwrap_or(name)));
        };
        let (package, rest) = path.split_once('/').unwrap_or(("", path));
        let folder = fs::canonicalize(self.folder).unwrap_or(self.folder.to_owned());
        let above = folder.ancestors().map(Path::to_owned);
        for folder in self.packages.iter().cloned().chain(above) {
            let is_package = folder.file_name().is_some_and(|name| name == package);
            let within = is_package.then(|| folder.join(rest));
            for file in [Some(folder.join(path)), within].into_iter().flatten() {
                if file.is_file() {
                    return Ok(file);
                }
            }
        }
        Err(RobotError::model(format!(
            "mesh {name}: not found in the package folders, nor in those above the URDF file"
        )))
    }
}

/// A mesh with scaled coordinates. A mirrored one has its triangles turned, so that they face
/// outwards again.
fn scaled(mesh: Mesh, scale: [f64; 3]) -> Result<Mesh, RobotError> {
    if scale == [1.0; 3] {
        return Ok(mesh);
    }
    let scale = DVec3::from_array(scale);
    let vertices = (0..mesh.vertex_count()).map(|i| (mesh.vertex(i) * scale).to_array());
    let is_mirrored = scale.x * scale.y * scale.z < 0.0;
    let triangles = mesh.triangles().iter().map(|&[a, b, c]| match is_mirrored {
        true => [a, c, b],
        false => [a, b, c],
    });
    Mesh::from_f64(vertices, triangles).map_err(|error| RobotError::model(error.to_string()))
}

/// Adds the pairs of an SRDF file that are not asked. Returns what was passed over: links that the
/// robot does not have.
fn allow(file: &Path, robot: &mut Description) -> Result<Vec<String>, RobotError> {
    let text = read(file)?;
    let document = parse(&text, file)?;
    let reader = Reader::new(file, &document);
    let mut notices = Vec::new();
    let names: Vec<String> = robot.links.iter().map(|link| link.name.clone()).collect();
    let mut known = |name: &str, node: Node<'_, '_>| {
        let is_known = names.iter().any(|known| known == name);
        if !is_known {
            let line = document.text_pos_at(node.range().start).row;
            notices.push(format!(
                "{}:{line}: there is no link {name}",
                file.display()
            ));
        }
        is_known
    };
    let mut enabled = Vec::new();
    let root = reader.root()?;
    for node in elements(root) {
        let tag = node.tag_name().name();
        match tag {
            "disable_collisions" | "enable_collisions" => {
                let a = reader.attribute(node, "link1", tag)?;
                let b = reader.attribute(node, "link2", tag)?;
                if known(a, node) && known(b, node) {
                    let pair = [a.to_owned(), b.to_owned()];
                    match tag {
                        "disable_collisions" => robot.allowed.push(pair),
                        _ => enabled.push(pair),
                    }
                }
            }
            "disable_default_collisions" => {
                let link = reader.attribute(node, "link", tag)?;
                if known(link, node) {
                    let pairs = names.iter().map(|name| [link.to_owned(), name.clone()]);
                    robot.allowed.extend(pairs);
                }
            }
            _ => {}
        }
    }
    let is_enabled = |[a, b]: &[String; 2]| {
        enabled
            .iter()
            .any(|[x, y]| (a == x && b == y) || (a == y && b == x))
    };
    robot.allowed.retain(|pair| !is_enabled(pair));
    Ok(notices)
}

fn read(file: &Path) -> Result<String, RobotError> {
    fs::read_to_string(file).map_err(|error| RobotError::file(file, None, error.to_string()))
}

fn parse<'t>(text: &'t str, file: &Path) -> Result<Document<'t>, RobotError> {
    Document::parse(text)
        .map_err(|error| RobotError::file(file, Some(error.pos().row), error.to_string()))
}

fn elements<'d>(node: Node<'d, 'd>) -> impl Iterator<Item = Node<'d, 'd>> {
    node.children().filter(Node::is_element)
}

fn child<'d>(node: Node<'d, 'd>, name: &str) -> Option<Node<'d, 'd>> {
    elements(node).find(|node| node.has_tag_name(name))
}
