"""Kinova with and without losses: efforts, and MuJoCo that follows the torques alone.

    cargo build --release && pip install mujoco
    python3 benches/losses.py [--aghf target/release/aghf]

Each scenario is solved as it is, with the damping and friction of the URDF, and with an armature of 0.1 kg m^2 too. The
last motion of the main job is replayed in MuJoCo with the same damping and armature, at 1 kHz and by feedforward alone,
once with the smooth friction of the motion as an external force, and once with MuJoCo's `frictionloss`, which is dry.
"""

import argparse
import csv
import json
import subprocess
import tempfile
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "robots/kinova_gen3"
SCENARIOS = [*(f"kinova_free_0{i}" for i in range(1, 6)), "kinova_table_01"]
ARMATURE, WIDTH, STEP = 0.1, 0.02, 1e-3
LOSSES = {"none": False, "URDF": True, "armature": {"armature": ARMATURE, "friction_velocity": WIDTH}}


def solve(aghf: str, name: str, losses, out: Path) -> dict:
    """The summary of a scenario with these losses, whose limits of torque do not count."""
    scenario = json.loads((FOLDER / f"{name}.json").read_text()) | {"losses": losses}
    scenario["enforced_limits"] = scenario.get("enforced_limits", {}) | {"torque": False}
    path = out / f"{name}.json"
    path.write_text(json.dumps(scenario))
    subprocess.run([aghf, "solve", path, "--out", out / "run"], check=True, capture_output=True)
    return json.loads((out / "run/summary.json").read_text())


def table(aghf: str, run: Path) -> np.ndarray:
    """`t, q, v, a, u` of a motion at 1 kHz."""
    rows = run / "sampled.csv"
    command = [aghf, "sample", run / "summary.json", "--rate", str(round(1 / STEP)), "--out", rows]
    subprocess.run(command, check=True, capture_output=True)
    lines = [line for line in rows.read_text().splitlines() if not line.startswith("#")]
    return np.array([[float(x) for x in row] for row in list(csv.reader(lines))[1:]])


def replay(rows: np.ndarray, dry: bool) -> float:
    """The largest error of a position, rad."""
    import mujoco

    n = (rows.shape[1] - 1) // 4
    t, q, v, _, u = np.split(rows, [1, 1 + n, 1 + 2 * n, 1 + 3 * n], axis=1)
    specification = mujoco.MjSpec.from_file(str(FOLDER / "kinova_gen3.urdf"))
    specification.compiler.balanceinertia = False
    for geometry in specification.geoms:
        geometry.contype = geometry.conaffinity = 0
    friction = np.array([joint.frictionloss for joint in specification.joints])
    for joint in specification.joints:
        joint.armature, joint.limited = ARMATURE, False
        joint.frictionloss = joint.frictionloss if dry else 0.0
    specification.option.timestep = STEP
    specification.option.integrator = mujoco.mjtIntegrator.mjINT_RK4
    world = specification.compile()
    data = mujoco.MjData(world)
    data.qpos[:], data.qvel[:] = q[0], v[0]
    worst = 0.0
    for i in range(len(t) - 1):
        x = data.qvel / WIDTH
        data.qfrc_applied[:] = 0.5 * (u[i] + u[i + 1]) - (0.0 if dry else friction * x / np.hypot(1, x))
        mujoco.mj_step(world, data)
        worst = max(worst, np.abs(q[i + 1] - data.qpos).max())
    return worst


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--aghf", default=str(ROOT / "target/release/aghf"))
    aghf = parser.parse_args().aghf
    print("| scenario | " + " | ".join(LOSSES) + " |\n| --- |" + " --- |" * len(LOSSES))
    for name in SCENARIOS:
        cells = []
        for losses in LOSSES.values():
            with tempfile.TemporaryDirectory() as folder:
                summary = solve(aghf, name, losses, Path(folder))
                cells.append(f"{summary['control_effort']:.1f}" if summary["success"] else "no motion")
                if name == SCENARIOS[-1]:
                    rows = table(aghf, Path(folder) / "run")
        print(f"| `{name}` | " + " | ".join(cells) + " |", flush=True)
    for dry in [False, True]:
        print(f"MuJoCo, {'dry' if dry else 'smooth'} friction: at most {replay(rows, dry):.1e} rad off")


if __name__ == "__main__":
    main()
