"""A mission in Nav2's words drives a robot to its goal in MuJoCo, around a box and after failures."""

import json

import pytest

MISSION = """<root BTCPP_format="4" main_tree_to_execute="Navigate">
  <BehaviorTree ID="Navigate">
    <RecoveryNode number_of_retries="{retries}" name="navigate">
      <PipelineSequence name="plan and drive">
        <PlannerSelector default_planner="GridBased" selected_planner="{{planner}}" topic_name="planner_selector"/>
        <RateController hz="1.0">
          <RecoveryNode number_of_retries="1" name="plan">
            <ComputePathToPose goal="{{goal}}" path="{{path}}" planner_id="{{planner}}" error_code_id="{{plan_error}}"/>
            <Sequence>
              <WouldAPlannerRecoveryHelp error_code="{{plan_error}}"/>
              <ClearEntireCostmap service_name="global_costmap/clear_entirely_global_costmap"/>
            </Sequence>
          </RecoveryNode>
        </RateController>
        <RecoveryNode number_of_retries="1" name="drive">
          <FollowPath path="{{path}}" controller_id="FollowPath" error_code_id="{{drive_error}}"/>
          <ClearEntireCostmap service_name="local_costmap/clear_entirely_local_costmap"/>
        </RecoveryNode>
      </PipelineSequence>
      <ReactiveFallback name="recover">
        <GoalUpdated/>
        <RoundRobin name="in turn">
          <Wait wait_duration="0.5"/>
          <Spin spin_dist="0.8"/>
          <BackUp backup_dist="0.10" backup_speed="0.15"/>
        </RoundRobin>
      </ReactiveFallback>
    </RecoveryNode>
  </BehaviorTree>
</root>
"""
SCENARIO = """format = "scenario/1"
base = "exp1"
duration = "{duration}"
nodes = "{nodes}"

[[place]]
name = "box"
kind = "object"
x = "-0.5 m"
y = "{y}"
yaw = "0 deg"
length = "0.5 m"
width = "0.5 m"
agents = ["R2"]

[[agent]]
name = "R2"
mission = "navigation"
[agent.parameters]
{parameters}
"""


@pytest.fixture
def project(tmp_path):
    """Writes a project with the mission, and a scenario that plays it."""

    def write(nodes="nav2", parameters='goal = "goal"', y="1 m", retries=6, duration="60 s"):
        for folder in ("planners/missions", "scenarios"):
            (tmp_path / folder).mkdir(parents=True, exist_ok=True)
        (tmp_path / "planners/missions/navigation.xml").write_text(MISSION.format(retries=retries))
        text = SCENARIO.format(nodes=nodes, parameters=parameters, y=y, duration=duration)
        (tmp_path / "scenarios/drive.toml").write_text(text)
        return tmp_path

    return write


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_robot_reaches_the_goal_around_the_box(rocs_bt, project, seed):
    folder = project()
    ran = rocs_bt("run", "drive", "--seed", seed, "--out", folder / "out")
    assert ran.code == 0, ran.text
    (agent,) = json.loads((folder / "out/summary.json").read_text())["agents"].values()
    assert (agent["outcome"], agent["collisions"]) == ("success", 0)
    assert rocs_bt("replay", folder / "out").code == 0


def test_recoveries_are_tried_in_turn_and_then_it_fails(rocs_bt, project):
    folder = project(y="0 m", retries=3)  # the box stands beside the goal, as far as the robot knows
    (folder / "scenarios/drive.toml").write_text(
        (folder / "scenarios/drive.toml").read_text().replace('x = "-0.5 m"', 'x = "0 m"')
    )
    ran = rocs_bt("run", "drive", "--seed", 1, "--out", folder / "out")
    (agent,) = json.loads((folder / "out/summary.json").read_text())["agents"].values()
    assert agent["outcome"] == "failed", ran.text
    assert agent["path_length"] > 0.05  # it backed up


def test_the_project_and_the_mission_alone_are_fine(rocs_bt, project):
    folder = project()
    assert rocs_bt("check", folder).out.splitlines()[-1].endswith("checked: fine.")
    assert rocs_bt("check", folder / "planners/missions/navigation.xml").code == 0
    (folder / "elsewhere.xml").write_text(MISSION.format(retries=1))
    assert rocs_bt("check", "--nodes", "nav2", folder / "elsewhere.xml").code == 0
    assert "RateController" in rocs_bt("show", folder / "elsewhere.xml", "--nodes", "nav2").out


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        (
            {"nodes": "rocs", "parameters": ""},
            "'RateController' is a node of Nav2. Write nodes = \"nav2\" in the scenario",
        ),
        ({"nodes": "nav3"}, "nav2"),
        ({"parameters": ""}, "goal"),
    ],
)
def test_a_scenario_that_does_not_fit_is_refused(rocs_bt, project, changes, says):
    folder = project(**changes)
    checked = rocs_bt("check", folder)
    assert checked.code == 2
    assert says in checked.text


def test_the_palette_has_the_nodes_of_nav2(rocs_bt):
    text = rocs_bt("palette", "--nodes", "nav2").out
    for name in ("RateController", "FollowPath", "ComputePathToPose", "Spin", "GoalUpdated"):
        assert text.count(f' ID="{name}"') == 1
    assert '<input_port name="path"' in text.split('ID="FollowPath"')[1].split("</Action>")[0]
    assert "RateController" not in rocs_bt("palette").out
