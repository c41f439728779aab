"""Model-based: whatever the network, the clocks and the robots suffer, all know the same in the end, and what was
acknowledged is not lost. The oracle is the list of all writes that were ever made."""

from __future__ import annotations

import contextlib
from collections import Counter
from typing import Any

import pytest
from hypothesis import HealthCheck, given, note, settings
from hypothesis import strategies as st

from rocs_bt.base.errors import KnowledgeError
from rocs_bt.base.geometry import Pose2

from . import share_world as world

COUNT = 3
NODES = ("a", "b", "c")
KINDS = ("object", "person", "place", "task", "observation")
EDGES = (("near", "thing"), ("observes", "single"), ("does", "one source"), ("follows", "single, with attributes"))

agents = st.integers(0, COUNT - 1)
nodes = st.sampled_from(NODES)
number = st.integers(0, 5)
ends = st.sampled_from((*NODES, "R0", "R1"))
steps = st.one_of(
    st.tuples(st.just("add"), agents, nodes, st.sampled_from(KINDS), number),
    st.tuples(st.just("set"), agents, nodes, number),
    st.tuples(st.just("set"), agents, nodes, number),
    st.tuples(st.just("unset"), agents, nodes),
    st.tuples(st.just("remove"), agents, nodes),
    st.tuples(st.just("relate"), agents, ends, st.sampled_from([name for name, _ in EDGES]), ends, number),
    st.tuples(st.just("unrelate"), agents, ends, st.sampled_from([name for name, _ in EDGES]), ends),
    st.tuples(st.just("wait"), st.integers(1, 30)),
    st.tuples(st.just("part"), agents),
    st.tuples(st.just("heal")),
    st.tuples(st.just("kill"), agents),
    st.tuples(st.just("restart"), agents),
    st.tuples(st.just("trouble"), st.sampled_from((0.0, 0.3, 0.6)), st.sampled_from((0.0, 0.4))),
    st.tuples(st.just("clock"), agents, st.sampled_from((-9e3, -1.0, 0.0, 60.0, 1e8))),
)


class Play:
    """Plays a schedule, and notes which writes were acknowledged, and who held them then."""

    def __init__(self, seed: int) -> None:
        self.peers = world.Peers(COUNT, seed).start()
        self.holders: dict[tuple[str, int], set[str]] = {}

    def step(self, what: str, *args: Any) -> None:
        if what in ("part", "heal", "kill", "restart", "trouble", "clock", "wait"):
            getattr(self, what)(*args)
        elif (name := f"R{args[0]}") in self.peers.sharing:
            with contextlib.suppress(KnowledgeError):  # what the schema refuses, or what is not there, is no write
                self.write(self.peers.knowledge[name].graph, what, *args[1:])
        self.wait(1)

    def write(self, graph: Any, what: str, *args: Any) -> None:
        if what == "add":
            node, kind, value = args
            graph.add(
                node, kind, **({"deadline": float(value)} if kind == "task" else {"pose": Pose2(value, 0.0, 0.0)})
            )
        elif what == "set":
            node, value = args
            if not graph.has(node):
                graph.add(node, "object")
            task = graph.has(node) and graph.kind(node) == "task"
            graph.set(node, **({"deadline": float(value)} if task else {"pose": Pose2(value, 1.0, 0.0)}))
        elif what == "unset":
            task = graph.has(args[0]) and graph.kind(args[0]) == "task"
            graph.set(args[0], **{"deadline" if task else "pose": None})
        elif what == "remove":
            graph.remove(*args)
        elif what == "relate":
            source, relation, target, value = args
            for end in (source, target):
                if not graph.has(end):
                    graph.add(
                        end, "task" if relation == "does" else "observation" if relation == "observes" else "object"
                    )
            graph.relate(source, relation, target, **({"distance": value} if relation in ("near", "follows") else {}))
        else:
            graph.unrelate(*args)

    def wait(self, turns: int) -> None:
        for _ in range(turns):
            self.peers.turn()
            for sharing in self.peers.sharing.values():
                here = {p.origin for p in sharing.presence.peers.values() if p.present}
                for number in range(sharing.acknowledged, 0, -1):
                    write = (sharing.replica.origin, number)
                    if write in self.holders:
                        break
                    self.holders[write] = here | {sharing.replica.origin}

    def part(self, alone: int) -> None:
        origins = [s.replica.origin for n, s in self.peers.sharing.items() if n == f"R{alone}"]
        self.peers.network.part(origins)

    def heal(self) -> None:
        self.peers.network.heal()

    def kill(self, agent: int) -> None:
        if f"R{agent}" in self.peers.sharing and len(self.peers.sharing) > 1:
            self.peers.kill(f"R{agent}")

    def restart(self, agent: int) -> None:
        if f"R{agent}" not in self.peers.sharing:
            self.peers.start(f"R{agent}")

    def trouble(self, loss: float, jitter: float) -> None:
        self.peers.network.impairments = world.Impairments(loss=loss, jitter=jitter, repeats=0.2 if loss else 0.0)

    def clock(self, agent: int, error: float) -> None:
        self.peers.error[f"R{agent}"] = error

    def end(self) -> None:
        """All faults are over, but for ordinary loss."""
        for agent in range(COUNT):
            self.restart(agent)
        self.heal()
        self.trouble(0.2, 0.1)
        assert self.peers.settle() < 1200, "they never agreed"


def check(schedule: list[tuple[Any, ...]], seed: int, tally: Counter[str]) -> None:
    play = Play(seed)
    for step in schedule:
        play.step(*step)
    play.end()
    peers = play.peers
    pictures = {n: world.picture(k, peers.sharing[n]._scope) for n, k in peers.knowledge.items()}
    note(str(pictures))
    assert pictures["R0"] == pictures["R1"] == pictures["R2"]
    final = peers.sharing["R0"].replica.entries
    alive = {sharing.replica.origin for sharing in peers.sharing.values()}
    made = {(entry.origin, entry.number): entry for entry in peers.written}
    for key, entry in final.items():
        assert made[entry.origin, entry.number] == entry, f"nobody wrote this under {key}"
    for write, holders in play.holders.items():
        if not holders & alive:
            tally["acknowledged, but all who held it were killed"] += 1
            continue
        entry, tally["acknowledged and checked"] = made[write], tally["acknowledged and checked"] + 1
        stays = final.get(entry.key)
        # What was removed may be forgotten once everybody has seen the removal; then nothing older is there either.
        assert stays is not None or any(
            e.value is None and not entry.after(e) for e in made.values() if e.key == entry.key
        )
        assert stays is None or not entry.after(stays), f"{entry} was acknowledged, and {stays} took its place"
    tally.update(step[0] for step in schedule)


@settings(max_examples=100, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(st.lists(steps, min_size=5, max_size=40), st.integers(0, 2**32 - 1))
def test_whatever_happens_all_know_the_same_in_the_end_and_nothing_acknowledged_is_lost(schedule, seed):
    check(schedule, seed, Counter())


@pytest.mark.soak
def test_a_thousand_longer_schedules():
    tally: Counter[str] = Counter()

    @settings(max_examples=1000, deadline=None, suppress_health_check=list(HealthCheck), database=None)
    @given(st.lists(steps, min_size=20, max_size=80), st.integers(0, 2**32 - 1))
    def play(schedule, seed):
        tally["schedules"] += 1
        check(schedule, seed, tally)

    play()
    print(dict(tally.most_common()))
    assert tally["acknowledged and checked"] > 1000
