"""The generated parts of pages are those of docs/tables.py."""

import inspect

import pytest

from docs.tables import PAGES, PLANNER_CLASSES, ROOT
from rocs_bt.declare import docs_of


@pytest.mark.parametrize("page", [page for page in PAGES if page != "docs/bodies.md"])  # which takes 20 min
def test_the_page_is_up_to_date(page):
    text = (ROOT / page).read_text("utf-8")
    assert PAGES[page](text) == text, "run: python docs/tables.py"


@pytest.mark.parametrize("cls", PLANNER_CLASSES)
def test_every_attribute_of_what_a_planner_gets_is_explained(cls):
    assert inspect.get_annotations(cls).keys() <= docs_of(cls).keys()
