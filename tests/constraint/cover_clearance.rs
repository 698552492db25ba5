//! The clearance of sets of balls.

use crate::common::{any_model, config, numbers, robot, wave};
use crate::derivatives::{ValueAlone, contracted};
use crate::solid_clearance::sizes;
use aghf::constraint::{CollisionSphere, Constraint, CoverClearance, Evaluator, Quantity, RowList, Weights};
use aghf::geometry::{BallTree, Solid, Sphere};
use aghf::model::Model;
use aghf::scalar::{LANES, Lanes, Wide};
use aghf::spatial::Placement;
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;

/// The number of balls of a link: more than are compared at once.
const BALLS: usize = 19;

/// Balls on each body and on the base in one to three sets, all pairs of them, and a solid of each shape.
pub fn covered(model: &Model, far: f64) -> CoverClearance {
    let bodies = (0..model.dof()).map(Some).chain([None]);
    let tree = |(i, body): (usize, Option<usize>)| {
        let ball = |k: usize| {
            let at = |s: f64| 0.4 * (s * (BALLS * i + k + 1) as f64).sin();
            CollisionSphere {
                body,
                centre: Vector3::new(at(1.0), at(2.3), at(4.1)),
                radius: 0.03 + 0.01 * (k % 7) as f64,
            }
        };
        let balls: Vec<_> = (0..BALLS).map(ball).collect();
        let mut tree = BallTree::new(&balls, (0..BALLS).collect());
        for ball in tree.nodes.iter_mut().filter_map(|node| node.leaf.as_mut()) {
            *ball += BALLS * i;
        }
        tree
    };
    let links: Vec<_> = bodies.enumerate().map(tree).collect();
    let solids = sizes([0.3, 0.2, 0.5, 0.4])
        .map(|shape| Solid { placement: Placement::new(Matrix3::identity(), Vector3::new(0.3, -0.4, 0.2)), shape });
    let of = |i: usize, count: usize| (0..count).map(move |j| [i, j]);
    CoverClearance {
        solid_pairs: (0..links.len()).flat_map(|i| of(i, solids.len())).collect(),
        pairs: (0..links.len()).flat_map(|i| of(i, i)).collect(),
        names: vec!["crate".to_owned()],
        solids: solids.into(),
        margins: [0.02, 0.01],
        counts: (0..links.len()).map(|i| 1 + i % 3).collect(),
        sets: (0..BALLS * links.len()).map(|ball| ball % (1 + ball / BALLS % 3)).collect(),
        links,
        far,
    }
}

/// The least distance of each pair, ball by ball.
fn by_balls(of: &CoverClearance, model: &Model, x: &[f64]) -> Vec<f64> {
    let mut evaluator = Evaluator::new(model);
    let at = evaluator.at(x).expect("lengths agree");
    let balls = |i: usize, set: usize| {
        let tree = &of.links[i];
        let leaves = tree.nodes.iter();
        let leaves = leaves.filter(move |node| node.leaf.is_some_and(|ball| of.sets[ball] == set));
        leaves.map(|node| Sphere {
            centre: at.state().point(tree.body, &node.bound.centre).expect("its bodies"),
            radius: node.bound.radius,
        })
    };
    let row = |margin: f64, gaps: &mut dyn Iterator<Item = f64>| margin - gaps.fold(margin + of.far, f64::min);
    let mut rows = Vec::new();
    for [i, j] in &of.solid_pairs {
        for set in 0..of.counts[*i] {
            let gaps = balls(*i, set).map(|b| of.solids[*j].distance(&b.centre) - b.radius);
            rows.push(row(of.margins[0], &mut gaps.into_iter()));
        }
    }
    for [i, j] in &of.pairs {
        let (m, n) = (of.counts[*i], of.counts[*j]);
        for k in 0..m.max(n) {
            let sets = (0..m).flat_map(|set| (0..n).map(move |beside| [set, beside]));
            let sets = sets.filter(|[set, beside]| (set + beside) % m.max(n) == k);
            let pairs = sets.flat_map(|[set, beside]| {
                let all = balls(*j, beside).collect::<Vec<_>>();
                balls(*i, set).flat_map(move |b| all.clone().into_iter().map(move |c| b.gap(&c)))
            });
            rows.push(row(of.margins[1], &mut pairs.into_iter()));
        }
    }
    rows
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
            let expected = [&x, &y].map(|state| by_balls(&constraint, &model, state));
            assert_close!(&g, &expected[0], 1e-13);

            // Side by side with other states, in other lanes of one evaluation.
            let wide: Vec<Wide> = (0..x.len())
                .map(|i| Lanes(std::array::from_fn(|lane| [&x, &y][lane % 2][i])))
                .collect();
            let mut found = vec![Wide::splat(0.0); constraint.dim()];
            let mut evaluator = Evaluator::<f64, Wide>::new(&model);
            evaluator.at(&wide).expect("lengths").value(&constraint, &mut found).expect("rows");
            for lane in 0..LANES {
                let alone: Vec<_> = found.iter().map(|g| g.0[lane]).collect();
                assert_close!(&alone, &expected[lane % 2], 1e-13);
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

/// Distances change by no more than the balls of two links may move.
#[test]
fn gaps_change_by_no_more_than_links_move() {
    let model = robot("kinova_gen3");
    let constraint = covered(&model, 0.3);
    let rows = |x: &[f64]| {
        let mut g = vec![0.0; constraint.dim()];
        let mut evaluator = Evaluator::new(&model);
        let placed = evaluator.at(x).expect("lengths agree");
        placed.value(&constraint, &mut g).expect("rows");
        (g, placed.state().placements.to_vec())
    };
    let mut most = 0.0_f64;
    for k in 0..40 {
        let x = wave(2 * model.dof(), 0.1 * f64::from(k));
        let y: Vec<_> = x.iter().map(|x| x + 0.02 * (9.0 * x).sin()).collect();
        let [(g, from), (h, to)] = [rows(&x), rows(&y)];
        for (row, (g, h)) in g.iter().zip(&h).enumerate() {
            let gap = constraint.row_set(row).distance.expect("each row is a distance");
            let moved = gap.bodies.iter().flatten().map(|(body, r)| {
                let turn = (from[*body].rotation - to[*body].rotation).norm();
                let step = (from[*body].translation - to[*body].translation).norm();
                step + r * turn / 2.0_f64.sqrt()
            });
            let moved: f64 = moved.sum();
            assert!((h - g).abs() <= moved + 1e-12, "row {row}: {g} {h} {moved}");
            most = most.max((h - g).abs() / moved);
        }
    }
    // The bound is not one of something else.
    assert!((0.5..=1.0).contains(&most), "{most}");
    assert_eq!(constraint.row_set(constraint.dim()).distance, None);
}

/// Some rows alone are those among all.
#[test]
fn rows_of_a_list_are_those_of_all() {
    let model = robot("kinova_gen3");
    let constraint = covered(&model, 0.3);
    let x: Vec<_> = wave(2 * model.dof(), 0.4);
    let [mut all, mut some] = [(); 2].map(|()| vec![f64::NAN; constraint.dim()]);
    let mut evaluator = Evaluator::new(&model);
    let placed = evaluator.at(&x).expect("lengths agree");
    placed.value(&constraint, &mut all).expect("rows");
    let rows: Vec<_> = (0..constraint.dim()).step_by(7).collect();
    let list = RowList::new(&rows);
    placed.value_of(&constraint, list, &mut some).expect("rows");
    assert!(rows.iter().all(|row| some[*row] == all[*row]));
}

#[test]
fn rows_are_named_by_links_and_solids() {
    let model = robot("kinova_gen3");
    let constraint = covered(&model, 0.1);
    let names = [0, 8, constraint.dim() - 1].map(|row| constraint.label(row, &model));
    assert!(names.iter().all(|label| label.quantity.is_clearance()));
    assert!(names[0].name.ends_with("from 'crate'"), "{}", names[0].name);
    // The third shape of the second link, which has two sets.
    assert!(names[1].name.ends_with("from capsule 2"), "{}", names[1].name);
    let last = "distance of the base";
    assert!(
        names[2].name.starts_with("distance of link 'base_link'") || names[2].name.starts_with(last),
        "{}",
        names[2].name
    );
    assert_eq!(constraint.label(constraint.dim(), &model).quantity, Quantity::Other);
}
