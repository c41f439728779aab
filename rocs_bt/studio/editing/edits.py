"""Edits of a mission's XML text: insert, remove and move nodes, set attributes.

Every other line keeps its bytes. A node's block is the white space and the comments before it, the node, and a comment
behind it on its line; blocks of siblings touch, so that what was moved away and back is where it was.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any, NamedTuple
from xml.sax.saxutils import quoteattr

from ...base.errors import Fault, InputError, unknown
from .elements import ENTITIES, Element, parse

Path = tuple[int, ...]

_COMMENT_BEHIND = re.compile(r"[ \t]*<!--[^\n]*?-->")
_SPACE = re.compile(r"\s*")
_UNIT = re.compile(r"\n([ \t]+)<")


def edit(text: str, asked: Mapping[str, Any]) -> tuple[str, Path]:
    """Text after an edit that an editor describes, and the path of the node afterwards.

    Args:
        text: Text of the mission.
        asked: `do`, one of `insert`, `remove`, `move` and `set`, with the arguments of that function; paths are texts
            such as `0/1/2`. Without `index`, a node becomes the last child.

    Raises:
        InputError: The text is not well-formed, the place does not exist, or an argument is missing.
    """
    try:
        if asked["do"] == "set":
            node = _path(asked["node"])
            return set_attribute(text, node, str(asked["name"]), asked["value"]), node
        if asked["do"] == "remove":
            node = _path(asked["node"])
            return remove(text, node), node[:-1]
        parent = _path(asked["parent"])
        index = asked.get("index", len(_element(_document(text), parent).children))
        if asked["do"] == "insert":
            return insert(text, parent, index, str(asked["new"])), (*parent, index)
        if asked["do"] == "move":
            node = _path(asked["node"])
            return move(text, node, parent, index), _moved(node, parent, index)
    except (KeyError, ValueError, TypeError, AttributeError) as error:
        raise InputError(f"the edit cannot be read: {error}.") from error
    raise InputError(unknown("edit", str(asked["do"]), ("insert", "remove", "move", "set")))


def _path(written: str) -> Path:
    return tuple(int(part) for part in written.split("/"))


def _moved(node: Path, parent: Path, index: int) -> Path:
    """Path of a node after its move."""
    depth, own = len(node) - 1, node[-1]
    if parent == node[:-1]:
        index -= index > own
    elif parent[:depth] == node[:-1] and parent[depth] > own:
        parent = (*parent[:depth], parent[depth] - 1, *parent[depth + 1 :])
    return (*parent, index)


def insert(text: str, parent: Path, index: int, node: str) -> str:
    """Text with a new node.

    Args:
        text: Text of the mission.
        parent: Path of the parent, as of `Element.path`.
        index: Index of the child before which the node is inserted; the number of children to append it.
        node: Text of the node, such as `<Wait duration="1 s"/>`.

    Raises:
        InputError: The text is not well-formed, or there is no such place.
    """
    place = _place(text, parent, index)
    return _put(text, place, place.lead + node.strip())


def remove(text: str, node: Path) -> str:
    """Text without a node and its comments.

    Raises:
        InputError: The text is not well-formed, or there is no such node.
    """
    return _taken(text, node)[1]


def move(text: str, node: Path, parent: Path, index: int) -> str:
    """Text in which a node has another place.

    Args:
        text: Text of the mission.
        node: Path of the node.
        parent: Path of its new parent, before the node is taken away.
        index: Index of the child of `parent` before which it is inserted, before the node is taken away.

    Raises:
        InputError: The text is not well-formed, there is no such place, or it is inside the node.
    """
    if parent[: len(node)] == node:
        raise InputError(Fault("a node cannot be moved into itself.", hint="Choose a place outside of it."))
    _place(text, parent, index)  # refuses a place that does not exist
    block, rest = _taken(text, node)
    *above, index = _moved(node, parent, index)
    home, place = _place(rest, node[:-1], node[-1]), _place(rest, tuple(above), index)
    return _put(rest, place, _fitted(block, home.lead, place.lead))


def set_attribute(text: str, node: Path, name: str, value: str | None) -> str:
    """Text in which an attribute of a node has a value.

    Args:
        text: Text of the mission.
        node: Path of the node.
        name: Name of the attribute.
        value: Value; None to remove the attribute.

    Raises:
        InputError: The text is not well-formed, or there is no such node.
    """
    element = _element(_document(text), node)
    quoted = quoteattr(value or "", {new: old for old, new in ENTITIES.items() if old != "&apos;"})
    given = next((a for a in element.attributes if a.name == name), None)
    if given is not None:
        if value is None:
            return text[: given.start] + text[given.end :]
        return text[: given.begin - 1] + quoted + text[given.end :]
    if value is None:
        return text
    last = element.attributes[-1] if element.attributes else None
    at = last.end if last else element.start + 1 + len(element.tag)
    lead = text[last.start : last.at] if last else " "
    return text[:at] + (lead if "\n" in lead else " ") + f"{name}={quoted}" + text[at:]


class _Place(NamedTuple):
    """Place of a block.

    Attributes:
        at: Offset of the block.
        lead: White space with which a block begins here.
        inside: Element to open, because it is written as `<Tag/>`; else None.
    """

    at: int
    lead: str
    inside: Element | None


def _document(text: str) -> Element:
    document = parse(text)
    if document is None:
        hint = "Close every tag, then edit the tree."
        raise InputError(Fault("the text is not well-formed XML, so that its nodes cannot be edited.", hint=hint))
    return document


def _element(document: Element, path: Path) -> Element:
    try:
        return document.at(path)
    except IndexError:
        raise InputError(Fault(f"there is no node at {'/'.join(map(str, path))}.")) from None


def _starts(text: str, parent: Element) -> list[int]:
    """Offsets of the blocks of an element's children, and of what follows the last one."""
    behind = _COMMENT_BEHIND.match(text, parent.inner)
    own_line = behind and re.match(r"[ \t]*\n", text[behind.end() :])
    starts = [behind.end() if behind and own_line and not parent.empty and parent.tag else parent.inner]
    for child in parent.children:
        end = child.end
        if "\n" in text[starts[-1] : child.start] and (behind := _COMMENT_BEHIND.match(text, end)):
            end = behind.end()
        starts.append(end)
    return starts


def _lead(text: str, at: int) -> str:
    """White space at the beginning of a block."""
    found = _SPACE.match(text, at)
    return found[0] if found else ""


def _place(text: str, path: Path, index: int) -> _Place:
    parent = _element(_document(text), path)
    if not 0 <= index <= len(parent.children):
        raise InputError(Fault(f"<{parent.tag}> has {len(parent.children)} children; there is no place {index}."))
    starts = _starts(text, parent)
    if parent.children:  # as the block before, or the one behind; after its last line break
        near = _lead(text, starts[max(index - 1, 0)])
        return _Place(starts[index], "\n" + near.rpartition("\n")[2] if "\n" in near else near, None)
    unit = _UNIT.search(text)
    lead = "\n" + _line_indent(text, parent.start) + (unit[1] if unit else "  ")
    if parent.empty:
        return _Place(parent.inner, lead, parent)
    return _Place(starts[0], lead if "\n" in text[starts[0] : parent.close] else "", None)


def _line_indent(text: str, at: int) -> str:
    begin = text.rfind("\n", 0, at) + 1
    line = text[begin:at]
    return line[: len(line) - len(line.lstrip(" \t"))]


def _put(text: str, place: _Place, block: str) -> str:
    if (outer := place.inside) is None:
        return text[: place.at] + block + text[place.at :]
    opening = text[outer.start : outer.inner].removesuffix("/>") + ">"
    closing = f"\n{_line_indent(text, outer.start)}</{outer.tag}>"
    return text[: outer.start] + opening + block + closing + text[outer.end :]


def _taken(text: str, path: Path) -> tuple[str, str]:
    """Block of a node, and the text without it."""
    if len(path) < 2:
        raise InputError(Fault("the document cannot be taken out of itself.", hint="Choose a node of a tree."))
    node = _element(_document(text), path)
    parent = node.parent
    assert parent is not None  # it has a path
    starts = _starts(text, parent)
    begin, end = starts[path[-1]], starts[path[-1] + 1]
    tail = text[end : parent.close]
    if len(parent.children) == 1 and begin == parent.inner and tail == "\n" + _line_indent(text, parent.start):
        return text[begin:end], text[: parent.inner - 1] + "/>" + text[parent.end :]
    return text[begin:end], text[:begin] + text[end:]


def _fitted(block: str, old: str, new: str) -> str:
    """The block with the indentation of its new place."""
    lead = _lead(block, 0)
    body, lines = block[len(lead) :], "\n" in lead
    if lines and "\n" in old and "\n" in new:
        return _shifted(lead, body, old.rpartition("\n")[2], new.rpartition("\n")[2])
    if not lines and "\n" in new:  # from a line of several nodes to one of its own; other white space stays before it
        return ("" if lead == old else lead) + new + body
    own = body.endswith("-->") or ("\n" in body and body.startswith("<!--"))  # comments that need a line of their own
    if own or not lead.endswith(old) or "\n" in (rest := lead.removesuffix(old)):
        return block
    return (rest or new) + body


def _shifted(lead: str, body: str, old: str, new: str) -> str:
    """Lines of a block with another indentation; lines with less than that of the block stay as they are."""
    breaks, _, indent = lead.rpartition("\n")
    to = indent  # of other characters, such as tabs among spaces
    if indent.startswith(old):
        to = new + indent[len(old) :]
    elif old.startswith(indent):
        to = new[: max(len(new) - len(old) + len(indent), 0)]
    first, *others = body.split("\n")
    moved = [to + line[len(indent) :] if indent and line.startswith(indent) else line for line in others]
    return "\n".join([breaks, to + first, *moved])
