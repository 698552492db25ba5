"""RESULTS.md and a page of the rows: a table for each section, with a line for each family and method."""

import datetime
import html
import importlib.metadata
import math
import os
import platform
import re
import subprocess

from common import AGHF, REPOSITORY, percentile

TITLES = {
    "ipopt": "Direct transcription with IPOPT",
    "paper": "The paper's experiments",
    "obstacles": "The paper's experiments with obstacles",
    "mbm": "MotionBenchMaker",
}
HEADS = ["family", "method", "success", "valid", "effort, N²m²s", "of the best", "duration, s", "median ms", "90 %"]
MOST_FAILURES = 60
PACKAGES = ["casadi", "crocoddyl", "pin", "toppra"]


def number(value, digits=4):
    """A number in few digits, a dash where there is none."""
    return "-" if value is None or not math.isfinite(value) else f"{value:.{digits}g}"


def mean(values):
    return sum(values) / len(values) if values else math.nan


def lines(rows):
    """A line for each family and method of a section: the entries of `HEADS`; of MotionBenchMaker also for all."""
    result = []
    families = dict.fromkeys(row.family for row in rows)
    for family in [*families, *(["all"] if rows[0].section == "mbm" else [])]:
        of_family = [row for row in rows if family in (row.family, "all")]
        best = {}
        for row in of_family:
            if row.success:
                best[row.scenario] = min(best.get(row.scenario, math.inf), row.effort)
        for method in dict.fromkeys(row.method for row in of_family):
            some = [row for row in of_family if row.method == method]
            good = [row for row in some if row.success]
            ratios = [row.effort / best[row.scenario] for row in good]
            ratio = math.exp(mean([math.log(r) for r in ratios])) if ratios and min(ratios) > 0 else math.nan
            times = [1e3 * row.seconds for row in some if math.isfinite(row.seconds)]
            result.append(
                [
                    family,
                    method,
                    f"{len(good)}/{len(some)}",
                    f"{sum(row.valid for row in some)}/{len(some)}",
                    number(mean([row.effort for row in good])),
                    number(ratio, 3),
                    number(mean([row.duration for row in good]), 3),
                    number(percentile(times, 0.5), 3),
                    number(percentile(times, 0.9), 3),
                ]
            )
    return result


def markdown(heads, body):
    """A Markdown table, the first two columns of which are text."""
    rule = ["---", "---"] + ["--:"] * (len(heads) - 2)
    return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in [heads, rule, *body])


def machine():
    """The machine and the versions, in a sentence."""
    cpu = next((line.split(":")[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")), "?")
    versions = ", ".join(f"{name} {importlib.metadata.version(name)}" for name in PACKAGES)
    compiler = subprocess.run(["gcc", "-dumpfullversion"], capture_output=True, text=True).stdout.strip()
    commit = ["git", "-C", str(REPOSITORY), "rev-parse", "--short", "HEAD"]
    commit = subprocess.run(commit, capture_output=True, text=True).stdout.strip()
    own = subprocess.run([AGHF, "--version"], capture_output=True, text=True).stdout.strip()
    date = datetime.date.today().isoformat()
    return (
        f"{own} at {commit}, {versions}, Python {platform.python_version()}, gcc {compiler}, on one core of {cpu}, "
        f"{date}; load at the end {os.getloadavg()[1]:.1f} on {os.cpu_count()} cores, so other work ran beside where "
        "it is above 1."
    )


def failures(rows):
    """A line for each row that is not a success or not valid, for the first of them."""
    bad = [row for row in rows if not (row.success and row.valid)]
    for row in bad[:MOST_FAILURES]:
        what = "valid" if row.valid else "not valid"
        yield f"{row.scenario}, {row.method}: final error {number(row.error, 2)}, {what}" + (
            f"; {row.note}" if row.note else ""
        )
    if len(bad) > MOST_FAILURES:
        yield f"{len(bad) - MOST_FAILURES} others, in `results.csv`"


def sections(table, notes):
    """Title, text, tables and failures of each section that has rows or notes."""
    for name, title in TITLES.items():
        rows = [row for row in table.rows if row.section == name]
        if rows:
            yield title, notes.get(name, ""), lines(rows), list(failures(rows))


COLUMNS = (
    "Success: the forward simulation of the paper, with its feedback, ends within 0.05 of the goal "
    "(MotionBenchMaker: valid). Valid: `aghf judge` accepts the table of the motion. Effort is the integral "
    'of |u|², the mean over successes; "of the best" the geometric mean of the ratio to the least effort that '
    "any method of the section found for the same scenario. Times are of the solves alone, the median of "
    "repeated ones for each scenario; 50th and 90th percentile over the scenarios, by nearest rank."
)


def write(table, notes, folder, command, extra=""):
    """Writes RESULTS.md and index.html beside the rows."""
    text = [f"# Side by side\n\n`{command}`: {machine()}\n\n{COLUMNS}\n"]
    for title, note, body, bad in sections(table, notes):
        text.append(f"## {title}\n\n{note}\n\n{markdown(HEADS, body)}\n")
        if bad:
            text.append("Not a success, or not valid:\n\n" + "\n".join(f"- {line}" for line in bad) + "\n")
    if extra:
        text.append(f"## Dynamics\n\n{extra}\n")
    (folder / "RESULTS.md").write_text("\n".join(text))
    (folder / "index.html").write_text(page(table, notes, command, extra))


STYLE = (
    "body{font:15px/1.5 system-ui,sans-serif;margin:2em auto;max-width:70em;padding:0 1em;color-scheme:light dark}"
    "table{border-collapse:collapse;margin:1em 0}"
    "td,th{padding:.2em .7em;border-bottom:1px solid #8884;text-align:right}"
    "td:nth-child(-n+2),th:nth-child(-n+2){text-align:left}"
    ".scroll{overflow-x:auto}text{font-size:12px;fill:currentColor}"
)
COLOURS = ["#2266cc", "#66aaee", "#dd7700", "#229944", "#bb3355", "#8855bb", "#888800", "#008899", "#666666"]


def plot(rows):
    """Effort relative to the best of each scenario against time, a point for each success, both logarithmic: SVG."""
    best = {}
    for row in rows:
        if row.success and row.effort > 0:
            best[row.scenario] = min(best.get(row.scenario, math.inf), row.effort)
    methods = list(dict.fromkeys(row.method for row in rows))
    points = [
        (row, 1e3 * row.seconds, row.effort / best[row.scenario]) for row in rows if row.success and row.effort > 0
    ]
    points = [point for point in points if point[1] > 0]
    if not points:
        return ""
    ends = lambda values: (math.floor(math.log10(min(values))), math.ceil(math.log10(max(values)) + 1e-9))
    (x0, x1), (y0, y1) = ends([p[1] for p in points]), (0, max(ends([p[2] for p in points])[1], 1))
    x = lambda value: 60 + 560 * (math.log10(value) - x0) / (x1 - x0)
    y = lambda value: 300 - 270 * (math.log10(value) - y0) / (y1 - y0)
    parts = ['<svg viewBox="0 0 900 350" width="900" role="img" aria-label="effort against time">']
    for k in range(x0, x1 + 1):
        parts.append(f'<line x1="{x(10.0**k):.0f}" x2="{x(10.0**k):.0f}" y1="30" y2="300" stroke="#8884"/>')
        parts.append(f'<text x="{x(10.0**k):.0f}" y="317" text-anchor="middle">{10.0**k:g}</text>')
    for k in range(y0, y1 + 1):
        parts.append(f'<line x1="60" x2="620" y1="{y(10.0**k):.0f}" y2="{y(10.0**k):.0f}" stroke="#8884"/>')
        parts.append(f'<text x="52" y="{y(10.0**k) + 4:.0f}" text-anchor="end">{10.0**k:g}</text>')
    parts.append('<text x="340" y="340" text-anchor="middle">solve, ms</text>')
    parts.append('<text x="60" y="18">effort / least effort found</text>')
    for row, time, ratio in points:
        colour = COLOURS[methods.index(row.method) % len(COLOURS)]
        tip = html.escape(f"{row.scenario}, {row.method}: {time:.3g} ms, effort {row.effort:.4g}")
        parts.append(
            f'<circle cx="{x(time):.1f}" cy="{y(ratio):.1f}" r="4" fill="{colour}" fill-opacity=".7">'
            f"<title>{tip}</title></circle>"
        )
    for i, method in enumerate(methods):
        parts.append(f'<circle cx="645" cy="{40 + 20 * i}" r="5" fill="{COLOURS[i % len(COLOURS)]}"/>')
        parts.append(f'<text x="656" y="{44 + 20 * i}">{html.escape(method)}</text>')
    return "".join(parts) + "</svg>"


def table_html(heads, body):
    """An HTML table."""
    line = lambda cells, tag: "<tr>" + "".join(f"<{tag}>{html.escape(str(cell))}</{tag}>" for cell in cells) + "</tr>"
    return (
        '<div class="scroll"><table>'
        + line(heads, "th")
        + "".join(line(cells, "td") for cells in body)
        + "</table></div>"
    )


def marked(text):
    """Text with `code` as HTML."""
    return re.sub(r"`([^`]*)`", r"<code>\1</code>", html.escape(text))


def from_markdown(text):
    """HTML of a text that has paragraphs and Markdown tables and nothing else."""
    parts = []
    for block in text.strip().split("\n\n"):
        if block.startswith("|"):
            cells = [[cell.strip() for cell in line.strip().strip("|").split("|")] for line in block.splitlines()]
            parts.append(table_html(cells[0], cells[2:]))
        else:
            parts.append(f"<p>{marked(block.lstrip('# '))}</p>")
    return "".join(parts)


def page(table, notes, command, extra):
    """One page that needs nothing else."""
    parts = ["<!doctype html><html lang=en><meta charset=utf-8><meta name=viewport content='width=device-width'>"]
    parts.append(f"<title>aghf side by side</title><style>{STYLE}</style><h1>Side by side</h1>")
    parts.append(f"<p>{marked(f'`{command}`: ' + machine())}</p><p>{marked(COLUMNS)}</p>")
    for (title, note, body, bad), name in zip(
        sections(table, notes), [k for k in TITLES if any(r.section == k for r in table.rows)]
    ):
        parts.append(f"<h2>{title}</h2><p>{marked(note)}</p>{table_html(HEADS, body)}")
        parts.append(plot([row for row in table.rows if row.section == name]))
        if bad:
            items = "".join(f"<li>{marked(line)}</li>" for line in bad)
            parts.append(
                f"<details><summary>{len(bad)} not a success, or not valid</summary><ul>{items}</ul></details>"
            )
    if extra:
        parts.append(f"<h2>Dynamics</h2>{from_markdown(extra)}")
    return "\n".join(parts) + "</html>\n"
