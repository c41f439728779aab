"""Services and actions of ROS 2 through rclpy, by a node and a thread of their own."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping
from typing import Any

from ...base.errors import interrupts
from ..messages.plain import PlainMessage, filled
from ..ros_link import GoalState
from .rclpy_transport import message_class
from .servers import action_mismatch, action_servers, service_mismatch

CLOSING = 1.0
"""Maximum time for which `RosServices.close` waits for what is still to be sent [s]."""

_SPIN = 0.5  # [s] between two looks whether the thread shall end


class RosServices:
    """Clients of services and actions, and action servers, of one robot.

    All calls of rclpy happen on a thread of this object, because its clients lose responses that arrive while another
    thread sends a request. Nothing else waits for that thread.
    """

    def __init__(self, context: Any, namespace: str, name: str = "rocs_bt_services") -> None:
        import rclpy
        from rclpy.executors import SingleThreadedExecutor

        self.node = rclpy.create_node(
            name, context=context, namespace=namespace or None, start_parameter_services=False
        )
        self._executor = SingleThreadedExecutor(context=context)
        self._executor.add_node(self.node)
        self._unsettled: set[object] = set()
        self._going_on: dict[object, str] = {}  # goals to be cancelled that may go on, and why
        self._closing = False
        self._thread = threading.Thread(target=self._spin, name="rocs_bt ros2 services", daemon=True)
        self._thread.start()

    def service(self, name: str, type: str) -> ServiceClient:
        """Open a client of a service with a full name.

        Raises:
            InputError: The ROS package of the type is not installed, or has no such type.
        """
        return ServiceClient(self, name, type)

    def action(self, name: str, type: str) -> ActionClient:
        """Open a client of an action with a full name; see `service`."""
        return ActionClient(self, name, type)

    def action_server(self, name: str, type: str) -> ActionServer:
        """Open a server of an action with a full name; see `service`."""
        return ActionServer(self, name, message_class(type))

    def trigger(self, name: str) -> TriggerServer:
        """Open a server of std_srvs/srv/Trigger with a full name; see `service`."""
        return TriggerServer(self, name)

    def do(self, step: Callable[[], object]) -> None:
        """Run a function on the thread, soon."""
        key = object()
        self._unsettled.add(key)

        def run() -> None:
            try:
                step()
            finally:
                self._unsettled.discard(key)

        self._executor.create_task(run)

    def expect(self, what: object, expected: bool) -> None:
        """Note whether `close` has to wait for an object."""
        if expected:
            self._unsettled.add(what)
        else:
            self._unsettled.discard(what)

    def goes_on(self, goal: object, why: str) -> None:
        """Note why a goal that is to be cancelled may go on; empty if it does not."""
        if why:
            self._going_on[goal] = why
        else:
            self._going_on.pop(goal, None)

    def close(self) -> list[str]:
        """Send what is still to be sent, then end thread and node; returns why goals may go on."""
        until = time.monotonic() + CLOSING
        while self._unsettled and self._thread.is_alive() and time.monotonic() < until:
            time.sleep(0.005)
        self._closing = True
        self._executor.wake()
        self._thread.join(CLOSING)
        self._executor.shutdown(0.0)
        self.node.destroy_node()
        return list(self._going_on.values())

    def _spin(self) -> None:
        while not self._closing and self._executor.context.ok():
            try:
                self._executor.spin_once(_SPIN)
            except Exception as error:  # noqa: BLE001 - one faulty message must not end all services
                if interrupts(error) or self._closing:
                    return


class ServiceClient:
    """Client of a service; see `RosServiceClient`."""

    def __init__(self, services: RosServices, name: str, type: str) -> None:
        self.services = services
        self._name, self._type = name, type
        self._class = message_class(type)
        self.client = services.node.create_client(self._class, name)

    def ready(self) -> bool:
        return bool(self.client.service_is_ready())

    def mismatch(self) -> str:
        return service_mismatch(self.services.node, self._name, self._type)

    def call(self, request: Mapping[str, Any]) -> Call:
        return Call(self, filled(self._class.Request, request))

    def close(self) -> None:
        self.services.do(lambda: self.services.node.destroy_client(self.client))


class Call:
    """Pending call of a service; see `RosCall`."""

    def __init__(self, client: ServiceClient, request: Any) -> None:
        self.response: PlainMessage | None = None
        self.error = ""
        self._client = client
        self._future: Any = None
        self._forgotten = False
        client.services.do(lambda: self._send(request))

    def forget(self) -> None:
        self._forgotten = True
        if self._future is not None and self.response is None:
            self._client.services.do(lambda: self._client.client.remove_pending_request(self._future))

    def _send(self, request: Any) -> None:
        if self._forgotten:
            return
        try:
            self._future = self._client.client.call_async(request)
        except Exception as error:  # noqa: BLE001 - reported by the node of the mission
            self.error = str(error) or type(error).__name__
            return
        self._future.add_done_callback(self._received)

    def _received(self, future: Any) -> None:
        if future.cancelled():
            return
        if (error := future.exception()) is not None:
            self.error = str(error) or type(error).__name__
        else:
            self.response = PlainMessage(future.result())


class ActionClient:
    """Client of an action; see `RosActionClient`."""

    def __init__(self, services: RosServices, name: str, type: str) -> None:
        from rclpy.action import ActionClient as Client

        self.services = services
        self.name = name
        self._type = type
        self._class = message_class(type)
        self.client = Client(services.node, self._class, name)
        self._unsettled: set[Goal] = set()
        self._closed = self._destroyed = False

    def ready(self) -> bool:
        return bool(self.client.server_is_ready())

    def mismatch(self) -> str:
        return action_mismatch(self.services.node, self.name, self._type)

    def servers(self) -> dict[str, str]:
        return action_servers(self.services.node, self.name, self._type)

    def send(self, goal: Mapping[str, Any]) -> Goal:
        return Goal(self, filled(self._class.Goal, goal))

    def close(self) -> None:
        self._closed = True
        self.services.do(self._destroy)

    def settle(self, goal: Goal, settled: bool) -> None:
        """Note whether a goal is still to be cancelled, for which the client must remain open."""
        if settled:
            self._unsettled.discard(goal)
        else:
            self._unsettled.add(goal)
        self.services.expect(goal, not settled)
        self._destroy()

    def _destroy(self) -> None:
        if self._closed and not self._unsettled and not self._destroyed:
            self._destroyed = True
            self.client.destroy()


class Goal:
    """Goal that was sent to an action server; see `RosGoal`.

    Only the thread of the services changes the state.
    """

    def __init__(self, client: ActionClient, goal: Any) -> None:
        self.state = GoalState.SENT
        self.feedback: PlainMessage | None = None
        self.feedback_count = 0
        self.result: PlainMessage | None = None
        self.error = ""
        self._client = client
        self._handle: Any = None
        self._cancel = False
        client.services.do(lambda: self._send(goal))

    def cancel(self) -> None:
        if not self._cancel and not self.state.done:
            self._cancel = True
            self._client.services.goes_on(self, f"{self._named()} has not acknowledged its cancellation")
            self._client.settle(self, False)  # the goal may not be accepted yet
            self._client.services.do(self._ask_to_cancel)

    def _send(self, goal: Any) -> None:
        if self._cancel:
            self._end(GoalState.CANCELED)
            return
        try:
            self._client.client.send_goal_async(goal, self._on_feedback).add_done_callback(self._on_answer)
        except Exception as error:  # noqa: BLE001 - reported by the node of the mission
            self._fail(error)

    def _on_answer(self, future: Any) -> None:
        if (error := future.exception()) is not None:
            self._fail(error)
            return
        self._handle = future.result()
        if not self._handle.accepted:
            self._end(GoalState.REJECTED)
            return
        self.state = GoalState.ACCEPTED
        self._handle.get_result_async().add_done_callback(self._on_result)
        if self._cancel:
            self._ask_to_cancel()

    def _ask_to_cancel(self) -> None:
        if self._handle is not None and self.state is GoalState.ACCEPTED:
            self.state = GoalState.CANCELING
            self._handle.cancel_goal_async().add_done_callback(self._on_cancel_answer)

    def _on_cancel_answer(self, future: Any) -> None:
        self._client.settle(self, True)
        refused = future.exception() is not None or not future.result().goals_canceling
        if refused and self.state is GoalState.CANCELING:
            self.state = GoalState.ACCEPTED
        refusal = f"{self._named()} has refused to cancel it" if self.state is GoalState.ACCEPTED else ""
        self._client.services.goes_on(self, refusal)

    def _named(self) -> str:
        return f"a goal of '{self._client.name}' may go on: its server"

    def _on_feedback(self, message: Any) -> None:
        self.feedback = PlainMessage(message.feedback)
        self.feedback_count += 1

    def _on_result(self, future: Any) -> None:
        if (error := future.exception()) is not None:
            self._fail(error)
            return
        response, status = future.result(), message_class("action_msgs/msg/GoalStatus")
        self.result = PlainMessage(response.result)
        states = {
            status.STATUS_SUCCEEDED: GoalState.SUCCEEDED,
            status.STATUS_ABORTED: GoalState.ABORTED,
            status.STATUS_CANCELED: GoalState.CANCELED,
        }
        self._end(states.get(response.status, GoalState.FAILED), f"its status is {response.status}")

    def _fail(self, error: BaseException) -> None:
        self._end(GoalState.FAILED, str(error) or type(error).__name__)

    def _end(self, state: GoalState, error: str = "") -> None:
        self.error = error
        self.state = state
        self._client.services.goes_on(self, "")
        self._client.settle(self, True)


class ActionServer:
    """Server of an action, for one goal at a time; see `RosActionServer`."""

    def __init__(self, services: RosServices, name: str, cls: Any) -> None:
        from rclpy.action import ActionServer as Server
        from rclpy.action import CancelResponse, GoalResponse

        self.services = services
        self.cls = cls
        self._open = False
        self._expected = False
        self._goal: AcceptedGoal | None = None
        self._taken = False

        def asked(request: Any) -> Any:
            if not self._open or self._expected or self._goal is not None:
                return GoalResponse.REJECT
            self._expected = True
            return GoalResponse.ACCEPT

        def accepted(handle: Any) -> None:
            self._goal, self._taken, self._expected = AcceptedGoal(self, handle), False, False
            if not self._open:
                self.open(False)

        self._server = Server(
            services.node,
            cls,
            name,
            execute_callback=lambda handle: cls.Result(),
            goal_callback=asked,
            handle_accepted_callback=accepted,
            cancel_callback=lambda request: CancelResponse.ACCEPT,
        )

    def open(self, accepting: bool) -> None:
        self._open = accepting
        if self._goal is not None and not self._goal.ended and not (accepting or self._taken):
            self._goal.end(GoalState.ABORTED, {})
        if self._goal is not None and self._goal.ended:
            self._goal = None

    def goal(self) -> AcceptedGoal | None:
        self._taken = self._goal is not None
        return self._goal

    def close(self) -> None:
        self.open(False)
        self.services.do(self._server.destroy)


class TriggerServer:
    """Server of std_srvs/srv/Trigger; see `RosTrigger`."""

    def __init__(self, services: RosServices, name: str) -> None:
        self.services = services
        self._asked = False
        self._server = services.node.create_service(message_class("std_srvs/srv/Trigger"), name, self._answer)

    def taken(self) -> bool:
        asked, self._asked = self._asked, False
        return asked

    def close(self) -> None:
        self.services.do(lambda: self.services.node.destroy_service(self._server))

    def _answer(self, request: Any, response: Any) -> Any:
        self._asked = response.success = True
        return response


class AcceptedGoal:
    """Goal that this robot serves; see `rocs_bt.ros2.ros_link.AcceptedGoal`.

    Its clients see the state `accepted` until it ends: for `executing`, rclpy wants a callback that lasts until
    then.
    """

    def __init__(self, server: ActionServer, handle: Any) -> None:
        self.request = PlainMessage(handle.request)
        self.ended = False
        self._server = server
        self._handle = handle

    @property
    def cancel_requested(self) -> bool:
        return bool(self._handle.is_cancel_requested)

    def feedback(self, values: Mapping[str, Any]) -> None:
        message = filled(self._server.cls.Feedback, values)
        self._server.services.do(lambda: self._handle.publish_feedback(message))

    def end(self, state: GoalState, result: Mapping[str, Any]) -> None:
        made = filled(self._server.cls.Result, result)
        self.ended = True

        def execute(handle: Any) -> Any:
            if state is GoalState.SUCCEEDED:
                handle.succeed()
            elif state is GoalState.CANCELED and handle.is_cancel_requested:
                handle.canceled()
            else:
                handle.abort()
            self._server.services.expect(self, False)
            return made

        self._server.services.expect(self, True)
        self._server.services.do(lambda: self._handle.execute(execute))
