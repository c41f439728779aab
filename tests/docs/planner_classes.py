"""Classes of docs/write-a-planner.md from their docstrings: `python tests/docs/planner_classes.py` writes them."""

from __future__ import annotations

import inspect
import re
from pathlib import Path

if __package__:
    from .actions import code
else:
    from actions import code

from rocs_bt import Pose2, Twist2
from rocs_bt.plan import Observation, Task, Vehicle

PAGE = Path(__file__).resolve().parents[2] / "docs" / "write-a-planner.md"
CLASSES = (Task, Observation, Pose2, Twist2, Vehicle)
_BLOCK = re.compile(r"(<!-- classes -->\n).*?(<!-- end -->)", re.DOTALL)
_ENTRY = re.compile(r"^ {4}(\w+): (.*?)(?=^ {4}\w+: |^\S|^$|\Z)", re.MULTILINE | re.DOTALL)


def page() -> str:
    """The page with a section for each class."""
    sections = "\n".join(section(cls) for cls in CLASSES)
    return _BLOCK.sub(lambda found: f"{found[1]}\n{sections}\n{found[2]}", PAGE.read_text("utf-8"))


def section(cls: type) -> str:
    """A class: its first sentence, its attributes and its methods."""
    doc = inspect.getdoc(cls) or ""
    lines = [f"## {cls.__name__}", "", f"`from {public(cls)} import {cls.__name__}`. {code(doc.splitlines()[0])}", ""]
    lines += ["| attribute or method | meaning |", "|---|---|"]
    lines += [f"| `{name}` | {code(text)} |" for name, text in attributes(doc).items()]
    lines += [f"| `{name}{signature(value)}` | {first_line(value)} |" for name, value in methods(cls)]
    return "\n".join([*lines, ""])


def attributes(doc: str) -> dict[str, str]:
    """Entries of the `Attributes:` section of a docstring."""
    found = _ENTRY.findall(doc.partition("\nAttributes:\n")[2].partition("\n\n")[0] + "\n")
    return {name: " ".join(text.split()) for name, text in found}


def methods(cls: type) -> list[tuple[str, object]]:
    """Public methods and properties in their order."""
    known = attributes(inspect.getdoc(cls) or "")
    own = [(name, value) for name, value in vars(cls).items() if not name.startswith("_") and name not in known]
    return [(name, value) for name, value in own if inspect.isfunction(value) or isproperty(value)]


def isproperty(value: object) -> bool:
    return isinstance(value, property)


def signature(value: object) -> str:
    """Names of the parameters of a method; empty for a property."""
    return "" if isproperty(value) else f"({', '.join(list(inspect.signature(value).parameters)[1:])})"


def first_line(value: object) -> str:
    return code((inspect.getdoc(value) or "").splitlines()[0])


def public(cls: type) -> str:
    """Package that exports a class."""
    return "rocs_bt" if cls in (Pose2, Twist2) else "rocs_bt.plan"


if __name__ == "__main__":
    PAGE.write_text(page(), "utf-8")
