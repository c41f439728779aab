"""Episode: one simulated run of a world and its agents (docs/architecture.md)."""

from __future__ import annotations

import hashlib
import math
import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack
from dataclasses import dataclass

from ..clock import Rate, WallClock, wait_until
from ..drivers.mujoco import Contact
from ..event import BodyMoved, ContactBegan, EventSink, GoalEntered, pack
from ..simulation.body_shapes import RobotShapes
from ..simulation.clearance import ClearanceWatch
from ..simulation.fact_schedule import FactSchedule
from ..simulation.outcome import Verdict
from ..simulation.physics_thread import PhysicsThread
from ..simulation.simulated_world import SimulatedWorld
from .judge_panel import END, EpisodeAgent, JudgePanel, brake

CLOSED = "the viewer was closed"
"""Reason of the outcome `interrupted` if the observer of the run ended it."""


@dataclass(frozen=True)
class Result:
    """Result of an episode.

    Attributes:
        verdicts: Verdicts by agent.
        sim_time: Simulated duration [s].
        wall_time: Wall-clock duration of the run [s].
        trajectory_hash: sha256 of the float64 generalised positions at all control periods.
        lateness: Maximum delay of physics behind the wall clock [s]; 0 in lockstep.
    """

    verdicts: Mapping[str, Verdict]
    sim_time: float
    wall_time: float
    trajectory_hash: str
    lateness: float = 0.0

    @property
    def real_time_factor(self) -> float:
        """Simulated time divided by wall-clock time."""
        return self.sim_time / max(self.wall_time, 1e-9)


class Episode:
    """One run of a scenario.

    Args:
        simulated: World, scripted actors and objects, and judges of the agents.
        agents: Agents of the scenario.
        facts: Scheduled facts of the agents.
        control: Control rate in physics steps.
        duration: Maximum duration [s].
        sink: Sink for all events.
        watch: Observer, called once per control period with the time [s]; False ends the run.
        ended: Returns the reason of a signal that ends the run, or an empty text; called once per control period.
        paused: Whether a person has paused the robots, so that no progress is due.

    Attributes:
        result: Result of the episode, also if `run` raised; None before its end.
    """

    def __init__(
        self,
        simulated: SimulatedWorld,
        agents: Sequence[EpisodeAgent],
        *,
        facts: Sequence[FactSchedule] = (),
        control: Rate,
        duration: float,
        sink: EventSink,
        watch: Callable[[float], bool] = lambda t: True,
        ended: Callable[[], str] = lambda: "",
        paused: Callable[[], bool] = lambda: False,
    ) -> None:
        self.result: Result | None = None
        self._world = simulated.world
        self._agents = agents
        self._judges = simulated.judges
        self._panel = JudgePanel(agents, simulated.judges, sink)
        self._actors = (*simulated.actors, *facts)
        self._wheels = simulated.wheels
        self._spatial = simulated.spatial
        self._joints = {name: RobotShapes(simulated.world, name).addresses for name in simulated.spatial}
        self._goals = simulated.goals
        self._control = control
        self._duration = duration
        self._sink = sink
        self._watch = watch
        self._ended = ended
        self._paused = paused
        self._clearance = ClearanceWatch(simulated.world, [agent.name for agent in agents], sink, simulated.spatial)
        self._inside: set[tuple[str, str]] = set()
        self._hash = hashlib.sha256()
        self._t = 0.0
        self._threaded = False

    def run(self) -> Result:
        """Run in lockstep: single-threaded, in the order of docs/architecture.md, repeatable bit by bit.

        If an exception is raised, all agents are stopped and their outcomes are determined before the exception
        propagates.
        """
        wall, count = WallClock(), 0
        try:
            while not self._observe(self._world.clock.now()):
                for agent in self._agents:
                    if not self._judges[agent.name].decided:
                        agent.step(count)
                for actor in self._actors:
                    actor.step(self._world.clock.now())
                self._world.advance(self._control.every)
                count += 1
        except BaseException as error:  # raised again, after the robots stopped
            self._abort(error, wall)
            raise
        return self._finish(wall)

    def run_threaded(self, clock: WallClock, runners: Sequence[AbstractContextManager[object]]) -> Result:
        """Run in real time: physics in a separate thread, each agent in the threads of its runner.

        If an exception is raised, all agents are stopped and their outcomes are determined before the exception
        propagates.

        Args:
            clock: Wall clock of the world and the agents; the run starts it at zero.
            runners: Runners of the agents, context managers that are entered after physics has started and left at the
                end.

        Raises:
            BlockError: The physics thread failed.
        """
        stop, count, period, self._threaded = threading.Event(), 0, self._control.period, True
        clock.start()
        try:
            with ExitStack() as stack:
                physics = stack.enter_context(PhysicsThread(self._world, clock, stop))
                for runner in runners:
                    stack.enter_context(runner)
                stack.callback(brake, self._agents)
                while wait_until(clock, count * period, stop, self._ended):
                    t = clock.now()
                    if self._observe(t):
                        break
                    for actor in self._actors:
                        actor.step(t)
                    count = max(count + 1, int(t / period) + 1)
            physics.raise_failure()
        except BaseException as error:  # raised again, after the robots stopped
            self._abort(error, clock)
            raise
        return self._finish(clock, physics.worst)

    def _observe(self, t: float) -> bool:
        """Pass the ground truth to the event sink and to the judges of the outcomes; True if the episode is over."""
        world, self._t = self._world, t
        with world.lock:
            world.digest(self._hash)
            contacts = world.contacts()
            for name in world.robots:
                self._emit_pose(t, name)
            for name in world.objects:
                pose = world.object_pose(name)
                self._sink.emit(BodyMoved(t=t, agent="", body=name, x=pose.x, y=pose.y, yaw=pose.yaw, wheels=b""))
        # Without the world's lock: a judge may stop an agent with threads that wait for the lock.
        for contact in contacts:
            kind = "collision" if contact.moving else "struck"
            if contact.robot in self._judges:
                self._sink.emit(ContactBegan(t=contact.t, agent=contact.robot, other=contact.other, kind=kind))
        self._clearance.update(t)
        for agent in self._agents:
            self._judge(t, agent, contacts)
        going = self._watch(t)
        if why := self._ended() or ("" if going else CLOSED):
            self._panel.interrupt(why, at_once=self._threaded)
        return self._panel.over or t >= self._duration - 1e-9

    def _emit_pose(self, t: float, name: str) -> None:
        (x, y, yaw), wheels = self._world.pose(name), self._wheels.get(name)
        agent = name if name in self._judges else ""
        packed = pack(wheels()) if wheels is not None else b""
        if name not in self._spatial:
            self._sink.emit(BodyMoved(t=t, agent=agent, body=name, x=x, y=y, yaw=yaw, wheels=packed))
            return
        _, _, z, roll, pitch, _ = self._world.pose3(name)
        joints = tuple(self._world.data.qpos[self._joints[name]].round(3).tolist())
        pose = {"x": x, "y": y, "yaw": yaw, "height": z, "roll": roll, "pitch": pitch}
        self._sink.emit(BodyMoved(t=t, agent=agent, body=name, wheels=packed, joints=joints, **pose))

    def _judge(self, t: float, agent: EpisodeAgent, contacts: Sequence[Contact]) -> None:
        name, world, judge = agent.name, self._world, self._judges[agent.name]
        pose, z = world.pose(name), world.position(name)[2] if name in self._spatial else math.nan
        for goal in self._goals.get(name, ()):
            if not goal.reached(pose, z):
                self._inside.discard((name, goal.name))
            elif (name, goal.name) not in self._inside:
                self._inside.add((name, goal.name))
                self._sink.emit(GoalEntered(t=t, agent=name, goal=goal.name, distance=goal.distance(pose, z)))
        if judge.decided:
            return
        ran_into = [c.other for c in contacts if c.robot == name and c.moving]
        tilt, ground = world.tilt(name), world.ground_contact(name)
        commanded, paused = world.commanded(name), self._paused()
        if judge.update(
            t, pose, agent, commanded=commanded, collisions=ran_into, tilt=tilt, ground=ground, z=z, paused=paused
        ):
            agent.stop(END)

    def _finish(self, wall: WallClock, lateness: float = 0.0) -> Result:
        wall_time = wall.now()
        return self._keep(self._panel.finish(self._t), wall_time, lateness)

    def _abort(self, error: BaseException, wall: WallClock) -> None:
        self._t, wall_time = max(self._t, self._world.clock.now()), wall.now()
        self._keep(self._panel.abort(error, self._t), wall_time)

    def _keep(self, verdicts: Mapping[str, Verdict], wall_time: float, lateness: float = 0.0) -> Result:
        self.result = Result(verdicts, self._t, wall_time, self._hash.hexdigest(), lateness)
        return self.result
