"""The checker of certificates: what `aghf certify` writes is accepted, and what is wrong is refused."""

import copy
import json
import os
import random
import subprocess
from pathlib import Path

import pytest

from aghf.check_certificate import Refused, check, main

ROBOT = Path(__file__).resolve().parents[2] / "robots/kinova_gen3/kinova_gen3.urdf"

pytestmark = pytest.mark.skipif(
    "AGHF_PROGRAM" not in os.environ, reason="AGHF_PROGRAM names no program to certify with"
)


# A goal and a waypoint by pose, conditions along the way, and links with cylinders.
TOOL = "end_effector_link"
ARM = ["shoulder", "half_arm_1", "half_arm_2", "forearm", "spherical_wrist_1", "spherical_wrist_2", "bracelet"]
LINKS = [f"{name}_link" for name in ["base", *ARM]]
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
    # Shapes of links with one or two others between them overlap, or never meet.
    "self_collision": {"ignored_pairs": [[LINKS[i], link] for i in range(8) for link in LINKS[i + 1 : i + 4]]},
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
    robot, scenario, run, certificate = map(str, files)
    for of in (scenario, run):
        assert main([robot, of, run, certificate]) == 0
        assert capsys.readouterr().out.startswith("certified at all times")
    assert main([robot, scenario, run]) == 1


def test_a_tube_is_checked(tmp_path):
    program, name = os.environ["AGHF_PROGRAM"], "limits_02"

    def run(*arguments):
        return subprocess.run([program, *arguments], cwd=tmp_path, check=True, capture_output=True, text=True).stdout

    run("solve", name, "--out", "out", "--no-report")
    run("certify", name, "out", "--tracking-error", "0.001")
    summary = (tmp_path / "out/summary.json").read_text()
    texts = [ROBOT.read_text(), summary, summary]
    certificate = json.loads((tmp_path / "certificate.json").read_text())
    assert "for positions within 0.001 of the motion" in check(*texts, json.dumps(certificate)).text
    for wrong in (None, "x", -1e-3, 1.0):
        with pytest.raises(Refused):
            check(*texts, json.dumps(certificate | {"tracking_error": wrong}))


def spoil(certificate, rng):
    """Changes one thing of a certificate to something wrong."""
    intervals = certificate["intervals"]
    i = rng.randrange(len(intervals))
    kind = rng.randrange(10)
    if kind == 0:
        key = rng.choice(["run_sha256", "robot_sha256"])
        certificate[key] = certificate[key][1:] + certificate[key][:1]
    elif kind == 1:
        claim = rng.choice([1.0, 1.7976931348623157e308, 1.1, -1.1e-9])
        intervals[i][3] = [claim if claim != intervals[i][3][0] else 1.1] * len(intervals[i][3])
    elif kind == 2:
        del intervals[i]
    elif kind == 3:
        intervals.insert(i, intervals[i])
    elif kind == 4:
        intervals[i][1 + rng.randrange(2)] += 1e-12
    elif kind == 5:
        intervals[i][3] = rng.choice([[], [None], [True], ["1"]])
    elif kind == 6:
        certificate["keys"][rng.choice(list(certificate["keys"]))] = rng.choice(["", "left out", "assumed ", None])
    elif kind == 7 and certificate["waypoints"]:
        certificate["waypoints"] = rng.choice([[], [[0, 0.5, 0.0]], [[0, certificate["waypoints"][0][1], 1e-5]]])
    elif kind == 8 and certificate.get("goal"):
        certificate["goal"] = rng.choice([0.1, -1e-6, None])
    elif kind == 9 and any(interval[4] for interval in intervals):
        listed = [direction for interval in intervals for direction in interval[4]]
        rng.choice(listed)[2] = rng.choice([[0.0, 0.0, 0.0], [1.0], None])
    else:
        key = rng.choice(["format", "promises", "meshes", "complete", "intervals", "tracking_error"])
        certificate[key] = rng.choice([None, 3.0, "x", {"a.stl": "0" * 64}, ["position"], False])
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
    with pytest.raises(Refused, match="another robot"):
        check(texts[0].replace("<robot", "<!-- --><robot", 1), *texts[1:])
    with pytest.raises(Refused, match="another motion"):
        check(*texts[:2], f"{texts[2]} ", texts[3])
    with pytest.raises(Refused, match="another scenario"):
        check(texts[0], f"{texts[1]} ", *texts[2:])
