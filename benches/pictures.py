#!/usr/bin/env python3
"""Redraws the pictures of the guide, each where its page is: all of them, or the named ones.

    cargo build --release
    pip install matplotlib pin
    benches/pictures.py                  # all of them: a minute
    benches/pictures.py methods          # first_motion, obstacles, limits, objectives, goals, standing, certificates,
                                         # methods, degree
"""

import contextlib
import csv
import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib
import numpy as np
import pinocchio

matplotlib.use("svg")
from matplotlib import pyplot as plt  # noqa: E402

ROOT = Path(__file__).resolve().parents[1]
AGHF = Path(os.environ.get("AGHF_PROGRAM", ROOT / "target" / "release" / "aghf"))
DIGIT = ROOT / "robots" / "digit_v3_pinned"
GUIDE, SCENARIOS = ROOT / "src" / "guide", ROOT / "app" / "scenario" / "src" / "guide"

#: Text stays text, names in the file are reproducible, and the background is white in dark themes, too.
STYLE = {
    "svg.fonttype": "none",
    "svg.hashsalt": "aghf",
    "font.family": "sans-serif",
    "font.size": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#dddddd",
    "path.simplify_threshold": 0.5,
}
BLUE, ORANGE, GREEN, GREY = "#0072B2", "#D55E00", "#009E73", "#999999"

SWING = {
    "robot": "pendulum_3",
    "horizon_s": 2.0,
    "q_start": [0.0, 0.0, 0.0],
    "v_start": [0.0, 0.0, 0.0],
    "q_goal": [1.0, 0.5, 0.0],
    "v_goal": [0.0, 0.0, 0.0],
}


def aghf(folder, *words):
    """The output of a command in a folder, which may find no motion."""
    run = subprocess.run([AGHF, *words], cwd=folder, capture_output=True, text=True)
    if run.returncode not in (0, 3):
        sys.exit(f"aghf {' '.join(words)}: {run.stderr}")
    return run.stdout


def table(path):
    """The columns of a table of numbers by their names; other columns are left out."""
    with open(path, newline="") as file:
        head, *rows = csv.reader(line for line in file if not line.startswith("#"))
    columns = {}
    for name, column in zip(head, zip(*rows)):
        with contextlib.suppress(ValueError):
            columns[name] = np.array(column, dtype=float)
    return columns


def solved(scenario, *options):
    """The table of a motion by the names of its columns, and its summary; a failed one counts too."""
    with tempfile.TemporaryDirectory() as folder:
        if isinstance(scenario, dict):
            path = Path(folder) / "scenario.json"
            path.write_text(json.dumps(scenario))
            scenario = str(path)
        command = ["solve", scenario, "--json", "--no-report", "--out", "motion", "--samples", "201", *options]
        summary = json.loads(aghf(folder, *command))
        failed = "" if summary["success"] else ".failed"
        return table(Path(folder) / "motion" / f"trajectory{failed}.csv"), summary


def first_motion():
    """Velocities and torques of a motion of the Kinova, as shares of their limits."""
    rest = [0.0] * 7
    reach = {
        "robot": "kinova_gen3",
        "horizon_s": 2.0,
        "q_start": [0.0, 0.3, 0.0, 1.6, 0.0, 1.2, 0.0],
        "v_start": rest,
        "q_goal": [0.8, 0.6, 0.0, 1.2, 0.0, 1.0, 0.0],
        "v_goal": rest,
        "objective": {"units": "si", "time": 100.0},
        "free_horizon": {"shortest_s": 0.5, "longest_s": 5.0},
    }
    motion, _ = solved(reach)
    figure, axes = plt.subplots(1, 3, figsize=(8.4, 2.6), layout="constrained")
    for kind, title, ax in zip("qvu", ["q, rad", "v, rad/s", "u, N m"], axes):
        for i in range(1, 8):
            ax.plot(motion["t"], motion[f"{kind}_joint_{i}"], linewidth=1.4, label=f"joint_{i}")
        ax.set(xlabel="t, s", title=title)
    axes[0].legend(fontsize=7, ncols=2)
    return figure


def methods():
    """The second joint of the double pendulum along the flow and by the direct method."""
    name = "pendulum_2_swingup"
    figure, ax = plt.subplots(figsize=(6.4, 3.2), layout="constrained")
    for s, colour in [("1e-9", ORANGE), ("100", BLUE)]:
        motion, summary = solved(name, "--method", "flow", "--s-max", s)
        label = f"published flow, s_max = {s}: effort {summary['control_effort']:.0f}"
        ax.plot(motion["t"], motion["q_joint_2"], color=colour, label=label)
    motion, summary = solved(name, "--starts", "1")
    ax.plot(motion["t"], motion["q_joint_2"], color=GREEN, label=f"direct: effort {summary['control_effort']:.0f}")
    ax.set(xlabel="t, s", ylabel="q of joint_2, rad")
    ax.legend(fontsize=8)
    return figure


def obstacles():
    """Paths of the third joint of the pendulum with and without a sphere."""
    centre, radius = [-1.35, 0.0, 0.3], 0.15
    sphere = {"shape": {"sphere": {"radius_m": radius}}, "pose": {"position_m": centre}}
    clear = {**SWING, "obstacles": [sphere], "robot_shape": {"swept_links": {"radius_m": 0.05}}}
    figure, ax = plt.subplots(figsize=(4.6, 3.6), layout="constrained")
    for scenario, colour, label in [(SWING, BLUE, "free"), (clear, ORANGE, "clear of the sphere")]:
        motion, summary = solved(scenario)
        first = motion["q_joint_1"]
        second = first + motion["q_joint_2"]
        # Links point along -x and turn about y.
        x, z = -np.cos(first) - np.cos(second), np.sin(first) + np.sin(second)
        ax.plot(x, z, color=colour, label=f"{label}: effort {summary['control_effort']:.0f}")
    ax.add_patch(plt.Circle((centre[0], centre[2]), radius, color=GREY))
    ax.set(xlabel="x, m", ylabel="z, m", aspect="equal")
    ax.legend(fontsize=8)
    return figure


def limits():
    """Velocities and accelerations of the scenario of its page."""
    page = (SCENARIOS / "limits.md").read_text(encoding="utf-8")
    scenario = json.loads(re.search(r"```json\n(\{.*?)```", page, re.DOTALL)[1])
    enforced, motion = scenario["enforced_limits"], solved(scenario)[0]
    joints = json.loads(aghf(ROOT, "robots", scenario["robot"], "--json"))[0]["joints"]
    figure, (left, right) = plt.subplots(1, 2, figsize=(8.4, 2.8), layout="constrained")
    for i, joint in enumerate(joints):
        name = joint["name"]
        kept = name in enforced["velocity"]["joints"]
        share = np.abs(motion[f"v_{name}"]) / joint["velocity"]
        left.plot(motion["t"], share, color=[BLUE, ORANGE][i] if kept else GREY, label=name if kept else None)
        free = enforced["acceleration"][i] is None
        right.plot(motion["t"], motion[f"a_{name}"], color=ORANGE if free else GREY, label=name if free else None)
    left.axhline(enforced["velocity"]["share"], color="black", linestyle="--", linewidth=1)
    for sign in (1, -1):
        right.axhline(sign * enforced["acceleration"][0], color="black", linestyle="--", linewidth=1)
    left.set(xlabel="t, s", title="|v| / limit of the robot")
    right.set(xlabel="t, s", title="a, rad/s²")
    for ax in (left, right):
        ax.legend(fontsize=8)
    return figure


def objectives():
    """Effort against duration of the motions of a trade-off."""
    name = "limits_03"
    with tempfile.TemporaryDirectory() as folder:
        aghf(folder, "tradeoff", name, "--out", "tradeoff")
        motions = table(Path(folder) / "tradeoff" / "tradeoff.csv")
        scenario = json.loads(aghf(folder, "scenarios", name))
    balanced = solved({**scenario, "objective": "balanced"})[1]
    figure, ax = plt.subplots(figsize=(6.4, 3.0), layout="constrained")
    ax.plot(motions["duration_s"], motions["control_effort"], "o-", color=BLUE, markersize=4, label="trade-off")
    ends = [("least time", motions["duration_s"][0], motions["control_effort"][0])]
    ends += [("balanced", balanced["horizon_s"], balanced["control_effort"])]
    ends += [("least effort", motions["duration_s"][-1], motions["control_effort"][-1])]
    for (label, duration, effort), colour in zip(ends, [ORANGE, GREEN, GREY]):
        ax.plot(duration, effort, "o", color=colour, markersize=9, label=f"{label}: {duration:.2f} s, {effort:.0f}")
    ax.set(xlabel="duration, s", ylabel="effort, N² m² s")
    ax.legend(fontsize=8)
    return figure


def goals():
    """The bar that two arms lift over a post, from the side and from above, by Pinocchio."""
    folder = ROOT / "robots" / "kinova_gen3_2arms"
    model = pinocchio.buildModelFromUrdf(str(folder / "kinova_gen3_2arms.urdf"))
    data, motion = model.createData(), solved("two_arms_bar_01")[0]
    hands = [model.getFrameId(f"arm_{arm}_end_effector_link") for arm in (1, 2)]
    places = []
    for k in range(len(motion["t"])):
        q = pinocchio.neutral(model)
        for name, joint in zip(model.names[1:], model.joints[1:]):
            angle = motion[f"q_{name}"][k]
            # A joint without limits has a cosine and a sine there.
            q[joint.idx_q : joint.idx_q + joint.nq] = angle if joint.nq == 1 else [np.cos(angle), np.sin(angle)]
        pinocchio.framesForwardKinematics(model, data, q)
        places.append([data.oMf[hand].translation.copy() for hand in hands])
    places = np.array(places)
    post = json.loads((folder / "two_arms_bar_01.json").read_text())["obstacles"][1]
    (x, y, z), shape = post["pose"]["position_m"], post["shape"]["cylinder"]
    radius, half = shape["radius_m"], shape["length_m"] / 2
    figure, (side, above) = plt.subplots(1, 2, figsize=(6.4, 3.2), layout="constrained")
    for ax, axis in ((side, 2), (above, 1)):
        for hand, colour in ((0, BLUE), (1, ORANGE)):
            ax.plot(places[:, hand, 0], places[:, hand, axis], color=colour, label=f"hand of arm {hand + 1}")
        for pair in places[::20]:
            ax.plot(pair[:, 0], pair[:, axis], color=GREY, linewidth=1.4)
    side.add_patch(plt.Rectangle((x - radius, z - half), 2 * radius, 2 * half, color="#dddddd"))
    above.add_patch(plt.Circle((x, y), radius, color="#dddddd"))
    side.set(xlabel="x, m", ylabel="z, m", title="from the side", aspect="equal")
    above.set(xlabel="x, m", ylabel="y, m", title="from above", aspect="equal")
    side.legend(fontsize=8)
    return figure


def certificates():
    """The reserves of the promises of a motion on the intervals of its certificate."""
    with tempfile.TemporaryDirectory() as folder:
        aghf(folder, "solve", "limits_01", "--no-report", "--out", "run")
        aghf(folder, "certify", "limits_01", "run", "--out", "certificate.json")
        certificate = json.loads((Path(folder) / "certificate.json").read_text())
        curve = json.loads((Path(folder) / "run" / "summary.json").read_text())["curve"]
    segments, horizon = curve["segments"], curve["horizon_s"]
    figure, ax = plt.subplots(figsize=(6.4, 3.0), layout="constrained")
    for number, (promise, colour) in enumerate(zip(certificate["promises"], [BLUE, ORANGE, GREEN])):
        edges, reserves = [], []
        for segment, begin, end, least, _ in certificate["intervals"]:
            edges += [horizon * (segment + (1 + time) / 2) / segments for time in (begin, end)]
            reserves += 2 * [least[number]]
        ax.plot(edges, reserves, color=colour, label=promise)
    ax.set(xlabel="t, s", ylabel="least reserve / limit", yscale="log")
    ax.legend(fontsize=8)
    return figure


def standing():
    """The centre of pressure of Digit's step and stretch, pinned to the ground and on its sole, by Pinocchio."""
    model = pinocchio.buildModelFromUrdf(str(DIGIT / "digit_v3_pinned.urdf"), pinocchio.JointModelFreeFlyer())
    data, still = model.createData(), np.zeros(6)

    def centre(motion):
        """The centre of pressure at all times, m."""
        joints = [name for name in model.names if f"q_{name}" in motion]
        places = [model.joints[model.getJointId(joint)] for joint in joints]
        found = []
        for k in range(len(motion["t"])):
            q, v, a = pinocchio.neutral(model), np.zeros(model.nv), np.zeros(model.nv)
            for joint, place in zip(joints, places):
                q[place.idx_q] = motion[f"q_{joint}"][k]
                v[place.idx_v], a[place.idx_v] = motion[f"v_{joint}"][k], motion[f"a_{joint}"][k]
            v[:6] = a[:6] = still
            _, _, fz, mx, my, _ = pinocchio.rnea(model, data, q, v, a)[:6]
            found.append((-my / fz, mx / fz))
        return np.array(found).T

    figure, axes = plt.subplots(1, 2, figsize=(8.4, 2.8), layout="constrained", sharex=True, sharey=True)
    for ax, motion in zip(axes, ["step", "stretch"]):
        for kind, colour, label in [("free", ORANGE, "pinned"), ("stand", BLUE, "on its sole")]:
            columns, summary = solved(str(DIGIT / f"digit_{kind}_{motion}.json"))
            ax.plot(*centre(columns), color=colour, linewidth=1.4,
                    label=f"{label}: effort {summary['control_effort']:.0f}")
        ax.add_patch(plt.Rectangle((-0.1175, -0.04), 0.235, 0.08, fill=False, color="black"))
        # Where the pinned foot pulls at the ground its centre of pressure is anywhere.
        ax.set(title=motion, xlabel="along the foot, m", aspect="equal", xlim=(-0.6, 0.6), ylim=(-0.25, 0.25))
        ax.legend(fontsize=8)
    axes[0].set(ylabel="across, m")
    return figure


def degree():
    """Effort of the swing-ups of three to five links against the degree, relative to the least."""
    degrees = [8, 10, 12, 14, 16, 20, 24, 28, 32, 40, 48]
    figure, ax = plt.subplots(figsize=(6.4, 3.0), layout="constrained")
    for links, colour in [(3, BLUE), (4, ORANGE), (5, GREEN)]:
        name = f"pendulum_{links}_swingup"
        efforts = np.array([solved(name, "--degree", str(p))[1]["control_effort"] for p in degrees])
        ax.plot(degrees, efforts / efforts.min(), "o-", color=colour, label=f"{links} links, least {efforts.min():.0f}")
    ax.set(xlabel="degree", ylabel="effort / least", yscale="log")
    ax.set_yticks([1, 1.5, 2, 3, 5], ["1", "1.5", "2", "3", "5"])
    ax.minorticks_off()
    ax.legend(fontsize=8)
    return figure


def written(name, figure):
    """Writes an SVG for inclusion in a page of rustdoc: no declaration, no metadata, no empty line."""
    folder = GUIDE if name in ("methods", "degree") else SCENARIOS
    path = folder / "pictures" / f"{name}.svg"
    figure.savefig(path, metadata={"Date": None, "Creator": None}, facecolor="white")
    plt.close(figure)
    text = path.read_text(encoding="utf-8")
    text = text[text.index("<svg") :]
    text = re.sub(r" <metadata>.*?</metadata>\n", "", text, flags=re.DOTALL)
    text = re.sub(r" <style type.*?</style>", "", text, count=1, flags=re.DOTALL)
    text = re.sub(r"<!--.*?-->\n?", "", text, flags=re.DOTALL)
    text = re.sub(r'^<svg [^>]*?width="([0-9.]+)pt" height="([0-9.]+)pt"', svg_head, text)
    lines = [line.rstrip() for line in text.splitlines() if line.strip()]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def svg_head(found):
    """The head of a picture that scales with its page."""
    return found[0].replace(f'width="{found[1]}pt" height="{found[2]}pt"', f'width="{float(found[1]):.0f}"')


def main():
    all_of_them = [first_motion, obstacles, limits, objectives, goals, standing, certificates, methods, degree]
    known = {function.__name__: function for function in all_of_them}
    unknown = [name for name in sys.argv[1:] if name not in known]
    if unknown:
        sys.exit(f"no picture {', '.join(unknown)}: there are {', '.join(known)}")
    plt.rcParams.update(STYLE)
    for name in sys.argv[1:] or known:
        written(name, known[name]())


if __name__ == "__main__":
    main()
