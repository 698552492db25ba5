//! Reading of robots from URDF files.

use super::elements::{self, JointType, Pose, read_robot};
use super::tree::Visit;
use super::{LoadNote, LoadReport, Mimic, UrdfOptions, tree};
use crate::error::{Error, Result, plain};
use crate::input::read_text;
use crate::model::{Carrier, Collision, Frame, JointKind, JointSpec, Limits, Model};
use crate::spatial::{Inertia, Placement};
use nalgebra::{Matrix3, Rotation3, Vector3};
use std::path::Path;

/// Reads the robot in the URDF file at `path`. See [`parse_urdf`].
///
/// # Errors
/// The file cannot be read, or those of [`parse_urdf`].
pub fn load_urdf(path: &Path) -> Result<(Model, LoadReport)> {
    load_urdf_with(path, UrdfOptions::default())
}

/// Reads the robot in the URDF file at `path` with options. See [`parse_urdf`].
///
/// # Errors
/// The file cannot be read, or those of [`parse_urdf`].
pub fn load_urdf_with(path: &Path, options: UrdfOptions) -> Result<(Model, LoadReport)> {
    let text = read_text(path)?;
    parse_urdf_with(&text, &path.display().to_string(), options)
}

/// Reads a robot from the text of a URDF file; `file` names it in errors.
///
/// Fixed joints are merged into the body before them. A velocity or effort limit of zero, and a limit element of zeros,
/// mean no limit, with a note. Collision elements become [`Model::collisions`]; files of meshes are not read. Visual
/// elements, materials, transmissions and all other elements without dynamics or collision shapes are ignored.
///
/// # Errors
/// Names the faulty element and the reason: text that is not a URDF; negative or non-finite numbers; zero axes;
/// repeated names; several roots; loops; unknown links; floating, planar, spherical and mimic joints; joints whose
/// subtree has no inertia about them; and collision elements without a shape, with an unknown one or with a size that
/// is not positive.
pub fn parse_urdf(text: &str, file: &str) -> Result<(Model, LoadReport)> {
    parse_urdf_with(text, file, UrdfOptions::default())
}

/// Reads a robot from the text of a URDF file with options. See [`parse_urdf`].
///
/// # Errors
/// Those of [`parse_urdf`].
pub fn parse_urdf_with(
    text: &str,
    file: &str,
    options: UrdfOptions,
) -> Result<(Model, LoadReport)> {
    let robot = read_robot(text, file)?;
    let mut loader = Loader {
        file,
        options,
        report: LoadReport::new(),
        specs: Vec::new(),
        frames: Vec::new(),
        collisions: Vec::new(),
    };
    for visit in tree::walk(&robot, file)? {
        loader.visit(&visit)?;
    }
    let model = Model::from_joints(&robot.name, loader.specs)
        .map_err(|e| match e {
            Error::Input {
                element, condition, ..
            } => Error::input(file, element, condition),
            other => other,
        })?
        .with_frames(loader.frames)
        .with_collisions(loader.collisions)?;
    model.check_regular(file)?;
    Ok((model, loader.report))
}

/// The elements read so far.
struct Loader<'a> {
    file: &'a str,
    options: UrdfOptions,
    report: LoadReport,
    specs: Vec<JointSpec<f64>>,
    frames: Vec<Frame<f64>>,
    collisions: Vec<Collision>,
}

impl Loader<'_> {
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
                let origin = self.pose(&joint.origin, format!("joint '{}'", joint.name))?;
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
                        let left_out = joint.losses.iter().map(|attribute| LoadNote::LeftOut {
                            joint: joint.name.clone(),
                            attribute,
                        });
                        self.report.extend(left_out);
                        self.specs.push(spec);
                        (Some(self.specs.len() - 1), Placement::identity())
                    }
                }
            }
        };
        if let Some(body) = body {
            let placed = inertia.placed(&placement);
            if !is_finite(&placed) {
                let condition = "its inertia about the joint that moves it is not finite";
                return Err(self.error(format!("link '{}'", link.name), condition));
            }
            self.specs[body].inertia += placed;
        }
        for shape in &link.collisions {
            let element = format!("link '{}': {}", link.name, shape.name);
            self.collisions.push(Collision {
                link: link.name.clone(),
                body,
                placement: placement.compose(&self.pose(&shape.origin, element)?),
                shape: shape.shape.clone(),
            });
        }
        self.frames.push(Frame {
            name: link.name.clone(),
            body,
            placement,
            carrier: visit.joint.map(|joint| Carrier {
                joint: joint.name.clone(),
                parent: Some(visit.parent),
            }),
        });
        Ok(())
    }

    /// The inertia of a link in its own frame.
    fn inertia(&mut self, link: &elements::Link) -> Result<Inertia<f64>> {
        let element = format!("link '{}'", link.name);
        let (mass, [ixx, ixy, ixz, iyy, iyz, izz]) = (link.mass, link.inertia);
        let origin = self.pose(&link.origin, element.clone())?;
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
        } else if let Some(condition) = impossible(mass, &rotational) {
            self.report.push(LoadNote::ImpossibleInertia {
                link: name(),
                condition,
            });
        }
        let turned = origin.rotation * rotational * origin.rotation.transpose();
        Ok(Inertia::from_com(mass, origin.translation, turned))
    }

    /// Converts a pose; roll, pitch and yaw rotate about the fixed axes x, y, z in this order.
    fn pose(&self, pose: &Pose, element: String) -> Result<Placement<f64>> {
        if pose
            .xyz
            .iter()
            .chain(pose.rpy.iter())
            .any(|x| !x.is_finite())
        {
            return Err(self.error(element, "its origin is not a finite number"));
        }
        let [roll, pitch, yaw] = pose.rpy;
        let rotation = Rotation3::from_euler_angles(roll, pitch, yaw);
        Ok(Placement::new(
            rotation.into_inner(),
            Vector3::from(pose.xyz),
        ))
    }

    /// The kind of a joint; `None` for a fixed one.
    fn kind(&mut self, joint: &elements::Joint) -> Result<Option<JointKind>> {
        if let Some(mimics) = &joint.mimics {
            match self.options.mimic {
                Mimic::Refuse => {
                    let condition = format!(
                        "it mimics joint '{mimics}', which is not supported: a dependent joint has no force of its own; \
                         --mimic independent (in a scenario: \"mimic\": \"independent\", in code: Mimic::Independent) lets it \
                         move by itself"
                    );
                    return Err(self.error(format!("joint '{}'", joint.name), condition));
                }
                Mimic::Independent => self.report.push(LoadNote::Independent {
                    joint: joint.name.clone(),
                    mimics: mimics.clone(),
                }),
            }
        }
        let refuse = |why: &str| Err(self.error(format!("joint '{}'", joint.name), why));
        match joint.kind {
            JointType::Revolute => Ok(Some(JointKind::Revolute)),
            JointType::Continuous => Ok(Some(JointKind::Continuous)),
            JointType::Prismatic => Ok(Some(JointKind::Prismatic)),
            JointType::Fixed => Ok(None),
            JointType::Floating => refuse("floating joints are not supported: the base is fixed"),
            JointType::Planar => {
                refuse("planar joints are not supported: every joint has one axis")
            }
            JointType::Spherical => {
                refuse("spherical joints are not supported: every joint has one axis")
            }
        }
    }

    /// The normalised axis.
    fn axis(&self, joint: &elements::Joint) -> Result<Vector3<f64>> {
        let axis = Vector3::from(joint.axis);
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
        Ok(if length * largest == 1.0 {
            axis
        } else {
            scaled / length
        })
    }

    fn limits(&mut self, joint: &elements::Joint, kind: JointKind) -> Result<Limits> {
        let Some(limit) = joint.limit else {
            if kind != JointKind::Continuous {
                self.report.push(LoadNote::Unlimited {
                    joint: joint.name.clone(),
                });
            }
            return Ok(Limits::NONE);
        };
        let file = self.file;
        let refuse = |why: String| Err(Error::input(file, format!("joint '{}'", joint.name), why));
        let (velocity, effort) = (limit.velocity, limit.effort);
        if [limit.lower, limit.upper, velocity, effort]
            .iter()
            .any(|x| x.is_nan())
        {
            return refuse("a limit is not a number".to_owned());
        }
        for (what, most) in [("velocity", velocity), ("effort", effort)] {
            if most < 0.0 {
                return refuse(format!("its {what} limit is negative: {}", plain(most)));
            }
        }
        let mut known = |attribute, most: f64| {
            if most > 0.0 {
                return most;
            }
            self.report.push(LoadNote::ZeroLimit {
                joint: joint.name.clone(),
                attribute,
            });
            f64::INFINITY
        };
        let (velocity, effort) = (known("velocity", velocity), known("effort", effort));
        let (lower, upper) = match kind {
            JointKind::Continuous => (f64::NEG_INFINITY, f64::INFINITY),
            JointKind::Revolute | JointKind::Prismatic => (limit.lower, limit.upper),
        };
        let ends = [lower, upper].map(plain);
        if lower > upper {
            return refuse(format!(
                "its lower limit {} is above its upper limit {}",
                ends[0], ends[1]
            ));
        }
        if lower == f64::INFINITY || upper == f64::NEG_INFINITY {
            return refuse(format!(
                "no position is within its limits {} and {}",
                ends[0], ends[1]
            ));
        }
        Ok(Limits {
            lower,
            upper,
            velocity,
            effort,
        })
    }
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
fn impossible(mass: f64, rotational: &Matrix3<f64>) -> Option<String> {
    if mass == 0.0 {
        return Some("it has rotational inertia but no mass".to_owned());
    }
    let moments = rotational.symmetric_eigenvalues();
    let rounding = (1e-9 * moments.amax()).max(mass * POINT);
    if moments.min() < -rounding {
        return Some(format!(
            "its principal moment of inertia {:e} is negative",
            moments.min()
        ));
    }
    if moments.sum() - 2.0 * moments.max() < -rounding {
        return Some(
            "its largest principal moment of inertia exceeds the sum of the others".to_owned(),
        );
    }
    None
}
