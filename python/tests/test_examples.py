"""The examples, each as a program."""

import re
import subprocess
import sys
from pathlib import Path

import nbclient
import nbformat
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


@pytest.mark.parametrize(
    ("name", "arguments", "words"),
    [
        ("pinocchio_viser.py", ["kinova_free_01", "--once"], "61 frames shown"),
        ("ray_solve.py", ["4"], "4 of 4 solved"),
        ("tracker_mujoco.py", ["--seconds", "1", "--page", "loops.html"], "wrote loops.html"),
    ],
)
def test_an_example_runs_to_its_end(name, arguments, words, tmp_path):
    command = [sys.executable, EXAMPLES / name, *arguments]
    run = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, timeout=300)
    assert run.returncode == 0 and words in run.stdout, run.stdout + run.stderr


def test_the_notebook_runs(tmp_path):
    notebook = nbformat.read(EXAMPLES / "quick_start.ipynb", as_version=4)
    client = nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(tmp_path)}})
    client.execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    pages = [output for output in outputs if "text/html" in output.get("data", {})]
    assert any("srcdoc" in page["data"]["text/html"] for page in pages), "the motion is shown"


def test_the_code_of_the_readme(tmp_path):
    """All blocks one after the other, as a reader would run them, with those of the project's README."""
    readmes = [(folder / "README.md").read_text(encoding="utf-8") for folder in EXAMPLES.resolve().parents[:2]]
    code = "\n".join(re.findall(r"```python\n(.*?)```", "\n".join(readmes), re.DOTALL))
    assert "import aghf" in code and "check_constraint" in code
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path, timeout=300)
    assert run.returncode == 0, run.stdout + run.stderr
    assert (tmp_path / "out" / "python" / "report.html").exists()
