// A robot as numbers: what robots.py writes of each joint.
#pragma once
#include <pinocchio/fwd.hpp>

#include <pinocchio/multibody.hpp>

#include <istream>
#include <stdexcept>
#include <string>

// The joint that Pinocchio's reader of URDF files would take: those along a coordinate axis have code of their own.
template <class X, class Y, class Z, class Any>
pinocchio::JointIndex add_joint(pinocchio::Model &model, int parent, const Eigen::Vector3d &axis,
                                const pinocchio::SE3 &placement, const std::string &name) {
  if (axis == Eigen::Vector3d::UnitX()) return model.addJoint(parent, X(), placement, name);
  if (axis == Eigen::Vector3d::UnitY()) return model.addJoint(parent, Y(), placement, name);
  if (axis == Eigen::Vector3d::UnitZ()) return model.addJoint(parent, Z(), placement, name);
  return model.addJoint(parent, Any(axis), placement, name);
}

// Reads that many joints with their bodies.
inline pinocchio::Model read_model(std::istream &in, int joints) {
  namespace pin = pinocchio;
  pin::Model model;
  for (int i = 0; i < joints; ++i) {
    int parent = 0;
    std::string kind;
    Eigen::Vector3d axis, translation, centre;
    Eigen::Matrix3d rotation, inertia;
    double mass = 0;
    in >> parent >> kind;
    for (double &x : axis.reshaped()) in >> x;
    for (double &x : rotation.reshaped<Eigen::RowMajor>()) in >> x;
    for (double &x : translation.reshaped()) in >> x;
    in >> mass;
    for (double &x : centre.reshaped()) in >> x;
    for (double &x : inertia.reshaped()) in >> x;
    const pin::SE3 placement(rotation, translation);
    const std::string name = "joint_" + std::to_string(i + 1);
    pin::JointIndex joint = 0;
    if (kind == "revolute")
      joint = add_joint<pin::JointModelRX, pin::JointModelRY, pin::JointModelRZ, pin::JointModelRevoluteUnaligned>(
          model, parent, axis, placement, name);
    else if (kind == "prismatic")
      joint = add_joint<pin::JointModelPX, pin::JointModelPY, pin::JointModelPZ, pin::JointModelPrismaticUnaligned>(
          model, parent, axis, placement, name);
    else
      throw std::runtime_error("joint " + std::to_string(i + 1) + " is of the unknown kind " + kind);
    model.appendBodyToJoint(joint, pin::Inertia(mass, centre, inertia), pin::SE3::Identity());
  }
  return model;
}
