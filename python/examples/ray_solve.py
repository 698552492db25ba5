"""Solves scenarios on a cluster of Ray: ``python ray_solve.py [COUNT]``.

Here the cluster is this machine with two workers of one core. On several machines start ``ray start --head`` on one and
``ray start --address=HEAD:6379`` on the others, install this package on each, and call
``ray.init(address="auto")``: the rest stays. A solution itself stays with its worker; scenarios,
summaries and arrays travel.
"""

import sys

import ray

import aghf

count = int(sys.argv[1]) if len(sys.argv) > 1 else 8
ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)


@ray.remote(num_cpus=1)
def solved(names):
    """Summaries and sampled motions of some scenarios."""
    return [(s.summary, s.sample(101)._asdict()) for s in aghf.solve_many(names, threads=1)]


names = [f"limits_{i:02}" for i in range(1, count + 1)]
halves = ray.get([solved.remote(names[worker::2]) for worker in range(2)])
efforts = {}
for summaries in halves:
    for summary, motion in summaries:
        assert motion["q"].shape[0] == 101
        efforts[summary["scenario"]] = summary["control_effort"]
here = aghf.solve_many(names)
for solution in here:
    assert solution.summary["control_effort"] == efforts[solution.summary["scenario"]]
good = sum(solution.success for solution in here)
print(f"{good} of {count} solved, by two workers as by this process")
ray.shutdown()
