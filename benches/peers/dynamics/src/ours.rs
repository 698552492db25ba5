//! Values and times of `aghf`.

use crate::{Result, State, time};
use aghf::dynamics::{
    Data, ForwardDynamicsDerivatives, InverseDynamicsDerivatives, InverseDynamicsSecondDerivatives, aba,
    aba_derivatives, crba, rnea, rnea_derivatives, rnea_second_derivatives,
};
use aghf::model::Model;
use aghf::scalar::{AlgebraOver, LANES, Lanes, Wide};
use nalgebra::DMatrix;
use std::hint::black_box;

/// Prints the results at the first states.
pub fn values(model: &Model, states: &[State]) -> Result<()> {
    let n = model.dof();
    let mut data = Data::new(model);
    let (mut tau, mut h) = (vec![0.0; n], DMatrix::zeros(n, n));
    let mut id = InverseDynamicsDerivatives::new(n);
    let mut fd = ForwardDynamicsDerivatives::new(n);
    let mut second = InverseDynamicsSecondDerivatives::new(n);
    for [q, v, a, force] in states.iter().take(3) {
        rnea(model, &mut data, q, v, a, &mut tau)?;
        print("rnea", &tau);
        crba(model, &mut data, q, &mut h)?;
        print("crba", h.as_slice());
        aba(model, &mut data, q, v, force, &mut tau)?;
        print("aba", &tau);
        rnea_derivatives(model, &mut data, q, v, a, &mut id)?;
        print("rnea_dq", id.dq.as_slice());
        print("rnea_dv", id.dv.as_slice());
        aba_derivatives(model, &mut data, q, v, force, &mut fd)?;
        print("aba_dq", fd.dq.as_slice());
        print("aba_dv", fd.dv.as_slice());
        print("aba_dtau", fd.h_inverse.as_slice());
        rnea_second_derivatives(model, &mut data, q, v, a, &mut second)?;
        print("rnea_dqdq", second.dqdq().entries());
        print("rnea_dvdv", second.dvdv().entries());
        print("rnea_dqdv", second.dqdv().entries());
        print("rnea_dadq", second.dadq().entries());
    }
    Ok(())
}

/// Prints a line of numbers.
fn print(name: &str, numbers: &[f64]) {
    let numbers: Vec<String> = numbers.iter().map(f64::to_string).collect();
    println!("{name} {}", numbers.join(" "));
}

/// Prints the times at one state at a time and at several side by side, of all functions unless one is asked for.
pub fn times(model: &Model, states: &[State], seconds: f64, function: Option<&str>) -> Result<()> {
    times_of(model, ("single", 1), states, seconds, function)?;
    let side_by_side = |group: &[State]| -> [Vec<Wide>; 4] {
        std::array::from_fn(|part| {
            let joint = |i: usize| Lanes(std::array::from_fn(|lane| group[lane][part][i]));
            (0..model.dof()).map(joint).collect()
        })
    };
    let groups: Vec<_> = states.chunks_exact(LANES).map(side_by_side).collect();
    times_of(model, ("lanes", LANES), &groups, seconds, function)
}

/// The same at states of one kind, each of which stands for `lanes` states.
fn times_of<S: AlgebraOver<f64>>(
    model: &Model,
    (mode, lanes): (&str, usize),
    states: &[[Vec<S>; 4]],
    seconds: f64,
    function: Option<&str>,
) -> Result<()> {
    let n = model.dof();
    let mut data = Data::new(model);
    let (mut tau, mut h) = (vec![S::zero(); n], DMatrix::zeros(n, n));
    let mut id = InverseDynamicsDerivatives::new(n);
    let mut fd = ForwardDynamicsDerivatives::new(n);
    let mut second = InverseDynamicsSecondDerivatives::new(n);
    let row = |name: &str, call: &mut dyn FnMut(&[Vec<S>; 4]) -> aghf::Result<()>| -> Result<()> {
        if function.is_none_or(|wanted| wanted == name) {
            let found = time(states, lanes, seconds, |state| Ok(call(black_box(state))?))?;
            println!("{name} {mode} {found:.6}");
        }
        Ok(())
    };
    row("rnea", &mut |[q, v, a, _]| rnea(model, &mut data, q, v, a, &mut tau))?;
    row("crba", &mut |[q, ..]| crba(model, &mut data, q, &mut h))?;
    row("aba", &mut |[q, v, _, force]| aba(model, &mut data, q, v, force, &mut tau))?;
    row("rnea_derivatives", &mut |[q, v, a, _]| rnea_derivatives(model, &mut data, q, v, a, &mut id))?;
    row("aba_derivatives", &mut |[q, v, _, force]| aba_derivatives(model, &mut data, q, v, force, &mut fd))?;
    row("rnea_second_derivatives", &mut |[q, v, a, _]| rnea_second_derivatives(model, &mut data, q, v, a, &mut second))
}
