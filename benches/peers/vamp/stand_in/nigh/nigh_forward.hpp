// Nearest neighbours by going through all nodes, in the place of the library `nigh`, which no package registry has. For the few hundred nodes of
// these problems this is about as fast as a tree, and it returns the same neighbours.
#pragma once

#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace unc::robotics::nigh
{
    namespace metric
    {
        template <int p>
        struct LP
        {
        };

        template <typename T, typename Metric>
        struct Space;
    }  // namespace metric

    struct NoThreadSafety
    {
    };

    template <std::size_t batch>
    struct KDTreeBatch
    {
    };

    template <typename T, typename Space, typename Key, typename Threads, typename Strategy>
    class Nigh
    {
        std::vector<T> nodes;

    public:
        void insert(const T &node)
        {
            nodes.push_back(node);
        }

        [[nodiscard]] auto size() const -> std::size_t
        {
            return nodes.size();
        }

        [[nodiscard]] auto nearest(const typename Space::Type &to) const -> std::optional<std::pair<T, float>>
        {
            if (nodes.empty())
            {
                return std::nullopt;
            }
            const T *best = nullptr;
            float least = std::numeric_limits<float>::infinity();
            for (const auto &node : nodes)
            {
                const float distance = Space::distance(Key{}(node), to);
                if (distance < least)
                {
                    least = distance;
                    best = &node;
                }
            }
            return std::make_pair(best ? *best : nodes.front(), least);
        }
    };
}  // namespace unc::robotics::nigh
