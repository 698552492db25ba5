"""Models of Pinocchio."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ._dynamics import rnea
from ._model import Model
from ._native import _aghf

#: The largest relative difference between the torques of a model and of its conversion.
_AGREEMENT = 1e-9


def from_pinocchio(model: Any) -> Model:
    """The robot of `Model.from_pinocchio`."""
    import pinocchio

    joints = [_joint(model, i) for i in range(1, model.njoints)]
    frames, names = [], set(list(model.names)[1:])
    for frame in model.frames:
        # In both libraries each joint has a frame of the same name.
        if frame.name in names or frame.type == pinocchio.FrameType.JOINT or frame.name == "universe":
            continue
        names.add(frame.name)
        frames.append((frame.name, frame.parentJoint - 1, _placement(frame.placement)))
    ours = Model._made("from_parts", model.name or "pinocchio", joints, frames, model.gravity.linear.tolist())
    _compare(pinocchio, model, ours)
    return ours


def pinocchio_configuration(model: Any, q: ArrayLike) -> np.ndarray:
    """The ``q`` of a ``pinocchio.Model`` at our positions, shape (nq,) or (B, nq)."""
    q = np.asarray(q, dtype=float)
    rows = [np.asarray(q[..., i]) for i in range(model.njoints - 1)]
    there = np.zeros((*q.shape[:-1], model.nq))
    for joint, own in zip(list(model.joints)[1:], rows, strict=True):
        if joint.nq == 2:
            there[..., joint.idx_q], there[..., joint.idx_q + 1] = np.cos(own), np.sin(own)
        else:
            there[..., joint.idx_q] = own
    return there


def _refused(model: Any, element: str, condition: str) -> Exception:
    error = _aghf.InputError(f"{model.name}: {element}: {condition}")
    error.file, error.element, error.condition = model.name, element, condition
    return error


def _placement(placement: Any) -> list[float]:
    return [*np.asarray(placement.rotation).ravel().tolist(), *np.asarray(placement.translation).tolist()]


def _limit(model: Any, new: str, old: str, i: int) -> float:
    """A limit by its name in this version of Pinocchio; zero becomes infinite, as in a URDF."""
    values = getattr(model, new) if hasattr(model, new) else getattr(model, old)
    return float(values[i]) or float("inf")


def _joint(model: Any, i: int) -> tuple[Any, ...]:
    joint, name = model.joints[i], model.names[i]
    element = f"joint '{name}'"
    if joint.nv != 1 or "Mimic" in joint.shortname():
        condition = f"it is a {joint.shortname()}, a joint has one degree of freedom of its own here"
        raise _refused(model, element, condition)
    if model.armature[joint.idx_v] != 0.0:
        raise _refused(model, element, "it has an armature, which the dynamics here do not have")
    data = joint.createData()
    joint.calc(data, np.array([1.0, 0.0]) if joint.nq == 2 else np.zeros(1))
    subspace = np.asarray(data.S, dtype=float).ravel()
    linear, angular = subspace[:3], subspace[3:]
    lower, upper = float("-inf"), float("inf")
    if joint.nq == 1:
        lower, upper = float(model.lowerPositionLimit[joint.idx_q]), float(model.upperPositionLimit[joint.idx_q])
    if np.any(linear):
        kind, axis = "prismatic", linear
    else:
        kind, axis = "continuous" if joint.nq == 2 else "revolute", angular
    inertia = model.inertias[i]
    mass = float(inertia.mass)
    return (
        name,
        kind,
        int(model.parents[i]) - 1,
        _placement(model.jointPlacements[i]),
        axis.tolist(),
        (mass, np.asarray(inertia.lever).tolist(), np.asarray(inertia.inertia).ravel().tolist()),
        [
            lower,
            upper,
            _limit(model, "upperVelocityLimit", "velocityLimit", joint.idx_v),
            _limit(model, "upperEffortLimit", "effortLimit", joint.idx_v),
        ],
    )


def _compare(pinocchio: Any, model: Any, ours: Model) -> None:
    """Refuses a conversion with other torques than the model."""
    data = model.createData()
    q, v, a = np.random.default_rng(0).normal(size=(3, 3, ours.dof))
    torques = rnea(ours, q, v, a)
    for q, v, a, tau in zip(q, v, a, torques, strict=True):
        expected = pinocchio.rnea(model, data, pinocchio_configuration(model, q), v, a)
        error = np.abs(tau - expected).max() / max(np.abs(expected).max(), 1.0)
        if not error <= _AGREEMENT:
            raise _refused(model, "inverse dynamics", f"its torques differ by {error:.1e}, relative")
