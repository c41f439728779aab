"""Edits of a mission's text keep every other line, and are undone exactly by the edit back."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.base.nesting import descendants
from rocs_bt.studio.editing import insert, move, parse, remove, set_attribute
from tests.cli.nav2_mission import mission

SHIPPED = sorted((Path(__file__).parents[2] / "planners" / "missions").glob("*.xml"))
LAYOUT = """<?xml version="1.0"?>
<!-- top -->
<root BTCPP_format="4">  <!-- about root -->
  <BehaviorTree ID="A"> <!-- about A -->
    <Sequence><A/><B x="1 &gt; &quot;0&quot;"/><C/></Sequence>
  </BehaviorTree>

  <!-- about B
       in two lines -->
  <BehaviorTree ID="B">
\t  <Fallback
        name="x"
        _skipIf='a > b'>

      <!-- one -->
      <X/>  <!-- behind X -->

      <Y>
         <Z/>
      </Y>
      <W></W>
      <R />
    </Fallback>
  </BehaviorTree>
</root>
"""


def places(text: str, seed: int, count: int) -> list[tuple[tuple[int, ...], tuple[int, ...], int]]:
    """Moves of nodes into places outside of them; all of them if there are fewer than `count`."""
    elements = [e for e in descendants(parse(text)) if e.tag]
    found = [
        (node.path, parent.path, index)
        for node in elements
        if len(node.path) > 1
        for parent in elements
        if parent.path[: len(node.path)] != node.path
        for index in range(len(parent.children) + 1)
    ]
    return random.Random(seed).sample(found, count) if len(found) > count else found


def there_now(node: tuple[int, ...], parent: tuple[int, ...], index: int) -> tuple[tuple[int, ...], int]:
    """Parent and index of a node after its move."""
    home, own = node[:-1], node[-1]
    if parent == home:
        return parent, index - (index > own)
    if parent[: len(home)] == home and parent[len(home)] > own:
        return (*home, parent[len(home)] - 1, *parent[len(home) + 1 :]), index
    return parent, index


def away_and_back(text: str, node: tuple[int, ...], parent: tuple[int, ...], index: int) -> tuple[str, str]:
    """Text after a move, and after the move back."""
    moved = move(text, node, parent, index)
    home, own = node[:-1], node[-1]
    there, at = there_now(node, parent, index)
    # Where the old place is while the node is at the new one.
    back, place = home, own
    if there == home:
        place += own >= at
    elif home[: len(there)] == there and home[len(there)] >= at:
        back = (*there, home[len(there)] + 1, *home[len(there) + 1 :])
    return moved, move(moved, (*there, at), back, place)


@pytest.mark.parametrize("file", [*SHIPPED, "nav2", "layout"], ids=lambda f: getattr(f, "stem", f))
def test_a_node_moved_away_and_back_is_where_it_was_byte_for_byte(file):
    text = {"nav2": mission(), "layout": LAYOUT}[file] if isinstance(file, str) else file.read_text("utf-8")
    tags = sorted(e.tag for e in descendants(parse(text)))
    wrong = 0
    for node, parent, index in places(text, 1, 250):
        moved, back = away_and_back(text, node, parent, index)
        document = parse(moved)
        assert document is not None, (node, parent, index)
        assert sorted(e.tag for e in descendants(document)) == tags
        wrong += back != text
    assert wrong == 0


@pytest.mark.parametrize("file", [*SHIPPED, "layout"], ids=lambda f: getattr(f, "stem", f))
def test_a_move_changes_nothing_but_the_node(file):
    """Without the node, the text is the same wherever the node was."""
    text = LAYOUT if isinstance(file, str) else file.read_text("utf-8")
    for node, parent, index in places(text, 2, 60):
        there, at = there_now(node, parent, index)
        assert remove(move(text, node, parent, index), (*there, at)) == remove(text, node), (node, parent, index)


def test_comments_travel_with_their_node():
    document = parse(LAYOUT)
    x = next(e for e in descendants(document) if e.tag == "X")
    moved = move(LAYOUT, x.path, (0, 0, 0), 3)
    assert "<!-- one -->" not in remove(LAYOUT, x.path)
    assert "behind X" not in remove(LAYOUT, x.path)
    inside = next(e for e in descendants(parse(moved)) if e.tag == "Sequence")
    assert "<!-- one -->" in moved[inside.start : inside.end]
    assert "<!-- behind X -->" in moved[inside.start : inside.end]


def test_a_new_node_is_indented_as_its_siblings_and_removed_without_a_trace():
    text = SHIPPED[0].read_text("utf-8")
    for element in descendants(parse(text)):
        if element.tag in ("root", "") or element.path[:1] != (0,):
            continue
        for index in range(len(element.children) + 1):
            new = insert(text, element.path, index, '<Wait duration="1 s"/>')
            assert parse(new).at((*element.path, index)).tag == "Wait"
            assert remove(new, (*element.path, index)) == text


@pytest.mark.parametrize("value", ["2", 'a "b" <c> & d', "x\ny\tz", "{key}", "'", "ä → 漢"])
def test_an_attribute_has_the_value_that_was_set_and_nothing_else_changes(value):
    for element in descendants(parse(LAYOUT)):
        if not element.tag:
            continue
        for name in ("new", *(a.name for a in element.attributes)):
            changed = set_attribute(LAYOUT, element.path, name, value)
            assert parse(changed).at(element.path).value(name) == value
            assert [e.tag for e in descendants(parse(changed))] == [e.tag for e in descendants(parse(LAYOUT))]
            assert set_attribute(set_attribute(changed, element.path, name, "1"), element.path, name, value) == changed
        assert set_attribute(set_attribute(LAYOUT, element.path, "new", value), element.path, "new", None) == LAYOUT


def test_what_cannot_be_edited_is_refused():
    with pytest.raises(InputError, match="not well-formed"):
        remove("<root><A></root>", (0, 0))
    with pytest.raises(InputError, match="into itself"):
        move(LAYOUT, (0, 1), (0, 1, 0), 0)
    with pytest.raises(InputError, match="no place 9"):
        insert(LAYOUT, (0,), 9, "<A/>")
    with pytest.raises(InputError, match="no node at 0/7"):
        remove(LAYOUT, (0, 7))


def test_a_text_in_the_middle_of_typing_still_has_its_elements():
    text = SHIPPED[0].read_text("utf-8")
    for end in range(0, len(text), 7):
        document = parse(text[:end], tolerant=True)
        assert all(0 <= e.start <= e.inner <= e.close <= e.end <= end for e in descendants(document))
