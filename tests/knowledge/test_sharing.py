"""What agents that share know, what they keep to themselves, and what they make of peers that vanish."""

from __future__ import annotations

import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.base.geometry import Pose2
from rocs_bt.event import PeerAppeared, PeerVanished
from rocs_bt.interfaces.message import MessageQueue
from rocs_bt.knowledge import SCHEMA, Attribute, NodeKind
from rocs_bt.knowledge.history import GraphState, load_into, persistent_part
from rocs_bt.share.network import Impairments
from rocs_bt.share.scope import SharingScope
from rocs_bt.share.sharing import Ageing

from . import share_world as world

Peers = world.Peers


def told_pose(peers, name, x, speed=0.0):
    """Give a robot a pose that it knows."""
    signals = peers.knowledge[name].signals
    signals.update({"pose": [x, 0.0, 0.0], "speed": [speed], "turn_rate": [0.0]}, peers.clock.now())


class TestWhatIsShared:
    def test_what_one_learns_the_others_know(self):
        peers = Peers(3).start()
        graph = peers.knowledge["R0"].graph
        graph.add("dock", "place", pose=Pose2(1.0, 2.0, 0.5), tolerance=0.2)
        graph.add("box", "object", radius=0.3, moves=True)
        graph.relate("box", "near", "dock", distance=0.7)
        peers.settle()
        for name in ("R1", "R2"):
            other = peers.knowledge[name].graph
            assert other.attributes("dock") == {"pose": Pose2(1.0, 2.0, 0.5), "tolerance": 0.2}
            assert other.attributes("box") == {"radius": 0.3, "moves": True}
            assert other.edge("box", "near", "dock") == {"distance": 0.7}

    def test_a_robot_is_a_peer_to_the_others_and_stays_itself(self):
        peers = Peers(2).start()
        peers.knowledge["R0"].graph.set("R0", radius=0.3, model="pioneer")
        peers.settle()
        assert peers.knowledge["R0"].graph.kind("R0") == "robot"
        assert peers.knowledge["R1"].graph.kind("R0") == "peer"
        assert peers.knowledge["R1"].graph.attributes("R0") == {"radius": 0.3}  # a peer has no model

    def test_parts_stay_at_home_unless_everything_is_shared_and_then_they_bear_their_owners_name(self):
        for kinds, there in (((), False), (("all",), True)):
            peers = Peers(2, kinds=kinds).start()
            for name in ("R0", "R1"):
                graph = peers.knowledge[name].graph
                graph.add("ranges", "sensor", driver=f"of {name}")
                graph.relate(name, "has_sensor", "ranges")
            peers.settle()
            graph = peers.knowledge["R1"].graph
            assert graph.has("R0/ranges") is there
            assert graph.get("ranges", "driver") == "of R1"
            if there:
                assert graph.get("R0/ranges", "driver") == "of R0"
                assert graph.related("R0", "has_sensor") == ["R0/ranges"]

    def test_kinds_and_relations_can_be_chosen_and_what_is_private_is_never_sent(self):
        peers = Peers(2, kinds=["object"], relations=["near"], private=["diary"]).start()
        frames = []
        send = peers.network.send
        peers.network.send = lambda sender, frame, to: (frames.append(frame), send(sender, frame, to))
        graph = peers.knowledge["R0"].graph
        for node, kind in (("box", "object"), ("nurse", "person"), ("dock", "place"), ("diary", "object")):
            graph.add(node, kind, pose=Pose2(0.0, 0.0, 0.0))
        graph.relate("box", "near", "nurse")
        graph.relate("box", "at", "dock")
        graph.relate("box", "near", "diary")
        peers.turn(40)
        other = peers.knowledge["R1"].graph
        assert [node for node in ("box", "nurse", "dock", "diary") if other.has(node)] == ["box", "nurse"]
        assert other.related("box", "near") == ["nurse"]
        assert frames
        assert not any(b"diary" in frame or b"dock" in frame for frame in frames)

    def test_one_who_shares_less_takes_less_and_another_still_gets_all(self):
        peers = Peers(3, kinds=["object", "place"])
        peers.scope["R1"] = {"kinds": ["object"]}
        peers.start("R0", "R1")
        graph = peers.knowledge["R0"].graph
        graph.add("box", "object")
        graph.add("dock", "place", pose=Pose2(0.0, 0.0, 0.0))
        peers.turn(20)
        peers.start("R2")
        peers.turn(40)
        assert peers.knowledge["R2"].graph.has("dock")
        assert peers.knowledge["R1"].graph.has("box")
        assert not peers.knowledge["R1"].graph.has("dock")
        assert peers.sharing["R1"].counts.refused > 0

    def test_unknown_kinds_are_refused_with_a_list(self):
        with pytest.raises(InputError, match=r"no kind is named 'objct'\. Did you mean 'object'"):
            SharingScope(SCHEMA, ["objct"])
        with pytest.raises(InputError, match="no relation is named 'nearr'"):
            SharingScope(SCHEMA, relations=["nearr"])

    def test_a_projects_own_kinds_are_shared_too(self):
        schema = SCHEMA.extended([NodeKind("charger", {"power": Attribute(float)}, extends="place")])
        peers = Peers(2, schema=schema, kinds=["place"]).start()
        peers.knowledge["R0"].graph.add("c1", "charger", pose=Pose2(1.0, 0.0, 0.0), power=50.0)
        peers.settle()
        assert peers.knowledge["R1"].graph.get("c1", "power") == 50.0


class TestPeers:
    def test_a_late_joiner_catches_up_with_more_than_fits_into_a_frame(self):
        peers = Peers(3)
        peers.start("R0", "R1")
        for i in range(3000):
            peers.knowledge["R0"].graph.add(f"box {i}", "object", radius=float(i), pose=Pose2(float(i), 0.0, 0.0))
        peers.turn(60)
        peers.start("R2")
        peers.turn(80)
        assert len(peers.knowledge["R2"].graph.nodes("object")) == 3000
        assert peers.sharing["R2"].replica.sum == peers.sharing["R0"].replica.sum

    def test_what_the_robot_knew_before_it_met_anybody_gives_way(self):
        peers = Peers(2)
        peers.start("R0")
        peers.turn(2)
        peers.knowledge["R0"].graph.add("gate", "door", open=True)
        peers.turn(5)
        peers.start("R1")
        peers.knowledge["R1"].graph.add("gate", "door", open=False)
        peers.settle()
        assert (
            peers.knowledge["R1"].graph.get("gate", "open") is peers.knowledge["R0"].graph.get("gate", "open") is True
        )

    def test_one_that_is_killed_is_noticed_and_one_that_comes_back_too(self):
        peers = Peers(2).start()
        peers.turn(10)
        peers.kill("R1")
        peers.turn(40)
        assert peers.sharing["R0"].peers == []
        peers.start("R1")
        peers.turn(10)
        told = [
            (type(e), e.start)
            for e in peers.sink.events
            if isinstance(e, (PeerAppeared, PeerVanished)) and e.agent == "R0"
        ]
        assert told == [(PeerAppeared, "R1#1"), (PeerVanished, "R1#1"), (PeerAppeared, "R1#2")]

    def test_acknowledged_is_what_every_peer_holds(self):
        peers = Peers(3).start()
        peers.settle()
        sharing = peers.sharing["R0"]
        peers.network.part([peers.sharing["R2"].replica.origin])
        before = sharing.acknowledged
        peers.knowledge["R0"].graph.add("box", "object")
        peers.turn(5)
        assert sharing.written > sharing.acknowledged == before
        peers.network.heal()
        peers.turn(30)
        assert sharing.acknowledged == sharing.written

    def test_what_was_removed_is_forgotten_when_all_have_seen_it(self):
        peers = Peers(2).start()
        graph = peers.knowledge["R0"].graph
        for i in range(50):
            graph.add(f"box {i}", "object", radius=1.0)
            peers.turn(2)
            graph.remove(f"box {i}")
        peers.turn(600)
        for sharing in peers.sharing.values():
            assert sorted(sharing.replica.entries) == [("R0",), ("R1",)]

    def test_a_value_that_is_written_again_and_again_takes_no_more_room(self):
        peers = Peers(2).start()
        graph = peers.knowledge["R0"].graph
        graph.add("box", "object")
        for i in range(500):
            graph.set("box", radius=float(i))
            peers.turn()
        peers.settle()
        assert peers.knowledge["R1"].graph.get("box", "radius") == 499.0
        assert len(peers.sharing["R1"].replica.entries) == 4


class TestDisk:
    def test_what_peers_wrote_is_in_the_knowledge_that_a_robot_keeps(self):
        peers = Peers(2).start()
        peers.knowledge["R0"].graph.add("dock", "place", pose=Pose2(1.0, 2.0, 0.5))
        peers.turn(5)
        assert peers.sharing["R0"].acknowledged == peers.sharing["R0"].written
        kept = persistent_part(GraphState.of(peers.knowledge["R1"].graph))
        for name in ("R0", "R1"):
            peers.kill(name)
        peers.start()
        load_into(peers.knowledge["R1"].graph, kept)
        peers.settle()
        assert peers.knowledge["R0"].graph.get("dock", "pose") == Pose2(1.0, 2.0, 0.5)


class TestBothSides:
    """What two robots write while they do not hear each other."""

    def parted(self):
        peers = Peers(2).start()
        peers.knowledge["R0"].graph.add("seen", "observation")
        for node in ("a", "b"):
            peers.knowledge["R0"].graph.add(node, "object")
        peers.knowledge["R0"].graph.add("job", "task")
        peers.settle()
        peers.network.part([peers.sharing["R0"].replica.origin])
        return peers, peers.knowledge["R0"].graph, peers.knowledge["R1"].graph

    def test_of_two_edges_with_room_for_one_the_later_stays_for_both(self):
        peers, ours, theirs = self.parted()
        ours.relate("seen", "observes", "a")
        ours.relate("R0", "does", "job")
        peers.turn(3)
        theirs.relate("seen", "observes", "b")
        theirs.relate("R1", "does", "job")
        peers.turn(3)
        peers.network.heal()
        peers.settle()
        for graph in (ours, theirs):
            assert graph.related("seen", "observes") == ["b"]
            assert [robot for robot in ("R0", "R1") if graph.related(robot, "does")] == ["R1"]

    def test_attributes_of_a_thing_that_both_found_are_joined(self):
        peers, ours, theirs = self.parted()
        ours.add("box", "object", radius=0.5, pose=Pose2(1.0, 0.0, 0.0))
        ours.relate("box", "near", "a")
        peers.turn(3)
        theirs.add("box", "object", height=0.2, pose=Pose2(2.0, 0.0, 0.0))
        peers.turn(3)
        peers.network.heal()
        peers.settle()
        for graph in (ours, theirs):
            assert graph.attributes("box") == {"radius": 0.5, "height": 0.2, "pose": Pose2(2.0, 0.0, 0.0)}
            assert graph.related("box", "near") == ["a"]

    def test_an_edge_and_attributes_that_come_before_their_node_wait_for_it(self):
        """The node is written here before the peer's word of it arrives; what the peer told of it before is taken."""
        peers, ours, theirs = self.parted()
        ours.add("box", "object", radius=0.5)
        ours.relate("box", "near", "a")
        sharing = peers.sharing["R1"]
        peers.turn(2)
        told = peers.sharing["R0"].replica.entries
        for key in (("box", "object", "radius"), ("box", "near", "a", "")):
            sharing.replica.merge(told[key], 0.0)  # the frame with the node itself was lost
        theirs.add("box", "object")
        peers.turn(2)
        assert theirs.attributes("box") == {"radius": 0.5}
        assert theirs.related("box", "near") == ["a"]


class TestAgeing:
    @pytest.fixture
    def peers(self):
        peers = Peers(2)
        peers.ageing = Ageing(state=3.0, rest=10.0)
        peers.start()
        return peers

    def test_others_know_where_a_robot_is_by_now_though_its_word_takes_a_while(self, peers):
        peers.network.impairments = Impairments(latency=0.4)
        for i in range(100):
            told_pose(peers, "R1", 0.05 * i, speed=1.0)
            peers.turn()
        known = peers.knowledge["R0"].world.predicted("R1", peers.clock.now())
        assert known.x == pytest.approx(0.05 * 100, abs=0.42)
        latest = peers.sharing["R0"].replica.value(("R1", "peer", "pose"))
        assert latest[0] < 0.05 * 100 - 0.35  # the word itself is that old

    def test_a_robot_whose_agent_has_ended_stands_for_its_peers(self, peers):
        told_pose(peers, "R1", 2.0, speed=1.0)
        peers.turn(2)
        graph = peers.knowledge["R0"].graph
        assert graph.get("R1", "speed") == 1.0
        peers.sharing["R1"].halt(peers.clock.now())
        peers.sharing["R0"].run(peers.clock.now())
        assert graph.get("R1", "speed") == 0.0

    def test_the_height_of_a_robot_that_has_one_is_shared_with_its_pose(self, peers):
        told_pose(peers, "R1", 2.0)
        peers.knowledge["R1"].signals.update({"height": [1.25]}, peers.clock.now())
        peers.turn(10)
        world = peers.knowledge["R0"].world
        assert (world.pose_of("R1"), world.z_of("R1")) == (Pose2(2.0, 0.0, 0.0), 1.25)
        peers.kill("R1")
        peers.turn(80)
        assert world.pose_of("R1") is world.z_of("R1") is None

    def test_where_a_vanished_robot_is_nobody_knows_after_a_while_and_what_it_told_goes_later(self, peers):
        told_pose(peers, "R1", 2.0)
        peers.knowledge["R1"].graph.add("box", "object", radius=1.0)
        peers.turn(10)
        graph = peers.knowledge["R0"].graph
        assert graph.get("R1", "pose") == Pose2(2.0, 0.0, 0.0)
        peers.kill("R1")
        peers.turn(40)
        assert graph.get("R1", "pose") == Pose2(2.0, 0.0, 0.0)
        peers.turn(40)
        assert graph.get("R1", "pose") is None
        assert graph.has("R1")
        assert graph.has("box")
        peers.turn(160)
        assert not graph.has("box")
        assert peers.sharing["R0"].replica.value(("box",)) == "object"  # for whoever comes back
        peers.start("R1")
        peers.turn(30)
        assert graph.get("box", "radius") == 1.0

    def test_what_is_seen_of_a_robot_that_speaks_for_itself_is_not_told(self, peers):
        told_pose(peers, "R1", 2.0)
        peers.turn(10)
        peers.knowledge["R0"].graph.set("R1", pose=Pose2(2.3, 0.1, 0.0))
        peers.turn(10)
        assert peers.sharing["R1"].replica.value(("R1", "peer", "pose")) == [2.0, 0.0, 0.0]
        assert peers.knowledge["R0"].graph.get("R1", "pose") == Pose2(2.3, 0.1, 0.0)


class TestMessages:
    def talking(self, count=3, **trouble):
        peers = Peers(count).start()
        peers.network.impairments = Impairments(**trouble)
        for sharing in peers.sharing.values():
            sharing.messenger.message_queue = MessageQueue()
        peers.turn(30)
        return peers

    def test_a_message_arrives_once_and_is_acknowledged_whatever_the_network_does(self):
        peers = self.talking(loss=0.4, jitter=0.3, repeats=0.3)
        sent = [peers.sharing["R0"].messenger.send("R1", f"number {i}") for i in range(20)]
        peers.turn(200)
        assert all(delivery.done for delivery in sent)
        box = peers.sharing["R1"].messenger.message_queue
        assert sorted(letter.text for letter in box.take(99)) == sorted(f"number {i}" for i in range(20))

    def test_to_all_means_all_that_are_there(self):
        peers = self.talking()
        delivery = peers.sharing["R0"].messenger.send("all", "hello")
        peers.turn(5)
        assert delivery.acknowledged == {"R1", "R2"}

    def test_a_full_mailbox_and_a_missing_one_say_so(self):
        peers = self.talking()
        messenger = peers.sharing["R0"].messenger
        peers.sharing["R2"].messenger.message_queue = None
        many = [messenger.send("R1", "x") for _ in range(65)]
        nobody = messenger.send("R2", "x")
        peers.turn(60)
        assert sum(delivery.done for delivery in many) == 64
        assert many[-1].problems == {"R1": "the mailbox is full"}
        assert nobody.problems == {"R2": "'R2' has no mailbox"}
        peers.sharing["R1"].messenger.message_queue.take(99)
        peers.turn(20)
        assert many[-1].done

    def test_too_long_a_text_is_refused(self):
        with pytest.raises(InputError, match="a message has at most 1024 bytes, found 2000"):
            self.talking().sharing["R0"].messenger.send("all", "é" * 1000)
