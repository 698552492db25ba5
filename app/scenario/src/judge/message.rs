//! A motion from a message of ROS 2.

use super::Trajectory;
use crate::{JointTrajectory, JointTrajectoryPoint};
use aghf::error::{Error, Result};
use aghf::model::Model;

/// The lists of a point.
const LISTS: [(&str, List); 4] = [
    ("positions", |point| &point.positions),
    ("velocities", |point| &point.velocities),
    ("accelerations", |point| &point.accelerations),
    ("effort", |point| &point.effort),
];

type List = fn(&JointTrajectoryPoint) -> &Vec<f64>;

impl Trajectory {
    /// The motion in a message for `model`, with its joints in any order. All points have positions, and all or none
    /// each of velocities, accelerations, not without velocities, and effort. `file` names the message in errors. Cost
    /// O(N) per point.
    ///
    /// # Errors
    /// The joints are not those of the robot; a list has another length; the times do not ascend; or there are fewer
    /// than two points.
    pub fn of_message(message: &JointTrajectory, file: &str, model: &Model) -> Result<Self> {
        let refuse = |element: String, condition: String| Error::input(file, element, condition);
        let names = &message.joint_names;
        let place = |name: &str| names.iter().position(|own| own == name);
        let joints: Option<Vec<usize>> = model.joints().iter().map(|j| place(j.name())).collect();
        let joints = joints.filter(|joints| joints.len() == names.len()).ok_or_else(|| {
            let condition = "they are not the joints of the robot that move";
            refuse("joint_names".to_owned(), condition.to_owned())
        })?;
        let points = &message.points;
        if points.len() < 2 {
            let condition = format!("{} are given, at least 2 are needed", points.len());
            return Err(refuse("points".to_owned(), condition));
        }
        let times: Vec<f64> = points.iter().map(|p| p.time_from_start.seconds()).collect();
        if let Some(k) = times.windows(2).position(|pair| pair[0] >= pair[1]) {
            let condition = format!("{} s does not come after {} s", times[k + 1], times[k]);
            return Err(refuse(format!("points[{}].time_from_start", k + 1), condition));
        }
        let mut tables = [const { None }; LISTS.len()];
        for ((name, list), table) in LISTS.into_iter().zip(&mut tables) {
            if name != LISTS[0].0 && points.iter().all(|point| list(point).is_empty()) {
                continue;
            }
            let wrong = points.iter().position(|point| list(point).len() != joints.len());
            if let Some(k) = wrong {
                let (found, wanted) = (list(&points[k]).len(), joints.len());
                let condition = format!("it has {found} numbers, there are {wanted} joints");
                return Err(refuse(format!("points[{k}].{name}"), condition));
            }
            let of_point = |point| joints.iter().map(|i| list(point)[*i]).collect();
            *table = Some(points.iter().map(of_point).collect());
        }
        Self::of_tables(file, times, tables)
    }
}
