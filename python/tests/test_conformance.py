"""The verdict of the checker of certificates on each file of the conformance suite; its README has the notation."""

import hashlib
import json
from pathlib import Path

import pytest

from aghf.check_certificate import Refused, check, find_mesh

FOLDER = Path(__file__).resolve().parents[2] / "app/check/conformance"
FILES = dict(robot="robot.urdf", scenario="scenario.json", summary="summary.json", certificate="certificate.json")
CASES = [
    pytest.param(case, id=f"{path.stem}[{i}]")
    for path in sorted(FOLDER.glob("cases/*.json"))
    for i, case in enumerate(json.loads(path.read_text("utf-8")))
]
LEAST_CASES = 600  # fewer are a folder that was not found as a whole


def set_value(value, pointer, *new):
    """Sets the value at a pointer, at the end of a list too, or removes it."""
    *parents, key = pointer.split("/")[1:]
    for parent in parents:
        value = value[int(parent) if isinstance(value, list) else parent]
    key = int(key) if isinstance(value, list) else key
    if not new:
        del value[key]
    elif isinstance(value, list) and key == len(value):
        value.extend(new)
    else:
        (value[key],) = new


def texts_of(case):
    """The texts of the robot, the scenario, the summary and the certificate."""
    before = {key: (FOLDER / "bases" / case["base"] / file).read_text("utf-8") for key, file in FILES.items()}
    texts = dict(before)
    for file, pairs in case.get("replace", {}).items():
        for old, new in pairs:
            assert old in texts[file]
            texts[file] = texts[file].replace(old, new, 1)
    for file, edits in case.get("set", {}).items():
        value = json.loads(texts[file])
        for edit in edits:
            set_value(value, *edit)
        texts[file] = json.dumps(value)
    for file, pieces in case.get("text", {}).items():
        texts[file] = "".join(piece * count for piece, count in pieces)
    if "scenario_of_summary" in case:
        texts["scenario"] = texts["summary"]
    if "hashes" not in case:
        for file in ("robot", "scenario", "summary"):
            old, new = (hashlib.sha256(all_texts[file].encode()).hexdigest() for all_texts in (before, texts))
            texts["certificate"] = texts["certificate"].replace(old, new)
    return [texts[file] for file in FILES]


@pytest.mark.parametrize("case", CASES)
def test_the_checker_gives_the_verdict_and_the_reason_of_each_case(case):
    robot = FOLDER / "bases" / case["base"] / "robot.urdf"
    try:
        report = check(*texts_of(case), lambda name: None if "meshes" in case else find_mesh(name, robot))
        verdict, message = "all" if report.is_complete else "in part", report.text
    except Refused as reason:
        verdict, message = "refused", str(reason)
    assert verdict == case["verdict"], message
    assert any(reason in message for reason in case.get("reason", [""])), message


def test_all_cases_are_there():
    assert len(CASES) >= LEAST_CASES
