"""Content is found by name, the project's first; Python content is loaded by path, once, and may be refused."""

from __future__ import annotations

import pickle
import shutil
import sys

import pytest

from rocs_bt.base.errors import InputError, UnknownName
from rocs_bt.catalog import Catalog, content_hash, find_project, shipped_root


def test_every_kind_is_found_with_its_first_sentence(project):
    own = [e for e in Catalog(project).list() if e.origin == "project"]
    assert [(e.kind, e.name, e.doc) for e in own] == [
        ("scenario", "walk", "A walk."),
        ("mission", "go", "Go there."),
        ("rules", "calm", "Stay calm."),
        ("robot", "bot", "A bot."),
        ("world", "room", "A room."),
    ]


def test_the_project_is_found_from_any_folder_inside_it(project):
    inside = project / "robots" / "bot"
    assert find_project(inside) == project.resolve()
    assert Catalog.here(inside).project == project.resolve()


def test_a_folder_without_content_is_no_project(tmp_path):
    (tmp_path / "rules").mkdir()
    assert find_project(tmp_path) is None


def test_a_project_that_does_not_exist_is_refused(tmp_path):
    with pytest.raises(InputError, match="there is no project folder"):
        Catalog(tmp_path / "nothing")
    with pytest.raises(InputError, match="there is no project folder"):
        Catalog(str(tmp_path / "nothing"))


def test_the_project_hides_a_shipped_name(project, monkeypatch, tmp_path):
    shipped = tmp_path / "shipped"
    shutil.copytree(project, shipped)
    (shipped / "rules" / "fierce.toml").write_text("")
    monkeypatch.setattr("rocs_bt.catalog.finder.shipped_root", lambda: shipped)
    origins = {e.name: e.origin for e in Catalog(project).list("rules")}
    assert origins == {"calm": "project", "fierce": "shipped"}


def test_in_the_shipped_folder_itself_everything_is_shipped():
    assert Catalog(shipped_root()).project is None


def test_content_is_found_by_its_path_too(project):
    entry = Catalog().find("robot", str(project / "robots" / "bot"))
    assert (entry.name, entry.origin) == ("bot", "file")
    with pytest.raises(UnknownName, match="no rule file is named"):
        Catalog().find("rules", str(project / "rules" / "clam.toml"))


def test_two_files_of_one_name_are_an_error(project):
    (project / "planners" / "missions" / "go.xml").write_text("<root/>")
    with pytest.raises(InputError, match="two mission files are named 'go'"):
        Catalog(project).list("mission")


def test_listing_and_finding_run_no_code(project):
    (project / "planners" / "missions" / "bomb.py").write_text('"""Bang."""\nraise SystemExit("it ran")\n')
    assert "bomb" in [e.name for e in Catalog(project).list("mission")]


def test_python_content_is_run_once_and_can_be_pickled(project):
    path = project / "planners" / "nodes" / "leaf.py"
    path.parent.mkdir()
    path.write_text("class Leaf:\n    def __eq__(self, other):\n        return type(other) is Leaf\n")
    catalog = Catalog(project)
    module = catalog.load_python(catalog.find("node", "leaf"))
    assert module is Catalog(project).load_python(catalog.find("node", "leaf"))
    assert sys.modules[module.__name__] is module
    assert pickle.loads(pickle.dumps(module.Leaf())) == module.Leaf()


def test_no_code_refuses_python_content(project):
    catalog = Catalog(project, code=False)
    with pytest.raises(InputError, match=r"go\.py: this Python content may not run"):
        catalog.load_python(catalog.find("mission", "go"))
    with pytest.raises(InputError, match="may not run"):
        catalog.load_scenario("walk")


def test_no_code_refuses_a_driver_beside_a_robot(project):
    robot = project / "robots" / "bot"
    (robot / "own.py").write_text("class Own:\n    pass\n")
    text = (robot / "robot.toml").read_text()
    (robot / "robot.toml").write_text(text.replace('driver = "position"', 'driver = "own.py:Own"'))
    with pytest.raises(InputError, match=r"own\.py: this Python content may not run"):
        Catalog(project, code=False).load_scenario("walk")


@pytest.mark.parametrize(
    ("code", "message"),
    [
        ("x = 1 +\n", r"go\.py:1:\d+: not valid Python"),
        ("x = 1\ny = 1 / 0\n", r"go\.py:2: running this file raised ZeroDivisionError"),
        ("import no_such_module\n", r"go\.py:1: running this file raised ModuleNotFoundError"),
    ],
)
def test_broken_python_is_an_input_error_with_its_line(project, code, message):
    (project / "planners" / "missions" / "go.py").write_text(code)
    catalog = Catalog(project)
    with pytest.raises(InputError, match=message):
        catalog.load_python(catalog.find("mission", "go"))


def test_a_class_is_loaded_by_its_path_and_name(project):
    own = project / "robots" / "bot" / "own.py"
    own.write_text("class Own:\n    pass\n")
    assert Catalog(project).load_class(own, "Own").__name__ == "Own"
    with pytest.raises(InputError, match=r"no class is named 'Owm'\. Did you mean 'Own'\?"):
        Catalog(project).load_class(own, "Owm")
    with pytest.raises(InputError, match="may not run"):
        Catalog(project, code=False).load_class(own, "Own")


def used(project):
    catalog = Catalog(project)
    return content_hash(catalog.content_of(catalog.load_scenario("walk")))


def test_the_hash_is_of_all_content_used_and_of_no_place(project, tmp_path):
    before = used(project)
    moved = tmp_path / "elsewhere"
    shutil.copytree(project, moved)
    assert used(moved) == before
    (project / "rules" / "unused.toml").write_text("x = 1")
    assert used(project) == before


@pytest.mark.parametrize(
    "file", ["robots/bot/robot.xml", "robots/bot/mesh.stl", "scenarios/worlds/room.xml", "rules/calm.toml"]
)
def test_the_hash_changes_with_any_file_used(project, file):
    before = used(project)
    with (project / file).open("a") as stream:
        stream.write("\n")
    assert used(project) != before


def test_the_hash_covers_what_an_xml_file_refers_to(project):
    (project / "scenarios" / "worlds" / "room.xml").write_text('<mujoco><include file="walls.xml"/></mujoco>')
    walls = project / "scenarios" / "worlds" / "walls.xml"
    walls.write_text("<mujoco/>")
    before = used(project)
    walls.write_text("<mujoco><!-- taller --></mujoco>")
    assert used(project) != before
