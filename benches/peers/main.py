"""Runs the comparisons that are asked for, one after the other on one core, and writes their tables."""

import argparse
import os
import subprocess
import sys
from pathlib import Path

import aligator_paper
import crocoddyl_paper
import ipopt
import report
import vamp_toppra
from common import HERE, WORK, Table

SECTIONS = {"paper": crocoddyl_paper, "obstacles": aligator_paper, "mbm": vamp_toppra, "ipopt": ipopt}
DYNAMICS = HERE / "dynamics" / "run"


def dynamics(folder, quick):
    """The table of the dynamics, which a program of its own makes."""
    command = [DYNAMICS, *(["--quick"] if quick else []), "--out", folder]
    return subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout.strip()


def main():
    known = [*SECTIONS, "dynamics"]
    parser = argparse.ArgumentParser(prog="benches/peers/run", description=__doc__)
    parser.add_argument("sections", nargs="*", help=f"some of {', '.join(known)}; all if none is named")
    parser.add_argument(
        "--quick",
        action="store_true",
        help="a part of each section, five minutes in all; obstacles, where Aligator is compiled, only if it is named",
    )
    parser.add_argument(
        "--repeats", type=int, default=0, help="solves of each scenario that are timed, 3 in a quick run, else 5"
    )
    parser.add_argument(
        "--grid",
        action="store_true",
        help="of the paper's experiments all sets of the tables too; takes days, use --resume",
    )
    parser.add_argument(
        "--limit", type=float, default=0, help="seconds for each set, the paper's 180 and 300 if not given"
    )
    parser.add_argument(
        "--stride", type=int, default=10, help="of MotionBenchMaker every so many problems of each family"
    )
    parser.add_argument("--resume", action="store_true", help="keep the rows of results.csv that are there")
    parser.add_argument("--out", type=Path, default=WORK / "out", help="the folder for RESULTS.md, index.html and CSV")
    options = parser.parse_args()
    options.repeats = options.repeats or (3 if options.quick else 5)
    unknown = [name for name in options.sections if name not in known]
    if unknown:
        parser.error(f"no section {', '.join(unknown)}: there are {', '.join(known)}")
    if options.quick:
        options.limit = options.limit or 20
    # On one core, the last of those that this process may use.
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    table = Table(options.out / "results.csv", options.resume)
    notes = {name: module.NOTE for name, module in SECTIONS.items()}
    command = " ".join(["benches/peers/run", *sys.argv[1:]])
    table_of_dynamics = ""
    all_sections = [name for name in known if not (options.quick and name == "obstacles")]
    for name in options.sections or all_sections:
        if name != "dynamics":
            SECTIONS[name].run(table, options)
        elif DYNAMICS.exists():
            table_of_dynamics = dynamics(options.out, options.quick)
        report.write(table, notes, options.out, command, table_of_dynamics)
    print(f"wrote {options.out}/RESULTS.md, index.html and results.csv")
    return 0


if __name__ == "__main__":
    sys.exit(main())
