"""Entry points of other packages: a command, and names that are wrong or taken."""

from __future__ import annotations

import sys

import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.base.registered import load, registered
from rocs_bt.studio.report import write_report

MODULE = """
import click
from rocs_bt.declare import Value

class Memory(Value):
    size: int = 3

def services(scenario, clock, seed):
    return dict.fromkeys([agent.name for agent in scenario.agents], lambda knowledge: None)

@click.command()
def hello():
    \"\"\"Greet.\"\"\"
    click.echo("hello")
"""


@pytest.fixture
def package(monkeypatch, tmp_path):
    """Installs a package with these entry points: its group, name and object, in each text."""

    def install(*points: str, name: str = "forgetful", module: str = "forgetful") -> None:
        info = tmp_path / "site" / f"{name}-1.0.dist-info"
        info.mkdir(parents=True)
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
        lines = (f"[{group}]\n{point} = {module}:{found}" for group, point, found in map(str.split, points))
        (info / "entry_points.txt").write_text("\n".join(lines))
        (info.parent / "forgetful.py").write_text(MODULE)
        monkeypatch.syspath_prepend(info.parent)
        registered.cache_clear()

    monkeypatch.setattr("rocs_bt.cli.doctor._renders", lambda kind: True)  # in a process of its own, which takes long
    yield install
    sys.modules.pop("forgetful", None)
    registered.cache_clear()


def test_a_package_adds_a_command_and_one_that_does_not_load_says_why(package, rocs_bt):
    package(
        "rocs_bt.commands hello hello",
        "rocs_bt.commands broken nothing",
        "rocs_bt.commands run hello",  # the core keeps its names
        "rocs_bt.report report nothing",  # and so do its wings
    )
    help_ = rocs_bt("--help").out
    assert "hello" in help_
    assert "Greet." in help_
    assert "cannot be loaded: module" in help_
    assert "registered as forgetful:nothing" in rocs_bt("broken").err
    assert rocs_bt("hello").out == "hello\n"
    assert "SCENARIO" in rocs_bt("run", "--help").out
    assert load("rocs_bt.report", "report") is write_report
    assert registered("rocs_bt.nothing") == {}
    with pytest.raises(InputError, match=r"'reprot'.*report"):
        load("rocs_bt.report", "reprot")


@pytest.mark.parametrize("name", ["memory", "robots.memory"])
def test_a_table_of_no_kind_of_file_is_told_where_a_file_has_it_and_by_doctor(package, rocs_bt, project, name):
    package(f"rocs_bt.tables {name} Memory")
    robot, scenario = next(project.glob("robots/*/robot.toml")), next(project.glob("scenarios/*.toml"))
    for file in (scenario, robot):
        text = file.read_text()
        assert rocs_bt("check", file).code == 0
        file.write_text(f"{text}\n[memory]\nsize = 4\n")
        told = rocs_bt("check", file)
        file.write_text(text)
        assert told.code == 2
        assert f"must have the name 'robot.memory' or 'scenario.memory', found '{name}'" in told.text
        assert "unknown key" not in told.text
        assert "It is registered as forgetful:Memory by the package forgetful." in told.text
    assert f"'scenario.memory', found '{name}'" in rocs_bt("doctor").out
    assert rocs_bt("show", "--schema", "robot").code == 0


def test_services_of_two_tables_for_one_agent_are_refused(package, rocs_bt, project):
    package("rocs_bt.tables scenario.memory Memory", "rocs_bt.services memory services")
    scenario = next(project.glob("scenarios/*.toml"))
    scenario.write_text(f"{scenario.read_text()}\n[share]\n\n[memory]\n")
    told = rocs_bt("check", scenario)
    assert told.code == 2
    assert "has services of two tables, [memory] and [share]." in told.text


def test_two_packages_with_one_name_are_refused(package, rocs_bt):
    package("rocs_bt.commands recall hello")
    package("rocs_bt.commands recall hello", name="mindful")
    told = rocs_bt("recall")
    assert told.code == 2
    assert "the command 'recall' is registered by the packages forgetful and mindful. Remove one." in told.text
    assert "is registered by the packages forgetful and mindful" in rocs_bt("doctor").out


def test_a_checkout_has_nothing_of_an_older_state_of_it_that_is_installed(package, rocs_bt, project):
    package("rocs_bt.tables ros2 Ros2Settings", name="rocs_bt", module="rocs_bt.ros2.settings")
    scenario = next(project.glob("scenarios/*.toml"))
    scenario.write_text(f"{scenario.read_text()}\n[ros2]\n")
    assert "unknown key 'ros2'" in rocs_bt("check", scenario).text
    assert "registered" not in rocs_bt("doctor").out


def test_an_installation_keeps_its_names_and_doctor_lists_others(package, rocs_bt, monkeypatch, tmp_path):
    monkeypatch.setattr("rocs_bt.base.registered._PROJECT", tmp_path / "pyproject.toml")
    package("rocs_bt.commands search command", name="rocs_bt", module="rocs_bt.search.command")
    package("rocs_bt.commands search hello", "rocs_bt.commands run hello", "rocs_bt.commands hello hello")
    assert set(registered("rocs_bt.commands")) == {"search", "run", "hello"}
    assert registered("rocs_bt.commands")["search"].value == "rocs_bt.search.command:command"
    told = rocs_bt("doctor").out
    assert "the command 'search' of the package forgetful is not used: rocs_bt has one of this name. Rename it." in told
    assert "the command 'run' of the package forgetful is not used" in told
    assert "'hello'" not in told
