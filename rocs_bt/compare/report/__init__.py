"""The report of a comparison: one page, and tables in Markdown."""

from .markdown import extent, markdown
from .pairs import pairs
from .pictures import sceneries
from .report import JUDGED, exported, render_comparison, write_comparison
from .tables import BEST_FIRST, SHARES, number, standings

__all__ = [
    "BEST_FIRST",
    "JUDGED",
    "SHARES",
    "exported",
    "extent",
    "markdown",
    "number",
    "pairs",
    "render_comparison",
    "sceneries",
    "standings",
    "write_comparison",
]
