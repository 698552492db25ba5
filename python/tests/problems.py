"""Problems that several tests solve."""

#: A double pendulum at rest to another rest.
SWING = {
    "robot": "pendulum_2",
    "horizon_s": 2.0,
    "q_start": [0.0, 0.0],
    "v_start": [0.0, 0.0],
    "q_goal": [1.0, 0.5],
    "v_goal": [0.0, 0.0],
}

#: A pendulum in one second.
PENDULUM = {
    "robot": "pendulum_1",
    "horizon_s": 1.0,
    "q_start": [0.0],
    "v_start": [0.0],
    "q_goal": [1.0],
    "v_goal": [0.0],
}
