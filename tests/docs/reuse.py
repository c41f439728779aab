"""Tables of docs/reuse.md: `python tests/docs/reuse.py` writes them."""

from __future__ import annotations

import re
from pathlib import Path

from click.testing import CliRunner

from benchmarks.paper.diff import command as diff

PAGE = Path(__file__).resolve().parents[2] / "docs" / "reuse.md"
MEASURED = PAGE.with_name("measurements.md")
_BLOCK = re.compile(r"(<!-- benchmarks.paper.diff ([^>]*) -->\n).*?(<!-- end -->)", re.DOTALL)
_COPY = re.compile(r"(<!-- measurements.md: ([^>]*) -->\n).*?(<!-- end -->)", re.DOTALL)


def written(text: str) -> str:
    """The page with every table as its command, or measurements.md, gives it now."""
    text = _COPY.sub(lambda found: f"{found[1]}{_measured(found[2])}\n\n{found[3]}", text)
    return _BLOCK.sub(lambda found: f"{found[1]}{_told(found[2])}\n{found[3]}", text)


def _measured(heading: str) -> str:
    """The first two columns of the first table under a heading of measurements.md."""
    _, _, below = MEASURED.read_text("utf-8").partition(f"\n## {heading}\n")
    table = re.search(r"(?:^\|.*\n)+", below, re.MULTILINE)
    assert table, f"measurements.md has no table under '{heading}'"
    return "\n".join("|".join(row.split("|")[:3]) + "|" for row in table[0].splitlines())


def _told(command: str) -> str:
    done = CliRunner().invoke(diff, command.split(), catch_exceptions=False)
    return done.output


if __name__ == "__main__":
    PAGE.write_text(written(PAGE.read_text("utf-8")), "utf-8")
