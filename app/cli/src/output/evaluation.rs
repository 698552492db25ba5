//! The dynamics of a robot at a given state in JSON.

use aghf::dynamics::{Data, InverseDynamicsDerivatives, aba, bias, mass_matrix_and_rate, rnea_derivatives};
use aghf::error::{Error, Result, plain};
use aghf::flow::{ControlForm, Node, RightHandSide};
use aghf::linalg::rows;
use aghf::model::Model;
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

/// The contents of the input file.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Input {
    State(State),
    Curve(Curve),
}

/// A state and an acceleration.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct State {
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    tau: Option<Vec<f64>>,
}

/// The input of the flow at a node.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Curve {
    x: Vec<f64>,
    xdot: Vec<f64>,
    xddot: Vec<f64>,
    k: f64,
    tau: Option<Vec<f64>>,
}

/// The dynamics of a robot with `N` joints at a state; matrices are lists of rows.
#[derive(Debug, Serialize)]
pub struct Evaluation {
    /// The torques or forces of the acceleration, `N` entries.
    pub inverse_dynamics: Vec<f64>,
    /// The mass matrix, `N` by `N`.
    pub mass_matrix: Vec<Vec<f64>>,
    /// The rate of the mass matrix along the velocity, or along the first half of xdot, `N` by `N`.
    pub mass_matrix_dot: Vec<Vec<f64>>,
    /// The torques at zero acceleration, `N` entries.
    pub bias: Vec<f64>,
    /// The acceleration under tau, `N` entries.
    pub forward_dynamics: Vec<f64>,
    /// The derivative of the inverse dynamics in the configuration, `N` by `N`.
    pub did_dq: Vec<Vec<f64>>,
    /// The derivative of the inverse dynamics in the velocity, `N` by `N`.
    pub did_dv: Vec<Vec<f64>>,
    /// The right-hand side $\Omega$, `2 N` entries; `None` without xddot and k.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub omega: Option<Vec<f64>>,
}

/// Evaluates the dynamics of `model` at a state given in JSON, by the keys q, v, a and optionally tau with `N` numbers
/// each, or x, xdot, xddot with `2 N`, k and optionally tau. `file` names the text in errors.
///
/// # Errors
/// The text does not have this form, a number is missing, or a result is not finite.
pub fn evaluate(model: &Model, text: &str, file: &str) -> Result<Evaluation> {
    let expected = "expected numbers under q, v, a, or under x, xdot, xddot, k of an object; tau may be added";
    let refuse = |condition: String| Error::input(file, "input", condition);
    // serde would accept a list as the values of the keys in order.
    if text.trim_start().starts_with(['[', '<']) {
        return Err(refuse(expected.to_owned()));
    }
    let input: Input = serde_json::from_str(text)
        .map_err(|e| refuse(if e.is_data() { expected.to_owned() } else { e.to_string() }))?;
    input.evaluate(model, file)
}

impl Input {
    fn evaluate(self, model: &Model, file: &str) -> Result<Evaluation> {
        let n = model.dof();
        let (state, rate, omega) = match self {
            Self::State(state) => (state, None, None),
            Self::Curve(curve) => {
                let (state, rate, omega) = curve.at_node(model, file)?;
                (state, Some(rate), Some(omega))
            }
        };
        let State { q, v, a, tau } = state;
        let tau = tau.unwrap_or_else(|| vec![0.0; n]);
        for (key, vector) in [("q", &q), ("v", &v), ("a", &a), ("tau", &tau)] {
            check_count(file, key, n, vector.len())?;
        }
        let data = &mut Data::new(model);
        let mut id = InverseDynamicsDerivatives::new(n);
        let (mut c, mut acceleration) = (vec![0.0; n], vec![0.0; n]);
        let (mut h, mut hdot) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
        rnea_derivatives(model, data, &q, &v, &a, &mut id)?;
        bias(model, data, &q, &v, &mut c)?;
        aba(model, data, &q, &v, &tau, &mut acceleration)?;
        mass_matrix_and_rate(model, data, &q, rate.as_ref().unwrap_or(&v), &mut h, &mut hdot)?;
        let output = Evaluation {
            inverse_dynamics: id.tau.as_slice().to_vec(),
            mass_matrix: rows(&h),
            mass_matrix_dot: rows(&hdot),
            bias: c,
            forward_dynamics: acceleration,
            did_dq: rows(&id.dq),
            did_dv: rows(&id.dv),
            omega,
        };
        output.check(file)?;
        Ok(output)
    }
}

/// Refuses a vector with a number of entries other than `expected`.
fn check_count(file: &str, key: &str, expected: usize, found: usize) -> Result<()> {
    let condition = format!("expected {expected} numbers, found {found}");
    if expected == found { Ok(()) } else { Err(Error::input(file, key, condition)) }
}

impl Curve {
    /// The state, the rate of its configuration along the curve, and the right-hand side of the flow.
    fn at_node(self, model: &Model, file: &str) -> Result<(State, Vec<f64>, Vec<f64>)> {
        let n = model.dof();
        let Self { x, xdot, xddot, k, tau } = self;
        for (key, vector) in [("x", &x), ("xdot", &xdot), ("xddot", &xddot)] {
            check_count(file, key, 2 * n, vector.len())?;
        }
        if k <= 0.0 {
            let condition = format!("it is {} and must be a positive number", plain(k));
            return Err(Error::input(file, "k", condition));
        }
        let mut omega = vec![0.0; 2 * n];
        // The paper's flow does not depend on time.
        let node = Node { t: 0.0, x: &x, xdot: &xdot, xddot: &xddot };
        ControlForm::new(model).omega(node, k, &mut omega)?;
        let half = |x: &[f64], second: bool| x[n * usize::from(second)..][..n].to_vec();
        let state = State { q: half(&x, false), v: half(&x, true), a: half(&xdot, true), tau };
        Ok((state, half(&xdot, false), omega))
    }
}

impl Evaluation {
    /// Refuses numbers that overflowed, which JSON cannot represent.
    fn check(&self, file: &str) -> Result<()> {
        let vectors = [
            ("inverse_dynamics", &self.inverse_dynamics),
            ("bias", &self.bias),
            ("forward_dynamics", &self.forward_dynamics),
        ];
        let matrices = [
            ("mass_matrix", &self.mass_matrix),
            ("mass_matrix_dot", &self.mass_matrix_dot),
            ("did_dq", &self.did_dq),
            ("did_dv", &self.did_dv),
        ];
        let finite = |x: &[f64]| x.iter().all(|x| x.is_finite());
        let of_vectors = vectors.into_iter().chain(self.omega.as_ref().map(|o| ("omega", o)));
        let of_vectors = of_vectors.map(|(key, x)| (key, finite(x)));
        let of_matrices = matrices.map(|(key, rows)| (key, rows.iter().all(|row| finite(row))));
        match of_vectors.chain(of_matrices).find(|(_, finite)| !finite) {
            Some((key, _)) => Err(Error::input(file, key, "it is not finite at this input")),
            None => Ok(()),
        }
    }
}
