"""The tables of docs/reuse.md: `python tests/docs/reuse.py` writes them anew."""

from __future__ import annotations

import re
from pathlib import Path

from click.testing import CliRunner

from rocs_bt.cli.main import group

PAGE = Path(__file__).resolve().parents[2] / "docs" / "reuse.md"
_BLOCK = re.compile(r"(<!-- rocs-bt (diff [^>]*) -->\n).*?(<!-- end -->)", re.DOTALL)


def written(text: str) -> str:
    """The page with every table as its command gives it now."""
    return _BLOCK.sub(lambda found: f"{found[1]}{_told(found[2])}\n{found[3]}", text)


def _told(command: str) -> str:
    done = CliRunner().invoke(group, command.split(), catch_exceptions=False)
    return done.output


if __name__ == "__main__":
    PAGE.write_text(written(PAGE.read_text("utf-8")), "utf-8")
