"""`[[fact]]`: what agents know at the start."""

from typing import Annotated

import pytest

from rocs_bt.agent.facts import add_facts, check_queries
from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import InputError
from rocs_bt.base.geometry import Pose2
from rocs_bt.base.toml_table import read_toml
from rocs_bt.catalog import FactSpec
from rocs_bt.declare import Key, Scope, Value, read_root
from rocs_bt.event import NullSink
from rocs_bt.knowledge import Knowledge

GOOD = """
[[fact]]
node = "hall"
kind = "place"
pose = { x = "1 m", y = "200 cm" }
connects = [{ to = "store", width = "1.2 m", both_ways = true }, "yard"]

[[fact]]
node = "store"
kind = "place"
pose = { x = "2 m", y = "2 m", yaw = "90 deg" }

[[fact]]
node = "yard"
kind = "place"
pose = { x = "5 m", y = "2 m" }

[[fact]]
node = "hatch"
kind = "door"
open = false
leads_to = ["hall", "store"]

[[fact]]
node = "R2"
mode = "patrol"
pursues = "home"

[[fact]]
node = "home"
kind = "goal"
pose = { x = "0 m", y = "0 m" }
tolerance = "20 cm"
"""


class Facts(Value):
    facts: Annotated[tuple[FactSpec, ...], Key("fact")] = ()


def facts_of(root, agents):
    return read_root(Facts, root, Scope(names={"agent": agents})).facts


def told(tmp_path, text, agents=("R2", "R3"), agent="R2"):
    root = read_toml(tmp_path / "s.toml", text)
    facts = facts_of(root, agents)
    knowledge = Knowledge(agent, SimulatedClock(0.05), NullSink())
    add_facts(knowledge, [fact for fact in facts if agent in fact.agents])
    return knowledge


def test_facts_become_nodes_attributes_and_relations(tmp_path):
    graph = told(tmp_path, GOOD).graph
    assert graph.get("hall", "pose") == Pose2(1.0, 2.0, 0.0)
    assert graph.get("store", "pose").yaw == pytest.approx(1.5707963)
    assert graph.edge("hall", "connects", "store")["width"] == 1.2
    assert graph.edge("store", "connects", "hall")["width"] == 1.2
    assert graph.related("hall", "connects") == ["store", "yard"]
    assert graph.related("yard", "connects") == []
    assert graph.get("hatch", "open") is False
    assert graph.related("hatch", "leads_to") == ["hall", "store"]
    assert graph.get("home", "tolerance") == pytest.approx(0.2)
    assert (graph.get("R2", "mode"), graph.related("R2", "pursues")) == ("patrol", ["home"])


def test_a_fact_has_a_height_beside_its_pose(tmp_path):
    knowledge = told(
        tmp_path, '[[fact]]\nnode = "shelf"\nkind = "place"\npose = { x = "1 m", y = "2 m" }\nz = "80 cm"\n'
    )
    assert (knowledge.world.pose_of("shelf"), knowledge.world.z_of("shelf")) == (Pose2(1.0, 2.0, 0.0), 0.8)


def test_only_those_who_are_told_know(tmp_path):
    text = '[[fact]]\nnode = "hall"\nkind = "place"\npose = { x = "1 m", y = "2 m" }\nagents = ["R3"]\n'
    assert not told(tmp_path, text).graph.has("hall")
    assert told(tmp_path, text, agent="R3").graph.has("hall")


def test_all_faults_are_told_at_once(tmp_path):
    text = GOOD.replace("open = false", "opn = false").replace('"20 cm"', '"20 s"').replace('to = "store"', 'to = "x"')
    with pytest.raises(InputError) as caught:
        told(tmp_path, text)
    assert [fault.line for fault in caught.value.faults] == [21, 33, 6]


@pytest.mark.parametrize(
    ("key", "kind", "text", "message"),
    [
        ("guard", "strategy", "door were open", r":5:1: the guard 'door were open': "),
        ("query", "question", "dor where open", r":5:1: the query 'dor where open': .*dor.*Did you mean 'door'"),
    ],
)
def test_what_is_no_query_is_told_before_anybody_asks_it(tmp_path, key, kind, text, message):
    file = f'\n[[fact]]\nnode = "a"\nkind = "{kind}"\n{key} = "{text}"\n'
    root = read_toml(tmp_path / "s.toml", file)
    facts = facts_of(root, ["R2"])
    knowledge = Knowledge("R2", SimulatedClock(0.05), NullSink())
    add_facts(knowledge, facts)
    with pytest.raises(InputError, match=message):
        check_queries(knowledge, facts)
