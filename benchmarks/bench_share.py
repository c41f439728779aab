"""Cost of knowledge sharing, and its latency and throughput between processes on this host.

Run it with `python benchmarks share`, or all benchmarks with `make bench`. Each peer is a process, connected by zenoh
over loopback; with 20 peers a small machine also measures its scheduler. loro and pycrdt, if installed, store the
same writes for comparison.
"""

from __future__ import annotations

import json
import os
import socket
import statistics
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator

from row import Row, size

from rocs_bt.base.clock import SimulatedClock, WallClock
from rocs_bt.event import NullSink
from rocs_bt.knowledge import Knowledge
from rocs_bt.share.network import LocalNetwork
from rocs_bt.share.replica import Replica
from rocs_bt.share.scope import SharingScope
from rocs_bt.share.sharing import Sharing

PEERS = size((2, 5, 20), (2,))
WRITES = size(200, 3)  # writes of the latency test
SECONDS = size(4.0, 0.1)  # duration of the throughput test
BATCH = 50
HOUR = size(20 * 5 * 3600, 100)  # writes of five values at 20 Hz in an hour
CALLS, BUSY, REPEATS = size((5000, 200, 5), (5, 2, 1))


def run() -> Iterator[Row]:
    """All rows."""
    yield from _costs()
    yield from _stores()
    for count in PEERS:
        yield from _travel(count)


# -- in this process ------------------------------------------------------------------------------------------------


def _costs() -> list[Row]:
    alone, shared = _peer("R0", None), _peer("R0", LocalNetwork())
    graph = shared[0].graph
    values = iter(range(10**9))
    bare = _micros(lambda: alone[0].graph.set("box", radius=float(next(values))))
    heard = _micros(lambda: graph.set("box", radius=float(next(values))))
    clock, sharing = shared[0].clock, shared[1]
    assert isinstance(clock, SimulatedClock)
    assert sharing is not None

    def turn() -> None:
        sharing.run(clock.now())
        clock.advance()

    def busy() -> None:
        for i in range(BATCH):
            graph.set(f"box {i}", radius=float(next(values)))
        turn()

    for i in range(BATCH):
        graph.add(f"box {i}", "object")
    writes = _micros(lambda: [graph.set(f"box {i}", radius=float(next(values))) for i in range(BATCH)], BUSY)
    return [
        Row("write to a shared graph, writer's thread", heard, "us", "unshared graph", heard / bare),
        Row("sharing cycle without changes", _micros(turn), "us"),
        Row(f"sharing cycle with {BATCH} changes, per change", (_micros(busy, BUSY) - writes) / BATCH, "us"),
    ]


def _peer(name: str, network: LocalNetwork | None) -> tuple[Knowledge, Sharing | None]:
    clock = SimulatedClock(0.05)
    knowledge = Knowledge(name, clock, NullSink())
    knowledge.signals.freeze()
    knowledge.graph.add("box", "object")
    if network is None:
        return knowledge, None
    return knowledge, _sharing(knowledge, network)


def _sharing(knowledge: Knowledge, network: object) -> Sharing:
    return Sharing(
        knowledge,
        SharingScope(knowledge.graph.schema),
        network,
        origin=f"{knowledge.agent}#{os.urandom(8).hex()}",
        calendar=time.time,
    )


def _stores() -> list[Row]:
    """One hour of five values at 20 Hz: cost per write, and data sent to a late joiner."""
    values = [[float(i), 2.0, 3.0] for i in range(1000)]
    replica = Replica("R0#1", time.time)
    keys = [(f"R{i}", "peer", "pose") for i in range(5)]
    ours = _each(HOUR, lambda i: replica.write(keys[i % 5], values[i % 1000], 0.0))
    rows = [
        Row("an hour of five values at 20 Hz, replica: per write", ours, "us"),
        Row("the same: data sent to a late joiner", sum(len(repr(e)) for e in replica.missing({})), "bytes"),
    ]
    try:
        import loro

        document = loro.LoroDoc()
        tree = document.get_map("k")

        def write(i: int) -> None:
            tree.insert(str(i % 5), values[i % 1000])
            if i % 5 == 4:
                document.commit()

        each = _each(HOUR, write)
        size = len(document.export(loro.ExportMode.Snapshot()))
        rows += [Row("the same, loro: per write", each, "us"), Row("the same, loro: snapshot", size, "bytes")]
    except ModuleNotFoundError:
        pass
    try:
        import pycrdt

        shared = pycrdt.Doc()
        entries = shared.get("k", type=pycrdt.Map)

        def put(i: int) -> None:
            entries[str(i % 5)] = values[i % 1000]

        each = _each(HOUR, put)
        rows += [
            Row("the same, pycrdt: per write", each, "us"),
            Row("the same, pycrdt: update", len(shared.get_update()), "bytes"),
        ]
    except ModuleNotFoundError:
        pass
    return rows


def _each(count: int, write: Callable[[int], object]) -> float:
    start = time.process_time_ns()
    for i in range(count):
        write(i)
    return (time.process_time_ns() - start) / count / 1e3


def _micros(call: Callable[[], object], count: int = CALLS, repeats: int = REPEATS) -> float:
    rounds = []
    for _ in range(repeats):
        start = time.process_time_ns()
        for _ in range(count):
            call()
        rounds.append((time.process_time_ns() - start) / count / 1e3)
    return statistics.median(rounds)


# -- between processes ------------------------------------------------------------------------------------------------


def _travel(count: int) -> list[Row]:
    addresses = _addresses(count)
    workers = [
        subprocess.Popen(
            [sys.executable, __file__, f"R{i}", address, *addresses[:1]],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        for i, address in enumerate(addresses)
    ]
    try:
        for worker in workers:
            _receive(worker)
        while any(_query(worker, "peers") != count - 1 for worker in workers):
            time.sleep(0.2)
        _query(workers[0], "write")
        delays = sorted(delay for worker in workers[1:] for delay in _query(worker, "delays"))
        for worker in workers:
            _send(worker, "race")
        rates = [_receive(worker) for worker in workers]
    finally:
        for worker in workers:
            worker.stdin.close()
            worker.wait(30)
    name = f"{count} peer processes:"
    return [
        Row(f"{name} latency of a write, p50", delays[len(delays) // 2] * 1e3, "ms"),
        Row(f"{name} latency of a write, p99", delays[int(len(delays) * 0.99)] * 1e3, "ms"),
        Row(f"{name} all write, acknowledged by all", sum(rates), "writes/s"),
    ]


def _addresses(count: int) -> list[str]:
    sockets = [socket.socket() for _ in range(count)]
    for each in sockets:
        each.bind(("127.0.0.1", 0))
    found = [f"127.0.0.1:{each.getsockname()[1]}" for each in sockets]
    for each in sockets:
        each.close()
    return found


def _send(worker: subprocess.Popen[str], word: str) -> None:
    assert worker.stdin is not None
    worker.stdin.write(word + "\n")
    worker.stdin.flush()


def _receive(worker: subprocess.Popen[str]) -> object:
    assert worker.stdout is not None
    return json.loads(worker.stdout.readline())


def _query(worker: subprocess.Popen[str], word: str) -> object:
    _send(worker, word)
    return _receive(worker)


def _run_peer(name: str, listen: str, *peers: str) -> None:
    """Peer process: reads one command per line and answers with one line of JSON."""
    from rocs_bt.share.zenoh_network import ZenohNetwork

    sys.setswitchinterval(0.0005)
    clock = WallClock()
    knowledge = Knowledge(name, clock, NullSink())
    knowledge.signals.freeze()
    graph = knowledge.graph
    sharing = _sharing(knowledge, ZenohNetwork(listen, [p for p in peers if p != listen]))
    delays: list[float] = []
    # The written value is the host's time, which all processes share.
    graph.subscribe(lambda c: delays.append(time.time() - c.value) if c.name == "radius" else None, node="clock")

    def share() -> None:
        while True:
            sharing.run(clock.now())
            sharing.awake.wait(0.05)

    threading.Thread(target=share, daemon=True).start()
    print(json.dumps("ready"), flush=True)
    for line in sys.stdin:
        match line.strip():
            case "peers":
                answer: object = len(sharing.peers)
            case "write":
                answer = _write(graph)
            case "delays":
                answer = delays[1:]
            case _:
                answer = _race(name, graph, sharing)
        print(json.dumps(answer), flush=True)
    os._exit(0)


def _write(graph: object) -> int:
    graph.add("clock", "object")
    for _ in range(WRITES):
        time.sleep(0.02)
        graph.set("clock", radius=time.time())
    time.sleep(size(1.0, 0.1))
    return WRITES


def _race(name: str, graph: object, sharing: Sharing) -> float:
    for i in range(BATCH):
        graph.add(f"{name} {i}", "object")
    begun, first, value = time.monotonic(), sharing.acknowledged, 0.0
    while time.monotonic() < begun + SECONDS:
        value += 1.0
        for i in range(BATCH):
            graph.set(f"{name} {i}", radius=value)
        while sharing.acknowledged < sharing.written and time.monotonic() < begun + SECONDS:
            time.sleep(0.001)
        time.sleep(0.001)
    return (sharing.acknowledged - first) / SECONDS


if __name__ == "__main__":
    _run_peer(*sys.argv[1:])
