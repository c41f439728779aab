"""Start-up time: `import rocs_bt` and `rocs-bt --help`, in CPU seconds.

Run it with `python benchmarks imports`, or all benchmarks with `make bench`.
"""

from __future__ import annotations

import resource
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

from row import Row, size

RUNS = size(7, 1)


def cpu_seconds(*command: str) -> float:
    """Median CPU time of a command as a process [s], after a first run that fills the disk cache."""
    times = []
    for _ in range(RUNS + 1):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(command, check=True, capture_output=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        times.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return sorted(times[1:])[RUNS // 2]


def run() -> Iterator[Row]:
    """All rows."""
    bare = cpu_seconds(sys.executable, "-c", "pass")
    package = cpu_seconds(sys.executable, "-c", "import rocs_bt")
    yield Row("import rocs_bt", package, "s", "python -c pass", package / bare, "<= 0.3 s", package <= 0.3)
    command = cpu_seconds(str(Path(sys.executable).with_name("rocs-bt")), "--help")
    yield Row("rocs-bt --help", command, "s", "python -c pass", command / bare, "<= 0.4 s", command <= 0.4)
