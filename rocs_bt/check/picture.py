"""Drawings of missions: the tree for a robot, parameters and faults."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

from ..actions import action_table
from ..agent import Controller
from ..base.errors import Fault, InputError
from ..catalog import TREES, Catalog, Entry
from ..declare.write import written
from ..event import TreeNode
from ..plan import TreePlan, mission_actions, mission_parameters
from ..plan.dialects import dialect_in, elsewhere, recognised, shipped_nodes, tags_of
from ..plan.mission_check import mission_faults
from ..plan.xml_mission import mission_nodes
from ..record.pages import page_maker
from ..trees.draw import Picture, picture_of, svg, text
from ..trees.nodes import Tree
from ..trees.xml import Document, make_nodes, read_document, verify, write_tree
from .stub_agent import stub_agent
from .xml_mission import declared_dialect, placeholders

FORMATS = ("text", "svg", "html", "xml")


def draw_mission(
    catalog: Catalog,
    entry: Entry,
    robot: str,
    *,
    form: str = "text",
    main: str = "",
    stub_unknown: bool = False,
    dialect: str = "",
) -> tuple[str, Sequence[Fault]]:
    """Draw a mission's tree.

    Args:
        catalog: Catalog of missions, nodes and robots.
        entry: Entry of the mission.
        robot: Name of the robot that the tree is built for.
        form: Format: text, svg, html or xml.
        main: ID of a tree in an XML file; the main tree by default.
        dialect: Dialect of an XML file, one of `dialects`; by default the dialect in scenarios that use
            the mission, or as recognised.
        stub_unknown: Whether unknown or invalid nodes of an XML file are replaced by stubs.

    Returns:
        The drawing, and notes about the mission.

    Raises:
        InputError: The mission or the robot is invalid.
    """
    declared = dialect or declared_dialect(entry, catalog)
    document, notes = None, list[Fault]()
    if entry.path.suffix in TREES:
        document = read_document(entry.path, within=catalog.root_of(entry.path))
        dialect = dialect_in(document, declared, catalog.defined_nodes)
        notes = recognised(entry.path, declared, dialect)
    if document is not None and (stub_unknown or main):
        tree, faults = _read(document, catalog, main, stub_unknown, dialect)
        return _drawn(picture_of(tree, main or entry.name, entry.doc, faults=faults), tree, form, document), notes
    build = catalog.load_mission(str(entry.path), dialect)
    parameters = mission_parameters(build)
    given = placeholders(parameters, names=True)
    controller = Controller(
        build=build, mission=entry.name, parameters=given, actions=mission_actions(build), schema=catalog.load_schema()
    )
    plan = stub_agent(catalog.load_robot(robot), catalog.load_class, controller).plan
    shown = {n: "(required)" if p.required else str(written(p, p.default)) for n, p in parameters.items()}
    if not isinstance(plan, TreePlan):
        lines = [f"{entry.name}: {entry.doc}", *(f"  {name} = {value}" for name, value in shown.items())]
        return "\n".join([*lines, f"planned by {type(plan).__name__}, which has no tree."]), notes
    picture = picture_of(plan.tree, entry.name, entry.doc, shown, mission_faults(plan.tree, plan.knowledge))
    return _drawn(picture, plan.tree, form, document), notes


def _read(document: Document, catalog: Catalog, main: str, lenient: bool, dialect: str) -> tuple[Tree, Sequence[Fault]]:
    """Build a tree without a robot; if lenient, with stubs for unknown nodes."""
    own = catalog.load_nodes(tags_of(document) - set(shipped_nodes(dialect))) if catalog.code else ()
    nodes = mission_nodes(action_table(), own, dialect)
    faults = [*document.faults, *verify(document, nodes, main=main, elsewhere=elsewhere())]
    if not lenient and (wrong := [fault for fault in faults if not fault.warning]):
        raise InputError(*wrong)
    root = make_nodes(document, nodes, main=main, lenient=lenient)
    return Tree(root, faults=faults if lenient else None), faults


def _drawn(picture: Picture, tree: Tree, form: str, document: Document | None) -> str:
    if form == "xml":
        own = document is not None and picture.title not in document.trees
        return write_tree(tree.root, main="" if own else picture.title, document=document)
    return _page(picture) if form == "html" else {"text": text, "svg": svg}[form](picture)


def _page(picture: Picture) -> str:
    parameters = ", ".join(f"{name} = {value}" for name, value in picture.parameters.items())
    doc = f"{picture.doc} ({parameters})" if parameters else picture.doc
    page: str = page_maker("tree")(picture.title, doc, tuple(_nodes(picture)), picture.faults)
    return page


def _nodes(picture: Picture) -> Iterator[TreeNode]:
    """Nodes for the page; of siblings with the same name, the second ends in `#2`."""
    waiting = [(picture.root, picture.root.title)]
    while waiting:
        card, path = waiting.pop()
        names, below = Counter[str](), []
        for child in card.children:
            names[child.title] += 1
            number = f"#{names[child.title]}" if names[child.title] > 1 else ""
            below.append((child, f"{path}/{child.title}{number}"))
        ports = ", ".join(f'{line.name}="{line.value}"' for line in card.lines)
        yield TreeNode(path=path, type=card.tag or card.title, children=tuple(p for _, p in below), ports=f"({ports})")
        waiting += reversed(below)
