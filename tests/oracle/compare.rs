//! The dynamics of this library compared with Pinocchio's, quantity by quantity.

use crate::python::{Oracle, Quantities};
use aghf::dynamics::{
    Data, ForwardDynamicsDerivatives, InverseDynamicsDerivatives, InverseDynamicsSecondDerivatives,
    RneaWeightedHessian, RootWrenchDerivatives, aba, aba_derivatives, bias, crba, forward_kinematics, frame_jacobian,
    frame_placement, kinetic_energy, mass_matrix_and_rate, potential_energy, rnea, rnea_derivatives,
    rnea_second_derivatives, root_wrench, root_wrench_second_order,
};
use aghf::model::Model;
use aghf::spatial::{Motion, Placement};
use nalgebra::{DMatrix, Vector3};
use proptest::prelude::*;
use std::collections::BTreeMap;
use std::fmt;

/// The largest error of a quantity: the largest difference over the largest entry.
pub const BOUND: f64 = 1e-9;

/// The smallest reference magnitude, in SI units: with gravity along a vertical axis both sides are zero up to the
/// rounding of terms that cancel, which may be some hundreds of N m.
pub const FLOOR: f64 = 1e-3;

/// The outcome of the comparison, quantity by quantity.
#[derive(Debug, Default)]
pub struct Comparison {
    /// The worst relative error of each quantity.
    pub worst: BTreeMap<String, f64>,
    /// The quantities whose error exceeds its bound.
    pub off: Vec<String>,
}

impl Comparison {
    /// Records an error.
    pub fn add(&mut self, name: &str, error: f64, bound: f64) {
        let worst = self.worst.entry(name.to_owned()).or_default();
        *worst = worst.max(error);
        if error > bound {
            self.off.push(format!("{name} is off by {error:.1e}, more than {bound:.1e}"));
        }
    }

    /// Records all errors of another comparison.
    pub fn merge(&mut self, other: Self) {
        for (name, error) in &other.worst {
            self.add(name, *error, f64::INFINITY);
        }
        self.off.extend(other.off);
    }

    /// Records the errors of quantities that have the same names on both sides, with a floor and a bound for each.
    pub fn compare(
        &mut self,
        ours: &Quantities,
        theirs: &Quantities,
        floor: impl Fn(&str) -> f64,
        bound: impl Fn(&str) -> f64,
    ) {
        assert!(ours.keys().eq(theirs.keys()), "different quantities");
        for ((name, ours), theirs) in ours.iter().zip(theirs.values()) {
            self.add(name, relative_error(ours, theirs, floor(name)), bound(name));
        }
    }
}

/// One line per quantity.
impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        (self.worst.iter()).try_for_each(|(name, error)| writeln!(f, "{name}: {error:.1e}"))
    }
}

/// `q, v, a, tau`.
pub type State = [Vec<f64>; 4];

/// A random state with the positions within the limits.
pub fn state(model: &Model) -> impl Strategy<Value = State> + use<> {
    let within = model.joints().iter().map(|joint| {
        let limits = joint.limits();
        let lower = if limits.lower.is_finite() { limits.lower } else { limits.upper.min(3.0) - 6.0 };
        let upper = if limits.upper.is_finite() { limits.upper } else { lower.max(-3.0) + 6.0 };
        lower..=upper
    });
    let n = model.dof();
    let numbers = || crate::common::numbers(n);
    (within.collect::<Vec<_>>(), numbers(), numbers(), numbers()).prop_map(|(q, v, a, tau)| [q, v, a, tau])
}

/// The largest difference relative to the largest entry of `theirs`, or to `floor` where that is smaller.
pub fn relative_error(ours: &DMatrix<f64>, theirs: &DMatrix<f64>, floor: f64) -> f64 {
    assert_eq!(ours.shape(), theirs.shape(), "different sizes");
    if ours.iter().chain(theirs).any(|x| !x.is_finite()) {
        return f64::INFINITY;
    }
    (ours - theirs).amax() / theirs.amax().max(floor)
}

/// Asserts that both sides have the same joints on the same parents and the same links, in the same order.
pub fn assert_same_names(model: &Model, oracle: &Oracle) {
    let theirs = oracle.names();
    let name = |i: usize| model.joints()[i].name().to_owned();
    let joints: Vec<_> = (0..model.dof()).map(name).collect();
    let parents = model.joints().iter().map(|j| j.parent());
    let parents: Vec<_> = parents.map(|p| p.map_or("universe".to_owned(), name)).collect();
    let links: Vec<_> = model.frames().iter().map(|f| f.name.clone()).collect();
    for (what, ours) in [("joints", joints), ("parents", parents), ("links", links)] {
        assert_eq!(ours, theirs[what], "{what} of {}", model.name());
    }
}

/// Compares all quantities for which Pinocchio has a function.
///
/// Forward dynamics solve with `H`, on both sides by methods with an error of the condition number of `H` times the
/// rounding of one number.
pub fn compare_dynamics(model: &Model, oracle: &Oracle, state: &State) -> Comparison {
    let [q, v, a, tau] = state;
    let theirs = oracle.call("dynamics", &[q, v, a, tau]);
    let eigenvalues = theirs["H"].symmetric_eigenvalues();
    let solve = f64::EPSILON * eigenvalues.max() / eigenvalues.min();
    let bound = |name: &str| BOUND + if name.contains("FD") { solve } else { 0.0 };
    let mut comparison = Comparison::default();
    comparison.compare(&dynamics(model, state), &theirs, |_| FLOOR, bound);
    comparison
}

/// Compares the second derivatives of inverse dynamics.
///
/// Their rounding is relative to the first derivatives in the differences, so these are the floor.
pub fn compare_second_derivatives(model: &Model, oracle: &Oracle, state: &State) -> Comparison {
    let ([q, v, a, _], n) = (state, model.dof());
    let mut data = Data::new(model);
    let mut first = InverseDynamicsDerivatives::new(n);
    rnea_derivatives(model, &mut data, q, v, a, &mut first).expect("lengths agree");
    let mut second = InverseDynamicsSecondDerivatives::new(n);
    rnea_second_derivatives(model, &mut data, q, v, a, &mut second).expect("lengths agree");
    let (mut root, mut of_root) = (RootWrenchDerivatives::new(n), RneaWeightedHessian::new(n));
    let motion = Motion::new(Vector3::new(1.0, 2.0, 3.0), Vector3::new(4.0, 5.0, 6.0));
    root_wrench_second_order(model, &mut data, [q, v, a], |_| motion, &mut root, &mut of_root).expect("lengths agree");
    let tensors = [
        ("d2ID/dqdq", second.dqdq(), &first.dq),
        ("d2ID/dqdv", second.dqdv(), &first.dq),
        ("d2ID/dvdv", second.dvdv(), &first.dv),
        ("d2ID/dadq", second.dadq(), &first.h),
    ];
    let column = |t: &[f64]| DMatrix::from_column_slice(t.len(), 1, t);
    let tensors = tensors.map(|(name, tensor, first)| (name, column(tensor.entries()), first));
    let matrices = [
        ("d2root/dqdq", of_root.qq),
        ("d2root/dqdv", of_root.qv),
        ("d2root/dvdv", of_root.vv),
        ("d2root/dqda", of_root.qa),
    ];
    let matrices = matrices.map(|(name, m)| (name, column(m.as_slice()), &root.jacobian));
    let all: Vec<_> = tensors.into_iter().chain(matrices).collect();
    let floors = all.iter().map(|(name, _, first)| (*name, first.amax().max(FLOOR)));
    let floors: BTreeMap<_, _> = floors.collect();
    let ours: Quantities = all.into_iter().map(|(name, ours, _)| (name.to_owned(), ours)).collect();
    let theirs = oracle.call("second_derivatives", &[q, v, a]);
    let mut comparison = Comparison::default();
    comparison.compare(&ours, &theirs, |name| floors[name], |_| BOUND);
    comparison
}

/// The values of this library under the names in `Robot.dynamics`.
fn dynamics(model: &Model, [q, v, a, tau]: &State) -> Quantities {
    let n = model.dof();
    let data = &mut Data::new(model);
    let zeros = vec![0.0; n];
    let vector = |f: &mut dyn FnMut(&mut [f64]) -> aghf::Result<()>| {
        let mut out = DMatrix::zeros(n, 1);
        f(out.as_mut_slice()).expect("lengths agree");
        out
    };
    let (mut h, mut hdot, mut h_too) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n), DMatrix::zeros(n, n));
    crba(model, data, q, &mut h).expect("lengths agree");
    mass_matrix_and_rate(model, data, q, v, &mut h_too, &mut hdot).expect("lengths agree");
    let mut id = InverseDynamicsDerivatives::new(n);
    rnea_derivatives(model, data, q, v, a, &mut id).expect("lengths agree");
    let (mut root, mut of_root) = (RootWrenchDerivatives::new(n), RneaWeightedHessian::new(n));
    let still = |_: &_| Motion::zero();
    root_wrench_second_order(model, data, [q, v, a], still, &mut root, &mut of_root).expect("lengths agree");
    let wrench = root_wrench(model, data, q, v, a).expect("lengths agree");
    let wrench = [wrench.angular.as_slice(), wrench.linear.as_slice()].concat();
    let of_part = |part: usize| root.jacobian.columns(part * n, n).into_owned();
    let mut fd = ForwardDynamicsDerivatives::new(n);
    aba_derivatives(model, data, q, v, tau, &mut fd).expect("lengths agree");
    let kinetic = kinetic_energy(model, data, q, v).expect("lengths agree");
    let potential = potential_energy(model, data, q).expect("lengths agree");
    let all = [
        ("ID", vector(&mut |out| rnea(model, data, q, v, a, out))),
        ("C", vector(&mut |out| bias(model, data, q, v, out))),
        ("gravity", vector(&mut |out| bias(model, data, q, &zeros, out))),
        ("FD", vector(&mut |out| aba(model, data, q, v, tau, out))),
        ("kinetic energy", DMatrix::from_element(1, 1, kinetic)),
        ("potential energy", DMatrix::from_element(1, 1, potential)),
        ("H", h),
        ("Hdot", hdot),
        ("dID/dq", id.dq),
        ("dID/dv", id.dv),
        ("dID/da", id.h),
        ("root wrench", DMatrix::from_column_slice(6, 1, &wrench)),
        ("droot/dq", of_part(0)),
        ("droot/dv", of_part(1)),
        ("droot/da", of_part(2)),
        ("dFD/dq", fd.dq),
        ("dFD/dv", fd.dv),
        ("dFD/dtau", fd.h_inverse),
    ];
    let all = all.into_iter().chain(kinematics(model, data, q));
    all.map(|(name, value)| (name.to_owned(), value)).collect()
}

fn kinematics(model: &Model, data: &mut Data, q: &[f64]) -> [(&'static str, DMatrix<f64>); 4] {
    let n = model.dof();
    let mut bodies = vec![Placement::identity(); n];
    forward_kinematics(model, q, &mut bodies).expect("lengths agree");
    let links = model.frames().iter();
    let links = links.map(|f| frame_placement(f, &bodies).expect("the body is there"));
    let mut axes = DMatrix::zeros(6, n);
    let mut jacobians = DMatrix::zeros(6 * model.frames().len(), n);
    for (i, joint) in model.joints().iter().enumerate() {
        let axis = joint.motion_subspace(&bodies[i]);
        axes.fixed_view_mut::<3, 1>(0, i).copy_from(&axis.angular);
        axes.fixed_view_mut::<3, 1>(3, i).copy_from(&axis.linear);
    }
    for (i, frame) in model.frames().iter().enumerate() {
        let mut jacobian = DMatrix::zeros(6, n);
        frame_jacobian(model, data, q, frame, &mut jacobian).expect("lengths agree");
        jacobians.rows_mut(6 * i, 6).copy_from(&jacobian);
    }
    [
        ("joint axes", axes),
        ("link Jacobians", jacobians),
        ("link placements", rows(links)),
        ("joint placements", rows(bodies.iter().copied())),
    ]
}

/// One row per placement: its rotation by rows, and its translation.
fn rows(placements: impl Iterator<Item = Placement<f64>>) -> DMatrix<f64> {
    let numbers: Vec<f64> =
        placements.flat_map(|p| [p.rotation.transpose().as_slice(), p.translation.as_slice()].concat()).collect();
    DMatrix::from_row_slice(numbers.len() / 12, 12, &numbers)
}
