"""MuJoCo as an independent judge: our motion, replayed in its simulation with a controller.

The torques of the motion and a feedback on positions and velocities drive the robot; MuJoCo knows nothing of
the motion but them.

    pip install mujoco
    python python/examples/mujoco_replay.py [SCENARIO]
"""

import sys

import mujoco
import numpy as np

import aghf

STEP = 5e-4
KP, KV = 100.0, 20.0


def specification_of(model: aghf.Model) -> mujoco.MjSpec:
    """The robot in MuJoCo: masses and joints of the URDF, no contacts and no losses, integrated by Runge and Kutta."""
    specification = mujoco.MjSpec.from_string(model.to_urdf())
    specification.compiler.discardvisual = True
    # Links may weigh as little as they say; what they touch is the planner's affair here.
    specification.compiler.balanceinertia = False
    for geometry in specification.geoms:
        geometry.contype = geometry.conaffinity = 0
    for joint in specification.joints:
        joint.damping[:], joint.frictionloss, joint.limited = 0.0, 0.0, False
    specification.option.timestep = STEP
    specification.option.integrator = mujoco.mjtIntegrator.mjINT_RK4
    specification.option.gravity = model.gravity
    return specification


def order_of(model: aghf.Model, world: mujoco.MjModel) -> list[int]:
    """The places of the joints of a model among those of MuJoCo."""
    names = [mujoco.mj_id2name(world, mujoco.mjtObj.mjOBJ_JOINT, i) for i in range(world.njnt)]
    return [names.index(name) for name in model.joint_names]


def replay(solution: aghf.Solution) -> tuple[float, float]:
    """The error at the end, rad or rad/s, and the largest on the way, rad."""
    model = solution.model
    world = specification_of(model).compile()
    order = order_of(model, world)
    data = mujoco.MjData(world)
    steps = int(np.ceil(solution.horizon / STEP))
    world.opt.timestep = solution.horizon / steps
    motion = solution.evaluate(np.linspace(0.0, solution.horizon, steps + 1))
    data.qpos[order], data.qvel[order] = motion.q[0], motion.v[0]
    worst = 0.0
    for i in range(steps):
        off = motion.q[i] - data.qpos[order]
        rate = motion.v[i] - data.qvel[order]
        # Accelerations that bring it back, as torques of this state.
        h = aghf.crba(model, data.qpos[order])
        middle = 0.5 * (motion.tau[i] + motion.tau[i + 1])
        data.qfrc_applied[order] = middle + h @ (KP * off + KV * rate)
        mujoco.mj_step(world, data)
        worst = max(worst, np.abs(motion.q[i + 1] - data.qpos[order]).max())
    end = np.concatenate([motion.q[-1] - data.qpos[order], motion.v[-1] - data.qvel[order]])
    return float(np.abs(end).max()), worst


def main() -> float:
    scenario = sys.argv[1] if len(sys.argv) > 1 else "kinova_table_01"
    solution = aghf.solve(scenario)
    end, worst = replay(solution)
    print(f"{solution}: in MuJoCo it ends {end:.1e} off and was at most {worst:.1e} off on the way")
    return end


if __name__ == "__main__":
    sys.exit(int(main() > 1e-2))
