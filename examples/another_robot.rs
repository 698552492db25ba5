//! Another robot: the derivatives of its inverse dynamics by dual numbers and by the analytic algorithm, with their
//! times. The argument is the path of a URDF file; without one it is a built-in robot.

use aghf::dynamics::{Data, InverseDynamicsDerivatives, rnea, rnea_derivatives};
use aghf::model::Model;
use aghf::num_dual::Dual64;
use aghf::urdf::load_robot;
use aghf::verify::duals::State;
use std::time::Instant;

/// The largest difference of the two, relative to the largest entry, and the seconds that each takes, at one state.
fn compare(model: &Model, state: &State) -> aghf::Result<[f64; 3]> {
    let n = model.dof();
    let (q, v, a) = (&state.x[..n], &state.x[n..], &state.xdot[n..]);
    let (mut data, mut analytic) = (Data::new(model), InverseDynamicsDerivatives::new(n));
    let started = Instant::now();
    rnea_derivatives(model, &mut data, q, v, a, &mut analytic)?;
    let by_algorithm = started.elapsed().as_secs_f64();

    let started = Instant::now();
    let mut z: Vec<Dual64> = [q, v, a].concat().into_iter().map(Dual64::from).collect();
    let (mut data, mut tau) = (Data::new(model), vec![Dual64::from(0.0); n]);
    let (mut error, mut largest) = (0.0_f64, 0.0_f64);
    for j in 0..3 * n {
        z[j].eps = 1.0;
        rnea(model, &mut data, &z[..n], &z[n..2 * n], &z[2 * n..], &mut tau)?;
        z[j].eps = 0.0;
        let block = [&analytic.dq, &analytic.dv, &analytic.h][j / n];
        for (dual, ours) in tau.iter().zip(&block.column(j % n)) {
            error = error.max((dual.eps - ours).abs());
            largest = largest.max(dual.eps.abs());
        }
    }
    Ok([error / largest, by_algorithm, started.elapsed().as_secs_f64()])
}

fn main() -> aghf::Result<()> {
    let path = std::env::args().find(|argument| argument.ends_with(".urdf"));
    let (model, notes) = load_robot(path.as_deref().unwrap_or("digit_v3_pinned"))?;
    println!("{}: {} joints", model.name(), model.dof());
    notes.iter().for_each(|note| println!("note: {note}"));
    println!("state  relative difference  analytic, us  duals, us");
    for sample in 0..5 {
        let [error, analytic, duals] = compare(&model, &State::random(&model, 1, sample))?;
        println!("{sample:5}  {error:19.1e}  {:12.1}  {:9.1}", 1e6 * analytic, 1e6 * duals);
    }
    Ok(())
}
