//! A constraint of one's own, kept by the direct method and by the flow: the tool of an arm stays below a height, and
//! the joints stay within their limits. Prints for both methods which rows come closest to their bounds, and how close.

use aghf::constraint::{
    Bounds, CollisionSphere, Constraint, Constraints, PlacedState, Quantity, RowLabel, TorqueLimits,
};
use aghf::direct::{Direct, DirectSettings};
use aghf::flow::{Flow, FlowSettings, Penalised, Penalty, PenaltyWeights};
use aghf::model::Model;
use aghf::motion::{Problem, violations};
use aghf::scalar::AlgebraOver;
use aghf::urdf::builtin_robot;

/// The centre of `tool` is at most `height` above the base, in m.
struct Below {
    tool: CollisionSphere,
    height: f64,
}

impl Constraint for Below {
    fn dim(&self) -> usize {
        1
    }

    fn value<S: AlgebraOver<f64>>(&self, at: &PlacedState<'_, f64, S>, g: &mut [S]) -> aghf::Result<()> {
        g[0] = at.point(self.tool.body, &self.tool.centre)?.z - S::lift(self.height);
        Ok(())
    }

    fn label(&self, _: usize, _: &Model) -> RowLabel {
        RowLabel::new("height of the tool".into(), "m", Quantity::Other)
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let model = &builtin_robot("kinova_gen3")?;
    let state = |q: [f64; 7]| [q, [0.0; 7]].concat();
    let (start, goal) = ([0.0, 0.6, 0.0, 1.6, 0.0, 0.8, 0.0], [2.0, 0.9, 0.0, 1.2, 0.0, 0.8, 0.0]);
    let problem = Problem::new(model, state(start), state(goal), 3.0)?;
    let tool = CollisionSphere::at_link(model, "end_effector_link", 0.0)?;
    let state = (Below { tool, height: 0.3 }, Bounds::positions(model), Bounds::velocities(model));
    let kept = Constraints { state, torque: TorqueLimits::of(model), stage: Default::default() };
    let direct = Direct::new(&problem).constraints(&kept).settings(DirectSettings::constrained()).solve()?;
    let penalty = Penalty { k_cons: 1e6, c_cons: 50.0 };
    let weights = PenaltyWeights { state: penalty, torque: penalty };
    let penalised = Penalised { constraints: kept, weights };
    let flowed = Flow::new(&problem, FlowSettings::new(9, 1e4, 1.0)).constraints(&penalised).run()?;
    assert_eq!(flowed.failure, None);
    for (method, curve) in [("direct", &direct.curve), ("flow", &flowed.curve)] {
        let mut rows = violations(model, curve, &penalised.constraints, 2000)?;
        rows.sort_by(|a, b| b.by.total_cmp(&a.by));
        println!("{method}: the rows with the least left");
        for row in &rows[..4] {
            let label = penalised.constraints.label(row.row, model);
            println!("{:10.1e} {:5} at {:.2} s  {}", -row.by, label.unit, row.at_s, label.name);
        }
    }
    Ok(())
}
