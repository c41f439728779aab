"""What comes from outside and is not what it should be changes nothing, and is counted."""

from __future__ import annotations

import hashlib
import math

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.event import PeerAppeared, PeerFault
from rocs_bt.share.inbox import PER_SENDER, Counts, FrameQueue
from rocs_bt.share.replica import Entry
from rocs_bt.share.wire import (
    FRAME_LIMIT,
    Ack,
    Delta,
    Heartbeat,
    Leave,
    Request,
    TextAck,
    TextMessage,
    decode,
    encode,
    genuine,
    parts,
)

from . import share_world as world
from .share_world import NOW, delta, entry

KEY = b"k" * 32


def two(key: bytes = KEY):
    """R0 and R1, who know a box."""
    peers = world.Peers(2, key=key).start()
    peers.knowledge["R0"].graph.add("box", "object", radius=0.5)
    peers.settle()
    return peers


def everything(peers):
    """All that R1 knows, and all that it would tell."""
    knowledge = peers.knowledge["R1"]
    graph = {node: knowledge.graph.attributes(node) for node in knowledge.graph.nodes()}
    return graph, list(knowledge.graph.view.edges(keys=True)), peers.sharing["R1"].replica.live


def throw(peers, *frames):
    """Frames come to R1."""
    before = everything(peers)
    for frame in frames:
        peers.sharing["R1"]._inbox.put(frame)
    peers.turn(5)
    assert everything(peers) == before
    return peers.sharing["R1"].counts


def test_what_is_not_sealed_with_the_key_is_not_even_read():
    peers = two()
    evil = delta(entry(("box", "object", "radius"), 9.0))
    frame = encode("R0#1", evil, KEY)
    counts = throw(peers, encode("R0#1", evil, b""), encode("R0#1", evil, b"x" * 32), frame[:-1], frame[1:], b"", b"x")
    assert counts.unauthenticated == 6
    peers.sharing["R1"]._inbox.put(encode("R0#1", delta(entry(("box", "object", "radius"), 9.0, origin="R0#1")), KEY))
    peers.turn(3)
    assert peers.knowledge["R1"].graph.get("box", "radius") == 9.0  # the same with the key does change something


def test_what_is_too_long_is_not_even_unsealed():
    peers = two()
    counts = throw(peers, encode("M#1", TextMessage(1, "x" * FRAME_LIMIT), KEY), bytes(FRAME_LIMIT + 1))
    assert (counts.oversized, counts.unauthenticated) == (2, 0)


@pytest.mark.parametrize(
    "body", [b"\xc1", b"\x93\x01", b"\x92\xa1x", b"\x80", b"\x92\xa3M#1\x92\xa5noise\x01", b"\x92\xa4none" + b"\x90"]
)
def test_what_makes_no_sense_is_counted(body):
    peers = two()
    counts = throw(peers, hashlib.blake2b(body, digest_size=16, key=KEY).digest() + body)
    assert counts.malformed == 1


@pytest.mark.parametrize(
    ("key", "value"),
    [
        (("box", "object", "radius"), -1.0),  # below its bound
        (("box", "object", "radius"), "big"),
        (("box", "object", "radius"), math.nan),
        (("box", "object", "colour"), "red"),  # no such attribute
        (("box", "object", "pose"), [1.0, 2.0]),
        (("box", "object", "pose"), [1.0, 2.0, math.inf]),
        (("box", "objct", "radius"), 1.0),
        (("box",), "robot"),
        (("box",), "sensor"),  # not shared
        (("box",), 5),
        (("box", "near", "box", ""), 1.0),
        (("box", "near", "box", ""), {"distance": "far"}),
        (("box", "near", "box", ""), {"colour": 1.0}),
        (("box", "nearby", "box", ""), {}),
        (("box", "near", "box", "x"), {}),
        (("", "object", "radius"), 1.0),
        (("x" * 300,), "object"),
        (("nul\0",), "object"),
        (("two\nlines",), "object"),
        (("\x1b[2J",), "object"),
        (("\u202ereversed",), "object"),
        (("box", "near", "\x1b[2J", ""), {}),
        ((), "object"),
        (("a", "b"), 1.0),
        (("a", "b", "c", "d", "e"), 1.0),
        (("R1/ranges",), "sensor"),  # R1's own to tell
        (("R0/box",), "object"),
    ],
)
def test_a_write_that_the_schema_does_not_allow_is_refused(key, value):
    counts = throw(two(), encode("M#1", delta(entry(key, value)), KEY))
    assert counts.refused == 1


@pytest.mark.parametrize(("stamp", "number"), [(0, 1), (-5, 1), (2**60, 1), (NOW, 0), (NOW, -1), (NOW, 2**60)])
def test_impossible_stamps_and_numbers_are_refused(stamp, number):
    bad = entry(("box", "object", "radius"), 2.0, stamp, number=number)
    assert throw(two(), encode("M#1", delta(bad), KEY)).refused == 1


@pytest.mark.parametrize("origin", ["M\x1b[2J#1", "M#1\n", "\0#1", "M\u202e#1"])
def test_a_start_whose_name_cannot_be_printed_is_not_heard(origin):
    peers = two()
    counts = throw(peers, encode(origin, TextMessage(1, "hello"), KEY), encode(origin, Leave(), KEY))
    assert counts.malformed == 2
    assert not [e for e in peers.sink.events if isinstance(e, PeerAppeared) and e.start == origin]


def test_the_first_refused_write_of_a_peer_is_reported_and_the_others_are_counted():
    peers = two()
    bad = [entry((f"\x1b[{i}J",), "object", number=i) for i in range(1, 20)]
    assert throw(peers, encode("M#1", delta(*bad), KEY)).refused == 19
    (fault,) = (e for e in peers.sink.events if isinstance(e, PeerFault))
    assert (fault.agent, fault.peer, fault.start, fault.kind) == ("R1", "M", "M#1", "refused")
    assert fault.detail == (r"a write was refused: '\x1b[1J' is not a name: a name has 1 to 200 printable characters")


def test_good_writes_beside_a_bad_one_are_taken():
    peers = two()
    both = delta(entry(("box", "object", "radius"), -1.0), entry(("box", "object", "width"), 2.0, number=2))
    peers.sharing["R1"]._inbox.put(encode("M#1", both, KEY))
    peers.turn(3)
    assert peers.knowledge["R1"].graph.attributes("box") == {"radius": 0.5, "width": 2.0}
    assert peers.sharing["R1"].counts.refused == 1


def test_nobody_can_tell_a_robot_what_it_is():
    peers = two()
    graph = peers.knowledge["R1"].graph
    graph.set("R1", radius=0.3)
    peers.settle()
    frames = [entry(("R1", "peer", "radius"), 7.0), entry(("R1",), None, number=2), entry(("R1",), "object", number=3)]
    for each in frames:
        peers.sharing["R1"]._inbox.put(encode("M#1", delta(each), KEY))
        peers.sharing["R0"]._inbox.put(encode("M#1", delta(each), KEY))
    peers.turn(60)
    assert graph.kind("R1") == "robot"
    assert graph.get("R1", "radius") == 0.3
    assert peers.knowledge["R0"].graph.kind("R1") == "peer"  # and it says so itself


def test_delta_without_ages_or_with_strange_parts_is_malformed():
    good = entry(("box", "object", "radius"), 2.0)
    counts = throw(
        two(), *(encode("M#1", d, KEY) for d in (delta(good, ages=[]), delta(good, part=3), delta(good, part=-1)))
    )
    assert counts.malformed == 3
    counts = throw(two(), encode("M#1", delta(good, ages=[math.nan]), KEY))
    assert counts.refused == 1


def test_who_floods_crowds_out_itself_alone():
    peers = two()
    sharing = peers.sharing["R1"]
    before = everything(peers)
    for i in range(5000):
        sharing._inbox.put(encode("M#1", Request({"x#1": i}), KEY))
    peers.knowledge["R0"].graph.set("box", radius=0.7)
    peers.turn(3)
    assert sharing.counts.flooded == 5000 - PER_SENDER
    assert peers.knowledge["R1"].graph.get("box", "radius") == 0.7  # R0 is heard all the same
    assert before != everything(peers)


def test_a_turn_takes_in_so_much_and_no_more_and_what_is_left_comes_next():
    peers = two()
    sharing = peers.sharing["R1"]
    for i in range(40):
        many = [entry((f"thing {i} {j}",), "object", number=i * 200 + j + 1) for j in range(200)]
        sharing._inbox.put(encode("M#1", delta(*many), KEY))
    before = sharing.counts.merged
    sharing.run(peers.clock.now())
    assert 1500 < sharing.counts.merged - before < 2500
    assert sharing.pending
    assert sharing.awake.is_set()
    peers.turn(6)
    assert sharing.counts.merged - before == 40 * 200


def test_a_flood_of_names_is_bounded_too():
    peers = two()
    sharing = peers.sharing["R1"]
    for i in range(3000):
        sharing._inbox.put(encode(f"M{i}#1", Heartbeat({}, 0, "", 0.0, 0.0), KEY))
        if i % 200 == 0:
            peers.turn()
    peers.turn(10)
    assert len(sharing.presence.peers) <= 1024
    assert sharing.counts.flooded > 0


def test_a_lie_about_what_was_seen_hides_nothing_for_ever():
    """Somebody with the key claims that all has been seen that R0 will ever write."""
    peers = two()
    lie = Delta(1, 0, 1, peers.sharing["R1"]._scope.digest, {}, {"R0#1": 10**9}, [], [])
    peers.sharing["R1"]._inbox.put(encode("M#1", lie, KEY))
    peers.turn(3)
    peers.knowledge["R0"].graph.set("box", radius=0.8)
    peers.turn(5)
    assert peers.knowledge["R1"].graph.get("box", "radius") == 0.8


MESSAGES = st.one_of(
    st.builds(
        Heartbeat, st.dictionaries(st.text(max_size=5), st.integers(-5, 2**40)), st.integers(0, 2**63), st.text()
    ),
    st.builds(Request, st.dictionaries(st.text(max_size=5), st.integers(-5, 2**40))),
    st.builds(Ack, st.integers(-(2**60), 2**60)),
    st.builds(TextMessage, st.integers(-5, 5), st.text()),
    st.builds(TextAck, st.integers(-5, 5), st.text()),
    st.builds(Leave),
    st.builds(
        delta,
        st.builds(
            Entry,
            st.lists(st.sampled_from(("box", "object", "radius", "near", "", "R1", "peer", "pose")), max_size=5).map(
                tuple
            ),
            st.one_of(
                st.none(),
                st.floats(),
                st.text(),
                st.lists(st.floats(), max_size=4),
                st.dictionaries(st.text(), st.floats()),
            ),
            st.integers(-5, 2**62),
            st.text(max_size=6),
            st.integers(-5, 2**62),
        ),
        part=st.integers(-1, 2),
        whole=st.integers(-1, 3),
    ),
)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(st.sampled_from(("M#1", "R0#1", "#", "", "R1#9")), MESSAGES), max_size=12))
def test_no_message_of_a_member_breaks_anything(messages):
    peers = two()
    for sender, message in messages:
        peers.sharing["R1"]._inbox.put(encode(sender, message, KEY))
        peers.turn()
    peers.turn(60)
    graph = peers.knowledge["R1"].graph
    assert graph.kind("R1") == "robot"
    for node in graph.nodes():
        declared = graph.schema.kinds[graph.kind(node)].attributes
        assert all(declared[name].check(value) is not None for name, value in graph.attributes(node).items())


@settings(max_examples=200, deadline=None)
@given(st.binary(max_size=200))
def test_bytes_that_somebody_made_up_never_raise(body):
    counts = Counts()
    inbox = FrameQueue(KEY, counts)
    inbox.put(body)
    inbox.put(hashlib.blake2b(body, digest_size=16, key=KEY).digest() + body)
    assert counts.unauthenticated == (1 if body else 2)
    assert counts.malformed + len(inbox.take(9)) == (1 if body else 0)


def test_what_is_encoded_comes_out_again_and_portions_fit_into_frames():
    message = Delta(3, 0, 1, "s", {"a#1": 1}, {"a#1": 2}, [entry(("box",), "object")], [0.5])
    frame = encode("a#1", message, KEY)
    assert genuine(frame, KEY)
    assert decode(frame) == ("a#1", message)
    entries = [entry((f"node {i}", "object", "pose"), [1.0, 2.0, 3.0], number=i) for i in range(5000)]
    portions = parts(entries)
    assert [e for portion in portions for e in portion] == entries
    for portion in portions:
        assert len(encode("a#1", delta(*portion), KEY)) < FRAME_LIMIT
    assert msgspec.msgpack.decode(msgspec.msgpack.encode(entries[0]), type=Entry) == entries[0]
