# /// script
# requires-python = ">=3.11"
# dependencies = ["rocs_bt"]
# ///
"""Record a run, and ask it afterwards: what happened, why at that moment, and how it looked.

With `out` a run leaves run.mcap, summary.json and report.html. The recording holds every event, in its order and to the
bit. `explain` tells what was known, planned, fired and sent at a time, and replaying it must reach the same decisions.

Output:

    left behind: report.html, run.mcap, summary.json
    events: 1092 SensorRead, 819 SignalsWritten, 548 BodyMoved, 272 ActuatorCommanded ...
       0.75 s  avoid_collision/AvoidCollision: min(front) = 0.381 m, min(near, to_goal) = 0.4 m, speed = 0.495 m/s
       3.85 s  avoid_collision/AvoidCollision: min(front) = 0.375 m, min(near, to_goal) = 0.4 m, speed = 0.285 m/s
       7.90 s  avoid_collision/AvoidCollision: min(front) = 0.392 m, min(near, to_goal) = 0.4 m, speed = 0.512 m/s
       0.75 s  GoTo was cancelled by avoid_collision/AvoidCollision
       3.85 s  GoTo was cancelled by avoid_collision/AvoidCollision
       7.90 s  GoTo was cancelled by avoid_collision/AvoidCollision
    at 0.75 s R2 knew front >= 0.38 m, had planned GoTo goal,
      had avoid_collision/AvoidCollision active, and told its wheels +0.07 and -0.07 m/s
    figures: arena.svg, coordinates.svg, activation.svg, wheels.svg
    replayed: the same decisions, event by event
"""

import tempfile
from collections import Counter
from pathlib import Path

import rocs_bt
from rocs_bt.event import RuleChanged, TicketChanged
from rocs_bt.record import Recording, explain, write_figures

with tempfile.TemporaryDirectory() as folder:
    result = rocs_bt.run("exp1", out=folder)
    recording = Recording.open(result.recording)

    print("left behind:", ", ".join(sorted(path.name for path in Path(folder).iterdir())))
    kinds = Counter(type(event).__name__ for event in recording.events())
    print("events:", ", ".join(f"{count} {kind}" for kind, count in kinds.most_common(4)), "...")

    fired = [e for e in recording.events() if isinstance(e, RuleChanged) and e.phase == "fired"]
    for event in fired:
        print(f"  {event.t:5.2f} s  {event.rule}: {event.reading}")
    cancelled = [e for e in recording.events() if isinstance(e, TicketChanged) and e.state == "CANCELLED"]
    for event in cancelled:
        print(f"  {event.t:5.2f} s  {event.action} was cancelled by {event.by}")

    why = explain(recording, fired[0].t, "R2")
    left, right = why.commands["wheels"].values
    print(f"at {why.t:.2f} s R2 knew front >= {min(why.signals['front'][1]):.2f} m, had planned {', '.join(why.tree)},")
    print(f"  had {', '.join(why.rules)} active, and told its wheels {left:+.2f} and {right:+.2f} m/s")

    figures = write_figures([recording], Path(folder), ["svg"])
    print("figures:", ", ".join(path.name for path in figures))
    print("replayed:", rocs_bt.replay(recording) or "the same decisions, event by event")
