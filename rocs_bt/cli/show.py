"""`rocs-bt show`: draw the tree of a mission, list a rule file, or write available nodes and schemas for editors."""

from __future__ import annotations

import json
from pathlib import Path

import click

from ..base.files import write_whole
from ..base.units import Quantity
from ..base.words import inactive_rule
from ..catalog import KINDS, Catalog, ContentKind
from ..interfaces.vocabulary import dialects
from .content import catalog_for, no_code_option
from .terminal import echo, own_stdout

TABLES = {
    **{kind: of for kind, of in KINDS.items() if of.table},
    "identified": ContentKind((), "rocs_bt.simulation.identified_file:IdentifiedFile"),
    "rule_tests": ContentKind((), "rocs_bt.reactive.rule_keys:RuleTestFile"),
}
"""Kinds of files with a schema."""


@click.command()
@click.argument("name", metavar="[MISSION|RULES]", required=False)
@click.option(
    "--format",
    "form",
    type=click.Choice(["text", "svg", "html", "xml"]),
    default="text",
    show_default=True,
    help="Format of a mission; xml is for Groot2.",
)
@click.option("--out", type=click.Path(path_type=Path, dir_okay=False), help="Write to this file.")
@click.option("--tree", "main", default="", metavar="ID", help="XML missions: ID of the tree to draw.")
@click.option("--stub-unknown", is_flag=True, help="XML missions: replace unknown or invalid nodes by stubs.")
@click.option("--nodes", "dialect", type=click.Choice(dialects()), help="XML missions: dialect of the nodes.")
@click.option("--robot", default="pioneer_p3dx", show_default=True, help="Robot that the tree is built for.")
@click.option("--compiled", is_flag=True, help="Rule files: show the program that they are compiled to.")
@click.option("--palette", is_flag=True, help="Write the nodes available to missions instead, for an editor.")
@click.option("--schema", type=click.Choice(sorted(TABLES)), help="Write the JSON Schema of such files instead.")
@no_code_option
def command(
    name: str | None,
    form: str,
    out: Path | None,
    main: str,
    stub_unknown: bool,
    dialect: str | None,
    robot: str,
    compiled: bool,
    palette: bool,
    schema: str | None,
    no_code: bool,
) -> None:
    """Draw the tree of a mission with its parameters, or list the rules of a rule file.

    If a mission and a rule file have the same name, the mission is shown; with --compiled, the rule file. With
    --palette, write a TreeNodesModel of all actions and nodes of rocs_bt and of the project, with ports, types and
    defaults: load it in an editor such as Groot2, or include it in a mission. With the JSON Schema of --schema, an
    editor for TOML completes and checks files.
    """
    from ..check import draw_mission

    if (name is not None) + palette + (schema is not None) != 1:
        raise click.UsageError("Name a mission or a rule file, or give --palette or --schema.")
    click.get_current_context().with_resource(own_stdout())
    if schema is not None:
        _write(_schema(schema), out, f"schema of {schema} files")
        return
    if name is None:
        text = _palette(dialect or "rocs", code=not no_code)
        _write(text, out, f"{text.count(' ID=')} nodes")
        return
    catalog = catalog_for(name, no_code=no_code)
    rules = compiled or name.endswith(".toml") or name not in {e.name for e in catalog.list("mission")}
    if rules and (name.endswith(".toml") or compiled or name in {e.name for e in catalog.list("rules")}):
        echo(_rules(catalog, name, robot, compiled))
        return
    entry = catalog.find("mission", name)
    drawn, notes = draw_mission(
        catalog,
        entry,
        robot,
        form=form,
        main=main,
        stub_unknown=stub_unknown,
        dialect=dialect or "",
    )
    for note in notes:
        echo(str(note), err=True)
    _write(drawn, out, f"{entry.name}, as {form}")


def _write(text: str, out: Path | None, what: str) -> None:
    if out is None:
        echo(text.rstrip("\n"))
    else:
        write_whole(out, text)
        echo(f"{out}: {what}.")


def _schema(kind: str) -> str:
    from ..declare import json_schema

    return json.dumps(json_schema(TABLES[kind].cls, kind), indent=2, allow_nan=False)


def _palette(dialect: str, *, code: bool) -> str:
    """Model of all nodes of a dialect and of the project."""
    from ..actions import action_table
    from ..plan import mission_nodes, shipped_nodes
    from ..trees.xml import palette

    shipped = shipped_nodes(dialect)
    own = [node for node in Catalog.here().load_nodes() if node.tag not in shipped] if code else []
    return palette(mission_nodes(action_table(), own, dialect).values())


def _rules(catalog: Catalog, name: str, robot: str, compiled: bool) -> str:
    from ..check import fitted_rules
    from ..reactive import lower_rules

    ((_, rules),) = fitted_rules(catalog.find("rules", name), catalog, robot)
    if compiled:
        return "\n".join(lower_rules(rules.rules).listing())
    lines = [rules.doc] if rules.doc else []
    lines += [f"{name} = {Quantity(value, rules.dimensions[name])}" for name, value in rules.thresholds.items()]
    for rule in sorted(rules.rules, key=lambda r: -r.priority):
        lines.append(f"{rule.priority:>8}  {rule.name.rpartition('/')[2]}: {rule.doc}".rstrip(": "))
        lines.append(f"          when {rule.when.text}")
        lines += [f"          until {rule.until.text}"] if rule.until is not None else []
        kept = f", keeps {', '.join(rule.keep)}" if rule.keep else ""
        lines.append(f"          {rule.action}, {'level' if rule.level else 'edge'}{kept}")
    lines += [inactive_rule(rule.name, [robot], rule.missing) for rule in rules.inactive]
    return "\n".join(lines)
