//! The fields of the messages of ROS that those of MoveIt contain, and of `joint_limits.yaml`.

use super::field_table::SHAPES;
use super::fields::Fields;
use super::fields::Treatment::{Accepted, In, Read, Refused};

const NO_CELLS: &str = "it describes cells, which are refused";
const SOFT: &str = "a part of the soft limits, which are refused";

/// The messages and files with their fields, in the order of their definitions.
pub(super) const OF_OTHERS: &[(&str, Fields)] = &[
    (
        "octomap_msgs/OctomapWithPose",
        &[("header", Accepted(NO_CELLS)), ("origin", Accepted(NO_CELLS)), ("octomap", In("octomap_msgs/Octomap"))],
    ),
    (
        "octomap_msgs/Octomap",
        &[
            ("header", Accepted(NO_CELLS)),
            ("binary", Accepted(NO_CELLS)),
            ("id", Accepted(NO_CELLS)),
            ("resolution", Accepted(NO_CELLS)),
            ("data", Refused(SHAPES)),
        ],
    ),
    (
        "shape_msgs/SolidPrimitive",
        &[
            ("type", Read("the shape, by name or number")),
            ("dimensions", Read("its lengths")),
            ("polygon", In("geometry_msgs/Polygon")),
        ],
    ),
    ("geometry_msgs/Polygon", &[("points", Refused(SHAPES))]),
    ("geometry_msgs/Pose", &[("position", Read("`position_m`")), ("orientation", Read("`orientation_xyzw`"))]),
    ("geometry_msgs/Transform", &[("translation", Read("zero")), ("rotation", Read("none"))]),
    (
        "geometry_msgs/TransformStamped",
        &[
            ("header", Accepted("a transform that is not the identity is refused")),
            ("child_frame_id", Accepted("a transform that is not the identity is refused")),
            ("transform", In("geometry_msgs/Transform")),
        ],
    ),
    (
        "std_msgs/Header",
        &[
            ("seq", Accepted("a counter of ROS 1")),
            ("stamp", Accepted("a time of sending")),
            ("frame_id", Read("the base, empty or `world`; of a constraint `relative_to` a link")),
        ],
    ),
    (
        "trajectory_msgs/JointTrajectory",
        &[
            ("header", Read("by `aghf judge` and others that take motions")),
            ("joint_names", Read("the same")),
            ("points", Read("`trajectory_msgs/JointTrajectoryPoint`")),
        ],
    ),
    (
        "trajectory_msgs/JointTrajectoryPoint",
        &[
            ("positions", Read("`q`")),
            ("velocities", Read("`v`")),
            ("accelerations", Read("`a`")),
            ("effort", Read("`u`")),
            ("time_from_start", Read("`t`")),
        ],
    ),
    (
        "joint_limits.yaml",
        &[
            (
                "default_velocity_scaling_factor",
                Read("a factor of all limits of velocity, unless a request has its own"),
            ),
            (
                "default_acceleration_scaling_factor",
                Read("a factor of all limits of acceleration, unless a request has its own"),
            ),
            ("joint_limits", Read("limits by the names of joints")),
            ("cartesian_limits", Refused("`keep` of the scenario has speeds of points")),
        ],
    ),
    (
        "a joint of joint_limits.yaml",
        &[
            ("joint_name", Accepted("the joint is that of the key")),
            ("has_position_limits", Read("whether positions are limited")),
            ("min_position", Read("refused above that of the URDF by more than 1e-5, which alone is enforced")),
            ("max_position", Read("refused below that of the URDF by more than 1e-5, which alone is enforced")),
            ("has_velocity_limits", Read("whether max_velocity holds; by default if it is there")),
            ("max_velocity", Read("`enforced_limits.max_velocity`")),
            ("has_acceleration_limits", Read("whether max_acceleration holds; by default if it is there")),
            ("max_acceleration", Read("`enforced_limits.acceleration`, in both directions")),
            ("has_deceleration_limits", Read("whether max_deceleration holds; by default if it is there")),
            ("max_deceleration", Read("of either sign; the smaller one of both holds, with a note if they differ")),
            ("has_jerk_limits", Read("whether max_jerk holds; by default if it is there")),
            ("max_jerk", Read("`enforced_limits.jerk`")),
            ("has_effort_limits", Read("whether max_effort holds; by default if it is there")),
            ("max_effort", Read("refused below that of the URDF, which alone is enforced")),
            ("angle_wraparound", Accepted("the URDF says which joints are continuous")),
            ("has_soft_limits", Refused("write narrower limits of position into the URDF")),
            ("soft_lower_limit", Accepted(SOFT)),
            ("soft_upper_limit", Accepted(SOFT)),
            ("k_position", Accepted(SOFT)),
            ("k_velocity", Accepted(SOFT)),
        ],
    ),
];
