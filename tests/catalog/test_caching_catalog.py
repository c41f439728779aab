"""CachingCatalog: what it keeps is what a plain catalog would find."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocs_bt.base.errors import InputError
from rocs_bt.base.toml_table import read_toml
from rocs_bt.base.toml_text import as_data, as_toml, parse_toml
from rocs_bt.catalog import CachingCatalog, Catalog
from rocs_bt.declare import replaced


@pytest.mark.parametrize("parameters", [{}, {"planner": "visibility"}, {"planner": "any_angle"}])
def test_the_content_of_a_mind_is_that_of_its_own_parameters(parameters):
    catalog, plain = CachingCatalog(), Catalog()
    planner = plain.load_planner("hybrid")
    catalog.content_of_controller(planner)
    mind = replaced(planner, parameters={**planner.parameters, **parameters})
    for _ in range(2):
        assert catalog.content_of_controller(mind) == plain.content_of_controller(mind)


def test_a_scene_that_a_program_made_hides_one_of_the_project_and_the_rest_stays():
    catalog, world = CachingCatalog(), "<mujoco/>"
    shipped = catalog.find("scenario", "exp1")
    document = read_toml(shipped.path).data | {"duration": "7 s", "world": "exp1"}
    made = catalog.with_scene("exp1", document, world)
    assert made.load_scenario("exp1").duration == 7.0
    assert made.find("world", "exp1").text == world
    assert catalog.find("scenario", "exp1") == shipped
    assert made.list("rules") == catalog.list("rules") == Catalog().list("rules")


def test_what_is_wrong_in_a_scene_that_a_program_made_is_an_input_error():
    made = Catalog().with_scene("odd", {"format": "scenario/2", "world": "odd", "duration": "7 m"}, "<mujoco/>")
    with pytest.raises(InputError, match="the scenario has no agent") as caught:
        made.load_scenario("odd")
    assert {str(fault.file) for fault in caught.value.faults} == {"odd.toml"}


VALUES = st.one_of(st.booleans(), st.integers(-(2**60), 2**60), st.floats(allow_nan=False), st.text(max_size=8))
TABLES = st.dictionaries(
    st.text(max_size=6),
    st.one_of(VALUES, st.none(), st.lists(VALUES, max_size=3).map(tuple), st.dictionaries(st.just("k"), VALUES)),
    max_size=4,
)


@given(TABLES, st.lists(TABLES, max_size=3))
def test_a_document_is_read_from_its_text_as_it_is_as_a_value(root, tables):
    document = root | {"table": tables}
    assert parse_toml(as_toml(document), Path("made.toml"))[0] == as_data(document)
