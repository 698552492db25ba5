"""Batches beside single calls in Rust and in Pinocchio: microseconds per state, on one core and on all.

    python python/benches/batch.py [ROBOT] [STATES]

Runs the Rust benchmarks first (`cargo bench`, minutes where they are to be built), on the same machine and for a robot
with as many joints.
"""

import os
import re
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[2]
REPEATS = 15
#: Names in the Rust benchmarks, which time one state after the other.
RUST = {
    "rnea": ("dynamics", "rnea"),
    "crba": ("dynamics", "crba"),
    "aba": ("dynamics", "aba"),
    "rnea_derivatives": ("dynamics", "rnea_derivatives"),
    "aba_derivatives": ("dynamics", "aba_derivatives"),
    "rnea_second_derivatives": ("dynamics", "rnea_second_derivatives"),
    "omega": ("flow", "omega control_form"),
    "omega_jacobian": ("flow", "jacobian control_form"),
}


def measured(robot: str, count: int) -> None:
    """Prints the microseconds per state of each function in this process, whose threads the environment says."""
    import aghf

    model = aghf.Model.builtin(robot)
    random = np.random.default_rng(0)
    q, v, a = random.normal(size=(3, count, model.dof))
    nodes = random.normal(size=(3, count, 2 * model.dof))
    for name in RUST:
        arguments = (q,) if name == "crba" else (*nodes, 1e7) if name.startswith("omega") else (q, v, a)
        function = getattr(aghf, name)
        print(name, 1e6 * median(lambda: function(model, *arguments)) / count, flush=True)


def by_pinocchio(robot: str) -> dict[str, float]:
    """Microseconds per call of Pinocchio's functions from Python, state by state."""
    import pinocchio as pin

    import aghf

    model = pin.buildModelFromXML(aghf.Model.builtin(robot).to_urdf())
    data = model.createData()
    count = 500
    q, v, a = np.random.default_rng(0).normal(size=(3, count, model.nv))
    p = aghf.pinocchio_configuration(model, q)
    functions = {
        "rnea": lambda i: pin.rnea(model, data, p[i], v[i], a[i]),
        "crba": lambda i: pin.crba(model, data, p[i]),
        "aba": lambda i: pin.aba(model, data, p[i], v[i], a[i]),
        "rnea_derivatives": lambda i: pin.computeRNEADerivatives(model, data, p[i], v[i], a[i]),
        "aba_derivatives": lambda i: pin.computeABADerivatives(model, data, p[i], v[i], a[i]),
    }
    times = {}
    for name, function in functions.items():
        times[name] = 1e6 * median(lambda: [function(i) for i in range(count)]) / count
    return times


def median(call) -> float:
    call()
    seconds = []
    for _ in range(REPEATS):
        began = time.perf_counter()
        call()
        seconds.append(time.perf_counter() - began)
    return float(np.median(seconds))


def in_process(robot: str, count: int, threads: int) -> dict[str, float]:
    command = [sys.executable, __file__, robot, str(count), "--measure"]
    environment = {**os.environ, "RAYON_NUM_THREADS": str(threads)}
    run = subprocess.run(command, env=environment, stdout=subprocess.PIPE, text=True, check=True)
    return {name: float(value) for name, value in (line.split() for line in run.stdout.splitlines())}


def by_rust(dof: int) -> dict[str, float]:
    """The medians that the Rust benchmarks print for a robot with so many joints."""
    times = {}
    for bench in ("dynamics", "flow"):
        command = ["cargo", "bench", "--locked", "--quiet", "--bench", bench, "--", f"/{dof}$"]
        run = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True)
        table = run.stdout.rpartition("medians in microseconds")[2]
        for name, (own, row) in RUST.items():
            found = re.search(rf"^{row} .*?\b{dof}: ([\d.]+)", table, re.MULTILINE)
            if own == bench and found:
                times[name] = float(found[1])
    return times


def main(robot: str, count: int) -> None:
    import aghf

    rust = by_rust(aghf.Model.builtin(robot).dof)
    one, all_cores = in_process(robot, count, 1), in_process(robot, count, os.cpu_count())
    pinocchio = by_pinocchio(robot)
    print(f"{robot}, {count} states, microseconds per state; {os.cpu_count()} cores, numpy {np.__version__}")
    columns = ["function", "Rust, single", "Python, one core", "all cores", "one core / Rust", "faster on all cores"]
    print(f"| {' | '.join(columns)} | Pinocchio from Python |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for name in RUST:
        there = f"{pinocchio[name]:.2f}" if name in pinocchio else "-"
        cells = [f"{rust[name]:.2f}", f"{one[name]:.2f}", f"{all_cores[name]:.2f}", f"{one[name] / rust[name]:.2f}"]
        print("|", " | ".join([name, *cells, f"{one[name] / all_cores[name]:.2f}", there]), "|")


if __name__ == "__main__":
    arguments = [argument for argument in sys.argv[1:] if argument != "--measure"]
    robot = arguments[0] if arguments else "kinova_gen3"
    count = int(arguments[1]) if len(arguments) > 1 else 10_000
    measured(robot, count) if "--measure" in sys.argv else main(robot, count)
