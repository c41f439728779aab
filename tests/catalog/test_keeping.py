"""KeepingCatalog: what it keeps is what a plain catalog would find."""

from dataclasses import replace

import pytest

from rocs_bt.catalog import Catalog, KeepingCatalog


@pytest.mark.parametrize("parameters", [{}, {"planner": "lattice"}, {"planner": "any_angle"}])
def test_the_content_of_a_mind_is_that_of_its_own_parameters(parameters):
    catalog, plain = KeepingCatalog(), Catalog()
    planner = plain.load_planner("hybrid")
    catalog.content_of_mind(planner)
    mind = replace(planner, parameters={**planner.parameters, **parameters})
    for _ in range(2):
        assert catalog.content_of_mind(mind) == plain.content_of_mind(mind)


def test_scenes_in_a_folder_hide_those_of_the_project_and_the_rest_stays(tmp_path):
    catalog = KeepingCatalog()
    shipped = catalog.find("scenario", "exp1")
    (tmp_path / "scenarios").mkdir()
    (tmp_path / "scenarios" / "exp1.toml").write_text(shipped.path.read_text("utf-8"), "utf-8")
    scenes = catalog.with_scenes(tmp_path)
    assert scenes.find("scenario", "exp1").path == tmp_path / "scenarios" / "exp1.toml"
    assert catalog.find("scenario", "exp1") == shipped
    assert scenes.list("rules") == catalog.list("rules") == Catalog().list("rules")
    assert scenes.with_scenes(tmp_path / "none").find("scenario", "exp1") == shipped
