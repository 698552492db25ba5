//! Models of robots in the types of `urdf-rs`.

use super::limits::limits_of;
use super::reroot::reroot;
use super::shapes::{collision_name, convert_shape, has_no_extent};
use super::tree::{Visit, walk};
use super::{LoadNote, LoadReport, Mimic, UrdfOptions};
use crate::error::{Error, Result, plain};
use crate::model::{Carrier, Collision, Frame, JointKind, JointSpec, Limits, Model};
use crate::spatial::{Inertia, Placement};
use nalgebra::{Matrix3, Rotation3, Vector3};
use urdf_rs::{Dynamics, Joint, JointType, Link, Pose, Robot};

impl TryFrom<&Robot> for Model {
    type Error = Error;

    /// Builds the model as [`build_model`] does with the default options and without its notes. Errors name the robot
    /// in place of a file.
    fn try_from(robot: &Robot) -> Result<Self> {
        let (model, _) = build_model(robot, &robot.name, UrdfOptions::default())?;
        Ok(model)
    }
}

/// Builds the model of a robot that `urdf-rs` has read, or that was made in code; `file` names it in errors.
///
/// Lengths are in m, angles in rad, masses in kg, inertias in kg m^2, forces in N and torques in N m. Links, joints,
/// inertias, limits of position, velocity and effort, and collision elements are kept as
/// [`parse_urdf`](super::parse_urdf) keeps them, damping and friction if [`UrdfOptions::losses`] asks for them. Visual
/// elements, materials, safety controllers and limits of acceleration and jerk are left out, the factor and offset of a
/// mimic joint too.
///
/// Cost O(L log L) for L links and joints, and O(N^3) for the check that the mass matrix is regular.
///
/// # Errors
/// Those of [`parse_urdf`](super::parse_urdf), except for those of its text.
pub fn build_model(robot: &Robot, file: &str, options: UrdfOptions) -> Result<(Model, LoadReport)> {
    let mut builder = Builder {
        file,
        options,
        report: LoadReport::new(),
        specs: Vec::new(),
        base_inertia: Inertia::zero(),
        dynamics: Vec::new(),
        frames: Vec::new(),
        collisions: Vec::new(),
    };
    let root = builder.options.root.as_deref();
    let hung = root.map(|root| reroot(robot, root, file)).transpose()?;
    for visit in walk(hung.as_ref().unwrap_or(robot), file)? {
        builder.visit(&visit)?;
    }
    let drives = match &builder.options.losses {
        Some(losses) => losses.drives(&builder.specs, &builder.dynamics, file)?,
        None => Vec::new(),
    };
    let model = Model::from_joints(&robot.name, builder.specs)
        .map_err(|e| match e {
            Error::Input { element, condition, .. } => Error::input(file, element, condition),
            other => other,
        })?
        .with_base_inertia(builder.base_inertia)
        .with_frames(builder.frames)
        .with_collisions(builder.collisions)?
        .with_drives(drives)?;
    if !builder.options.singular {
        model.check_regular(file)?;
    }
    Ok((model, builder.report))
}

/// The parts built so far.
struct Builder<'a> {
    file: &'a str,
    options: UrdfOptions,
    report: LoadReport,
    specs: Vec<JointSpec<f64>>,
    base_inertia: Inertia<f64>,
    /// The `dynamics` elements of the joints.
    dynamics: Vec<Dynamics>,
    frames: Vec<Frame<f64>>,
    collisions: Vec<Collision>,
}

impl Builder<'_> {
    fn error(&self, element: String, condition: impl Into<String>) -> Error {
        Error::input(self.file, element, condition)
    }

    /// Adds a link and the joint that carries it. Parents are visited before children, so that their frame is known.
    fn visit(&mut self, visit: &Visit<'_>) -> Result<()> {
        let link = visit.link;
        let inertia = self.inertia(link)?;
        let (body, placement) = match visit.joint {
            None => (None, Placement::identity()),
            Some(joint) => {
                let parent = &self.frames[visit.parent];
                let (carrier, in_carrier) = (parent.body, parent.placement);
                let origin = self.pose(&joint.origin, || format!("joint '{}'", joint.name))?;
                let placement = in_carrier.compose(&origin);
                match self.kind(joint)? {
                    None => {
                        self.report.push(LoadNote::Merged {
                            link: link.name.clone(),
                            joint: joint.name.clone(),
                            into: carrier.map(|b| self.specs[b].name.clone()),
                        });
                        (carrier, placement)
                    }
                    Some(kind) => {
                        let spec = JointSpec {
                            name: joint.name.clone(),
                            kind,
                            parent: carrier,
                            origin: placement,
                            axis: self.axis(joint)?,
                            inertia: Inertia::zero(),
                            limits: self.limits(joint, kind)?,
                        };
                        self.add_dynamics(joint);
                        self.specs.push(spec);
                        (Some(self.specs.len() - 1), Placement::identity())
                    }
                }
            }
        };
        let placed = inertia.placed(&placement);
        if !is_finite(&placed) {
            let condition = "its inertia about the joint that moves it is not finite";
            return Err(self.error(format!("link '{}'", link.name), condition));
        }
        let own = body.map_or(&mut self.base_inertia, |body| &mut self.specs[body].inertia);
        *own += placed;
        self.add_collisions(link, body, &placement)?;
        self.frames.push(Frame {
            name: link.name.clone(),
            body,
            placement,
            carrier: visit.joint.map(|joint| Carrier { joint: joint.name.clone(), parent: Some(visit.parent) }),
        });
        Ok(())
    }

    /// Adds the collision elements of a link, which is placed in its body.
    fn add_collisions(&mut self, link: &Link, body: Option<usize>, placement: &Placement<f64>) -> Result<()> {
        for (i, collision) in link.collision.iter().enumerate() {
            let name = collision_name(collision.name.as_deref(), i);
            if has_no_extent(&collision.geometry) {
                self.report.push(LoadNote::NoExtent { link: link.name.clone(), shape: name });
                continue;
            }
            let element = || format!("link '{}': {name}", link.name);
            let shape = convert_shape(&collision.geometry, &self.options.packages);
            self.collisions.push(Collision {
                link: link.name.clone(),
                body,
                placement: placement.compose(&self.pose(&collision.origin, element)?),
                shape: shape.map_err(|condition| self.error(element(), condition))?,
            });
        }
        Ok(())
    }

    /// Adds the damping and friction of a joint, with a note if they are not counted.
    fn add_dynamics(&mut self, joint: &Joint) {
        let dynamics = joint.dynamics.clone().unwrap_or(Dynamics { damping: 0.0, friction: 0.0 });
        for (attribute, value) in [("damping", dynamics.damping), ("friction", dynamics.friction)] {
            if value != 0.0 && self.options.losses.is_none() {
                self.report.push(LoadNote::LeftOut { joint: joint.name.clone(), attribute });
            }
        }
        self.dynamics.push(dynamics);
    }

    /// The inertia of a link in its own frame.
    fn inertia(&mut self, link: &Link) -> Result<Inertia<f64>> {
        let element = format!("link '{}'", link.name);
        let urdf_rs::Inertia { ixx, ixy, ixz, iyy, iyz, izz } = link.inertial.inertia;
        let mass = link.inertial.mass.value;
        let origin = self.pose(&link.inertial.origin, || element.clone())?;
        let numbers = [mass, ixx, ixy, ixz, iyy, iyz, izz];
        if numbers.iter().any(|x| !x.is_finite()) {
            return Err(self.error(element, "its mass or inertia is not a finite number"));
        }
        if mass < 0.0 {
            return Err(self.error(element, format!("its mass is negative: {}", plain(mass))));
        }
        let rotational = Matrix3::new(ixx, ixy, ixz, ixy, iyy, iyz, ixz, iyz, izz);
        let name = || link.name.clone();
        if numbers.iter().all(|x| *x == 0.0) {
            self.report.push(LoadNote::Massless { link: name() });
        } else if let Some(condition) = impossible_inertia(mass, &rotational) {
            self.report.push(LoadNote::ImpossibleInertia { link: name(), condition });
        }
        let turned = origin.rotation * rotational * origin.rotation.transpose();
        Ok(Inertia::from_com(mass, origin.translation, turned))
    }

    /// Converts the pose of an element.
    fn pose(&self, pose: &Pose, element: impl Fn() -> String) -> Result<Placement<f64>> {
        convert_pose(pose).map_err(|condition| self.error(element(), condition))
    }

    /// Holds a joint of several degrees of freedom, or refuses it.
    fn held(&mut self, joint: &Joint, kind: &'static str) -> Result<Option<JointKind>> {
        if !self.options.hold {
            let condition = format!(
                "{kind} joints are not supported, as every joint has one axis: the keys \"srdf\" and \"group\", of \
                 joints without it, hold it (in code: UrdfOptions::hold), and so does type=\"fixed\" in the file"
            );
            return Err(self.error(format!("joint '{}'", joint.name), condition));
        }
        self.report.push(LoadNote::Held { joint: joint.name.clone(), kind });
        Ok(None)
    }

    /// The kind of a joint; `None` for one that is fixed or held.
    fn kind(&mut self, joint: &Joint) -> Result<Option<JointKind>> {
        let refuse = |why: &str| Err(self.error(format!("joint '{}'", joint.name), why));
        let kind = match joint.joint_type {
            JointType::Revolute => JointKind::Revolute,
            JointType::Continuous => JointKind::Continuous,
            JointType::Prismatic => JointKind::Prismatic,
            JointType::Fixed => return Ok(None),
            JointType::Floating => return self.held(joint, "floating"),
            JointType::Planar => return self.held(joint, "planar"),
            JointType::Spherical => return self.held(joint, "spherical"),
        };
        let Some(mimic) = &joint.mimic else {
            return Ok(Some(kind));
        };
        let mimics = &mimic.joint;
        match self.options.mimic {
            Mimic::Refuse => refuse(&format!(
                "it mimics joint '{mimics}', which is not supported: a dependent joint has no force of its own; \
                 --mimic independent (in a scenario: \"mimic\": \"independent\", in code: Mimic::Independent) lets it \
                 move by itself, and a \"group\" of an SRDF holds it with its master"
            )),
            Mimic::Independent => {
                self.report.push(LoadNote::Independent { joint: joint.name.clone(), mimics: mimics.clone() });
                Ok(Some(kind))
            }
        }
    }

    fn limits(&mut self, joint: &Joint, kind: JointKind) -> Result<Limits> {
        limits_of(joint, kind, &mut self.report)
            .map_err(|condition| self.error(format!("joint '{}'", joint.name), condition))
    }

    /// The normalised axis.
    fn axis(&self, joint: &Joint) -> Result<Vector3<f64>> {
        let axis = Vector3::from(joint.axis.xyz.0);
        let refuse = |why: &str| Err(self.error(format!("joint '{}'", joint.name), why));
        if axis.iter().any(|x| !x.is_finite()) {
            return refuse("its axis is not a finite number");
        }
        let largest = axis.amax();
        if largest == 0.0 {
            return refuse("its axis is zero");
        }
        // Scaled first, so that neither tiny nor huge axes lose digits; axes of length one stay as they are written.
        let scaled = axis / largest;
        let length = scaled.norm();
        Ok(if length * largest == 1.0 { axis } else { scaled / length })
    }
}

/// Converts a pose, or returns its fault; roll, pitch and yaw rotate about the fixed axes x, y, z in this order.
pub(super) fn convert_pose(pose: &Pose) -> std::result::Result<Placement<f64>, String> {
    if pose.xyz.iter().chain(pose.rpy.iter()).any(|x| !x.is_finite()) {
        return Err("its origin is not a finite number".to_owned());
    }
    let [roll, pitch, yaw] = pose.rpy.0;
    let rotation = Rotation3::from_euler_angles(roll, pitch, yaw);
    Ok(Placement::new(rotation.into_inner(), Vector3::from(pose.xyz.0)))
}

/// Returns true if products of finite numbers stayed finite.
fn is_finite(inertia: &Inertia<f64>) -> bool {
    let numbers = inertia.first_moment.iter().chain(&inertia.rotational);
    numbers.chain([&inertia.mass]).all(|x| x.is_finite())
}

/// The square of 1e-8 m: moments smaller than a mass times this are those of a point mass, or rounding errors of a
/// change of frame by some tenths of a metre.
const POINT: f64 = 1e-16;

/// The reason why an inertia about the centre of mass is physically impossible, if it is.
#[doc(hidden)]
#[must_use]
pub fn impossible_inertia(mass: f64, rotational: &Matrix3<f64>) -> Option<String> {
    if mass == 0.0 {
        return Some("it has rotational inertia but no mass".to_owned());
    }
    let moments = rotational.symmetric_eigenvalues();
    let rounding = (1e-9 * moments.amax()).max(mass * POINT);
    if moments.min() < -rounding {
        return Some(format!("its principal moment of inertia {:e} is negative", moments.min()));
    }
    if moments.sum() - 2.0 * moments.max() < -rounding {
        return Some("its largest principal moment of inertia exceeds the sum of the others".to_owned());
    }
    None
}
