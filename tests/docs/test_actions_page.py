"""docs/actions.md is what the declarations of the actions give."""

from . import actions


def test_the_page_is_up_to_date():
    assert actions.PAGE.read_text("utf-8") == actions.page(), "write it with: python tests/docs/actions.py"
