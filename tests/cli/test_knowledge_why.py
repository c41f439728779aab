"""`rocs-bt knowledge why`: from a run, what was chosen and why."""

from pathlib import Path

import pytest

from rocs_bt import run
from rocs_bt.catalog import Catalog

ROOT = Path(__file__).resolve().parents[2]
MISSION = """
<root BTCPP_format="4">
  <BehaviorTree ID="errand">
    <UseStrategy selected="{way}">
      <Switch2 variable="{way}" case_1="through" case_2="around">
        <Sequence><Sleep msec="300"/><AlwaysFailure name="shut"/></Sequence>
        <Sleep msec="300"/>
        <AlwaysFailure/>
      </Switch2>
    </UseStrategy>
  </BehaviorTree>
</root>
"""
FACTS = """
[[fact]]
node = "around"
kind = "strategy"

[[fact]]
node = "through"
kind = "strategy"
preference = 0.5
falls_back_to = "around"
"""


@pytest.fixture(scope="module")
def played(tmp_path_factory):
    project = tmp_path_factory.mktemp("project")
    for folder in ("scenarios", "planners/missions"):
        (project / folder).mkdir(parents=True)
    (project / "planners" / "missions" / "errand.xml").write_text(MISSION, "utf-8")
    scenario = (ROOT / "scenarios" / "exp1.toml").read_text("utf-8")
    head, _, rest = scenario.partition("[[agent]]")
    agent = rest.partition("[[actor]]")[0]
    agent = agent.partition("[agent.parameters]")[0].replace('mission = "go_to"', 'mission = "errand"')
    assert "errand" in agent
    (project / "scenarios" / "errand.toml").write_text(f"{head}{FACTS}\n[[agent]]{agent}", "utf-8")
    run("errand", Catalog(project), out=project / "out", duration=2.0, report=False)
    return project / "out"


@pytest.fixture
def told(rocs_bt):
    def told(*arguments):
        answer = rocs_bt("knowledge", "why", *arguments)
        assert (answer.code, answer.err) == (0, "")
        return answer.out

    return told


def test_each_use_is_told_with_its_reasons_and_its_outcome(told, played):
    lines = told(played).splitlines()
    assert lines[0].split("  ")[1:] == ["through", "failure: shut"]
    assert lines[1] == "    situation: no questions"
    assert lines[2] == "    through: +0.50 (preference 0.5, not tried)"
    around = next(i for i, line in enumerate(lines) if line.split("  ")[1] == "around")
    assert lines[around].endswith("success")
    assert lines[around + 1] == "    'through' falls back to it"
    assert any("through: no, it has just failed" in line for line in lines[around:])


def test_at_a_time_the_one_in_force_is_told(told, played):
    assert "  through  " in told(played, "--at", "0.1")
    assert "No strategy of R2 was active at 1.9 s." in told(played, "--at", "1.9")


def test_a_run_without_strategies_says_so(told, tmp_path):
    run("exp1", out=tmp_path / "out", duration=0.2, report=False)
    assert "No strategy of R2 was active. Missions choose strategies with UseStrategy" in told(tmp_path / "out")
