"""Shipped content that a person copies into a project, to change it."""

import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.catalog import Catalog, copy_content

SHIPPED = [
    (kind, entry.name)
    for kind in ("scenario", "mission", "rules", "robot", "planner")
    for entry in Catalog().list(kind)
]


@pytest.mark.parametrize(("kind", "name"), SHIPPED, ids=lambda each: each)
def test_all_that_is_shipped_can_be_copied_and_loads_from_the_copy(kind, name, tmp_path):
    catalog = Catalog(tmp_path)
    before = catalog.find(kind, name)
    path = copy_content(catalog, kind, name)
    catalog = catalog.fresh()
    found = catalog.find(kind, name)
    assert (found.origin, found.path) == ("project", path)
    assert [data for _, data in found.contents()] == [data for _, data in before.contents()]
    if kind != "rules":
        getattr(catalog, f"load_{kind}")(name)
    with pytest.raises(InputError, match="is not shipped"):
        copy_content(catalog, kind, name)


def test_the_tests_of_rules_are_copied_too(tmp_path):
    copy_content(Catalog(tmp_path), "rules", "avoid_collision")
    assert (tmp_path / "rules/tests/avoid_collision.toml").is_file()


def test_a_file_of_the_project_is_kept(tmp_path):
    (tmp_path / "rules/tests").mkdir(parents=True)
    (tmp_path / "rules/tests/avoid_collision.toml").write_text("mine")
    with pytest.raises(InputError, match=r"has a file '.*avoid_collision\.toml' already\. Rename it first\."):
        copy_content(Catalog(tmp_path), "rules", "avoid_collision")
    assert not (tmp_path / "rules/avoid_collision.toml").exists()
    with pytest.raises(InputError, match="no scenario is named"):
        copy_content(Catalog(tmp_path), "scenario", "nothing")
    with pytest.raises(InputError, match="no project to copy"):
        copy_content(Catalog(), "scenario", "exp1")


def test_nothing_is_copied_through_a_link_out_of_the_project(tmp_path):
    project, outside = tmp_path / "project", tmp_path / "outside"
    project.mkdir()
    outside.mkdir()
    (project / "robots").symlink_to(outside)
    with pytest.raises(InputError, match="outside"):
        copy_content(Catalog(project), "robot", "jackal")
    assert [*outside.iterdir()] == []
