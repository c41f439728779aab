"""A process that writes knowledge until somebody kills it: says on stdout which write was flushed for sure.

Each write adds two nodes in one `locked` block and joins them, so a half of it would show.
"""

from __future__ import annotations

import sys
from pathlib import Path

from rocs_bt.base.clock import WallClock
from rocs_bt.event import NullSink
from rocs_bt.knowledge import KnowledgeGraph
from rocs_bt.knowledge.history import Journal


def main(path: Path, keep: int) -> None:
    graph = KnowledgeGraph(WallClock(), NullSink(), "R2")
    journal = Journal(path, keep=keep, every=0.002)
    journal.attach(graph)
    count = 0
    while True:
        with graph.locked():
            graph.add(f"a{count}", "object", radius=float(count))
            graph.add(f"b{count}", "object", radius=float(count))
            graph.relate(f"a{count}", "near", f"b{count}", distance=float(count))
            if count >= 5:
                graph.remove(f"a{count - 5}")
                graph.remove(f"b{count - 5}")
        count += 1
        if count % 20 == 0:
            journal.flush()
            print(count - 1, flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]))
