// Pinocchio's share of the comparison: values and times of its dynamics on one robot, whose numbers robots.py wrote.
//
//     pinocchio_dynamics ROBOT.txt values    results at the first states, one line each
//     pinocchio_dynamics ROBOT.txt times S   microseconds per state, the least of several blocks of S seconds
#include <pinocchio/fwd.hpp>

#include <pinocchio/multibody.hpp>

#include <pinocchio/algorithm/aba-derivatives.hpp>
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/rnea-derivatives.hpp>
#include <pinocchio/algorithm/rnea-second-order-derivatives.hpp>
#include <pinocchio/algorithm/rnea.hpp>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "robot.hpp"

namespace se3 = pinocchio;
using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

struct State {
  Vector q, v, a, tau;
};

struct Robot {
  se3::Model model;
  std::vector<State> states;
};

static Robot read(const char *path) {
  std::ifstream in(path);
  in.exceptions(std::ios::failbit | std::ios::badbit);
  Robot robot;
  int joints = 0, states = 0;
  in >> joints >> states;
  robot.model = read_model(in, joints);
  for (int k = 0; k < states; ++k) {
    State state{Vector(robot.model.nq), Vector(joints), Vector(joints), Vector(joints)};
    for (Vector *part : {&state.q, &state.v, &state.a, &state.tau})
      for (double &x : *part) in >> x;
    robot.states.push_back(state);
  }
  return robot;
}

static void print(const char *name, const double *begin, long count) {
  std::printf("%s", name);
  for (long i = 0; i < count; ++i) std::printf(" %.17g", begin[i]);
  std::printf("\n");
}

static void print(const char *name, const Matrix &m) { print(name, m.data(), m.size()); }

static void values(const Robot &robot) {
  const se3::Model &model = robot.model;
  se3::Data data(model);
  for (std::size_t k = 0; k < std::min<std::size_t>(robot.states.size(), 3); ++k) {
    const State &s = robot.states[k];
    print("rnea", se3::rnea(model, data, s.q, s.v, s.a));
    print("crba", Matrix(se3::crba(model, data, s.q).selfadjointView<Eigen::Upper>()));
    print("aba", se3::aba(model, data, s.q, s.v, s.tau));
    se3::computeRNEADerivatives(model, data, s.q, s.v, s.a);
    print("rnea_dq", data.dtau_dq);
    print("rnea_dv", data.dtau_dv);
    se3::computeABADerivatives(model, data, s.q, s.v, s.tau);
    print("aba_dq", data.ddq_dq);
    print("aba_dv", data.ddq_dv);
    print("aba_dtau", Matrix(data.Minv.selfadjointView<Eigen::Upper>()));
    se3::ComputeRNEASecondOrderDerivatives(model, data, s.q, s.v, s.a);
    print("rnea_dqdq", data.d2tau_dqdq.data(), data.d2tau_dqdq.size());
    print("rnea_dvdv", data.d2tau_dvdv.data(), data.d2tau_dvdv.size());
    print("rnea_dqdv", data.d2tau_dqdv.data(), data.d2tau_dqdv.size());
    print("rnea_dadq", data.d2tau_dadq.data(), data.d2tau_dadq.size());
  }
}

// The least time per state, in microseconds, of several blocks.
static double time(const std::vector<State> &states, double seconds, const std::function<void(const State &)> &call) {
  using Clock = std::chrono::steady_clock;
  double least = 1e300;
  for (int block = 0; block < 6; ++block) {
    long calls = 0;
    const auto start = Clock::now();
    double elapsed = 0;
    do {
      for (const State &state : states) call(state);
      calls += states.size();
      elapsed = std::chrono::duration<double>(Clock::now() - start).count();
    } while (elapsed < seconds);
    least = std::min(least, 1e6 * elapsed / calls);
  }
  return least;
}

static void times(const Robot &robot, double seconds) {
  const se3::Model &model = robot.model;
  se3::Data data(model);
  using se3::Convention;
  const std::vector<std::pair<const char *, std::function<void(const State &)>>> calls = {
      {"rnea", [&](const State &s) { se3::rnea(model, data, s.q, s.v, s.a); }},
      {"crba", [&](const State &s) { se3::crba(model, data, s.q, Convention::LOCAL); }},
      {"crba", [&](const State &s) { se3::crba(model, data, s.q, Convention::WORLD); }},
      {"aba", [&](const State &s) { se3::aba(model, data, s.q, s.v, s.tau, Convention::LOCAL); }},
      {"aba", [&](const State &s) { se3::aba(model, data, s.q, s.v, s.tau, Convention::WORLD); }},
      {"rnea_derivatives", [&](const State &s) { se3::computeRNEADerivatives(model, data, s.q, s.v, s.a); }},
      {"aba_derivatives", [&](const State &s) { se3::computeABADerivatives(model, data, s.q, s.v, s.tau); }},
      {"rnea_second_derivatives",
       [&](const State &s) { se3::ComputeRNEASecondOrderDerivatives(model, data, s.q, s.v, s.a); }},
      // Into tensors that are zero where the tree says so, from the call before.
      {"rnea_second_derivatives",
       [&](const State &s) {
         se3::ComputeRNEASecondOrderDerivatives(model, data, s.q, s.v, s.a, data.d2tau_dqdq, data.d2tau_dvdv,
                                                data.d2tau_dqdv, data.d2tau_dadq);
       }},
  };
  for (const auto &[name, call] : calls) std::printf("%s single %.6g\n", name, time(robot.states, seconds, call));
}

int main(int argc, char **argv) try {
  const std::string what = argc > 2 ? argv[2] : "";
  if (what == "values" && argc == 3)
    values(read(argv[1]));
  else if (what == "times" && argc == 4)
    times(read(argv[1]), std::stod(argv[3]));
  else
    throw std::runtime_error("usage: pinocchio_dynamics ROBOT.txt values | times SECONDS");
  return 0;
} catch (const std::exception &error) {
  std::fprintf(stderr, "pinocchio_dynamics: %s\n", error.what());
  return 1;
}
