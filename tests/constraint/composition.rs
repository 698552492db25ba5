//! Composed constraints: rows, names and derivatives are those of the parts.

use crate::common::constraint::{Held, Slow};
use crate::common::{robot, wave};
use aghf::constraint::{
    AnyConstraint, Bound, Bounds, CollisionSphere, Constraint, DynConstraint, Evaluator, RowLabel, RowSet, Side,
    SolidClearance, Sphere, SphereClearance, Weights,
};
use aghf::geometry::Solid;
use aghf::model::Model;
use nalgebra::{DMatrix, DVector, Vector3};

/// Six different ones, with another number of rows each.
type Parts = (SphereClearance, SolidClearance, (Held, Slow), Bounds, Bounds, Bounds);

fn parts(model: &Model) -> Parts {
    let balls = CollisionSphere::joint_frames(model);
    let sphere = |z| Sphere { centre: Vector3::new(0.2, 0.1, z), radius: 0.1 };
    (
        SphereClearance { balls: balls.clone(), spheres: vec![sphere(0.3), sphere(0.7)] },
        SolidClearance { balls, solids: vec![Solid::half_space(&Vector3::z(), 0.2)], names: Vec::new() },
        (Held(0.09), Slow(0.5)),
        Bounds::velocities(model),
        Bounds::positions(model),
        Bounds(vec![Bound { entry: 3, side: Side::Upper, value: 0.4 }]),
    )
}

/// All results of a constraint at a state.
#[derive(Clone, Debug, PartialEq)]
struct Said {
    values: Vec<f64>,
    sets: Vec<RowSet>,
    labels: Vec<RowLabel>,
    gradient: DVector<f64>,
    hessian: DMatrix<f64>,
}

/// All results, with the weights of rows from `first` on of a longer list.
fn said(model: &Model, constraint: &impl Constraint, first: usize) -> Said {
    let x = wave(2 * model.dof(), 0.9);
    let mut evaluator = Evaluator::new(model);
    let mut here = evaluator.at(&x).expect("lengths agree");
    let rows = constraint.dim();
    let mut values = vec![f64::NAN; rows];
    here.value(constraint, &mut values).expect("same robot");
    let of = |f| wave(first + rows, f).split_off(first);
    let weights = Weights { first_order: &of(0.7), gauss_newton: Some(&of(1.9)) };
    let derivatives = here.weighted_derivatives(constraint, weights);
    let derivatives = derivatives.expect("same robot");
    Said {
        values,
        sets: (0..rows).map(|row| RowSet { distance: None, ..constraint.row_set(row) }).collect(),
        labels: (0..rows).map(|row| constraint.label(row, model)).collect(),
        gradient: derivatives.gradient().clone(),
        hessian: derivatives.hessian().clone(),
    }
}

/// The results of the parts, concatenated.
fn joined(parts: impl IntoIterator<Item = Said>) -> Said {
    let mut parts = parts.into_iter();
    let mut all = parts.next().expect("there is one");
    for part in parts {
        all.values.extend(part.values);
        all.sets.extend(part.sets);
        all.labels.extend(part.labels);
        all.gradient += part.gradient;
        all.hessian += part.hessian;
    }
    all
}

/// Compares up to rounding, because sums have another order.
fn assert_is(model: &Model, whole: &impl Constraint, parts: &Said) {
    let whole = said(model, whole, 0);
    assert_close!(&whole.gradient, &parts.gradient, 1e-13);
    assert_close!(&whole.hessian, &parts.hessian, 1e-13);
    let same_sums = Said { gradient: whole.gradient.clone(), hessian: whole.hessian.clone(), ..parts.clone() };
    assert_eq!(whole, same_sums);
}

#[test]
fn tuples_are_their_parts() {
    let model = &robot("kinova_gen3");
    let (a, b, c, d, e, f) = &parts(model);
    let dims = [a.dim(), b.dim(), c.dim(), d.dim(), e.dim(), f.dim()];
    let first = |i: usize| dims[..i].iter().sum::<usize>();
    let each = [
        said(model, a, first(0)),
        said(model, b, first(1)),
        said(model, c, first(2)),
        said(model, d, first(3)),
        said(model, e, first(4)),
        said(model, f, first(5)),
    ];
    let of = |count: usize| joined(each[..count].to_vec());
    assert_is(model, &(a, b), &of(2));
    assert_is(model, &(a, b, c), &of(3));
    assert_is(model, &((a, (b, c)), (), ((d, e), f)), &of(6));
    // An index out of range is no equality, and is named by its number.
    let all = ((a, b, c), (d, e, f));
    assert!(!all.row_set(all.dim()).is_equality);
    assert_eq!(all.label(all.dim(), model).unit, "");
}

/// Lists of all kinds have the same results as the tuple, to the last bit.
#[test]
fn lists_are_tuples() {
    let model = &robot("kinova_gen3");
    let (a, b, c, d, e, f) = parts(model);
    let truth = said(model, &((&a, &b, &c), (&d, &e, &f)), 0);
    let boxed: [Box<dyn DynConstraint>; 6] = [
        Box::new(a.clone()),
        Box::new(b.clone()),
        Box::new(c.clone()),
        Box::new(d.clone()),
        Box::new(e.clone()),
        Box::new(f.clone()),
    ];
    let any = [
        AnyConstraint::Spheres(a),
        AnyConstraint::Solids(b),
        AnyConstraint::Other(Box::new(c)),
        AnyConstraint::Bounds(d),
        AnyConstraint::Bounds(e),
        AnyConstraint::Bounds(f),
    ];
    assert_eq!(said(model, &boxed, 0), truth);
    assert_eq!(said(model, &boxed.to_vec(), 0), truth);
    assert_eq!(said(model, &any, 0), truth);
    assert_eq!(said(model, &&any[..], 0), truth);
    assert_eq!(said(model, &any.to_vec(), 0), truth);
    assert_eq!(said(model, &any.iter().collect::<Vec<_>>(), 0), truth);
    let (first, rest) = any.split_at(2);
    assert_eq!(said(model, &vec![first, rest], 0), truth);
    let none: Vec<AnyConstraint> = Vec::new();
    assert_eq!(said(model, &none, 0), said(model, &(), 0));
}
