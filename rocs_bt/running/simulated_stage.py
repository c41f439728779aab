"""SimulatedStage: a run in a simulated world, in lockstep or in real time (docs/architecture.md)."""

from __future__ import annotations

import hashlib
import math
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager

from ..agent import Agent, AgentRuntime, ThreadedRunner
from ..base.clock import Clock, Rate, WallClock, wait_until
from ..base.errors import Fault
from ..base.python_content import running_class
from ..catalog import Catalog, ScenarioSpec
from ..devices.mujoco import Contact
from ..event import BodyMoved, ContactBegan, EventSink, GoalEntered, pack
from ..simulation.body_shapes import RobotShapes
from ..simulation.clearance import ClearanceWatch
from ..simulation.fact_schedule import FactSchedule, fact_schedules
from ..simulation.foresight import Foresight
from ..simulation.pace import Pace
from ..simulation.physics_thread import PhysicsThread
from ..simulation.scripted_object import ScriptedObject
from ..simulation.simulated_world import SimulatedWorld, build_world
from .build_agents import build_agents
from .run_loop import LoopAgent, brake
from .run_options import Build, RunOptions

_PAUSE = "pause of the run"  # source of the holds


class SimulatedStage:
    """Simulated world as the stage of a run.

    In lockstep a single thread runs agents, actors and physics by turns, repeatable bit by bit. Else physics and each
    block of the agents have threads of their own, and the run goes on in real time.

    Args:
        simulated: World, scripted actors and objects, and judges of the agents.
        agents: Agents of the scenario.
        sink: Sink for the ground truth.
        control: Control rate in physics steps.
        facts: Scheduled facts of the agents.
        foresight: Foresight of the agents with an oracle; None without one.
        wall: Wall clock of world and agents, which `playing` starts at zero; None in lockstep.

    Attributes:
        clock: Clock of the run.
        agents: Agents of the scenario, without those of tests.
        judges: Judges of the outcomes, by agent.
        time_stops: Whether the run is in lockstep.
        start: Time of the first control period [s].
        simulated: World of the run.
    """

    def __init__(
        self,
        simulated: SimulatedWorld,
        agents: Sequence[LoopAgent],
        sink: EventSink,
        *,
        control: Rate,
        facts: Sequence[FactSchedule] = (),
        foresight: Foresight | None = None,
        wall: WallClock | None = None,
    ) -> None:
        self.clock: Clock = simulated.clock
        self.judges = simulated.judges
        self.time_stops = wall is None
        self.simulated = simulated
        self._world = simulated.world
        self.agents = [agent for agent in agents if isinstance(agent, Agent)]
        self.start = 0.0
        self._agents = agents
        self._sink = sink
        self._control = control
        self._actors = (*simulated.actors, *facts)
        self._foresight = foresight
        self._wall = wall
        self._paused = False
        self._clearance = ClearanceWatch(simulated.world, [a.name for a in agents], sink, simulated.spatial)
        self._inside: set[tuple[str, str]] = set()
        self._joints = {name: RobotShapes(simulated.world, name).addresses for name in simulated.spatial}
        self._hash = hashlib.sha256()
        self._count = 0

    @classmethod
    def of(
        cls,
        spec: ScenarioSpec,
        catalog: Catalog,
        options: RunOptions,
        sink: EventSink,
        faults: list[Fault] | None = None,
    ) -> SimulatedStage:
        """Build the world of a scenario and its agents; in a check, the faults of agents are added to a list.

        Raises:
            InputError: The content is invalid.
        """
        wall = WallClock(running=False) if options.mode == "threaded" else None
        simulated = build_world(spec, catalog, options.seed, sink, clock=wall)
        if options.prepare is not None:
            options.prepare(simulated)
        agents = simulated_agents(spec, simulated, catalog, sink, options.missions, options.seed, faults)
        return cls(
            simulated,
            agents,
            sink,
            control=spec.rate.control_rate,
            facts=fact_schedules(spec, agents, simulated),
            foresight=_foresight(spec, agents, simulated),
            wall=wall,
        )

    def observers(self, stack: ExitStack, options: RunOptions) -> Callable[[float], bool]:
        """Open the viewer and the video; the function observes a control period, False if the viewer was closed."""
        observers: list[Callable[[float], bool]] = []
        if options.view:
            from ..simulation.viewer import Viewer

            observers.append(stack.enter_context(Viewer(self._world)))
        if options.video is not None:
            from ..simulation.video import Video

            observers.append(stack.enter_context(Video(self._world, options.video, follow=options.follow)))
        if options.live is not None:
            observers.append(Pace())
        return lambda t: sum(not observe(t) for observe in observers) == 0  # every observer is called

    def ready(self, ended: Callable[[], str]) -> bool:
        """A simulation is always ready."""
        return True

    @property
    def trajectory_hash(self) -> str:
        """Hash of the generalised positions at all control periods."""
        return self._hash.hexdigest()

    @contextmanager
    def playing(self, ended: Callable[[], str]) -> Iterator[Iterator[float]]:
        """Context in which the run goes on; see `Stage.playing`.

        Raises:
            BlockError: The physics thread failed.
        """
        if self._wall is None:
            yield iter(self.clock.now, None)
            return
        self._wall.start()
        stop = threading.Event()
        with ExitStack() as stack:
            physics = stack.enter_context(PhysicsThread(self._world, self._wall, stop))
            for agent in self.agents:
                stack.enter_context(ThreadedRunner(agent, self._wall))
            stack.callback(brake, self._agents)
            yield self._periods(self._wall, stop, ended)
        physics.raise_failure()

    def _periods(self, clock: WallClock, stop: threading.Event, ended: Callable[[], str]) -> Iterator[float]:
        count, period = 0, self._control.period
        while wait_until(clock, count * period, stop, ended):
            t = clock.now()
            yield t
            count = max(count + 1, int(t / period) + 1)

    def observe(self, t: float) -> None:
        """Pass the ground truth to the event sink and to the judges."""
        world = self._world
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
            kind = "collision" if contact.driven else "struck"
            if contact.robot in self.judges:
                self._sink.emit(ContactBegan(t=contact.t, agent=contact.robot, other=contact.other, kind=kind))
        self._clearance.update(t)
        for agent in self._agents:
            self._judge(t, agent, contacts)

    def advance(self, t: float) -> None:
        """Let the actors go on, and in lockstep the agents before and the physics after them."""
        if self._foresight is not None:
            self._foresight.step(t)
        if self.time_stops:
            for agent in self._agents:
                if not self.judges[agent.name].decided:
                    agent.step(self._count)
        for actor in self._actors:
            with running_class(type(actor)):  # a fault in a script of the project names its file
                actor.step(t)
        if self.time_stops:
            self._world.advance(self._control.every)
            self._count += 1

    def rest(self) -> None:
        """Do nothing: no device outlives the world."""

    def pause(self, by: str) -> None:
        """Hold the robots in real time; in lockstep nothing moves while the run waits."""
        if not self.time_stops:
            self._paused = True
            for agent in self.agents:
                agent.hold(f"paused by {by}", _PAUSE)

    def resume(self, by: str) -> None:
        """Let the robots move again."""
        if not self.time_stops:
            self._paused = False
            for agent in self.agents:
                agent.resume(_PAUSE, by)

    def _emit_pose(self, t: float, name: str) -> None:
        (x, y, yaw), wheels = self._world.pose(name), self.simulated.wheels.get(name)
        agent = name if name in self.judges else ""
        packed = pack(wheels()) if wheels is not None else b""
        if name not in self.simulated.spatial:
            self._sink.emit(BodyMoved(t=t, agent=agent, body=name, x=x, y=y, yaw=yaw, wheels=packed))
            return
        _, _, z, roll, pitch, _ = self._world.pose3(name)
        joints = tuple(self._world.data.qpos[self._joints[name]].round(3).tolist())
        pose = {"x": x, "y": y, "yaw": yaw, "height": z, "roll": roll, "pitch": pitch}
        self._sink.emit(BodyMoved(t=t, agent=agent, body=name, wheels=packed, joints=joints, **pose))

    def _judge(self, t: float, agent: LoopAgent, contacts: Sequence[Contact]) -> None:
        name, world, judge = agent.name, self._world, self.judges[agent.name]
        pose, z = world.pose(name), world.pose3(name).z if name in self.simulated.spatial else math.nan
        for goal in self.simulated.goals.get(name, ()):
            if not goal.reached(pose, z):
                self._inside.discard((name, goal.name))
            elif (name, goal.name) not in self._inside:
                self._inside.add((name, goal.name))
                self._sink.emit(GoalEntered(t=t, agent=name, goal=goal.name, distance=goal.distance(pose, z)))
        if judge.decided:
            return
        if judge.update(
            t,
            pose,
            agent,
            commanded=world.commanded(name),
            collisions=[c.other for c in contacts if c.robot == name and c.driven],
            tilt=world.tilt(name),
            ground=world.ground_contact(name),
            z=z,
            paused=self._paused,
        ):
            agent.stop(f"its outcome, {judge.verdict().outcome}")


def simulated_agents(
    spec: ScenarioSpec,
    simulated: SimulatedWorld,
    catalog: Catalog,
    sink: EventSink,
    missions: Mapping[str, Build] | None = None,
    seed: int = 0,
    faults: list[Fault] | None = None,
) -> list[Agent]:
    """Build the agents of a scenario in its simulated world; see `build_agents`."""
    devices = {agent.name: simulated.devices(agent.name) for agent in spec.agents}
    runtime = AgentRuntime(simulated.clock, sink, time.perf_counter)
    return build_agents(spec, catalog, devices, runtime, seed=seed, missions=missions, faults=faults)


def _foresight(spec: ScenarioSpec, agents: Sequence[Agent], simulated: SimulatedWorld) -> Foresight | None:
    names = {agent.name for agent in spec.agents if agent.privileged is not None}
    oracles = [agent.knowledge.world for agent in agents if agent.name in names]
    scripts = [actor for actor in simulated.actors if isinstance(actor, ScriptedObject)]
    return Foresight(simulated.world, scripts, oracles) if oracles else None
