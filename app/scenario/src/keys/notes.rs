//! Notes on a scenario: keys that a method ignores, bodies that keep clear by default, and turns that are not taken.

use crate::{IgnoredPair, Method, Objective, RobotShape, Scenario};

impl Scenario {
    /// The keys of this scenario that the method ignores, and the bodies that keep clear by default, in words.
    pub(crate) fn notes(&self, method: Method) -> Vec<String> {
        let unnamed = |IgnoredPair { links: [a, b], reason }: &IgnoredPair| {
            format!("self_collision: links '{a}' and '{b}' {reason}, so they are not kept clear of each other")
        };
        let mut notes = self.turned.clone();
        notes.extend(self.notes_on_start());
        notes.extend(self.overlapping.iter().map(unnamed));
        notes.extend(self.kept_clear().map(str::to_owned));
        let weighted = matches!(self.file.objective, Objective::Weights(_));
        if method == Method::Flow && weighted {
            notes.push("objective: the published flow minimises the control effort alone".to_owned());
        }
        notes
    }

    /// The note on the bodies that keep clear of each other by default.
    fn kept_clear(&self) -> Option<&'static str> {
        let file = &self.file;
        match (self.robot_shape(), &file.robot_shape, &file.self_collision) {
            (RobotShape::JointFrames, None, _) if !file.obstacles.is_empty() => Some(
                "robot_shape: the robot has no collision shapes, so only the origins of joint frames keep clear of \
                 obstacles; \"swept_links\" takes its links with a radius",
            ),
            (RobotShape::Collision { .. }, None, None) => Some(
                "robot_shape: the collision shapes of the robot keep clear of obstacles, and of each other but for \
                 neighbours; \"joint_frames\" plans without them",
            ),
            (RobotShape::Collision { .. }, None, Some(_)) if !file.obstacles.is_empty() => Some(
                "robot_shape: the collision shapes of the robot keep clear of obstacles; \"joint_frames\" plans \
                 without them",
            ),
            (RobotShape::Collision { .. }, Some(_), None) => {
                Some("self_collision: links keep clear of each other but for neighbours; \"off\" lets them overlap")
            }
            _ => None,
        }
    }
}
