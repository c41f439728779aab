"""A robot's mind without a body, as a process of its own: shares over zenoh what it is told on its standard input.

A line is `add NODE`, `set NODE RADIUS`, `remove NODE`, `say AGENT TEXT` or `ask`; each is answered by a line of JSON.
"""

from __future__ import annotations

import json
import os
import sys
import threading
import time
from pathlib import Path

from rocs_bt.base.clock import WallClock
from rocs_bt.event import NullSink
from rocs_bt.interfaces.message import MessageQueue
from rocs_bt.knowledge import Knowledge
from rocs_bt.share.keys import MemberKeys
from rocs_bt.share.scope import SharingScope
from rocs_bt.share.sharing import Sharing
from rocs_bt.share.zenoh_network import ZenohNetwork


def main(name: str, listen: str, keys_folder: str, error: str, *peers: str) -> None:
    clock = WallClock()
    keys = MemberKeys.read(Path(keys_folder)) if keys_folder else None
    knowledge = Knowledge(name, clock, NullSink())
    knowledge.signals.freeze()
    sharing = Sharing(
        knowledge,
        SharingScope(knowledge.graph.schema),
        ZenohNetwork(listen, peers, keys=keys),
        origin=f"{name}#{os.urandom(8).hex()}",
        calendar=lambda: time.time() + float(error),
        key=b"" if keys is None else keys.secret,
    )
    sharing.messenger.message_queue = MessageQueue()
    stop = threading.Event()

    def share() -> None:
        while not stop.is_set():
            sharing.run(clock.now())
            sharing.awake.wait(0.05)

    thread = threading.Thread(target=share, daemon=True)
    thread.start()
    print(json.dumps("ready"), flush=True)
    for line in sys.stdin:
        print(json.dumps(obey(line.split(), knowledge, sharing)), flush=True)
    stop.set()
    thread.join()
    sharing.close()


def obey(words: list[str], knowledge: Knowledge, sharing: Sharing) -> object:
    graph = knowledge.graph
    match words:
        case ["add", node]:
            if not graph.has(node):
                graph.add(node, "object")
        case ["set", node, radius]:
            graph.set(node, radius=float(radius))
        case ["remove", node]:
            graph.remove(node)
        case ["say", agent, text]:
            delivery = sharing.messenger.send(agent, text)
            for _ in range(12_000):  # looks, and no time
                if delivery.done:
                    return True
                time.sleep(0.005)
            return False
        case ["ask"]:
            return {
                "live": [[list(key), value] for key, value in sharing.replica.live.items()],
                "graph": {node: graph.attributes(node) for node in sorted(graph.nodes("object"))},
                "peers": sorted(sharing.peers),
                "written": sharing.written,
                "acknowledged": sharing.acknowledged,
                "pending": sharing.pending,
                "letters": [letter.text for letter in sharing.messenger.message_queue.take(99)],
                "counts": sharing.counts.as_dict(),
            }
    return None


if __name__ == "__main__":
    main(*sys.argv[1:])
