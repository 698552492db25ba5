#!/usr/bin/env python3
"""Compares the figures in the README, the page of figures and the guide with the tables that they come from.

    python3 benches/figures.py

A claim is a text with `{}` in place of its numbers, and the values in the tables of results that round to these. Every
number in the table of results in the README and in the tables of the page of figures belongs to a claim. Exits with 1
where something differs.
"""

import csv
import re
import statistics
import sys
from decimal import Decimal
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
NUMBER = r"\d+(?:\.\d+)?"
MBM, PAPER, WALKS = "MotionBenchMaker", "The paper's experiments, run anew", "Walks"
BUILT_IN, GOALS, IK = "Built-in scenarios", "Goals of a task", "Inverse kinematics"
STEP, CUROBO, EXPERIMENTS = "A step from random starts", "The conditions of cuRoboV2", "The paper's experiments"


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
        cells = [row[head.index(heading)] for row in body if re.search(rows, " | ".join(row[:2]))]
        if not cells:
            sys.exit(f"{self.path}: {section}: '{heading}': no row matches '{rows}'")
        return [Decimal(number) for number in re.findall(NUMBER, cells[0])]

    def in_prose(self, words: str) -> list[Decimal]:
        """The numbers behind these words and in the groups of their pattern."""
        found = re.search(rf"{words} ({NUMBER})", " ".join(self.text.split()))
        if not found:
            sys.exit(f"{self.path}: there is no number behind '{words}'")
        return [Decimal(number) for number in found.groups()]


class Solves:
    """The rows of a CSV file of solves, one per section, scenario and method, in the same order for each method."""

    def __init__(self, path: str) -> None:
        with (ROOT / path).open(encoding="utf-8", newline="") as file:
            self.rows = list(csv.DictReader(file))

    def of(self, section: str, column: str, method: str, scenario: str) -> list[Decimal]:
        """The numbers of a column, in the rows of a section whose method and scenario begin like two patterns."""
        rows = [row for row in self.rows if row["section"] == section and re.match(method, row["method"])]
        return [Decimal(row[column]) for row in rows if re.match(scenario, row["scenario"])]

    def ratios(self, section: str, column: str, first: str, second: str, scenario: str) -> list[Decimal]:
        """The numbers of the first method divided by those of the second one, scenario by scenario."""
        numbers = (self.of(section, column, method, scenario) for method in (first, second))
        return [a / b for a, b in zip(*numbers, strict=True)]


def ends(values: list[Decimal]) -> list[Decimal]:
    """The least and the largest value."""
    return [min(values), max(values)]


def of_readme(ours: Results, peers: Results) -> list[tuple[str, list[Decimal]]]:
    """The claims of the README."""
    solved, medians = (ours.of("Within all limits", name, "^(?!G1)") for name in ("solved", "median, ms"))
    mutations = (ROOT / "tests/mutations/list.toml").read_text(encoding="utf-8").count("[[mutation]]")
    poses, own = r"^Kinova \| pose$", r"^(Kinova|Panda|xArm7) \| ours"
    vamp = peers.of(MBM, "median ms", r"^all \| VAMP.*spline")[0]
    plans = [vamp, ours.of(CUROBO, "median, ms", r"^cuRobo.* \| yes")[-1]]
    return [
        ("{} deliberate errors", [Decimal(mutations)]),
        (
            "Panda, {} problems | {}, one has no solution | {} s |",
            [ours.of(MBM, name, "^all", 1)[0] for name in ("problems", "optimal")]
            + [ours.of(MBM, "median ms", "^all", 1)[0] / 1000],
        ),
        ("five arms | {} of {} | {} to {} ms |", [sum(solved), Decimal(100 * len(solved)), *ends(medians)]),
        (
            "as goals, Kinova | {} of {} | {} s |",
            [*ours.both(GOALS, "solved and valid", poses), ours.of(GOALS, "median, ms", poses)[0] / 1000],
        ),
        (
            "three arms | {} of {} | {} to {} ms |",
            [sum(ours.of(IK, "solved", own)), sum(ours.of(IK, "poses", own)), *ends(ours.of(IK, "median ms", own))],
        ),
        (
            "its torque limits | {} of {} phases certified | {} s |",
            [ours.of(WALKS, name, "Digit")[0] for name in ("certified", "phases", "solve, s")],
        ),
        ("as in the paper | {} ms |", ours.of(PAPER, "solve, ms", r"^Kinova \|")),
        ("VAMP plans in {} ms and cuRobo on a GPU in {} ms", plans),
    ]


def of_page(ours: Results) -> list[tuple[str, list[Decimal]]]:
    """The claims of the page of figures but for those beside peers."""
    solved, medians = (ours.of("Within all limits", name, "^(?!G1)") for name in ("solved", "median, ms"))
    costs, starts = ours.both(STEP, "cost, least to largest", "^ours"), ours.of(STEP, "valid", "^ours")
    poses = (r"^Kinova \| pose$", r"^Panda \| pose$")
    own, theirs = (rf"^(Kinova|Panda|xArm7) \| {who}" for who in ("ours", "TRAC-IK, 50 ms"))
    return [
        ("{} of {} MotionBenchMaker problems", ours.of(MBM, "valid", "^all") + ours.of(MBM, "problems", "^all")),
        (
            "median {} s, the slowest {} s",
            [ours.of(MBM, name, "^all")[0] / 1000 for name in ("median ms", "worst")],
        ),
        (
            "of all {}, with the objective `balanced`, {} are valid and minima, median {} s",
            [ours.of(MBM, name, "^all", 1)[0] for name in ("problems", "optimal")]
            + [ours.of(MBM, "median ms", "^all", 1)[0] / 1000],
        ),
        ("or the folder of the {}", ours.of(MBM, "problems", "^all", 1)),
        ("on five arms, {} of {} solved", [sum(solved), Decimal(100 * len(solved))]),
        ("medians {} to {} ms", [min(medians), max(medians)]),
        (
            "{} of {} on Kinova, {} of {} on Panda, median {} and {} s",
            [number for row in poses for number in ours.both(GOALS, "solved and valid", row)]
            + [ours.of(GOALS, "median, ms", row)[0] / 1000 for row in poses],
        ),
        (
            "{} poses each: {} on Kinova, {} on Panda, {} on xArm7, median {} to {} ms",
            ours.of(IK, "poses", r"Kinova \| ours") + ours.of(IK, "solved", own)
            + ends(ours.of(IK, "median ms", own)),
        ),
        (
            "TRAC-IK, at most {} ms: {}, {} and {}, median {} to {} ms",
            [Decimal(50), *ours.of(IK, "solved", theirs), *ends(ours.of(IK, "median ms", theirs))],
        ),
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
            "by the published flow, the paper's Kinova experiments: {} ms without obstacles, {} ms with",
            [ours.of(PAPER, "solve, ms", row)[0] for row in (r"^Kinova \|", "^Kinova, obstacles")],
        ),
        (
            "Jacobian at a node: {} µs for Kinova, {} µs for Digit",
            [ours.of(PAPER, name, "^Jacobian, control form", 1)[0] for name in ("N = 7", "N = 22")],
        ),
        (
            "(released C++: {} and {})",
            [ours.of(PAPER, name, "^Jacobian, released", 3)[0] for name in ("Kinova (7)", "Digit (22)")],
        ),
        ("the acrobot, {}, as IPOPT", ours.in_prose("it ends at")),
    ]


def beside_planners(ours: Results, peers: Results) -> list[tuple[str, list[Decimal]]]:
    """The claims of the page of figures beside VAMP, cuRoboV2, RAPTOR and Pinocchio."""
    vamp, fast, balanced = "VAMP.*spline", "ours, least time", "ours, balanced"
    longer = rf"last ({NUMBER}) times .*?with"
    times = [peers.of(MBM, "median ms", rf"^all \| {who}")[0] for who in (vamp, fast, balanced)]
    valid = [peers.of(MBM, "valid", rf"^all \| {who}")[0] for who in (balanced, vamp, "VAMP.*corners")]
    # The last row within limits of torque has a payload; the first one without these limits has none.
    solvers = ("cuRobo.*", "ours, least-time", "ours, balanced")
    medians, durations, energies = (
        [ours.of(CUROBO, name, rf"^{who} \| yes")[-1] for who in solvers]
        for name in ("median, ms", "duration, s", "energy, J")
    )
    jerks = [ours.of(CUROBO, "largest jerk, rad/s³", rf"^{who} \| no")[0] for who in solvers]
    success = ours.of(CUROBO, "valid", "^cuRobo.* yes") + ours.in_prose("Problems: theirs are")
    dynamics = [peers.of("Dynamics", name) for name in ("Pinocchio", "aghf", "aghf, 4 lanes")]
    ahead = [ends([a / b for a, b in zip(dynamics[0], own, strict=True)]) for own in dynamics[1:]]
    return [
        ("times in {} ms, aghf in {} (least time) or {} (balanced)", times),
        ("{} motions keep all limits and clearances, with VAMP {} ({} with sharp corners)", valid),
        ("least time last {} times as long with {} times", peers.in_prose(f"Motions of least time {longer}")),
        ("balanced ones {} times with {} times", peers.in_prose(f"Balanced motions {longer}")),
        (
            "{} s in the median, aghf {} (least time) or {} s (balanced), {} or {} times as long",
            [number / 1000 for number in medians] + [number / medians[0] for number in medians[1:]],
        ),
        ("shorter motions ({} s, aghf {} or {} s) with less energy ({} J, aghf {} or {} J)", durations + energies),
        ("less jerk ({} rad/s³, aghf up to {})", [jerks[0], max(jerks[1:])]),
        ("{} of {} motions pass the judge", ours.both(CUROBO, "valid", "^ours, least-time")),
        ("a success of {} % on {}", success),
        (
            "from {} random starts: {} s in the median and {} s at most; RAPTOR reports {} s and {} s",
            ours.of(STEP, "valid", "^ours")
            + [ours.of(STEP, name, who)[0] for who in ("^ours", "^RAPTOR") for name in ("median, s", "slowest, s")],
        ),
        ("{} to {} times as fast for one state, {} to {} times for four in lanes", ahead[0] + ahead[1]),
    ]


def beside_optimisers(peers: Results, solves: Solves) -> list[tuple[str, list[Decimal]]]:
    """The claims of the page of figures beside Crocoddyl, IPOPT and Aligator."""
    efforts = [solves.of("paper", "effort", who, "pend.*_[345]") for who in ("Croc.*best", "ours$", "ours, degree")]
    crocoddyl = [solves.of("paper", "effort", who, "kinova") for who in ("Croc.*best", "Croc.*tuned", "ours$")]
    more = statistics.median(min(best, tuned) / own for best, tuned, own in zip(*crocoddyl, strict=True))
    digit = [peers.both(EXPERIMENTS, "success", rf"^Digit \| {who}") for who in ("ours$", "Crocoddyl, best")]

    shooting, basis = ("ours, degree 32", "IPOPT, multiple"), ("IPOPT, degree 16", "ours, one")
    # On one problem within limits IPOPT ends at another minimum in the same basis.
    free, spheres, limits, other = "kinova_free", "kinova_obstacles", "limits", "limits_05$"
    third = [solves.of("ipopt", "effort", who, "pend.*_3")[0] for who in reversed(shooting)]
    fifth = [solves.of("ipopt", "effort", who, other)[0] for who in reversed(basis)]
    less, basis_less = (
        [100 * (1 - ratio) for ratio in solves.ratios("ipopt", "effort", *methods, names)]
        for methods, names in ((shooting, limits), (basis, rf"{free}|(?!{other}){limits}"))
    )
    slower, within, without, among = (
        ends(solves.ratios("ipopt", "seconds", *shooting, names)) for names in ("pend", limits, free, spheres)
    )
    faster = [ends(solves.ratios("ipopt", "seconds", *basis, names)) for names in (f"{free}|{limits}", "pend")]
    means = [
        statistics.mean(solves.of("ipopt", "effort", who, names)) for who in shooting for names in (free, spheres)
    ]

    aligator = ("Aligator, best", "Aligator, tuned$")
    steps = sorted(solves.of("obstacles", "iterations", "|".join(aligator), "kinova"))
    times = [solves.of("obstacles", "seconds", who, "kinova") for who in ("ours$", "|".join(aligator))]
    worse = [ratio for who in aligator for ratio in solves.ratios("obstacles", "effort", who, "ours$", "kinova")]
    slow = [solves.of("obstacles", "seconds", who, "digit") for who in ("ours$", aligator[1])]
    costly = solves.ratios("obstacles", "effort", aligator[1], "ours$", "digit")
    return [
        ("of 3 to 5 links ({}, {} and {}) than aghf at degree 16 ({}, {} and {})", efforts[0] + efforts[1]),
        ("on the last one also at degree 32 ({})", efforts[2][-1:]),
        (
            "Kinova in {} to {} s, with Crocoddyl in {} to {} s and {} times the effort in the median",
            ends(solves.of("paper", "seconds", "ours$", "kinova"))
            + ends(solves.of("paper", "seconds", "Crocoddyl", "kinova"))
            + [more],
        ),
        ("{} of {} motions of Digit solved, with Crocoddyl {}", digit[0] + digit[1][:1]),
        ("pendulums: {} to {} times as fast", slower),
        ("on that of 3 links ({}, aghf {})", third),
        ("within limits at most {} % less effort in {} to {} times its time", [max(less), *within]),
        ("mean efforts of {} and {} (IPOPT: {} and {})", means),
        ("in {} to {} and {} to {} times its time", without + among),
        (
            "{} to {} times as fast, efforts differ by at most {} % but on one of {} problems ({}, IPOPT {})",
            [*faster[0], max(map(abs, basis_less)), Decimal(len(basis_less) + 1), *fifth],
        ),
        ("pendulums {} to {} times", faster[1]),
        ("fewer iterations, {} to {} in eight of ten solves", [steps[0], steps[7]]),
        (
            "Kinova in {} to {} s, with Aligator in {} to {} s and {} to {} times the effort",
            [end for values in (*times, worse) for end in ends(values)],
        ),
        (
            "Digit in {} to {} s, with Aligator, after tuning for this comparison, in {} to {} s and {} to {} times",
            ends(slow[0]) + ends(slow[1]) + ends(costly),
        ),
    ]


def of_functions(ours: Results, peers: Results) -> list[tuple[str, list[Decimal]]]:
    """The times of functions in the page on performance."""
    dynamics = {
        "dynamics::rnea) | O(N)": "rnea",
        "dynamics::crba) | O(N d)": "crba",
        "dynamics::aba) | O(N)": "aba",
        "dynamics::rnea_derivatives()) | O(N d)": "rnea_derivatives",
        "dynamics::aba_derivatives) | O(N²) and products of matrices": "aba_derivatives",
        "full tensors | O(N d²)": "rnea_second_derivatives",
    }
    flow = {
        "by the control form | O(N)": "Omega, control form",
        "control form | O(N d) and products of matrices": "Jacobian, control form",
        "Algorithm B2 | O(N³)": "Jacobian, Theorem B4",
    }
    columns = [(robot, name) for robot in ("kinova", "digit") for name in ("aghf", "aghf, 4 lanes")]
    claims = []
    for head, function in dynamics.items():
        times = [peers.of("Dynamics", name, rf"^{robot} \| {function}$")[0] for robot, name in columns]
        claims.append((head + " | {} | {} | {} | {} |", times))
    for head, row in flow.items():
        times = [ours.of(PAPER, name, f"^{row}", 1)[0] for name in ("N = 7", "N = 22")]
        claims.append((head + " | {} | | {} | |", times))
    return claims


def of_guide(ours: Results, peers: Results) -> dict[str, list[tuple[str, list[Decimal]]]]:
    """The claims of other pages."""
    walks = ours.of(WALKS, "solve, s")
    limits = ours.of("Within all limits", "median, ms", "^Kinova Gen3")
    return {
        "src/guide/performance.md": of_functions(ours, peers),
        "app/scenario/src/guide/standing.md": [("take {} to {} s on one core", [min(walks), max(walks)])],
        "app/scenario/src/guide/asking_for_more.md": [
            ("(`limits`) | 91 | {} ms", limits[:1]),
            ("(`limits_obstacle`) | 91 | {} ms", limits[1:]),
            ("(`kinova_free`) | 91 | {} ms", [statistics.median(ours.of(BUILT_IN, "solve, ms", "^kinova_free"))]),
            ("(`kinova_table_01`) | 91 and the horizon | {} ms", ours.of(BUILT_IN, "solve, ms", "^kinova_table_01")),
        ],
    }


def differences(file: str, claims: list[tuple[str, list[Decimal]]]) -> tuple[list[str], str]:
    """The differences between a page and its claims, and the text of the page without these."""
    text = " ".join((ROOT / file).read_text(encoding="utf-8").split())
    found = []
    for claim, values in claims:
        pattern = re.escape(claim).replace(r"\{\}", f"({NUMBER})")
        match = re.search(pattern, text)
        if not match:
            found.append(f"{file}: there is no '{claim}'")
            continue
        for number, value in zip(match.groups(), values, strict=True):
            # As many digits behind the point as the page has.
            if value.quantize(Decimal(1).scaleb(Decimal(number).as_tuple().exponent)) != Decimal(number):
                found.append(f"{file}: '{match[0]}': {number} is {value} in the table of results")
        text = text.replace(match[0], "")
    return found, text


def main() -> None:
    ours, peers = Results("benches/RESULTS.md"), Results("benches/peers/RESULTS.md")
    claims = of_page(ours) + beside_planners(ours, peers)
    claims += beside_optimisers(peers, Solves("benches/peers/results.csv"))
    found = []
    # The claims of a page, and the headings of its tables, the text behind them, and the columns of figures.
    for page, of, tables in (
        ("README.md", of_readme(ours, peers), [("| task | solved |", "motions of aghf keep", slice(1, 3))]),
        (
            "benches/README.md",
            claims,
            [
                ("| figure | command |", "[RESULTS.md]", slice(1)),
                ("| peer | advantage of the peer |", "|END", slice(1, 3)),
            ],
        ),
    ):
        own, rest = differences(page, of)
        found += own
        rest += "|END"
        for head, end, columns in tables:
            for row in rest[rest.index(head) : rest.index(end, rest.index(head))].split(" | | ")[1:]:
                for cell in row.split(" | ")[columns]:
                    for number in re.findall(rf"(?<![\w.-]){NUMBER}", cell):
                        found.append(f"{page}: {number} in '{cell}' belongs to no claim")
    for file, claims in of_guide(ours, peers).items():
        found += differences(file, claims)[0]
    print("\n".join(found) or "all figures are those of the tables")
    sys.exit(bool(found))


if __name__ == "__main__":
    main()
