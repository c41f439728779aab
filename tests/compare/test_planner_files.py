"""planner.toml, and Python planners that are no tree."""

from __future__ import annotations

import dataclasses

import pytest

from rocs_bt import run
from rocs_bt.base.errors import InputError
from rocs_bt.catalog import Catalog, PlannerSpec, read_planner
from rocs_bt.compare import ScenarioScene
from rocs_bt.compare.episode import Episode
from rocs_bt.compare.runner import EpisodeRunner
from rocs_bt.declare import replaced


def write(project, text):
    file = project / "planners" / "mine.toml"
    file.write_text(text, "utf-8")
    return file


def play(planner, project, seed=1):
    return EpisodeRunner(project).play(Episode("key", planner, ScenarioScene("short"), seed, project))


def test_what_a_file_says(project, catalog):
    write(
        project,
        'format = "planner/1"\ndoc = "One."\nsource = "A book."\nmission = "go_to"\nrules = ["avoid_collision"]\n'
        'latency = "80 ms"\noracle = true\n[parameters]\ngoal = "goal"\ncruise = "0.4 m/s"\n',
    )
    found = catalog.load_planner("mine")
    assert (found.name, found.mission, found.rules, found.latency) == ("mine", "go_to", ("avoid_collision",), 0.08)
    assert (found.doc, found.source, found.oracle) == ("One.", "A book.", True)
    assert found.parameters == {"goal": "goal", "cruise": "0.4 m/s"}
    assert read_planner(project / "planners" / "mine.toml") == found


def test_a_planner_takes_the_place_of_mission_rules_parameters_and_latency_of_one_agent():
    scenario = Catalog().load_scenario("exp3")
    planner = PlannerSpec(name="mine", mission="go_to", parameters={"cruise": "0.1 m/s"}, latency=None)
    changed = planner.drives(scenario, "R2")
    before, after = ({agent.name: agent for agent in s.agents} for s in (scenario, changed))
    assert {name for name in before if before[name] != after[name]} == {"R2"}
    assert after["R2"] == replaced(
        before["R2"], mission="go_to", rules=(), parameters={"cruise": "0.1 m/s"}, latency=None
    )
    assert (changed.file, changed.actors, changed.world) == (scenario.file, scenario.actors, scenario.world)


def test_a_planner_on_a_robot_also_replaces_the_robot_of_the_agent(catalog):
    scenario = catalog.load_scenario("exp1")
    own, tree = (catalog.load_planner(name) for name in ("@robotino", "tree@robotino"))
    assert (own.name, tree.name) == ("@robotino", "tree@robotino")
    (before, after, other) = (spec.agents[0] for spec in (scenario, *(p.drives(scenario, "R2") for p in (own, tree))))
    assert after == replaced(before, robot="robotino")
    assert (other.robot, other.mission, other.rules) == ("robotino", "go_to", ("avoid_collision",))


def test_a_python_planner_drives_and_says_when_it_has_arrived(project, catalog, planner):
    planner("told", "return None if observation.t >= 1.0 else (0.2, 0.2)")
    record = play(catalog.load_planner("told"), project)
    assert record.outcome == "timeout"
    assert "the mission returned SUCCESS, but" in record.reason
    assert 0.1 < record.metrics["path_length"] < 0.21


def test_a_python_planner_sees_what_the_robot_knows(project, catalog, planner):
    planner(
        "told",
        "assert set(s) == set(self.task.knowledge.signals.names); assert len(s['front']) > 1; "
        "assert observation.pose.distance(self.task.goals['goal']) > 1.0; "
        "assert self.task.tolerances['goal'] == 0.1; assert len(self.task.locomotion.values) == 2; return 0.0, 0.0",
        reset="self.task = task; assert not task.privileged",
    )
    file = project / "planners" / "told.py"
    file.write_text(file.read_text().replace("        assert set(s)", "        s = observation.signals; assert set(s)"))
    assert play(catalog.load_planner("told"), project).outcome == "timeout"


def test_reflexes_cut_in_on_a_python_planner_and_it_goes_on_after_them(project, catalog, planner):
    planner("told", "return 0.5, 0.5")
    blind = catalog.load_planner("told")
    wary = replaced(blind, rules=("avoid_collision",))
    text = (project / "scenarios" / "short.toml").read_text().replace('"2 s"', '"8 s"')
    (project / "scenarios" / "short.toml").write_text(text)
    assert play(blind, project).outcome == "collision"
    record = play(wary, project)
    assert record.outcome != "collision"
    assert record.metrics["route_switches"] >= 2


def test_what_a_python_planner_draws_is_keyed_by_scenario_and_seed(project, catalog):
    random = catalog.load_planner("random")
    hashes = [play(random, project, seed).trajectory_hash for seed in (1, 2, 1)]
    assert hashes[0] == hashes[2] != hashes[1]


def test_parameters_of_a_python_planner_have_units(project, catalog):
    slow = replaced(catalog.load_planner("random"), parameters={"speed": "1 cm/s"})
    assert play(slow, project).metrics["path_length"] < 0.025
    wrong = replaced(slow, parameters={"speed": "1 kg"})
    with pytest.raises(InputError, match="speed must be in m/s"):
        play(wrong, project)


def test_a_class_without_act_is_no_planner(project, catalog, planner):
    planner("told", "return 0.0, 0.0")
    file = project / "planners" / "told.py"
    file.write_text(file.read_text().replace("def act", "def think"))
    with pytest.raises(InputError, match="the class 'Told' has no 'act'"):
        catalog.load_mission("told.py:Told")


def test_without_code_no_python_planner_runs(project, planner):
    planner("told", "return 0.0, 0.0")
    catalog = Catalog(project, code=False)
    with pytest.raises(InputError, match="--no-code"):
        catalog.load_mission("told.py:Told")


def test_only_an_oracle_is_told_more(project, catalog, planner):
    planner("told", "return 0.0, 0.0", reset="self.privileged = task.privileged; assert task.privileged == {'map': 7}")
    runner = EpisodeRunner(project)
    setting = dataclasses.replace(runner.prepare(ScenarioScene("short")), privileged={"map": 7})
    blind = catalog.load_planner("told")
    seeing = replaced(blind, oracle=True)
    outcomes = [run(setting.with_planner(planner), setting.catalog).outcomes["R2"] for planner in (blind, seeing)]
    assert outcomes == ["failed", "timeout"]


@pytest.mark.parametrize("decided", ["0.1, 0.1, 0.1", "0.1", "'fast'", "float('nan'), 0.1", "0.1, float('inf')", "[]"])
def test_what_the_wheels_cannot_do_fails_and_says_so(project, catalog, planner, decided):
    name = planner("odd", f"return {decided}")
    record = play(catalog.load_planner(name), project)
    assert record.outcome == "failed"
    assert "act of Told returned" in record.reason
    assert "Return 2 wheel linear speeds in m/s (left, right), a Twist2, or None at the end." in record.reason


def test_an_error_tells_the_line_of_content_at_which_it_was_raised(project, catalog, planner):
    record = play(catalog.load_planner(planner("broken", "return 1 / 0")), project)
    assert record.outcome == "failed"
    assert record.reason.endswith("raised ZeroDivisionError: division by zero (broken.py:12); 3 exceptions within 10 s")
