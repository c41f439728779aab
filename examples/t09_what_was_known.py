# /// script
# requires-python = ">=3.11"
# dependencies = ["rocs_bt"]
# ///
"""Store a robot's knowledge in a file, query its history, and load it in the next run.

A journal writes every change of the graph to the file, on its own thread; the file survives a killed process. `History`
restores the graph as of any time or revision. The next run with the same file starts with the knowledge that is still
valid, such as places.

Output:

    at 0.0 s: shelf at (1.0, 2.0)
    at 0.5 s: shelf at (1.5, 2.0)
    at 1.0 s: dock at (0.5, -2.0)
    positions of the shelf: [[1.0, 2.0], [1.5, 2.0]]
    remembered: Remembered(nodes=1, edges=0, refused=())
    in the file: 1 by hand, 2 exp1-1
    known at the end: goal goal, place dock
    as JSON: ['"format": "knowledge/1",', '"agent": "R2",']
"""

import tempfile
from pathlib import Path

import rocs_bt
from rocs_bt import SimulatedClock
from rocs_bt.event import NullSink
from rocs_bt.knowledge import Knowledge
from rocs_bt.knowledge.history import History, Journal, to_json_text

with tempfile.TemporaryDirectory() as folder:
    file = Path(folder) / "knowledge.sqlite"

    # A graph and its journal.
    clock = SimulatedClock(step=0.5)
    knowledge = Knowledge("R2", clock, NullSink())
    with Journal(file, "by hand") as journal:
        journal.attach(knowledge.graph)
        knowledge.world.place("shelf", rocs_bt.Pose2(1.0, 2.0), kind="object")
        clock.advance()
        knowledge.world.place("shelf", rocs_bt.Pose2(1.5, 2.0), kind="object")
        clock.advance()
        knowledge.graph.remove("shelf")
        knowledge.world.place("dock", rocs_bt.Pose2(0.5, -2.0))

    with History(file) as history:
        for t in (0.0, 0.5, 1.0):
            state = history.as_of(t)
            print(f"at {t} s:", ", ".join(f"{n} at {state.get(n, 'pose')[:2]}" for n in state.nodes() if n != "R2"))
        print("positions of the shelf:", [change.value[:2] for change in history.changes(node="shelf", name="pose")])

    # A run that loads the file and appends to it.
    result = rocs_bt.run("exp1", knowledge=file)
    print("remembered:", result.summary.knowledge.remembered["R2"])
    print("in the file:", ", ".join(f"{run.number} {run.label}" for run in History.runs(file)))
    with History(file) as history:
        end = history.as_of()
        print("known at the end:", ", ".join(f"{end.kind(n)} {n}" for n in end.nodes() if end.row(n).get("pose")))
        print("as JSON:", to_json_text(end).splitlines()[1:3])
