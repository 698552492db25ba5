"""Scenarios of the benchmarks."""

import json
import subprocess
from pathlib import Path


def built_in(aghf: Path) -> list[str]:
    """The names of all built-in and generated scenarios."""
    listed = subprocess.run([aghf, "scenarios"], capture_output=True, text=True, check=True).stdout
    return [line.split()[0] for line in listed.splitlines() if line.strip() and "SEED" not in line]


def from_file(file: Path) -> dict:
    """The scenario of a file, with the paths of its robot and its SRDF from anywhere."""
    made = json.loads(file.read_text())
    paths = {key: made[key] for key in ("robot", "srdf") if made.get(key, "").endswith("df")}
    return made | {key: str((file.parent / path).resolve()) for key, path in paths.items()}
