"""RosAction, RosActionServer and RosService through rclpy: the others are plain rclpy, in a process of their own."""

from __future__ import annotations

import time
from contextlib import contextmanager

import pytest
import rclpy
from rclpy.action import ActionClient, ActionServer
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import qos_profile_sensor_data
from std_srvs.srv import Trigger
from test_msgs.action import Fibonacci, NestedMessage

from rocs_bt.base.errors import InputError

from ..nodes_at_work import Servers

PATIENCE = 60.0  # [s]
ACTION = (
    '<RosAction action="fibonacci" type="test_msgs/action/Fibonacci" goal="order = {n}" '
    'feedback="sequence -> {part}" result="sequence -> {all}" wait="30 s" {}/>'
)
SERVICE = (
    '<RosService service="{}" type="std_srvs/srv/SetBool" request="data = {on}" '
    'response="success -> {done}; message -> {text}" wait="30 s" timeout="{t}"/>'
)
RUNNING, SUCCESS, FAILURE = "RUNNING", "SUCCESS", "FAILURE"


def action(more=""):
    return ACTION.replace("{}", more)


def service(name, timeout="10 s"):
    return SERVICE.replace("{}", name).replace("{t}", timeout)


@contextmanager
def plain_node(name, namespace):
    """A plain node of this process, which nothing spins."""
    context = Context()
    rclpy.init(context=context)
    node = rclpy.create_node(name, context=context, namespace=namespace)
    yield node
    node.destroy_node()
    context.try_shutdown()


class TestAction:
    def test_goal_feedback_result_and_the_next_goal(self, servers, at_work):
        tree = at_work(action(), n=6)
        assert tree.until(lambda tree: tree.has("part")) == RUNNING
        assert tree.board["part"][:3] == [0, 1, 1]
        assert tree.end() == SUCCESS
        assert tree.board["all"] == [0, 1, 1, 2, 3, 5, 8]
        tree.board["n"] = 3
        assert tree.end() == SUCCESS
        assert tree.board["all"] == [0, 1, 1, 2]
        servers.until("ended", 3)
        assert [what for what, _ in servers.seen if what == "asked"] == ["asked"] * 2

    @pytest.mark.parametrize(
        ("order", "message"),
        [
            (-1, "REFUSED: the server of 'fibonacci' rejected the goal"),
            (40, "REFUSED: the server of 'fibonacci' aborted the goal"),
        ],
    )
    def test_a_goal_that_is_not_achieved(self, servers, at_work, order, message):
        tree = at_work(action(), n=order)
        assert tree.end() == FAILURE
        assert tree.feedback == message

    def test_a_halt_cancels_the_goal_without_waiting(self, servers, at_work):
        tree = at_work(action(), n=25)
        tree.until(lambda tree: tree.has("part"))
        begun = time.perf_counter()
        tree.plan.tree.halt()
        took = time.perf_counter() - begun
        assert servers.until("cancel") == 25
        assert servers.until("cancelled") < 25
        assert took < 0.05

    @pytest.mark.parametrize("closed", [False, True])
    def test_also_a_goal_that_is_not_accepted_yet(self, servers, at_work, closed):
        tree = at_work(action(), n=25)
        for delay in (0.0, 0.001, 0.002, 0.004, 0.008):
            tree = at_work(action(), n=25) if closed else tree
            tree.until(lambda tree: "goal sent" in tree.feedback)
            time.sleep(delay)
            tree.close() if closed else tree.plan.tree.halt()
        last = at_work(action(), n=-1)
        assert last.end() == FAILURE
        servers.until("asked", -1)
        asked = servers.seen.count(["asked", 25])
        assert asked > 0
        while sum(what == "cancelled" for what, _ in servers.seen) < asked:
            servers.until("cancelled")

    def test_a_goal_that_takes_too_long_is_cancelled(self, servers, at_work):
        tree = at_work(action('timeout="0.4 s"'), n=25)
        assert tree.end() == FAILURE
        assert tree.feedback == "TIMEOUT: 'fibonacci' is not done after 0.4 s"
        servers.until("cancelled")

    def test_a_server_that_is_not_there(self, ros_environment, at_work):
        tree = at_work(action().replace("30 s", "0.2 s"), n=5)
        assert tree.end() == FAILURE
        assert tree.feedback == "UNHEARD: no server of the action 'fibonacci' within 0.2 s"

    @pytest.mark.parametrize(
        ("more", "message"),
        [
            ("", "UNHEARD: the server of 'fibonacci' disappeared"),
            ('feedback_timeout="0.5 s"', "UNHEARD: no feedback of 'fibonacci' for 0.5 s"),
        ],
    )
    def test_a_server_that_is_killed_during_the_goal(self, servers, at_work, more, message):
        tree = at_work(action(more), n=29)
        tree.until(lambda tree: tree.has("part"))
        servers.kill()
        assert tree.end() == FAILURE
        assert tree.feedback == message

    def test_a_server_that_is_killed_and_started_again(self, servers, at_work, ros_environment, tmp_path):
        tree = at_work(action(), n=29)
        tree.until(lambda tree: tree.has("part"))
        servers.kill()
        again = Servers(ros_environment, tmp_path)
        assert tree.end() == FAILURE
        # the lease of the killed process may end before its successor is there
        assert tree.feedback in (
            "UNHEARD: the server of 'fibonacci' was restarted, and has lost the goal",
            "UNHEARD: the server of 'fibonacci' disappeared",
        )
        tree.board["n"] = 3
        assert tree.end() == SUCCESS
        again.kill()

    def test_a_goal_that_is_never_acknowledged_and_the_end_of_the_run(self, servers, at_work):
        tree = at_work(action('server_timeout="0.3 s"'), n=38)
        assert tree.end() == FAILURE
        assert tree.feedback == "TIMEOUT: the server of 'fibonacci' has not acknowledged the goal within 0.3 s"
        tree.close()
        assert tree.notices == [
            "a goal of '/r1/fibonacci' may go on: its server has not acknowledged its cancellation."
        ]

    def test_a_server_that_refuses_the_cancellation_and_the_end_of_the_run(self, servers, at_work):
        tree = at_work(action(), n=37)
        tree.until(lambda tree: tree.has("part"))
        tree.close()
        assert tree.notices == ["a goal of '/r1/fibonacci' may go on: its server has refused to cancel it."]

    @pytest.mark.parametrize(
        ("type", "options", "reason"),
        [
            (NestedMessage, {}, "the server in the node '/r1/odd' has another type, test_msgs/action/NestedMessage"),
            (
                Fibonacci,
                {"goal_service_qos_profile": qos_profile_sensor_data},
                "the quality of service of the server in the node '/r1/odd' does not match in reliability "
                "(offered best_effort, requested reliable) of its send_goal",
            ),
        ],
    )
    def test_a_server_that_does_not_match(self, ros_environment, at_work, type, options, reason):
        with plain_node("odd", "r1") as node:
            server = ActionServer(node, type, "fibonacci", lambda handle: type.Result(), **options)
            tree = at_work(action().replace("30 s", "0.1 s"), n=5)
            wanted = f"UNHEARD: no server of the action 'fibonacci' within 0.1 s: {reason}"
            tree.until(lambda tree: tree.feedback == wanted)  # discovery may take longer
            server.destroy()

    def test_a_reflex_cancels_it_and_afterwards_it_is_sent_again(self, servers, at_work):
        tree = at_work(action('cancel_on_reflex="true"'), n=12)
        tree.until(lambda tree: tree.has("part"))
        tree.mission.pipeline.hold(True)
        tree.until(lambda tree: "waits for a reflex" in tree.feedback)
        servers.until("cancelled")
        tree.mission.pipeline.hold(False)
        assert tree.end() == SUCCESS
        assert len(tree.board["all"]) == 13

    def test_no_tick_waits_for_the_network(self, servers, at_work):
        tree = at_work(f"<Sequence>{action()}{service('lamp')}</Sequence>", n=3, on=True)
        tree.end()
        assert tree.slowest < 0.1, "a round trip takes three or more ticks"

    @pytest.mark.parametrize(
        ("type", "message"),
        [
            ("nav3_msgs/action/Fly", "Install the ROS package 'nav3_msgs'"),
            ("test_msgs/action/Fibonaci", "Fibonacci"),
        ],
    )
    def test_a_type_that_is_not_installed_is_refused_before_the_run(self, ros_environment, at_work, type, message):
        with pytest.raises(InputError, match=message):
            at_work(action().replace("test_msgs/action/Fibonacci", type).replace("sequence", "."), n=1)


class TestService:
    def test_a_server_of_another_type(self, ros_environment, at_work):
        with plain_node("odd", "r1") as node:
            node.create_service(Trigger, "lamp", lambda request, response: response)
            tree = at_work(service("lamp").replace("30 s", "0.1 s"), on=True)
            odd = "the server in the node '/r1/odd' has another type, std_srvs/srv/Trigger"
            wanted = f"UNHEARD: no server of the service 'lamp' within 0.1 s: {odd}"
            tree.until(lambda tree: tree.feedback == wanted)

    @pytest.mark.parametrize(("on", "text"), [(True, "on"), (False, "no bulb")])
    def test_a_call(self, servers, at_work, on, text):
        tree = at_work(service("lamp"), on=on)
        assert tree.end() == SUCCESS
        assert (tree.board["done"], tree.board["text"]) == (on, text)
        assert servers.until("lamp") == on

    def test_no_response_and_no_server(self, servers, at_work):
        tree = at_work(service("deaf", "0.3 s"), on=True)
        assert tree.end() == FAILURE
        assert tree.feedback == "TIMEOUT: no response of the service 'deaf' within 0.3 s"
        servers.until("deaf")
        tree = at_work(service("lamb").replace("30 s", "0.2 s"), on=True)
        assert tree.end() == FAILURE
        assert tree.feedback == "UNHEARD: no server of the service 'lamb' within 0.2 s"


def test_any_program_pauses_and_resumes_a_controller_by_its_services(ros_environment, at_work):
    """Each request is answered at once and acts once; the services of two controllers are separate."""
    lasting = "<KeepRunningUntilFailure><Script code=\"{} := '{}'\"/></KeepRunningUntilFailure>"
    one = (
        '<PauseResumeController pause_service_name="pause{0}" resume_service_name="resume{0}">'
        + lasting.format("at{0}", "run")
        + lasting.format("at{0}", "paused")
        + "</PauseResumeController>"
    )
    parallel = f'<Parallel success_count="2">{one.format(1)}{one.format(2)}</Parallel>'
    with plain_node("operator", "r1") as node:
        tree = at_work(parallel, dialect="nav2_servers")
        executor = SingleThreadedExecutor(context=node.context)
        executor.add_node(node)

        def ask(name):
            client = node.create_client(Trigger, name)
            assert client.wait_for_service(PATIENCE)
            asked = client.call_async(Trigger.Request())
            executor.spin_until_future_complete(asked, PATIENCE)
            assert asked.result().success
            node.destroy_client(client)

        def at(one, other):
            return tree.until(lambda tree: (tree.board["at1"], tree.board["at2"]) == (one, other))

        assert tree.tick() == RUNNING
        for name, *places in (
            ("pause1", "paused", "run"),
            ("pause2", "paused", "paused"),
            ("resume1", "run", "paused"),
            ("resume1", "run", "paused"),
            ("resume2", "run", "run"),
        ):
            ask(name)
            assert at(*places) == RUNNING
        executor.shutdown()


class Client:
    """A plain client of our action, in this process."""

    def __init__(self):
        self.context = Context()
        rclpy.init(context=self.context)
        self.node = rclpy.create_node("client", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.client = ActionClient(self.node, Fibonacci, "/r1/count")
        self.fed = []

    def until(self, tree, condition):
        """Tick a tree until something has happened here."""
        end, outcome = time.monotonic() + PATIENCE, ""
        while not condition():
            assert time.monotonic() < end
            outcome = tree.tick()
            self.executor.spin_once(timeout_sec=0.02)
        return outcome

    def send(self, tree, order):
        self.until(tree, self.client.server_is_ready)
        future = self.client.send_goal_async(
            Fibonacci.Goal(order=order), lambda m: self.fed.append(m.feedback.sequence)
        )
        self.until(tree, future.done)
        return future.result()

    def result(self, tree, handle):
        future = handle.get_result_async()
        outcome = self.until(tree, future.done)
        return future.result(), outcome

    def close(self):
        self.executor.shutdown()
        self.node.destroy_node()
        self.context.try_shutdown()


@pytest.fixture
def client(ros_environment):
    made = Client()
    yield made
    made.close()


SERVER = """
<RosActionServer action="count" type="test_msgs/action/Fibonacci" goal="order -> {n}"
                 feedback="sequence = [{n}, {round}]" result="sequence = [{n}, {round}, 7]">
  <Sequence><Script code="round := 0"/><Repeat num_cycles="{n}"><Sequence>
    <Script code="round := round + 1"/><Sleep msec="100"/></Sequence></Repeat>
    <ScriptCondition code="n != 4"/></Sequence>
</RosActionServer>
"""


class TestActionServer:
    def test_a_client_starts_a_part_of_the_mission(self, client, at_work):
        tree = at_work(SERVER)
        handle = client.send(tree, 3)
        assert handle.accepted
        response, _ = client.result(tree, handle)
        assert response.status == 4, "succeeded"
        assert list(response.result.sequence) == [3, 3, 7]
        assert [list(each) for each in client.fed] == [[3, 1], [3, 2], [3, 3]]
        handle = client.send(tree, 2)
        assert client.result(tree, handle)[0].status == 4, "the next tick waits for the next goal"

    def test_a_child_that_fails_aborts(self, client, at_work):
        tree = at_work(SERVER)
        response, _ = client.result(tree, client.send(tree, 4))
        assert response.status == 6
        assert list(response.result.sequence) == [4, 4, 7]

    def test_one_goal_at_a_time(self, client, at_work):
        tree = at_work(SERVER)
        first = client.send(tree, 10)
        assert not client.send(tree, 2).accepted
        first.cancel_goal_async()
        response, _ = client.result(tree, first)
        assert response.status == 5, "cancelled"

    def test_of_two_goals_between_two_ticks_one_is_accepted(self, client, at_work):
        tree = at_work(SERVER)
        client.until(tree, client.client.server_is_ready)
        tree.tick()
        futures = [client.client.send_goal_async(Fibonacci.Goal(order=2)) for _ in range(2)]
        while not all(future.done() for future in futures):
            client.executor.spin_once(timeout_sec=PATIENCE)
        (accepted,) = [future.result() for future in futures if future.result().accepted]
        assert client.result(tree, accepted)[0].status == 4

    def test_a_halt_aborts_and_no_goal_is_accepted_any_more(self, client, at_work):
        tree = at_work(SERVER)
        handle = client.send(tree, 10)
        client.until(tree, lambda: client.fed)
        tree.plan.tree.halt()
        tree.tick = lambda: "IDLE"
        assert client.result(tree, handle)[0].status == 6
        assert not client.send(tree, 2).accepted
