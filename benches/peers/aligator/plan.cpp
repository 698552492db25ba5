// Aligator's SolverProxDDP on problems with spheres that the frames of the joints must not enter.
//
//     aligator_plan < PROBLEM
//
// aligator_paper.py writes the problem and reads what is printed: in a line the accelerations at one state, in the next
// whether it converged, the iterations and the seconds of each solve, and then a line of state and control for each
// knot. After a fault of the solver the second line tells it and is the last.
#include <pinocchio/fwd.hpp>

#include <aligator/core/stage-model.hpp>
#include <aligator/core/traj-opt-problem.hpp>
#include <aligator/modelling/constraints/equality-constraint.hpp>
#include <aligator/modelling/constraints/negative-orthant.hpp>
#include <aligator/modelling/costs/quad-costs.hpp>
#include <aligator/modelling/dynamics/integrator-semi-euler.hpp>
#include <aligator/modelling/dynamics/multibody-free-fwd.hpp>
#include <aligator/modelling/spaces/multibody.hpp>
#include <aligator/modelling/state-error.hpp>
#include <aligator/solvers/proxddp/solver-proxddp.hpp>

#include <pinocchio/algorithm/jacobian.hpp>
#include <pinocchio/algorithm/kinematics.hpp>

#include <chrono>
#include <cstdio>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <vector>

#include "../dynamics/robot.hpp"

namespace pin = pinocchio;
namespace context = aligator::context;
using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;
using Vectors = std::vector<Vector>;
using Clock = std::chrono::steady_clock;

static double seconds_since(Clock::time_point began) {
  return std::chrono::duration<double>(Clock::now() - began).count();
}

struct Sphere {
  Eigen::Vector3d centre;
  double radius;
};

struct Problem {
  pin::Model model;
  Vector start, goal, sample;
  std::vector<Sphere> spheres;
  double step = 0, w_u = 0, w_x = 0, w_xf = 0, tolerance = 0, penalty = 0, regularisation = 0, limit = 0;
  int knots = 0, nonlinear = 0, iterations = 0, repeats = 0;
  Vectors states, controls;
};

static Vector read_vector(std::istream &in, long size) {
  Vector result(size);
  for (double &x : result) in >> x;
  return result;
}

static Problem read_problem(std::istream &in) {
  in.exceptions(std::ios::failbit | std::ios::badbit);
  Problem p;
  int joints = 0, spheres = 0;
  in >> joints;
  p.model = read_model(in, joints);
  p.sample = read_vector(in, 3 * joints);
  p.start = read_vector(in, 2 * joints);
  p.goal = read_vector(in, 2 * joints);
  in >> spheres;
  for (int i = 0; i < spheres; ++i) {
    const Vector numbers = read_vector(in, 4);
    p.spheres.push_back({numbers.head<3>(), numbers[3]});
  }
  in >> p.step >> p.w_u >> p.w_x >> p.w_xf >> p.tolerance >> p.penalty >> p.nonlinear >> p.regularisation;
  in >> p.iterations >> p.limit >> p.repeats >> p.knots;
  for (int k = 0; k <= p.knots; ++k) p.states.push_back(read_vector(in, 2 * joints));
  for (int k = 0; k < p.knots; ++k) p.controls.push_back(read_vector(in, joints));
  return p;
}

// How deep the frame of each joint is inside each sphere: the radius less the distance from the centre, which must not
// be positive. One function for all, since Aligator's own residuals hold a copy of the robot each.
struct Depths : context::UnaryFunction {
  using Scalar = double;
  ALIGATOR_DYNAMIC_TYPEDEFS(Scalar);
  ALIGATOR_UNARY_FUNCTION_INTERFACE(Scalar);

  struct Values : context::StageFunctionData {
    pin::Data kinematics;
    Eigen::Matrix<double, 6, Eigen::Dynamic> jacobian;

    explicit Values(const Depths &depths)
        : context::StageFunctionData(depths)
        , kinematics(*depths.model)
        , jacobian(6, depths.model->nv) {}
  };

  std::shared_ptr<const pin::Model> model;
  std::vector<Sphere> spheres;

  Depths(std::shared_ptr<const pin::Model> robot, std::vector<Sphere> obstacles)
      : Base(2 * robot->nv, robot->nv, int(obstacles.size()) * (robot->njoints - 1))
      , model(std::move(robot))
      , spheres(std::move(obstacles)) {}

  void evaluate(const ConstVectorRef &x, context::StageFunctionData &data) const override {
    Values &values = static_cast<Values &>(data);
    pin::forwardKinematics(*model, values.kinematics, x.head(model->nq));
    long row = 0;
    for (int joint = 1; joint < model->njoints; ++joint)
      for (const Sphere &sphere : spheres)
        values.value_[row++] = sphere.radius - (values.kinematics.oMi[joint].translation() - sphere.centre).norm();
  }

  void computeJacobians(const ConstVectorRef &x, context::StageFunctionData &data) const override {
    Values &values = static_cast<Values &>(data);
    pin::computeJointJacobians(*model, values.kinematics, x.head(model->nq));
    long row = 0;
    values.Jx_.setZero();
    for (int joint = 1; joint < model->njoints; ++joint) {
      values.jacobian.setZero();
      pin::getJointJacobian(*model, values.kinematics, joint, pin::LOCAL_WORLD_ALIGNED, values.jacobian);
      for (const Sphere &sphere : spheres) {
        const Eigen::Vector3d away = (values.kinematics.oMi[joint].translation() - sphere.centre).normalized();
        values.Jx_.row(row++).head(model->nv) = -away.transpose() * values.jacobian.topRows<3>();
      }
    }
  }

  std::shared_ptr<context::StageFunctionData> createData() const override { return std::make_shared<Values>(*this); }
};

struct Limit : context::CallbackBase {
  Clock::time_point began = Clock::now();
  double seconds;

  explicit Limit(double seconds) : seconds(seconds) {}

  void call(const Workspace &, const Results &) override {
    if (seconds_since(began) > seconds) throw std::runtime_error("more than " + std::to_string(int(seconds)) + " s");
  }
};

using Dynamics = aligator::dynamics::MultibodyFreeFwdDynamicsTpl<double>;

static context::TrajOptProblem optimal_control(const Problem &p, const Dynamics &dynamics) {
  const long n = p.model.nv;
  const Matrix no_control = Matrix::Zero(n, n), unit = Matrix::Identity(2 * n, 2 * n);
  // Running costs are integrals over a step, as in Aligator's examples.
  const aligator::QuadraticCostTpl<double> running(p.w_x * p.step * unit, p.w_u * p.step * Matrix::Identity(n, n));
  const aligator::QuadraticCostTpl<double> terminal(p.w_xf * unit, no_control, -p.w_xf * p.goal, Vector::Zero(n));
  context::StageModel stage(running, aligator::dynamics::IntegratorSemiImplEulerTpl<double>(dynamics, p.step));
  if (!p.spheres.empty())
    stage.addConstraint(Depths(std::make_shared<pin::Model>(p.model), p.spheres),
                        aligator::NegativeOrthantTpl<double>());
  const std::vector<xyz::polymorphic<context::StageModel>> stages(p.knots, stage);
  context::TrajOptProblem result(p.start, stages, terminal);
  result.addTerminalConstraint(aligator::StateErrorResidualTpl<double>(dynamics.space(), int(n), p.goal),
                               aligator::EqualityConstraintTpl<double>());
  return result;
}

static void show(const Vector &x) {
  for (const double &value : x) std::printf("%.17g ", value);
}

static void solve(const Problem &p, const context::TrajOptProblem &problem) {
  Vectors states, controls;
  std::vector<double> seconds;
  std::size_t iterations = 0;
  bool converged = false;
  std::string fault;
  for (int repeat = 0; repeat < p.repeats && fault.empty(); ++repeat) {
    context::SolverProxDDP solver(p.tolerance, p.penalty, p.iterations);
    solver.rollout_type_ = p.nonlinear ? aligator::RolloutType::NONLINEAR : aligator::RolloutType::LINEAR;
    solver.reg_init = p.regularisation;
    solver.setup(problem);
    const auto limit = std::make_shared<Limit>(p.limit);
    solver.registerCallback("limit", limit);
    limit->began = Clock::now();
    try {
      converged = solver.run(problem, p.states, p.controls);
    } catch (const std::runtime_error &error) {
      fault = error.what();
    }
    seconds.push_back(seconds_since(limit->began));
    iterations = solver.results_.num_iters;
    states = solver.results_.xs;
    controls = solver.results_.us;
    // Long solves are timed once.
    if (seconds[0] > 5) break;
  }
  if (!fault.empty()) {
    std::printf("fault %zu %.9g %s\n", iterations, seconds[0], fault.c_str());
    return;
  }
  std::printf("%s %zu", converged ? "converged" : "stopped", iterations);
  for (double value : seconds) std::printf(" %.9g", value);
  std::printf("\n");
  for (std::size_t k = 0; k < controls.size(); ++k) {
    show(states[k]);
    show(controls[k]);
    std::printf("\n");
  }
  show(states.back());
  show(controls.back());
  std::printf("\n");
}

int main() {
  try {
    const Problem p = read_problem(std::cin);
    const Dynamics dynamics{aligator::MultibodyPhaseSpace<double>(p.model)};
    const auto data = dynamics.createData();
    dynamics.forward(p.sample.head(2 * p.model.nv), p.sample.tail(p.model.nv), *data);
    show(data->xdot_.tail(p.model.nv));
    std::printf("\n");
    solve(p, optimal_control(p, dynamics));
  } catch (const std::exception &error) {
    std::fprintf(stderr, "aligator_plan: %s\n", error.what());
    return 1;
  }
  return 0;
}
