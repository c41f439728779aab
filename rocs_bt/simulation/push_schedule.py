"""Scheduled pushes: forces on robots at times, and in directions, that are sampled with the seed."""

from __future__ import annotations

import math

from ..catalog import PushSpec, ScenarioSpec
from ..declare import replaced
from ..devices.mujoco import MujocoWorld
from ..event import EventSink, RobotPushed
from .random_streams import push_of, stream

_SAME = 1e-9  # [s]


class PushSchedule:
    """Pushes a robot once.

    Args:
        push: Robot, force and duration.
        at: Time of the push [s].
        world: World of the robot.
        sink: Sink for the event `RobotPushed`.
        agent: Name of the robot's agent; empty for a scripted robot.
    """

    def __init__(self, push: PushSpec, at: float, world: MujocoWorld, sink: EventSink, agent: str) -> None:
        self._push = push
        self._at = at
        self._world = world
        self._sink = sink
        self._agent = agent
        self._done = False

    def step(self, t: float) -> None:
        """Begin the push if it is due at time t [s]."""
        if self._done or t < self._at - _SAME:
            return
        self._done = True
        robot, force, duration = self._push.robot, self._push.force, self._push.duration
        self._world.push(robot, force, duration)
        self._sink.emit(RobotPushed(t=t, agent=self._agent, body=robot, force=force, duration=duration))


def push_schedules(scenario: ScenarioSpec, seed: int, world: MujocoWorld, sink: EventSink) -> list[PushSchedule]:
    """Create the pushes of a scenario, with their times and directions."""
    agents, made = {agent.name for agent in scenario.agents}, []
    for i, push in enumerate(scenario.pushes):
        rng = stream(scenario.name, seed, push.robot, push_of(i))
        at = float(rng.uniform(push.at, push.latest))
        angle = float(rng.uniform(-push.spread, push.spread))
        turned = replaced(push, force=_turned(push.force, angle))
        made.append(PushSchedule(turned, at, world, sink, push.robot if push.robot in agents else ""))
    return made


def _turned(force: tuple[float, float, float], angle: float) -> tuple[float, float, float]:
    """The force, turned to the left about the vertical by an angle [rad]."""
    forward, left, up = force
    c, s = math.cos(angle), math.sin(angle)
    return c * forward - s * left, s * forward + c * left, up
