"""Report of a comparison: an HTML page, and tables in Markdown."""

from .figures import sceneries
from .markdown import extent, markdown
from .pairs import pairs
from .report import exported, render_comparison, write_comparison
from .tables import BEST_FIRST, COLD_HEAD, cold_rows, number, standings

__all__ = [
    "BEST_FIRST",
    "COLD_HEAD",
    "cold_rows",
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
