"""Text drawing of a tree, for a terminal."""

from __future__ import annotations

from collections.abc import Iterator

from .picture import Card, Line, Picture

_SIGNS = {"<": "=", ">": "→", "<>": "↔", "if": ":"}


def text(picture: Picture) -> str:
    """Draw a tree as lines of text: each node, with its ports in the lines below."""
    lines = [f"{picture.title}: {picture.doc}" if picture.doc else picture.title]
    lines += [f"  {name} = {value}" for name, value in picture.parameters.items()]
    return "\n".join([*lines, *_tree(picture.root)])


def _tree(root: Card) -> Iterator[str]:
    todo = [(root, "", "")]
    while todo:
        card, first, rest = todo.pop()
        tag = f"  [{card.tag}]" if card.tag else ""
        yield f"{first}{card.title}{tag}{'  (stub)' if card.stub else ''}"
        below = "│ " if card.children else "  "
        for line in card.lines:
            yield f"{rest}{below}  {_line(line)}"
        last = len(card.children) - 1
        todo += [
            (child, rest + ("└─ " if i == last else "├─ "), rest + ("   " if i == last else "│  "))
            for i, child in reversed(list(enumerate(card.children)))
        ]


def _line(line: Line) -> str:
    comes_from = f"   ({line.comes_from})" if line.comes_from else ""
    return f"{line.name} {_SIGNS[line.sign]} {line.value}{comes_from}"
