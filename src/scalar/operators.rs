//! A macro for the operators of a number type.

/// Implements the operators of a number type from a few functions: `+`, `-`, `*`, `/`, negation, the assignment
/// operators, zero and one. In addition to these, [`Scalar`](crate::scalar::Scalar) requires `from_f64`, `sin_cos`,
/// `sqrt` and `if_negative`.
///
/// Attributes such as `#[inline]` apply to every function. The brackets hold the parameters of the type, `[]` for none.
/// The [guide](crate::guide::scalar) defines a scalar with it.
///
/// ```
/// use aghf::impl_scalar_operators;
///
/// #[derive(Clone, Copy, Debug, PartialEq)]
/// struct Mine(f64);
///
/// impl_scalar_operators! {
///     #[inline]
///     impl [] for Mine {
///         zero() => Self(0.0),
///         one() => Self(1.0),
///         is_zero(a) => a.0 == 0.0,
///         neg(a) => Self(-a.0),
///         add(a, b) => Self(a.0 + b.0),
///         sub(a, b) => Self(a.0 - b.0),
///         mul(a, b) => Self(a.0 * b.0),
///         div(a, b) => Self(a.0 / b.0),
///     }
/// }
///
/// let mut x = Mine(3.0) * Mine(2.0);
/// x -= Mine(1.0);
/// assert_eq!(-x / Mine(2.0), Mine(-2.5));
/// ```
#[macro_export]
macro_rules! impl_scalar_operators {
    (
        $(#[$attribute:meta])*
        impl [$($parameters:tt)*] for $type:ty {
            zero() => $zero:expr,
            one() => $one:expr,
            is_zero($x:ident) => $is_zero:expr,
            neg($y:ident) => $neg:expr,
            add($add_a:ident, $add_b:ident) => $add:expr,
            sub($sub_a:ident, $sub_b:ident) => $sub:expr,
            mul($mul_a:ident, $mul_b:ident) => $mul:expr,
            div($div_a:ident, $div_b:ident) => $div:expr $(,)?
        }
    ) => {
        impl<$($parameters)*> $crate::scalar::Zero for $type {
            $(#[$attribute])*
            fn zero() -> Self {
                $zero
            }

            $(#[$attribute])*
            fn is_zero(&self) -> bool {
                let $x = *self;
                $is_zero
            }
        }

        impl<$($parameters)*> $crate::scalar::One for $type {
            $(#[$attribute])*
            fn one() -> Self {
                $one
            }
        }

        impl<$($parameters)*> ::std::ops::Neg for $type {
            type Output = Self;
            $(#[$attribute])*
            fn neg(self) -> Self {
                let $y = self;
                $neg
            }
        }

        $crate::impl_scalar_operators!(@binary [$(#[$attribute])*] [$($parameters)*] $type,
            Add add AddAssign add_assign $add_a $add_b $add);
        $crate::impl_scalar_operators!(@binary [$(#[$attribute])*] [$($parameters)*] $type,
            Sub sub SubAssign sub_assign $sub_a $sub_b $sub);
        $crate::impl_scalar_operators!(@binary [$(#[$attribute])*] [$($parameters)*] $type,
            Mul mul MulAssign mul_assign $mul_a $mul_b $mul);
        $crate::impl_scalar_operators!(@binary [$(#[$attribute])*] [$($parameters)*] $type,
            Div div DivAssign div_assign $div_a $div_b $div);
    };
    (
        @binary [$(#[$attribute:meta])*] [$($parameters:tt)*] $type:ty,
        $Operator:ident $operator:ident $Assign:ident $assign:ident $a:ident $b:ident $value:expr
    ) => {
        impl<$($parameters)*> ::std::ops::$Operator for $type {
            type Output = Self;
            $(#[$attribute])*
            fn $operator(self, other: Self) -> Self {
                let ($a, $b) = (self, other);
                $value
            }
        }

        impl<$($parameters)*> ::std::ops::$Assign for $type {
            $(#[$attribute])*
            fn $assign(&mut self, other: Self) {
                *self = ::std::ops::$Operator::$operator(*self, other);
            }
        }
    };
}
