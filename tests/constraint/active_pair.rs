//! The active pairs of rows.

use crate::common::{config, numbers, robot, wave};
use crate::cover_clearance::covered;
use aghf::constraint::{
    ActivePair, ActivePairs, AnyConstraint, Bounds, Constraint, CoverClearance, Evaluator, PlacedState, RowList,
    Weights,
};
use aghf::model::Model;
use aghf::scalar::{LANES, Lanes, Wide};
use proptest::prelude::*;

/// Covers with other distances before and after a constraint that has no active pairs.
fn three(model: &Model) -> [AnyConstraint; 3] {
    let cover = |far| AnyConstraint::Cover(covered(model, far));
    let bounds = AnyConstraint::Bounds(Bounds(Vec::new()));
    [cover(0.3), bounds, cover(0.1)]
}

/// The rows of a constraint in lanes and its active pairs.
fn noted<K: Constraint>(model: &Model, rows: &K, x: &[Wide]) -> (Vec<Wide>, Vec<ActivePair>) {
    beside(model, rows, x, None, None)
}

/// The same for some rows alone, where active pairs are known.
fn beside<K: Constraint>(
    model: &Model,
    rows: &K,
    x: &[Wide],
    some: Option<RowList<'_>>,
    known: Option<ActivePairs<'_>>,
) -> (Vec<Wide>, Vec<ActivePair>) {
    let mut g = vec![Wide::splat(f64::NAN); rows.dim()];
    let (mut active_pairs, mut evaluator) = (Vec::new(), Evaluator::<f64, Wide>::new(model));
    let placed = evaluator.at(x).expect("lengths agree");
    let at = PlacedState { active_pairs: known, ..*placed.state() };
    let found = rows.value_of(&at, some, &mut g, Some(&mut active_pairs));
    found.expect("rows");
    (g, active_pairs)
}

/// The rows of a constraint in lanes by active pairs.
fn by_active_pairs<K: Constraint>(model: &Model, rows: &K, x: &[Wide], active_pairs: &[ActivePair]) -> Vec<Wide> {
    let mut g = vec![Wide::splat(0.0); rows.dim()];
    let mut evaluator = Evaluator::<f64, Wide>::new(model);
    let placed = evaluator.at(x).expect("lengths agree");
    let at = PlacedState { active_pairs: Some(ActivePairs::new(active_pairs)), ..*placed.state() };
    rows.value(&at, &mut g).expect("rows");
    g
}

/// The state of seven joints at rest in lanes with these positions moved by an angle.
fn state(numbers: &[f64], by: f64) -> Vec<Wide> {
    let entry = |i: usize| {
        if i < 7 { Lanes(std::array::from_fn(|lane| numbers[LANES * i + lane] + by)) } else { Wide::splat(0.0) }
    };
    (0..14).map(entry).collect()
}

proptest! {
    #![proptest_config(config(16))]

    /// At the state all values and derivatives are the same by the active pairs; beside it rows are no larger, and
    /// differ by no more than balls have moved.
    #[test]
    fn rows_are_those_of_their_active_pieces(numbers in numbers(LANES * 7)) {
        let model = robot("kinova_gen3");
        let rows = three(&model);
        let [x, beside] = [0.0, 1e-4].map(|by| state(&numbers, by));
        let (g, active_pairs) = noted(&model, &rows, &x);
        prop_assert!(active_pairs.is_sorted_by_key(|pair| pair.row) && !active_pairs.is_empty());
        prop_assert!(by_active_pairs(&model, &rows, &x, &active_pairs) == g);

        let (exact, _) = noted(&model, &rows, &beside);
        // Seven joints, at most 1.2 m from any ball, on both sides.
        let most = 2.0 * 7.0 * 1.2 * 1e-4;
        for (near, exact) in by_active_pairs(&model, &rows, &beside, &active_pairs).iter().zip(&exact) {
            for lane in 0..LANES {
                prop_assert!(near.0[lane] <= exact.0[lane]);
                prop_assert!(exact.0[lane] - near.0[lane] <= 2.0 * most);
            }
        }

        let [w, c] = [0.7, 1.9].map(|s| wave(g.len(), s).into_iter().map(Wide::splat).collect::<Vec<_>>());
        let weights = Weights { first_order: &w, gauss_newton: Some(&c) };
        let derivatives = |active_pairs: Option<&[ActivePair]>| {
            let mut evaluator = Evaluator::<f64, Wide>::new(&model);
            let mut placed = evaluator.at(&x).expect("lengths agree").with_active_pairs(active_pairs);
            let found = placed.weighted_derivatives(&rows, weights).expect("rows");
            (found.gradient().clone(), found.hessian().clone())
        };
        prop_assert!(derivatives(Some(&active_pairs)) == derivatives(None));
    }

    /// Beside a state rows are those of its active pairs where these are the largest, and exact from a value on; some
    /// rows have the values and the active pairs that they have among all.
    #[test]
    fn rows_beside_are_exact_from_a_value_on(numbers in numbers(LANES * 7), from in -0.2..0.1) {
        let model = robot("kinova_gen3");
        let rows = three(&model);
        let [x, moved] = [0.0, 0.1].map(|by| state(&numbers, by));
        let (_, known) = noted(&model, &rows, &x);
        let least = by_active_pairs(&model, &rows, &moved, &known);
        let (exact, _) = noted(&model, &rows, &moved);
        let known = ActivePairs::new(&known).and_above(from);
        let (found, active_pairs) = beside(&model, &rows, &moved, None, Some(known));
        for (found, (least, exact)) in found.iter().zip(least.iter().zip(&exact)) {
            for lane in 0..LANES {
                let [found, least, exact] = [found, least, exact].map(|g| g.0[lane]);
                prop_assert!(least <= found && found <= exact);
                prop_assert!(exact < from || found == exact, "{found} {exact} from {from}");
            }
        }
        prop_assert!(by_active_pairs(&model, &rows, &moved, &active_pairs) == found);

        let some: Vec<_> = (0..rows.dim()).step_by(31).collect();
        let list = Some(RowList::new(&some));
        let (of_list, of_some) = beside(&model, &rows, &moved, list, Some(known));
        prop_assert!(some.iter().all(|row| of_list[*row] == found[*row]));
        let own = |of: &[ActivePair]| of.iter().filter(|of| some.contains(&of.row)).copied().collect::<Vec<_>>();
        prop_assert!(own(&of_some) == own(&active_pairs));
    }
}

#[test]
fn pieces_are_split_like_rows() {
    let at = |row| ActivePair { row, of: [row, 0] };
    let all = [0, 0, 3, 4, 7].map(at);
    let (first, rest) = ActivePairs::new(&all).split_at(3);
    let (second, third) = rest.split_at(2);
    let rows = |active_pairs: ActivePairs<'_>| active_pairs.iter().map(|pair| pair.row).collect::<Vec<_>>();
    assert_eq!(rows(first), [0, 0]);
    assert_eq!(rows(second), [0, 1]);
    assert_eq!(rows(third), [2]);
    // Without active pairs all rows are far.
    let model = robot("kinova_gen3");
    let cover: CoverClearance = covered(&model, 0.3);
    let x = vec![Wide::splat(0.0); 14];
    let far = by_active_pairs(&model, &cover, &x, &[]);
    assert!(far.iter().all(|g| g.0 == [-0.3; LANES]));
}
