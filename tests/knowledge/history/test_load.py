"""Saved knowledge in a later run: what lasts comes back, what belongs to a run does not, what is told now stands."""

from __future__ import annotations

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.geometry import Pose2
from rocs_bt.event import ListSink, NullSink
from rocs_bt.knowledge import Knowledge, KnowledgeGraph
from rocs_bt.knowledge.history import GraphState, load_into, persistent_part


def graph_of() -> KnowledgeGraph:
    graph = KnowledgeGraph(SimulatedClock(0.05), ListSink(), "R2")
    graph.add("R2", "robot", mode="patrol")
    return graph


def earlier() -> GraphState:
    graph = graph_of()
    graph.add("sonar", "sensor", driver="range_cone")
    graph.relate("R2", "has_sensor", "sonar")
    graph.add("dock", "place", pose=Pose2(1.0, 2.0))
    graph.add("gate", "place", pose=Pose2(3.0, 2.0))
    graph.relate("dock", "connects", "gate", open=False)
    graph.add("shelf", "object", pose=Pose2(0.0, 1.0), radius=0.4)
    graph.add("trolley", "object", pose=Pose2(0.0, 1.0), moves=True)
    graph.add("something front", "object", distance=0.3)
    graph.add("R3", "peer", tag=2, pose=Pose2(5.0, 5.0))
    graph.add("origin", "goal", pose=Pose2(0.0, 0.0))
    graph.relate("R2", "pursues", "origin")
    graph.relate("shelf", "near", "dock", distance=0.7)
    return GraphState.of(graph)


def test_what_lasts_comes_back_and_what_belongs_to_a_run_does_not() -> None:
    state = persistent_part(earlier())
    assert state.nodes() == ["dock", "gate", "shelf", "origin"]
    assert {*state.edges()} == {("dock", "connects", "gate"), ("shelf", "near", "dock")}
    graph = graph_of()
    loaded = load_into(graph, state)
    assert (loaded.nodes, loaded.edges, loaded.refused) == (4, 2, ())
    assert graph.get("shelf", "radius") == 0.4
    assert graph.edge("dock", "connects", "gate")["open"] is False
    assert graph.get("R2", "mode") == "patrol"


def test_what_is_told_now_stands_and_what_nobody_tells_is_remembered() -> None:
    graph = graph_of()
    graph.add("shelf", "object", pose=Pose2(9.0, 9.0))
    graph.add("dock", "goal", pose=Pose2(7.0, 7.0))
    loaded = load_into(graph, persistent_part(earlier()))
    assert graph.get("shelf", "pose") == Pose2(9.0, 9.0)
    assert graph.get("shelf", "radius") == 0.4
    assert graph.kind("dock") == "goal"
    assert any("'dock' was of kind place, and is of kind goal now" in reason for reason in loaded.refused)


def test_what_came_of_strategies_is_remembered() -> None:
    knowledge = Knowledge("R2", SimulatedClock(0.05), NullSink())
    knowledge.strategy.add("detour")
    use = knowledge.strategy.begin("detour", "the door was shut")
    knowledge.strategy.end(use, "success")
    knowledge.strategy.begin("detour", "the run's end cuts it off")
    later = Knowledge("R2", SimulatedClock(0.05), NullSink())
    later.strategy.add("detour")
    assert not load_into(later.graph, persistent_part(GraphState.of(knowledge.graph))).refused
    assert later.strategy.uses() == knowledge.strategy.uses() != []
    assert later.graph.nodes("use") == [use], "or it would be in force for ever"


def test_it_can_be_repeated() -> None:
    graph = graph_of()
    state = persistent_part(earlier())
    load_into(graph, state)
    again = load_into(graph, state)
    assert (again.nodes, again.edges, again.refused) == (0, 0, ())
