//! The analytic derivatives of the dynamics, and the Jacobian of the control form.

use super::wrt::{Wrt, derivative, gathered, unfold};
use super::{Equality, Gf, Identity, Jet1, Jet2, RandomInstance};
use crate::dynamics::{
    Data, ForwardDynamicsDerivatives, InverseDynamicsSecondDerivatives, MassMatrixDerivatives, RneaVjp,
    RneaWeightedHessian, RootWrenchDerivatives, aba, aba_derivatives, crba_second_derivatives,
    mass_matrix_product_derivative, rnea_second_derivatives, rnea_vjp, rnea_weighted_hessian, root_wrench,
    root_wrench_second_order,
};
use crate::error::Result;
use crate::flow::RightHandSide;
use crate::flow::jacobian::{ControlFormJacobian, NodeBlocks};
use crate::model::{JointKind, JointSpec, Limits, Model};
use crate::scalar::AlgebraOver;
use crate::spatial::{Force, Inertia, Motion, Placement};
use crate::verify::reference::{
    At, bias_force, constant, entries, fd_0, inverse_dynamics, jacobian, mass, omega_by_definition, rate, vector,
};
use nalgebra::{DMatrix, DVector, Vector3};
use num_traits::{One, Zero};

/// The identities of this file.
pub(super) fn identities() -> Vec<Identity> {
    let law = |label, statement, claims| Identity {
        label,
        statement,
        convention: "rows are those of the function; the derivative index of a tensor comes last",
        claims,
    };
    vec![
        law("ABA_D", "dFD/dq, dFD/dv and H^-1", aba_d),
        law("CRBA_2D", "Hdot, dH/dq and d2H/dq2", crba_2d),
        law("RNEA_2D", "second derivatives of ID", rnea_2d),
        law("ABA_2D", "second derivatives of FD_0", aba_2d),
        law("contracted gradient", "gradient of w^T ID", gradient),
        law("contracted Hessian", "Hessian of w^T ID", hessian),
        law("root wrench", "torques of six joints at the root", root),
        law("root wrench derivatives", "Jacobian, and Hessian of m . f", root_second),
        law("crba contracted", "d(H w)/dq", contracted_mass),
        law("control form Jacobian", "its three blocks", control_form),
    ]
}

fn aba_d(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (n, node, tau) = (p.dof(), p.node(), p.w.as_slice());
    let (q, v) = (node.x_p1(), node.x_p2());
    let mut fd = ForwardDynamicsDerivatives::new(n);
    aba_derivatives(&p.model, &mut Data::new(&p.model), q, v, tau, &mut fd)?;
    let by_duals = jacobian(&[q, v, tau].concat(), |s| {
        let (mut a, data) = (DVector::zeros(n), &mut Data::new(&p.model));
        let (q, v, tau) = (&s[..n], &s[n..2 * n], &s[2 * n..]);
        aba(&p.model, data, q, v, tau, a.as_mut_slice())?;
        Ok(a)
    })?;
    let part = |i: usize| by_duals.columns(i * n, n).into_owned();
    let force = inverse_dynamics(&p.model, q, v, fd.a.as_slice())?;
    Ok(vec![
        Equality::vectors("FD", &force, &p.w),
        Equality::new("dFD/dq", fd.dq, part(0)),
        Equality::new("dFD/dv", fd.dv, part(1)),
        Equality::new("dFD/dtau", fd.h_inverse, part(2)),
    ])
}

fn crba_2d(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (q, rate) = (p.node().x_p1(), p.w.as_slice());
    let mut found = MassMatrixDerivatives::new(p.dof());
    crba_second_derivatives(&p.model, &mut Data::new(&p.model), q, rate, &mut found)?;
    of_mass(p, rate, &found)
}

/// Compares the results of CRBA_2D with dual numbers.
pub(super) fn of_mass(
    p: &RandomInstance,
    direction: &[Gf],
    found: &MassMatrixDerivatives<Gf>,
) -> Result<Vec<Equality>> {
    let (n, q) = (p.dof(), p.node().x_p1());
    let first = jacobian(q, |q| Ok(entries(&mass(&p.model, q)?)))?;
    let second = second(q, |q| Ok(entries(&mass(&p.model, q)?)))?;
    let along = rate(q, direction, |q| Ok(entries(&mass(&p.model, q)?)))?;
    let along = DMatrix::from_column_slice(n, n, along.as_slice());
    Ok(vec![
        Equality::new("H", found.h.clone(), mass(&p.model, q)?),
        Equality::new("Hdot", found.hdot.clone(), along),
        Equality::new("dH/dq", unfold(n, found.dq.entries()), first),
        Equality::new("d2H/dq2", unfold(n, found.dqdq.entries()), second),
    ])
}

fn rnea_2d(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (node, a) = (p.node(), p.node().xdot_p2());
    let (q, v) = (node.x_p1(), node.x_p2());
    let mut found = InverseDynamicsSecondDerivatives::new(p.dof());
    rnea_second_derivatives(&p.model, &mut Data::new(&p.model), q, v, a, &mut found)?;
    of_inverse_dynamics(p, a, &found)
}

/// Compares the results of RNEA_2D at the acceleration `a` with nested dual numbers.
pub(super) fn of_inverse_dynamics(
    p: &RandomInstance,
    a: &[Gf],
    found: &InverseDynamicsSecondDerivatives<Gf>,
) -> Result<Vec<Equality>> {
    let (n, node) = (p.dof(), p.node());
    let f = |s: &[Jet2]| inverse_dynamics(&p.model, &s[..n], &s[n..2 * n], &s[2 * n..]);
    let all = second(&[node.x_p1(), node.x_p2(), a].concat(), f)?;
    let claim = |what, entries: &[Gf], j, k| Equality::new(what, unfold(n, entries), part(&all, n, j, k));
    let zero = vec![Gf::default(); n * n * n];
    Ok(vec![
        claim("d2ID/dqdq", found.dqdq.entries(), 0, 0),
        claim("d2ID/dvdv", found.dvdv.entries(), 1, 1),
        claim("d2ID/dqdv", found.dqdv.entries(), 0, 1),
        claim("d2ID/dadq", found.dadq.entries(), 2, 0),
        claim("d2ID/dadv", &zero, 2, 1),
        claim("d2ID/dada", &zero, 2, 2),
    ])
}

/// Compares the second derivatives of the bias force, without an acceleration, with `found`.
pub(super) fn of_bias(p: &RandomInstance, found: &InverseDynamicsSecondDerivatives<Gf>) -> Result<Vec<Equality>> {
    let n = p.dof();
    let all = second(p.node().x, |x| bias_force(&p.model, &x[..n], &x[n..]))?;
    let claim = |what, entries: &[Gf], j, k| Equality::new(what, unfold(n, entries), part(&all, n, j, k));
    Ok(vec![
        claim("d2C/dqdq", found.dqdq.entries(), 0, 0),
        claim("d2C/dvdv", found.dvdv.entries(), 1, 1),
        claim("d2C/dqdv", found.dqdv.entries(), 0, 1),
    ])
}

pub(super) fn aba_2d(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (n, found) = (p.dof(), gathered(p)?.d2fd0);
    let all = second(p.node().x, |x| fd_0(&p.model, &x[..n], &x[n..]))?;
    let claim = |what, entries: &[Gf], j, k| Equality::new(what, unfold(n, entries), part(&all, n, j, k));
    Ok(vec![
        claim("d2FD/dqdq", found.dqdq.entries(), 0, 0),
        claim("d2FD/dvdv", found.dvdv.entries(), 1, 1),
        claim("d2FD/dqdv", found.dqdv.entries(), 0, 1),
    ])
}

/// All second derivatives of `f`: one column per last coordinate, rows for the function and, within it, for the first
/// one.
fn second(x: &[Gf], f: impl Fn(&[Jet2]) -> Result<DVector<Jet2>>) -> Result<DMatrix<Gf>> {
    jacobian(x, |x| Ok(entries(&jacobian(x, &f)?)))
}

/// The part of [`second`] in groups `j` and `k` of `N` coordinates, for a function with `N` entries.
fn part(all: &DMatrix<Gf>, n: usize, j: usize, k: usize) -> DMatrix<Gf> {
    all.view((j * n * n, k * n), (n * n, n)).into_owned()
}

/// $w^T ID$ at `[q; v; a]`.
fn contracted<S: AlgebraOver<Gf>>(p: &RandomInstance, s: &[S]) -> Result<DVector<S>> {
    let n = p.dof();
    let tau = inverse_dynamics(&p.model, &s[..n], &s[n..2 * n], &s[2 * n..])?;
    let sum = tau.iter().zip(&p.w).fold(S::zero(), |sum, (t, w)| sum + t.scale(*w));
    Ok(DVector::from_element(1, sum))
}

fn gradient(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (n, node) = (p.dof(), p.node());
    let (q, v, a, w) = (node.x_p1(), node.x_p2(), node.xdot_p2(), p.w.as_slice());
    let mut found = RneaVjp::new(n);
    rnea_vjp(&p.model, &mut Data::new(&p.model), q, v, a, w, &mut found)?;
    let by_duals = jacobian(&[q, v, a].concat(), |s| contracted(p, s))?.transpose();
    let part = |i: usize| vector(&by_duals.as_slice()[i * n..(i + 1) * n]);
    Ok(vec![
        Equality::vectors("in q", &found.q, &part(0)),
        Equality::vectors("in v", &found.v, &part(1)),
        Equality::vectors("in a", &found.a, &part(2)),
    ])
}

fn hessian(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (n, node) = (p.dof(), p.node());
    let (q, v, a, w) = (node.x_p1(), node.x_p2(), node.xdot_p2(), p.w.as_slice());
    let mut found = RneaWeightedHessian::new(n);
    rnea_weighted_hessian(&p.model, &mut Data::new(&p.model), q, v, a, w, &mut found)?;
    let all = second(&[q, v, a].concat(), |s| contracted(p, s))?;
    let part = |i: usize, j: usize| all.view((i * n, j * n), (n, n)).into_owned();
    let zero = DMatrix::zeros(n, n);
    Ok(vec![
        Equality::new("in q, q", found.qq, part(0, 0)),
        Equality::new("in q, v", found.qv, part(0, 1)),
        Equality::new("in v, v", found.vv, part(1, 1)),
        Equality::new("in q, a", found.qa, part(0, 2)),
        Equality::new("in v, a", zero.clone(), part(1, 2)),
        Equality::new("in a, a", zero, part(2, 2)),
    ])
}

/// The wrench as six numbers, moment first.
fn wrench_of<S: AlgebraOver<Gf>>(p: &RandomInstance, s: &[S]) -> Result<DVector<S>> {
    let (n, data) = (p.dof(), &mut Data::new(&p.model));
    let force = root_wrench(&p.model, data, &s[..n], &s[n..2 * n], &s[2 * n..])?;
    Ok(vector(&[force.angular.as_slice(), force.linear.as_slice()].concat()))
}

/// The robot on six joints at the root, three that turn and three that slide, which are massless but for the last one,
/// whose body is the base.
fn with_floating_base(p: &RandomInstance) -> Result<Model<Gf>> {
    let (model, zero, one) = (&p.model, Gf::default(), Gf::one());
    let unit = |i: usize| Vector3::from_fn(|k, _| if k == i { one } else { zero });
    let mut specs: Vec<_> = (0..6_usize)
        .map(|i| JointSpec {
            name: format!("root_{i}"),
            kind: if i < 3 { JointKind::Revolute } else { JointKind::Prismatic },
            parent: i.checked_sub(1),
            origin: Placement::identity(),
            axis: unit(i % 3),
            inertia: Inertia::zero(),
            limits: Limits::NONE,
        })
        .collect();
    specs[5].inertia = *model.base_inertia();
    for (joint, inertia) in model.joints().iter().zip(model.inertias()) {
        specs.push(JointSpec {
            name: joint.name().to_owned(),
            kind: joint.kind(),
            parent: Some(joint.parent().map_or(5, |parent| parent + 6)),
            origin: *joint.origin(),
            axis: *joint.axis(),
            inertia: *inertia,
            limits: Limits::NONE,
        });
    }
    Ok(Model::from_joints("on a floating base", specs)?.with_gravity(*model.gravity()))
}

fn root(p: &RandomInstance) -> Result<Vec<Equality>> {
    let node = p.node();
    let (q, v, a) = (node.x_p1(), node.x_p2(), node.xdot_p2());
    let still = |x: &[Gf]| [&[Gf::default(); 6], x].concat();
    let tau = inverse_dynamics(&with_floating_base(p)?, &still(q), &still(v), &still(a))?;
    let found = wrench_of(p, &[q, v, a].concat())?;
    let right = tau.rows(0, 6).into_owned();
    Ok(vec![Equality::vectors("f", &found, &right)])
}

fn root_second(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (n, node) = (p.dof(), p.node());
    let (q, v, a) = (node.x_p1(), node.x_p2(), node.xdot_p2());
    let (mut first, mut second_order) = (RootWrenchDerivatives::new(n), RneaWeightedHessian::new(n));
    let m = DVector::from_column_slice(&p.extra[..6]);
    let motion = Motion::new(vector3(&m, 0), vector3(&m, 3));
    let (data, weigh) = (&mut Data::new(&p.model), |_: &Force<Gf>| motion);
    root_wrench_second_order(&p.model, data, [q, v, a], weigh, &mut first, &mut second_order)?;
    let state = [q, v, a].concat();
    let wrench = [first.wrench.angular.as_slice(), first.wrench.linear.as_slice()].concat();
    let all = second(&state, |s| {
        let fixed = m.iter().zip(&wrench_of(p, s)?).map(|(m, f)| f.scale(*m)).collect::<Vec<_>>();
        let sum = fixed.into_iter().fold(Jet2::zero(), |sum, x| sum + x);
        Ok(DVector::from_element(1, sum))
    })?;
    let part = |i: usize, j: usize| all.view((i * n, j * n), (n, n)).into_owned();
    let zero = DMatrix::zeros(n, n);
    Ok(vec![
        Equality::vectors("f", &vector(&wrench), &wrench_of(p, &state)?),
        Equality::new("J", first.jacobian, jacobian(&state, |s| wrench_of(p, s))?),
        Equality::new("in q, q", second_order.qq, part(0, 0)),
        Equality::new("in q, v", second_order.qv, part(0, 1)),
        Equality::new("in v, v", second_order.vv, part(1, 1)),
        Equality::new("in q, a", second_order.qa, part(0, 2)),
        Equality::new("in v, a", zero.clone(), part(1, 2)),
        Equality::new("in a, a", zero, part(2, 2)),
    ])
}

fn vector3(m: &DVector<Gf>, first: usize) -> Vector3<Gf> {
    m.fixed_rows::<3>(first).into_owned()
}

fn contracted_mass(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (n, q) = (p.dof(), p.node().x_p1());
    let mut found = DMatrix::zeros(n, n);
    mass_matrix_product_derivative(&p.model, &mut Data::new(&p.model), q, p.w.as_slice(), &mut found)?;
    let w = vector(&constant(p.w.as_slice()));
    let by_duals = jacobian(q, |q| Ok(mass(&p.model, q)? * &w))?;
    Ok(vec![Equality::new("K", found, by_duals)])
}

/// The right-hand side in the control form, whose Jacobian is tested.
fn control_form_omega(at: &At<'_, Gf, Jet1>) -> Result<DVector<Jet1>> {
    let mut omega = DVector::zeros(at.node.x.len());
    crate::flow::ControlForm::new(at.model).omega(at.node, at.k, omega.as_mut_slice())?;
    Ok(omega)
}

fn control_form(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (t, mut found) = (gathered(p)?, NodeBlocks::new(p.dof()));
    ControlFormJacobian::new(&p.model).blocks(p.node(), p.k, &mut found)?;
    let by = |part| derivative(p, part, control_form_omega);
    let omega = super::theorem_b3::omega_of(p, crate::flow::ControlForm::new(&p.model))?;
    Ok(vec![
        Equality::vectors("Omega", &omega, &omega_by_definition(&p.at())?),
        Equality::new("dx by duals", found.dx.clone(), by(Wrt::X)?),
        Equality::new("dxdot by duals", found.dxdot.clone(), by(Wrt::Xdot)?),
        Equality::new("dxddot by duals", found.dxddot.clone(), by(Wrt::Xddot)?),
        Equality::new("dx by Theorem B4", found.dx, t.domega_dx(p.k)),
        Equality::new("dxdot by Theorem B4", found.dxdot, t.domega_dxdot(p.k)),
        Equality::new("dxddot by Theorem B4", found.dxddot, t.domega_dxddot()),
    ])
}
