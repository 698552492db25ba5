"""Bad input: the cases of the Rust tests again, each an exception with the same words, and no states."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

import aghf
from problems import PENDULUM

TESTS = Path(__file__).parents[2] / "tests" / "urdf"


def bad_robots():
    """The good robot of the Rust test, and its changes: what, replacement, element, words of the condition."""
    source = (TESTS / "refused.rs").read_text(encoding="utf-8")
    arm = re.search(r'const ARM: &str = r#"(.*?)"#;', source, re.DOTALL)[1]
    cases = json.loads((TESTS / "refused.json").read_text(encoding="utf-8"))["arm"]
    return arm.replace('"', "'"), [(*case, "")[:4] for case in cases]


def test_bad_robots(tmp_path):
    arm, cases = bad_robots()
    assert aghf.Model.from_urdf(arm).dof == 2 and len(cases) > 50
    for number, (what, replacement, element, words) in enumerate(cases):
        assert arm.count(what) == 1, what
        path = tmp_path / f"arm_{number}.urdf"
        path.write_text(arm.replace(what, replacement), encoding="utf-8")
        with pytest.raises(aghf.InputError) as raised:
            aghf.Model.from_urdf(path)
        error = raised.value
        assert (error.file, error.element) == (str(path), element), error
        assert words in error.condition, error
    for text in ["<", "<robot>", "<sdf/>", '<robot name="arm"/>', arm[:900], arm.replace("robot", "sdf")]:
        with pytest.raises(aghf.InputError):
            aghf.Model.from_urdf(text)
    path.write_bytes(b"\xff\xfe<robot/>")
    with pytest.raises((aghf.InputError, OSError)):
        aghf.Model.from_urdf(path)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"q_goal": [1.0, 2.0]}, "q_goal"),
        ({"horizon_s": -1.0}, "horizon_s"),
        ({"horizon_s": float("nan")}, "scenario|JSON|number"),
        ({"robot": "nothing"}, "nothing"),
        ({"robot": 3}, "robot"),
        ({"surprise": 1}, "surprise"),
        ({"q_start": "zero"}, "q_start"),
        ({"spheres": [{"centre": [0, 0], "radius": 1}]}, "spheres"),
        ({"enforced_limits": {"torque": 2.0}}, "torque"),
        ({"objective": {"effort": -1.0}}, "objective"),
    ],
)
def test_bad_scenarios(change, words):
    with pytest.raises((ValueError, TypeError), match=words):
        aghf.solve({**PENDULUM, **change})


def test_what_is_no_scenario():
    for scenario in ["kinova_free_99", "nowhere/at/all.json"]:
        with pytest.raises((aghf.InputError, OSError), match=re.escape(scenario)):
            aghf.solve(scenario)
    for scenario in [3, None, 1.5, object()]:
        with pytest.raises(TypeError):
            aghf.solve(scenario)
    with pytest.raises(aghf.InputError, match="q_start"):
        aghf.solve({key: value for key, value in PENDULUM.items() if key != "q_start"})


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"method": "flow", "degree": 1}, "at least 2"),
        ({"method": "flow", "k": 0.0}, "positive"),
        ({"method": "flow", "s_max": float("inf")}, "options"),
        ({"method": "flow", "tolerance": -1.0}, "positive"),
        ({"method": "flow", "jacobian": "magic"}, "magic"),
        ({"method": "flow", "integrator": "magic"}, "magic"),
        ({"method": "flow", "segments": 2}, "unknown field `segments`"),
        ({"method": "magic"}, "magic"),
        ({"degree": 3}, "at least 6"),
        ({"degree": 2**63}, "degree"),
        ({"degree": -1}, "options"),
        ({"starts": 0}, "at least 1"),
        ({"segments": 17}, "at most 16"),
        ({"degree_tolerance": 0}, "positive"),
        ({"k": 1e5}, "unknown field `k`"),
        ({"seed": -1}, "options"),
        ({"time_limit_s": float("nan")}, "options"),
    ],
)
def test_bad_options(options, words):
    with pytest.raises(ValueError, match=words):
        aghf.solve(PENDULUM, **options)


def test_bad_states():
    model = aghf.Model.builtin("kinova_gen3")
    good = np.zeros((4, 7))
    arrays = [np.zeros(size) for size in [6, (4, 8), (2, 2, 7), 0]]
    for bad in [*arrays, 1.0, "seven", None, [[0.0] * 7, [0.0]]]:
        for arguments in [(bad, good, good), (good, bad, good)]:
            with pytest.raises(ValueError):
                aghf.rnea(model, *arguments)
    with pytest.raises(ValueError, match="v: it has one state"):
        aghf.rnea(model, good, good[0], good)
    assert aghf.rnea(model, good[:0], good[:0], good[:0]).shape == (0, 7)
    for layout in [np.asfortranarray(good), good[::-1], good.astype(np.float32), good.astype(int), good.tolist()]:
        assert np.array_equal(aghf.rnea(model, layout, layout, layout), aghf.rnea(model, good, good, good))
    with pytest.raises(KeyError, match="hand"):
        aghf.frame_jacobian(model, good, "hand")
    with pytest.raises(aghf.InputError, match="magic"):
        aghf.omega_jacobian(model, *np.zeros((3, 14)), 1.0, "magic")
    for numbers in [np.full(7, np.nan), np.full(7, 1e300), np.full(7, np.inf)]:
        assert aghf.rnea(model, numbers, numbers, numbers).shape == (7,)
        assert aghf.aba_derivatives(model, *np.stack([numbers] * 3)[:, None]).a.shape == (1, 7)
