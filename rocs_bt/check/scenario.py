"""Check of scenarios: builds all referenced content as for a run."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import closing

from ..agent import Agent
from ..base.errors import Fault, collected, located_at
from ..base.files import read_text
from ..base.registered import load, registered
from ..catalog import AgentSpec, Catalog, Entry, RobotSpec, ScenarioSpec
from ..declare import location_of
from ..expression import Environment
from ..monitor import Monitor, RangeMonitor, ScanMonitor
from ..plan import Plan
from ..plan.mission_texts import words_in
from ..reactive import OnInvalid, Rule
from ..reactive.analysis import analyse_fit
from ..running import Build, Run
from ..running.hardware_devices import on_hardware
from ..running.signal_sources import signal_monitors, signals_read
from ..trees.examine import blocking_faults
from .feasible import check_feasible
from .rules import examined, inactive_faults


def check_scenario_file(entry: Entry, catalog: Catalog) -> Iterable[Fault]:
    """Check the file of a scenario, and the scenario; see `run_faults`."""
    # Read with code allowed: reading runs no code, and most checks do not either.
    reader = catalog if catalog.code else Catalog(catalog.project)
    with closing(Run(reader.load_scenario(str(entry.path)), catalog)) as run:
        yield from run_faults(run, prepared(run))


def prepared(run: Run) -> list[Fault]:
    """Prepare a run, and return its faults; missions that need code which may not run do nothing then."""
    found = list[Fault]()
    if not run.catalog.code:
        run.options = run.options.changed(missions=_idle_missions(run.spec, run.catalog))
    run.prepare(found)
    return found


def run_faults(run: Run, found: list[Fault]) -> Iterator[Fault]:
    """Judge a prepared run: its agents with their rules, and whether its goals are free."""
    scenario, catalog = run.spec, run.catalog
    built = {agent.name: agent for agent in run.agents}
    for agent in scenario.agents:
        with collected(found), located_at(scenario.file, location_of(agent).line):
            if agent.name in built:
                found += _agent_faults(scenario, agent, catalog, built[agent.name])
    for table in sorted(scenario.tables.keys() & registered("rocs_bt.checks")):
        found += load("rocs_bt.checks", table)(scenario, catalog.load_schema())
    found += _late_pushes(scenario)
    found += _slow_sensors(scenario, catalog)
    yield from found
    if run.prepared:
        yield from check_feasible(run)


def _idle_missions(scenario: ScenarioSpec, catalog: Catalog) -> dict[str, Build]:
    """Missions that do nothing, for the agents with missions that need code."""
    agents = {a.name: catalog.content_of_controller(a) for a in scenario.agents}
    return {name: Plan.idle for name, used in agents.items() if any(entry.path.suffix == ".py" for entry in used)}


_SLOW = 0.2  # [s] interval of readings above which reflexes and path following are late: that of the watchdog


def _slow_sensors(scenario: ScenarioSpec, catalog: Catalog) -> Iterator[Fault]:
    """Warn of a common sensor rate with which the robots drive too far from one reading to the next."""
    hz = scenario.rate.sensors
    if hz is None or 1.0 / hz <= _SLOW:
        return
    for name, agent in {agent.robot: agent for agent in scenario.agents}.items():
        locomotion = catalog.robot_of(agent).locomotion
        speed = max(locomotion.axis_limits(axis).max_speed for axis in locomotion.axes if axis != "wz")
        message = (
            f"at {hz:g} Hz, {name} drives up to {speed / hz:.2g} m from one reading of its sensors to the next: "
            "reflexes are late, and it may never reach its goal."
        )
        hint = f"Use at least {1.0 / _SLOW:g} Hz, better the {scenario.rate.control:g} Hz of the control."
        yield Fault(message, scenario.file, location_of(scenario.rate).line, hint=hint, warning=True)


def _late_pushes(scenario: ScenarioSpec) -> Iterable[Fault]:
    """Warnings about pushes that do not happen, or may not happen, because the run ends before them."""
    end = scenario.duration
    for push in scenario.pushes:
        if push.at >= end or push.latest > end:
            when = f"at {push.at:g} s" if push.at >= end else f"from {push.at:g} s to {push.latest:g} s"
            what = "does not happen" if push.at >= end else "may not happen"
            message = f"the push of {push.robot} {when} {what}: the run ends at {end:g} s."
            hint = "Push earlier, or increase the scenario's duration."
            yield Fault(message, scenario.file, location_of(push).line, hint=hint, warning=True)


def _agent_faults(scenario: ScenarioSpec, agent: AgentSpec, catalog: Catalog, built: Agent) -> Iterator[Fault]:
    """Faults of an agent's rules and code, which could be built."""
    robot = catalog.robot_of(agent)
    environment, actions = Environment.of(built.knowledge.signals, robot.constants), built.plan.actions
    modes = words_in(catalog.find("mission", agent.mission).path) if agent.mission else None
    period, found = scenario.rate.control_rate.period, list[Rule]()
    for name in agent.rules:
        yield from examined(catalog.find("rules", name).path, robot, environment, actions, catalog).faults
    for file in built.reloadable_rules:
        rules = file.model.rules
        yield from analyse_fit(rules.rules, environment, period, modes)
        yield from inactive_faults(rules, robot.name, catalog)
        found += rules.rules
    if on_hardware(catalog, robot):
        yield from (fault.at(scenario.file, location_of(agent).line) for fault in unprotected(built, robot, found))
    for entry in catalog.content_of_controller(agent):
        if entry.path.suffix == ".py":
            yield from blocking_faults(read_text(entry.path), entry.path)


_RULE = (
    'rule.{name} = {{ when = "{guard}", for = "0.1 s", trigger = "level", priority = 100, on_invalid = "trip", '
    'action = {{ name = "Stop", below = "0 m/s", patience = "1 h" }} }}'
)


def unprotected(agent: Agent, robot: RobotSpec, rules: Sequence[Rule]) -> Iterator[Fault]:
    """Warn of ranges and poses without which the robot drives on: no rule with `on_invalid = "trip"` reads them."""
    guards = (rule.when.node for rule in rules if rule.on_invalid is OnInvalid.TRIP)
    sources, covered = signal_monitors(agent, robot), set[str]()
    for signal in signals_read(guards, agent.knowledge):
        covered.update(sources.get(signal, ()))
    for monitor in agent.monitors:
        if monitor.name not in covered and (found := _safety_signal(monitor)):
            signal, guard = found
            sensors = ", ".join(each.sensor.name for each in monitor.monitored)
            message = f"no rule of '{agent.name}' stops the robot while '{signal}' is invalid, without {sensors}."
            rule = _RULE.format(name=f"Without{signal.title().replace('_', '')}", guard=guard)
            yield Fault(message, hint=f"Add the rules avoid_collision, or to a rule file: {rule}", warning=True)


def _safety_signal(monitor: Monitor) -> tuple[str, str] | None:
    """Signal of ranges or of a pose, and a guard that is never true but needs it; None if the monitor has none."""
    names = [signal.name for signal in monitor.signals()]
    if isinstance(monitor, (RangeMonitor, ScanMonitor)):
        group = next((name for name in names[1:] if name in ("front", "rear")), names[0])
        return names[0], f"min({group}) < 0 m"
    return ("pose", "goal_distance < 0 m") if "pose" in names else None
