"""The `rocs-bt` command: which commands there are, and what their errors become.

Exit 0: it ran, and every agent succeeded. 1: it ran, some agent did not. 2: the input is wrong. 3: the engine failed.
128 + signal: a signal ended it.
"""

from __future__ import annotations

import importlib
import io
import signal
import sys
from collections.abc import Sequence
from keyword import iskeyword
from typing import NoReturn

import click

from ..errors import InputError, RecordingError, RocsError
from ..version import __version__
from .terminal import echo, echo_traceback, guard_streams, perhaps_closed

# Each command and what it does, so that the help needs to load none of them.
COMMANDS = {
    "run": "Run a scenario to its outcome and write a report.",
    "replay": "Feed a recorded run to the same mind; or tell why something happened.",
    "report": "Make summary and report of a recording, also of one that was cut off.",
    "plot": "Draw the figures of a run, or of two runs over each other.",
    "episode": "Play one episode of a comparison again, with its recording and report.",
    "compare": "Compare planners over many scenes and seeds, and say which is better, and how sure that is.",
    "search": "Search for a scene in which a planner fails, and make it as small as can be.",
    "scene": "Make scenes of a family: ordinary scenarios, and how hard they are.",
    "import": "Make scenarios of your own copy of a benchmark: BARN, MRPB, MovingAI.",
    "list": "List robots, missions, rules, scenarios: all content there is.",
    "show": "Draw a mission as text, SVG, HTML or XML; list a rule file, or show what it compiles to.",
    "palette": "Write the nodes that missions may name, for an editor such as Groot2.",
    "check": "Check content files: all faults at once.",
    "rules": "Test, replay and tune rule files: what they do, and would have done.",
    "knowledge": "Ask and draw what agents knew in a run; export, import.",
    "share": "Make keys for robots that share what they know over a network.",
    "requirements": "Check what must hold over a run on its recording.",
    "diff": "Tell what two scenarios share, and what differs: content and code.",
    "identify": "Measure a robot's drive: track, lag, speed, braking.",
    "new": "Begin a project of your own.",
    "doctor": "Tell what works on this machine.",
}


class _LazyGroup(click.Group):
    """Loads a command's module when the command is called."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in COMMANDS:
            return None
        module = f"{cmd_name}_" if iskeyword(cmd_name) else cmd_name
        command: click.Command = importlib.import_module(f"{__package__}.{module}").command
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


@click.group(cls=_LazyGroup, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(__version__, prog_name="rocs-bt")
def group() -> None:
    """Robots that plan with behaviour trees and flinch with rules, on one shared knowledge graph.

    Begin with: rocs-bt run exp1
    """


def main() -> NoReturn:
    """The entry point."""
    guard_streams()
    sys.exit(call(sys.argv[1:]))


def call(arguments: Sequence[str]) -> int:
    """Run one command line.

    Args:
        arguments: What follows `rocs-bt`.

    Returns:
        The exit code.
    """
    try:
        # What was typed is the commands' object, so that a report can tell how it was made.
        code = group.main(list(arguments), prog_name="rocs-bt", standalone_mode=False, obj=tuple(arguments))
        return code if isinstance(code, int) else 0
    except click.exceptions.Exit as stop:
        return int(stop.exit_code)
    except click.ClickException as error:  # what click finds wrong in the command line
        shown = io.StringIO()
        error.show(shown)
        echo(shown.getvalue(), err=True, nl=False)
        return 2
    except (click.Abort, KeyboardInterrupt) as error:
        return _interrupted(error.__cause__ if isinstance(error, click.Abort) else error)
    except (InputError, RecordingError) as error:  # a recording is an input too
        echo(str(error), err=True)
        return 2
    except RocsError as error:
        echo("\n".join([f"the engine failed: {error}", *getattr(error, "__notes__", ())]), err=True)
        return 3
    except OSError as error:
        # A place that cannot be written is the person's; what has no name is ours.
        echo(f"'{error.filename}' cannot be used: {error.strerror}. Name another place.", err=True)
        return 3 if error.filename is None else 2
    except Exception as error:  # noqa: BLE001 - the process's boundary: a defect must not look like a lost run (exit 1)
        echo_traceback(error)
        echo("the engine failed: this is a defect of rocs_bt. Please report the lines above.", err=True)
        return 3


def _interrupted(error: BaseException | None) -> int:
    """Tell of an interruption; its exit code."""
    number = int(getattr(error, "signal", signal.SIGINT))
    with perhaps_closed():
        echo("\n".join([f"{error}" or "interrupted.", *getattr(error, "__notes__", ())]), err=True)
    return 128 + number
