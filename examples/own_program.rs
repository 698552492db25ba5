//! A smooth program of one's own: problem 71 of Hock and Schittkowski, and its solution.

use aghf::Result;
use aghf::nlp::{Options, SmoothDerivatives, SmoothProgram, solve_smooth};
use nalgebra::{DMatrix, DVector, Matrix4, dmatrix, dvector};

struct Hs71;

#[rustfmt::skip]
impl SmoothProgram for Hs71 {
    fn bounds(&self) -> Vec<[f64; 2]> {
        vec![[1.0, 5.0]; 4]
    }

    fn row_bounds(&self) -> Vec<[f64; 2]> {
        vec![[25.0, f64::INFINITY], [40.0, 40.0]]
    }

    fn value(&mut self, x: &DVector<f64>, g: &mut DVector<f64>) -> Result<f64> {
        g.copy_from_slice(&[x.product(), x.norm_squared()]);
        Ok(x[0] * x[3] * (x[0] + x[1] + x[2]) + x[2])
    }

    fn derivatives(&mut self, x: &DVector<f64>, y: &DVector<f64>, out: &mut SmoothDerivatives) -> Result<()> {
        let (a, b, c, d) = (x[0], x[1], x[2], x[3]);
        out.gradient = dvector![d * (2.0 * a + b + c), a * d, a * d + 1.0, a * (a + b + c)];
        out.jacobian = dmatrix![b * c * d, a * c * d, a * b * d, a * b * c; 2.0 * a, 2.0 * b, 2.0 * c, 2.0 * d];
        let objective = Matrix4::new(
            2.0 * d, d, d, 2.0 * a + b + c,  d, 0.0, 0.0, a,  d, 0.0, 0.0, a,  2.0 * a + b + c, a, a, 0.0,
        );
        let product = Matrix4::new(
            0.0, c * d, b * d, b * c,  c * d, 0.0, a * d, a * c,  b * d, a * d, 0.0, a * b,  b * c, a * c, a * b, 0.0,
        );
        let sum = objective + product * y[0] + Matrix4::identity() * (2.0 * y[1]);
        out.hessian = DMatrix::from_column_slice(4, 4, sum.as_slice());
        Ok(())
    }
}

fn main() -> Result<()> {
    let start = dvector![1.0, 5.0, 5.0, 1.0];
    let found = solve_smooth(&mut Hs71, &start, &Options { tolerance: 1e-8, ..Options::default() })?;
    println!("{:?} after {} iterations: f = {:.6}", found.status, found.iterations, found.objective);
    println!("x = {:.6?}, y = {:.6?}", found.x.as_slice(), found.multipliers.as_slice());
    Ok(())
}
