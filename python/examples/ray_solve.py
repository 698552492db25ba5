"""Solves scenarios on a cluster of Ray: ``python ray_solve.py [COUNT]``.

Here the cluster is this machine with two workers of one core. On several machines start ``ray start --head`` on one and
``ray start --address=HEAD:6379`` on the others, install this package on each, and call
``ray.init(address="auto")``: the rest stays. Scenarios and solutions travel.
"""

import sys

import ray

import aghf

count = int(sys.argv[1]) if len(sys.argv) > 1 else 8
ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)


@ray.remote(num_cpus=1)
def solved(names: list[str]) -> list[aghf.Solution | Exception]:
    """Some scenarios, one after the other."""
    return aghf.solve_many(names, threads=1)


def solutions(found: list[aghf.Solution | Exception]) -> list[aghf.Solution]:
    """The solutions; scenarios that were refused are printed."""
    for refused in found:
        if isinstance(refused, Exception):
            print(refused)
    return [solution for solution in found if isinstance(solution, aghf.Solution)]


names = [f"limits_{i:02}" for i in range(1, count + 1)]
halves = ray.get([solved.remote(names[worker::2]) for worker in range(2)])
efforts = {}
for solution in solutions([*halves[0], *halves[1]]):
    assert solution.sample(101).q.shape[0] == 101
    efforts[solution.summary["scenario"]] = solution.summary["control_effort"]
here = solutions(aghf.solve_many(names))
for solution in here:
    assert solution.summary["control_effort"] == efforts[solution.summary["scenario"]]
good = sum(solution.success for solution in here)
print(f"{good} of {count} solved, by two workers as by this process")
ray.shutdown()
