"""`rocs-bt knowledge query`: questions to what an agent knew."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..errors import InputError, KnowledgeError
from ..geometry import Pose2
from .knowledge_files import agent_option, at_option, open_log, run_number_option, state_of
from .terminal import echo

if TYPE_CHECKING:
    from ..knowledge import Answers


@click.command()
@click.argument("run", metavar="RUN", type=click.Path(path_type=Path))
@click.argument("text", metavar="QUERY")
@agent_option
@run_number_option
@at_option
@click.option("--json", "as_json", is_flag=True, help="Print the answers as JSON.")
def query(run: Path, text: str, agent: str | None, run_number: int | None, t: float | None, as_json: bool) -> int:
    """Put a QUERY to what an agent knew, such as "object where moves and distance(pose, robot) < 2 m".

    RUN is a run's folder, its run.mcap, a file that `run --knowledge` wrote, or an export. Of a recorded run, `robot`
    is where the robot was, and the query may name its signals. The language is told in docs/knowledge.md.

    Exits with 0 when there is an answer, with 1 when there is none.
    """
    from ..knowledge import Asker, compile_query
    from ..record import Recording
    from ..record.knowledge import recorded_asker

    log = open_log(run, agent, run_number)
    t = log.end if t is None else t
    asker, signals = Asker(log.agent, None, t, past=log), None
    if (recorded := run / "run.mcap" if run.is_dir() else run).suffix == ".mcap" and recorded.exists():
        asker, signals = recorded_asker(Recording.open(recorded), log, t)
    state = state_of(log, t)
    try:
        answers = compile_query(text, state.schema, signals).ask(state, asker)
    except InputError as error:
        raise error.at(Path("query"), 1) from error
    except KnowledgeError as error:
        raise InputError(str(error)) from error
    echo(json.dumps([_plain(each) for each in answers.dicts]) if as_json else _table(answers))
    return 0 if answers else 1


def _table(answers: Answers) -> str:
    """The answers in columns."""
    if not answers:
        return "nothing answers."
    if not answers.things and not answers.columns:
        return "yes."
    heads = [*answers.things, *answers.columns]
    values = answers.values or ((),) * len(answers)
    rows = [[*names, *map(_shown, given)] for names, given in zip(answers.rows, values, strict=True)]
    widths = [max(map(len, column)) for column in zip(heads, *rows, strict=True)]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in [heads, *rows]]
    return "\n".join(line.rstrip() for line in lines)


def _shown(value: Any) -> str:
    if value is None:
        return "-"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, tuple):
        return f"({', '.join(_shown(each) for each in value)})"
    return str(value)


def _plain(answer: dict[str, Any]) -> dict[str, Any]:
    return {name: [*value] if isinstance(value, (Pose2, tuple)) else value for name, value in answer.items()}
