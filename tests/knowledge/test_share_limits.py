"""What a broken or hostile member, and time, can do at worst: memory, clocks and the line stay bounded."""

from __future__ import annotations

import itertools
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.base.geometry import Pose2
from rocs_bt.event import PeerFault
from rocs_bt.interfaces.message import MessageQueue
from rocs_bt.knowledge import SCHEMA
from rocs_bt.share import inbox, replica, sharing
from rocs_bt.share.inbox import Counts
from rocs_bt.share.replica import STAMP_LIMIT, Entry
from rocs_bt.share.scope import SharingScope
from rocs_bt.share.sharing import Ageing
from rocs_bt.share.wire import FRAME_LIMIT, Ack, Heartbeat, TextMessage, encode, parts

from . import share_world as world
from .share_world import NOW, delta


def told(peers, name, message, sender="M#1"):
    peers.sharing[name]._inbox.put(encode(sender, message, b""))


def one_portion():
    """How many entries fit into a frame, of a usual size."""
    entry = Entry(("a thing 1234", "object", "pose"), [1.0, 2.0, 3.0], NOW, "R2#0123456789abcdef", 10**6)
    return len(parts([entry] * 5000)[0])


def skip(peers, seconds):
    """Let time pass in which nobody has a turn."""
    peers.clock.advance(round(seconds / world.TURN))


class TestRemovals:
    """What was removed must not come back from a peer that was parted for less than an hour."""

    def parted(self, *names):
        peers = world.Peers(3).start(*names)
        peers.knowledge["R0"].graph.add("box", "object", radius=1.0)
        peers.settle()
        peers.network.part([peers.sharing["R1"].replica.origin])
        peers.turn()
        peers.knowledge["R0"].graph.remove("box")
        return peers

    @pytest.mark.parametrize("seconds", [30.0, sharing.MEMORY - 60.0])
    def test_a_removed_thing_stays_removed_when_one_that_was_parted_comes_back(self, seconds):
        peers = self.parted("R0", "R1")
        peers.turn(10)
        skip(peers, seconds)
        peers.turn(10)
        assert peers.knowledge["R1"].graph.has("box")
        peers.network.heal()
        assert peers.settle() < 1200
        assert not any(k.graph.has("box") for k in peers.knowledge.values())

    def test_after_an_hour_the_removal_itself_is_forgotten(self):
        peers = self.parted("R0", "R1")
        peers.turn(10)
        skip(peers, sharing.MEMORY + 60.0)
        peers.turn(10)
        assert ("box",) not in peers.sharing["R0"].replica.entries


class TestGone:
    def gone(self, *names):
        peers = world.Peers(3)
        peers.ageing = Ageing(state=3.0, rest=10.0)
        peers.start(*names)
        signals = peers.knowledge["R1"].signals
        signals.update({"pose": [2.0, 0.0, 0.0], "speed": [0.0], "turn_rate": [0.0]}, 0.0)
        peers.knowledge["R1"].graph.add("box", "object", radius=1.0)
        peers.turn(20)
        assert peers.knowledge["R0"].graph.get("R1", "pose") == Pose2(2.0, 0.0, 0.0)
        peers.kill("R1")
        return peers

    def test_where_it_was_does_not_come_back_to_mind_when_its_start_is_forgotten(self):
        peers = self.gone("R0", "R1")
        skip(peers, sharing.MEMORY - 100.0)
        for _ in range(20):
            skip(peers, 20.0)
            peers.turn()
            graph = peers.knowledge["R0"].graph
            assert not graph.has("R1") or graph.get("R1", "pose") is None
            assert not graph.has("box")
        assert "R1#1" not in peers.sharing["R0"].presence.peers

    def test_what_it_told_ages_for_one_who_came_after_it_had_gone_too(self):
        peers = self.gone("R0", "R1")
        peers.turn(20)
        peers.start("R2")
        peers.turn(120)
        late = peers.knowledge["R2"].graph
        assert late.has("box")
        assert late.get("R1", "pose") is None
        peers.turn(200)
        assert not peers.knowledge["R2"].graph.has("box")
        assert peers.sharing["R2"].peers == ["R0"]


class TestClocks:
    @pytest.mark.parametrize("stamp", [STAMP_LIMIT - 1, STAMP_LIMIT // 2 + 2**40, 2**62])
    def test_a_stamp_at_the_end_of_time_does_not_silence_the_others(self, stamp):
        peers = world.Peers(2).start()
        peers.settle()
        told(peers, "R0", delta(Entry(("evil",), "object", stamp, "M#1", 1)))
        peers.turn(3)
        graph = peers.knowledge["R0"].graph
        assert not graph.has("evil")
        assert peers.sharing["R0"].counts.refused == 1
        graph.add("box", "object", radius=1.0)
        peers.turn(10)
        assert peers.knowledge["R1"].graph.get("box", "radius") == 1.0
        assert peers.sharing["R1"].counts.refused == 0

    def test_a_clock_that_is_a_thousand_years_ahead_wins_once_and_all_go_on(self):
        peers = world.Peers(2)
        peers.error["R0"] = 4e10  # [s]
        peers.start()
        first, second = (peers.knowledge[name].graph for name in ("R0", "R1"))
        first.add("box", "object", radius=1.0)
        peers.settle()
        for i in range(20):
            (second if i % 2 else first).set("box", radius=float(i))
            peers.turn(3)
        assert first.get("box", "radius") == second.get("box", "radius") == 19.0

    @pytest.mark.parametrize("error", [-3e8, -5.0, 5.0])  # [s]: ten years, and less than a minute
    def test_of_two_writes_in_a_partition_the_later_stays_however_wrong_a_clock_is(self, error):
        peers = world.Peers(3)
        peers.error["R1"] = error
        peers.start()
        graphs = [peers.knowledge[name].graph for name in peers.names]
        graphs[0].add("box", "object", radius=1.0)
        peers.settle()
        for later, earlier in ((1, 0), (0, 1)):
            peers.network.part([peers.sharing["R1"].replica.origin])
            graphs[earlier].set("box", radius=2.0 + later)
            peers.turn(40)
            graphs[later].set("box", radius=4.0 + later)
            peers.turn()
            peers.network.heal()
            assert peers.settle() < 1200
            assert [graph.get("box", "radius") for graph in graphs] == [4.0 + later] * 3

    def test_a_clock_that_is_behind_is_reported_by_all_once(self):
        peers = world.Peers(3)
        peers.error["R1"] = -3e8  # [s]
        peers.start()
        peers.turn(200)
        faults = {(e.agent, e.peer, e.kind): e.detail for e in peers.sink.events if isinstance(e, PeerFault)}
        corrected = "3472.2 days behind and has been corrected"
        assert corrected in faults.pop(("R1", "R0", "clock"), "") or corrected in faults.pop(("R1", "R2", "clock"), "")
        assert faults == {
            (name, "R1", "behind"): "its clock was 3472.2 days behind and has been corrected" for name in ("R0", "R2")
        }
        assert len([e for e in peers.sink.events if isinstance(e, PeerFault)]) == 3
        figures = {name: sharing.statistics()["clock_ahead"] for name, sharing in peers.sharing.items()}
        assert figures == {"R0": 0.0, "R1": pytest.approx(3e8, abs=1.0), "R2": 0.0}

    def test_clocks_that_agree_but_for_what_a_network_takes_are_left_alone(self):
        peers = world.Peers(3)
        peers.network.impairments = world.Impairments(latency=0.4, jitter=0.3)
        peers.error["R1"] = 0.9  # [s]
        peers.start()
        peers.turn(400)
        assert not [e for e in peers.sink.events if isinstance(e, PeerFault)]
        assert [sharing.clock.ahead for sharing in peers.sharing.values()] == [0.0] * 3

    def test_a_calendar_that_is_set_during_a_run_changes_no_stamp(self):
        peers = world.Peers(2).start()
        peers.settle()
        peers.error["R1"] = 2e9  # [s]
        before = peers.sharing["R1"].clock.now()
        peers.turn(20)
        assert peers.sharing["R1"].clock.now() == pytest.approx(before + 20 * world.TURN)

    @pytest.mark.parametrize(
        ("time", "ahead"), [(math.nan, 0.0), (math.inf, 0.0), (-1.0, 0.0), (1e300, 0.0), (1e4, -1.0), (1e4, math.inf)]
    )
    def test_a_time_that_no_clock_shows_is_not_followed(self, time, ahead):
        peers = world.Peers(2).start()
        peers.settle()
        told(peers, "R0", Heartbeat({}, 0, "x", time, ahead))
        peers.turn()
        assert peers.sharing["R0"].clock.ahead == 0.0
        assert peers.sharing["R0"].counts.malformed == 1

    @staticmethod
    def pose_of_a_moving_peer(speed, turn_rate, age):
        """Pose of a peer that was at the origin so many seconds ago, as another one knows it."""
        peers = world.Peers(2).start()
        state = {"pose": [0.0, 0.0, 0.0], "speed": speed, "turn_rate": turn_rate}
        said = [Entry(("M",), "peer", NOW, "M#1", 1)]
        said += [
            Entry(("M", "peer", name), value, NOW + i, "M#1", 2 + i) for i, (name, value) in enumerate(state.items())
        ]
        told(peers, "R1", delta(*said, ages=[age] * 4))
        peers.turn(3)
        return peers.knowledge["R1"].graph.attributes("M").get("pose") if peers.knowledge["R1"].graph.has("M") else None

    def test_a_peer_is_where_its_motion_has_taken_it_since_its_word(self):
        radius, quarter = 2 / math.pi, math.pi / 2
        assert self.pose_of_a_moving_peer(1.0, quarter, 1.0) == pytest.approx((radius, radius, quarter))

    def test_a_word_that_is_older_than_time_and_turns_like_mad_breaks_nothing(self):
        pose = self.pose_of_a_moving_peer(1.7e308, 1.7e308, 1e300)
        assert pose is None or all(map(math.isfinite, pose))


class TestMemory:
    def test_names_of_starts_that_never_were_do_not_make_beats_too_long(self):
        peers = world.Peers(2).start()
        scope = peers.sharing["R1"]._scope.digest
        for i in range(40):
            told(peers, "R1", delta(sync=i, scope=scope, upto={f"{'x' * 150}{i} {j}#1": 1 for j in range(200)}))
        peers.turn(60)
        assert (
            len(encode("R1#1", Heartbeat(peers.sharing["R1"].replica.seen, 2**63, scope, 1e9, 1e9), b""))
            < FRAME_LIMIT // 2
        )
        peers.knowledge["R1"].graph.add("box", "object")
        peers.turn(60)
        assert peers.sharing["R0"].peers == ["R1"]
        assert peers.knowledge["R0"].graph.has("box")
        assert peers.sharing["R0"].counts.oversized == 0

    def test_parts_that_never_end_are_not_remembered_for_ever(self):
        peers = world.Peers(2).start()
        one = peers.sharing["R1"]
        for i in range(400):
            told(peers, "R1", delta(sync=1, part=i, whole=2**40))
            told(peers, "R1", delta(sync=i, part=0, whole=2))
            peers.turn(i % 100 == 99)
        peers.turn(5)
        assert one.counts.malformed == 400
        assert len(one._parts) == sharing.SYNCS
        assert sharing.PARTS * one_portion() > replica.ENTRY_LIMIT  # a whole replica fits into one answer

    def test_a_flood_of_messages_does_not_pile_up_answers_nor_keep_us_from_telling(self):
        peers = world.Peers(2).start()
        one = peers.sharing["R1"]
        one.messenger.message_queue = MessageQueue()
        peers.settle()
        numbers = itertools.count(1)
        for _ in range(100):
            for _ in range(200):
                told(peers, "R1", TextMessage(next(numbers), "x"))
            peers.turn()
        assert len(one._out) <= sharing.TURN_OUT * 4
        assert one.counts.flooded > 0
        peers.knowledge["R1"].graph.add("box", "object")
        for _ in range(8):
            for _ in range(200):
                told(peers, "R1", TextMessage(next(numbers), "x"))
            peers.turn()
        assert peers.knowledge["R0"].graph.has("box")

    def test_a_replica_takes_in_so_much_and_no_more(self, monkeypatch):
        monkeypatch.setattr(replica, "ENTRY_LIMIT", 100)
        peers = world.Peers(2).start()
        peers.knowledge["R1"].graph.add("box", "object", radius=1.0)
        peers.settle()
        for i in range(3):
            told(
                peers,
                "R0",
                delta(*(Entry((f"n{i} {j}",), "object", NOW + j, "M#1", i * 80 + j + 1) for j in range(80))),
            )
        peers.turn(5)
        assert len(peers.sharing["R0"].replica.entries) == 100
        assert peers.sharing["R0"].counts.refused == 240 - (100 - 4)
        peers.knowledge["R1"].graph.set("box", radius=2.0)  # what is known already can change all the same
        peers.turn(5)
        assert peers.knowledge["R0"].graph.get("box", "radius") == 2.0

    @pytest.mark.parametrize(("each", "together", "room"), [(10_000, 10**6, 3), (10**6, 31_000, 2), (10, 10, 1)])
    def test_what_waits_is_bounded_in_bytes_too_and_the_first_of_anybody_has_room(
        self, monkeypatch, each, together, room
    ):
        monkeypatch.setattr(inbox, "PER_SENDER_BYTES", each)
        monkeypatch.setattr(inbox, "WAITING_BYTES", together)
        counts = Counts()
        door = inbox.FrameQueue(b"", counts)
        for i in range(10):
            for name in "ABCDE":
                door.put(encode(f"{name}#1", TextMessage(i, "x" * 3000), b""))
        waiting = door.take(1000)
        assert {sender for sender, _ in waiting} == {f"{name}#1" for name in "ABCDE"}
        assert [message.number for sender, message in waiting if sender == "A#1"] == list(range(room))
        assert len(waiting) + counts.flooded == 50
        door.put(encode("A#1", TextMessage(99, "x"), b""))
        assert len(door.take(9)) == 1  # there is room again

    @pytest.mark.parametrize("origin", ["", "#", "M", "M#", "M#" + "1" * 300])
    def test_a_write_must_come_from_somebody(self, origin):
        peers = world.Peers(2).start()
        told(peers, "R1", delta(Entry(("evil",), "object", NOW, origin, 1)))
        peers.turn(3)
        assert peers.sharing["R1"].counts.refused == 1
        assert not peers.knowledge["R1"].graph.has("evil")

    def test_nobody_can_have_more_of_our_writes_than_there_are(self):
        peers = world.Peers(2).start()
        peers.settle()
        told(peers, "R0", Ack(2**40), sender="R1#1")
        peers.turn()
        assert peers.sharing["R0"].acknowledged <= peers.sharing["R0"].written


_SCOPE = SharingScope(SCHEMA, kinds=["all"])
_KEYS = [
    *((kind, name) for kind in sorted(_SCOPE.kinds) for name in sorted(SCHEMA.kinds[kind].attributes)),
]
_SIMPLE = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-(2**63), 2**64 - 1),
    st.floats(),
    st.text(max_size=4),
    st.lists(st.one_of(st.floats(), st.integers(-(2**63), 2**64 - 1).map(float)), max_size=40),
)
_VALUES = st.one_of(_SIMPLE, st.dictionaries(st.sampled_from(["distance", "x"]), _SIMPLE, max_size=2))


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.tuples(st.sampled_from(_KEYS), _VALUES), max_size=8), st.floats(allow_nan=False, allow_infinity=False)
)
def test_no_value_of_any_attribute_breaks_a_turn(writes, age):
    peers = world.Peers(2, kinds=["all"]).start()
    for number, ((kind, name), value) in enumerate(writes):
        node = "M" if kind == "peer" else f"M/{kind}"
        pair = [
            Entry((node,), kind, NOW + number, "M#1", 2 * number + 1),
            Entry((node, kind, name), value, NOW + number, "M#1", 2 * number + 2),
        ]
        told(peers, "R1", delta(*pair, sync=number, ages=[age, age]))
    peers.turn(3)
    graph = peers.knowledge["R1"].graph
    for node in graph.nodes():
        declared = graph.schema.kinds[graph.kind(node)].attributes
        assert all(declared[name].check(value) is not None for name, value in graph.attributes(node).items())
