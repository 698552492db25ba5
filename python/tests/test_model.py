"""Robots: what they say of themselves, and what is refused."""

import copy
import pickle

import numpy as np
import pytest

import aghf

URDF = """<robot name="slide"><link name="base"/><link name="cart"><inertial><mass value="2"/>
<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
<joint name="rail" type="prismatic"><parent link="base"/><child link="cart"/><axis xyz="1 0 0"/>
<limit lower="-1" upper="2" velocity="3" effort="4"/></joint></robot>"""


def test_a_model_tells_what_its_urdf_says(tmp_path):
    path = tmp_path / "slide.urdf"
    path.write_text(URDF)
    for model in [aghf.Model.from_urdf(URDF), aghf.Model.from_urdf(path), aghf.Model.from_urdf(str(path))]:
        assert (model.name, model.dof, model.mass) == ("slide", 1, 2.0)
        assert (model.joint_names, model.joint_kinds) == (["rail"], ["prismatic"])
        limits = [model.lower, model.upper, model.velocity_limits, model.effort_limits]
        assert [x.tolist() for x in limits] == [[-1.0], [2.0], [3.0], [4.0]]
        assert model.parents.tolist() == [-1]
        assert model.frame_names == ["base", "cart"]
    assert aghf.rnea(model, [0.5], [0.0], [3.0]) == pytest.approx([6.0])
    again = aghf.Model.from_urdf(model.to_urdf())
    assert again.joint_names == model.joint_names
    assert repr(model) == "Model('slide', 1 joints)"


def test_models_are_pickled_and_copied(tmp_path):
    path = tmp_path / "slide.urdf"
    path.write_text(URDF)
    for model in [aghf.Model.from_urdf(URDF), aghf.Model.from_urdf(path), aghf.Model.builtin("kinova_gen3")]:
        q = np.full(model.dof, 0.5)
        for again in [pickle.loads(pickle.dumps(model)), copy.copy(model), copy.deepcopy(model)]:
            assert again.name == model.name
            assert np.array_equal(aghf.crba(again, q), aghf.crba(model, q))


def test_attributes_are_those_of_the_documentation():
    model = aghf.Model.builtin("pendulum_2")
    for name in ["dof", "mass", "joint_names", "parents", "lower", "effort_limits", "gravity", "notes"]:
        assert name in dir(model) and getattr(model, name) is not None
    with pytest.raises(AttributeError):
        model.joints


def test_all_robots_that_are_built_in():
    for name in aghf.builtin_robots():
        model = aghf.Model.builtin(name)
        assert np.isfinite(aghf.crba(model, np.zeros(model.dof))).all()


def test_bad_robots_are_errors_with_file_element_and_condition(tmp_path):
    path = tmp_path / "bad.urdf"
    path.write_text(URDF.replace('value="2"', 'value="two"'))
    with pytest.raises(aghf.InputError) as raised:
        aghf.Model.from_urdf(path)
    error = raised.value
    assert error.file == str(path) and "cart" in error.element and "two" in error.condition
    assert str(error) == f"{error.file}: {error.element}: {error.condition}"
    assert isinstance(error, ValueError)
    with pytest.raises(OSError):
        aghf.Model.from_urdf(tmp_path / "nowhere.urdf")
    with pytest.raises(aghf.InputError, match="none"):
        aghf.Model.builtin("none")
    with pytest.raises(aghf.InputError, match="mimic"):
        aghf.Model.from_urdf(URDF, mimic="maybe")
