#!/usr/bin/env python3
"""Compares the figures in the README and the guide with the tables that they come from.

    python3 benches/figures.py

A claim is a text with `{}` in place of its numbers, and the values in the tables of results that round to these. Every
number in the table "Results" of the README belongs to a claim. Exits with 1 where something differs.
"""

import re
import sys
from decimal import Decimal
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
NUMBER = r"\d+(?:\.\d+)?"
MBM, PAPER, WALKS = "MotionBenchMaker", "The paper's experiments, run anew", "Walks"
STEP = "A step from random starts"


class Results:
    """The tables of a file by the headings above them."""

    def __init__(self, path: str) -> None:
        self.path = path
        self.text = (ROOT / path).read_text(encoding="utf-8")
        self.sections: dict[str, list[list[list[str]]]] = {}
        section, before = "", ""
        for line in self.text.splitlines():
            if line.startswith("#"):
                section = line.lstrip("# ")
            if line.startswith("|"):
                tables = self.sections.setdefault(section, [])
                if not before.startswith("|"):
                    tables.append([])
                if not set(line) <= set("|-: "):
                    tables[-1].append([cell.strip(" `") for cell in line.strip("|").split("|")])
            before = line

    def of(self, section: str, heading: str, rows: str = "", table: int = 0) -> list[Decimal]:
        """The numbers of a column, in rows whose first two cells match a pattern; of "a/b" the first."""
        head, *body = self.sections[section][table]
        column = head.index(heading)
        cells = [row[column] for row in body if re.search(rows, " | ".join(row[:2]))]
        numbers = [re.match(NUMBER, cell) for cell in cells]
        if not cells or None in numbers:
            sys.exit(f"{self.path}: {section}: '{heading}': rows that match '{rows}' have {cells}")
        return [Decimal(number[0]) for number in numbers if number]

    def both(self, section: str, heading: str, rows: str) -> list[Decimal]:
        """Both numbers of a cell "a to b", in the row whose first two cells match a pattern."""
        head, *body = self.sections[section][0]
        cell = next(row[head.index(heading)] for row in body if re.search(rows, " | ".join(row[:2])))
        return [Decimal(number) for number in re.findall(NUMBER, cell)]

    def in_prose(self, words: str) -> list[Decimal]:
        """The number behind these words."""
        found = re.search(rf"{words} ({NUMBER})", " ".join(self.text.split()))
        if not found:
            sys.exit(f"{self.path}: there is no number behind '{words}'")
        return [Decimal(found[1])]


def of_readme(ours: Results, peers: Results) -> list[tuple[str, list[Decimal]]]:
    """The claims of the README."""
    solved, medians = (ours.of("Within all limits", name, "^(?!G1)") for name in ("solved", "median, ms"))
    methods = ("VAMP.*spline", "ours, least time", "ours, balanced")
    times = [peers.of(MBM, "median ms", rf"^all \| {who}")[0] for who in methods]
    costs, starts = ours.both(STEP, "cost, least to largest", "^ours"), ours.of(STEP, "valid", "^ours")
    methods = ("ours, balanced", "VAMP.*spline", "VAMP.*corners")
    valid = [peers.of(MBM, "valid", rf"^all \| {who}")[0] for who in methods]
    mutations = (ROOT / "tests/mutations/list.toml").read_text(encoding="utf-8").count("[[mutation]]")
    return [
        ("{} deliberate errors", [Decimal(mutations)]),
        ("{} of {} MotionBenchMaker problems", ours.of(MBM, "valid", "^all") + ours.of(MBM, "problems", "^all")),
        (
            "median {} s, the slowest {} s",
            [ours.of(MBM, name, "^all")[0] / 1000 for name in ("median ms", "worst")],
        ),
        (
            "of all {}, balanced, {} are valid and {} minima, median {} s",
            [ours.of(MBM, name, "^all", 1)[0] for name in ("problems", "valid", "optimal")]
            + [ours.of(MBM, "median ms", "^all", 1)[0] / 1000],
        ),
        ("or the folder of the {}", ours.of(MBM, "problems", "^all", 1)),
        ("on five arms, {} of {} solved", [sum(solved), Decimal(100 * len(solved))]),
        ("medians {} to {} ms", [min(medians), max(medians)]),
        ("{} of the {} phases certified", [sum(ours.of(WALKS, name)) for name in ("certified", "phases")]),
        (
            "Digit {} s, G1 {} s, Talos {} s",
            [ours.of(WALKS, "solve, s", robot)[0] for robot in ("Digit", "G1", "Talos")],
        ),
        (
            "from {} random starts: {} minima within {} % of each other",
            [*starts, *ours.of(STEP, "optimal", "^ours"), 100 * (costs[1] / costs[0] - 1)],
        ),
        ("dynamics, median {} s", ours.of(STEP, "median, s", "^ours")),
        (
            "{} s in the median and {} s at most, on another machine {} and {} s",
            [ours.of(STEP, name, who)[0] for who in ("^ours", "^RAPTOR") for name in ("median, s", "slowest, s")],
        ),
        (
            "{} ms without obstacles, {} ms with",
            [ours.of(PAPER, "solve, ms", row)[0] for row in (r"^Kinova \|", "^Kinova, obstacles")],
        ),
        (
            "{} µs for Kinova, {} µs for Digit",
            [ours.of(PAPER, name, "^Jacobian, control form", 1)[0] for name in ("N = 7", "N = 22")],
        ),
        (
            "(released C++: {} and {})",
            [ours.of(PAPER, name, "^Jacobian, released", 3)[0] for name in ("Kinova (7)", "Digit (22)")],
        ),
        ("the acrobot, {}, as IPOPT", ours.in_prose("it ends at")),
        ("times in {} ms, ours {} (least time) or {} (balanced)", times),
        ("{} motions keep all limits and clearances, its {} ({} with sharp corners)", valid),
    ]


def of_guide(ours: Results) -> dict[str, list[tuple[str, list[Decimal]]]]:
    """The claims of other pages."""
    walks = ours.of(WALKS, "solve, s")
    limits = ours.of("Within all limits", "median, ms", "^Kinova Gen3")
    return {
        "app/scenario/src/guide/standing.md": [("take {} to {} s on one core", [min(walks), max(walks)])],
        "app/scenario/src/guide/asking_for_more.md": [
            ("(`limits`) | 91 | {} ms", limits[:1]),
            ("(`limits_obstacle`) | 91 | {} ms", limits[1:]),
        ],
    }


def differences(file: str, claims: list[tuple[str, list[Decimal]]]) -> tuple[list[str], str]:
    """What differs between a page and its claims, and the text of the page without these."""
    text = " ".join((ROOT / file).read_text(encoding="utf-8").split())
    found = []
    for claim, values in claims:
        pattern = re.escape(claim).replace(r"\{\}", f"({NUMBER})")
        match = re.search(pattern, text)
        if not match:
            found.append(f"{file}: there is no '{claim}'")
            continue
        for told, value in zip(match.groups(), values, strict=True):
            # As many digits behind the point as the page has.
            if value.quantize(Decimal(1).scaleb(Decimal(told).as_tuple().exponent)) != Decimal(told):
                found.append(f"{file}: '{match[0]}': {told} is {value} in the table of results")
        text = text.replace(match[0], "")
    return found, text


def main() -> None:
    ours = Results("benches/RESULTS.md")
    found, rest = differences("README.md", of_readme(ours, Results("benches/peers/RESULTS.md")))
    table = rest[rest.index("| figure | command |") : rest.index("[benches/RESULTS.md]")]
    for row in table.split(" | | ")[1:]:
        for number in re.findall(rf"(?<![\w.-]){NUMBER}", row.split(" | ")[0]):
            found.append(f"README.md: {number} in '{row.split(' | ')[0]}' belongs to no claim")
    for file, claims in of_guide(ours).items():
        found += differences(file, claims)[0]
    print("\n".join(found) or "all figures are those of the tables")
    sys.exit(bool(found))


if __name__ == "__main__":
    main()
