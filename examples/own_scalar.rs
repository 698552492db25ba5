//! A scalar of one's own that counts operations, and prints those of the inverse dynamics of each built-in robot.

use aghf::dynamics::{Data, InverseDynamicsDerivatives, rnea, rnea_derivatives};
use aghf::scalar::{AlgebraOver, Scalar, impl_scalar_operators};
use aghf::urdf::{builtin_robot, builtin_robots};
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
static OPERATIONS: AtomicU64 = AtomicU64::new(0);

#[derive(Clone, Copy, Debug, PartialEq)]
struct Counted(f64);

fn counted(result: f64) -> Counted {
    OPERATIONS.fetch_add(1, Relaxed);
    Counted(result)
}

impl_scalar_operators! {
    impl [] for Counted {
        zero() => Self(0.0),
        one() => Self(1.0),
        is_zero(a) => a.0 == 0.0,
        neg(a) => Self(-a.0),
        add(a, b) => counted(a.0 + b.0),
        sub(a, b) => counted(a.0 - b.0),
        mul(a, b) => counted(a.0 * b.0),
        div(a, b) => counted(a.0 / b.0),
    }
}

#[rustfmt::skip]
impl Scalar for Counted {
    fn from_f64(x: f64) -> Self { Self(x) }
    fn sin_cos(self) -> (Self, Self) { (Self(self.0.sin()), Self(self.0.cos())) }
    fn sqrt(self) -> Self { Self(self.0.sqrt()) }
    fn if_negative(self, then: Self, otherwise: Self) -> Self { if self.0 < 0.0 { then } else { otherwise } }
}

/// The constants of a robot stay plain numbers.
#[rustfmt::skip]
impl AlgebraOver<f64> for Counted {
    fn lift(c: f64) -> Self { Self(c) }
    fn scale(self, c: f64) -> Self { counted(self.0 * c) }
}

fn main() -> aghf::Result<()> {
    println!("robot             joints  operations  with derivatives");
    for name in builtin_robots() {
        let model = builtin_robot(name)?;
        let n = model.dof();
        let [q, v, a, mut tau] = [0.3, 0.5, 0.7, 0.0].map(|x| vec![Counted(x); n]);
        let (mut data, mut all) = (Data::new(&model), InverseDynamicsDerivatives::new(n));
        OPERATIONS.store(0, Relaxed);
        rnea(&model, &mut data, &q, &v, &a, &mut tau)?;
        let alone = OPERATIONS.swap(0, Relaxed);
        rnea_derivatives(&model, &mut data, &q, &v, &a, &mut all)?;
        println!("{name:17} {n:6}  {alone:10}  {:16}", OPERATIONS.load(Relaxed));
    }
    Ok(())
}
