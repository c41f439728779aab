"""Roads in docs/navigation.md, strategies in docs/knowledge.md: their files load, and do what the pages say."""

import re
from pathlib import Path
from typing import Annotated

import pytest

from rocs_bt.agent.facts import add_facts
from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.geometry import Pose2
from rocs_bt.base.toml_table import read_toml
from rocs_bt.catalog import Catalog, FactSpec
from rocs_bt.declare import Key, Scope, Value, read_root
from rocs_bt.event import NullSink
from rocs_bt.knowledge import Knowledge

ROOT = Path(__file__).resolve().parents[2]
SCENARIO = (ROOT / "scenarios" / "exp1.toml").read_text("utf-8")


def section(page, heading):
    return (ROOT / "docs" / page).read_text("utf-8").partition(f"\n## {heading}\n")[2].partition("\n## ")[0]


SECTIONS = {
    "roads": section("navigation.md", "Places, roads and doors") + section("navigation.md", "Routes"),
    "strategies": section("knowledge.md", "Strategies"),
}


def blocks(name, language):
    return re.findall(rf"```{language}\n(.*?)```", SECTIONS[name], re.DOTALL)


class Facts(Value):
    facts: Annotated[tuple[FactSpec, ...], Key("fact")] = ()


def told(name):
    """What a robot knows that is told the facts of a section from the start."""
    root = read_toml(Path("page.toml"), "\n".join(blocks(name, "toml")))
    facts = read_root(Facts, root, Scope(names={"agent": ["R2"]})).facts
    knowledge = Knowledge("R2", SimulatedClock(0.05), NullSink())
    add_facts(knowledge, [fact for fact in facts if not fact.at])
    return knowledge


@pytest.mark.parametrize("name", SECTIONS)
def test_its_facts_are_those_of_a_scenario(name, tmp_path):
    (tmp_path / "scenarios").mkdir()
    file = tmp_path / "scenarios" / "told.toml"
    file.write_text("\n".join([SCENARIO, *blocks(name, "toml")]), "utf-8")
    assert Catalog(tmp_path).load_scenario("told").facts


@pytest.mark.parametrize("name", SECTIONS)
def test_its_mission_loads(name, tmp_path):
    (text,) = blocks(name, "xml")
    (tmp_path / "planners" / "missions").mkdir(parents=True)
    (tmp_path / "planners" / "missions" / "told.xml").write_text(text, "utf-8")
    assert callable(Catalog(tmp_path).load_mission("told"))


def test_its_roads_lead_where_it_says():
    knowledge = told("roads")
    planner, goal = Catalog().load_route("astar")(knowledge), knowledge.world.pose_of("store")
    assert planner.route(knowledge.world.pose_of("hall"), goal, 0.1) == [(-1.2, 1.2), (1.2, 1.2)]
    knowledge.graph.set("hatch", open=False)
    assert len(planner.route(Pose2(-1.2, 1.2, 0.0), goal, 0.1)) == 3


def test_its_strategies_are_chosen_as_it_says():
    knowledge = told("strategies")
    assert knowledge.strategy.choose().best == "around", "no door is known to be open"
    knowledge.graph.add("hatch", "door", open=True)
    assert knowledge.strategy.choose().best == "through"
    for _ in range(9):
        knowledge.strategy.end(knowledge.strategy.begin("around"), "success")
    through, around = sorted(knowledge.strategy.choose().candidates, key=lambda c: c.name)[::-1]
    assert (through.score, around.score) == pytest.approx((0.5, 2.0 * (10 / 11 - 0.5)))
