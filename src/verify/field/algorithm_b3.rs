//! Algorithm B3 and the pseudospectral assembly.

use super::{Equality, Gf, Identity, RandomInstance};
use crate::curve::Chebyshev;
use crate::dynamics::{Data, bias, crba, rnea};
use crate::error::Result;
use crate::flow::jacobian::{ControlFormJacobian, NodeBlocks, TheoremB4};
use crate::flow::{Collocation, ControlForm, assemble_jacobian};
use crate::scalar::Scalar;
use crate::verify::reference::{At, DifferentiableOver, jacobian, omega_by_definition};
use nalgebra::{DMatrix, DVector};

/// The degree of the curves: two interior nodes, so that each has a neighbour.
const P: usize = 3;

/// The identities of this file.
pub(super) fn identities() -> Vec<Identity> {
    let step = |label, statement, claims| Identity {
        label,
        statement,
        convention: "nodes by increasing time; unknowns are the states at the interior nodes, one after the other",
        claims,
    };
    vec![
        step("Algorithm B3 line 1", "the nodes start on the curve", line_1),
        step("Algorithm B3 line 2", "(23) at each node, and its assembled Jacobian", line_2),
        step("Algorithm B3 line 3", "u = H xdot_P2 + C is inverse dynamics", line_3),
    ]
}

/// The nodes, and unknowns from the numbers of `p`.
fn curve(p: &RandomInstance) -> Result<(Chebyshev, Vec<Gf>)> {
    let nodes = Chebyshev::new(P, 2.0)?;
    Ok((nodes, [p.xddot.as_slice(), p.xdot.as_slice()].concat()))
}

/// Compares the nodes with the given values, the ends with the boundary states, and the derivatives with products by
/// `D` and `D^2`.
fn line_1(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (nodes, unknowns) = curve(p)?;
    let mut collocation = Collocation::<Gf, Gf>::new(&nodes, p.x.as_slice(), p.xdot.as_slice())?;
    collocation.set(&unknowns)?;
    let columns = [&p.x, &p.xddot, &p.xdot, &p.xdot].map(Clone::clone);
    let xi = DMatrix::from_columns(&columns);
    let rates = |d: &DMatrix<f64>| &xi * d.map(Gf::from_f64).transpose();
    let (xdot, xddot) = (rates(nodes.d()), rates(nodes.d2()));
    let mut claims = vec![Equality::new("xi", collocation.xi().clone(), xi)];
    for i in collocation.interior() {
        let node = collocation.node(i);
        let column = |x: &[Gf]| DMatrix::from_column_slice(x.len(), 1, x);
        claims.push(Equality::new("D xi", column(node.xdot), xdot.columns(i, 1).into_owned()));
        claims.push(Equality::new("D^2 xi", column(node.xddot), xddot.columns(i, 1).into_owned()));
    }
    Ok(claims)
}

/// $\Omega$ by its definition (7) at the interior nodes, derivatives in time by the products with `D` and `D^2`.
fn rates_by_definition<S: DifferentiableOver<Gf>>(
    p: &RandomInstance,
    nodes: &Chebyshev,
    unknowns: &[S],
) -> Result<DVector<S>> {
    let (m, lift) = (p.x.len(), |x: &DVector<Gf>| x.map(S::lift));
    let columns = [lift(&p.x).as_slice(), unknowns, lift(&p.xdot).as_slice()].concat();
    let xi = DMatrix::from_vec(m, P + 1, columns);
    let derivative = |d: &DMatrix<f64>| &xi * d.transpose().map(S::from_f64);
    let (xdot, xddot) = (derivative(nodes.d()), derivative(nodes.d2()));
    let mut rates = Vec::with_capacity(unknowns.len());
    for i in 1..P {
        let part = |of: &DMatrix<S>| of.column(i).as_slice().to_vec();
        let z = [part(&xi), part(&xdot), part(&xddot)].concat();
        rates.extend_from_slice(omega_by_definition(&At::new(&p.model, &z, p.k))?.as_slice());
    }
    Ok(DVector::from_vec(rates))
}

/// The rates are $\Omega$ at each node, and the assembled Jacobian is that of the whole system, for both analytic
/// Jacobians.
fn line_2(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (nodes, unknowns) = curve(p)?;
    let mut collocation = Collocation::<Gf, Gf>::new(&nodes, p.x.as_slice(), p.xdot.as_slice())?;
    collocation.set(&unknowns)?;
    let size = collocation.unknowns();
    let mut rates = DVector::zeros(size);
    collocation.rates(&mut ControlForm::new(&p.model), p.k, rates.as_mut_slice())?;
    let by_definition = rates_by_definition(p, &nodes, &unknowns)?;
    let reference = jacobian(&unknowns, |unknowns| rates_by_definition(p, &nodes, unknowns))?;
    let blocks = &mut NodeBlocks::new(p.dof());
    let (mut by_control, mut by_b4) = (DMatrix::zeros(size, size), DMatrix::zeros(size, size));
    let control = &mut ControlFormJacobian::new(&p.model);
    assemble_jacobian(&collocation, control, p.k, blocks, &mut by_control)?;
    assemble_jacobian(&collocation, &mut TheoremB4::new(&p.model), p.k, blocks, &mut by_b4)?;
    Ok(vec![
        Equality::vectors("rates", &rates, &by_definition),
        Equality::new("Jacobian by the control form", by_control, reference.clone()),
        Equality::new("Jacobian by Theorem B4", by_b4, reference),
    ])
}

fn line_3(p: &RandomInstance) -> Result<Vec<Equality>> {
    let (n, node, data) = (p.dof(), p.node(), &mut Data::<Gf>::new(&p.model));
    let (q, v, a) = (node.x_p1(), node.x_p2(), node.xdot_p2());
    let (mut u, mut c, mut h) = (DVector::zeros(n), DVector::zeros(n), DMatrix::zeros(n, n));
    rnea(&p.model, data, q, v, a, u.as_mut_slice())?;
    bias(&p.model, data, q, v, c.as_mut_slice())?;
    crba(&p.model, data, q, &mut h)?;
    Ok(vec![Equality::vectors("u", &u, &(h * DVector::from_column_slice(a) + c))])
}
