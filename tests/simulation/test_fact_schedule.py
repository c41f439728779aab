"""Facts that come during a run make a plan go another way, and a replay has them too."""

from __future__ import annotations

from pathlib import Path

from rocs_bt import run
from rocs_bt.catalog import Catalog
from rocs_bt.event import KnowledgeChanged, ScriptActed
from rocs_bt.record import Recording
from rocs_bt.running.replay import replay

MISSION = """<root BTCPP_format="4">
  <BehaviorTree ID="deliver">
    <PipelineSequence>
      <ComputeRoute goal="store" planner="astar" path="{way}"/>
      <FollowRoute points="{way}" goal="store"/>
    </PipelineSequence>
  </BehaviorTree>
</root>
"""
SCENARIO = """format = "scenario/2"
base = "exp1"
duration = "20 s"
[[place]]
name = "store"
x = "1.2 m"
y = "2.0 m"
agents = ["R2"]
[[agent]]
name = "R2"
mission = "deliver"
rules = []
x = "-1.2 m"
y = "2.0 m"
yaw = "0 deg"
success = { goal = "store" }
[[fact]]
node = "start"
kind = "place"
pose = { x = "-1.2 m", y = "2.0 m" }
connects = ["store", { to = "corner", cost = 3 }]
[[fact]]
node = "corner"
kind = "place"
pose = { x = "1.2 m", y = "1.2 m" }
connects = [{ to = "store", both_ways = true }]
[[fact]]
node = "hatch"
kind = "door"
open = true
leads_to = ["start", "store"]
[[fact]]
node = "hatch"
at = "1 s"
open = false
"""


def test_a_door_that_closes_meanwhile_turns_the_robot_round_and_a_replay_tells_it_again(tmp_path: Path) -> None:
    for name, text in (("planners/missions/deliver.xml", MISSION), ("scenarios/errand.toml", SCENARIO)):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text, encoding="utf-8")
    catalog = Catalog(tmp_path)
    result = run("errand", catalog, out=tmp_path / "run", report=False)
    assert result.summary.agents["R2"].outcome == "success"
    assert result.summary.agents["R2"].path_length > 3.0, "it went back, and round by the corner"
    recording = Recording.open(tmp_path / "run")
    closed = [e for e in recording.events() if isinstance(e, KnowledgeChanged) and e.subject == "hatch" and e.t > 0.0]
    assert [(e.t, e.value) for e in closed] == [(1.0, False)]
    scripted = [(e.t, e.name, e.sentence) for e in recording.events() if isinstance(e, ScriptActed)]
    assert scripted == [(1.0, "hatch", "the agent is given the fact hatch (scripted)")]
    assert replay(recording, catalog) is None
