//! Conditions about names of links and joints that a robot does not have.

use super::Model;
use crate::names::instead;
use crate::scalar::Scalar;

impl<C: Scalar> Model<C> {
    /// The condition of an error about a link that is not there, with the links or the nearest names of many.
    #[must_use]
    pub fn no_link(&self, name: &str) -> String {
        let names = self.frames().iter().map(|frame| frame.name.as_str());
        format!("the robot has no link '{name}'{}", instead(name, names))
    }

    /// The condition of an error about a link that is not there or does not move.
    #[must_use]
    pub fn no_moving_link(&self, name: &str) -> String {
        let moving = self.frames().iter().filter(|frame| frame.body.is_some());
        let names = instead(name, moving.map(|frame| frame.name.as_str()));
        format!("the robot has no link '{name}' that moves{names}")
    }

    /// The condition of an error about a joint that is not there or does not move.
    #[must_use]
    pub fn no_moving_joint(&self, name: &str) -> String {
        let names = instead(name, self.joints().iter().map(|joint| joint.name()));
        format!("the robot has no joint '{name}' that moves{names}")
    }
}
