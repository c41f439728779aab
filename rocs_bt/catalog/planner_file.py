"""planner.toml: a planner by its name: a mission, what it flinches from, its parameters, and how long it thinks."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from ..document import Table, read_toml
from ..errors import Fault, InputError
from ..python_content import is_reference
from .scenario_file import AgentSpec, ScenarioSpec, dialect_in
from .values import latency_of

FORMAT = "planner/1"
Missing = Callable[[str, str], Fault | None]


@dataclass(frozen=True, kw_only=True)
class PlannerSpec:
    """A planner: everything of a mind that may be swapped on a robot. Files make it, and so may a program.

    Attributes:
        name: What results call it.
        mission: A mission's name; or `file.py:Class`, a PythonPlanner that is no tree.
        rules: The names of its rule files; none for a planner without reflexes.
        parameters: The mission's, as a scenario writes them: `{"cruise": "0.5 m/s"}`.
        latency: How long it thinks [s], in simulated time; None where that is measured, which does not repeat.
        nodes: Dialect of a mission in XML: empty for ours, `nav2` for Nav2's nodes.
        oracle: Whether it gets privileged information, such as the map (`Mission.privileged`).
        doc: One sentence for people.
        source: The book or the paper that it is from.
        file: Its file; None for one that a program made.
    """

    name: str
    mission: str
    rules: tuple[str, ...] = ()
    parameters: Mapping[str, Any] = field(default_factory=dict)
    latency: float | None = 0.0
    nodes: str = ""
    oracle: bool = False
    doc: str = ""
    source: str = ""
    file: Path | None = None

    def drives(self, scenario: ScenarioSpec, agent: str, privileged: Mapping[str, Any] | None = None) -> ScenarioSpec:
        """A scenario in which this planner is the mind of an agent. The file, and so every random draw, stays.

        Args:
            scenario: The scenario.
            agent: The name of one of its agents.
            privileged: Information for oracle planners; not passed to others.
        """
        known = (privileged or {}) if self.oracle else {}
        agents = [self._instead_of(each, known) if each.name == agent else each for each in scenario.agents]
        return replace(scenario, agents=tuple(agents))

    def _instead_of(self, agent: AgentSpec, privileged: Mapping[str, Any]) -> AgentSpec:
        return replace(
            agent,
            mission=self.mission,
            rules=self.rules,
            parameters=dict(self.parameters),
            latency=self.latency,
            nodes=self.nodes,
            privileged=privileged,
        )


def read_planner(file: Path, missing: Missing = lambda kind, name: None) -> PlannerSpec:
    """Read a planner.toml.

    Args:
        file: The file.
        missing: Told of each name of other content; its fault is noted at that name.

    Raises:
        InputError: With every fault, each at its line.
    """
    root = read_toml(file)
    root.choice("format", (FORMAT,))
    doc, source = root.text("doc", ""), root.text("source", "")
    rules = tuple(root.texts("rules", []))
    for name in rules:
        if fault := missing("rules", name):
            root.fault("rules", fault.message, fault.hint)
    parameters = root.table("parameters")
    spec = PlannerSpec(
        name=file.stem,
        mission=_mission(root, missing),
        rules=rules,
        parameters={key: parameters.raw(key) for key in parameters.keys()},  # noqa: SIM118 - a Table is no mapping
        latency=latency_of(root),
        nodes=dialect_in(root, "rocs").removeprefix("rocs"),
        oracle=root.flag("oracle", False),
        doc=doc,
        source=source,
        file=file,
    )
    root.done()
    return spec


def at_parameters(planner: PlannerSpec, error: InputError) -> InputError:
    """The same faults, at the place of the planner's parameters in its file where they have none of their own."""
    if planner.file is None:
        return error
    table = read_toml(planner.file)
    return error.at(planner.file, *table.position("parameters" if "parameters" in table else None))


def _mission(root: Table, missing: Missing) -> str:
    """Its mission, or the class beside the file that takes a mission's place."""
    root.text("mission", ""), root.text("python", "")  # both are keys that may be there
    if ("mission" in root) == ("python" in root):
        root.fault(None, "a planner is either a mission or a Python class.", "Write mission = ... or python = ...")
        return ""
    key = "mission" if "mission" in root else "python"
    name = root.text(key)
    if key == "python" and not is_reference(name):
        root.fault(key, f"'{name}' names no class.", 'Write python = "file.py:Class", of a file beside this one.')
        return name
    if key == "python" and root.file.parent.name != "planners":
        name = str(root.file.parent / name)  # which is how a catalog finds what stands elsewhere
    if fault := missing("mission", name):
        root.fault(key, fault.message, fault.hint)
    return name
