//! The laws of the dynamics.

use super::{Equality, Gf, Identity, Jet1, RandomInstance};
use crate::dynamics::{
    Data, InverseDynamicsDerivatives, aba, bias, crba, forward_kinematics, frame_jacobian, frame_placement,
    mass_matrix_and_rate, rnea, rnea_derivatives,
};
use crate::error::Result;
use crate::model::Frame;
use crate::spatial::Placement;
use crate::verify::reference::{constant, dual, inverse_dynamics, jacobian};
use nalgebra::{DMatrix, DVector};

/// The identities of this file.
pub(super) fn identities() -> Vec<Identity> {
    let law = |label, statement, claims| Identity {
        label,
        statement,
        convention: "rows are those of the function, columns those of what it is differentiated in",
        claims,
    };
    vec![
        law("rnea", "ID(q, v, a) = H a + C", rnea_is_h_a_plus_c),
        law("aba", "FD(q, v, ID(q, v, a)) = a", aba_inverts_rnea),
        law("crba", "H is symmetric and dID/da", the_mass_matrix),
        law("Hdot", "Hdot = dH/dt along the velocity", hdot),
        law("frame Jacobian", "[R]' R^T = [J_angular]x and p' = J_linear", frames_move_as_their_jacobian_says),
        law("RNEA_D", "dID/dq and dID/dv by duals", rnea_d),
    ]
}

fn rnea_is_h_a_plus_c(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (n, node, data) = (p.dof(), p.node(), &mut Data::<Gf>::new(&p.model));
    let mut tau = DVector::zeros(n);
    rnea(&p.model, data, node.x_p1(), node.x_p2(), node.xdot_p2(), tau.as_mut_slice())?;
    let (mut h, mut c) = (DMatrix::zeros(n, n), DVector::zeros(n));
    crba(&p.model, data, node.x_p1(), &mut h)?;
    bias(&p.model, data, node.x_p1(), node.x_p2(), c.as_mut_slice())?;
    let right = h * DVector::from_column_slice(node.xdot_p2()) + c;
    Ok(vec![Equality::vectors("ID", &tau, &right)])
}

fn aba_inverts_rnea(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (n, node, data) = (p.dof(), p.node(), &mut Data::<Gf>::new(&p.model));
    let (mut tau, mut a) = (DVector::zeros(n), DVector::zeros(n));
    let (q, v) = (node.x_p1(), node.x_p2());
    rnea(&p.model, data, q, v, node.xdot_p2(), tau.as_mut_slice())?;
    aba(&p.model, data, q, v, tau.as_slice(), a.as_mut_slice())?;
    Ok(vec![Equality::vectors("a", &a, &DVector::from_column_slice(node.xdot_p2()))])
}

fn the_mass_matrix(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (n, node) = (p.dof(), p.node());
    let mut h = DMatrix::zeros(n, n);
    crba(&p.model, &mut Data::new(&p.model), node.x_p1(), &mut h)?;
    let by_duals = jacobian(node.xdot_p2(), |a| {
        let (q, v) = (constant(node.x_p1()), constant(node.x_p2()));
        inverse_dynamics(&p.model, &q, &v, a)
    })?;
    Ok(vec![Equality::new("symmetry", h.clone(), h.transpose()), Equality::new("dID/da", h, by_duals)])
}

fn hdot(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (n, node) = (p.dof(), p.node());
    let (mut h, mut hdot) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
    let (q, w) = (node.x_p1(), node.xdot_p1());
    mass_matrix_and_rate(&p.model, &mut Data::new(&p.model), q, w, &mut h, &mut hdot)?;
    let mut moving_h = DMatrix::zeros(n, n);
    crba(&p.model, &mut Data::new(&p.model), &dual(q, w), &mut moving_h)?;
    Ok(vec![Equality::new("H", h, moving_h.map(|h| h.re)), Equality::new("Hdot", hdot, moving_h.map(|h| h.eps[0]))])
}

fn rnea_d(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (n, node) = (p.dof(), p.node());
    let (q, v, a) = (node.x_p1(), node.x_p2(), node.xdot_p2());
    let mut id = InverseDynamicsDerivatives::new(n);
    rnea_derivatives(&p.model, &mut Data::new(&p.model), q, v, a, &mut id)?;
    let state = [q, v, a].concat();
    let by_duals = jacobian(&state, |s| inverse_dynamics(&p.model, &s[..n], &s[n..2 * n], &s[2 * n..]))?;
    let part = |i: usize| by_duals.columns(i * n, n).into_owned();
    Ok(vec![
        Equality::new("dID/dq", id.dq, part(0)),
        Equality::new("dID/dv", id.dv, part(1)),
        Equality::new("dID/da", id.h, part(2)),
    ])
}

/// Tests a frame off the origin of every body by dual numbers of forward kinematics.
fn frames_move_as_their_jacobian_says(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (n, q) = (p.dof(), p.node().x_p1());
    let mut claims = Vec::new();
    for body in 0..n {
        let frame = Frame::new("", Some(body), *p.model.joints()[n - 1 - body].origin());
        let mut ours = DMatrix::zeros(6, n);
        frame_jacobian(&p.model, &mut Data::new(&p.model), q, &frame, &mut ours)?;
        let place = |q: &[Jet1]| {
            let mut bodies = vec![Placement::identity(); n];
            forward_kinematics(&p.model, q, &mut bodies)?;
            frame_placement(&frame, &bodies)
        };
        let rotation = place(&constant(q))?.rotation.map(|r| r.re);
        let reference = jacobian(q, |q| {
            let placement = place(q)?;
            let turning = placement.rotation * rotation.transpose().map(Jet1::constant);
            let turning = [turning.m32, turning.m13, turning.m21];
            let rates = turning.iter().chain(&placement.translation);
            Ok(DVector::from_iterator(6, rates.copied()))
        })?;
        claims.push(Equality::new("J", ours, reference));
    }
    Ok(claims)
}
