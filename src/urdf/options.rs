//! How to read a robot, and what is told of it.

use std::fmt;

crate::names::named_enum! {
/// The treatment of a joint that is to follow another one (a `mimic` element: $q_i = m\, q_j + c$).
///
/// Such a joint is not natural here: joint `i` moves body `i` and is degree of freedom `i`, with a force of its own, in
/// every algorithm of this library.
pub enum Mimic("mimic") {
    /// Refuse the robot.
    Refuse = "refuse",
    /// Let it move by itself, with a note, as Pinocchio's `buildModelFromUrdf` does by default.
    Independent = "independent",
}
}

/// The options of reading a URDF.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct UrdfOptions {
    /// The treatment of mimic joints.
    pub mimic: Mimic,
}

/// A note on something that was accepted on loading but is worth knowing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LoadNote {
    /// The link has no inertial element, or one of zeros, and counts as massless.
    Massless {
        /// The link.
        link: String,
    },
    /// No body can have this inertia; the dynamics are computed with it all the same.
    ImpossibleInertia {
        /// The link.
        link: String,
        /// The reason why it is impossible.
        condition: String,
    },
    /// The link hangs on a fixed joint and became part of the body before it; its frame is kept.
    Merged {
        /// The link.
        link: String,
        /// The fixed joint.
        joint: String,
        /// The moving joint whose body it is part of now; `None` is the base.
        into: Option<String>,
    },
    /// The joint has no limit element, or one of zeros, and counts as unlimited.
    Unlimited {
        /// The joint.
        joint: String,
    },
    /// The velocity or effort limit of the joint is zero, which exporters write where it is unknown, and counts as infinite.
    ZeroLimit {
        /// The joint.
        joint: String,
        /// The attribute of the limit element, `velocity` or `effort`.
        attribute: &'static str,
    },
    /// The joint is to follow another one, but moves by itself here, as [`Mimic::Independent`] asks for.
    Independent {
        /// The joint.
        joint: String,
        /// The joint that it is to follow.
        mimics: String,
    },
}

impl fmt::Display for LoadNote {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Massless { link } => write!(f, "link '{link}': massless"),
            Self::ImpossibleInertia { link, condition } => write!(f, "link '{link}': {condition}"),
            Self::Merged { link, joint, into } => {
                let body = into.as_deref().map_or_else(
                    || "the base".to_owned(),
                    |into| format!("the body of joint '{into}'"),
                );
                write!(
                    f,
                    "link '{link}': merged by fixed joint '{joint}' into {body}"
                )
            }
            Self::Unlimited { joint } => write!(f, "joint '{joint}': no limits"),
            Self::ZeroLimit { joint, attribute } => write!(
                f,
                "joint '{joint}': its {attribute} limit of 0 counts as unknown, no limit"
            ),
            Self::Independent { joint, mimics } => {
                write!(f, "joint '{joint}': mimics '{mimics}', independent here")
            }
        }
    }
}

/// The notes on what was accepted on loading but is worth knowing, in the order in which the tree is walked.
pub type LoadReport = Vec<LoadNote>;
