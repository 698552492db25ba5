//! The clearance of sets of balls.

use crate::common::{any_model, config, numbers, robot, wave};
use crate::derivatives::{ValueAlone, contracted};
use crate::solid_clearance::sizes;
use aghf::constraint::{BallSet, Constraint, CoverClearance, Evaluator, RowKind, Weights};
use aghf::geometry::{Solid, Sphere};
use aghf::model::Model;
use aghf::scalar::{LANES, Lanes, Wide};
use aghf::spatial::Placement;
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;

/// Sets of three balls on each body and on the base, all pairs of them, and a solid of each shape.
fn covered(model: &Model, far: f64) -> CoverClearance {
    let bodies = (0..model.dof()).map(Some).chain([None]);
    let set = |(i, body): (usize, Option<usize>)| {
        let ball = |k: usize| {
            let at = |s: f64| 0.4 * (s * (3 * i + k + 1) as f64).sin();
            Sphere {
                centre: Vector3::new(at(1.0), at(2.3), at(4.1)),
                radius: 0.03 + 0.02 * k as f64,
            }
        };
        BallSet::new(body, (0..3).map(ball).collect())
    };
    let sets: Vec<_> = bodies.enumerate().map(set).collect();
    let solids = sizes([0.3, 0.2, 0.5, 0.4]).map(|shape| Solid {
        placement: Placement::new(Matrix3::identity(), Vector3::new(0.3, -0.4, 0.2)),
        shape,
    });
    let of = |i: usize, count: usize| (0..count).map(move |j| [i, j]);
    CoverClearance {
        solid_pairs: (0..sets.len()).flat_map(|i| of(i, solids.len())).collect(),
        pairs: (0..sets.len()).flat_map(|i| of(i, i)).collect(),
        names: vec!["crate".to_owned()],
        solids: solids.into(),
        sets,
        far,
    }
}

/// The least distance of each pair, ball by ball.
fn by_balls(of: &CoverClearance, model: &Model, x: &[f64]) -> Vec<f64> {
    let mut evaluator = Evaluator::new(model);
    let at = evaluator.at(x).expect("lengths agree");
    let balls = |i: usize| {
        let set = &of.sets[i];
        set.balls.iter().map(|b| Sphere {
            centre: at.state().point(set.body, &b.centre).expect("its bodies"),
            radius: b.radius,
        })
    };
    let least = |gaps: &mut dyn Iterator<Item = f64>| gaps.fold(of.far, f64::min);
    let solids = of
        .solid_pairs
        .iter()
        .map(|[i, j]| least(&mut balls(*i).map(|b| of.solids[*j].distance(&b.centre) - b.radius)));
    let pairs = of.pairs.iter();
    let pairs = pairs.map(|[i, j]| {
        least(&mut balls(*i).flat_map(|b| balls(*j).map(move |other| b.gap(&other))))
    });
    solids.chain(pairs).map(|gap| -gap).collect()
}

proptest! {
    #![proptest_config(config(24))]

    /// Near, where all distances count, and with a distance beyond which most do not.
    #[test]
    fn rows_and_derivatives_are_those_of_the_nearest_balls((model, x, y) in any_model().prop_flat_map(|model| {
        let n = 2 * model.dof();
        (Just(model), numbers(n), numbers(n))
    })) {
        for far in [100.0, 0.3] {
            let constraint = covered(&model, far);
            let mut g = vec![0.0; constraint.dim()];
            let mut evaluator = Evaluator::new(&model);
            evaluator.at(&x).expect("lengths").value(&constraint, &mut g).expect("rows");
            let expected = by_balls(&constraint, &model, &x);
            assert_close!(&g, &expected, 1e-13);

            // Side by side with other states, in other lanes of one evaluation.
            let state = |lane: usize| if lane.is_multiple_of(2) { &x } else { &y };
            let wide: Vec<Wide> = (0..x.len()).map(|i| Lanes(std::array::from_fn(|lane| state(lane)[i]))).collect();
            let mut found = vec![Wide::splat(0.0); constraint.dim()];
            let mut evaluator = Evaluator::<f64, Wide>::new(&model);
            evaluator.at(&wide).expect("lengths").value(&constraint, &mut found).expect("rows");
            for lane in 0..LANES {
                let alone: Vec<_> = found.iter().map(|g| g.0[lane]).collect();
                assert_close!(&alone, &by_balls(&constraint, &model, state(lane)), 1e-13);
            }

            let (w, c) = (wave(g.len(), 0.7), wave(g.len(), 1.9));
            let weights = Weights { first_order: &w, gauss_newton: Some(&c) };
            let (gradient, hessian) = contracted(&model, &constraint, &x, weights);
            let (by_jets, by_jets2) = contracted(&model, &ValueAlone(constraint), &x, weights);
            assert_close!(&gradient, &by_jets, 1e-11);
            assert_close!(&hessian, &by_jets2, 1e-11);
        }
    }
}

#[test]
fn rows_are_named_by_links_and_solids() {
    let model = robot("kinova_gen3");
    let constraint = covered(&model, 0.1);
    let names = [0, 6, constraint.dim() - 1].map(|row| constraint.label(row, &model));
    assert!(names.iter().all(|label| label.kind == RowKind::Clearance));
    assert!(names[0].name.ends_with("from 'crate'"), "{}", names[0].name);
    // The third shape of the second set.
    assert!(
        names[1].name.ends_with("from capsule 2"),
        "{}",
        names[1].name
    );
    let last = "distance of the base";
    assert!(
        names[2].name.starts_with("distance of link 'base_link'")
            || names[2].name.starts_with(last),
        "{}",
        names[2].name
    );
    assert_eq!(
        constraint.label(constraint.dim(), &model).kind,
        RowKind::Other
    );
}

#[test]
fn a_bound_contains_its_balls() {
    let balls = vec![
        Sphere {
            centre: Vector3::new(1.0, 0.0, 0.0),
            radius: 0.5,
        },
        Sphere {
            centre: Vector3::new(-1.0, 0.0, 0.0),
            radius: 0.1,
        },
    ];
    let set = BallSet::new(None, balls);
    assert_close!(&set.bound.centre, &Vector3::new(0.2, 0.0, 0.0), 1e-15);
    assert_close!(&[set.bound.radius], &[1.3], 1e-15);
}
