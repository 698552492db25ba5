//! Another link as the root of a robot, such as the foot on which it stands.

use super::build::convert_pose;
use super::tree::walk;
use super::write::roll_pitch_yaw;
use crate::error::{Error, Result};
use crate::names::instead;
use crate::spatial::Placement;
use urdf_rs::{Joint, JointType, Link, Pose, Robot, Vec3};

/// Hangs a robot on another link, which becomes its root; `file` names it in errors.
///
/// Joints between the two roots are turned round and keep their names, positions and limits: each is at the end of its
/// former child and carries a new massless link `JOINT_reversed_link`, on which its former parent is fixed by a joint
/// `JOINT_reversed`. All other links and joints, and the places of all links in each other, are as they were.
///
/// # Errors
/// The robot has no such link, an origin on the way is not finite, or its links form no tree.
pub fn reroot(robot: &Robot, root: &str, file: &str) -> Result<Robot> {
    let visits = walk(robot, file)?;
    let Some(mut at) = visits.iter().position(|visit| visit.link.name == root) else {
        let links = visits.iter().map(|visit| visit.link.name.as_str());
        let condition = format!("the robot has no such link{}", instead(root, links));
        return Err(Error::input(file, format!("root '{root}'"), condition));
    };
    let mut all = robot.clone();
    let mut reversed = Vec::new();
    while let Some(joint) = visits[at].joint {
        let origin = convert_pose(&joint.origin)
            .map_err(|condition| Error::input(file, format!("joint '{}'", joint.name), condition))?;
        let back = Joint {
            name: free_name([robot, &all], format!("{}_reversed", joint.name)),
            joint_type: JointType::Fixed,
            origin: pose_of(&inverse(&origin)),
            parent: joint.child.clone(),
            child: joint.parent.clone(),
            axis: Default::default(),
            limit: Default::default(),
            calibration: None,
            dynamics: None,
            mimic: None,
            safety_controller: None,
        };
        if joint.joint_type == JointType::Fixed {
            reversed.push(Joint { name: joint.name.clone(), ..back });
        } else {
            let mut turned = Joint { origin: Pose::default(), parent: joint.child.clone(), ..joint.clone() };
            // Pinocchio has one list of names for links and joints.
            turned.child.link = free_name([robot, &all], format!("{}_link", back.name));
            for x in &mut turned.axis.xyz.0 {
                *x = -*x;
            }
            all.links.push(Link {
                name: turned.child.link.clone(),
                inertial: Default::default(),
                visual: Vec::new(),
                collision: Vec::new(),
            });
            let mut back = back;
            back.parent.link.clone_from(&turned.child.link);
            reversed.extend([turned, back]);
        }
        all.joints.retain(|other| other.name != joint.name);
        at = visits[at].parent;
    }
    all.joints.extend(reversed);
    Ok(all)
}

/// A name that neither a link nor a joint of these robots has.
fn free_name(robots: [&Robot; 2], mut name: String) -> String {
    let links = || robots.iter().flat_map(|robot| &robot.links);
    let joints = || robots.iter().flat_map(|robot| &robot.joints);
    while links().any(|link| link.name == name) || joints().any(|joint| joint.name == name) {
        name.push('_');
    }
    name
}

fn inverse(of: &Placement<f64>) -> Placement<f64> {
    let back = of.rotation.transpose();
    Placement::new(back, -(back * of.translation))
}

fn pose_of(placement: &Placement<f64>) -> Pose {
    Pose { xyz: Vec3(placement.translation.into()), rpy: Vec3(roll_pitch_yaw(&placement.rotation)) }
}
