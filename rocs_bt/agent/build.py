"""Construction of an agent: blocks from robot.toml, a mission and rule files, connected as in the paper, 5.2."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from ..actions import action_table
from ..base.clock import Clock
from ..base.errors import Fault, InputError, collected, located_at
from ..catalog import ActuatorSpec, FactSpec, PlaceSpec, RobotSpec
from ..catalog import load_class as load_class_from_file
from ..control.follower import Follower
from ..control.locomotion import Locomotion
from ..declare import Open, location_of
from ..event import EventSink, NullSink
from ..execute import Execute, RobotBody
from ..expression import Environment, compile_expression
from ..interfaces.action import Action
from ..interfaces.device import Sensor
from ..interfaces.message import Mailbox
from ..interfaces.pipeline import Pipeline
from ..interfaces.safety_gate import SafetyGate
from ..interfaces.service import Service
from ..knowledge import SCHEMA, Knowledge, RobotModel, Schema, StrategyModel, WorldModel
from ..plan import CheckOptions, Mission, Plan, TreePlan, checked_plan
from ..reactive import Override, ReactiveModel, ReflexArc, RuleModel
from .agent import Agent
from .facts import add_facts, check_queries, read_attributes
from .parts import AgentRuntime, Blocks, Rates, RobotDevices
from .reloadable_rules import ReloadableRules
from .wiring import LoadClass, declare_signals, make_analyzers, make_monitors

Cache = Callable[[Hashable, Callable[[], Any]], Any]


@dataclass(frozen=True)
class Controller:
    """Controller of an agent: mission, reflexes and initial knowledge, without the robot.

    Attributes:
        build: Mission function, which takes a `Mission` and the parameters, and returns a tree or a user's own `Plan`.
        mission: Name of the mission.
        parameters: Parameters of the mission, SI units.
        rules: Rule files.
        reflexes: Function from the agent's Knowledge to reactive models in Python, in addition to those of rule files.
        places: Places and objects that are known at the beginning.
        facts: Facts that are known at the beginning (time 0), and facts that are scheduled for later.
        peers: Tags of the other robots, by name; robot sensors identify peers by tag.
        actions: Actions in addition to the shipped ones.
        latency: Planning latency [s], by which decisions take effect later. None to measure the latency during the run,
            which makes the run non-repeatable.
        world_model: Class of `knowledge.world` (paper, 5.3: an optional extension point, as the next two).
        robot_model: Class of `knowledge.robot`.
        strategy_model: Class of `knowledge.strategy`.
        schema: Schema of the Knowledge graph.
        privileged: Ground-truth information for oracle planners (`Mission.privileged`).
        check_options: Options of a check of the mission; None to build it without a check.
    """

    build: Callable[..., Any]
    mission: str = "mission"
    parameters: Mapping[str, Any] = field(default_factory=dict)
    rules: Sequence[Path] = ()
    reflexes: Callable[[Knowledge], Sequence[ReactiveModel]] = lambda knowledge: ()
    places: Sequence[PlaceSpec] = ()
    facts: Sequence[FactSpec] = ()
    peers: Mapping[str, int] = field(default_factory=dict)
    actions: Sequence[type[Action]] = ()
    latency: float | None = 0.0
    world_model: type[WorldModel] = WorldModel
    robot_model: type[RobotModel] = RobotModel
    strategy_model: type[StrategyModel] = StrategyModel
    schema: Schema = SCHEMA
    privileged: Mapping[str, Any] = field(default_factory=dict)
    check_options: CheckOptions | None = None


def build_agent(
    name: str,
    devices: RobotDevices,
    controller: Controller,
    rates: Rates,
    runtime: AgentRuntime,
    *,
    load_class: LoadClass = load_class_from_file,
    cached: Cache = lambda key, make: make(),
    share: Callable[[Knowledge], Service] | None = None,
    faults: list[Fault] | None = None,
) -> Agent:
    """Build, connect and check all blocks of one agent, without running them.

    Args:
        name: Name of the agent.
        devices: Specification and devices of the robot.
        controller: Mission, rules and initial knowledge.
        rates: Rates of the blocks.
        runtime: Clock, sink, timer and random streams.
        load_class: Loader of classes that robot.toml names as `file.py:Class`.
        cached: Cache of data that agents with the same content share (`Catalog.cached`).
        share: Factory of the knowledge sharing; None without sharing.
        faults: List to which the faults of mission and rules are added, in a check: with errors, the agent lacks these
            rules, and its plan does nothing. By default they are raised.

    Raises:
        InputError: A class, signal, action or parameter is unknown, or content is faulty; the error lists all faults.
    """
    robot, clock, sink = devices.robot, runtime.clock, runtime.sink
    locomotion = robot.locomotion
    knowledge = _knowledge(name, robot, locomotion, controller, clock, sink)
    _check_motion(robot, locomotion, devices.actuators)
    monitors = make_monitors(robot, knowledge, devices.sensors, devices.sensor_rates, sink, load_class)
    analyzers = make_analyzers(robot, knowledge, monitors, sink, load_class)
    declare_signals(knowledge, [*monitors, *analyzers], robot)
    check_queries(knowledge, controller.facts)
    actions = action_table(*controller.actions)
    pipeline = Pipeline(clock, sink, name, latency=controller.latency)
    environment = Environment.of(knowledge.signals, robot.constants)
    reloadable_rules = _reloadable_rules(controller, robot, environment, actions, knowledge, cached, faults)
    knowledge.reactive_models.extend([*(file.model for file in reloadable_rules), *controller.reflexes(knowledge)])
    _follow_mode(knowledge, [file.model for file in reloadable_rules])
    sharing = None if share is None else _with_mailbox(share(knowledge), devices.sensors)
    body = _body(devices, knowledge, locomotion, rates, runtime, sharing)
    arc = ReflexArc(knowledge.reactive_models, pipeline, actions, sink, name, clock)
    mission = Mission(
        controller.mission,
        knowledge=knowledge,
        pipeline=pipeline,
        actions=actions,
        compile_guard=lambda text: compile_expression(text, environment),
        rule_reading=arc.reading,
        rule_waits=arc.waits,
        rng=runtime.rng,
        privileged=controller.privileged,
        services=devices.services,
        tables=robot.tables,
        motion_held=lambda: devices.actuators[robot.motion.actuator].held,
        check_options=controller.check_options,
    )
    plan = _plan(controller, mission, faults)
    arc.on_end = lambda rule: plan.replan(f"{rule} ended")
    for analyze in analyzers:
        analyze.attach(plan)
    blocks = Blocks(monitors, analyzers, plan, Execute(pipeline, body), arc, pipeline)
    return Agent(name, knowledge, devices, blocks, rates, runtime, reloadable_rules=reloadable_rules, sharing=sharing)


def _body(
    devices: RobotDevices,
    knowledge: Knowledge,
    locomotion: Locomotion,
    rates: Rates,
    runtime: AgentRuntime,
    sharing: Service | None,
) -> RobotBody:
    """Create the body of the robot, which the agent's actions use."""
    body = RobotBody(
        knowledge=knowledge,
        locomotion=locomotion,
        follower=Follower(locomotion, timer=runtime.timer),
        clock=runtime.clock,
        period=rates.control.period,
        actuators=devices.actuators,
        motion=devices.robot.motion.actuator,
        sink=runtime.sink,
    )
    body.messenger = None if sharing is None else sharing.messenger
    return body


def _knowledge(
    name: str, robot: RobotSpec, locomotion: Locomotion, controller: Controller, clock: Clock, sink: EventSink
) -> Knowledge:
    """Create the Knowledge at the beginning of the run; also checks that the scheduled facts can be added."""
    knowledge = Knowledge(
        name, clock, sink, controller.schema, controller.world_model, controller.robot_model, controller.strategy_model
    )
    describe(knowledge, robot, locomotion, controller.places, controller.peers)
    add_facts(knowledge, [fact for fact in controller.facts if not fact.at])
    if any(fact.at for fact in controller.facts):  # a dry run finds faults of scheduled facts before the run
        rehearsal = Knowledge(name, clock, NullSink(), controller.schema)
        describe(rehearsal, robot, locomotion, controller.places, controller.peers)
        add_facts(rehearsal, sorted(controller.facts, key=lambda fact: fact.at))
    return knowledge


def _reloadable_rules(
    controller: Controller,
    robot: RobotSpec,
    environment: Environment,
    actions: Mapping[str, type[Action]],
    knowledge: Knowledge,
    cached: Cache,
    faults: list[Fault] | None,
) -> list[ReloadableRules]:
    """Load the rule files; agents with the same robot and mission share the parsed rules."""
    found = []
    for file in controller.rules:
        shared = partial(cached, ("rules", file, robot.file, controller.mission))
        with collected(faults):
            found.append(ReloadableRules(file, environment, actions, thresholds(robot, file), knowledge, shared))
    return found


def _plan(controller: Controller, mission: Mission, faults: list[Fault] | None) -> Plan:
    """Call the mission's `build`; returns its Plan, or a TreePlan for its tree."""
    if faults is not None and mission.check_options is not None:
        plan = checked_plan(controller.build, mission, controller.parameters)
        faults += mission.faults
        return plan or Plan.idle(mission)
    with located_at(*_source(controller.build)):
        planned = controller.build(mission, **controller.parameters)
        return planned if isinstance(planned, Plan) else TreePlan(planned, mission)


def describe(
    knowledge: Knowledge,
    robot: RobotSpec,
    locomotion: Locomotion,
    places: Sequence[PlaceSpec],
    peers: Mapping[str, int],
) -> None:
    """Write the robot, its devices, the places and the peers to the Knowledge graph (paper, 4.2)."""
    graph, name = knowledge.graph, knowledge.agent
    knowledge.robot.locomotion = locomotion
    groups = [item for monitor in robot.monitors for item in monitor.parameters.get("group", {}).items()]
    knowledge.robot.blind = frozenset(name for name, group in groups if group.get("blind") is True)
    wheels: dict[str, Any] = {"neutral": locomotion.neutral}
    if locomotion.wheels:
        limits = float(locomotion.max_speed.min()), float(locomotion.max_acceleration.min())
        wheels = dict(zip(("wheel_speed_limit", "wheel_acceleration_limit"), limits, strict=True))
    sizes = {key: size for key in ("length", "width") if math.isfinite(size := getattr(robot.body, key))}
    graph.set(
        name,
        model=robot.name,
        drive=locomotion.kind,
        speed_limit=locomotion.speed_limit,
        turn_limit=locomotion.turn_limit,
        **wheels,
        **sizes,
    )
    for sensor in robot.sensors:
        with located_at(robot.file, sensor.line):
            graph.add(sensor.name, "sensor", **sensor.attributes)
            graph.relate(name, "has_sensor", sensor.name)
    for actuator in robot.actuators:
        with located_at(robot.file, actuator.line):
            graph.add(actuator.name, "actuator", driver=actuator.driver, **_limits(actuator))
            graph.relate(name, "has_actuator", actuator.name)
    for place in places:
        x, y, yaw = place.pose
        pose = place.pose if math.isfinite(yaw) else type(place.pose)(x, y)
        with located_at(None, location_of(place).line):  # the caller adds the scenario's file
            given = read_attributes(place, graph.schema)
            attributes = given if place.kind == "object" else {"tolerance": place.tolerance}
            if place.z is not None:
                attributes["z"] = place.z
            knowledge.world.place(place.name, pose, kind=place.kind, **attributes)
    for peer, tag in peers.items():
        graph.add(peer, "peer", tag=tag)


def _limits(actuator: ActuatorSpec) -> dict[str, float]:
    """Attributes of an actuator's node: the range of commands that all values of the actuator accept."""
    limits = actuator.limits
    found = {"range_low": max(limits.low), "range_high": min(limits.high), "max_command_age": actuator.max_command_age}
    return found | ({"max_change": min(limits.changes)} if math.isfinite(min(limits.changes)) else {})


def thresholds(robot: RobotSpec, rules: Path) -> dict[str, Override]:
    """Values of a rule file's thresholds that robot.toml declares, by name of the threshold."""
    own = robot.thresholds.get(rules.stem, Open())
    return {name: Override(value, location_of(own, name)) for name, value in own.items()}


def _follow_mode(knowledge: Knowledge, models: Sequence[RuleModel]) -> None:
    """Pass the agent's mode, the attribute `mode` of its own node, to the rules: now and after every change."""

    def enter() -> None:
        mode = knowledge.graph.attributes(knowledge.agent).get("mode", "")
        for model in models:
            model.enter(mode)

    knowledge.graph.subscribe(lambda change: enter() if change.name == "mode" else None, node=knowledge.agent)
    enter()


def _with_mailbox(sharing: Service, sensors: Mapping[str, Sensor]) -> Service:
    """Connect the sharing to the robot's mailbox sensor, which gets the received messages; returns the sharing."""
    sharing.messenger.message_queue = next((s.message_queue for s in sensors.values() if isinstance(s, Mailbox)), None)
    return sharing


def _check_motion(robot: RobotSpec, locomotion: Locomotion, actuators: Mapping[str, SafetyGate]) -> None:
    """Check that the actuator of the locomotion takes as many values as the locomotion has; raises InputError."""
    size, values = actuators[robot.motion.actuator].size, locomotion.values
    if size != len(values):
        raise InputError(
            Fault(
                f"the actuator '{robot.motion.actuator}' takes {size} values, but a '{locomotion.kind}' locomotion "
                f"has {len(values)}.",
                robot.file,
                robot.mover.line,
                hint=f"Give it one for each: {', '.join(values)}.",
            )
        )


def _source(build: Callable[..., Any]) -> tuple[Path | None, int]:
    """File and line of a mission: those of its `build` function, or the file of an XML mission."""
    if isinstance(file := getattr(build, "file", None), Path):
        return file, 0
    code = getattr(inspect.unwrap(build), "__code__", None)
    return (None, 0) if code is None else (Path(code.co_filename), code.co_firstlineno)
