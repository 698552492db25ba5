//! Several numbers processed at once.

use super::{AlgebraOver, Scalar, Tanh, Zero, impl_scalar_operators};

/// `W` numbers in the same arithmetic, such as the same joint at `W` times of a motion.
///
/// Over `f64` the compiler generates SIMD instructions, as wide as it may (`-C target-cpu`). Each lane has bit for bit
/// the value of a single number.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(32))]
pub struct Lanes<S, const W: usize>(pub [S; W]);

/// The number of lanes of [`Wide`]: as many `f64` as a vector of AVX2 has.
pub const LANES: usize = 4;

/// The values of a quantity at [`LANES`] points, which go through the dynamics together.
pub type Wide<S = f64> = Lanes<S, LANES>;

impl<S: Scalar, const W: usize> Lanes<S, W> {
    /// The same number in all lanes.
    #[inline(always)]
    #[must_use]
    pub fn splat(x: S) -> Self {
        Self([x; W])
    }
}

#[cfg(feature = "solvers")]
impl<S: Scalar, const W: usize> Lanes<S, W> {
    /// Copies the columns from `first` on of a column-major matrix into the lanes of `to`, which is as long as a
    /// column. Unused lanes get the last column; returns the number of used lanes.
    pub(crate) fn gather(columns: &[S], first: usize, to: &mut [Self]) -> usize {
        let size = to.len();
        let count = W.min(columns.len() / size - first);
        for lane in 0..W {
            let begin = (first + lane.min(count - 1)) * size;
            for (to, from) in to.iter_mut().zip(&columns[begin..begin + size]) {
                to.0[lane] = *from;
            }
        }
        count
    }
}

/// Applies `op` to each lane in a loop, because the compiler does not always unroll `array::map`.
#[inline(always)]
fn lanewise<S: Scalar, const W: usize>(mut a: Lanes<S, W>, b: Lanes<S, W>, op: impl Fn(&mut S, S)) -> Lanes<S, W> {
    for i in 0..W {
        op(&mut a.0[i], b.0[i]);
    }
    a
}

impl_scalar_operators! {
    #[inline(always)]
    impl [S: Scalar, const W: usize] for Lanes<S, W> {
        zero() => Self::splat(S::zero()),
        one() => Self::splat(S::one()),
        is_zero(a) => a.0.iter().all(Zero::is_zero),
        neg(a) => lanewise(a, a, |x, _| *x = -*x),
        add(a, b) => lanewise(a, b, |x, y| *x += y),
        sub(a, b) => lanewise(a, b, |x, y| *x -= y),
        mul(a, b) => lanewise(a, b, |x, y| *x *= y),
        div(a, b) => lanewise(a, b, |x, y| *x /= y),
    }
}

impl<S: Scalar, const W: usize> Scalar for Lanes<S, W> {
    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        Self::splat(S::from_f64(x))
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let mut found = [(S::zero(), S::zero()); W];
        S::sin_cos_of_several(&self.0, &mut found);
        let (mut sin, mut cos) = (self, self);
        for i in 0..W {
            (sin.0[i], cos.0[i]) = found[i];
        }
        (sin, cos)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        lanewise(self, self, |x, _| *x = x.sqrt())
    }

    #[inline(always)]
    fn if_negative(self, then: Self, otherwise: Self) -> Self {
        let mut chosen = otherwise;
        for i in 0..W {
            chosen.0[i] = self.0[i].if_negative(then.0[i], otherwise.0[i]);
        }
        chosen
    }

    #[inline(always)]
    fn vanishes(&self) -> bool {
        // Without a branch, so that lanes are compared side by side.
        self.0.iter().fold(true, |all, x| all & x.vanishes())
    }
}

impl<S: Tanh, const W: usize> Tanh for Lanes<S, W> {
    #[inline(always)]
    fn tanh(self) -> Self {
        Self(self.0.map(S::tanh))
    }
}

impl<C: Copy, S: AlgebraOver<C>, const W: usize> AlgebraOver<C> for Lanes<S, W> {
    #[inline(always)]
    fn lift(c: C) -> Self {
        Self::splat(S::lift(c))
    }

    #[inline(always)]
    fn scale(mut self, c: C) -> Self {
        for x in &mut self.0 {
            *x = x.scale(c);
        }
        self
    }
}
