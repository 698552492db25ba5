//! The joints of a URDF that follow others.

use crate::error::{Error, Result, plain};
use crate::model::Model;
use std::collections::BTreeMap;
use urdf_rs::{Joint, JointType, Robot};

/// A joint that follows another one: $q_i = m\\, q_j + c$.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Follower {
    /// The joint `i`, by its number in the model.
    pub joint: usize,
    /// The joint `j`, which follows none itself.
    pub master: usize,
    /// The factor `m`; for a prismatic and a revolute joint in m/rad or rad/m.
    pub multiplier: f64,
    /// The offset `c`, rad or m.
    pub offset: f64,
}

/// The joints of a robot that follow others; one that follows a follower follows its master. `model` is that of the
/// robot with [`Mimic::Independent`](super::Mimic::Independent), and `file` names it in errors. Cost O(J^2) for J mimic
/// joints.
///
/// # Errors
/// Names the joint: it follows itself, or a joint that does not move, or its factor or offset is not finite.
pub fn followers(robot: &Robot, model: &Model, file: &str) -> Result<Vec<Follower>> {
    let moves = |joint: &&Joint| joint.joint_type != JointType::Fixed;
    let mimics: BTreeMap<_, _> = (robot.joints.iter().filter(moves))
        .filter_map(|joint| Some((joint.name.as_str(), joint.mimic.as_ref()?)))
        .collect();
    let number = |name: &str| model.joints().iter().position(|joint| joint.name() == name);
    let mut found = Vec::new();
    for (name, mimic) in &mimics {
        let refuse = |condition: String| Error::input(file, format!("joint '{name}'"), condition);
        let (mut multiplier, mut offset) = (1.0, 0.0);
        let (mut master, mut next, mut steps) = (name.to_owned(), Some(mimic), 0);
        while let Some(mimic) = next {
            offset += multiplier * mimic.offset.unwrap_or(0.0);
            multiplier *= mimic.multiplier.unwrap_or(1.0);
            master = &mimic.joint;
            next = mimics.get(master);
            steps += 1;
            if steps > mimics.len() {
                return Err(refuse("it follows joints that follow each other".to_owned()));
            }
        }
        if !(f64::is_finite(multiplier) && f64::is_finite(offset)) {
            let [multiplier, offset] = [multiplier, offset].map(plain);
            return Err(refuse(format!("it mimics '{master}' with the factor {multiplier} and the offset {offset}")));
        }
        let (Some(joint), Some(master)) = (number(name), number(master)) else {
            return Err(refuse(format!("it mimics '{master}', no joint that moves")));
        };
        found.push(Follower { joint, master, multiplier, offset });
    }
    Ok(found)
}
