#!/usr/bin/env python3
"""Updates the tables in benches/RESULTS.md: all of them, or the named ones.

    cargo build --release
    benches/results.py                     # scenarios, families, degrees, paper, variants: some 25 minutes
    benches/results.py scenarios families

Tables are between `<!-- NAME -->` and `<!-- end of NAME -->`. The first line of the file names the processor and the
commit of the last run. The commands of the tables of `benches/limits.py`, of MotionBenchMaker, whose problems are
downloaded, and of builds are next to them. `paper` and `variants` come from `benches/paper.py` and have its
requirements; the others need only Python 3.9.
"""

import json
import os
import platform
import re
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
AGHF = ROOT / "target" / "release" / "aghf"
RESULTS = ROOT / "benches" / "RESULTS.md"
KNOWN = json.loads((ROOT / "robots" / "best_known.json").read_text(encoding="utf-8"))
FAMILIES = ["kinova_cross", "kinova_gap", "kinova_floor", "digit_box"]
DEGREES = ["kinova_free_01", "digit_free_stretch", "digit_free_step"]
SIZES = [(1, 9), (1, 16), (1, 24), (1, 32), (2, 7), (2, 9), (4, 7), (4, 9), (8, 7), (8, 9)]


def aghf(*arguments: str, folder: str) -> str:
    """The output of `aghf` on one thread; exit code 3 is a failed solve, which is a result."""
    environment = {**os.environ, "RAYON_NUM_THREADS": "1"}
    run = subprocess.run([AGHF, *arguments], cwd=folder, env=environment, capture_output=True, text=True)
    if run.returncode not in (0, 3):
        sys.exit(f"aghf {' '.join(arguments)}: {run.stderr}")
    return run.stdout


def solved(name: str, folder: str, *options: str) -> dict:
    arguments = ("--threads", "1", "--json", "--no-report", "--force", "--out", name, *options)
    return json.loads(aghf("solve", name, *arguments, folder=folder))


def short(x) -> str:
    """Two digits, or nothing."""
    if x is None:
        return ""
    return f"{x:.1e}" if abs(x) < 1e-2 or abs(x) >= 100 else f"{x:.2g}"


def table(head: str, rows) -> str:
    rule = "| --- " * head.count(" | ") + "| --- |"
    return "\n".join([f"| {head} |", rule, *(f"| {' | '.join(row)} |" for row in rows)])


def scenarios(folder: str) -> str:
    head = (
        "scenario | success | effort | cost / least known | final error with feedback | open loop | clearance, m"
        " | gradient norm | smallest curvature | solve, ms | points / iterations / factorisations"
    )
    rows = []
    for name, known in KNOWN.items():
        if re.fullmatch(r".*_(cross|gap|floor|box)_\d+", name):
            continue
        s = solved(name, folder)
        cost = s.get("cost") or s["control_effort"]
        clearance = s["smallest_clearance_m"]
        rows.append([
            f"`{name}`",
            "yes" if s["success"] else "no",
            f"{s['control_effort']:.4g}",
            f"{cost / known['cost']:.2f}",
            f"{s['final_error_inf']:.1e}",
            short(s["open_loop_error_inf"]),
            "" if clearance is None else f"{clearance:.1e}",
            f"{s['gradient_norm']:.1e}",
            "" if s["smallest_curvature"] is None else f"{s['smallest_curvature']:.2f}",
            f"{1e3 * s['solve_seconds']:.0f}",
            f"{s['quadrature_points']} / {s['iterations']} / {s['factorisations']}",
        ])
    return table(head, rows)


def families(folder: str) -> str:
    head = "family | success | mean effort | worst final error with feedback | smallest clearance, m"
    head += " | median solve, ms | slowest, ms"
    rows = []
    for family in FAMILIES:
        all_of = [solved(f"{family}_{i:02}", folder) for i in range(1, 11)]
        times = [1e3 * s["solve_seconds"] for s in all_of]
        rows.append([
            f"`{family}`",
            f"{sum(s['success'] for s in all_of)}/10",
            f"{statistics.mean(s['control_effort'] for s in all_of):.1f}",
            f"{max(s['final_error_inf'] for s in all_of):.1e}",
            f"{min(s['smallest_clearance_m'] for s in all_of):.1e}",
            f"{statistics.median(times):.0f}",
            f"{max(times):.0f}",
        ])
    return table(head, rows)


def degrees(folder: str) -> str:
    head = "segments x degree | unknowns per joint | " + " | ".join(f"`{name}` | solve, ms" for name in DEGREES)
    rows = []
    for segments, degree in SIZES:
        options = ("--segments", str(segments), "--degree", str(degree))
        summaries = [solved(name, folder, *options) for name in DEGREES]
        # Segments share position and velocity at breakpoints, and those of the ends are given by the scenario.
        row = [f"{segments} x {degree}", str(segments * (degree - 1) - 2)]
        for s in summaries:
            row += [f"{s['control_effort']:.4g}", f"{1e3 * s['solve_seconds']:.0f}"]
        rows.append(row)
    return table(head, rows)


def experiments(folder: str, *options: str) -> str:
    """The report of `benches/paper.py`."""
    command = [sys.executable, str(ROOT / "benches" / "paper.py"), "--out", folder, *options]
    subprocess.run(command, cwd=ROOT, stdout=subprocess.DEVNULL, check=True)
    return (Path(folder) / "report.md").read_text(encoding="utf-8").strip()


def paper(folder: str) -> str:
    return experiments(folder, "--quick")


def variants(folder: str) -> str:
    return experiments(folder, "--variants")


SECTIONS = {of.__name__: of for of in (scenarios, families, degrees, paper, variants)}


def processor() -> str:
    if Path("/proc/cpuinfo").exists():
        found = re.search(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text(encoding="utf-8"))
        if found:
            return found[1]
    return platform.processor() or platform.machine()


def machine(name: str) -> str:
    """The table that was made last, the commit, and the processor."""
    revision = ["git", "rev-parse", "--short", "HEAD"]
    commit = subprocess.run(revision, cwd=ROOT, capture_output=True, text=True).stdout.strip()
    cores = f"one core of {os.cpu_count()} of {processor()}"
    return f"Last run of `benches/results.py`: table `{name}` at commit {commit}, {cores}."


def main(chosen: list[str]) -> None:
    unknown = [name for name in chosen if name not in SECTIONS]
    if unknown:
        sys.exit(f"{unknown[0]}: there are {', '.join(SECTIONS)}")
    text = RESULTS.read_text(encoding="utf-8")
    for name in chosen or SECTIONS:
        pattern = re.compile(rf"(<!-- {name} -->\n\n).*?(\n\n<!-- end of {name} -->)", re.DOTALL)
        if not pattern.search(text):
            sys.exit(f"{RESULTS.name}: it has no place for {name}")
        with tempfile.TemporaryDirectory() as folder:
            made = SECTIONS[name](folder)
        text = pattern.sub(lambda found: found[1] + made + found[2], text)
        # One after the other, so that an interruption loses nothing.
        RESULTS.write_text(re.sub(r"Last run of .*", machine(name), text), encoding="utf-8")
        print(f"{name}: done", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
