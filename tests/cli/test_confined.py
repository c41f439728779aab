"""Content names files of its project alone: paths, links, and whatever MJCF can name, through `check` and `run`."""

from __future__ import annotations

import os
import struct
from pathlib import Path

import pytest

from ..changes import edit
from .conftest import refused

SCENARIO, WORLD = "scenarios/first.toml", "scenarios/worlds/yard.xml"
STL = (
    b"\0" * 80
    + struct.pack("<I", 4)
    + b"".join(
        struct.pack("<12fH", 0, 0, 0, *a, *b, *c, 0)
        for a, b, c in (
            ((0, 0, 0), (0, 1, 0), (1, 0, 0)),
            ((0, 0, 0), (1, 0, 0), (0, 0, 1)),
            ((0, 0, 0), (0, 0, 1), (0, 1, 0)),
            ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
        )
    )
)


@pytest.fixture
def outside(project) -> Path:
    """A folder beside the project, with a copy of all that the project has."""
    import shutil

    return Path(shutil.copytree(project, project.parent / "outside"))


@pytest.mark.parametrize(
    ("command", "absolute"), [(("check",), True), (("run", "first"), False)], ids=["check-absolute", "run-relative"]
)
@pytest.mark.parametrize(
    ("key", "path"),
    [
        ("world", "scenarios/worlds/yard.xml"),
        ("robot", "robots/rover/robot.toml"),
        ("mission", "planners/missions/patrol.py"),
        ("rules", "rules/keep_clear.toml"),
        ("base", "scenarios/first.toml"),
    ],
)
def test_a_path_in_a_scenario_leads_to_no_other_folder(project, outside, rocs_bt, command, absolute, key, path):
    named = outside / path if absolute else Path("..") / "outside" / path
    old = {"rules": 'rules = ["keep_clear"]', "base": "doc = "}.get(key, f'{key} = "')
    new = {"rules": f'rules = ["{named}"]', "base": f'base = "{named}"\ndoc = '}.get(key, f'{key} = "{named}" # "')
    edit(project / SCENARIO, old, new)
    refused(rocs_bt(*command), "first.toml:", f"'{named}'", f"is outside of '{project}'")


def test_a_file_that_is_not_there_is_not_told_apart_from_one_that_is(project, rocs_bt):
    for path in ("/etc/passwd", "/etc/no_such_file"):
        edit(project / SCENARIO, 'world = "yard"', f'world = "{path}"')
        refused(rocs_bt("check"), f"'{path}' is outside of")
        edit(project / SCENARIO, f'world = "{path}"', 'world = "yard"')


def test_paths_in_the_project_and_files_that_a_person_names_are_fine(project, outside, rocs_bt):
    edit(project / SCENARIO, 'world = "yard"', 'world = "scenarios/worlds/yard.xml"')
    assert rocs_bt("check").code == 0
    assert rocs_bt("check", outside / SCENARIO).code == 0


@pytest.mark.parametrize("name", ["mission", "python", "rules"])
def test_a_planner_names_files_of_its_project_alone(project, outside, rocs_bt, name):
    (outside / "planners" / "own.py").write_text("class Own:\n    pass\n")
    file = project / "planners" / "brisk.toml"
    key = {
        "mission": f'mission = "{outside}/planners/missions/patrol.py"\nrules = []',
        "python": 'python = "../../outside/planners/own.py:Own"\nrules = []',
        "rules": f'mission = "patrol"\nrules = ["{outside}/rules/keep_clear.toml"]',
    }[name]
    file.write_text(f'format = "planner/1"\n{key}\n')
    refused(rocs_bt("check", file), "brisk.toml:", "is outside of")


LINKS = [
    SCENARIO, WORLD, "robots/rover", "robots/rover/robot.toml", "robots/rover/robot.xml", "rules/keep_clear.toml",
    "planners/missions/patrol.py", "planners/brisk.toml",
]  # fmt: skip  # paths, several on a line


@pytest.mark.parametrize("path", LINKS)
def test_a_link_out_of_the_project_is_refused(project, outside, rocs_bt, path):
    place = project / path
    place.rename(place.with_name("moved"))
    if place.with_name("moved").is_dir():
        (project / "robots" / "moved").rename(project.parent / "moved")
    place.symlink_to(outside / path)
    refused(rocs_bt("check"), "outside of" if path != "robots/rover/robot.xml" else "is not in the robot's folder")
    if not path.endswith("brisk.toml"):
        refused(rocs_bt("run", "first"))


def test_a_link_within_the_project_is_fine(project, rocs_bt):
    (project / WORLD).rename(project / "yard.xml")
    (project / WORLD).symlink_to(project / "yard.xml")
    assert rocs_bt("check").code == 0


def test_an_include_of_a_mission_does_not_follow_a_link_out_of_the_project(project, outside, rocs_bt):
    tree = '<root BTCPP_format="4"><BehaviorTree ID="Far"><AlwaysSuccess/></BehaviorTree></root>'
    (outside / "far.xml").write_text(tree)
    (project / "planners" / "missions" / "far.xml").symlink_to(outside / "far.xml")
    file = project / "planners" / "missions" / "near.xml"
    file.write_text(
        '<root BTCPP_format="4"><include path="far.xml"/>'
        '<BehaviorTree ID="Near"><SubTree ID="Far"/></BehaviorTree></root>'
    )
    refused(rocs_bt("check", file), "near.xml:1:", "'far.xml', which leads to ", "is outside of")


def test_a_rule_file_includes_nothing_by_a_link_out_of_the_project(project, outside, rocs_bt):
    (project / "rules" / "far.toml").symlink_to(outside / "rules" / "keep_clear.toml")
    (project / "rules" / "near.toml").write_text('format = "reflex/1"\ninclude = ["far.toml"]\n')
    refused(rocs_bt("check", project / "rules" / "near.toml"), "near.toml:2:1: 'far.toml', which leads to ")


def test_tests_of_rules_are_not_read_by_a_link_out_of_the_project(project, outside, rocs_bt):
    (outside / "secret.toml").write_text("[database]\npassword = 1\n")
    (project / "rules" / "tests").mkdir(exist_ok=True)
    (project / "rules" / "tests" / "keep_clear.toml").symlink_to(outside / "secret.toml")
    for command in (("check", "rules/keep_clear.toml"), ("rules", "test", "keep_clear")):
        told = rocs_bt(*command)
        refused(told, "keep_clear.toml", "which leads to")
        assert "database" not in told.text


MJCF = {
    "include": '<include file="{far}.xml"/>',
    "include of an include": '<include file="near.xml"/>',
    "mesh": '<asset><mesh name="m" file="{far}.stl"/></asset>',
    "texture": '<asset><texture name="t" type="2d" file="{far}.png"/></asset>',
    "side of a texture": '<asset><texture name="t" type="cube" fileright="{far}.png"/></asset>',
    "height field": '<asset><hfield name="h" size="1 1 1 1" file="{far}.png"/></asset>',
    "skin": '<asset><skin name="s" file="{far}.skn"/></asset>',
    "flex": '<worldbody><body><flexcomp name="f" type="mesh" file="{far}.stl"/></body></worldbody>',
    "model": '<asset><model name="m" file="{far}.xml"/></asset>',
    "folder": '<compiler meshdir="{folder}"/><asset><mesh name="m" file="far.stl"/></asset>',
    "folder after": '<asset><mesh name="m" file="far.stl"/></asset><compiler meshdir="{folder}"/>',
    "folder of assets": '<compiler assetdir="{folder}"/><asset><texture name="t" type="2d" file="far.png"/></asset>',
    "link": '<asset><mesh name="m" file="link.stl"/></asset>',
}


@pytest.mark.parametrize("element", MJCF.values(), ids=MJCF.keys())
@pytest.mark.parametrize(
    ("command", "absolute"), [(("check",), True), (("run", "first"), False)], ids=["check-absolute", "run-relative"]
)
def test_a_world_names_files_of_the_project_alone(project, outside, rocs_bt, command, absolute, element):
    folder = str(outside) if absolute else os.path.relpath(outside, project / "scenarios" / "worlds")
    (outside / "far.stl").write_bytes(STL)
    for name in ("far.xml", "far.png", "far.skn"):
        (outside / name).write_text("<mujoco/>")
    (project / WORLD).with_name("link.stl").symlink_to(outside / "far.stl")
    (project / WORLD).with_name("near.xml").write_text(f'<mujoco><include file="{folder}/far.xml"/></mujoco>')
    edit(project / WORLD, "<worldbody>", element.format(far=f"{folder}/far", folder=folder) + "<worldbody>")
    refused(rocs_bt(*command), ".xml:", "is outside of", str(project))


@pytest.mark.parametrize("element", ['<mesh name="m" file="../../meshes/box.stl"/>', '<mesh name="m" file="box.stl"/>'])
def test_a_robot_may_name_files_elsewhere_in_its_project(project, rocs_bt, element):
    (project / "meshes").mkdir()
    (project / "meshes" / "box.stl").write_bytes(STL)
    body = project / "robots" / "rover" / "robot.xml"
    folder = "" if "../" in element else '<compiler meshdir="../../meshes"/>'
    edit(body, "<worldbody>", f"{folder}<asset>{element}</asset><worldbody>")
    told = rocs_bt("check")
    assert told.code == 0, told.out + told.err


def test_a_model_that_strips_paths_names_files_beside_itself(project, rocs_bt):
    (project / WORLD).with_name("box.stl").write_bytes(STL)
    edit(
        project / WORLD,
        "<worldbody>",
        '<compiler strippath="true"/><asset><mesh name="m" file="/home/me/box.stl"/></asset><worldbody>',
    )
    told = rocs_bt("check")
    assert told.code == 0, told.out + told.err


def test_a_document_type_is_refused(project, rocs_bt):
    file = project / WORLD
    file.write_text('<!DOCTYPE mujoco [<!ENTITY a SYSTEM "/etc/passwd">]>\n' + file.read_text())
    refused(rocs_bt("check"), "yard.xml:1:", "an MJCF file must not have a document type")
