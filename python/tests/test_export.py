"""Motions in the formats of ROS 2, read back by the readers of others."""

import json

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

import aghf


def seconds(stamp):
    return stamp["sec"] + 1e-9 * stamp["nanosec"] if isinstance(stamp, dict) else stamp.sec + 1e-9 * stamp.nanosec


@pytest.fixture(scope="module")
def main_job():
    return aghf.solve("kinova_table_01")


def test_a_trajectory_has_the_shape_of_the_message(main_job):
    message = main_job.to_joint_trajectory()
    assert json.loads(json.dumps(message)) == message
    assert list(message) == ["header", "joint_names", "points"]
    assert message["joint_names"] == main_job.model.joint_names
    times = np.array([seconds(point["time_from_start"]) for point in message["points"]])
    motion = main_job.evaluate(np.minimum(times, main_job.horizon))
    names = ("positions", "velocities", "accelerations", "effort")
    for name, numbers in zip(names, (motion.q, motion.v, motion.a, motion.tau), strict=True):
        np.testing.assert_allclose([point[name] for point in message["points"]], numbers, rtol=0, atol=1e-5)
    few = main_job.to_joint_trajectory(rate=10.0)["points"]
    assert seconds(few[1]["time_from_start"]) == 0.1 and len(few) < 0.1 * len(times)


def placement(transform):
    x, y, z, w = (getattr(transform.rotation, name) for name in "xyzw")
    rotation = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    matrix = np.eye(4)
    matrix[:3, :3] = rotation
    matrix[:3, 3] = [getattr(transform.translation, name) for name in "xyz"]
    return matrix


def test_a_recording_is_read_field_by_field(main_job, tmp_path):
    path = tmp_path / "run.mcap"
    assert main_job.save(path) == [str(path)]
    with pytest.raises(aghf.InputError, match="exists already"):
        main_job.save(path)
    found = {}
    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        assert reader.get_header().profile == "ros2"
        for schema, channel, message, decoded in reader.iter_decoded_messages():
            assert (schema.encoding, channel.message_encoding) == ("ros2msg", "cdr")
            found.setdefault(channel.topic, []).append((schema.name, message.log_time, decoded))
    counts = {topic: (messages[0][0], len(messages)) for topic, messages in found.items()}
    rows = len(found["/joint_states"])
    assert rows == np.ceil(100 * main_job.horizon) + 1
    assert counts == {
        "/robot_description": ("std_msgs/msg/String", 1),
        "/obstacles": ("visualization_msgs/msg/MarkerArray", 1),
        "/plan": ("trajectory_msgs/msg/JointTrajectory", 1),
        "/joint_states": ("sensor_msgs/msg/JointState", rows),
        "/tf": ("tf2_msgs/msg/TFMessage", rows),
    }
    assert "<robot" in found["/robot_description"][0][2].data
    plan = found["/plan"][0][2]
    assert list(plan.joint_names) == main_job.model.joint_names and len(plan.points) == rows

    kinds = {1: "box", 3: "cylinder"}
    markers, obstacles = found["/obstacles"][0][2].markers, main_job.scenario["obstacles"]
    assert [m.id for m in markers] == list(range(len(obstacles)))
    for marker, obstacle in zip(markers, obstacles, strict=True):
        (kind, shape), position = *obstacle["shape"].items(), obstacle["pose"]["position_m"]
        assert kind == kinds[marker.type] and marker.action == 0 and marker.header.frame_id == "base_link"
        edges = {
            "box": lambda s: s["size_m"],
            "cylinder": lambda s: [2 * s["radius_m"], 2 * s["radius_m"], s["length_m"]],
        }[kind](shape)
        np.testing.assert_allclose([marker.scale.x, marker.scale.y, marker.scale.z], edges, rtol=1e-12)
        at = marker.pose.position
        np.testing.assert_allclose([at.x, at.y, at.z], position, atol=1e-12)
        assert marker.color.a > 0 and marker.points == [] and marker.text == "" and marker.mesh_file.filename == ""
        assert marker.mesh_use_embedded_materials is False

    times = np.minimum([seconds(state.header.stamp) for _, _, state in found["/joint_states"]], main_job.horizon)
    motion = main_job.evaluate(times)
    for k, (_, at, state) in enumerate(found["/joint_states"]):
        assert at == state.header.stamp.sec * 10**9 + state.header.stamp.nanosec
        assert list(state.name) == main_job.model.joint_names
        for ours, theirs in ((motion.q, state.position), (motion.v, state.velocity), (motion.tau, state.effort)):
            np.testing.assert_allclose(theirs, ours[k], rtol=0, atol=1e-5)
        point = plan.points[k]
        assert list(point.positions) == list(state.position)
        np.testing.assert_allclose(point.accelerations, motion.a[k], rtol=0, atol=1e-4)
    for k in (0, rows // 2, rows - 1):
        # Each link is where forward kinematics has it.
        poses = {"base_link": np.eye(4)}
        for each in found["/tf"][k][2].transforms:
            poses[each.child_frame_id] = poses[each.header.frame_id] @ placement(each.transform)
        for name, pose in poses.items():
            np.testing.assert_allclose(pose, aghf.frame_placement(main_job.model, motion.q[k], name), atol=1e-6)
