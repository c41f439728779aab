"""docs/bodies.md: its table has every body that EXP1 can be played on, with the figures of the campaign."""

from __future__ import annotations

import re

import pytest

from docs.tables import ROOT, bodies, body_row

TEXT = (ROOT / "docs/bodies.md").read_text("utf-8")
ROWS = {match[1]: match[0] for match in re.finditer(r"^\| `(\w+)` \|.*\n", TEXT, re.MULTILINE)}
(COMMAND,) = re.findall(r"<!-- (campaign.py .*) -->", TEXT)


def test_every_body_is_in_the_table():
    assert list(ROWS) == bodies()


def test_the_runs_of_a_row_add_up():
    for row in ROWS.values():
        cells = [cell.strip() for cell in row.strip("|\n ").split("|")]
        clean, of = map(int, cells[3].split(" of "))
        assert clean + sum(map(int, cells[5:9])) == of, row


@pytest.mark.soak
@pytest.mark.parametrize("robot", ROWS)
def test_a_campaign_gives_the_figures_of_the_page(robot):
    assert f"| {body_row(robot, COMMAND)} |\n" == ROWS[robot], "run: python docs/tables.py docs/bodies.md"
