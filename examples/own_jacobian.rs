//! A Jacobian of one's own in place of the analytic one: differences of fourth order. Prints what the checker finds, and where the
//! flow comes to with both.

use aghf::flow::jacobian::{NodeBlocks, NodeJacobian};
use aghf::flow::{ControlForm, Flow, FlowSettings, Node, RightHandSide};
use aghf::verify::duals::{CheckOptions, check_jacobian};
use aghf_cli::output::check_table;
use aghf_scenario::Scenario;
use std::error::Error;

/// Differences of the right-hand side at four points: their error is O(h^4) for the step h. In the accelerations it is linear.
struct FourthOrder<'m>(ControlForm<'m>);

impl NodeJacobian for FourthOrder<'_> {
    fn evaluate(&mut self, node: Node<'_, f64>, k: f64, out: &mut NodeBlocks) -> aghf::Result<()> {
        out.dxddot.fill(0.0);
        out.dxddot.fill_diagonal(2.0);
        let mut parts = [node.x, node.xdot].map(<[f64]>::to_vec);
        let mut omega = vec![0.0; node.x.len()];
        for (part, block) in [&mut out.dx, &mut out.dxdot].into_iter().enumerate() {
            block.fill(0.0);
            for (j, mut column) in block.column_iter_mut().enumerate() {
                let (here, step) = (parts[part][j], 1e-3);
                for (steps, weight) in [(-2.0, 1.0), (-1.0, -8.0), (1.0, 8.0), (2.0, -1.0)] {
                    parts[part][j] = here + steps * step;
                    let [x, xdot] = &parts;
                    self.0.omega(Node { x, xdot, ..node }, k, &mut omega)?;
                    let terms = column.iter_mut().zip(&omega);
                    terms.for_each(|(sum, omega)| *sum += weight * omega / (12.0 * step));
                }
                parts[part][j] = here;
            }
        }
        Ok(())
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let scenario = Scenario::load("kinova_free_01")?;
    let (model, problem) = (&scenario.model, scenario.problem()?);
    let settings = FlowSettings::new(9, 1e9, 0.1);
    let mut mine = FourthOrder(ControlForm::new(model));
    let options = CheckOptions { samples: 5, seed: 1, penalties: vec![settings.k] };
    println!("{}\n", check_table(&check_jacobian(model, "fourth-order", &mut mine, &options)?));

    let flow = || Flow::new(&problem, settings.clone());
    let (truth, found) = (flow().run()?, flow().jacobian(mine).run()?);
    assert_eq!((&truth.failure, &found.failure), (&None, &None));
    println!("analytic:     {} steps", truth.statistics.steps);
    println!("fourth order: {} steps", found.statistics.steps);
    println!("largest difference of the curves: {:.1e}", (truth.curve.x() - found.curve.x()).amax());
    Ok(())
}
