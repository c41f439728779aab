"""An episode on hardware: the agents in their threads, until each has its outcome."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack

from ..agent import Agent, ThreadedRunner
from ..clock import WallClock
from ..drivers.isolated import IsolatedActuator
from ..event import BodyMoved, EventSink, Stuck
from ..safety import SafetyGate
from .judging import Judging, brake, wait_until
from .outcome import Judge


class HardwareEpisode:
    """One run on hardware. There is no truth: agents are judged by what they know.

    Args:
        agents: The agents.
        gates: By agent, the gates of its actuators.
        wheels: By agent, the gate of its wheels.
        links: By agent, the links to its isolated actuators.
        clock: Wall time; it begins at zero.
        duration: The longest it may take [s].
        period: Control period [s].
        sink: Takes the events.
        ended: Asked why a signal ends the run; empty while none does.
        check: Called once a control period; what it raises ends the run.

    Attributes:
        t: Time of the last control period [s].
    """

    def __init__(
        self,
        agents: Sequence[Agent],
        gates: Mapping[str, Mapping[str, SafetyGate]],
        wheels: Mapping[str, SafetyGate],
        links: Mapping[str, Sequence[IsolatedActuator]],
        *,
        clock: WallClock,
        duration: float,
        period: float,
        sink: EventSink,
        ended: Callable[[], str],
        check: Callable[[], None] = lambda: None,
    ) -> None:
        self.t = 0.0
        self._agents = agents
        self._gates = [gate for each in gates.values() for gate in each.values()]
        self._wheels = wheels
        self._links = links
        self._clock = clock
        self._duration = duration
        self._period = period
        self._sink = sink
        self._ended = ended
        self._check = check
        self._judges = {agent.name: Judge(end_on_stuck=False) for agent in agents}
        self._judging = Judging(agents, self._judges, sink)
        self._stuck: set[str] = set()

    def run(self) -> None:
        """Run until every agent has its outcome, the time is over, or a signal ends it."""
        clock, never, count = self._clock, threading.Event(), 0
        clock.start()
        try:
            with ExitStack() as stack:
                for agent in self._agents:
                    stack.enter_context(ThreadedRunner(agent, clock))
                stack.callback(brake, self._agents)
                while wait_until(clock, count * self._period, never, self._ended):
                    self.t = clock.now()
                    self._look()
                    if why := self._ended():
                        self._judging.interrupt(why, at_once=True)
                    if self._judging.over or self.t >= self._duration:
                        break
                    count = max(count + 1, int(self.t / self._period) + 1)
        except BaseException as error:  # raised again, after the robots stopped
            self._judging.abort(error, self.t)
            raise
        self._judging.finish(self.t)

    def _look(self) -> None:
        """Check devices and progress of all agents."""
        self._check()
        for gate in self._gates:
            gate.check()
        for agent in self._agents:
            for link in self._links[agent.name]:
                if (error := link.check()) is not None:
                    agent.fail(link.name, error.kind, str(error), error, owner="content")
            self._judge(agent)

    def _judge(self, agent: Agent) -> None:
        name, judge, pose = agent.name, self._judges[agent.name], agent.knowledge.robot.pose()
        if math.isfinite(pose.x):
            self._sink.emit(BodyMoved(t=self.t, agent=name, body=name, x=pose.x, y=pose.y, yaw=pose.yaw))
        if judge.decided:
            return
        if judge.update(self.t, pose, agent, commanded=self._wheels[name].active):
            agent.brake()
        if not judge.stuck:
            self._stuck.discard(name)
        elif name not in self._stuck:
            self._stuck.add(name)
            self._sink.emit(Stuck(t=self.t, agent=name, reason=judge.stuck, rule=judge.stuck_rule))
