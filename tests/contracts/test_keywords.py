"""Public functions with `**keywords` take no name that they do not know, and a run is played once."""

import ast
from contextlib import closing
from pathlib import Path

import pytest

import rocs_bt
from rocs_bt import InputError, Pose2, RunOptions
from rocs_bt.base.errors import RocsError, UnknownName
from rocs_bt.catalog import Catalog
from rocs_bt.control.locomotion_kinds import make_locomotion
from rocs_bt.declare import replaced
from rocs_bt.running import Run
from rocs_bt.testing.missions import play

CATALOG = Catalog()
WHEELS = {"max_wheel_speed": 1.0, "max_wheel_acceleration": 1.0}


def made(**options):
    return Run(CATALOG.load_scenario("exp1"), CATALOG, RunOptions(duration=0.1, **options))


@pytest.fixture(scope="module")
def agent():
    with closing(made()) as run:
        run.prepare()
        yield run.agents[0]


FUNCTIONS = {
    "run": lambda agent, **wrong: rocs_bt.run("exp1", CATALOG, **wrong),
    "drive": lambda agent, **wrong: rocs_bt.drive("exp1", CATALOG, **wrong),
    "conduct": lambda agent, **wrong: made().conduct(**wrong),
    "changed": lambda agent, **wrong: RunOptions().changed(**wrong),
    "replaced": lambda agent, **wrong: replaced(CATALOG.load_scenario("exp1"), **wrong),
    "play": lambda agent, **wrong: play("exp1", catalog=CATALOG, **wrong),
    "act": lambda agent, **wrong: rocs_bt.run(
        "exp1", CATALOG, missions={"R2": lambda mission: mission.act("GoTo", goal="goal", **wrong)}
    ),
    "node": lambda agent, **wrong: rocs_bt.run(
        "exp1", CATALOG, missions={"R2": lambda mission: mission.node("AlwaysSuccess", **wrong)}
    ),
    "tree": lambda agent, **wrong: play(
        lambda mission: mission.tree("navigate", **wrong), catalog=CATALOG, leaves={"*": "S"}
    ),
    "submit": lambda agent, **wrong: agent.plan.submit("GoTo", goal="goal", **wrong),
    "update": lambda agent, **wrong: agent.plan.submit("GoTo", goal="goal").action.update(**wrong),
    "place": lambda agent, **wrong: agent.knowledge.world.place("p", Pose2(0.0, 0.0, 0.0), **wrong),
    "add": lambda agent, **wrong: agent.knowledge.graph.add("p", "place", **wrong),
    "set": lambda agent, **wrong: agent.knowledge.graph.set("goal", **wrong),
    "relate": lambda agent, **wrong: agent.knowledge.graph.relate("goal", "near", "goal", **wrong),
    "make_locomotion": lambda agent, **wrong: make_locomotion("differential", wheel_separation=0.3, **WHEELS, **wrong),
}
# Inside the house, or a value that a query need not use.
FORWARDING = {
    "command",
    "ask",
    "holds",
    "query",
    "build",
    "change",
    "entity",
    "make",
    "method",
    "note",
    "safe",
    "setup",
    "with_catalog",
}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_an_unknown_keyword_is_an_error_that_names_it(agent, name):
    with pytest.raises((RocsError, TypeError), match="gaol" if name != "twist_body" else "needs the axis"):
        FUNCTIONS[name](agent, gaol="dock")


def test_every_public_function_with_keywords_is_in_the_table():
    """Constructors are not: they pass their keywords to their base class, which checks them."""
    found = set()
    for file in Path(rocs_bt.__file__).parent.rglob("*.py"):
        if {"cli", "figures", "studio", "report", "nodes", "testing"} & set(file.parts):
            continue
        for each in ast.walk(ast.parse(file.read_text())):
            if isinstance(each, ast.FunctionDef) and each.args.kwarg and not each.name.startswith("_"):
                found.add(each.name)
    assert found <= {*FUNCTIONS, *FORWARDING}


def test_an_unknown_option_names_the_nearest_one():
    with pytest.raises(UnknownName, match=r"no option of a run is named 'sed'.*Did you mean 'seed'"):
        rocs_bt.run("exp1", CATALOG, sed=3)


USED = (
    "seed",
    "mode",
    "duration",
    "missions",
    "prepare",
    "watch_rules",
    "knowledge",
    "swaps",
    "wait",
    "dry_run",
    "confirm",
)


@pytest.mark.parametrize("name", USED)
def test_an_option_that_the_preparation_has_used_is_refused(name):
    with closing(made()) as run:
        run.prepared = True
        with pytest.raises(InputError, match=rf"is prepared with {name} = .* already"):
            run.conduct(**{name: getattr(run.options, name)})


@pytest.mark.parametrize("first", [lambda run: run.conduct(), lambda run: run.prepare() or run.close()])
@pytest.mark.parametrize("again", [lambda run: run.conduct(), lambda run: run.prepare()])
def test_a_run_is_played_once(first, again):
    run = made()
    first(run)
    with pytest.raises(InputError, match="was conducted or closed before"):
        again(run)


def test_a_mission_for_an_agent_that_the_scenario_does_not_have_is_refused():
    with pytest.raises(InputError, match=r"no agent of the option 'missions' is named 'R3'.*R2"):
        rocs_bt.run("exp1", CATALOG, missions={"R3": lambda mission: mission.wait("1 s")})
