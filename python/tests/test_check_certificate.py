"""The checker of certificates: what `aghf certify` writes is accepted, and what is wrong is refused."""

import copy
import json
import os
import random
import subprocess
from pathlib import Path

import pytest

from aghf.check_certificate import Refused, check, main, xxh64

ROBOT = Path(__file__).resolve().parents[2] / "robots/kinova_gen3/kinova_gen3.urdf"

pytestmark = pytest.mark.skipif(
    "AGHF_PROGRAM" not in os.environ, reason="AGHF_PROGRAM names no program to certify with"
)


# A goal and a waypoint by pose, conditions along the way, and links with cylinders.
TOOL = "end_effector_link"
CONDITIONS = {
    "robot": "kinova_gen3",
    "horizon_s": 4.0,
    "q_start": [0.0, 0.5, 0.0, 1.6, 0.0, 1.0, 0.0],
    "v_start": [0.0] * 7,
    "goal": {
        "frame": TOOL,
        "position_m": [0.4, 0.3, 0.3],
        "tolerance_m": 0.01,
        "axis": {"of_frame": [0, 0, 1], "direction": [0, 0, -1]},
        "tolerance_rad": 0.2,
    },
    "keep": [
        {"speed": {"frame": TOOL, "most_m_s": 0.8}},
        {"poses": {"frame": TOOL, "box": {"size_m": [None, None, 2], "pose": {"position_m": [0, 0, 1.1]}}}},
    ],
    "waypoints": [{"poses": {"frame": TOOL, "position_m": [0.45, 0.1, 0.5]}}],
    "obstacles": [
        {"shape": {"box": {"size_m": [0.3, 0.05, 0.2]}}, "pose": {"position_m": [0.45, 0.5, 0.2]}},
        {"shape": {"half_space": {}}, "pose": {"position_m": [0, 0, -0.05]}},
    ],
}


@pytest.fixture(scope="module", params=["kinova_obstacles_02", "conditions.json"])
def files(tmp_path_factory, request):
    """The robot, the scenario, the run and its certificate."""
    folder, name = tmp_path_factory.mktemp("certificate"), request.param
    (folder / "conditions.json").write_text(json.dumps(CONDITIONS))
    program = os.environ["AGHF_PROGRAM"]

    def run(*arguments):
        return subprocess.run([program, *arguments], cwd=folder, check=True, capture_output=True, text=True).stdout

    run("solve", name, "--out", "out", "--no-report")
    run("certify", name, "out")
    (folder / "scenario.json").write_text(run("scenarios", name))
    return [ROBOT, *(folder / name for name in ("scenario.json", "out/summary.json", "certificate.json"))]


def test_a_certificate_is_accepted(files, capsys):
    assert main([str(file) for file in files]) == 0
    assert capsys.readouterr().out.startswith("certified at all times")
    assert main([str(file) for file in files[:3]]) == 1


def test_a_tube_is_checked(tmp_path):
    program, name = os.environ["AGHF_PROGRAM"], "limits_02"

    def run(*arguments):
        return subprocess.run([program, *arguments], cwd=tmp_path, check=True, capture_output=True, text=True).stdout

    run("solve", name, "--out", "out", "--no-report")
    run("certify", name, "out", "--tracking-error", "0.001")
    texts = [ROBOT.read_text(), run("scenarios", name), (tmp_path / "out/summary.json").read_text()]
    certificate = json.loads((tmp_path / "certificate.json").read_text())
    assert "for positions within 0.001 of the motion" in check(*texts, json.dumps(certificate))
    for wrong in (None, "x", -1e-3, 1.0):
        with pytest.raises(Refused):
            check(*texts, json.dumps(certificate | {"tracking_error": wrong}))


def spoil(certificate, rng):
    """Changes one thing of a certificate to something wrong."""
    intervals = certificate["intervals"]
    i = rng.randrange(len(intervals))
    kind = rng.randrange(10)
    if kind == 0:
        certificate["coefficients"][0][rng.randrange(7)][rng.randrange(9)] += 1e-13
    elif kind == 1:
        intervals[i][3][0] += 0.002 if intervals[i][3][0] < 0.04 else 10.0
    elif kind == 2:
        del intervals[i]
    elif kind == 3:
        intervals.insert(i, intervals[i])
    elif kind == 4:
        intervals[i][1 + rng.randrange(2)] += 1e-12
    elif kind == 5:
        intervals[i][3] = rng.choice([[], [None], [True], ["1"]])
    elif kind == 6:
        certificate["deviations"]["start_position"] = rng.choice([1.0, -1.0, None])
    elif kind == 7 and certificate["waypoints"]:
        certificate["waypoints"] = rng.choice([[], [[0, 0.5, 0.0]], [[0, certificate["waypoints"][0][1], 1e-5]]])
    elif kind == 8 and certificate["goal"]:
        certificate["goal"] = rng.choice([0.1, -1e-6, None])
    elif kind == 9 and any(interval[4] for interval in intervals):
        listed = [direction for interval in intervals for direction in interval[4]]
        rng.choice(listed)[2] = rng.choice([[0.0, 0.0, 0.0], [1.0], None])
    else:
        key = rng.choice(["tolerance", "horizon_s", "joints", "promises", "robot_xxh64", "not_certified"])
        certificate[key] = rng.choice([None, 3.0, [], "x"]) if key != "not_certified" else [{"promise": "goal"}]
    return kind


def test_wrong_certificates_are_refused(files):
    texts = [file.read_text() for file in files]
    good, rng = json.loads(texts[3]), random.Random(38)
    for _ in range(60):
        wrong = copy.deepcopy(good)
        kind = spoil(wrong, rng)
        with pytest.raises(Refused):
            pytest.fail(f"kind {kind}: {check(*texts[:3], json.dumps(wrong))}")
    for end in (0, 100, len(texts[3]) // 2, len(texts[3]) - 3):
        with pytest.raises(Refused):
            check(*texts[:3], texts[3][:end])
    for wrong in (texts[3].replace("1.0", "NaN", 1), texts[3].replace("1.0", "1e999", 1)):
        with pytest.raises(Refused):
            check(*texts[:3], wrong)
    with pytest.raises(Refused, match="another robot"):
        check(texts[0].replace("<robot", "<!-- --><robot", 1), *texts[1:])


def test_hashes_are_those_of_xxhash():
    # The values of the specification for no bytes and `abc`, and of more than a block by the reference.
    assert xxh64(b"") == 0xEF46DB3751D8E999
    assert xxh64(b"abc") == 0x44BC2CF5AD770999
