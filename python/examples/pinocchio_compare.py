"""The same robot in Pinocchio: joint by joint, and the same numbers.

    pip install pin
    python python/examples/pinocchio_compare.py [ROBOT.urdf]
"""

import sys
import tempfile
from pathlib import Path

import numpy as np
import pinocchio as pin

import aghf


def largest_difference(model: aghf.Model, other: pin.Model, states: int = 100) -> float:
    """The largest relative difference of inverse dynamics, mass matrix and first derivatives at random states."""
    data = other.createData()
    q, v, a = np.random.default_rng(0).normal(size=(3, states, model.dof))
    ours = aghf.rnea_derivatives(model, q, v, a)
    worst = 0.0
    for i in range(states):
        dq, dv, da = pin.computeRNEADerivatives(other, data, configuration(other, q[i]), v[i], a[i])
        da = np.triu(da) + np.triu(da, 1).T
        for own, theirs in [(ours.tau[i], data.tau), (ours.dq[i], dq), (ours.dv[i], dv), (ours.da[i], da)]:
            worst = max(worst, np.abs(own - theirs).max() / max(1.0, np.abs(theirs).max()))
    return worst


def configuration(other: pin.Model, q: np.ndarray) -> np.ndarray:
    """The configuration in Pinocchio, which has cosine and sine of a continuous joint."""
    parts = []
    for joint in other.joints[1:]:
        angle = q[joint.idx_v]
        parts += [np.cos(angle), np.sin(angle)] if joint.nq == 2 else [angle]
    return np.array(parts)


def main() -> float:
    if len(sys.argv) > 1:
        path = Path(sys.argv[1])
        model = aghf.Model.from_urdf(path)
    else:
        model = aghf.Model.builtin("kinova_gen3")
        path = Path(tempfile.mkdtemp()) / "robot.urdf"
        path.write_text(model.to_urdf())
    other = pin.buildModelFromUrdf(str(path))
    # The order of joints is that of Pinocchio, which counts the world as the first.
    assert model.joint_names == list(other.names)[1:], (model.joint_names, list(other.names))
    difference = largest_difference(model, other)
    print(f"{model.name}: {model.dof} joints, largest relative difference {difference:.1e}")
    return difference


if __name__ == "__main__":
    sys.exit(int(main() > 1e-9))
