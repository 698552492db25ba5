//! The barriers of the rows and the running cost with them, against their definitions and against duals.

use crate::common::{config, slider};
use aghf::constraint::{
    AnyConstraint, Bound, Bounds, CollisionSphere, Constraint, Constraints, Evaluator, RowKind,
    Side, SolidClearance, Sphere, SphereClearance, TorqueLimits,
};
use aghf::dynamics::{Data, rnea};
use aghf::geometry::Solid;
use aghf::model::{Model, random_tree};
use aghf::relax::{Barrier, BarrierCost, HyperDual64, Point, PointCost, PointDerivatives};
use nalgebra::{DMatrix, Vector3};
use num_dual::DualNum;
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

type Kept = Constraints<Vec<AnyConstraint>>;

/// Excess `t` and slack `s` of a row by $h = t - s$ and $\mu / t + \mu / s = \nu$: the larger of the two solves a
/// quadratic equation without loss of digits. Then what they cost.
fn psi(h: HyperDual64, Barrier { mu, nu }: Barrier) -> HyperDual64 {
    let reach = (if h.re < 0.0 { -h } else { h }) * nu;
    let root = (reach * reach + 4.0 * mu * mu).sqrt();
    let larger = (reach + root + 2.0 * mu) / (2.0 * nu);
    let smaller = larger * (2.0 * mu) / (reach + root);
    let [excess, slack] = if h.re < 0.0 {
        [smaller, larger]
    } else {
        [larger, smaller]
    };
    excess * nu - (excess * slack).ln() * mu
}

/// The weight of the product of the gradients of a row for a multiplier `z`.
fn curvature(h: f64, z: f64, barrier: Barrier) -> f64 {
    let mut moving = HyperDual64::from(h);
    moving.eps1 = 1.0;
    let own = psi(moving, barrier).eps1;
    let [slack, excess] = [barrier.mu / own, barrier.mu / (barrier.nu - own)];
    (slack / z + excess / (barrier.nu - z)).recip()
}

/// The control effort and the rows relative to their scales, with the margins.
fn effort_and_rows(
    model: &Model,
    kept: &Kept,
    margins: &[f64],
    z: &[HyperDual64],
) -> (HyperDual64, Vec<HyperDual64>) {
    let n = model.dof();
    let mut u = vec![HyperDual64::from(0.0); n];
    let (q, rest) = z.split_at(n);
    let (v, a) = rest.split_at(n);
    rnea(model, &mut Data::new(model), q, v, a, &mut u).expect("sizes agree");
    let mut h = vec![HyperDual64::from(0.0); kept.dim()];
    let states = kept.state.dim();
    let mut evaluator = Evaluator::new(model);
    let placed = evaluator.at(&z[..2 * n]).expect("sizes agree");
    placed
        .value(&kept.state, &mut h[..states])
        .expect("sizes agree");
    kept.torque
        .value(&u, &mut h[states..])
        .expect("sizes agree");
    let mut scales = vec![1.0; states];
    kept.state.row_scales(&mut scales);
    // A torque counts relative to its limit, that of a passive joint as it is.
    let limits = kept.torque.0.iter().flatten();
    scales.extend(limits.flat_map(|limit| {
        if *limit > 0.0 {
            vec![*limit; 2]
        } else {
            vec![1.0]
        }
    }));
    assert_eq!(scales.len(), h.len());
    let rows = h.iter().zip(scales).zip(margins);
    let rows = rows.map(|((h, scale), margin)| *h * scale.recip() + *margin);
    (u.iter().map(|u| *u * *u).sum(), rows.collect())
}

/// Gradient and Hessian of a function by numbers that move twice.
fn twice(z: &[f64], f: impl Fn(&[HyperDual64]) -> HyperDual64) -> (Vec<f64>, DMatrix<f64>) {
    let size = z.len();
    let (mut gradient, mut hessian) = (vec![0.0; size], DMatrix::zeros(size, size));
    for i in 0..size {
        for j in 0..size {
            let mut moved: Vec<_> = z.iter().map(|z| HyperDual64::from(*z)).collect();
            moved[i].eps1 = 1.0;
            moved[j].eps2 = 1.0;
            let found = f(&moved);
            (gradient[i], hessian[(i, j)]) = (found.eps1, found.eps1eps2);
        }
    }
    (gradient, hessian)
}

/// All kinds of constraints for a random tree, with a free, a passive and limited joints.
fn constraints(n: usize, rng: &mut ChaCha8Rng) -> Kept {
    let mut vector = || Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0));
    let balls: Vec<CollisionSphere> = (0..n)
        .map(|body| CollisionSphere {
            body: Some(body),
            centre: vector(),
            radius: 0.1,
        })
        .collect();
    let spheres = (0..3).map(|_| Sphere {
        centre: vector(),
        radius: 1.0,
    });
    let spheres = spheres.collect();
    let sides = [(Side::Lower, -0.2), (Side::Upper, 0.3)];
    let bounds =
        (0..2 * n).flat_map(|entry| sides.map(|(side, value)| Bound { entry, side, value }));
    let half_space = Solid::half_space(&vector(), 0.1);
    let limit = |i: usize| (i > 0).then(|| 0.5 * (i - 1) as f64);
    Constraints {
        state: vec![
            AnyConstraint::Spheres(SphereClearance {
                balls: balls.clone(),
                spheres,
            }),
            AnyConstraint::Solids(SolidClearance {
                balls,
                solids: vec![half_space],
                names: Vec::new(),
            }),
            AnyConstraint::Bounds(Bounds(bounds.collect())),
        ],
        torque: TorqueLimits((0..n).map(limit).collect()),
    }
}

fn point(z: &[f64]) -> Point<'_, f64> {
    let n = z.len() / 3;
    Point {
        index: 0,
        time: 0.0,
        q: &z[..n],
        v: &z[n..2 * n],
        a: &z[2 * n..],
    }
}

/// With the multipliers of the barrier, and no relaxations, gradient and Hessian are those of
/// $l_0 + \sum_j \psi(h_j + m_j)$. With others and with relaxations $r$ the gradient has the push $c_j r_j$ of the
/// curvature `c` on a row more, and the Hessian is that of $l_0 + \sum_j z_j h_j + c_j (h_j - \bar h_j)^2 / 2$ where
/// $\bar h$ is what `h` is here.
#[test]
fn derivatives_are_those_of_duals() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    for (n, seed) in [(3, 1), (4, 2), (5, 7)] {
        let model = random_tree(n, seed).expect("n > 0");
        let kept = constraints(n, &mut rng);
        let barrier = Barrier { mu: 3e-3, nu: 7.0 };
        let mut cost = BarrierCost::at_a_point(&model, &kept, barrier).expect("sizes agree");
        let rows = kept.dim();
        let equality = |j: usize| kept.is_equality(j);
        assert_eq!((0..rows).filter(|j| equality(*j)).count(), 1);
        cost.margins = (0..rows).map(|_| rng.random_range(0.0..0.1)).collect();
        let margins = cost.margins.clone();
        let z: Vec<f64> = (0..3 * n).map(|_| rng.random_range(-1.0..1.0)).collect();
        let fixed: Vec<_> = z.iter().map(|z| HyperDual64::from(*z)).collect();
        let here = effort_and_rows(&model, &kept, &margins, &fixed).1;
        let inside = here.iter().filter(|h| h.re < 0.0).count();
        assert!((3..rows - 3).contains(&inside), "{inside} of {rows}");

        let number = |rng: &mut ChaCha8Rng| rng.random_range(0.5..2.0);
        cost.equalities.duals = (0..rows).map(|_| number(&mut rng)).collect();
        cost.equalities.penalties = (0..rows).map(|_| number(&mut rng)).collect();
        let (duals, penalties) = (
            cost.equalities.duals.clone(),
            cost.equalities.penalties.clone(),
        );
        // The barrier of a clearance fades: with the distance `x` relative to 0.05 m, from 0 to 1, it is mu (x - 1 - (x
        // - 1)^2 / 2 - ln x), but for the part of the price, and nothing beyond. Where the bound is broken what is
        // added to the logarithm is a line.
        let clearance = |j: usize| !equality(j) && kept.label(j, &model).kind == RowKind::Clearance;
        let far = |j: usize, h: f64| clearance(j) && h < -0.05;
        let term = |j: usize, h: HyperDual64| {
            if far(j, h.re) {
                HyperDual64::from(0.0)
            } else if clearance(j) {
                let rest = h / 0.05 + 1.0;
                let added = if h.re < 0.0 {
                    rest + rest * rest * 0.5
                } else {
                    h / 0.025 + 1.5
                };
                psi(h, barrier) - psi(HyperDual64::from(-0.05), barrier) - added * barrier.mu
            } else if equality(j) {
                h * duals[j] + h * h * (0.5 * penalties[j])
            } else {
                psi(h, barrier)
            }
        };
        // That of the logarithm: what is added to it depends on nothing else.
        let multiplier = |j: usize| {
            let mut h = here[j];
            h.eps1 = 1.0;
            if equality(j) || far(j, h.re) {
                term(j, h).eps1
            } else {
                psi(h, barrier).eps1
            }
        };
        let added = |j: usize, h: f64| {
            let none = !clearance(j) || far(j, h);
            let rest = if none { -1.0 } else { 1.0 + h.min(0.0) / 0.05 };
            let bend = if none || h >= 0.0 { 0.0 } else { 400.0 };
            [(1.0 + rest) / 0.05 * barrier.mu, bend * barrier.mu]
        };
        cost.multipliers = (0..rows).map(multiplier).collect();
        let with_barriers = |z: &[HyperDual64]| {
            let (effort, h) = effort_and_rows(&model, &kept, &margins, z);
            let all = h.iter().enumerate();
            effort + all.map(|(j, h)| term(j, *h)).sum::<HyperDual64>()
        };
        let mut out = PointDerivatives::new(n);
        cost.derivatives(point(&z), &mut out).expect("sizes agree");
        let value = cost.value(point(&z)).expect("sizes agree");
        assert!((value - with_barriers(&fixed).re).abs() <= 1e-12 * value);
        let (gradient, hessian) = twice(&z, with_barriers);
        // Sums of some hundred products in another order.
        assert_close!(&out.gradient, &gradient, 1e-12);
        assert_close!(&out.hessian, &hessian, 1e-12);

        let mut between = |j: usize| {
            if equality(j) || far(j, here[j].re) {
                multiplier(j)
            } else {
                barrier.nu * rng.random_range(0.05..0.95)
            }
        };
        cost.multipliers = (0..rows).map(&mut between).collect();
        cost.relaxations = (0..rows)
            .map(|j| {
                let relaxed = !equality(j) && j % 3 != 1;
                if relaxed {
                    here[j].re.max(0.0) + 0.02
                } else {
                    0.0
                }
            })
            .collect();
        let (multipliers, relaxations) = (&cost.multipliers, &cost.relaxations);
        let left: Vec<f64> = (0..rows).map(|j| here[j].re - relaxations[j]).collect();
        let c: Vec<f64> = (0..rows)
            .map(|j| {
                if far(j, left[j]) {
                    0.0
                } else if equality(j) {
                    penalties[j]
                } else {
                    let rate = curvature(left[j], multipliers[j], barrier);
                    (rate - added(j, left[j])[1]).max(0.0)
                }
            })
            .collect();
        let pushed = |z: &[HyperDual64]| {
            let (effort, h) = effort_and_rows(&model, &kept, &margins, z);
            let all = h.iter().enumerate();
            let of = |(j, h): (usize, &HyperDual64)| {
                term(j, *h - relaxations[j]) + *h * (c[j] * relaxations[j])
            };
            effort + all.map(of).sum::<HyperDual64>()
        };
        let primal_dual = |z: &[HyperDual64]| {
            let (effort, h) = effort_and_rows(&model, &kept, &margins, z);
            let all = h.iter().enumerate();
            let of = |(j, h): (usize, &HyperDual64)| {
                let moved = *h - here[j].re;
                let weight = multipliers[j] - added(j, left[j])[0];
                let weight = if clearance(j) {
                    weight.max(0.0)
                } else {
                    weight
                };
                *h * weight + moved * moved * (0.5 * c[j])
            };
            effort + all.map(of).sum::<HyperDual64>()
        };
        let (gradient, hessian) = (twice(&z, pushed).0, twice(&z, primal_dual).1);
        cost.derivatives(point(&z), &mut out).expect("sizes agree");
        assert_close!(&out.gradient, &gradient, 1e-12);
        assert_close!(&out.hessian, &hessian, 1e-12);
    }
}

/// A row that is `h`, and nothing else: value and slope of its barrier.
fn barrier_of(h: f64, barrier: Barrier) -> (f64, f64) {
    let model = slider(1.0);
    let bound = Bound {
        entry: 0,
        side: Side::Upper,
        value: 0.0,
    };
    let kept = Constraints {
        state: vec![AnyConstraint::Bounds(Bounds(vec![bound]))],
        torque: TorqueLimits(vec![None]),
    };
    let z = [h, 0.0, 0.0];
    let mut cost = BarrierCost::at_a_point(&model, &kept, barrier).expect("sizes agree");
    cost.margins.fill(0.0);
    cost.multipliers.fill(0.3 * barrier.nu);
    let value = cost.value(point(&z)).expect("sizes agree");
    let mut out = PointDerivatives::new(1);
    cost.derivatives(point(&z), &mut out).expect("sizes agree");
    (value, out.gradient[0])
}

proptest! {
    #![proptest_config(config(64))]

    /// The least of what excess and slack cost, by a search of the slack alone, and the slope that belongs to it.
    #[test]
    fn a_barrier_is_the_least_of_excess_and_slack(
        h in -3.0..3.0_f64, mu in -6.0..0.5_f64, nu in -1.0..2.0_f64,
    ) {
        let barrier = Barrier { mu: 10.0_f64.powf(mu), nu: 10.0_f64.powf(nu) };
        let Barrier { mu, nu } = barrier;
        let (value, slope) = barrier_of(h, barrier);
        let costs = |slack: f64| {
            let excess = h + slack;
            nu * excess - mu * (slack.ln() + excess.ln())
        };
        // Convex in the slack, and in its logarithm it has one minimum too.
        let (mut from, mut to) = ((-h).max(0.0), (-h).max(0.0) + 10.0 + 10.0 * mu / nu);
        for _ in 0..300 {
            let [left, right] = [from + 0.382 * (to - from), from + 0.618 * (to - from)];
            if costs(left) < costs(right) { to = right } else { from = left }
        }
        let least = costs(0.5 * (from + to));
        let size = 1.0 + value.abs();
        prop_assert!((value - least).abs() <= 1e-9 * size, "{value} {least}");
        let mut moving = HyperDual64::from(h);
        moving.eps1 = 1.0;
        let by_duals = psi(moving, barrier);
        prop_assert!((value - by_duals.re).abs() <= 1e-8 * size);
        prop_assert!((slope - by_duals.eps1).abs() <= 1e-8 * nu, "{slope} {}", by_duals.eps1);
        // At the extremes rounding leaves the bounds themselves.
        prop_assert!((0.0..=nu).contains(&slope));
    }

    /// As the barrier becomes weak its sum with the price is the exact penalty, and numbers stay numbers.
    #[test]
    fn a_weak_barrier_is_the_exact_penalty(h in -3.0..3.0_f64, nu in -1.0..9.0_f64) {
        let nu = 10.0_f64.powf(nu);
        let exact = nu * h.max(0.0);
        let mut before = f64::INFINITY;
        for power in [-2, -5, -8, -11] {
            let mu = 10.0_f64.powi(power);
            for h in [h, 0.0] {
                let exact = if h == 0.0 { 0.0 } else { exact };
                let (value, slope) = barrier_of(h, Barrier { mu, nu });
                // 2 mu and logarithms of numbers above 1e-25 and below 1e3.
                let apart = (value - exact).abs();
                let rounding = 4e-15 * (exact + h * h);
                prop_assert!(apart <= 200.0 * mu + rounding, "{mu} {h}: {value} {exact}");
                prop_assert!(slope.is_finite());
                if h == 0.0 {
                    prop_assert!(apart < before);
                    before = apart;
                }
            }
        }
    }
}

/// Far out and far in nothing overflows, and signs are as they have to be.
#[test]
fn barriers_at_extremes_are_numbers() {
    for h in [-1e9, -1.0, -1e-300, 0.0, 1e-300, 1.0, 1e9] {
        for (mu, nu) in [(1e-12, 1e9), (1e3, 1e-3), (1e-12, 1e-3)] {
            let (value, slope) = barrier_of(h, Barrier { mu, nu });
            assert!(value.is_finite(), "{h} {mu} {nu}");
            assert!((0.0..=nu).contains(&slope), "{h} {mu} {nu}: {slope}");
        }
    }
}
