# /// script
# requires-python = ">=3.11"
# dependencies = ["rocs_bt"]
# ///
"""Record a run and analyse it: events, the reasons for an action at a given time, figures and replay.

With `out` a run writes run.mcap, summary.json and report.html. The recording, run.mcap, contains every event in order
and without loss of precision. `explain` returns the signals, plan, rules and commands at a time. `replay` runs the
agent on the recorded sensor data and checks that it makes the same decisions.

Output:

    written: report.html, run.mcap, summary.json
    events: 1092 SensorRead, 819 SignalsWritten, 548 BodyMoved, 272 ActuatorCommanded ...
       0.75 s  avoid_collision/AvoidCollision: min(front) = 0.381 m, min(near, to_goal) = 0.4 m, speed = 0.495 m/s
       3.85 s  avoid_collision/AvoidCollision: min(front) = 0.375 m, min(near, to_goal) = 0.4 m, speed = 0.285 m/s
       7.90 s  avoid_collision/AvoidCollision: min(front) = 0.392 m, min(near, to_goal) = 0.4 m, speed = 0.512 m/s
       0.75 s  GoTo was cancelled by avoid_collision/AvoidCollision
       3.85 s  GoTo was cancelled by avoid_collision/AvoidCollision
       7.90 s  GoTo was cancelled by avoid_collision/AvoidCollision
    R2 at 0.75 s: front >= 0.38 m, plan: GoTo goal
      active rule: avoid_collision/AvoidCollision, wheel commands: +0.07 and -0.07 m/s
    figures: arena.svg, coordinates.svg, activation.svg, commands.svg
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

    print("written:", ", ".join(sorted(path.name for path in Path(folder).iterdir())))
    kinds = Counter(type(event).__name__ for event in recording.events())
    print("events:", ", ".join(f"{count} {kind}" for kind, count in kinds.most_common(4)), "...")

    fired = [e for e in recording.events() if isinstance(e, RuleChanged) and e.phase == "fired"]
    for event in fired:
        print(f"  {event.t:5.2f} s  {event.rule}: {event.reading}")
    cancelled = [e for e in recording.events() if isinstance(e, TicketChanged) and e.state == "CANCELLED"]
    for event in cancelled:
        print(f"  {event.t:5.2f} s  {event.action} was cancelled by {event.by}")

    why = explain(recording, fired[0].t, "R2")
    front, (left, right) = why.value("signal", "front"), why.value("command", "wheels")
    print(f"R2 at {why.t:.2f} s: front >= {min(front):.2f} m, plan: {', '.join(why.mission.waiting())}")
    print(f"  active rule: {', '.join(why.rules)}, wheel commands: {left:+.2f} and {right:+.2f} m/s")

    figures = write_figures([recording], Path(folder), ["svg"])
    print("figures:", ", ".join(path.name for path in figures))
    print("replayed:", rocs_bt.replay(recording) or "the same decisions, event by event")
