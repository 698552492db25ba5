#!/usr/bin/env python3
"""Runs the experiments of the paper's supplement, and writes and prints a report in Markdown.

    pip install ./python --requirement benches/requirements.txt
    cargo build --release
    python3 benches/paper.py --quick       # the known sets of parameters: two minutes
    python3 benches/paper.py               # searches the grids of Tables IX to XIII first: 10 to 170 core hours
    python3 benches/paper.py --variants    # the variants of the flow and the direct method instead: 20 minutes

The searches are those of `aghf sweep`, are resumed after an interruption, and can be distributed over machines by its
`--shard`. Then every scenario is solved with the best sets, one after the other on one core, and
`cargo bench --bench flow` times the right-hand side of the flow and its Jacobian on robots of 2 to 22 joints, as in
Figures 4 and 5. The folder gets report.md, results.json with the summaries of all solves, and the figures as SVG.
benches/RESULTS.md explains the tables.
"""

import argparse
import csv
import importlib.metadata
import itertools
import json
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path
from typing import NamedTuple

import matplotlib.style
import numpy as np
from matplotlib.figure import Figure
from numpy.polynomial import Polynomial

import aghf
from results import AGHF, ROOT, processor, table


def numbered(family: str, count: int) -> list[str]:
    return [f"{family}_{i:02}" for i in range(1, count + 1)]


TABLES = "table_09_pendulums table_10_kinova table_11_digit table_12_kinova_obstacles table_13_digit_obstacles".split()
PENDULUMS = [f"pendulum_{n}_swingup" for n in range(1, 6)]
FREE = {"Kinova": numbered("kinova_free", 5), "Digit": ["digit_free_stretch", "digit_free_step"]}
OBSTACLES = {"Kinova, obstacles": numbered("kinova_obstacles", 5)}
# The straight line collides.
HARDER = {
    "Kinova, cross": numbered("kinova_cross", 10),
    "Kinova, gap": numbered("kinova_gap", 10),
    "Kinova, floor": numbered("kinova_floor", 10),
    "Digit, box": numbered("digit_box", 10),
}
SYSTEMS = {
    "pendulum, 1 link": PENDULUMS[:1],
    **{f"pendulum, {n} links": [PENDULUMS[n - 1]] for n in range(2, 6)},
    **FREE,
    **OBSTACLES,
    "Digit, obstacles": ["digit_obstacles_2", "digit_obstacles_4"],
    **HARDER,
}
# The best sets that the supplement prints, section C-C, as options of `aghf.solve`.
PAPER = {
    "Kinova": {"degree": 9, "k": 1e9, "s_max": 0.1},
    "Digit": {"degree": 6, "k": 1e7, "s_max": 1.0},
    "Kinova, obstacles": {"degree": 8, "k": 1e9, "s_max": 0.1, "k_cons": 1e9, "c_cons": 1.0},
    "Digit, obstacles": {"degree": 6, "k": 1e7, "s_max": 1.0, "k_cons": 1e5, "c_cons": 200.0},
}

METHODS = ["flow", "rest", "duals", "two_phases", "direct"]
SWING_UPS = ["acrobot_swingup", "pendubot_swingup", "cart_pole_swingup"]
PASSIVE = {"underactuated": [*SWING_UPS, "rotorcraft_shift_01", "rotorcraft_flip_01"]}
FAMILIES = {"pendulums": PENDULUMS, **FREE, **OBSTACLES, **HARDER, **PASSIVE}
# The scenario whose action during the flows is drawn.
DRAWN = "kinova_free_01"

# The numbers of joints of Figures 4 and 5: pendulums, Kinova and Digit.
JOINTS = [2, 3, 4, 5, 6, 7, 22]
STATISTICS = ["mean", "std_dev", "median"]


class Quantity(NamedTuple):
    """A curve of Figures 4 and 5; `degree` is that of the polynomial in N, the paper's bound for the worst case."""

    title: str
    bench: str
    figure: int
    degree: int
    paper: str


QUANTITIES = [
    Quantity("Omega, control form", "omega control_form", 4, 3, ""),
    Quantity("Omega, Algorithm B1", "omega algorithm-b1", 4, 3, "about N^2"),
    Quantity("Jacobian, control form", "jacobian control_form", 5, 4, ""),
    Quantity("Jacobian, Theorem B4", "jacobian theorem_b4", 5, 4, "about N^3"),
]


def figures(x: float, count: int) -> str:
    """`x` with this number of significant digits, in the shorter of the usual notations."""
    mantissa, exponent = f"{x:.{count - 1}e}".split("e")
    e = int(exponent)
    return f"{x:.{max(count - 1 - e, 0)}f}" if -3 <= e <= 6 else f"{mantissa}e{e}"


def scientific(x: float) -> str:
    """`x` such as 1e5, without trailing zeros."""
    mantissa, exponent = f"{x:.12e}".split("e")
    return f"{float(mantissa):g}e{int(exponent)}"


def in_words(degree: int, k: float, s_max: float, k_cons: float | None = None, c_cons: float | None = None) -> str:
    """A set of parameters."""
    constraints = "" if k_cons is None else f" ({scientific(k_cons)}, {c_cons:g})"
    return f"{degree}, {scientific(k)}, {s_max:g}{constraints}"


def sweep(grid: str) -> list[dict]:
    """The rows of a sweep, which `aghf sweep` solves on all cores or completes."""
    folder = Path("out/sweeps") / Path(grid).stem
    subprocess.run([AGHF, "sweep", grid, "--out", folder], stdout=sys.stderr, check=True)
    with (folder / "results.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def best_sets(rows: list[dict]) -> tuple[list[dict], list]:
    """The fastest of the sets that succeed in most scenarios and the one of least effort among them, as options of
    `aghf.solve`, neither if no set succeeds; and their cells of the table."""
    names = [name for name in ("degree", "k", "s_max", "k_cons", "c_cons") if name in rows[0]]
    by_set: dict[tuple, list[dict]] = {}
    for row in rows:
        by_set.setdefault(tuple(row[name] for name in names), []).append(row)
    good = {key: [row for row in solves if row["outcome"] == "success"] for key, solves in by_set.items()}
    rates = {key: len(good[key]) / len(solves) for key, solves in by_set.items()}
    seconds = sum(float(row["solve_seconds"]) for row in rows)
    most, cells = max(rates.values()), [len(by_set), sum(rate == 1 for rate in rates.values()), figures(seconds, 3)]
    if most == 0:
        return [], [*cells, "none succeeds", ""]
    sets = []
    for column in ("solve_seconds", "control_effort"):
        candidates = [key for key, rate in rates.items() if rate == most]
        numbers = min(candidates, key=lambda key: statistics.mean(float(row[column]) for row in good[key]))
        options = dict(zip(names, map(json.loads, numbers)))
        cells.append(f"{in_words(**options)}, {100 * most:.0f} %")
        sets.append(options)
    return sets, cells


def search(systems: dict[str, list[str]], grids: list[str]) -> tuple[dict[str, list[dict]], str]:
    """The best sets by system, and their table."""
    found, lines = {}, []
    for grid in grids:
        rows = sweep(grid)
        for title, scenarios in systems.items():
            own = [row for row in rows if row["scenario"] in scenarios]
            if {row["scenario"] for row in own} == set(scenarios):
                found[title], cells = best_sets(own)
                lines.append([title, Path(grid).stem, *map(str, cells)])
    head = (
        "system | grid | sets | succeed in all scenarios | solve time in all, s"
        " | fastest set p, k, s_max (k_cons, c_cons) | set of least effort"
    )
    return found, table(head, lines)


def solve(name: str, options: dict, repetitions: int) -> dict:
    """The summary of the published flow; after a success `solve_seconds` is the median of further runs."""
    print(name, file=sys.stderr)
    summary = aghf.solve(name, method="flow", **options).summary
    if summary["success"]:
        again = [aghf.solve(name, method="flow", **options).summary for _ in range(repetitions)]
        summary["solve_seconds"] = statistics.median(s["solve_seconds"] for s in again)
    return summary


def set_of(summary: dict) -> str:
    return in_words(*(summary[name] for name in ("degree", "k", "s_max", "k_cons", "c_cons")))


class Row(NamedTuple):
    """The summaries of a system; it has several origins if their sets of parameters are the same."""

    system: str
    origins: list[str]
    summaries: list[dict]


def solve_systems(systems: dict[str, list[str]], found: dict[str, list[dict]], repetitions: int) -> list[Row]:
    """Solves every scenario with the paper's best set, and with those of the search or, without one, our own."""
    rows: dict[tuple, Row] = {}
    for title, scenarios in systems.items():
        sets = [("paper", PAPER[title])] if title in PAPER else []
        sets += zip(("grid, fastest", "grid, least effort"), found[title]) if title in found else [("own", {})]
        for origin, options in sets:
            summaries = [solve(name, options, repetitions) for name in scenarios]
            row = Row(title, [], summaries)
            rows.setdefault((title, *map(set_of, summaries)), row).origins.append(origin)
    return list(rows.values())


def worst(errors: list[float | None]) -> str:
    return "stopped" if None in errors else figures(max(errors), 2)


def solves_table(rows: list[Row]) -> str:
    head = (
        "system | set of | p, k, s_max (k_cons, c_cons) | success | solve, ms | effort | action | open loop"
        " | with feedback | clearance, m | limits broken q, v, u"
    )
    lines = []
    for title, origins, summaries in rows:
        good = [s for s in summaries if s["success"]]
        clearances = [s["smallest_clearance_m"] for s in summaries if s["smallest_clearance_m"] is not None]
        broken = [{violation["limit"] for violation in s["limit_violations"]} for s in summaries]
        means = [[s[name] for s in good] for name in ("control_effort", "action")]
        lines.append([
            title,
            "; ".join(origins),
            "; ".join(dict.fromkeys(map(set_of, summaries))),
            f"{len(good)}/{len(summaries)}",
            figures(1e3 * statistics.mean(s["solve_seconds"] for s in summaries), 2),
            *(figures(statistics.mean(values), 4) if values else "" for values in means),
            worst([s["open_loop_error_inf"] for s in summaries]),
            worst([s["final_error_inf"] for s in summaries]),
            f"{min(clearances):.3f}" if clearances else "",
            ", ".join(str(sum(limit in kinds for kinds in broken)) for limit in ("position", "velocity", "torque")),
        ])
    return table(head, lines)


def node_times(folder: Path) -> dict[str, list[dict]]:
    """Criterion's estimates of a call at one node in microseconds: by quantity, one for each of `JOINTS`."""
    names, joints = "|".join(quantity.bench for quantity in QUANTITIES), "|".join(map(str, JOINTS))
    command = ["cargo", "bench", "--bench", "flow", "--", f"^({names})/({joints})$"]
    print(" ".join(command), file=sys.stderr)
    environment = {**os.environ, "CRITERION_HOME": str(folder.resolve())}
    subprocess.run(command, cwd=ROOT, env=environment, stdout=subprocess.DEVNULL, check=True)
    times = {}
    for quantity in QUANTITIES:
        files = [folder / f"{quantity.bench}_{n}" / "new" / "estimates.json" for n in JOINTS]
        estimates = [json.loads(file.read_text(encoding="utf-8")) for file in files]
        times[quantity.title] = [{of: 1e-3 * t[of]["point_estimate"] for of in STATISTICS} for t in estimates]
    return times


def fit(quantity: Quantity, times: list[dict]) -> tuple[Polynomial, float, float]:
    """The polynomial of least squares through the means, and the factor and the exponent of the power law."""
    means = [one["mean"] for one in times]
    power = Polynomial.fit(np.log(JOINTS), np.log(means), 1).convert().coef
    return Polynomial.fit(JOINTS, means, quantity.degree).convert(), np.exp(power[0]), power[1]


def polynomial_in_words(coefficients: np.ndarray) -> str:
    powers = ["", " N", *(f" N^{i}" for i in range(2, len(coefficients)))]
    terms = [f"{'-' if c < 0 else '+'} {figures(abs(c), 3)}{power}" for c, power in zip(coefficients, powers)]
    return terms[0].replace("- ", "-").removeprefix("+ ") + "".join(f" {term}" for term in terms[1:])


def times_tables(times: dict[str, list[dict]]) -> str:
    lines, fits = [], []
    for quantity in QUANTITIES:
        own = times[quantity.title]
        cells = [f"{figures(t['mean'], 3)} ± {figures(t['std_dev'], 1)} ({figures(t['median'], 3)})" for t in own]
        lines.append([f"{quantity.title} (Figure {quantity.figure})", *cells])
        polynomial, factor, exponent = fit(quantity, own)
        share = polynomial.coef[-1] * JOINTS[-1] ** quantity.degree / polynomial(JOINTS[-1])
        terms, power = polynomial_in_words(polynomial.coef), f"{figures(factor, 2)} N^{exponent:.2f}"
        fits.append([quantity.title, terms, f"{100 * share:.0f} %", power, quantity.paper])
    head = (
        "growth | polynomial of least squares, microseconds | its last term at the largest N | power law"
        " | paper, Figures 4 and 5"
    )
    first = " | ".join(["microseconds per call at one node", *(f"N = {n}" for n in JOINTS)])
    note = "Mean ± standard deviation (median) of criterion's samples at one state; the fits are those of the means."
    return f"{table(first, lines)}\n\n{table(head, fits)}\n\n{note}"


def logarithmic(title: str, x: str, y: str) -> tuple:
    """A figure with logarithmic axes, and these."""
    figure = Figure(figsize=(7.2, 4.8), layout="constrained")
    axes = figure.subplots()
    axes.set(title=title, xlabel=x, ylabel=y, xscale="log", yscale="log")
    axes.grid(alpha=0.3)
    return figure, axes


def draw_times(number: int, times: dict[str, list[dict]], path: Path) -> None:
    figure, axes = logarithmic(f"A call at one node (cf. Figure {number})", "number of joints N", "time, microseconds")
    for i, quantity in enumerate(quantity for quantity in QUANTITIES if quantity.figure == number):
        own = times[quantity.title]
        polynomial, _, exponent = fit(quantity, own)
        mean, deviation, _ = ([t[of] for t in own] for of in STATISTICS)
        label = f"{quantity.title}, about N^{exponent:.1f}"
        axes.errorbar(JOINTS, mean, deviation, fmt="o", color=f"C{i}", label=label)
        n = np.geomspace(JOINTS[0], JOINTS[-1])
        axes.plot(n, polynomial(n), color=f"C{i}", linewidth=1)
    axes.set_xticks(JOINTS, JOINTS)
    axes.minorticks_off()
    axes.legend()
    figure.savefig(path)


def solve_by(method: str, name: str, passive: bool, limit: float, records: list[dict]) -> dict:
    """The summary of a solve on one thread that is stopped after `limit` seconds; `records` gets those of a flow.

    The direct method has one start, so that it begins at the first guess of the flows to rest. With passive joints all
    of them have their default number of starts instead."""
    print(f"{name}, {method}", file=sys.stderr)
    if method != "direct":
        return aghf.solve(name, method=method, time_limit_s=limit, on_iteration=records.append).summary
    end = time.monotonic() + limit

    def stop(_: dict) -> None:
        # With `time_limit_s` the direct method would plan a path first.
        if time.monotonic() > end:
            raise KeyboardInterrupt

    return aghf.solve(name, threads=1, on_iteration=stop, **({} if passive else {"starts": 1})).summary


def variants_cell(tried: list[dict]) -> str:
    good = [s for s in tried if s["success"]]
    count = f"{len(good)}/{len(tried)}" if tried else "-"
    if not good:
        return count
    effort, seconds = (statistics.median(s[name] for s in good) for name in ("control_effort", "solve_seconds"))
    return f"{count}, {figures(effort, 4)}, {figures(1e3 * seconds, 2)} ms"


def compare_variants(families: dict[str, list[str]], limit: float, out: Path) -> tuple[str, dict]:
    """The table of the methods, and the summaries by family and method; draws the action of the flows."""
    results = {title: {method: [] for method in METHODS} for title in families}
    figure, axes = logarithmic(f"Action along the flow, {DRAWN}", "s", "action")
    for title, names in families.items():
        passive = title in PASSIVE
        # The published flow is not defined for passive joints.
        for name, method in itertools.product(names, METHODS[1:] if passive else METHODS):
            results[title][method].append(solve_by(method, name, passive, limit, records := []))
            if name == DRAWN and records:
                axes.plot(*zip(*((record["s"], record["action"]) for record in records)), label=method)
    if axes.lines:
        axes.legend()
        figure.savefig(out / "variants.svg")
    lines = [[title, *map(variants_cell, of.values())] for title, of in results.items()]
    return table(" | ".join(["family", *METHODS]), lines), results


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="no searches; two scenarios per family, 10 s each")
    parser.add_argument("--variants", action="store_true", help="compare the variants of the flow and the direct one")
    parser.add_argument("--only", default="", metavar="NAME", help="scenarios that begin with this; no Figures 4 and 5")
    parser.add_argument("--grid", action="append", help="search this sweep [default: the tables, with --quick none]")
    parser.add_argument("--out", type=Path, metavar="DIR", help="default: out/paper or out/variants")
    arguments = parser.parse_args()
    began = time.monotonic()
    out = arguments.out or Path("out") / ("variants" if arguments.variants else "paper")
    out.mkdir(parents=True, exist_ok=True)
    matplotlib.style.use("tableau-colorblind10")
    all_of = FAMILIES if arguments.variants else SYSTEMS
    chosen = {title: [name for name in names if name.startswith(arguments.only)] for title, names in all_of.items()}
    chosen = {title: names for title, names in chosen.items() if names}
    if not chosen:
        parser.error(f"--only: no scenario begins with '{arguments.only}'")
    found, parts = {}, ["# Variants of the flow" if arguments.variants else "# The paper's experiments, run anew"]
    grids = arguments.grid or ([] if arguments.quick else TABLES)
    if grids and not arguments.variants:
        found, text = search(chosen, grids)
        parts.append(text)
    # Timed solves use one core.
    os.environ["RAYON_NUM_THREADS"] = "1"
    if arguments.variants:
        families = {title: names[:2] if arguments.quick else names for title, names in chosen.items()}
        text, results = compare_variants(families, 10.0 if arguments.quick else 60.0, out)
        parts.append(text)
    else:
        rows = solve_systems(chosen, found, 9 if arguments.quick else 25)
        parts.append(solves_table(rows))
        results = {"solves": [row._asdict() for row in rows]}
        if not arguments.only:
            results["times"] = node_times(out / "criterion")
            parts.append(times_tables(results["times"]))
            for number in (4, 5):
                draw_times(number, results["times"], out / f"figure_{number}.svg")
    version, seconds = importlib.metadata.version("aghf"), figures(time.monotonic() - began, 2)
    parts.append(f"aghf {version}, one core of {os.cpu_count()} of {processor()}, {seconds} s in all.")
    report = "\n\n".join(parts) + "\n"
    (out / "report.md").write_text(report, encoding="utf-8")
    (out / "results.json").write_text(json.dumps(results, indent=1), encoding="utf-8")
    print(report, end="")


if __name__ == "__main__":
    main()
