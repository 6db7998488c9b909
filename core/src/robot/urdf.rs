//! URDF: the tree of links and joints, strictly read.
//!
//! Numbers must be numbers, names must exist and be unique, the joints must form one tree. What only costs a picture
//! (a missing mesh, an unknown colour) becomes a note. `<capsule radius length>` is read as a shape, and
//! `<limit … acceleration="…" jerk="…"/>` is ours; without it a joint takes one second to its top speed and a tenth of
//! a second to its acceleration.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::{Isometry3, Unit, Vector3};
use roxmltree::Node;

use super::mesh_file::read_mesh;
use super::tree::{JointDraft, order_tree};
use super::{
    CollisionBody, Geometry, JointKind, JointLimit, Link, Material, Robot, RobotError, Visual, error::MAX_LINKS, xml,
};
use crate::loaded::Loaded;
use crate::mesh::Mesh;

/// Seconds from rest to top speed where a limit names no acceleration. Crichton's own controller took 0.75 s.
pub const DEFAULT_SECONDS_TO_TOP_SPEED: f64 = 1.0;

/// Seconds from rest to the acceleration limit where a limit names no jerk: short beside any motion, long beside the
/// millisecond cycles of drives.
pub const DEFAULT_SECONDS_TO_ACCELERATION: f64 = 0.1;

/// Where no speed is given (fixed and lenient files), rad/s or m/s.
const DEFAULT_VELOCITY: f64 = 1.0;

/// Gives the bytes of a file that the URDF names, such as `package://endcomfort/robots/meshes/palm_joint.obj`.
pub type Resolve<'a> = dyn Fn(&str) -> Option<Vec<u8>> + 'a;

/// A body that is left out because its mesh could not be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MissingMesh {
    /// Link that it belongs to.
    pub link: String,
    /// Whether it would be drawn; else it would collide.
    pub is_visual: bool,
    /// The file as the URDF names it.
    pub file: String,
}

/// Reads a URDF; arms, hands and postures stay empty until the SRDF is applied ([`super::load_robot`]).
///
/// # Errors
/// [`RobotError`], with the line of whatever makes the tree unusable.
pub fn read_urdf(urdf: &str, resolve: &Resolve<'_>) -> Result<Loaded<Robot>, RobotError> {
    Ok(read_urdf_and_missing(urdf, resolve)?.0)
}

/// As [`read_urdf`], with the bodies that are left out because their meshes could not be read.
///
/// # Errors
/// As [`read_urdf`].
pub fn read_urdf_and_missing(
    urdf: &str,
    resolve: &Resolve<'_>,
) -> Result<(Loaded<Robot>, Vec<MissingMesh>), RobotError> {
    let document = xml::parse("URDF", urdf)?;
    let root = document.root_element();
    let mut reader =
        Reader { resolve, materials: BTreeMap::new(), meshes: BTreeMap::new(), notes: Vec::new(), missing: Vec::new() };
    for material in xml::children(root, "material") {
        reader.define_material(material)?;
    }

    let found = xml::children(root, "link").count();
    if found > MAX_LINKS {
        return Err(RobotError::TooManyLinks { found, limit: MAX_LINKS });
    }
    let mut links = Vec::with_capacity(found);
    let mut link_lines = BTreeMap::new();
    for node in xml::children(root, "link") {
        let link = reader.link(node)?;
        remember("link", &link.name, node, &mut link_lines)?;
        links.push((link, xml::line(node)));
    }
    let mut joint_lines = BTreeMap::new();
    let mut drafts = Vec::new();
    for node in xml::children(root, "joint") {
        let draft = joint(node)?;
        remember("joint", &draft.name, node, &mut joint_lines)?;
        drafts.push(draft);
    }

    let (links, joints, dof_joints) = order_tree(links, drafts)?;
    let name = root.attribute("name").unwrap_or("robot").to_owned();
    let robot = Robot {
        name,
        links,
        joints,
        dof_joints,
        arms: Vec::new(),
        postures: Vec::new(),
        allowed_collisions: Vec::new(),
    };
    Ok((Loaded { value: robot, notes: reader.notes }, reader.missing))
}

/// Notes the line of a name and refuses its second use.
pub(super) fn remember(
    kind: &'static str,
    name: &str,
    node: Node<'_, '_>,
    lines: &mut BTreeMap<String, u32>,
) -> Result<(), RobotError> {
    let line = xml::line(node);
    match lines.insert(name.to_owned(), line) {
        None => Ok(()),
        Some(first_line) => Err(RobotError::DuplicateName { line, kind, name: name.to_owned(), first_line }),
    }
}

struct Reader<'r> {
    resolve: &'r Resolve<'r>,
    materials: BTreeMap<String, Material>,
    /// Meshes read so far, by name and scale; `None` where one could not be read.
    meshes: BTreeMap<String, Option<Arc<Mesh>>>,
    notes: Vec<String>,
    missing: Vec<MissingMesh>,
}

impl Reader<'_> {
    fn define_material(&mut self, node: Node<'_, '_>) -> Result<Option<Material>, RobotError> {
        let name = node.attribute("name").unwrap_or_default().trim().to_owned();
        let thing = format!("material {name:?}");
        let Some(color) = xml::child(node, "color") else { return Ok(None) };
        let Some(rgba) = xml::numbers::<4>(color, "rgba", &thing)? else {
            return Err(RobotError::Missing { line: xml::line(color), thing, wanted: "rgba=\"…\"".to_owned() });
        };
        if rgba.iter().any(|value| !(0.0..=1.0).contains(value)) {
            return Err(xml::bad(color, "rgba", &thing, "four numbers from 0 to 1"));
        }
        let material = Material { name: name.clone(), rgba: rgba.map(|value| value as f32) };
        if !name.is_empty() {
            self.materials.entry(name).or_insert_with(|| material.clone());
        }
        Ok(Some(material))
    }

    fn material(&mut self, visual: Node<'_, '_>, thing: &str) -> Result<Material, RobotError> {
        let plain = |name: &str| Material { name: name.to_owned(), rgba: [0.7, 0.7, 0.7, 1.0] };
        let Some(node) = xml::child(visual, "material") else { return Ok(plain("")) };
        if let Some(inline) = self.define_material(node)? {
            return Ok(inline);
        }
        let name = xml::text(node, "name", thing)?;
        Ok(self.materials.get(name).cloned().unwrap_or_else(|| {
            self.notes.push(format!("line {}: {thing}: material {name:?} has no colour, drawn grey", xml::line(node)));
            plain(name)
        }))
    }

    fn link(&mut self, node: Node<'_, '_>) -> Result<Link, RobotError> {
        let name = xml::text(node, "name", "link")?.to_owned();
        let thing = format!("link {name:?}");
        let mut visuals = Vec::new();
        for visual in xml::children(node, "visual") {
            let material = self.material(visual, &thing)?;
            match self.body(visual, &thing)? {
                Some((X_LV, geometry)) => visuals.push(Visual { X_LV, geometry, material }),
                None => self.miss(visual, &name, true),
            }
        }
        let mut collisions = Vec::new();
        for collision in xml::children(node, "collision") {
            match self.body(collision, &thing)? {
                Some((X_LC, geometry)) => collisions.push(CollisionBody { X_LC, geometry }),
                None => self.miss(collision, &name, false),
            }
        }
        Ok(Link { name, visuals, collisions })
    }

    /// Remembers a body that is left out.
    fn miss(&mut self, body: Node<'_, '_>, link: &str, is_visual: bool) {
        let mesh = xml::child(body, "geometry").and_then(|geometry| xml::child(geometry, "mesh"));
        let file = mesh.and_then(|mesh| mesh.attribute("filename")).unwrap_or_default().trim().to_owned();
        self.missing.push(MissingMesh { link: link.to_owned(), is_visual, file });
    }

    /// Pose and shape of a visual or collision; `None` when its mesh is left out.
    fn body(&mut self, node: Node<'_, '_>, thing: &str) -> Result<Option<(Isometry3<f64>, Geometry)>, RobotError> {
        let X_LB = xml::origin(node, thing)?;
        let missing = |wanted: &str| RobotError::Missing {
            line: xml::line(node),
            thing: format!("{} of {thing}", node.tag_name().name()),
            wanted: wanted.to_owned(),
        };
        let geometry = xml::child(node, "geometry").ok_or_else(|| missing("<geometry>"))?;
        let shapes = "<box>, <cylinder>, <sphere>, <capsule> or <mesh>";
        let shape = geometry.children().find(|child| child.is_element()).ok_or_else(|| missing(shapes))?;
        let geometry = match shape.tag_name().name() {
            "box" => {
                let Some(size) = xml::numbers::<3>(shape, "size", thing)? else { return Err(missing("box size")) };
                if size.iter().any(|&edge| edge <= 0.0) {
                    return Err(xml::bad(shape, "size", thing, "three numbers greater than 0"));
                }
                Geometry::Box { size_m: size.into() }
            }
            "sphere" => Geometry::Sphere { radius_m: xml::positive(shape, "radius", thing)? },
            "cylinder" => Geometry::Cylinder {
                radius_m: xml::positive(shape, "radius", thing)?,
                length_m: xml::positive(shape, "length", thing)?,
            },
            "capsule" => Geometry::Capsule {
                radius_m: xml::positive(shape, "radius", thing)?,
                length_m: xml::positive(shape, "length", thing)?,
            },
            "mesh" => match self.mesh(shape, thing)? {
                Some(geometry) => geometry,
                None => return Ok(None),
            },
            _ => return Err(missing(shapes)),
        };
        Ok(Some((X_LB, geometry)))
    }

    fn mesh(&mut self, node: Node<'_, '_>, thing: &str) -> Result<Option<Geometry>, RobotError> {
        let file = xml::text(node, "filename", thing)?;
        let scale = Vector3::from(xml::numbers::<3>(node, "scale", thing)?.unwrap_or([1.0; 3]));
        if scale.iter().any(|&factor| factor == 0.0) {
            return Err(xml::bad(node, "scale", thing, "three numbers other than 0"));
        }
        let key = format!("{file}|{scale:?}");
        let mesh = if let Some(known) = self.meshes.get(&key) {
            known.clone()
        } else {
            let read = match (self.resolve)(file) {
                None => Err("it was not found".to_owned()),
                Some(bytes) => read_mesh(file, &bytes, scale),
            };
            let mesh = match read {
                Ok(mesh) => Some(Arc::new(mesh)),
                Err(reason) => {
                    self.notes.push(format!("line {}: {thing}: mesh {file} is left out: {reason}", xml::line(node)));
                    None
                }
            };
            self.meshes.insert(key, mesh.clone());
            mesh
        };
        Ok(mesh.map(|mesh| Geometry::Mesh { file: file.to_owned(), mesh }))
    }
}

fn joint(node: Node<'_, '_>) -> Result<JointDraft, RobotError> {
    let line = xml::line(node);
    let name = xml::text(node, "name", "joint")?.to_owned();
    let thing = format!("joint {name:?}");
    let end = |which: &'static str| -> Result<String, RobotError> {
        let missing = || RobotError::Missing { line, thing: thing.clone(), wanted: format!("<{which} link=\"…\"/>") };
        let end = xml::child(node, which).ok_or_else(missing)?;
        Ok(xml::text(end, "link", &format!("<{which}> of {thing}"))?.to_owned())
    };
    let (parent, child) = (end("parent")?, end("child")?);
    let (kind, continuous) = match xml::text(node, "type", &thing)? {
        "fixed" => (JointKind::Fixed, false),
        "revolute" => (JointKind::Revolute, false),
        "continuous" => (JointKind::Revolute, true),
        "prismatic" => (JointKind::Prismatic, false),
        found => return Err(RobotError::UnknownJointType { line, joint: name, found: found.to_owned() }),
    };
    let axis = match xml::child(node, "axis") {
        Some(axis) => xml::numbers::<3>(axis, "xyz", &thing)?.unwrap_or([1.0, 0.0, 0.0]),
        None => [1.0, 0.0, 0.0],
    };
    let axis = match Unit::try_new(Vector3::from(axis), 1e-9) {
        Some(unit) => unit,
        None if kind == JointKind::Fixed => Vector3::x_axis(),
        None => return Err(RobotError::ZeroAxis { line, joint: name, found: axis }),
    };
    let limit = limit(node, &name, kind, continuous)?;
    let mimic = match xml::child(node, "mimic") {
        None => None,
        Some(mimic) => Some((
            xml::text(mimic, "joint", &format!("<mimic> of {thing}"))?.to_owned(),
            xml::number(mimic, "multiplier", &thing)?.unwrap_or(1.0),
            xml::number(mimic, "offset", &thing)?.unwrap_or(0.0),
        )),
    };
    Ok(JointDraft { line, X_PJ: xml::origin(node, &thing)?, name, kind, parent, child, axis, limit, mimic })
}

fn limit(joint: Node<'_, '_>, name: &str, kind: JointKind, continuous: bool) -> Result<JointLimit, RobotError> {
    let thing = format!("joint {name:?}");
    let whole_turn = JointLimit {
        lower: -std::f64::consts::PI,
        upper: std::f64::consts::PI,
        velocity: DEFAULT_VELOCITY,
        acceleration: DEFAULT_VELOCITY / DEFAULT_SECONDS_TO_TOP_SPEED,
        jerk: DEFAULT_VELOCITY / DEFAULT_SECONDS_TO_TOP_SPEED / DEFAULT_SECONDS_TO_ACCELERATION,
    };
    let Some(node) = xml::child(joint, "limit") else {
        if kind == JointKind::Fixed || continuous {
            return Ok(whole_turn);
        }
        return Err(RobotError::Missing {
            line: xml::line(joint),
            thing,
            wanted: "<limit lower upper velocity>".into(),
        });
    };
    // URDF: absent bounds are 0, an absent speed is unlimited, which a planner cannot use.
    let (lower, upper) = if continuous {
        (whole_turn.lower, whole_turn.upper)
    } else {
        (xml::number(node, "lower", &thing)?.unwrap_or(0.0), xml::number(node, "upper", &thing)?.unwrap_or(0.0))
    };
    if lower > upper {
        return Err(RobotError::ReversedLimit { line: xml::line(node), joint: name.to_owned(), lower, upper });
    }
    let optional = |attribute, default| match node.attribute(attribute) {
        Some(_) => xml::positive(node, attribute, &thing),
        None => Ok(default),
    };
    xml::number(node, "effort", &thing)?;
    let velocity = optional("velocity", DEFAULT_VELOCITY)?;
    let acceleration = optional("acceleration", velocity / DEFAULT_SECONDS_TO_TOP_SPEED)?;
    let jerk = optional("jerk", acceleration / DEFAULT_SECONDS_TO_ACCELERATION)?;
    Ok(JointLimit { lower, upper, velocity, acceleration, jerk })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(body: &str) -> Result<Loaded<Robot>, RobotError> {
        read_urdf(&format!("<robot name='t'>\n{body}\n</robot>"), &|_| None)
    }

    const LIMIT: &str = "<limit lower='-1' upper='1' velocity='2'/>";

    fn hinge(name: &str, parent: &str, child: &str, inside: &str) -> String {
        format!(
            "<joint name='{name}' type='revolute'><parent link='{parent}'/><child link='{child}'/>{inside}</joint>\n"
        )
    }

    fn links(names: &str) -> String {
        names.split(' ').map(|name| format!("<link name='{name}'/>\n")).collect()
    }

    #[test]
    fn children_written_first_still_come_after_their_parents() {
        let text = hinge("two", "b", "c", LIMIT) + &hinge("one", "a", "b", LIMIT) + &links("c b a");
        let robot = read(&text).unwrap().value;
        let names: Vec<_> = robot.links.iter().map(|link| link.name.as_str()).collect();
        assert_eq!(names, ["a", "b", "c"]);
        for (i, joint) in robot.joints.iter().enumerate() {
            assert!(joint.child == i + 1 && joint.parent < joint.child);
        }
        assert_eq!(robot.joints[0].limit.acceleration, 2.0, "one second to the top speed");
    }

    #[test]
    fn limits_that_are_not_named_follow_from_those_that_are() {
        let limit = |attributes: &str| {
            let text = links("a b") + &hinge("j", "a", "b", &format!("<limit lower='-1' upper='1' {attributes}/>"));
            let limit = read(&text).unwrap().value.joints[0].limit;
            (limit.velocity, limit.acceleration, limit.jerk)
        };
        assert_eq!(limit("velocity='2'"), (2.0, 2.0, 20.0));
        assert_eq!(limit("velocity='2' acceleration='4'"), (2.0, 4.0, 40.0));
        assert_eq!(limit("velocity='2' acceleration='4' jerk='5'"), (2.0, 4.0, 5.0));
        let text = links("a b") + &hinge("j", "a", "b", "<limit lower='-1' upper='1' jerk='0'/>");
        assert!(read(&text).unwrap_err().to_string().contains("jerk=\"0\", wanted a number greater than 0"));
    }

    #[test]
    fn a_loop_is_named_link_by_link() {
        let text = links("root a b") + &hinge("up", "a", "b", LIMIT) + &hinge("back", "b", "a", LIMIT);
        match read(&text).unwrap_err() {
            RobotError::Cycle { line, joint, links } => {
                assert_eq!((line, joint.as_str()), (6, "back"));
                assert_eq!(links, ["a", "b", "a"]);
            }
            other => panic!("{other}"),
        }
    }

    #[test]
    fn every_fault_is_named_with_its_line() {
        let chain = links("a b");
        let mimic = |master: &str| format!("{LIMIT}<mimic joint='{master}'/>");
        let cases = [
            (links("a b"), "line 3: link \"b\" has no parent, but \"a\" is the root already"),
            (links("a a"), "line 3: link \"a\" is defined a second time (first on line 2)"),
            (
                chain.clone() + &hinge("j", "x", "b", LIMIT),
                "line 4: joint \"j\" names link \"x\", which does not exist",
            ),
            (
                chain.clone() + &hinge("j", "a", "b", "<limit lower='2' upper='1' velocity='1'/>"),
                "line 4: joint \"j\": lower limit 2 is above upper limit 1",
            ),
            (
                chain.clone() + &hinge("j", "a", "b", "<limit lower='NaN' upper='1'/>"),
                "line 4: joint \"j\": lower=\"NaN\", wanted one finite number",
            ),
            (
                chain.clone() + &hinge("j", "a", "b", "<limit lower='0' upper='1' velocity='0'/>"),
                "line 4: joint \"j\": velocity=\"0\", wanted a number greater than 0",
            ),
            (
                chain.clone() + &hinge("j", "a", "b", "<origin xyz='0 1,5 0'/>"),
                "line 4: joint \"j\" has no <limit lower upper velocity>",
            ),
            (
                chain.clone() + &hinge("j", "a", "b", &format!("{LIMIT}<origin xyz='0 1,5 0'/>")),
                "line 4: joint \"j\": xyz=\"0 1,5 0\", wanted three finite numbers",
            ),
            (
                chain.clone() + &hinge("j", "a", "b", &format!("{LIMIT}<axis xyz='0 0 0'/>")),
                "line 4: joint \"j\": axis [0.0, 0.0, 0.0] has no direction, wanted a vector longer than 1e-9",
            ),
            (
                chain.clone() + &hinge("j", "a", "b", &mimic("k")),
                "line 4: joint \"j\" mimics \"k\", which does not exist",
            ),
            (
                chain.clone() + &hinge("j", "a", "b", &mimic("j")),
                "line 4: joint \"j\" mimics \"j\", which leads back to itself",
            ),
            (
                links("a b c") + &hinge("j", "a", "c", LIMIT) + &hinge("k", "b", "c", LIMIT),
                "line 6: link \"c\" is moved by joint \"k\" and already by joint \"j\"",
            ),
            (
                chain + "<joint name='j' type='floating'><parent link='a'/><child link='b'/></joint>",
                "line 4: joint \"j\" has type \"floating\", wanted fixed, revolute, continuous or prismatic",
            ),
            (
                "<link name='a'><collision><geometry><sphere radius='-1'/></geometry></collision></link>".to_owned(),
                "line 2: link \"a\": radius=\"-1\", wanted a number greater than 0",
            ),
            (String::new(), "the robot has no links"),
            (links(&vec!["x"; MAX_LINKS + 1].join(" ")), "the robot has 1001 links, at most 1000 are read (MAX_LINKS)"),
        ];
        for (body, wanted) in cases {
            assert_eq!(read(&body).map(|_| ()).unwrap_err().to_string(), wanted);
        }
    }

    #[test]
    fn a_missing_mesh_costs_one_visual_and_leaves_a_note() {
        let text = "<link name='a'><visual><geometry><mesh filename='no.obj'/></geometry></visual>\
                    <visual><geometry><box size='1 1 1'/></geometry><material name='m'/></visual></link>";
        let loaded = read(text).unwrap();
        assert_eq!(loaded.value.links[0].visuals.len(), 1);
        assert!(loaded.notes[0].contains("no.obj is left out: it was not found"), "{:?}", loaded.notes);
        assert!(loaded.notes[1].contains("material \"m\" has no colour"), "{:?}", loaded.notes);
    }

    #[test]
    fn mimics_of_mimics_follow_the_joint_that_moves() {
        let text = links("a b c d")
            + &hinge("one", "a", "b", LIMIT)
            + &hinge("two", "b", "c", &format!("{LIMIT}<mimic joint='one' multiplier='2' offset='0.5'/>"))
            + &hinge("three", "c", "d", &format!("{LIMIT}<mimic joint='two' multiplier='-1' offset='0.1'/>"));
        let robot = read(&text).unwrap().value;
        assert_eq!(robot.dof_count(), 1);
        assert!((robot.joint_position(&robot.joints[2], &[0.3]) - (-(2.0 * 0.3 + 0.5) + 0.1)).abs() < 1e-12);
    }
}
