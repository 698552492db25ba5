//! Jacobians by name.

use aghf::flow::jacobian::{ControlFormJacobian, JacobianKind, Jacobians};
use aghf::model::random_tree;
use aghf::verify::duals::{CheckOptions, check_jacobians};

#[test]
fn a_jacobian_is_registered_by_name() {
    let model = random_tree(3, 1).expect("there are joints");
    let mut jacobians = Jacobians::built_in();
    let built_in = JacobianKind::by_name().count();
    assert_eq!(jacobians.names().count(), built_in);
    jacobians.register("mine", |model| Box::new(ControlFormJacobian::new(model))).expect("a new name");
    let taken = jacobians.register("dual", |model| Box::new(ControlFormJacobian::new(model)));
    assert!(taken.expect_err("taken").to_string().contains("'dual' is taken"));
    let error = jacobians.build("magic", &model).err().expect("no such name").to_string();
    for word in ["'magic'", "control_form", "theorem_b4", "dual", "difference", "mine"] {
        assert!(error.contains(word), "{error}");
    }
    let options = CheckOptions { samples: 1, seed: 3, penalties: vec![1e4] };
    let findings = check_jacobians(&model, &jacobians, &options).expect("same robot");
    let mine = findings.iter().filter(|f| f.quantity.contains("mine"));
    assert!(mine.clone().count() >= 5 && mine.clone().all(aghf::verify::duals::Finding::passes));
}

#[test]
fn names_are_read_and_written() {
    for (name, kind) in JacobianKind::by_name() {
        assert_eq!(kind.to_string(), name);
        assert_eq!(name.parse::<JacobianKind>().expect("its name"), kind);
        assert_eq!(serde_json::to_string(&kind).expect("a name"), format!("\"{name}\""));
    }
    let error = "magic".parse::<JacobianKind>().expect_err("no such name").to_string();
    assert!(error.contains("jacobian: 'magic' is none of control_form, theorem_b4"), "{error}");
}
