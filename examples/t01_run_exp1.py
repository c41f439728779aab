# /// script
# requires-python = ">=3.11"
# dependencies = ["rocs_bt"]
# ///
"""Run the paper's first experiment, and read its summary.

One call runs a scenario by its name: physics, sensors, agent and actuators, in lockstep on simulated time. The summary
has the same contents as the file summary.json that `rocs-bt run exp1` writes. Runs with the same seed have the same
trajectory hash.

Output:

    exp1, seed 1, 13.7 s simulated
    R2 success; 3.55 m, 0 collisions, 3 reflexes, 3 resumed actions
    mission go_to, rules avoid_collision
    minimum clearance: 0.17 m
    reflexes active for 6.6 s, plan active for 6.8 s
    the same run again: True
"""

import rocs_bt

result = rocs_bt.run("exp1", seed=1)
again = rocs_bt.run("exp1", seed=1)

print(result)
r2 = result.summary.agents["R2"]
print(f"mission {r2.mission}, rules {', '.join(r2.rules)}")
print(f"minimum clearance: {r2.min_clearance:.2f} m")
print(f"reflexes active for {r2.time_reactive:.1f} s, plan active for {r2.time_deliberative:.1f} s")
print("the same run again:", result.summary.trajectory_hash == again.summary.trajectory_hash)
