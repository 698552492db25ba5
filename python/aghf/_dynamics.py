"""Rigid-body dynamics, the right-hand side of the flow, and their derivatives."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ._native import _aghf
from ._model import Model, array


class InverseDynamicsDerivatives(NamedTuple):
    """Torques with their derivatives; rows are torques."""

    tau: np.ndarray
    dq: np.ndarray
    dv: np.ndarray
    da: np.ndarray


class ForwardDynamicsDerivatives(NamedTuple):
    """Accelerations with their derivatives; rows are accelerations."""

    a: np.ndarray
    dq: np.ndarray
    dv: np.ndarray
    dtau: np.ndarray


class InverseDynamicsSecondDerivatives(NamedTuple):
    """Second derivatives of torques: the first index is the torque, the others are in the order of the name."""

    dqdq: np.ndarray
    dvdv: np.ndarray
    dqdv: np.ndarray
    dadq: np.ndarray


class ForwardDynamicsSecondDerivatives(NamedTuple):
    """Second derivatives of accelerations at constant torques: the first index is the acceleration."""

    dqdq: np.ndarray
    dvdv: np.ndarray
    dqdv: np.ndarray


class Energy(NamedTuple):
    """Energies, J."""

    kinetic: np.ndarray
    potential: np.ndarray


class RneaVjp(NamedTuple):
    """The derivatives of ``w @ rnea(q, v, a)``."""

    q: np.ndarray
    v: np.ndarray
    a: np.ndarray


class RneaWeightedHessian(NamedTuple):
    """The second derivatives of ``w @ rnea(q, v, a)``."""

    qq: np.ndarray
    qv: np.ndarray
    vv: np.ndarray
    qa: np.ndarray


class OmegaJacobian(NamedTuple):
    """The derivatives of Omega, (B38) to (B40)."""

    dx: np.ndarray
    dxdot: np.ndarray
    dxddot: np.ndarray


def rnea(model: Model, q: ArrayLike, v: ArrayLike, a: ArrayLike) -> np.ndarray:
    """Inverse dynamics: the torques or forces of accelerations, by the recursive Newton-Euler algorithm.

    Parameters
    ----------
    q, v, a : array_like, shape (N,) or (B, N)
        Positions, velocities and accelerations.

    Returns
    -------
    numpy.ndarray, shape (N,) or (B, N)
    """
    return _aghf.rnea(model._own, array(q, "q"), array(v, "v"), array(a, "a"))[0]


def aba(model: Model, q: ArrayLike, v: ArrayLike, tau: ArrayLike) -> np.ndarray:
    """Forward dynamics: the accelerations of torques or forces, by the articulated-body algorithm. Shapes as `rnea`."""
    return _aghf.aba(model._own, array(q, "q"), array(v, "v"), array(tau, "tau"))[0]


def crba(model: Model, q: ArrayLike) -> np.ndarray:
    """The mass matrix, both triangles, shape (N, N) or (B, N, N)."""
    return _aghf.crba(model._own, array(q, "q"))[0]


def mass_matrix_and_rate(model: Model, q: ArrayLike, v: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """The mass matrix ``H`` and its rate along ``v``, each (N, N) or (B, N, N)."""
    mass_matrix, rate = _aghf.mass_matrix_and_rate(model._own, array(q, "q"), array(v, "v"))
    return mass_matrix, rate


def energy(model: Model, q: ArrayLike, v: ArrayLike) -> Energy:
    """The kinetic and potential energies, each a number or (B,).

    The potential energy is zero with all centres of mass at the height of the base.
    """
    return Energy(*_aghf.energy(model._own, array(q, "q"), array(v, "v")))


def rnea_derivatives(model: Model, q: ArrayLike, v: ArrayLike, a: ArrayLike) -> InverseDynamicsDerivatives:
    """Inverse dynamics and first derivatives, each (N, N) or (B, N, N); the derivative in ``a`` is the mass matrix."""
    found = _aghf.rnea_derivatives(model._own, array(q, "q"), array(v, "v"), array(a, "a"))
    return InverseDynamicsDerivatives(*found)


def aba_derivatives(model: Model, q: ArrayLike, v: ArrayLike, tau: ArrayLike) -> ForwardDynamicsDerivatives:
    """Forward dynamics with its first derivatives; the derivative in ``tau`` is the inverse of the mass matrix."""
    found = _aghf.aba_derivatives(model._own, array(q, "q"), array(v, "v"), array(tau, "tau"))
    return ForwardDynamicsDerivatives(*found)


def rnea_second_derivatives(model: Model, q: ArrayLike, v: ArrayLike, a: ArrayLike) -> InverseDynamicsSecondDerivatives:
    """Second derivatives of the inverse dynamics, each (N, N, N) or (B, N, N, N)."""
    found = _aghf.rnea_second_derivatives(model._own, array(q, "q"), array(v, "v"), array(a, "a"))
    return InverseDynamicsSecondDerivatives(*found)


def aba_second_derivatives(
    model: Model, q: ArrayLike, v: ArrayLike, tau: ArrayLike
) -> ForwardDynamicsSecondDerivatives:
    """Second derivatives of the forward dynamics in the state, each (N, N, N) or (B, N, N, N)."""
    found = _aghf.aba_second_derivatives(model._own, array(q, "q"), array(v, "v"), array(tau, "tau"))
    return ForwardDynamicsSecondDerivatives(*found)


def rnea_vjp(model: Model, q: ArrayLike, v: ArrayLike, a: ArrayLike, w: ArrayLike) -> RneaVjp:
    """The product of ``w`` with the derivatives of the inverse dynamics, in O(N) per state."""
    return RneaVjp(*_aghf.rnea_vjp(model._own, array(q, "q"), array(v, "v"), array(a, "a"), array(w, "w")))


def rnea_weighted_hessian(model: Model, q: ArrayLike, v: ArrayLike, a: ArrayLike, w: ArrayLike) -> RneaWeightedHessian:
    """The second derivatives of ``w @ rnea(q, v, a)``, in O(N^2) per state."""
    own = model._own
    found = _aghf.rnea_weighted_hessian(own, array(q, "q"), array(v, "v"), array(a, "a"), array(w, "w"))
    return RneaWeightedHessian(*found)


def forward_kinematics(model: Model, q: ArrayLike) -> np.ndarray:
    """The homogeneous placements of all bodies in the base, shape (N, 4, 4) or (B, N, 4, 4)."""
    return _aghf.forward_kinematics(model._own, array(q, "q"))[0]


def frame_placement(model: Model, q: ArrayLike, frame: str) -> np.ndarray:
    """The homogeneous placement of a frame in the base, shape (4, 4) or (B, 4, 4)."""
    return _aghf.frame_placements(model._own, array(q, "q"), frame)[0]


def frame_jacobian(model: Model, q: ArrayLike, frame: str) -> np.ndarray:
    """The Jacobian of a frame, shape (6, N) or (B, 6, N): its angular velocity, then that of its
    origin, along the axes of the base. It is Pinocchio's ``LOCAL_WORLD_ALIGNED``, which has the linear rows first."""
    return _aghf.frame_jacobian(model._own, array(q, "q"), frame)[0]


def inverse_kinematics(
    model: Model, placement: ArrayLike, frame: str, *, near: ArrayLike | None = None, guesses: int = 64
) -> np.ndarray:
    """Joint positions that take a frame to homogeneous placements in the base, shape (N,) or (B, N).

    They are within the position limits, and the placement is kept within 1e-9 m and rad; NaN where no search found
    any, which does not prove that there are none. Collisions and torques are not checked: `aghf ik`, and goals of
    scenarios, leave such positions out.

    Parameters
    ----------
    model : Model
        The robot.
    placement : (4, 4) or (B, 4, 4)
        The placements, as from `frame_placement`.
    frame : str
        The frame.
    near : (N,) or (B, N), optional
        The joint positions at which the searches begin; by default those within the limits that are nearest to zero.
    guesses : int, optional
        The largest number of searches for each placement; those after the first one are from random positions, which
        are the same in each call.

    Raises
    ------
    KeyError
        The robot has no such frame.
    ValueError
        A shape is wrong, or the last row of a placement.
    InputError
        The upper left of a placement is not a rotation, or a number is not finite.
    """
    goals = array(placement, "placement")
    if goals.shape[-2:] != (4, 4) or goals.ndim > 3:
        raise ValueError(f"placement: its shape is {list(goals.shape)}, expected [4, 4] or [batch, 4, 4]")
    if not np.array_equal(goals[..., 3, :], np.broadcast_to([0.0, 0.0, 0.0, 1.0], goals[..., 3, :].shape)):
        raise ValueError("placement: the last row of each is 0, 0, 0, 1")
    first = np.clip(0.0, model.lower, model.upper) if near is None else array(near, "near")
    shape = (*goals.shape[:-2], model.dof)
    if first.shape not in (shape, shape[-1:]):
        raise ValueError(f"near: its shape is {list(first.shape)}, expected {[model.dof]} or {list(shape)}")
    rotations, translations = goals[..., :3, :3], goals[..., :3, 3]
    numbers = np.concatenate([rotations.reshape(*goals.shape[:-2], 9), translations], axis=-1)
    each = np.ascontiguousarray(np.broadcast_to(first, shape))
    return _aghf.inverse_kinematics(model._own, numbers, each, frame, guesses)[0]


def omega(model: Model, x: ArrayLike, xdot: ArrayLike, xddot: ArrayLike, k: float) -> np.ndarray:
    """The right-hand side of the flow at nodes, (B3), shape (2 N,) or (B, 2 N); ``k`` is the penalty of (11)."""
    return _aghf.omega(model._own, array(x, "x"), array(xdot, "xdot"), array(xddot, "xddot"), k)[0]


def omega_jacobian(
    model: Model, x: ArrayLike, xdot: ArrayLike, xddot: ArrayLike, k: float, jacobian: str = "control_form"
) -> OmegaJacobian:
    """The Jacobian of `omega` by an implementation named in `jacobians`, each (2 N, 2 N) or (B, 2 N, 2 N)."""
    arguments = array(x, "x"), array(xdot, "xdot"), array(xddot, "xddot")
    return OmegaJacobian(*_aghf.omega_jacobian(model._own, *arguments, k, jacobian))
