"""Check of missions in XML, including files from other projects with nodes and trees that are missing here."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..actions import action_table
from ..base.errors import Fault, InputError
from ..base.files import read_bytes, same_file
from ..catalog import TREES, Catalog, Entry, kind_of
from ..declare import Field
from ..plan import Mission, mission_nodes, mission_parameters, shipped_nodes, xml_mission
from ..plan.dialects import dialect_in, recognised, tags_of
from ..trees.nodes import Node
from ..trees.xml import (
    Document,
    Model,
    Stub,
    Survey,
    add_siblings,
    outer_trees,
    read_document,
    stub_nodes,
    survey,
    times,
)


@dataclass(frozen=True)
class MissionOptions:
    """Options of a check of XML missions."""

    dialect: str = ""  # one of `dialects`; empty for that of the scenarios, or to recognise it
    # Declared by palettes and by the files checked together, by ID.
    models: Mapping[str, Model] = field(default_factory=dict)
    palettes: bool = False  # whether the user named palettes; models of the checked files are then used too
    stub_unknown: bool = False  # stubs replace undeclared nodes and trees, with a warning each
    together: Survey = field(default_factory=Survey)
    scenarios: frozenset[Path] = frozenset()  # checked together; these judge their missions themselves

    @property
    def given(self) -> bool:
        """Whether the user chose a dialect, palettes or stubs, for files that need not run here."""
        return bool(self.dialect) or self.palettes or self.stub_unknown


def read_palettes(files: Iterable[Path]) -> dict[str, Model]:
    """Read the node models of palettes, by ID.

    Raises:
        InputError: A file cannot be read, or declares no node.
    """
    models: dict[str, Model] = {}
    for file in files:
        document = read_document(file)
        if not document.models:
            hint = "Give a file with a <TreeNodesModel>, such as Groot's palette or Nav2's nav2_tree_nodes.xml."
            raise InputError(Fault("the palette declares no node.", file, hint=hint))
        models.update(document.models)
    return models


def check_xml(
    file: Path,
    catalog: Catalog,
    options: MissionOptions,
    build_faults: Callable[[Any, dict[str, Any]], Iterable[Fault]],
) -> Iterator[Fault]:
    """Check a mission in XML.

    `build_faults` builds with 1, True and empty texts for required parameters, which no check judges.
    """
    within, foreign = catalog.root_of(file), kind_of(file) != "mission"
    beside = options.together.trees if foreign else catalog.tree_files()
    document = read_document(file, within=within)
    add_siblings(document, beside)
    if not document.trees:
        yield from document.faults
        if not document.models:
            yield document.root.fault("the document contains no tree.", 'Write <BehaviorTree ID="Main">.')
        return
    dialect = dialect_in(document, options.dialect, catalog.defined_nodes)
    yield from recognised(file, options.dialect, dialect)
    own = list(catalog.load_nodes(tags_of(document) - set(shipped_nodes(dialect))))
    known = mission_nodes(action_table(), own, dialect)
    stubs: list[type[Node]] = []
    if options.palettes or options.stub_unknown:
        models = {**options.models, **document.models}
        stubs, warnings = stub_nodes(
            document, known, models, undeclared=options.stub_unknown, everywhere=options.together.nodes
        )
        known = known.replaced(stubs)
        yield from warnings
    missions = _Missions(document, catalog, options)
    yield from missions.warnings()
    for main in document.entries() if foreign else [""]:
        build = xml_mission(
            file,
            main=main,
            within=within,
            nodes=lambda tags: own,
            missions=missions.find,
            beside=beside,
            dialect=dialect,
            stubs=stubs,
            inputs=missions.inputs(document.main(main).name),
        )
        given = placeholders(mission_parameters(build))
        yield from build_faults(catalog.with_content(build, dialect), given)


def placeholders(parameters: Mapping[str, Field], names: bool = False) -> dict[str, Any]:
    """Values of required parameters with which a tree can be built: 1, True, and empty texts or names."""
    required = {name: each.hint for name, each in parameters.items() if each.required}
    return {n: hint(1) if hint in (bool, int, float) else n if names else "" for n, hint in required.items()}


class _Missions:
    """Trees that a document references and that are defined in other files."""

    def __init__(self, document: Document, catalog: Catalog, options: MissionOptions) -> None:
        self.catalog = catalog
        self.document, self.file = document, document.root.source.file
        own = kind_of(self.file) == "mission" if self.file else False  # then other missions of the project may use it
        self.uses = {**(survey(catalog.tree_files().values()).subtrees if own else {}), **options.together.subtrees}
        missing = [name for name in sorted(outer_trees(document)) if not self.catalog.is_python_mission(name)]
        self.stubbed = missing if options.stub_unknown else []

    def find(self, name: str) -> Callable[..., Any] | None:
        """Function `build` of a tree; None if it does not exist."""
        return _stub if name in self.stubbed else self.catalog.python_tree(name)

    def inputs(self, name: str) -> set[str]:
        """Keys that other checked files give a tree of this document, where they use it as a subtree."""
        others = [use for use in self.uses.get(name, ()) if use.source.file != self.file]
        given = {key for use in others for key in use.attributes if key.isidentifier() and key[0] != "_"}
        return given - {"ID", "name"}

    def warnings(self) -> Iterator[Fault]:
        """Yield a warning for each missing tree, in the file that references it first."""
        for name in self.stubbed:
            own = [e for e in self.document.elements() if e.tag == "SubTree" and e.attributes.get("ID") == name]
            uses = self.uses.get(name) or own
            if name not in self.uses or uses[0].source.file == self.file:
                message = f"no tree is named '{name}' in the checked files; a stub replaces it{times(uses)}."
                hint = "Check the file that contains it together with this one, or <include> it."
                yield uses[0].fault(message, hint, attribute="ID", warning=True)


def _stub(mission: Mission) -> Stub:
    return Stub("a tree that is not here")


def declared_dialect(mission: Entry, catalog: Catalog) -> str:
    """Dialect that a scenario or planner declares for a mission that it uses; empty if none does.

    Files without the mission's name are not read.
    """
    name = mission.name.encode()
    entries = [e for kind in ("scenario", "planner") for e in catalog.list(kind) if name in read_bytes(e.path)]
    for entry in entries if mission.path.suffix in TREES else ():
        try:
            path = str(entry.path)
            scenario = entry.kind == "scenario"
            users = catalog.load_scenario(path).agents if scenario else [catalog.load_planner(path)]
        except InputError:
            continue  # reported where the scenario or the planner is checked
        for agent in users:
            if agent.nodes and same_file(catalog.find("mission", agent.mission).path, mission.path):
                return agent.nodes
    return ""
