// Plans with VAMP's RRT-Connect for the Panda and simplifies, with the settings of its script `evaluate_mbm.py`.
//
// Standard input, for each problem: a name, the start, the goal, the number of boxes, each with its centre, Euler
// angles x, y, z and half
// lengths, and the number of capsules, each with its ends and its radius. Standard output, for each problem a line:
// the name, the median of the
// nanoseconds of planning and simplification over the runs, their 90th percentile, the number of waypoints, the
// waypoints.
#include <algorithm>
#include <array>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include <vamp/collision/factory.hh>
#include <vamp/planning/rrtc.hh>
#include <vamp/planning/simplify.hh>
#include <vamp/planning/validate.hh>
#include <vamp/random/halton.hh>
#include <vamp/robots/panda.hh>

using Robot = vamp::robots::Panda;
static constexpr std::size_t rake = vamp::FloatVectorWidth;
namespace factory = vamp::collision::factory;

template <std::size_t n>
auto read() -> std::array<float, n>
{
    std::array<float, n> values;
    for (auto &value : values)
    {
        std::cin >> value;
    }
    return values;
}

auto main(int, char **arguments) -> int
{
    const int runs = std::atoi(arguments[1]);
    std::string name;
    while (std::cin >> name)
    {
        const auto start = read<Robot::dimension>();
        const auto goal = read<Robot::dimension>();
        vamp::collision::Environment<float> environment;
        std::size_t count = 0;
        for (std::cin >> count; count > 0; --count)
        {
            const auto center = read<3>();
            const auto euler = read<3>();
            const auto half = read<3>();
            const auto cuboid = factory::cuboid::array(center, euler, half);
            auto &list = cuboid.axis_3_z == 1. ? environment.z_aligned_cuboids : environment.cuboids;
            list.emplace_back(cuboid);
        }
        for (std::cin >> count; count > 0; --count)
        {
            const auto from = read<3>();
            const auto to = read<3>();
            const auto radius = read<1>();
            environment.capsules.emplace_back(factory::capsule::endpoints::array(from, to, radius[0]));
        }
        environment.sort();
        const auto vectors = vamp::collision::Environment<vamp::FloatVector<rake>>(environment);

        vamp::planning::RRTCSettings settings;
        settings.range = 1.0;
        const vamp::planning::SimplifySettings simplification;
        std::vector<std::size_t> times;
        vamp::planning::PlanningResult<Robot> simple;
        for (int run = 0; run < runs; ++run)
        {
            auto rng = std::make_shared<vamp::rng::Halton<Robot>>();
            auto result = vamp::planning::RRTC<Robot, rake, Robot::resolution>::solve(
                Robot::Configuration(start), Robot::Configuration(goal), vectors, settings, rng);
            times.push_back(result.nanoseconds);
            if (result.path.empty())
            {
                simple.path.clear();
                break;
            }
            simple = vamp::planning::simplify<Robot, rake, Robot::resolution>(result.path, vectors, simplification, rng);
            times.back() += simple.nanoseconds;
        }
        std::sort(times.begin(), times.end());
        std::cout << name << ' ' << times[times.size() / 2] << ' ' << times[times.size() * 9 / 10] << ' ' << simple.path.size();
        for (const auto &configuration : simple.path)
        {
            for (const auto value : configuration.to_array())
            {
                std::cout << ' ' << value;
            }
        }
        std::cout << std::endl;
    }
    return 0;
}
