//! Scenario files of version 0.2: the keys that were removed, the form that replaced each, and the translation.

use crate::ScenarioFile;
use crate::keys::json::{by_name, read_json};
use aghf::error::{Error, Result};
use aghf::spatial::unit_vector;
use nalgebra::{UnitQuaternion, Vector3};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// The other keys of version 0.2, which are still there.
const KEPT: [&str; 17] = [
    "robot",
    "mimic",
    "locked_joints",
    "passive",
    "horizon_s",
    "q_start",
    "v_start",
    "q_goal",
    "v_goal",
    "free_final_velocity",
    "free_horizon",
    "robot_shape",
    "self_collision",
    "enforced_limits",
    "flow",
    "feedback",
    "success_threshold",
];

/// The defaults of version 0.2 that are others now.
const DEFAULTS: [(&str, &str); 3] =
    [("robot_shape", "joint_frames"), ("self_collision", "off"), ("continuity", "velocity")];

/// The keys whose words had hyphens.
const HYPHENS: [&str; 2] = ["robot_shape", "flow.guess"];

/// The keys of version 0.2 that were removed, with dots before those of inner objects.
const FORMER: [(&str, Form); 9] = [
    ("sphere_obstacles", Form::Obstacle("sphere", &["radius_m"], "\"radius_m\": r")),
    ("box_obstacles", Form::Obstacle("box", &["size_m"], "\"size_m\": [x, y, z]")),
    ("cylinder_obstacles", Form::Obstacle("cylinder", &["radius_m", "length_m"], "\"radius_m\": r, \"length_m\": l")),
    ("capsule_obstacles", Form::Obstacle("capsule", &["radius_m"], "\"radius_m\": r, \"length_m\": l")),
    ("half_spaces", Form::Obstacle("half_space", &[], "")),
    ("running_cost", Form::Weights("\"effort\": w, \"velocity\": w, \"acceleration\": w")),
    ("free_horizon.weight", Form::Weights("\"time\": w")),
    ("robot_shape.collision.spacing_m", Form::Excess),
    ("flow.p", Form::Degree),
];

/// The excess of a ball about a cell of a box beyond its face, relative to the edge of the cell: the spacing of version
/// 0.2 was the longest edge.
const EXCESS: f64 = 0.366_025_403_784_438_6;

/// The form that replaced a key.
#[derive(Clone, Copy)]
enum Form {
    /// An obstacle in one list, by its shape, the keys of it that moved there, and an example of all.
    Obstacle(&'static str, &'static [&'static str], &'static str),
    /// Weights of the objective, by an example.
    Weights(&'static str),
    /// The excess of balls in place of their spacing.
    Excess,
    /// The degree of the flow by its whole name.
    Degree,
}

/// The key that replaced the one at `path` of a file, in words, if that is one of version 0.2.
pub(crate) fn instead_of(path: &str) -> Option<String> {
    let is_at = |key: &str| path.strip_suffix(key).is_some_and(|rest| rest.is_empty() || rest.ends_with('.'));
    let (_, form) = FORMER.iter().find(|(key, _)| is_at(key))?;
    let needed = match form {
        Form::Obstacle(shape, _, keys) => format!(
            "obstacles of every shape are in one list: \"obstacles\": [{{\"shape\": {{\"{shape}\": {{{keys}}}}}, \
             \"pose\": {{\"position_m\": [x, y, z]}}}}]"
        ),
        Form::Weights(weights) => {
            format!("all weights are in one object: \"objective\": {{\"units\": \"si\", {weights}}}")
        }
        Form::Excess => {
            "the pieces of meshes are chosen by the distance by which they extend beyond these: \"excess_m\"".to_owned()
        }
        Form::Degree => "the key has its whole name: \"degree\"".to_owned(),
    };
    Some(format!("{needed} is needed; `aghf scenarios --upgrade FILE` rewrites a scenario of version 0.2"))
}

/// The keys of a file, none of them twice.
#[derive(Serialize, Deserialize)]
struct Keys(#[serde(deserialize_with = "by_name")] BTreeMap<String, Value>);

impl ScenarioFile {
    /// Reads a scenario of version 0.2 as one of this version with the same meaning: defaults that have changed since
    /// are written out. One of this version is read as it is. `path` names the text in errors.
    ///
    /// # Errors
    /// Names the file, a key without a translation, and the reason.
    pub fn upgrade(text: &str, path: &str) -> Result<Self> {
        let Keys(keys) = read_json(text, path)?;
        let former = |key: &str| FORMER.iter().any(|(former, _)| *former == key);
        let is_old = keys.keys().all(|key| KEPT.contains(&&**key) || former(key));
        let mut scenario = Value::Object(keys.into_iter().collect());
        for (key, form) in FORMER {
            let Some(value) = take(&mut scenario, key) else {
                continue;
            };
            let at = Place { file: path, key };
            match form {
                Form::Obstacle(shape, keys, _) => obstacles(value, (shape, keys), &at, &mut scenario),
                Form::Weights(_) => weights(value, &at, &mut scenario),
                Form::Excess => at.number(&value).map(|spacing| {
                    scenario["robot_shape"]["collision"]["excess_m"] = json!(EXCESS * spacing);
                }),
                Form::Degree => at.set_new(&mut scenario["flow"], "degree", value),
            }?;
        }
        for key in HYPHENS {
            if let Some(value) = scenario.pointer_mut(&format!("/{}", key.replace('.', "/"))) {
                underscored(value);
            }
        }
        for (key, default) in DEFAULTS.iter().filter(|_| is_old) {
            if scenario[*key].is_null() {
                scenario[*key] = json!(default);
            }
        }
        read_json(&scenario.to_string(), path)
    }
}

/// Removes the value of a key with dots before those of inner objects.
fn take(scenario: &mut Value, key: &str) -> Option<Value> {
    match key.rsplit_once('.') {
        None => scenario.as_object_mut()?.remove(key),
        Some((outer, inner)) => {
            let outer = scenario.pointer_mut(&format!("/{}", outer.replace('.', "/")))?;
            outer.as_object_mut()?.remove(inner)
        }
    }
}

/// Replaces hyphens in a word, or in the only key of an object.
fn underscored(value: &mut Value) {
    match value {
        Value::String(word) => *word = word.replace('-', "_"),
        Value::Object(keys) => {
            let renamed = std::mem::take(keys).into_iter();
            *keys = renamed.map(|(key, value)| (key.replace('-', "_"), value)).collect();
        }
        _ => {}
    }
}

/// The place of a key in a file, for errors.
struct Place<'p> {
    file: &'p str,
    key: &'p str,
}

impl Place<'_> {
    fn refuse<T>(&self, condition: impl Into<String>) -> Result<T> {
        Err(Error::input(self.file, self.key, condition))
    }

    /// The value as one of this type.
    fn read<T: DeserializeOwned>(&self, value: Value) -> Result<T> {
        serde_json::from_value(value).or_else(|e| self.refuse(e.to_string()))
    }

    fn number(&self, value: &Value) -> Result<f64> {
        self.read(value.clone())
    }

    /// Sets a key of an object that does not have it yet.
    fn set_new(&self, object: &mut Value, key: &str, value: Value) -> Result<()> {
        match object.as_object_mut() {
            Some(object) if !object.contains_key(key) => {
                object.insert(key.to_owned(), value);
                Ok(())
            }
            _ => self.refuse(format!("it is `{key}` now, which is there too")),
        }
    }
}

/// Puts weights into the objective.
fn weights(value: Value, at: &Place<'_>, scenario: &mut Value) -> Result<()> {
    let weights = match value {
        Value::Null => return Ok(()),
        Value::Object(weights) => weights,
        second => Map::from_iter([("time".to_owned(), second)]),
    };
    let units = json!({ "units": "si" });
    let keys = scenario.as_object_mut().into_iter();
    for objective in keys.map(|keys| keys.entry("objective").or_insert(units.clone())) {
        if objective["units"] != units["units"] {
            return at.refuse("its weights are in SI units, and so are not those of the objective that is there too");
        }
        for (key, weight) in &weights {
            let now = match key.as_str() {
                "torque" => "effort",
                "velocity" | "acceleration" | "time" => key,
                _ => return at.refuse(format!("version 0.2 had no weight `{key}`")),
            };
            at.set_new(objective, now, weight.clone())?;
        }
    }
    Ok(())
}

/// Puts obstacles of a shape, which has these keys, into the one list.
fn obstacles(value: Value, of: (&str, &[&str]), at: &Place<'_>, scenario: &mut Value) -> Result<()> {
    let former: Vec<Map<String, Value>> = at.read(value)?;
    let mut moved = Vec::with_capacity(former.len());
    for (i, former) in former.into_iter().enumerate() {
        let key = format!("{}[{i}]", at.key);
        moved.push(obstacle(former, of, &Place { file: at.file, key: &key })?);
    }
    let keys = scenario.as_object_mut().into_iter();
    for list in keys.map(|keys| keys.entry("obstacles").or_insert(json!([]))) {
        match list {
            Value::Array(list) => list.append(&mut moved),
            _ => {
                return at.refuse("its obstacles are in the list `obstacles` now, and that is no list");
            }
        }
    }
    Ok(())
}

/// The obstacle in the form of this version.
fn obstacle(mut former: Map<String, Value>, (shape, keys): (&str, &[&str]), at: &Place<'_>) -> Result<Value> {
    let mut taken = |key: &str| match former.remove(key) {
        Some(value) => Ok(value),
        None => at.refuse(format!("missing field `{key}`")),
    };
    let mut size = Map::new();
    for key in keys {
        size.insert((*key).to_owned(), taken(key)?);
    }
    let pose = match shape {
        "capsule" => {
            let [from, to] = at.read::<[[f64; 3]; 2]>(taken("ends_m")?)?.map(Vector3::from);
            size.insert("length_m".to_owned(), json!((to - from).norm()));
            pose((from + to) * 0.5, &(to - from), at)?
        }
        "half_space" => {
            let normal = Vector3::from(at.read::<[f64; 3]>(taken("normal")?)?);
            let offset = at.number(&taken("offset_m")?)?;
            pose(unit_vector(&normal).unwrap_or_default() * offset, &normal, at)?
        }
        _ => {
            let centre = taken("center_m")?;
            match former.remove("orientation_xyzw") {
                Some(turn) if shape != "sphere" => {
                    json!({ "position_m": centre, "orientation_xyzw": turn })
                }
                Some(_) => return at.refuse("unknown field `orientation_xyzw`"),
                None => json!({ "position_m": centre }),
            }
        }
    };
    let name = former.remove("name");
    if let Some(key) = former.keys().next() {
        return at.refuse(format!("unknown field `{key}`"));
    }
    let mut now = json!({ "shape": { shape: size }, "pose": pose });
    if let Some(name) = name {
        now["name"] = name;
    }
    Ok(now)
}

/// The pose at a position whose `z` axis has this direction.
fn pose(position: Vector3<f64>, z: &Vector3<f64>, at: &Place<'_>) -> Result<Value> {
    let Some(z) = unit_vector(z) else {
        return at.refuse("the direction has length zero");
    };
    // Opposite to the axis any half turn is right.
    let turn = UnitQuaternion::rotation_between(&Vector3::z(), &z)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), PI));
    // A zero without a sign.
    let position: Vec<_> = position.iter().map(|x| x + 0.0).collect();
    Ok(if turn == UnitQuaternion::identity() {
        json!({ "position_m": position })
    } else {
        json!({ "position_m": position, "orientation_xyzw": turn.coords.as_slice() })
    })
}
