"""`make bench`: run every `bench_*.py` of this folder and print its rows.

`python benchmarks rules trees` runs only benchmarks whose name is or contains one of the words. `--quick` runs the
smallest sizes, as a check that the benchmarks run; its figures are meaningless. A benchmark that raises does not stop
the others.
"""

from __future__ import annotations

import importlib
import os
import sys
import traceback
from pathlib import Path

from row import QUICK


def main(words: list[str]) -> int:
    """Run benchmarks and print their rows; returns 1 if one of them raised, 2 if the words match none."""
    if "--quick" in words:
        os.environ[QUICK] = "1"  # also for the processes that benchmarks start
        words = [word for word in words if word != "--quick"]
    names = sorted(p.stem for p in Path(__file__).parent.glob("bench_*.py"))
    chosen = [n for n in names if not words or any(w == n or (w in n and w not in names) for w in words)]
    if not chosen:
        print(f"no benchmark matches {' '.join(words)}. Benchmarks: {', '.join(names)}.", file=sys.stderr)
        return 2
    broken = [name for name in chosen if not finished(name)]
    if broken:
        print(f"{len(broken)} of {len(chosen)} benchmarks did not finish: {', '.join(broken)}.", file=sys.stderr)
    return 1 if broken else 0


def finished(name: str) -> bool:
    """Run one benchmark and print its rows as they arrive; False if it raised."""
    print(f"{name} ...", file=sys.stderr, flush=True)
    try:
        for row in importlib.import_module(name).run():
            print(row, flush=True)
    except Exception:  # noqa: BLE001 - a failed benchmark must not stop the others
        traceback.print_exc()
        return False
    return True


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
