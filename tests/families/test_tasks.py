"""Families that test deliberation: what each asks is really asked, and a mission that thinks does it."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt import Catalog, Pose2, run
from rocs_bt.base.errors import InputError
from rocs_bt.compare import Building, TaskFamily, load_family
from rocs_bt.compare.building import Route
from rocs_bt.declare import replaced
from rocs_bt.devices.mujoco import compose_world
from rocs_bt.search.space import SearchSpace
from rocs_bt.simulation import Goal, Judge

SMALL = {"rows": 2, "columns": 2}


def play(tmp_path: Path, family: str, index: int, duration: float = 30.0, **parameters: object) -> Any:
    scene = load_family(Catalog(), family, parameters).scene(index)
    scene.write(tmp_path)
    return run(scene.name, Catalog(tmp_path), seed=1, report=False, duration=duration).summary


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 1000), st.integers(1, 4), st.integers(2, 4), st.data())
def test_the_shortest_way_over_the_roads_is_networkxs(seed: int, rows: int, columns: int, data: st.DataObject) -> None:
    building = Building.sample(np.random.default_rng(seed), rows, columns, 4.0, 1.0)
    closed = data.draw(st.sets(st.sampled_from(building.doors()), max_size=4))
    graph = nx.Graph()
    graph.add_nodes_from(map(building.room_name, building.rooms))
    for door in set(building.doors()) - closed:
        for room in door:
            length = math.dist(building.doorway(door), building.middle(room))
            graph.add_edge(building.gate_name(door), building.room_name(room), weight=length)
    start, goal = data.draw(st.sampled_from(building.rooms)), data.draw(st.sampled_from(building.rooms))
    found = building.shortest(start, goal, closed)
    if not nx.has_path(graph, building.room_name(start), building.room_name(goal)):
        assert found == Route()
        return
    assert found.length == pytest.approx(
        nx.dijkstra_path_length(graph, building.room_name(start), building.room_name(goal))
    )
    way = building.path(found.rooms)
    assert sum(map(math.dist, way, way[1:])) == pytest.approx(found.length)
    assert (way[0], way[-1]) == (building.middle(start), building.middle(goal))


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 1000))
def test_a_door_fills_its_doorway_and_opens_into_the_wall(seed: int) -> None:
    building = Building.sample(np.random.default_rng(seed), 2, 2, 3.6, 1.1)
    open_way = building.floor().grid(0.05)
    for door in building.doors():
        floor = building.floor()
        leaf = building.leaf(door, closed=True)
        assert not open_way.occupied[open_way.cell_at(building.doorway(door))]
        grid = floor.grid(0.05)
        grid.add(leaf)
        x, y = building.doorway(door)
        aside = [(x, y + d) if leaf.width > leaf.length else (x + d, y) for d in np.linspace(-0.5, 0.5, 21)]
        assert all(grid.occupied[grid.cell_at(point)] for point in aside)
        before = floor.grid(0.05)
        before.add(building.leaf(door, closed=False))
        free = [before.occupied[before.cell_at(point)] for point in aside]
        assert not any(free[1:-1])


TASKS = {"blocked_doors": 2, "closed_edges": 2, "low_battery": 3, "moved_goals": 4, "priorities": 5}


@pytest.mark.parametrize("name", TASKS)
def test_a_building_with_too_few_rooms_is_told(name: str) -> None:
    with pytest.raises(InputError, match=f"1 x 1 rooms are too few: this task needs {TASKS[name]}"):
        load_family(Catalog(), name, {"rows": 1, "columns": 1}).scene(0)


@pytest.mark.parametrize("name", TASKS)
def test_a_search_may_draw_any_parameters(name: str) -> None:
    """Those of which no scene can be made are refused as wrong input, so that others are drawn."""
    family = load_family(Catalog(), name)
    space, rng = SearchSpace(family, {"rows": (1, 3), "columns": (1, 2)}), np.random.default_rng(1)
    for _ in range(6):
        parameters = space.sample(rng).parameters
        assert parameters["rows"] * parameters["columns"] >= TASKS[name]


@pytest.mark.parametrize("name", ["blocked_doors", "closed_edges"])
def test_a_building_without_another_way_is_told(name: str) -> None:
    with pytest.raises(InputError, match="none of 300 sampled buildings of 1 x 3 rooms fits"):
        load_family(Catalog(), name, {"rows": 1, "columns": 3}).scene(0)


@pytest.mark.parametrize("name", TASKS)
def test_who_drives_has_no_part_in_the_building(name: str) -> None:
    """A task's own mission is given its route planner; another mission knows of none."""
    family = load_family(Catalog(), name)
    assert isinstance(family, TaskFamily)
    scenes = [replaced(family, **who).scene(3) for who in ({}, {"planner": "dijkstra"}, {"mission": "go_to"})]
    assert len({(scene.world, tuple(scene.reference)) for scene in scenes}) == 1
    told = [scene.scenario["agent"][0]["parameters"] for scene in scenes]
    assert told == [{"goal": "goal", "planner": "astar"}, {"goal": "goal", "planner": "dijkstra"}, {"goal": "goal"}]


def test_doors_really_shut_and_a_thinking_mission_goes_round(tmp_path: Path) -> None:
    """The roads are all that `astar` knows: without the news it drives into a shut door."""
    wanted = {**SMALL, "doors": 1, "until": "0.5 s"}
    assert play(tmp_path, "blocked_doors", 0, **wanted).agents["R"].outcome == "success"
    untold = play(tmp_path / "b", "blocked_doors", 0, report_doors=0, **wanted).agents["R"]
    assert untold.outcome != "success"
    assert "door_" in untold.reason or untold.min_clearance < 0.1
    scene = load_family(Catalog(), "blocked_doors", wanted).scene(0)
    told = scene.scenario
    world = compose_world(tmp_path / "scenarios" / "worlds" / f"{scene.name}.xml", [])
    assert set(world.objects) == {actor["name"] for actor in told["actor"]}
    news = {fact["node"]: fact["at"] for fact in told["fact"] if fact.get("at")}
    assert news == {actor["name"]: actor["depart_at"] for actor in told["actor"]}


def test_whether_one_is_told_changes_neither_building_nor_doors() -> None:
    told, untold = (load_family(Catalog(), "blocked_doors", {"report_doors": n}).scene(5) for n in (1, 0))
    assert told.world == untold.world
    assert told.reference == untold.reference


def test_only_knowledge_tells_of_a_closed_road(tmp_path: Path) -> None:
    wanted = {**SMALL, "closed": 1}
    by_road = play(tmp_path / "a", "closed_edges", 0, **wanted).agents["R"]
    by_eye = play(tmp_path / "b", "closed_edges", 0, planner="grid_astar", **wanted).agents["R"]
    assert [agent.outcome for agent in (by_road, by_eye)] == ["success", "success"]
    assert [agent.requirements[0].verdict for agent in (by_road, by_eye)] == ["satisfied", "violated"]


@pytest.mark.parametrize("index", range(12))
def test_nobody_is_where_a_goal_is_before_it_moves(index: int) -> None:
    scene = load_family(Catalog(), "moved_goals").scene(index)
    told = scene.scenario

    def at(pose: dict[str, str]) -> tuple[float, float]:
        return float(pose["x"].split()[0]), float(pose["y"].split()[0])

    start = at(told["agent"][0])
    news = [fact for fact in told["fact"] if fact["node"] == "goal"]
    places = [at(told["place"][0]), *(at(fact["pose"]) for fact in news)]
    assert len(news) == 2
    for place, fact in zip(places, news, strict=False):
        assert math.dist(start, place) > 0.5
        assert float(fact["at"].split()[0]) * 2.0 < 2.0 * math.hypot(10.8, 10.8)
    assert scene.reference[-1] == pytest.approx(places[-1])


def test_errands_are_done_in_their_order(tmp_path: Path) -> None:
    summary = play(tmp_path, "priorities", 0, rows=2, errands=1).agents["R"]
    assert summary.outcome == "success"
    # A mission that knows nothing of tasks drives home, and that is no success.
    other = play(tmp_path / "b", "priorities", 0, 12.0, rows=2, errands=1, mission="navigate").agents["R"]
    assert other.outcome == "timeout" or "it was not at 'urgent'" in other.reason


def test_a_missed_deadline_is_a_timeout(tmp_path: Path) -> None:
    assert play(tmp_path, "low_battery", 0, rows=2).agents["R"].outcome == "success"
    late = play(tmp_path / "b", "low_battery", 0, rows=2, spare=0.01).agents["R"]
    assert late.outcome == "timeout"
    assert "it was not at 'charger' by" in late.reason


class Asked:
    """A mind that says what a test wants."""

    status, reason, failure, reflex, held, waiting = "RUNNING", "", None, "", False, ""

    def reading(self, rule):
        return ""


def test_success_only_after_the_goals_before_it() -> None:
    end, first, second = (Goal(name, Pose2(x, 0.0), 0.2) for name, x in (("end", 0.0), ("first", 1.0), ("second", 2.0)))
    mind = Asked()
    judge = Judge(end, after=[(first, 5.0), (second, math.inf)])
    judge.update(0.0, Pose2(1.1, 0.0), mind, commanded=False)
    mind.status = "SUCCESS"
    assert not judge.update(1.0, Pose2(0.0, 0.0), mind, commanded=False)
    assert judge.verdict().reason == "it never reached 'second'"
    judge.update(6.0, Pose2(2.0, 0.1), mind, commanded=False)
    assert judge.update(7.0, Pose2(0.0, 0.0), mind, commanded=False)
    assert judge.verdict().outcome == "success"
    assert judge.verdict().time_to_goal == 7.0


def test_too_late_is_a_timeout_and_a_goal_that_moves_is_visited_where_it_is() -> None:
    end, first = Goal("end", Pose2(0.0, 0.0), 0.2), Goal("first", Pose2(1.0, 0.0), 0.2)
    judge = Judge(end, after=[(first, 5.0)])
    judge.move_goal("first", Pose2(3.0, 0.0))
    assert not judge.update(5.0, Pose2(1.0, 0.0), Asked(), commanded=False)
    assert judge.update(5.05, Pose2(1.0, 0.0), Asked(), commanded=False)
    assert judge.verdict().outcome == "timeout"
    assert judge.verdict().reason == "it was not at 'first' by 5 s"
