//! Options and notes of reading a robot.

use super::Losses;
use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;

/// The number of elements named in a summary of notes.
const NAMED: usize = 3;

crate::names::named_enum! {
/// The treatment of a mimic joint, which follows another one (a `mimic` element: $q_i = m\\, q_j + c$).
///
/// Such a joint does not fit the model: in every algorithm of this library joint `i` moves body `i` and is degree of
/// freedom `i`, with an independent force.
pub enum Mimic("mimic") {
    /// Refuses the robot.
    Refuse = "refuse",
    /// Lets each mimic joint move by itself, with a note, as Pinocchio's `buildModelFromUrdf` does by default.
    Independent = "independent",
}
}

/// The options of reading a URDF.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct UrdfOptions {
    /// The treatment of mimic joints.
    pub mimic: Mimic,
    /// The link that becomes the [root](super::reroot()); `None` for that of the file.
    pub root: Option<String>,
    /// The losses and the rotor inertia of the joints; `None` for rigid bodies alone.
    pub losses: Option<Losses>,
    /// True to hold joints of several degrees of freedom, such as a floating base, as if they were fixed, with a note;
    /// otherwise they are refused.
    pub hold: bool,
    /// True to accept a robot whose mass matrix is singular, such as one whose joints will be locked.
    pub singular: bool,
    /// The folders of packages by their names, for the files that the URDF calls `package://NAME/PATH`: such a file is
    /// `PATH` in that folder and nowhere else. A relative folder is relative to the current one.
    pub packages: BTreeMap<String, PathBuf>,
}

/// A note on something that was accepted during loading but may matter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LoadNote {
    /// The link has no inertial element, or an inertia of zero, and counts as massless.
    Massless {
        /// The link.
        link: String,
    },
    /// The inertia is physically impossible; the dynamics use it nevertheless.
    ImpossibleInertia {
        /// The link.
        link: String,
        /// The reason why it is impossible.
        condition: String,
    },
    /// The link is on a fixed joint and was merged into the body before it; its frame is kept.
    Merged {
        /// The link.
        link: String,
        /// The fixed joint.
        joint: String,
        /// The moving joint of the body that contains it; `None` is the base.
        into: Option<String>,
    },
    /// The joint has no limit element, or only zeros in it, and counts as unlimited.
    Unlimited {
        /// The joint.
        joint: String,
    },
    /// The velocity or effort limit of the joint is zero, which exporters write for an unknown limit, and counts as
    /// infinite.
    ZeroLimit {
        /// The joint.
        joint: String,
        /// The attribute of the limit element, `velocity` or `effort`.
        attribute: &'static str,
    },
    /// The joint has several degrees of freedom and is held, as requested by [`UrdfOptions::hold`].
    Held {
        /// The joint.
        joint: String,
        /// Its type.
        kind: &'static str,
    },
    /// An SRDF has a link that the robot does not have.
    UnknownLink {
        /// The link.
        link: String,
    },
    /// A limit of the joint is 1e10 or more, which exporters write for none, and counts as infinite.
    HugeLimit {
        /// The joint.
        joint: String,
        /// The kind of the limit: `position`, `velocity` or `effort`.
        limit: &'static str,
    },
    /// The safety controller of the joint has soft limits within its limits of position, which are not kept.
    SoftLimits {
        /// The joint.
        joint: String,
        /// The soft limits, rad or m, in words.
        limits: String,
        /// The largest centred share of the range of positions that is within them, if there is one.
        share: Option<String>,
    },
    /// The joint has several axes, of which the first counts.
    SeveralAxes {
        /// The joint.
        joint: String,
    },
    /// The link has a mass and no moments of inertia, and counts as a point mass at the origin of its inertial element.
    PointMass {
        /// The link.
        link: String,
    },
    /// A collision shape of the link has the radius zero, or no extent at all, and is left out.
    NoExtent {
        /// The link.
        link: String,
        /// The name or the number of the collision element.
        shape: String,
    },
    /// A prefix of elements or attributes is not declared. What has it is left out, as with declared ones.
    UndeclaredPrefix {
        /// The prefix.
        prefix: String,
    },
    /// The declaration `<?xml ...?>` is not at the beginning of the file, and is passed over.
    BeforeDeclaration,
    /// The joint has damping or friction, which the dynamics do not count without [`UrdfOptions::losses`].
    LeftOut {
        /// The joint.
        joint: String,
        /// The attribute of the dynamics element, `damping` or `friction`.
        attribute: &'static str,
    },
    /// A state in another file names a joint that the robot does not have.
    Missing {
        /// The joint.
        joint: String,
    },
    /// A state in another file is beyond a limit of the joint by rounding, and was set to the limit.
    AtLimit {
        /// The joint.
        joint: String,
        /// The distance from the limit, rad or m, in words.
        by: String,
    },
    /// A goal in another file is an angle of the continuous joint, and was moved by whole turns as near as possible to
    /// its start.
    Turned {
        /// The joint.
        joint: String,
        /// The number of turns, in words.
        by: String,
    },
    /// Another file has different limits of acceleration and of deceleration for the joint, the smaller of which holds
    /// in both directions.
    Deceleration {
        /// The joint.
        joint: String,
        /// The limit, rad/s^2 or m/s^2, in words.
        least: String,
    },
    /// The joint moves nothing with inertia about it and is planned with a rotor inertia that stands in for it.
    SubstituteRotor {
        /// The joint.
        joint: String,
        /// The inertia with its unit.
        armature: String,
    },
    /// The mimic joint moves independently, as requested by [`Mimic::Independent`].
    Independent {
        /// The joint.
        joint: String,
        /// The joint that it should follow.
        mimics: String,
    },
}

impl LoadNote {
    /// Returns true if motions or torques may differ from those of the real robot. Links without mass and merged links
    /// move correctly, and a declaration has no effect.
    #[must_use]
    pub fn bears_on_motion(&self) -> bool {
        !matches!(self, Self::Massless { .. } | Self::Merged { .. } | Self::BeforeDeclaration)
    }

    /// The joint concerned.
    #[must_use]
    pub fn joint(&self) -> Option<&str> {
        match self.element() {
            ("joint", name) => Some(name),
            _ => None,
        }
    }

    /// The kind and the name of the element concerned.
    #[must_use]
    pub fn element(&self) -> (&'static str, &str) {
        match self {
            Self::Massless { link }
            | Self::ImpossibleInertia { link, .. }
            | Self::PointMass { link }
            | Self::NoExtent { link, .. }
            | Self::UnknownLink { link }
            | Self::Merged { link, .. } => ("link", link),
            Self::UndeclaredPrefix { prefix } => ("prefix", prefix),
            Self::BeforeDeclaration => ("declaration", "<?xml"),
            Self::Unlimited { joint }
            | Self::ZeroLimit { joint, .. }
            | Self::HugeLimit { joint, .. }
            | Self::Held { joint, .. }
            | Self::SoftLimits { joint, .. }
            | Self::SeveralAxes { joint }
            | Self::Independent { joint, .. }
            | Self::SubstituteRotor { joint, .. }
            | Self::Missing { joint }
            | Self::AtLimit { joint, .. }
            | Self::Turned { joint, .. }
            | Self::Deceleration { joint, .. }
            | Self::LeftOut { joint, .. } => ("joint", joint),
        }
    }

    /// The sentence for several notes of this kind.
    #[must_use]
    pub fn kind(&self) -> String {
        match self {
            Self::Massless { .. } => "massless".to_owned(),
            Self::ImpossibleInertia { .. } => "no body can have such an inertia".to_owned(),
            Self::Merged { .. } => "merged by fixed joints".to_owned(),
            Self::Independent { .. } => "mimic another joint, independent here".to_owned(),
            Self::Unlimited { .. } => "no limits".to_owned(),
            Self::ZeroLimit { attribute, .. } => {
                format!("{attribute} limit of 0 counts as unknown, no limit")
            }
            Self::Held { kind, .. } => format!("{kind}, held at the origin of the joint"),
            Self::UnknownLink { .. } => {
                "the SRDF has a pair of links with it, and the robot does not have it".to_owned()
            }
            Self::HugeLimit { limit, .. } => {
                format!("{limit} limit of 1e10 or more counts as no limit")
            }
            Self::SoftLimits { .. } => {
                "soft limits of the safety controller are not kept; \"enforced_limits\": {\"position\": SHARE} keeps a \
                 centred share of the ranges of all joints"
                    .to_owned()
            }
            Self::SeveralAxes { .. } => "several axes, the first counts".to_owned(),
            Self::PointMass { .. } => {
                "no inertia element beside the mass, counts as a point mass at its origin".to_owned()
            }
            Self::NoExtent { .. } => "a collision shape has the radius 0, or no extent, and is left out".to_owned(),
            Self::UndeclaredPrefix { .. } => "not declared; elements and attributes with it are left out".to_owned(),
            Self::BeforeDeclaration => {
                "blank lines or comments are before it, where it has no effect; it should be at the beginning"
                    .to_owned()
            }
            Self::Missing { .. } => "the robot has none of this name, its position is not used".to_owned(),
            Self::AtLimit { by, .. } => {
                format!("its position is {by} beyond a limit, and was set to the limit")
            }
            Self::Turned { by, .. } => {
                format!("its goal was moved by {by}, as near as possible to its start")
            }
            Self::Deceleration { least, .. } => format!(
                "limits of acceleration and deceleration differ, the smaller of {least} holds in both directions"
            ),
            Self::SubstituteRotor { armature, .. } => format!(
                "nothing that it moves has inertia about it, planned with a rotor inertia of {armature}; \
                 \"losses\": {{\"armature\": ...}} sets another"
            ),
            Self::LeftOut { attribute, .. } => {
                format!("{attribute} is not counted, as losses are not asked for")
            }
        }
    }
}

impl fmt::Display for LoadNote {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (element, name) = self.element();
        write!(f, "{element} '{name}': ")?;
        match self {
            Self::ImpossibleInertia { condition, .. } => f.write_str(condition),
            Self::Merged { joint, into, .. } => {
                let body =
                    into.as_deref().map_or_else(|| "the base".to_owned(), |into| format!("the body of joint '{into}'"));
                write!(f, "merged by fixed joint '{joint}' into {body}")
            }
            Self::Independent { mimics, .. } => write!(f, "mimics '{mimics}', independent here"),
            Self::ZeroLimit { .. } | Self::HugeLimit { .. } => write!(f, "its {}", self.kind()),
            Self::SoftLimits { limits, share, .. } => {
                write!(f, "its soft limits {limits} are not kept; ")?;
                match share {
                    Some(share) => write!(
                        f,
                        "\"enforced_limits\": {{\"position\": {share}}} keeps within them, and all joints within this \
                         share of their ranges"
                    ),
                    None => write!(f, "lower and upper of its limit element in the file would be"),
                }
            }
            Self::NoExtent { shape, .. } => {
                write!(f, "{shape} has the radius 0, or no extent, and is left out")
            }
            Self::SeveralAxes { .. } => f.write_str("it has several axes, the first counts"),
            Self::PointMass { .. }
            | Self::Held { .. }
            | Self::UnknownLink { .. }
            | Self::UndeclaredPrefix { .. }
            | Self::BeforeDeclaration
            | Self::Massless { .. }
            | Self::Unlimited { .. }
            | Self::SubstituteRotor { .. }
            | Self::Missing { .. }
            | Self::AtLimit { .. }
            | Self::Turned { .. }
            | Self::Deceleration { .. }
            | Self::LeftOut { .. } => f.write_str(&self.kind()),
        }
    }
}

/// The notes of a report that [affect motions](LoadNote::bears_on_motion), in words, with one line per kind.
#[must_use]
pub fn summarised(report: &[LoadNote]) -> Vec<String> {
    let mut kinds: Vec<(String, Vec<&LoadNote>)> = Vec::new();
    for note in report.iter().filter(|note| note.bears_on_motion()) {
        let kind = note.kind();
        match kinds.iter_mut().find(|(other, _)| *other == kind) {
            Some((_, notes)) => notes.push(note),
            None => kinds.push((kind, vec![note])),
        }
    }
    let in_words = |(kind, notes): (String, Vec<&LoadNote>)| {
        if let [note] = notes.as_slice() {
            return note.to_string();
        }
        let names: Vec<_> = (notes.iter().take(NAMED)).map(|note| format!("'{}'", note.element().1)).collect();
        let (element, names) = (notes[0].element().0, names.join(", "));
        match notes.len().saturating_sub(NAMED) {
            0 => format!("{element}s {names}: {kind}"),
            more => format!("{element}s {names} and {more} more: {kind}"),
        }
    };
    kinds.into_iter().map(in_words).collect()
}

/// The notes on irregularities that were accepted during loading, in the order in which the tree is visited.
pub type LoadReport = Vec<LoadNote>;
