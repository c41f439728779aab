"""`rocs-bt show`: draw the tree of a mission, or list a rule file."""

from __future__ import annotations

from pathlib import Path

import click

from ..catalog import Catalog
from ..dialect import DIALECTS
from ..files import write_whole
from ..units import Quantity
from ..words import inactive_rule
from .content import catalog_for, no_code_option
from .terminal import echo, own_stdout


@click.command()
@click.argument("name", metavar="MISSION|RULES")
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
@click.option("--nodes", "dialect", type=click.Choice(DIALECTS), help="XML missions: dialect of the nodes.")
@click.option("--robot", default="pioneer_p3dx", show_default=True, help="Robot that the tree is built for.")
@click.option("--compiled", is_flag=True, help="Rule files: show the generated Python code.")
@no_code_option
def command(
    name: str,
    form: str,
    out: Path | None,
    main: str,
    stub_unknown: bool,
    dialect: str | None,
    robot: str,
    compiled: bool,
    no_code: bool,
) -> None:
    """Draw the tree of a mission with its parameters, or list the rules of a rule file.

    If a mission and a rule file have the same name, the mission is shown; with --compiled, the rule file.
    """
    from ..check import draw_mission

    click.get_current_context().with_resource(own_stdout())
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
    if out is None:
        echo(drawn.rstrip("\n"))
    else:
        write_whole(out, drawn)
        echo(f"{out}: {entry.name}, as {form}.")


def _rules(catalog: Catalog, name: str, robot: str, compiled: bool) -> str:
    from ..check import fitted_rules
    from ..reactive import lower_rules, python_source

    ((_, rules),) = fitted_rules(catalog.find("rules", name), catalog, robot)
    if compiled:
        return python_source(lower_rules(rules.rules))
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
