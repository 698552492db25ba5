"""Dynamics: batches, shapes, identities, and the numbers of the program itself."""

import json
import os
import subprocess

import numpy as np
import pytest

import aghf

ROBOTS = ["pendulum_3", "kinova_gen3", "digit_v3_pinned", "panda"]


def states(model, count, seed=1):
    rng = np.random.default_rng(seed)
    return rng.normal(size=(3, count, model.dof))


@pytest.fixture(params=ROBOTS)
def model(request):
    return aghf.Model.builtin(request.param)


def test_a_batch_has_the_numbers_of_its_states(model):
    q, v, a = states(model, 130)
    w = states(model, 130, seed=2)[0]
    functions = [
        (aghf.rnea, (q, v, a)),
        (aghf.aba, (q, v, a)),
        (aghf.crba, (q,)),
        (aghf.mass_matrix_and_rate, (q, v)),
        (aghf.rnea_derivatives, (q, v, a)),
        (aghf.aba_derivatives, (q, v, a)),
        (aghf.rnea_second_derivatives, (q, v, a)),
        (aghf.rnea_vjp, (q, v, a, w)),
        (aghf.rnea_weighted_hessian, (q, v, a, w)),
        (aghf.forward_kinematics, (q,)),
    ]
    for function, arguments in functions:
        batch = function(model, *arguments)
        one = function(model, *(x[17] for x in arguments))
        batch, one = (x if isinstance(x, tuple) else (x,) for x in (batch, one))
        for all_of, single in zip(batch, one, strict=True):
            assert all_of.shape == (130, *single.shape), function.__name__
            assert np.array_equal(all_of[17], single), function.__name__


def test_identities(model):
    q, v, a = states(model, 20)
    tau = aghf.rnea(model, q, v, a)
    h = aghf.crba(model, q)
    bias = aghf.rnea(model, q, v, np.zeros_like(a))
    scale = np.abs(tau).max()
    assert np.allclose(tau, np.einsum("bij,bj->bi", h, a) + bias, atol=1e-12 * scale, rtol=0)
    assert np.allclose(aghf.aba(model, q, v, tau), a, atol=1e-8)
    found = aghf.rnea_derivatives(model, q, v, a)
    assert np.allclose(found.tau, tau, atol=1e-12 * scale, rtol=0)
    forward = aghf.aba_derivatives(model, q, v, tau)
    product = np.einsum("bij,bjk->bik", found.da, forward.dtau)
    assert np.allclose(product, np.eye(model.dof), atol=1e-7)
    w = states(model, 20, seed=3)[0]
    vjp = aghf.rnea_vjp(model, q, v, a, w)
    assert np.allclose(vjp.q, np.einsum("bi,bij->bj", w, found.dq), atol=1e-10 * scale)
    second = aghf.rnea_second_derivatives(model, q, v, a)
    hessian = aghf.rnea_weighted_hessian(model, q, v, a, w)
    for name, tensor in [("qq", second.dqdq), ("vv", second.dvdv)]:
        contracted = np.einsum("bi,bijk->bjk", w, tensor)
        assert np.allclose(getattr(hessian, name), contracted, atol=1e-10 * np.abs(contracted).max())


def test_frames(model):
    q = states(model, 5)[0]
    frame = model.frame_names[-1]
    step = 1e-6
    jacobian = aghf.frame_jacobian(model, q, frame)
    here = aghf.frame_placement(model, q, frame)
    assert np.allclose(here[:, 3], [0, 0, 0, 1])
    for j in range(model.dof):
        moved = q.copy()
        moved[:, j] += step
        there = aghf.frame_placement(model, moved, frame)
        linear = (there - here)[:, :3, 3] / step
        assert np.allclose(jacobian[:, 3:, j], linear, atol=1e-4), frame


def test_inverse_kinematics(model):
    frame = model.frame_names[-1]
    lower, upper = np.maximum(model.lower, -np.pi), np.minimum(model.upper, np.pi)
    drawn = np.random.default_rng(6).uniform(lower, upper, (70, model.dof))
    goals = aghf.frame_placement(model, drawn, frame)
    found = aghf.inverse_kinematics(model, goals, frame)
    assert found.shape == drawn.shape
    assert np.all((found >= model.lower) & (found <= model.upper))
    np.testing.assert_allclose(aghf.frame_placement(model, found, frame), goals, atol=1e-8)
    # Positions near those that are wanted are kept, and so is one state without a batch.
    near = np.clip(drawn[3] + 1e-3, model.lower, model.upper)
    one = aghf.inverse_kinematics(model, goals[3], frame, near=near)
    assert one.shape == (model.dof,) and np.abs(one - near).max() < 0.1
    far = goals[:2].copy()
    far[1, :3, 3] += 100.0
    found = aghf.inverse_kinematics(model, far, frame, guesses=30)
    assert np.isfinite(found[0]).all() and np.isnan(found[1]).all()


def test_bad_placements(model):
    frame, goal = model.frame_names[-1], np.eye(4)
    with pytest.raises(ValueError, match=r"placement.*\[3, 4\]"):
        aghf.inverse_kinematics(model, goal[:3], frame)
    with pytest.raises(ValueError, match="near"):
        aghf.inverse_kinematics(model, goal, frame, near=np.zeros(model.dof + 1))
    with pytest.raises(KeyError, match="no frame 'nothing'"):
        aghf.inverse_kinematics(model, goal, "nothing")
    with pytest.raises(ValueError, match=r"near.*\[2, "):
        aghf.inverse_kinematics(model, goal, frame, near=np.zeros((2, model.dof)))
    with pytest.raises(ValueError, match=r"near.*\[\]"):
        aghf.inverse_kinematics(model, goal, frame, near=0.0)
    with pytest.raises(ValueError, match="last row"):
        aghf.inverse_kinematics(model, goal + np.eye(4)[3], frame)
    with pytest.raises(aghf.InputError, match="near.*number 0 is not finite"):
        aghf.inverse_kinematics(model, goal, frame, near=np.full(model.dof, np.nan))
    far = goal.copy()
    far[0, 3] = np.inf
    with pytest.raises(aghf.InputError, match="placement.*number 1 is not finite"):
        aghf.inverse_kinematics(model, [goal, far], frame)
    nothing = np.vstack([np.full((3, 4), np.nan), goal[3:]])
    for wrong in [np.diag([2.0, 2.0, 2.0, 1.0]), np.diag([1.0, 1.0, -1.0, 1.0]), nothing]:
        with pytest.raises(aghf.InputError, match="rotation of number 1"):
            aghf.inverse_kinematics(model, [goal, wrong], frame)


@pytest.mark.parametrize("name", aghf.jacobians())
def test_jacobians_of_omega_agree(name):
    model = aghf.Model.builtin("kinova_gen3")
    x, xdot, xddot = np.random.default_rng(4).normal(size=(3, 70, 2 * model.dof))
    k = 1e3
    usual = aghf.omega_jacobian(model, x, xdot, xddot, k)
    other = aghf.omega_jacobian(model, x, xdot, xddot, k, name)
    # Differences of Omega, which is large, lose digits of all blocks alike.
    largest = max(np.abs(block).max() for block in usual)
    for a, b in zip(usual, other, strict=True):
        tolerance = 1e-7 * largest if name == "difference" else 1e-11 * np.abs(a).max()
        assert np.abs(a - b).max() <= tolerance
    assert aghf.omega(model, x, xdot, xddot, k).shape == (70, 2 * model.dof)


@pytest.mark.skipif("AGHF_PROGRAM" not in os.environ, reason="AGHF_PROGRAM names no program to compare with")
def test_the_numbers_are_those_of_the_program(tmp_path):
    model = aghf.Model.builtin("kinova_gen3")
    rng = np.random.default_rng(5)
    x, xdot, xddot = rng.normal(size=(3, 2 * model.dof))
    n, k = model.dof, 1e4
    given = {"x": x.tolist(), "xdot": xdot.tolist(), "xddot": xddot.tolist(), "k": k}
    path = tmp_path / "input.json"
    path.write_text(json.dumps(given))
    command = [os.environ["AGHF_PROGRAM"], "eval", "kinova_gen3", str(path)]
    told = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
    q, v, a = x[:n], x[n:], xdot[n:]
    found = aghf.rnea_derivatives(model, q, v, a)
    h, hdot = aghf.mass_matrix_and_rate(model, q, xdot[:n])
    for key, own in [
        ("inverse_dynamics", found.tau),
        ("did_dq", found.dq),
        ("did_dv", found.dv),
        ("mass_matrix", h),
        ("mass_matrix_dot", hdot),
        ("forward_dynamics", aghf.aba(model, q, v, np.zeros(n))),
        ("omega", aghf.omega(model, x, xdot, xddot, k)),
    ]:
        assert np.array_equal(np.array(told[key]), own), key


def test_bad_arguments_are_errors():
    model = aghf.Model.builtin("pendulum_2")
    good, batch = np.zeros(2), np.zeros((3, 2))
    for arguments, words in [
        ((np.zeros(3), good, good), r"q: its shape is \[3\], expected \[2\]"),
        ((good, batch, good), "v: it has 3 states, the arguments before it one state"),
        ((good, good, np.zeros((2, 2, 2))), "a: its shape is"),
        ((good, good, "text"), "a: "),
        ((good, good, None), "a: "),
    ]:
        with pytest.raises(ValueError, match=words):
            aghf.rnea(model, *arguments)
    with pytest.raises(KeyError, match="no frame 'elbow'"):
        aghf.frame_jacobian(model, good, "elbow")
    assert aghf.rnea(model, [0.0, 0.0], (0, 0), good[::-1]).shape == (2,)
    assert aghf.rnea(model, np.zeros((0, 2)), np.zeros((0, 2)), np.zeros((0, 2))).shape == (0, 2)
