"""Paths, robots, scenarios, our own program, the judge, the simulation of the paper and rows of results, for all
sections."""

import csv
import json
import math
import os
import subprocess
import tempfile
import time
import xml.etree.ElementTree as ElementTree
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path

import numpy as np
import pinocchio as pin
from scipy.integrate import solve_ivp
from scipy.interpolate import BPoly, interp1d

HERE = Path(__file__).resolve().parent
REPOSITORY = HERE.parents[1]
WORK = REPOSITORY / "target" / "peers"
AGHF = REPOSITORY / "target" / "release" / "aghf"
ROBOTS = REPOSITORY / "robots"
# One thread for everything that is timed.
ONE_CORE = {name: "1" for name in ("RAYON_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}


@dataclass
class Row:
    """One method on one scenario."""

    section: str
    family: str
    scenario: str
    method: str
    settings: str = ""
    # By the section's definition, and by `aghf judge`.
    success: bool = False
    valid: bool = False
    effort: float = math.nan
    cost: float = math.nan
    duration: float = math.nan
    # Seconds of the solve alone, over `repeats` solves.
    seconds: float = math.nan
    seconds_90: float = math.nan
    repeats: int = 0
    error: float = math.nan
    iterations: int = 0
    note: str = ""


class Table:
    """Rows in a CSV file, written one by one, so that a run that was interrupted goes on where it was."""

    def __init__(self, path, resume=False):
        self.path, self.rows = Path(path), []
        if resume and self.path.exists():
            with open(self.path, newline="") as file:
                self.rows = [parsed(entry) for entry in csv.DictReader(file)]
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self.write()

    def has(self, section, scenario, method, settings=""):
        """Returns true if there is such a row already."""
        wanted = (section, scenario, method, settings)
        return any((row.section, row.scenario, row.method, row.settings) == wanted for row in self.rows)

    def add(self, row):
        """Adds a row, prints it and writes the file."""
        self.rows.append(row)
        line = f"{row.scenario:22} {row.method:34} {'success' if row.success else 'FAILED ':8} "
        line += f"{'valid' if row.valid else 'INVALID':8} effort {row.effort:10.4g}  "
        line += f"{1e3 * row.seconds:9.1f} ms  {row.note}"
        print(line, flush=True)
        self.write()

    def write(self):
        """Replaces the file at once, so that an interruption leaves the old or the new one."""
        partial = self.path.with_suffix(".part")
        with open(partial, "w", newline="") as file:
            writer = csv.DictWriter(file, [column.name for column in fields(Row)], lineterminator="\n")
            writer.writeheader()
            writer.writerows({key: text_of(value) for key, value in asdict(row).items()} for row in self.rows)
        os.replace(partial, self.path)


def text_of(value):
    """A number with seven digits, anything else as it is."""
    return f"{value:.7g}" if isinstance(value, float) else value


def parsed(entry):
    """A row of the CSV file with the types of `Row`."""
    kinds = {column.name: column.type for column in fields(Row)}
    read = {bool: lambda text: text == "True", float: float, int: int, str: str}
    return Row(**{key: read[kinds[key]](value) for key, value in entry.items()})


@dataclass
class Motion:
    """Samples of a motion: times, and positions, velocities, accelerations and torques, a row for each time."""

    t: np.ndarray
    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    u: np.ndarray
    # Whether torques hold until the next sample or change linearly.
    hold: bool = False
    names: list = field(default_factory=list)

    def effort(self):
        """The integral of the squared torques."""
        squares = (self.u**2).sum(axis=1)
        return float((squares[:-1] * np.diff(self.t)).sum() if self.hold else np.trapezoid(squares, self.t))


def percentile(values, share):
    """The smallest value that at least `share` of all do not exceed."""
    ascending = sorted(values)
    return ascending[max(math.ceil(share * len(ascending)) - 1, 0)] if ascending else math.nan


def aghf(*arguments, check=True):
    """The standard output of our program on one core."""
    run = subprocess.run([AGHF, *map(str, arguments)], capture_output=True, text=True, env={**os.environ, **ONE_CORE})
    if check and run.returncode not in (0, 1, 3):
        raise RuntimeError(f"aghf {' '.join(map(str, arguments))}: {run.stderr.strip()}")
    return run.stdout


def scenario(name):
    """A scenario as a dictionary with every key, and the file it is in (`file`)."""
    folder = WORK / "scenarios"
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.json"
    if name == "pendulum_6_swingup":
        # The paper has six pendulums, our scenarios five: the sixth is made like the others.
        values = json.loads(aghf("scenarios", "pendulum_5_swingup"))
        values.update(robot="pendulum_6", q_start=[-math.pi / 2] + 5 * [0.0], q_goal=[math.pi / 2] + 5 * [0.0])
        values.update(v_start=6 * [0.0], v_goal=6 * [0.0])
        text = json.dumps(values)
    else:
        text = aghf("scenarios", name)
    path.write_text(text)
    return {**json.loads(text), "file": path, "name": name}


def robot(name):
    """A built-in robot as a Pinocchio model whose positions are one number per joint, without friction, damping and
    meshes."""
    tree = ElementTree.parse(ROBOTS / name / f"{name}.urdf")
    for joint in tree.iter("joint"):
        for dynamics in joint.findall("dynamics"):
            joint.remove(dynamics)
        if joint.get("type") == "continuous":
            joint.set("type", "revolute")
            limit = joint.find("limit")
            if limit is None:
                limit = ElementTree.SubElement(joint, "limit", effort="1e9", velocity="1e9")
            limit.set("lower", "-1e9")
            limit.set("upper", "1e9")
    for link in tree.iter("link"):
        for child in link.findall("visual") + link.findall("collision"):
            link.remove(child)
    model = pin.buildModelFromXML(ElementTree.tostring(tree.getroot(), encoding="unicode"))
    assert model.nq == model.nv, f"{name}: joints of more than one coordinate"
    return model


def check_dynamics(model, name):
    """Refuses to go on unless Pinocchio and our program have the same inverse dynamics."""
    random = np.random.default_rng(7)
    q, v, a = random.normal(size=(3, model.nv))
    with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
        json.dump({"q": list(q), "v": list(v), "a": list(a)}, file)
        file.flush()
        result = json.loads(aghf("eval", name, file.name))
    ours = np.array(result["inverse_dynamics"])
    theirs = pin.rnea(model, model.createData(), q, v, a)
    off = abs(ours - theirs).max() / abs(theirs).max()
    assert off < 1e-9, f"{name}: inverse dynamics differ by {off:.1e}, relative"


def gains(name):
    """The gains of the paper's forward simulation, for positions and for velocities alike."""
    return 100.0 if name.startswith("digit") else 10.0


def simulated(model, motion, goal, gain):
    """Forward simulation with feedback, the paper's measure of success: the largest entry of the final state's error,
    and the motion.

    The torques of the motion and `-gain` times what position and velocity are off drive the model without friction;
    implicit
    steps of variable order (BDF) with the analytic Jacobian.
    """
    data, n = model.createData(), model.nv
    if not all(np.isfinite(x).all() for x in (motion.q, motion.v, motion.a, motion.u)):
        return math.inf, None
    if motion.hold:
        lines = [interp1d(motion.t, x, axis=0, assume_sorted=True) for x in (motion.q, motion.v)]
        steps = interp1d(motion.t, motion.u, axis=0, kind="previous", assume_sorted=True)
        wanted = lambda t: (lines[0](t), lines[1](t), steps(t))
    else:
        # Of a smooth motion the curve of degree five through the samples and its own torques: between samples linear
        # torques are
        # off by enough to matter, as these arms drift away from any curve.
        some = np.unique(np.linspace(0, len(motion.t) - 1, 401).round().astype(int))
        curve = BPoly.from_derivatives(
            motion.t[some], np.stack([motion.q[some], motion.v[some], motion.a[some]], axis=1)
        )
        curves = [curve, curve.derivative(), curve.derivative(2)]

        def wanted(t):
            q, v, a = (x(t) for x in curves)
            return q, v, pin.rnea(model, data, q, v, a)

    def applied(t, x):
        q, v, u = wanted(t)
        return u - gain * (x[:n] - q) - gain * (x[n:] - v)

    def rate(t, x):
        return np.r_[x[n:], pin.aba(model, data, x[:n], x[n:], applied(t, x))]

    def jacobian(t, x):
        pin.computeABADerivatives(model, data, x[:n], x[n:], applied(t, x))
        inverse = np.triu(data.Minv) + np.triu(data.Minv, 1).T
        below = np.hstack([data.ddq_dq - gain * inverse, data.ddq_dv - gain * inverse])
        return np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), below])

    began = np.r_[motion.q[0], motion.v[0]]
    # The torques that are held jump: no step may be much longer than they are held.
    step = max(2e-3, 2 * (motion.t[1] - motion.t[0])) if motion.hold else 2e-2
    options = {"method": "BDF", "jac": jacobian, "rtol": 1e-7, "atol": 1e-9, "max_step": step}
    times = np.linspace(motion.t[0], motion.t[-1], 2001)
    run = solve_ivp(rate, (motion.t[0], motion.t[-1]), began, t_eval=times, **options)
    if not run.success:
        return math.inf, None
    x = run.y.T
    u = np.array([applied(t, state) for t, state in zip(times, x)])
    a = np.array([pin.aba(model, data, state[:n], state[n:], torques) for state, torques in zip(x, u)])
    return float(abs(x[-1] - goal).max()), Motion(times, x[:, :n], x[:, n:], a, u, names=motion.names)


def judge(scenario_file, motion, tolerance=1e-3, overlap=1e-4, kinds="qvau"):
    """The verdict of `aghf judge` on a motion, and the checks that fail with their worst values."""
    with tempfile.TemporaryDirectory() as folder:
        table, verdict = Path(folder) / "trajectory.csv", Path(folder) / "verdict.json"
        rows = np.hstack([motion.t[:, None], *(getattr(motion, kind) for kind in kinds)])
        heads = ["t"] + [f"{kind}_{joint}" for kind in kinds for joint in motion.names]
        np.savetxt(table, rows, delimiter=",", header=",".join(heads), comments="", fmt="%.17g")
        options = ["--tolerance", tolerance, "--overlap", overlap, "--json", verdict]
        aghf("judge", scenario_file, table, *options)
        if not verdict.exists():
            return False, "the judge could not read it"
        return verdict_of(json.loads(verdict.read_text()))


def verdict_of(verdict):
    """The outcome of a verdict of the judge, and the checks that are not passed."""
    bad = [check for check in verdict["checks"] if check["outcome"] in ("fail", "undecided", "not_checked")]
    return verdict["valid"], "; ".join(f"{c['check']} {c.get('value', math.nan):.3g}" for c in bad)


def read_motion(path):
    """A trajectory that `aghf solve` wrote."""
    with open(path) as file:
        heads = file.readline().strip().split(",")
        rows = np.loadtxt(file, delimiter=",", ndmin=2)
    pick = lambda kind: rows[:, [i for i, head in enumerate(heads) if head.startswith(kind + "_")]]
    names = [head[2:] for head in heads if head.startswith("q_")]
    return Motion(rows[:, 0], pick("q"), pick("v"), pick("a"), pick("u"), names=names)


def ours(values, options, repeats):
    """Our solver on a scenario: the summary, the seconds of `repeats` solves, and the motion at 2001 times."""
    with tempfile.TemporaryDirectory() as folder:
        threads = [] if "flow" in options else ["--threads", 1]
        common = [
            "solve",
            values["file"],
            *threads,
            "--json",
            "--no-report",
            "--force",
            "--out",
            folder,
            "--samples",
            2001,
        ]
        runs = [json.loads(aghf(*common, *options)) for _ in range(repeats)]
        name = "trajectory.csv" if runs[0]["success"] else "trajectory.failed.csv"
        path = Path(folder) / name
        motion = read_motion(path) if path.exists() else None
    return runs[0], [run["solve_seconds"] for run in runs], motion


def add_ours(table, section, family, values, method, options, repeats, tolerance=1e-3):
    """A row of our own on a scenario."""
    if table.has(section, values["name"], method):
        return
    summary, seconds, motion = ours(values, options, repeats)
    row = Row(section, family, values["name"], method, repeats=len(seconds), duration=values["horizon_s"])
    row.seconds, row.seconds_90 = percentile(seconds, 0.5), percentile(seconds, 0.9)
    row.iterations = summary.get("iterations") or 0
    finish(row, values, motion, tolerance)
    table.add(row)


def finish(row, values, motion, tolerance=1e-3):
    """Fills in the quantities that are measured in the same way for all methods.

    Knots with torques that are held define no motion between them: for those the judge gets positions and velocities of
    the simulated motion, with its feedback, and derives the rest, since accelerations jump with the torques.
    """
    if motion is None or not np.isfinite(motion.u).all():
        row.note = row.note or "no motion"
        return
    model = robot(values["robot"])
    goal = np.r_[values["q_goal"], values["v_goal"]]
    row.duration = float(motion.t[-1] - motion.t[0])
    row.effort = motion.effort()
    weight = values.get("objective", {}).get("acceleration", 0.0)
    squares = (motion.a**2).sum(axis=1)
    row.cost = row.effort + weight * float(np.trapezoid(squares, motion.t))
    row.error, driven = simulated(model, motion, goal, gains(values["robot"]))
    row.success = bool(row.error < values["success_threshold"])
    judged = driven if motion.hold else motion
    row.valid, fault = (
        judge(values["file"], judged, tolerance, kinds="qv" if motion.hold else "qvau")
        if judged
        else (False, "the simulation fails")
    )
    row.note = "; ".join(filter(None, [row.note, fault]))


def timed(function, *arguments):
    """The result of a function, and the seconds it took."""
    began = time.perf_counter()
    result = function(*arguments)
    return result, time.perf_counter() - began
