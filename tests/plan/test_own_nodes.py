"""The nodes of planners/nodes: each of them, on a robot without physics, from Python and from XML."""

import pytest

from rocs_bt.actions import ACTIONS
from rocs_bt.base.errors import InputError
from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import Catalog
from rocs_bt.event import Said
from rocs_bt.plan import mission_nodes
from rocs_bt.trees.nodes import FAILURE, RUNNING, SUCCESS, Tree
from rocs_bt.trees.xml import load_xml

CATALOG = Catalog()
NODES = mission_nodes(ACTIONS, CATALOG.load_nodes())


@pytest.fixture
def grow(mind):
    """A tree from one line of XML, in a mission with the shipped content."""
    mind.mission.content = CATALOG

    def grow(line):
        line = line.replace(" < ", " &lt; ")
        root = load_xml(f'<root BTCPP_format="4"><BehaviorTree ID="M">{line}</BehaviorTree></root>', NODES)
        return Tree(root, board=mind.mission.board, clock=mind.rig.clock, owner=mind.mission)

    return grow


def begin(mind):
    mind.mission.begin(mind.rig.clock.now(), {})


class TestAsk:
    def test_it_asks_knowledge_and_writes_what_was_found(self, mind, grow):
        graph = mind.rig.knowledge.graph
        tree = grow("""<Ask query='object where moves order by distance(pose, "far")' found="{who}" count="{n}"/>""")
        begin(mind)
        assert tree.tick() is FAILURE
        assert tree.root.feedback_message == """no answer to 'object where moves order by distance(pose, "far")'"""
        graph.add("far", "place", pose=Pose2(9.0, 0.0))
        graph.add("cart", "object", pose=Pose2(1.0, 0.0), moves=True)
        graph.add("dog", "object", pose=Pose2(8.0, 0.0), moves=True)
        assert tree.tick() is SUCCESS
        assert (tree.board["who"], tree.board["n"]) == ("dog", 2)

    def test_it_takes_a_path_and_a_name_from_the_board(self, mind, grow):
        graph = mind.rig.knowledge.graph
        for name, y in (("a", 0.3), ("b", 2.0)):
            graph.add(name, "object", pose=Pose2(5.0, y))
        tree = grow('<Ask query="object where distance(pose, path) < 0.5 m" path="{way}" names="{found}"/>')
        tree.board["way"] = [(0.0, 0.0), (10.0, 0.0)]
        begin(mind)
        assert tree.tick() is SUCCESS
        assert tree.board["found"] == ["a"]
        other = grow('<Ask query="object where object == it and distance(pose, path) < 0.5 m" path="{way}" it="b"/>')
        other.board["way"] = [(0.0, 0.0), (10.0, 0.0)]
        assert other.tick() is FAILURE


class TestWhen:
    @pytest.mark.parametrize(("front", "outcome"), [(0.4, SUCCESS), (0.6, FAILURE), (float("nan"), FAILURE)])
    def test_it_asks_the_signals_of_this_tick(self, mind, grow, front, outcome):
        tree = grow('<When expression="min(front) < 0.5 m"/>')
        mind.rig.knowledge.signals.write("front", [front], 0.0)
        begin(mind)
        assert tree.tick() is outcome

    def test_the_expression_may_come_from_the_board_and_change(self, mind, grow):
        tree = grow('<When expression="{ask}"/>')
        mind.rig.knowledge.signals.write("front", [0.25], 0.0)
        for text, outcome in (("front > 0.5 m", FAILURE), ("front < 0.5 m", SUCCESS)):
            tree.board["ask"] = text
            begin(mind)
            assert tree.tick() is outcome


class TestKnown:
    @pytest.mark.parametrize(
        ("line", "outcome", "why"),
        [
            ('<Known node="dock"/>', SUCCESS, ""),
            ('<Known node="dock" attribute="pose"/>', SUCCESS, ""),
            ('<Known node="dok"/>', FAILURE, "no node named 'dok' is known"),
            ('<Known node="crate" attribute="pose"/>', FAILURE, "the pose of 'crate' is not known"),
            ('<Known node="dock" attribute="mass"/>', FAILURE, "the mass of 'dock' is not known"),
            ('<Known node="dock" max_age="1 s"/>', FAILURE, "'dock' is 2.0 s old"),
            ('<Known node="dock" max_age="3 s"/>', SUCCESS, ""),
        ],
    )
    def test_what_is_known(self, mind, grow, line, outcome, why):
        mind.rig.knowledge.world.place("dock", Pose2(1.0, 0.0), kind="goal")
        mind.rig.knowledge.graph.add("crate", "object")
        mind.rig.clock.advance(40)
        tree = grow(line)
        assert tree.tick() is outcome
        assert tree.root.feedback_message == why

    def test_an_attribute_that_no_kind_has_is_wrong_from_the_start(self, grow):
        tree = grow('<Known node="dock" attribute="posse"/>')
        ((attribute, fault),) = tree.root.bound_faults()
        assert attribute == "attribute"
        assert "Did you mean 'pose'" in fault.hint


class TestWaitForChange:
    def test_it_runs_until_something_fits_and_tells_what(self, mind, grow):
        world = mind.rig.knowledge.world
        world.place("a", Pose2(0.0, 0.0), kind="goal")
        tree = grow('<WaitForChange kind="goal" attribute="pose" subject="{moved}"/>')
        assert tree.tick() is RUNNING
        world.place("p", Pose2(0.0, 0.0))
        mind.rig.knowledge.graph.set("a", tolerance=0.3)
        assert tree.tick() is RUNNING
        world.place("a", Pose2(1.0, 0.0), kind="goal")
        assert tree.tick() is SUCCESS
        assert tree.board["moved"] == "a"
        assert tree.root.feedback_message == "attribute: a pose"

    def test_what_changed_before_does_not_count_and_nothing_is_heard_after(self, mind, grow):
        knowledge = mind.rig.knowledge
        tree = grow('<WaitForChange relation="pursues"/>')
        knowledge.world.place("a", Pose2(0.0, 0.0), kind="goal")
        knowledge.world.pursue("a")
        assert tree.tick() is RUNNING
        knowledge.world.pursue(None)
        assert tree.tick() is SUCCESS
        knowledge.world.pursue("a")
        assert tree.tick() is RUNNING

    def test_what_was_left_over_in_one_run_is_forgotten_in_the_next(self, mind, grow):
        world = mind.rig.knowledge.world
        tree = grow('<WaitForChange kind="goal"/>')
        tree.tick()
        world.place("a", Pose2(0.0, 0.0), kind="goal")
        world.place("b", Pose2(0.0, 0.0), kind="goal")
        assert tree.tick() is SUCCESS
        assert tree.tick() is RUNNING

    def test_a_halt_ends_the_subscription(self, mind, grow):
        graph = mind.rig.knowledge.graph
        tree = grow('<WaitForChange node="a"/>')
        tree.tick()
        before = len(graph._subscribers.all)
        tree.halt()
        assert len(graph._subscribers.all) == before - 1


class TestWaitForOpenDoor:
    @pytest.fixture
    def graph(self, mind):
        for name, x in (("a", 5.0), ("b", 2.0), ("c", 1.0)):
            mind.rig.knowledge.world.place(name, Pose2(x, 0.0), kind="door")
        return mind.rig.knowledge.graph

    @staticmethod
    def observe(graph, door, is_open, confidence=0.95):
        graph.set(door, open=is_open)
        graph.add(f"{door} seen", "observation", confidence=confidence)
        graph.relate(f"{door} seen", "observes", door)

    def test_it_runs_until_an_open_door_is_observed_and_finds_the_nearest(self, mind, grow, graph):
        tree = grow('<WaitForOpenDoor found="{door}"/>')
        begin(mind)
        assert tree.tick() is RUNNING
        self.observe(graph, "c", False)
        assert tree.tick() is RUNNING
        self.observe(graph, "a", True)
        self.observe(graph, "b", True)
        assert tree.tick() is SUCCESS
        assert tree.board["door"] == "b"

    def test_a_door_without_a_sure_observation_does_not_count(self, mind, grow, graph):
        tree = grow('<WaitForOpenDoor confidence="0.9"/>')
        begin(mind)
        graph.set("a", open=True)
        self.observe(graph, "b", True, confidence=0.8)
        assert tree.tick() is RUNNING
        assert "not observed: a, b, c" in tree.root.feedback_message

    def test_it_fails_when_all_doors_are_closed(self, mind, grow, graph):
        tree = grow("<WaitForOpenDoor/>")
        for name in ("a", "b", "c"):
            self.observe(graph, name, False)
        begin(mind)
        assert tree.tick() is FAILURE
        assert tree.root.feedback_message == "closed: a, b, c"

    def test_without_any_door_it_waits_for_one_that_another_robot_shares(self, mind, grow):
        tree = grow('<WaitForOpenDoor patience="2 s" found="{door}"/>')
        begin(mind)
        assert tree.tick() is RUNNING
        assert "no door is known" in tree.root.feedback_message
        mind.rig.knowledge.world.place("b", Pose2(2.0, 0.0), kind="door")
        self.observe(mind.rig.knowledge.graph, "b", True)
        assert tree.tick() is SUCCESS


class TestFinishTask:
    def test_open_tasks_that_serve_the_goal_are_done(self, mind, grow):
        graph = mind.rig.knowledge.graph
        for goal in ("a", "b"):
            mind.rig.knowledge.world.place(goal, Pose2(1.0, 2.0), kind="goal")
        for task, goal in (("one", "a"), ("two", "a"), ("three", "b")):
            graph.add(task, "task", priority=1)
            graph.relate(task, "serves", goal)
        tree = grow('<FinishTask goal="a"/>')
        assert tree.tick() is SUCCESS
        assert {task: graph.get(task, "state") for task in graph.nodes("task")} == {
            "one": "done",
            "two": "done",
            "three": "open",
        }
        assert tree.tick() is FAILURE
        assert tree.root.feedback_message == "no open task serves 'a'"


class TestPlaceGoal:
    @pytest.mark.parametrize(
        ("line", "pose"),
        [
            ('<PlaceGoal goal="g" x="3 m" y="-1 m"/>', (3.0, -1.0, 0.0)),
            ('<PlaceGoal goal="g" at="shelf"/>', (1.0, 2.0, 1.5707963)),
            ('<PlaceGoal goal="g" at="shelf" x="1 m" y="50 cm" yaw="90 deg"/>', (0.5, 3.0, 3.1415926)),
            ('<PlaceGoal goal="g" at="R1"/>', (0.0, 0.0, 0.0)),
        ],
    )
    def test_a_goal_stands_where_it_says(self, mind, grow, line, pose):
        world = mind.rig.knowledge.world
        world.place("shelf", Pose2(1.0, 2.0, 1.5707963))
        assert grow(line).tick() is SUCCESS
        assert world.pose_of("g") == pytest.approx(pose, abs=1e-6)
        assert world.goals() == ["g"]

    @pytest.mark.parametrize(
        ("line", "why"),
        [
            ('<PlaceGoal goal="g" at="nowhere"/>', "NO_GOAL: the position of 'nowhere' is unknown"),
            ('<PlaceGoal goal="shelf"/>', "CANNOT: cannot place 'shelf' as goal"),
        ],
    )
    def test_what_cannot_be_fails_with_its_reason(self, mind, grow, line, why):
        mind.rig.knowledge.world.place("shelf", Pose2(1.0, 2.0))
        tree = grow(line)
        assert tree.tick() is FAILURE
        assert tree.root.feedback_message.startswith(why)


class TestSay:
    def test_speaking_and_logging_are_events(self, mind, grow):
        tree = grow('<Sequence><Speak text="hello"/><Log text="tries left:" value="{n}"/><Log value="{n}"/></Sequence>')
        tree.board["n"] = 3
        assert tree.tick() is SUCCESS
        assert [(e.text, e.aloud) for e in mind.rig.of(Said)] == [
            ("hello", True),
            ("tries left: 3", False),
            ("3", False),
        ]


class TestComputeRoute:
    LINE = '<ComputeRoute goal="g" planner="visibility" path="{way}" length="{far}"/>'

    def test_the_way_is_driven_by_follow_path(self, mind, grow):
        world = mind.rig.knowledge.world
        world.place("g", Pose2(4.0, 0.0), kind="goal")
        world.place("crate", Pose2(2.0, 0.0), kind="object", radius=0.5)
        plan = mind.start(grow(f'<Sequence>{self.LINE}<FollowPath points="{{way}}"/></Sequence>').root)
        mind.until_done()
        assert plan.status == "SUCCESS", plan.reason
        assert mind.rig.pose.distance(Pose2(4.0, 0.0)) < 0.06
        assert min(p.distance(Pose2(2.0, 0.0)) for p in mind.rig.path) > 0.5
        assert 4.0 < mind.mission.board["far"] < 4.6

    @pytest.mark.parametrize(
        ("goal", "why"),
        [("nowhere", "NO_GOAL: the position of 'nowhere' is unknown"), ("c", "BLOCKED: the goal is too")],
    )
    def test_no_way_has_a_reason(self, mind, grow, goal, why):
        mind.rig.knowledge.world.place("c", Pose2(2.0, 0.0), kind="object", radius=0.5)
        tree = grow(f'<ComputeRoute goal="{goal}" planner="visibility"/>')
        assert tree.tick() is FAILURE
        assert tree.root.feedback_message.startswith(why)

    def test_a_lost_pose_is_told(self, mind, grow):
        mind.rig.knowledge.world.place("g", Pose2(4.0, 0.0), kind="goal")
        tree = grow(self.LINE)
        mind.rig.lost = True
        mind.rig.clock.advance(10)
        assert tree.tick() is FAILURE
        assert tree.root.feedback_message.startswith("LOST_POSE")


class TestMissionNode:
    def test_any_node_that_a_file_may_name(self, mind):
        mission = mind.mission
        mission.content = CATALOG
        root = mission.node(
            "Sequence",
            mission.node("PlaceGoal", goal="g", x="1 m"),
            mission.node("Inverter", mission.node("Known", node="h")),
            mission.node("GoTo", name="drive", goal="g", cruise="0.4 m/s"),
            name="whole",
        )
        assert [n.name for n in root.iterate()] == ["PlaceGoal", "Known", "Inverter", "drive", "whole"]
        plan = mind.start(root)
        mind.until_done()
        assert plan.status == "SUCCESS"
        assert mind.rig.pose.distance(Pose2(1.0, 0.0)) <= 0.055

    def test_a_port_whose_name_is_a_word_of_python_gets_an_underscore(self, mind):
        root = mind.mission.node("Precondition", mind.mission.node("AlwaysSuccess"), if_="1 > 2", else_="SKIPPED")
        assert root.given == {"if": "1 > 2", "else": "SKIPPED"}


class TestProject:
    def write(self, folder, name, text):
        file = folder / "planners" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, "utf-8")

    NODE = (
        '"""One of mine."""\nfrom rocs_bt.trees.nodes import SUCCESS, Instant\n'
        'class Mine(Instant):\n    """Mine."""\n    def update(self):\n        return SUCCESS\n'
    )

    def test_a_file_with_a_class_is_all_it_takes(self, mind, tmp_path):
        self.write(tmp_path, "nodes/mine.py", self.NODE)
        mind.mission.content = Catalog(tmp_path)
        assert Tree(mind.mission.node("Mine")).tick() is SUCCESS

    def test_two_of_one_name_clash(self, mind, tmp_path):
        self.write(tmp_path, "nodes/mine.py", self.NODE)
        self.write(tmp_path, "nodes/other.py", self.NODE)
        mind.mission.content = Catalog(tmp_path)
        with pytest.raises(InputError, match="two nodes are named 'Mine'"):
            mind.mission.node("Mine")

    def test_a_route_of_a_project(self, mind, tmp_path):
        route = '"""A way."""\nfrom rocs_bt.plan import RoutePlanner\n{}'
        method = "    def route(self, start, goal, clearance):\n        return [start[:2], goal[:2]]\n"
        one = "class {}(RoutePlanner):\n" + method
        self.write(tmp_path, "routes/straight.py", route.format(one.format("Straight")))
        self.write(tmp_path, "routes/both.py", route.format(one.format("A") + one.format("B")))
        catalog = Catalog(tmp_path)
        planner = catalog.load_route("straight")(mind.rig.knowledge)
        assert planner.route(Pose2(0, 0), Pose2(1, 1), 0.1) == [(0, 0), (1, 1)]
        with pytest.raises(InputError, match="expected one route planner in the file, found 2"):
            catalog.load_route("both")
