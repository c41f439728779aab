# /// script
# requires-python = ">=3.11"
# dependencies = ["rocs_bt"]
# ///
"""Run the paper's first experiment, and read what became of it.

One call runs a scenario by its name: physics, sensors, mind and wheels, in lockstep on simulated time. The summary is
what `rocs-bt run exp1` writes into summary.json. The same seed is the same run: the hash of the trajectory says so.

Output:

    exp1, seed 1, 13.7 s simulated
    R2 success; 3.55 m, 0 collisions, 3 reflexes, 3 re-plans
    mission go_to, rules avoid_collision
    nearest to anything: 0.17 m
    wheels held by a reflex for 6.6 s, by the plan for 6.8 s
    the same run again: True
"""

import rocs_bt

result = rocs_bt.run("exp1", seed=1)
again = rocs_bt.run("exp1", seed=1)

print(result)
r2 = result.summary.agents["R2"]
print(f"mission {r2.mission}, rules {', '.join(r2.rules)}")
print(f"nearest to anything: {r2.min_clearance:.2f} m")
print(f"wheels held by a reflex for {r2.time_reactive:.1f} s, by the plan for {r2.time_deliberative:.1f} s")
print("the same run again:", result.summary.trajectory_hash == again.summary.trajectory_hash)
