"""Missions as pictures: their tree on a robot, their parameters, and what a check finds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..action import Parameter
from ..actions import action_table
from ..agent import Controller
from ..catalog import Catalog, Entry
from ..errors import Fault, InputError
from ..plan import TreePlan, mission_actions, mission_parameters
from ..plan.check import mission_faults
from ..plan.nav2 import ELSEWHERE
from ..plan.xml_mission import mission_nodes, shipped_nodes, tags_of
from ..record.page import render_page
from ..trees.draw import Picture, picture_of, svg, text
from ..trees.nodes import Tree
from ..trees.xml import Document, make_nodes, read_document, verify, write_tree
from ..units import NONE
from .paper import paper_agent
from .xml_mission import dialect_of

FORMATS = ("text", "svg", "html", "xml")


def draw_mission(
    catalog: Catalog,
    entry: Entry,
    robot: str,
    *,
    form: str = "text",
    main: str = "",
    stub_unknown: bool = False,
    dialect: str | None = None,
) -> str:
    """A mission's tree, drawn.

    Args:
        catalog: Where missions, nodes and robots are found.
        entry: The mission.
        robot: The robot that the tree is built for.
        form: text, svg, html or xml.
        main: Which tree of an XML file; its main tree by default.
        dialect: Dialect of an XML file: `nav2`, or empty for ours; that of the scenarios that play it by default.
        stub_unknown: Whether stand-ins take the place of nodes of an XML file that are not ours, or wrong.

    Raises:
        InputError: The mission, or the robot, is wrong.
    """
    dialect = dialect_of(entry, catalog) if dialect is None else dialect
    if entry.path.suffix == ".xml" and (stub_unknown or main):
        document = read_document(entry.path, within=catalog.root_of(entry.path))
        tree, faults = _read(document, catalog, main, stub_unknown, dialect)
        return _drawn(picture_of(tree, main or entry.name, entry.doc, faults=faults), tree, form, document)
    build = catalog.load_mission(str(entry.path), dialect)
    declared = mission_parameters(build)
    given = {name: _any_value(p) for name, p in declared.items() if p.required}
    mind = Controller(
        build=build, mission=entry.name, parameters=given, actions=mission_actions(build), schema=catalog.load_schema()
    )
    plan = paper_agent(catalog.load_robot(robot), catalog.load_class, mind).plan
    shown = {name: _shown(p) for name, p in declared.items()}
    if not isinstance(plan, TreePlan):
        lines = [f"{entry.name}: {entry.doc}", *(f"  {name} = {value}" for name, value in shown.items())]
        return "\n".join([*lines, f"planned by {type(plan).__name__}, which is no tree."])
    read = read_document(entry.path, within=catalog.root_of(entry.path)) if entry.path.suffix == ".xml" else None
    picture = picture_of(plan.tree, entry.name, entry.doc, shown, mission_faults(plan.tree, plan.knowledge))
    return _drawn(picture, plan.tree, form, read)


def _read(document: Document, catalog: Catalog, main: str, lenient: bool, dialect: str) -> tuple[Tree, Sequence[Fault]]:
    """A tree without a robot, with stand-ins for what is not here."""
    own = catalog.load_nodes(tags_of(document) - set(shipped_nodes(dialect))) if catalog.code else ()
    nodes = mission_nodes(action_table(), own, dialect)
    faults = [*document.faults, *verify(document, nodes, main=main, elsewhere=ELSEWHERE)]
    if not lenient and (wrong := [fault for fault in faults if not fault.warning]):
        raise InputError(*wrong)
    root = make_nodes(document, nodes, main=main, lenient=lenient)
    return Tree(root, faults=faults if lenient else None), faults


def _drawn(picture: Picture, tree: Tree, form: str, document: Document | None) -> str:
    if form == "xml":
        own = document is not None and picture.title not in document.trees
        return write_tree(tree.root, main="" if own else picture.title, document=document)
    return {"text": text, "svg": svg, "html": _page}[form](picture)


def _page(picture: Picture) -> str:
    return render_page("tree.html", picture=picture, drawing=svg(picture), stubs=sum(c.stub for c in picture.cards))


def _any_value(parameter: Parameter) -> Any:
    """A value for a parameter that must be given, so that the tree can be drawn."""
    return parameter.name if parameter.type is str else parameter.type(1)


def _shown(parameter: Parameter) -> str:
    if parameter.required:
        return "(must be given)"
    unit = "" if parameter.dimension in (None, NONE) else f" {parameter.dimension}"
    return f"{parameter.default}{unit}"
