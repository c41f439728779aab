"""Check of content files: selects the checker of each file and collects the faults."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from types import MappingProxyType

from ..base.errors import Fault, InputError, RocsError
from ..base.files import MOST_TEXT, is_file, read_bytes, read_once, read_text, unsaved
from ..base.raised import content_line, describe
from ..base.toml_table import read_toml
from ..catalog import (
    KINDS,
    PATTERNS,
    TREES,
    CachingCatalog,
    Catalog,
    Entry,
    ScenarioSpec,
    classes_in,
    find_project,
    functions_in,
    kind_of,
    make_entry,
    mission_values,
)
from ..declare import fields_of, read_root
from ..expression import one_for_each_signal
from ..knowledge import SCHEMA, load_schema
from ..reactive import tested_file
from ..running import Run
from ..trees.examine import blocking_faults
from ..trees.xml import included_files, survey
from .mission import check_mission_file
from .robot import check_robot, check_world
from .rules import check_rule_file
from .scenario import check_scenario_file, prepared, run_faults
from .xml_mission import MissionOptions, read_palettes

Checker = Callable[[Entry, Catalog], Iterable[Fault]]

EXAMPLE = ", for example, "
"""Text in a message before an example, which differs from robot to robot."""


@dataclass(frozen=True)
class Findings:
    """Result of a check.

    Attributes:
        files: Checked files.
        faults: Errors, warnings and notes, each once, sorted by file and line.
        defect: Unexpected exception in rocs_bt itself (a bug) that aborted the check of a file; None if there was none.
    """

    files: tuple[Path, ...]
    faults: tuple[Fault, ...]
    defect: BaseException | None = None

    @property
    def has_errors(self) -> bool:
        """Whether any content cannot run."""
        return any(not fault.warning for fault in self.faults)

    @property
    def has_warnings(self) -> bool:
        """Whether any content runs but is probably a mistake; notes do not count."""
        return bool(self.warnings)

    @property
    def warnings(self) -> tuple[Fault, ...]:
        """Faults with which content runs but is probably a mistake; without notes."""
        return tuple(fault for fault in self.faults if fault.warning and not fault.note)

    def refuse(self) -> None:
        """Raise the errors.

        Raises:
            InputError: There are errors; contains all of them.
        """
        if self.defect is not None:
            raise self.defect
        if errors := [fault for fault in self.faults if not fault.warning]:
            raise InputError(*errors)


def check_content(
    paths: Sequence[Path] = (),
    *,
    code: bool = True,
    dialect: str = "",
    palettes: Sequence[Path] = (),
    stub_unknown: bool = False,
    texts: Mapping[Path, str] = MappingProxyType({}),
) -> Findings:
    """Check files and folders.

    Args:
        paths: Files and folders; by default the project that contains the current folder.
        code: Whether missions may be loaded; if False, Python content is only parsed.
        dialect: Dialect of missions in XML, one of `dialects`; by default that of the scenarios, or as
            recognised.
        palettes: Files with a TreeNodesModel of nodes that missions in XML use but that are not implemented here.
        stub_unknown: Whether unknown nodes and trees of missions in XML are warnings, one for each name.
        texts: Texts of an editor by file, which are checked instead of those on disk.

    Raises:
        InputError: A palette cannot be read, or declares no node.
    """
    with unsaved(texts), read_once():
        return _check_content(paths, code, MissionOptions(dialect, stub_unknown=stub_unknown), palettes)


def _check_content(
    paths: Sequence[Path],
    code: bool,
    options: MissionOptions,
    palettes: Sequence[Path],
) -> Findings:
    """Check files and folders; see `check_content`."""
    models = read_palettes(palettes)
    faults: list[Fault] = []
    entries: list[tuple[Entry, Catalog]] = []
    catalogs: dict[Path | None, Catalog] = {}
    for path in paths or (_default(),):
        try:
            entries += _entries(path.resolve(), code, catalogs)
        except InputError as error:
            faults += error.faults
    together = survey([e.path for e, _ in entries if e.kind == "mission" and e.path.suffix in TREES])
    scenarios = frozenset(e.path for e, _ in entries if e.kind == "scenario")
    models = {**together.models, **models}
    options = replace(options, models=models, palettes=bool(palettes), together=together, scenarios=scenarios)
    checkers: dict[str, Checker] = {**_CHECKERS, "mission": partial(check_mission_file, options=options)}
    found = _findings(_with_robots(entries), faults, checkers)
    return replace(found, files=tuple(dict.fromkeys(entry.path for entry, _ in entries)))


def check_scenario(scenario: ScenarioSpec | str, catalog: Catalog) -> Findings:
    """Check a scenario and the robots that it uses, as for a run, which refuses what has errors here.

    Args:
        scenario: Scenario, or its name, or its file.
        catalog: Source of the content.

    Raises:
        InputError: The scenario does not exist.
    """
    if isinstance(scenario, str):
        entry, robots = catalog.find("scenario", scenario), _robots(catalog, scenario)
        entries = [(found, catalog) for found in (entry, *_entries_of(robots, catalog))]
        with read_once():
            return _findings(entries, [], _CHECKERS)
    with closing(Run(scenario, catalog)) as run:
        return check_run(run)


def check_run(run: Run) -> Findings:
    """Prepare a run, and check its scenario and the robots that it uses.

    Raises:
        Exception: A function that the program gave to the run raised it.
    """
    catalog = run.catalog
    entries = [(found, catalog) for found in (catalog.entry_of(run.spec), *_entries_of(run.spec.robots, catalog))]
    with read_once():
        faults = prepared(run)
        judge: Checker = lambda entry, catalog: run_faults(run, faults)  # noqa: E731 - keeps narrowed types
        return _findings(entries, [], {**_CHECKERS, "scenario": judge, "robot": partial(check_robot, run=run)})


def _findings(
    entries: Sequence[tuple[Entry, Catalog]],
    faults: list[Fault],
    checkers: Mapping[str, Checker],
) -> Findings:
    """Check entries; `faults` are those already found."""
    defect: BaseException | None = None
    for entry, catalog in entries:
        found, ended = _faults(entry, catalog, checkers)
        faults += found
        defect = defect or ended
    ordered = sorted(dict.fromkeys(faults), key=lambda f: (str(f.file or ""), f.line, f.column))
    return Findings(tuple(dict.fromkeys(e.path for e, _ in entries)), tuple(_once(ordered)), defect)


def _with_robots(entries: Sequence[tuple[Entry, Catalog]]) -> list[tuple[Entry, Catalog]]:
    """The entries, and those of the robots that their scenarios use."""
    found = {entry.path: (entry, catalog) for entry, catalog in entries}
    for entry, catalog in entries:
        for robot in _entries_of(_robots(catalog, str(entry.path)) if entry.kind == "scenario" else (), catalog):
            found.setdefault(robot.path, (robot, catalog))
    return list(found.values())


def _robots(catalog: Catalog, scenario: str) -> tuple[str, ...]:
    """Names of the robots of a scenario; empty if it cannot be read, which its check reports."""
    try:
        return catalog.read_scenario(scenario).robots
    except InputError:
        return ()


def _entries_of(robots: Iterable[str], catalog: Catalog) -> list[Entry]:
    """Entries of the robots that exist; the check of the scenario reports the others."""
    found = []
    for name in robots:
        with suppress(InputError):
            found.append(catalog.find("robot", name))
    return list(dict.fromkeys(found))


def _once(faults: Iterable[Fault]) -> list[Fault]:
    """Remove faults that say less than another at their position, or the same with another example."""
    found, seen = one_for_each_signal(faults), dict[tuple[object, ...], list[str]]()
    for fault in found:
        messages = seen.setdefault((fault.file, fault.line, fault.column), [])
        if fault.message.partition(EXAMPLE)[0] not in [message.partition(EXAMPLE)[0] for message in messages]:
            messages.append(fault.message)

    def is_kept(fault: Fault) -> bool:
        messages = seen[fault.file, fault.line, fault.column]
        longer = any(message != fault.message and message.startswith(fault.message) for message in messages)
        return fault.message in messages and not longer

    return [fault for fault in found if is_kept(fault)]


def _faults(
    entry: Entry, catalog: Catalog, checkers: Mapping[str, Checker]
) -> tuple[list[Fault], BaseException | None]:
    """Check one entry; returns its faults, and the exception of rocs_bt that aborted the check, or None."""
    found: list[Fault] = []
    try:
        catalog.confine(entry)
        for fault in checkers.get(entry.kind, check_table)(entry, catalog):
            found.append(fault.at(entry.path))
    except InputError as error:
        found += error.at(entry.path).faults
    except RocsError as error:
        found.append(Fault(str(error), entry.path))
    except (Exception, SystemExit) as error:  # noqa: BLE001 - the other files are checked all the same
        if (line := content_line(error)) is not None:
            return [*found, Fault(f"this line raised {describe(error)}", line.file, line.line)], None
        message = f"checking this file raised {describe(error)}: a defect of rocs_bt."
        return [*found, Fault(message, entry.path)], error
    return found, None


def _default() -> Path:
    return find_project(Path.cwd()) or Catalog().shipped


def _entries(path: Path, code: bool, catalogs: dict[Path | None, Catalog]) -> Iterator[tuple[Entry, Catalog]]:
    """Files to check: the given file, or all missions, rule files, robots and other content in a folder."""
    project = find_project(path if path.is_dir() else path.parent)
    catalog = catalogs.setdefault(project, CachingCatalog(project, code=code))
    if path.is_dir():
        if not (files := _inside(path)):
            raise InputError(Fault("there is no content in this folder.", path, hint=_layout()))
        tested = {tested_file(file): file for file in files}
        for file in tested:
            if is_file(file):
                kind = kind_of(file)
                yield make_entry(file, kind or "mission", "project" if kind else "file"), catalog
        if orphans := [(file, tests) for file, tests in tested.items() if not is_file(file)]:
            raise InputError(*(Fault(f"there is no rule file {file} for these tests.", at) for file, at in orphans))
        catalog.list()  # raises if two files have the same name
    elif is_file(path):
        path = tested_file(path)
        kind = kind_of(path) or _kind_inside(path)
        if kind is None:
            raise InputError(Fault("unknown kind of content.", path, hint=_layout()))
        yield make_entry(path, kind, "file"), catalog
    else:
        raise InputError(Fault("there is no such file or folder.", path))


def _inside(folder: Path) -> list[Path]:
    """Files of content and rule tests: by the layout of a project, or else anywhere in the folder."""
    own = [p for pattern in (*PATTERNS, "rules/tests/*.toml") for p in sorted(folder.glob(pattern))]
    found = own or sorted(p for p in folder.rglob("*") if p.suffix in (".toml", ".py", *TREES) and _is_content(p))
    found = [p for p in found if is_file(p) and not p.name.startswith((".", "_"))]
    included = {file for project in found if project.suffix == ".btproj" for file in included_files(project)}
    return [p for p in found if p.resolve() not in included]


def _is_content(path: Path) -> bool:
    """Whether `rocs-bt check` can check a file of a folder that is not a project.

    Either its path is that of a mission, rule file, robot or other content, or it is an XML file of behaviour trees.
    """
    try:
        return kind_of(tested_file(path)) is not None or (path.suffix in TREES and xml_kind(path) == "mission")
    except InputError:
        return False


def _kind_inside(path: Path) -> str | None:
    """Kind of a file outside a project's folders, such as `mission`, found from what the file contains."""
    if path.suffix == ".toml":
        kind = str(read_toml(path).data.get("format", "")).partition("/")[0]
        return {"reflex": "rules"}.get(kind, kind if kind in KINDS else None)
    if path.suffix in (*TREES, ".urdf", ".sdf"):
        return xml_kind(path)
    return {".py": "node"}.get(path.suffix)


def _layout() -> str:
    return f"Paths of content: {', '.join([*PATTERNS, 'rules/tests/*.toml'])}."


def check_planner_file(entry: Entry, catalog: Catalog) -> Iterable[Fault]:
    """Check a planner; its parameters are checked only if Python content may run."""
    planner = catalog.load_planner(str(entry.path))
    if not catalog.code and catalog.find("mission", planner.mission).path.suffix == ".py":
        return
    try:
        mission_values(catalog.load_mission(planner.mission, planner.nodes), planner)
    except InputError as error:
        yield from error.faults


def check_python(entry: Entry, catalog: Catalog) -> Iterable[Fault]:
    """Check that a Python file parses, defines a class or a function, and has no leaf that would block."""
    if not classes_in(entry.path) and not functions_in(entry.path):
        yield Fault("the file defines no class and no function.", entry.path, warning=True)
    yield from blocking_faults(read_text(entry.path), entry.path)


def _check_loaded(load: Callable[[Catalog, Entry], object], entry: Entry, catalog: Catalog) -> Iterable[Fault]:
    """Check that the classes of a Python file load; with `--no-code` only that it is Python."""
    yield from check_python(entry, catalog)
    if catalog.code:
        try:
            load(catalog, entry)
        except InputError as error:
            yield from error.faults


def _load_family(catalog: Catalog, entry: Entry) -> None:
    fields_of(catalog.load_family(entry))


def check_schema_file(entry: Entry, catalog: Catalog) -> Iterable[Fault]:
    """Check a schema file together with all other schema files, but return only this file's faults."""
    others = [other.path for other in catalog.list("schema") if other.path.resolve() != entry.path.resolve()]
    try:
        load_schema([*others, entry.path], SCHEMA)
    except InputError as error:
        return [fault for fault in error.faults if fault.file == entry.path]
    return ()


def check_table(entry: Entry, catalog: Catalog) -> Iterable[Fault]:
    """Check a file of which the declared class says everything."""
    read_root(KINDS[entry.kind].cls, read_toml(entry.path))
    return ()


_LEADING = re.compile(r"<\?.*?\?>|<!--.*?-->|<!DOCTYPE[^>\[]*(?:\[.*?\]\s*)?>", re.DOTALL)
_ROOT = re.compile(r"<([A-Za-z_][\w.:\-]*)")
_TREES = re.compile(r"BTCPP_format|main_tree_to_execute|<(?:BehaviorTree|TreeNodesModel|TreeNodeModel|include)\b")
_READ = 1_000_000
"""Maximum number of bytes read to determine the kind of a file."""

_CHECKABLE = "Behaviour trees (<root BTCPP_format=...>) and MJCF models (<mujoco>) can be checked."
_OTHER = {
    "robot": "a URDF model. MuJoCo's compile tool turns it into MJCF.",
    "sdf": "an SDF model of Gazebo.",
    "launch": "a ROS launch file.",
    "package": "a ROS package manifest.",
    "svg": "a picture.",
}


def xml_kind(file: Path) -> str:
    """Kind of content in an XML file: `mission` for behaviour trees, `world` for MJCF.

    Raises:
        InputError: The file contains neither, or cannot be read.
    """
    try:
        text = read_bytes(file, MOST_TEXT)[:_READ].decode("utf-8", errors="replace")
    except OSError as error:
        raise InputError(Fault(f"cannot read the file: {error.strerror}.", file)) from error
    found = _ROOT.search(_LEADING.sub(lambda m: re.sub(r"[^\n]", " ", m[0]), text))
    if found is None:
        raise InputError(Fault("the file contains no XML element.", file, 1, hint=_CHECKABLE))
    root = found[1]
    if root == "mujoco":
        return "world"
    if root == "BehaviorTree" or (root == "root" and _TREES.search(text)):
        return "mission"
    what = "neither trees nor models of nodes" if root == "root" else _OTHER.get(root, "an unknown format.")
    message = f"the file begins with <{root}>, which is {what}" if root != "root" else f"its <root> contains {what}."
    line, column = text.count("\n", 0, found.start()) + 1, found.start() - text.rfind("\n", 0, found.start())
    raise InputError(Fault(message, file, line, column, hint=_CHECKABLE))


_CHECKERS: Mapping[str, Checker] = {
    "robot": check_robot,
    "rules": check_rule_file,
    "mission": check_mission_file,
    "scenario": check_scenario_file,
    "world": check_world,
    "schema": check_schema_file,
    "route": partial(_check_loaded, lambda catalog, entry: catalog.load_route(str(entry.path))),
    "node": partial(_check_loaded, lambda catalog, entry: catalog.load_nodes(classes_in(entry.path))),
    "family": partial(_check_loaded, _load_family),
    "planner": check_planner_file,
}
