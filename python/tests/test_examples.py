"""The examples, each as a program."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"


@pytest.mark.parametrize(
    ("name", "arguments", "largest"),
    [
        ("pinocchio_compare.py", [], 1e-12),
        ("mujoco_replay.py", ["kinova_table_01"], 1e-2),
        ("jax_inverse_dynamics.py", [], 1e-12),
    ],
)
def test_an_example_tells_of_a_small_difference(name, arguments, largest, tmp_path):
    command = [sys.executable, EXAMPLES / name, *arguments]
    run = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, timeout=300)
    assert run.returncode == 0, run.stdout + run.stderr
    first = re.search(r"(?:difference|ends) (\d\.\de[+-]\d\d)", run.stdout)
    assert first and 0.0 < float(first[1]) < largest, run.stdout
