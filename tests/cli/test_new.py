"""`rocs-bt new`: a project, and further files in it."""

import pytest

from rocs_bt import run
from rocs_bt.catalog import Catalog
from rocs_bt.compare.episode import FamilyScene
from rocs_bt.compare.runner import EpisodeRunner

KINDS = ["mission", "rules", "robot", "scenario", "planner"]


@pytest.fixture
def project(rocs_bt, tmp_path, monkeypatch):
    """A new project, whose folder is the current one."""
    assert rocs_bt("new", "mine").code == 0
    monkeypatch.chdir(tmp_path / "mine")
    return tmp_path / "mine"


def files(folder):
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_shipped_content_is_copied_and_passes_the_check(rocs_bt, project):
    shipped = {
        "scenario": "exp1",
        "mission": "navigate",
        "rules": "avoid_collision",
        "robot": "jackal",
        "planner": "tree",
    }
    for kind, name in shipped.items():
        told = rocs_bt("new", name, "--kind", kind, "--copy")
        assert (told.code, f"it hides the shipped {kind} '{name}'" in told.out) == (0, True)
        assert rocs_bt("new", name, "--kind", kind, "--copy").code == 2
    assert rocs_bt("check", "--strict").code == 0
    for wrong in (["--copy"], ["--copy", "--kind", "mission", "--python"]):
        assert "--copy needs --kind alone" in rocs_bt("new", "exp1", *wrong).err


def test_a_file_of_each_kind_is_added_and_all_together_run(rocs_bt, project):
    told = {kind: rocs_bt("new", f"my_{kind}", "--kind", kind) for kind in KINDS}
    assert {kind: t.code for kind, t in told.items()} == dict.fromkeys(KINDS, 0)
    assert rocs_bt("new", "my-python", "--kind", "mission", "--python").code == 0
    for kind in KINDS:
        assert Catalog(project).find(kind, f"my_{kind}").path.is_relative_to(project), kind
        assert f"my_{kind}" in told[kind].out.partition("Try next: rocs-bt ")[2], kind
    assert (project / "robots/my_robot/robot.xml").is_file()
    assert rocs_bt("rules", "test", "my_rules").code == 0
    checked = rocs_bt("check", "--strict")
    assert (checked.code, checked.text) == (0, "14 files checked: no faults.\n")
    scenario = project / "scenarios/my_scenario.toml"
    assert rocs_bt("run", "my_scenario", "--no-report").code == 0
    text = scenario.read_text("utf-8")
    for old, new in (
        ('robot = "jackal"', 'robot = "my_robot"'),
        ('mission = "navigate"', 'mission = "my_mission"'),
        ('rules = ["contact"]', 'rules = ["my_rules"]'),
        ('goal = "goal"\ncruise', 'first = "goal"\nsecond = "goal"\ncruise'),
    ):
        assert old in text
        text = text.replace(old, new)
    scenario.write_text(text, "utf-8")
    own = rocs_bt("run", "my_scenario", "--no-report")
    assert (own.code, "R1 success" in own.out) == (0, True), own.text


def test_it_adds_to_the_project_around_the_current_folder(rocs_bt, project, monkeypatch):
    (project / "notes/today").mkdir(parents=True)
    monkeypatch.chdir(project / "notes/today")
    assert rocs_bt("new", "gap", "--kind", "scenario").code == 0
    assert (project / "scenarios/gap.toml").is_file()
    assert (project / "scenarios/worlds/gap.xml").is_file()
    assert not any((project / "notes/today").iterdir())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["patrol", "--kind", "mission"], "the mission 'patrol' already exists"),  # in Python
        (["a b", "--kind", "mission"], "'a b' is not a valid name"),
        (["", "--kind", "rules"], "'' is not a valid name"),
    ],
)
def test_a_refused_call_says_why_and_writes_nothing(rocs_bt, project, arguments, message):
    before = files(project)
    told = rocs_bt("new", *arguments)
    assert (told.code, told.out) == (2, "")
    assert message in told.err
    assert files(project) == before
    assert sorted(path.name for path in project.iterdir() if path.is_dir()) == [
        "planners",
        "robots",
        "rules",
        "scenarios",
        "tests",
    ]


def test_outside_a_project_there_is_nothing_to_add_to(rocs_bt, tmp_path):
    told = rocs_bt("new", "mine", "--kind", "rules")
    assert told.code == 2
    assert f"there is no project in '{tmp_path}' or above. Create a project with `rocs-bt new my_project`" in told.err
    assert not any(tmp_path.iterdir())


def test_hiding_shipped_content_is_told(rocs_bt, project):
    told = rocs_bt("new", "jackal", "--kind", "robot")
    assert not (project / "robots/jackal/identified.toml").exists(), "it is that of another body"
    assert "In this project it hides the shipped robot 'jackal'." in told.out


@pytest.mark.parametrize("python", [[], ["--python"]], ids=["mission", "python"])
@pytest.mark.parametrize("family", [entry.name for entry in Catalog().list("family")])
def test_a_new_planner_of_a_family_drives_in_its_scenes_without_an_edit(rocs_bt, project, family, python):
    told = rocs_bt("new", "my-own", "--kind", "planner", "--family", family, *python)
    assert (told.code, f"rocs-bt compare my-own tree --family {family} --scenes 5" in told.out) == (0, True), told.text
    runner = EpisodeRunner(project)
    scene = runner.prepare(FamilyScene(family, 1))
    spec = scene.with_planner(runner.catalog.load_planner("my-own"))
    found = run(spec, scene.catalog, duration=1.0).summary.agents["R"]
    assert found.exceptions == {}, found.reason
    assert 0.02 < found.path_length < 2.0


def test_a_new_planner_of_a_family_does_what_the_agent_of_each_scene_does(rocs_bt, project):
    assert rocs_bt("new", "mine", "--kind", "planner", "--family", "exp2_family").code == 0
    planner = Catalog(project).load_planner("mine")
    assert (planner.mission, planner.rules) == ("go_to", ("avoid_collision",))
    assert planner.parameters == {"goal": "goal", "hold": True}, "facing differs between the scenes"
    assert rocs_bt("new", "other", "--kind", "planner", "--python").code == 0
    assert rocs_bt("check", "--strict").code == 0
