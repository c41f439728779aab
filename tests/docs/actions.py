"""docs/actions.md from the declarations of the shipped actions: `python tests/docs/actions.py` writes it."""

from __future__ import annotations

import inspect
import re
from pathlib import Path

from rocs_bt.actions import ACTIONS
from rocs_bt.interfaces.action import Action, parameters_of

PAGE = Path(__file__).resolve().parents[2] / "docs" / "actions.md"
HEAD = """# Look up an action

With this page you choose the action of a mission, `<GoTo goal="dock"/>` or `mission.act("GoTo", goal="dock")`, or of a
rule (`[rule.NAME.action]`). Quantities in files need a unit: `cruise = "0.5 m/s"`. A value outside of the range is
refused when the file is read or the mission is built. If an expression gives such a value while the robot runs, the
action fails with CANNOT.

`python tests/docs/actions.py` writes this page from the actions' declarations and docstrings.
"""


def page() -> str:
    """The page as Markdown."""
    return "\n".join([HEAD, *(section(name, action) for name, action in sorted(ACTIONS.items()))])


def section(name: str, action: type[Action]) -> str:
    """An action: its description, and a table of its parameters."""
    text, _, attributes = inspect.getdoc(action).partition("\nAttributes:\n")
    meanings = entries(attributes)
    lines = [f"## {name}", "", code(text.strip()), ""]
    if parameters := parameters_of(action):
        lines += ["| parameter | meaning | unit | range | default |", "|---|---|---|---|---|"]
    for key, parameter in parameters.items():
        unit, bounds = ("", "") if parameter.dimension is None else (str(parameter.dimension), str(parameter.bounds))
        lines.append(f"| `{key}` | {code(meanings[key])} | {unit} | {bounds} | {default(parameter)} |")
    return "\n".join([*lines, ""])


def entries(attributes: str) -> dict[str, str]:
    """The entries of an `Attributes:` section by name, each on one line and without its unit."""
    found = re.findall(r"^ {4}(\w+): (.*?)(?=^ {4}\w+: |^\S|\Z)", attributes, re.MULTILINE | re.DOTALL)
    return {name: re.sub(r" \[[^\]]*\](?=\.?$)", "", " ".join(text.split())) for name, text in found}


def code(text: str) -> str:
    """Text of a docstring as Markdown."""
    return text.replace("``", "`").replace("|", "\\|")


def default(parameter) -> str:
    """A default as a content file writes it."""
    if parameter.required:
        return "needed"
    if isinstance(parameter.default, (str, bool)):
        return f"`{str(parameter.default).lower()}`"
    return "none" if parameter.default in (None, float("inf")) else f"{parameter.default:g}"


if __name__ == "__main__":
    PAGE.write_text(page(), "utf-8")
