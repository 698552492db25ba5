"""Models of Pinocchio, and every URDF of two public collections: the same numbers, or refused for a reason."""

import os
import sys
from pathlib import Path

import numpy as np
import pytest

import aghf
from problems import PENDULUM

pin = pytest.importorskip("pinocchio")

#: The robots of the collections that the Rust test refuses too: no moving joint, a singular mass matrix, no link.
REFUSED = {
    "hector_description/robots/quadrotor_base.urdf": "no moving joint",
    "iris_description/robots/iris_simple.urdf": "no moving joint",
    "romeo_description/urdf/romeo.urdf": "mass matrix is singular",
    "romeo_description/urdf/romeo_laas_small.urdf": "mass matrix is singular",
    "ur_description/urdf/ur3.urdf": "no links",
}


def corpus():
    """The URDF files of the collections and of this project, by their names."""
    folders = [
        (Path(pin.__file__).parents[4] / "share" / "example-robot-data" / "robots", 69),
        (Path(sys.prefix) / "share" / "iCub" / "robots", 16),
        (Path(__file__).parents[2] / "robots", 16),
    ]
    robots = {}
    for folder, count in folders:
        found = {str(path.relative_to(folder)): path for path in sorted(folder.rglob("*.urdf"))}
        assert len(found) == count, folder
        robots |= found
    return robots


def differences(ours, theirs, q, v, a):
    """The largest relative difference of each quantity at a state."""
    data = theirs.createData()
    p = aghf.pinocchio_configuration(theirs, q)
    tau = pin.rnea(theirs, data, p, v, a)
    dq, dv, mass = (np.array(m).reshape(ours.dof, ours.dof) for m in pin.computeRNEADerivatives(theirs, data, p, v, a))
    pin.framesForwardKinematics(theirs, data, p)
    last = theirs.frames[theirs.nframes - 1]
    found = aghf.rnea_derivatives(ours, q, v, a)
    pairs = [
        (aghf.rnea(ours, q, v, a), tau),
        (found.dq, dq),
        (found.dv, dv),
        (np.triu(aghf.crba(ours, q)), np.triu(mass)),
        (aghf.aba(ours, q, v, tau), a),
        (aghf.forward_kinematics(ours, q)[-1], data.oMi[theirs.njoints - 1].homogeneous),
        (aghf.frame_placement(ours, q, last.name), data.oMf[theirs.nframes - 1].homogeneous),
    ]
    return [np.abs(ours - theirs).max() / max(np.abs(theirs).max(), 1e-6) for ours, theirs in pairs]


def test_the_corpus():
    robots = corpus()
    random = np.random.default_rng(19)
    refused, worst = {}, 0.0
    for name, path in robots.items():
        try:
            ours = aghf.Model.from_urdf(path, mimic="independent")
        except aghf.InputError as error:
            refused[name] = error.condition
            continue
        theirs = pin.buildModelFromXML(path.read_text(encoding="utf-8"))
        assert ours.joint_names == list(theirs.names)[1:], name
        q, v, a = random.uniform(-1, 1, size=(3, ours.dof))
        off = differences(ours, theirs, q, v, a)
        # Accelerations of robots with fingers of some grams lose digits by the condition of the mass matrix.
        condition = np.linalg.cond(aghf.crba(ours, q))
        assert max(off[:4] + off[5:]) < 1e-9 and off[4] < max(1e-9, 1e-14 * condition), (name, off)
        worst = max(worst, *off[:4], *off[5:])
    assert refused.keys() == REFUSED.keys()
    assert all(REFUSED[name] in refused[name] for name in refused), refused
    print(f"{len(robots) - len(refused)} robots agree to {worst:.1e}, {len(refused)} are refused")


@pytest.mark.parametrize("name", ["kinova_gen3", "digit_v3_pinned", "panda", "cart_pole"])
def test_models_of_pinocchio(name):
    theirs = pin.buildModelFromXML(aghf.Model.builtin(name).to_urdf())
    theirs.gravity.linear = np.array([0.1, 0.2, -9.0])
    ours = aghf.Model.from_pinocchio(theirs)
    assert ours.joint_names == list(theirs.names)[1:]
    assert ours.gravity.tolist() == [0.1, 0.2, -9.0]
    frames = {frame.name for frame in theirs.frames} - {"universe"}
    assert frames == set(ours.frame_names)
    q, v, a = np.random.default_rng(3).normal(size=(3, ours.dof))
    assert max(differences(ours, theirs, q, v, a)) < 1e-9
    by_urdf = aghf.Model.builtin(name)
    for limits in ["lower", "upper", "velocity_limits", "effort_limits"]:
        assert np.array_equal(getattr(ours, limits), getattr(by_urdf, limits)), limits


def test_a_model_made_in_code_keeps_its_order():
    """Joints in an order that no URDF has, about slanted axes, one that slides."""
    theirs = pin.Model()
    theirs.name = "made"
    body = pin.Inertia(2.0, np.array([0.1, 0.2, 0.3]), np.diag([0.3, 0.4, 0.5]))
    slanted = np.array([1.0, 2.0, 2.0]) / 3
    first = theirs.addJoint(0, pin.JointModelRevoluteUnaligned(slanted), pin.SE3.Random(), "z")
    second = theirs.addJoint(first, pin.JointModelPrismaticUnaligned(slanted), pin.SE3.Random(), "b")
    third = theirs.addJoint(first, pin.JointModelRUBX(), pin.SE3.Random(), "a")
    for joint in [first, second, third]:
        theirs.appendBodyToJoint(joint, body, pin.SE3.Random())
    theirs.addFrame(pin.Frame("tool", third, 0, pin.SE3.Random(), pin.FrameType.OP_FRAME))
    ours = aghf.Model.from_pinocchio(theirs)
    assert (ours.joint_names, ours.joint_kinds) == (["z", "b", "a"], ["revolute", "prismatic", "continuous"])
    q, v, a = np.random.default_rng(5).normal(size=(3, 3))
    assert max(differences(ours, theirs, q, v, a)) < 1e-9


def test_what_is_not_known_is_refused():
    theirs = pin.buildModelFromXML(aghf.Model.builtin("pendulum_2").to_urdf(), pin.JointModelFreeFlyer())
    with pytest.raises(aghf.InputError, match="root_joint.*FreeFlyer"):
        aghf.Model.from_pinocchio(theirs)
    theirs = pin.buildModelFromXML(aghf.Model.builtin("kinova_gen3").to_urdf())
    armature = np.zeros(7)
    armature[2] = 0.1
    theirs.armature = armature
    with pytest.raises(aghf.InputError, match="armature") as raised:
        aghf.Model.from_pinocchio(theirs)
    assert theirs.names[3] in raised.value.element


def test_nothing_leaks():
    """The resident memory does not grow over 1e5 calls, of which there are fewer of those that take long."""
    model = aghf.Model.builtin("kinova_gen3")
    q = np.random.default_rng(0).normal(size=(8, 7))
    bad = np.zeros((8, 6))
    text = model.to_urdf()

    def calls(count):
        for i in range(count):
            aghf.rnea(model, q, q, q)
            aghf.rnea_derivatives(model, q[0], q[0], q[0])
            try:
                aghf.rnea(model, bad, q, q)
            except ValueError:
                pass
            if i % 100 == 0:
                aghf.Model.from_urdf(text)
                aghf.omega_jacobian(model, *np.zeros((3, 8, 14)), 1.0)
            if i % 1000 == 0:
                aghf.solve(PENDULUM, starts=1, threads=1, on_iteration=lambda _: None).report_html()

    def resident():
        with open("/proc/self/statm", encoding="ascii") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")

    calls(2000)
    before = resident()
    calls(33_000)
    grown = resident() - before
    assert grown < 4e6, f"{grown / 1e6:.1f} MB more after 1e5 calls"
