"""Check that a robot on hardware stops without its range sensors and its pose."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ..agent import Agent
from ..base.errors import Fault
from ..catalog import RobotSpec
from ..monitor import Monitor, RangeMonitor, ScanMonitor
from ..reactive import OnInvalid, Rule
from ..running.signal_sources import signal_monitors, signals_read

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
