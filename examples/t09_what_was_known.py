# /// script
# requires-python = ">=3.11"
# dependencies = ["rocs_bt"]
# ///
"""Query what a robot knew at an earlier time, keep its knowledge in a file, and load it in the next run.

A robot's knowledge logs every change of its graph. The log restores the graph as of any time or revision. A run that
gets a file of knowledge starts with what is still valid in it, such as places, and replaces it at its end.

Output:

    at 0.0 s: shelf at (1.0, 2.0)
    at 0.5 s: shelf at (1.5, 2.0)
    at 1.0 s: dock at (0.5, -2.0)
    remembered: Remembered(nodes=1, edges=0, refused=())
    pursued at 3.0 s: goal
    known at the end: goal goal, place dock
"""

import tempfile
from pathlib import Path

import rocs_bt
from rocs_bt import SimulatedClock
from rocs_bt.event import NullSink
from rocs_bt.knowledge import Knowledge
from rocs_bt.knowledge.history import GraphState, read_knowledge, to_json_text
from rocs_bt.record import Recording
from rocs_bt.record.knowledge import recorded_log

with tempfile.TemporaryDirectory() as folder:
    # A robot's knowledge over a second.
    clock = SimulatedClock(step=0.5)
    knowledge = Knowledge("R2", clock, NullSink())
    knowledge.world.place("shelf", rocs_bt.Pose2(1.0, 2.0), kind="object")
    clock.advance()
    knowledge.world.place("shelf", rocs_bt.Pose2(1.5, 2.0), kind="object")
    clock.advance()
    knowledge.graph.remove("shelf")
    knowledge.world.place("dock", rocs_bt.Pose2(0.5, -2.0))
    for t in (0.0, 0.5, 1.0):
        state = knowledge.past.as_of(t)
        print(f"at {t} s:", ", ".join(f"{n} at {state.get(n, 'pose')[:2]}" for n in state.nodes() if n != "R2"))

    # A run that loads it from a file, and replaces the file.
    file = Path(folder) / "knowledge.json"
    file.write_text(to_json_text(GraphState.of(knowledge.graph)))
    result = rocs_bt.run("exp1", out=Path(folder) / "run", report=False, knowledge=file)
    print("remembered:", result.summary.knowledge.remembered["R2"])
    log = recorded_log(Recording.open(Path(folder) / "run"), "R2")
    print("pursued at 3.0 s:", *log.as_of(3.0).related("R2", "pursues"))
    end = read_knowledge(file)["R2"]
    print("known at the end:", ", ".join(f"{end.kind(n)} {n}" for n in end.nodes() if end.row(n).get("pose")))
