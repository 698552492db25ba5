"""Shows a motion in the viser visualiser of Pinocchio, at the address it prints.

    python pinocchio_viser.py [SCENARIO] [--once]

``--once`` plays the motion once and ends. Shapes are those of the URDF, where it has any.
"""

import sys
import tempfile
import time
from pathlib import Path

import pinocchio
from pinocchio.visualize import ViserVisualizer

import aghf

once = "--once" in sys.argv
scenario = next((argument for argument in sys.argv[1:] if not argument.startswith("--")), "kinova_table_01")
solution = aghf.solve(scenario)
with tempfile.TemporaryDirectory() as folder:
    urdf = Path(folder) / "robot.urdf"
    urdf.write_text(solution.model.to_urdf(), encoding="utf-8")
    robot = pinocchio.RobotWrapper.BuildFromURDF(str(urdf), [folder])
display = ViserVisualizer(robot.model, robot.collision_model, robot.collision_model)
display.initViewer(open=False)
display.loadViewerModel()
FRAMES_PER_SECOND = 30
motion = solution.sample(int(solution.horizon * FRAMES_PER_SECOND) + 1)
frames = aghf.pinocchio_configuration(robot.model, motion.q)
while True:
    for q in frames:
        display.display(q)
        if not once:
            time.sleep(1 / FRAMES_PER_SECOND)
    if once:
        break
print(f"{len(frames)} frames shown of {solution}")
