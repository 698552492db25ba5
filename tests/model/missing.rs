//! Errors about names that a robot does not have.

use aghf::model::pendulum;
use aghf::urdf::builtin_robot;

#[test]
fn the_names_are_listed_if_they_are_few() {
    let model = pendulum(2).expect("it is good");
    let [a, b] = [0, 1].map(|i| model.joints()[i].name());
    let words = format!("the robot has no joint 'x' that moves; there are '{a}', '{b}'");
    assert_eq!(model.no_moving_joint("x"), words);
}

#[test]
fn of_many_names_the_nearest_are_listed() {
    let model = builtin_robot("digit_v3_pinned").expect("it is built in");
    let own = |frame: &&aghf::model::Frame<f64>| frame.body.is_some();
    for frame in model.frames().iter().filter(own) {
        // A digit or letter is missing, or the name has another one before it.
        for name in [&frame.name[1..], &format!("my_{}", frame.name)] {
            let words = model.no_moving_link(name);
            assert!(words.contains("; the nearest of "), "{words}");
            assert!(words.contains(&format!("'{}'", frame.name)), "{words}");
        }
    }
    let words = model.no_link("left-knee");
    assert!(words.contains("are 'left_knee'"), "{words}");
}
