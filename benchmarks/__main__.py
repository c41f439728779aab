"""`make bench`: runs every `bench_*.py` here and prints one table. Words choose: `python benchmarks rules`."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

from row import Row


def main(words: list[str]) -> int:
    """Run the benchmarks whose names contain one of the words; all of them without words."""
    names = sorted(p.stem for p in Path(__file__).parent.glob("bench_*.py"))
    chosen = [n for n in names if not words or any(w in n for w in words)]
    if not chosen:
        print(f"no benchmark matches {' '.join(words)}. There are: {', '.join(names)}.", file=sys.stderr)
        return 2
    table = [("what", "measured", "ratio", "budget", "holds")]
    for name in chosen:
        print(f"{name} ...", file=sys.stderr, flush=True)
        table += [cells(row) for row in importlib.import_module(name).run()]
    widths = [max(len(line[column]) for line in table) for column in range(len(table[0]))]
    for line in table:
        print("  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip())
    return 0


def cells(row: Row) -> tuple[str, str, str, str, str]:
    """A row as the texts of the table."""
    ratio = "" if row.ratio is None else f"{row.ratio:.3g}x {row.baseline}"
    holds = "" if row.holds is None else ("yes" if row.holds else "NO")
    return row.name, f"{row.value:.4g} {row.unit}", ratio, row.budget, holds


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
