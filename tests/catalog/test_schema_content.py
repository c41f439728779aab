"""A project's schema files: found, merged, checked, and given to its agents."""

import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.catalog import Catalog
from rocs_bt.check import check_content
from rocs_bt.knowledge import SCHEMA
from rocs_bt.running.build_agents import load_controller

CHARGER = 'format = "schema/1"\ndoc = "Chargers."\n[kind.charger]\nextends = "place"\n'


@pytest.fixture
def project(tmp_path):
    (tmp_path / "scenarios" / "schema").mkdir(parents=True)
    (tmp_path / "scenarios" / "schema" / "charging.toml").write_text(CHARGER, encoding="utf-8")
    return tmp_path


def test_what_we_ship_is_all_there_is_without_a_project():
    assert Catalog().load_schema() is SCHEMA


def test_a_projects_files_are_found_and_merged(project):
    catalog = Catalog.here(project)
    assert [entry.doc for entry in catalog.list("schema")] == ["Chargers."]
    assert catalog.load_schema().is_a("charger", "place")


def test_its_agents_have_it(project):
    catalog = Catalog(project)
    scenario = catalog.load_scenario("exp1")
    assert "charger" in load_controller(scenario, scenario.agents[0], catalog).schema.kinds
    assert any(entry.kind == "schema" for entry in catalog.content_of(scenario))
    assert not any(entry.kind == "schema" for entry in Catalog().content_of(scenario))


def test_a_check_tells_what_is_wrong_with_each_file_where_it_stands(project):
    other = project / "scenarios" / "schema" / "other.toml"
    other.write_text('format = "schema/1"\n[kind.wall_charger]\nextends = "charger"\n', encoding="utf-8")
    assert not check_content([project]).faults
    other.write_text('format = "schema/1"\n[kind.wall_charger]\nextends = "chargr"\n', encoding="utf-8")
    faults = check_content([project]).faults
    assert [(fault.file, fault.line) for fault in faults] == [(other, 3)]
    assert "Did you mean 'charger'" in faults[0].message
    with pytest.raises(InputError, match="chargr"):
        Catalog(project).load_schema()
