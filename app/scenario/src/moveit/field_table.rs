//! The fields of MoveIt's messages.

use super::fields::Fields;
use super::fields::Treatment::{Accepted, In, Only, Read, Refused};

/// The remedy for shapes that are not read.
pub(super) const SHAPES: &str = "boxes, cylinders and spheres alone are read; an obstacle of these that \
    contains it stands in for it";

const CLEARANCE: &str = "the robot has the shapes of its URDF; `clearance_m` of the scenario keeps a distance from all \
    obstacles and between links";
const NO_MESHES: &str = "meshes are refused";
const FIXED_BASE: &str = "the base is fixed";
const WEIGHT: &str = "all conditions hold";
const NO_FRAME: &str = "no frame is looked up by it";
const BUDGET: &str = "a budget of the search, of which `aghf solve` has its own";
const PLANNER: &str = "a choice of a planner";

/// The messages with their fields, in the order of their definitions.
pub(super) const OF_MOVEIT: &[(&str, Fields)] = &[
    (
        "moveit_msgs/MotionPlanRequest",
        &[
            ("workspace_parameters", Accepted("bounds of a base that drives or floats; the base is fixed")),
            ("start_state", In("moveit_msgs/RobotState")),
            ("goal_constraints", In("moveit_msgs/Constraints")),
            ("path_constraints", In("moveit_msgs/Constraints")),
            ("trajectory_constraints", In("moveit_msgs/TrajectoryConstraints")),
            ("reference_trajectories", Refused("no motion to begin the search with is read here")),
            ("pipeline_id", Accepted(PLANNER)),
            ("planner_id", Accepted(PLANNER)),
            ("group_name", Read("the joints that are planned, for a goal by pose with an SRDF")),
            ("num_planning_attempts", Accepted(BUDGET)),
            ("allowed_planning_time", Accepted(BUDGET)),
            (
                "max_velocity_scaling_factor",
                Read("`enforced_limits.velocity`, a share, and a factor of `max_velocity`; 0 means 1"),
            ),
            (
                "max_acceleration_scaling_factor",
                Read("a factor of the accelerations of `--joint-limits`, which it needs; 0 means 1"),
            ),
            ("cartesian_speed_end_effector_link", Read("the next one, by the name that it has in Humble and before")),
            ("cartesian_speed_limited_link", Read("`keep[].speed.frame`")),
            ("max_cartesian_speed", Read("`keep[].speed.most_m_s`; none at zero or below")),
        ],
    ),
    (
        "moveit_msgs/TrajectoryConstraints",
        &[("constraints", Refused("conditions on the way are those of path_constraints"))],
    ),
    (
        "moveit_msgs/PlanningScene",
        &[
            ("name", Accepted("a label")),
            ("robot_state", In("moveit_msgs/RobotState")),
            ("robot_model_name", Accepted("the robot is that of `--urdf`")),
            ("fixed_frame_transforms", In("geometry_msgs/TransformStamped")),
            ("allowed_collision_matrix", In("moveit_msgs/AllowedCollisionMatrix")),
            ("link_padding", In("moveit_msgs/LinkPadding")),
            ("link_scale", In("moveit_msgs/LinkScale")),
            ("object_colors", Accepted("colours")),
            ("world", In("moveit_msgs/PlanningSceneWorld")),
            ("is_diff", Refused("it is a change of another scene; a whole one is needed")),
        ],
    ),
    (
        "moveit_msgs/RobotState",
        &[
            ("joint_state", In("sensor_msgs/JointState")),
            ("multi_dof_joint_state", In("sensor_msgs/MultiDOFJointState")),
            (
                "attached_collision_objects",
                Refused("an object that the robot carries is `payload` of the scenario, and a shape of its link"),
            ),
            ("is_diff", Accepted("joints that the request lacks are where the scene has them, either way")),
        ],
    ),
    (
        "sensor_msgs/JointState",
        &[
            ("header", Accepted(NO_FRAME)),
            ("name", Read("names of joints")),
            ("position", Read("`q_start`, or `locked_joints`")),
            ("velocity", Read("`v_start`; that of a locked joint has to be zero")),
            ("effort", Refused("the torques at the start are those of the motion; leave them out")),
        ],
    ),
    (
        "sensor_msgs/MultiDOFJointState",
        &[
            ("header", Accepted(NO_FRAME)),
            ("joint_names", Accepted(FIXED_BASE)),
            ("transforms", In("geometry_msgs/Transform")),
            ("twist", Refused(FIXED_BASE)),
            ("wrench", Refused(FIXED_BASE)),
        ],
    ),
    (
        "moveit_msgs/Constraints",
        &[
            ("name", Accepted("a label")),
            ("joint_constraints", In("moveit_msgs/JointConstraint")),
            ("position_constraints", In("moveit_msgs/PositionConstraint")),
            ("orientation_constraints", In("moveit_msgs/OrientationConstraint")),
            ("visibility_constraints", Refused("they are not read; `keep` has poses and speeds")),
        ],
    ),
    (
        "moveit_msgs/JointConstraint",
        &[
            ("joint_name", Read("a joint of `q_goal`")),
            (
                "position",
                Read("`q_goal`; of a continuous joint moved by whole turns, as near as possible to its start"),
            ),
            ("tolerance_above", Accepted("the motion ends at the position itself")),
            ("tolerance_below", Accepted("the motion ends at the position itself")),
            ("weight", Accepted(WEIGHT)),
        ],
    ),
    (
        "moveit_msgs/PositionConstraint",
        &[
            ("header", In("std_msgs/Header")),
            ("link_name", Read("`frame`")),
            ("target_point_offset", Read("zero, the origin of the link")),
            ("constraint_region", In("moveit_msgs/BoundingVolume")),
            ("weight", Accepted(WEIGHT)),
        ],
    ),
    (
        "moveit_msgs/BoundingVolume",
        &[
            ("primitives", In("shape_msgs/SolidPrimitive")),
            ("primitive_poses", In("geometry_msgs/Pose")),
            ("meshes", Refused("a sphere or a box is read")),
            ("mesh_poses", Accepted(NO_MESHES)),
        ],
    ),
    (
        "moveit_msgs/OrientationConstraint",
        &[
            ("header", In("std_msgs/Header")),
            ("orientation", Read("`orientation_xyzw`, or `axis`")),
            ("link_name", Read("`frame`")),
            ("absolute_x_axis_tolerance", Read("`tolerance_rad`, the least; from half a turn on a free axis")),
            ("absolute_y_axis_tolerance", Read("the same")),
            ("absolute_z_axis_tolerance", Read("the same")),
            ("parameterization", Read("0 or 1, with a free axis 0")),
            ("weight", Accepted(WEIGHT)),
        ],
    ),
    (
        "moveit_msgs/AllowedCollisionMatrix",
        &[
            ("entry_names", Read("links of `self_collision`")),
            ("entry_values", Read("pairs that may overlap; lists, or `moveit_msgs/AllowedCollisionEntry`")),
            ("default_entry_names", Accepted("their values are refused unless they allow nothing")),
            ("default_entry_values", Refused("name the pairs that may overlap in entry_names")),
        ],
    ),
    ("moveit_msgs/AllowedCollisionEntry", &[("enabled", Read("a row of the matrix"))]),
    ("moveit_msgs/LinkPadding", &[("link_name", Accepted("a padding is refused")), ("padding", Refused(CLEARANCE))]),
    ("moveit_msgs/LinkScale", &[("link_name", Accepted("a scale is refused")), ("scale", Only("1", CLEARANCE))]),
    (
        "moveit_msgs/PlanningSceneWorld",
        &[("collision_objects", In("moveit_msgs/CollisionObject")), ("octomap", In("octomap_msgs/OctomapWithPose"))],
    ),
    (
        "moveit_msgs/CollisionObject",
        &[
            ("header", In("std_msgs/Header")),
            ("pose", In("geometry_msgs/Pose")),
            ("id", Read("`obstacles[].name`")),
            ("type", Accepted("a label of a data base")),
            ("primitives", In("shape_msgs/SolidPrimitive")),
            ("primitive_poses", In("geometry_msgs/Pose")),
            ("meshes", Refused(SHAPES)),
            ("mesh_poses", Accepted(NO_MESHES)),
            ("planes", Refused(SHAPES)),
            ("plane_poses", Accepted("planes are refused")),
            ("subframe_names", Accepted("a goal in such a frame is refused")),
            ("subframe_poses", Accepted("a goal in such a frame is refused")),
            ("operation", Only("add", "the objects of a whole scene are added, as number 0")),
        ],
    ),
];
