"""An episode: a world, its agents and movers, from the first control period to the last (docs/architecture.md)."""

from __future__ import annotations

import hashlib
import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack
from dataclasses import dataclass
from typing import Protocol

from ..clock import Rate, WallClock
from ..drivers.mujoco import Contact, MujocoWorld
from ..event import BodyMoved, EventSink, GoalEntered, Judged, Touched, pack
from .carried import Carrier
from .clearance import ClearanceWatch
from .mover import Mover
from .news import News
from .outcome import Goal, Judge, MindState, Verdict
from .physics_thread import PhysicsThread

END = "the end of the run"
"""Who cancels what is left when an agent's run is over."""


class Mind(MindState, Protocol):
    """What an episode needs of an agent."""

    @property
    def name(self) -> str:
        """The agent's name, which is its robot's in the world."""
        ...

    def step(self, count: int) -> None:
        """One control period in lockstep; `count` of them have passed."""
        ...

    def stop(self, by: str = ...) -> None:
        """Cancel everything and let the wheels stand."""
        ...


@dataclass(frozen=True)
class Result:
    """What came of an episode.

    Attributes:
        verdicts: By agent.
        sim_time: How long it took in the world [s].
        wall_time: How long it took to compute [s].
        trajectory_hash: sha256 of the float64 generalised positions at all control periods.
        lateness: The furthest that physics fell behind the wall clock [s]; 0 in lockstep.
    """

    verdicts: Mapping[str, Verdict]
    sim_time: float
    wall_time: float
    trajectory_hash: str
    lateness: float = 0.0

    @property
    def real_time_factor(self) -> float:
        """Simulated seconds a second."""
        return self.sim_time / max(self.wall_time, 1e-9)


class Episode:
    """One run of a scenario.

    Args:
        world: Where it happens; its robots are placed.
        minds: The agents.
        judges: Who watches each agent.
        movers: Who else moves, and what is told meanwhile.
        wheels: By robot, how fast its rims truly go [m/s]; robots that are not in it are drawn without.
        goals: The goals that each agent may enter.
        control: The control rate, over physics steps.
        duration: The longest it may take [s].
        sink: Where events go.
        watch: Called once a control period with the time [s], for progress, viewers and videos; False ends the run.
    """

    def __init__(
        self,
        world: MujocoWorld,
        minds: Sequence[Mind],
        judges: Mapping[str, Judge],
        *,
        movers: Sequence[Mover | Carrier | News] = (),
        wheels: Mapping[str, Callable[[], list[float]]] | None = None,
        goals: Mapping[str, Sequence[Goal]] | None = None,
        control: Rate,
        duration: float,
        sink: EventSink,
        watch: Callable[[float], bool] = lambda t: True,
    ) -> None:
        self._world = world
        self._minds = minds
        self._judges = judges
        self._movers = movers
        self._wheels = wheels or {}
        self._goals = goals or {}
        self._control = control
        self._duration = duration
        self._sink = sink
        self._watch = watch
        self._clearance = ClearanceWatch(world, [mind.name for mind in minds], sink)
        self._inside: set[tuple[str, str]] = set()
        self._hash = hashlib.sha256()

    def run(self) -> Result:
        """Run in lockstep: everything in one thread, in the order of the architecture, bit-identical when repeated."""
        wall, count = WallClock(), 0
        while True:
            t = self._world.clock.now()
            if self._observe(t):
                break
            for mind in self._minds:
                if not self._judges[mind.name].decided:
                    mind.step(count)
            for mover in self._movers:
                mover.step(t)
            self._world.advance(self._control.every)
            count += 1
        return self._finish(t, wall.now())

    def run_threaded(self, clock: WallClock, runners: Sequence[AbstractContextManager[object]]) -> Result:
        """Run on wall time: physics in a thread of its own, the agents in those that their runners start.

        Args:
            clock: Time, the world's and the agents' too; it begins at zero.
            runners: Entered when physics runs, left at the end.

        Raises:
            BlockError: The physics thread failed.
        """
        stop, count, period = threading.Event(), 0, self._control.period
        clock.start()
        with ExitStack() as stack:
            physics = stack.enter_context(PhysicsThread(self._world, clock, stop))
            for runner in runners:
                stack.enter_context(runner)
            while clock.wait_until(count * period, stop):
                t = clock.now()
                if self._observe(t):
                    break
                for mover in self._movers:
                    mover.step(t)
                count = max(count + 1, int(t / period) + 1)
        physics.raise_failure()
        return self._finish(t, clock.now(), physics.worst)

    def _observe(self, t: float) -> bool:
        """Tell the truth to sink and judges; True when the episode is over."""
        world = self._world
        with world.lock:
            world.digest(self._hash)
            contacts = world.contacts()
            for name in world.robots:
                self._tell_pose(t, name)
            for name in world.things:
                pose = world.thing_pose(name)
                self._sink.emit(BodyMoved(t=t, agent="", body=name, x=pose.x, y=pose.y, yaw=pose.yaw, wheels=b""))
        # Not under the world's lock: a judge may stop a mind, whose threads may be waiting for it.
        for contact in contacts:
            kind = "collision" if contact.moving else "struck"
            if contact.robot in self._judges:
                self._sink.emit(Touched(t=contact.t, agent=contact.robot, other=contact.other, kind=kind))
        self._clearance.look(t)
        for mind in self._minds:
            self._judge(t, mind, contacts)
        going = self._watch(t)
        over = all(judge.decided for judge in self._judges.values()) or t >= self._duration - 1e-9
        return over or not going

    def _tell_pose(self, t: float, name: str) -> None:
        pose, wheels = self._world.pose(name), self._wheels.get(name)
        agent = name if name in self._judges else ""
        packed = pack(wheels()) if wheels is not None else b""
        self._sink.emit(BodyMoved(t=t, agent=agent, body=name, x=pose.x, y=pose.y, yaw=pose.yaw, wheels=packed))

    def _judge(self, t: float, mind: Mind, contacts: Sequence[Contact]) -> None:
        name, world, judge = mind.name, self._world, self._judges[mind.name]
        pose = world.pose(name)
        for goal in self._goals.get(name, ()):
            away = pose.distance(goal.pose)
            if away > goal.tolerance:
                self._inside.discard((name, goal.name))
            elif (name, goal.name) not in self._inside:
                self._inside.add((name, goal.name))
                self._sink.emit(GoalEntered(t=t, agent=name, goal=goal.name, distance=away))
        if judge.decided:
            return
        ran_into = [c.other for c in contacts if c.robot == name and c.moving]
        if judge.update(t, pose, mind, commanded=world.commanded(name), collisions=ran_into):
            mind.stop(END)

    def _finish(self, t: float, wall_time: float, lateness: float = 0.0) -> Result:
        verdicts = {}
        for mind in self._minds:
            if not self._judges[mind.name].decided:
                mind.stop(END)
            verdict = verdicts[mind.name] = self._judges[mind.name].verdict()
            self._sink.emit(
                Judged(
                    t=t,
                    agent=mind.name,
                    outcome=verdict.outcome,
                    reason=verdict.reason,
                    time_to_goal=verdict.time_to_goal,
                )
            )
        return Result(verdicts, t, wall_time, self._hash.hexdigest(), lateness)
