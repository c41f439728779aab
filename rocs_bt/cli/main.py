"""The `rocs-bt` command: table of commands, error handling and exit codes.

Exit codes: 0, every agent succeeded; 1, an agent did not succeed; 2, invalid input; 3, defect of the engine;
128 + signal, ended by a signal.
"""

from __future__ import annotations

import importlib
import io
import signal
import sys
from collections.abc import Sequence
from typing import NoReturn

import click

from ..base.current_folder import keep_current_folder_off_path
from ..base.errors import InputError, RecordingError, RocsError
from ..base.registered import load, registered
from ..base.version import __version__
from .stop import end_by_signals
from .terminal import discard_if_closed, echo, echo_traceback, guard_streams

_GROUP = "rocs_bt.commands"

# Commands of the core with their descriptions, so that `--help` loads no command.
COMMANDS = {
    "run": "Run a scenario to its outcome and write a report.",
    "drive": "Run a scenario on its real robots, after a check of their sensors.",
    "replay": "Re-run agents on recorded sensor data, explain a moment, or evaluate rules on a ROS bag.",
    "report": "Make the summary and report of a recording, also of an incomplete one.",
    "plot": "Draw the figures of a run, or of two runs overlaid.",
    "compare": "Compare planners over many scenes and seeds, with statistical verdicts.",
    "scene": "Generate scenes of a family as scenarios, and report their difficulty.",
    "list": "List all content: robots, missions, rules, scenarios ...",
    "show": "Draw a mission as text, SVG, HTML or XML; list a rule file, or the nodes for an editor.",
    "check": "Check content files; reports all faults at once.",
    "rules": "Test rule files, replay them on recordings, tune their thresholds.",
    "knowledge": "Query, draw, export and import the knowledge of agents; make keys for sharing it.",
    "requirements": "Check requirements on the recording of a run.",
    "identify": "Measure a robot's motion by axis: speed, lag, braking, and wheel separation.",
    "new": "Create a project, or add a file to it.",
    "docs": "Open the manual in the browser, without a network.",
    "doctor": "Check the installation and optional tools on this machine.",
}


class _LazyGroup(click.Group):
    """Group that loads a command's module when the command is called."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return [*COMMANDS, *_added()]

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name in COMMANDS:
            command: click.Command = importlib.import_module(f"{__package__}.{cmd_name}").command
        elif cmd_name in _added():
            command = load(_GROUP, cmd_name)
        else:
            return None
        command.name = cmd_name  # the manual takes its headings from it
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl([*COMMANDS.items(), *((name, _description(name)) for name in _added())])


def _added() -> list[str]:
    """Commands that wings and other packages register; a name of the core stays the core's.

    A name with a dot is a part of a command: `replay.bag` of `replay`, `knowledge.keys` of the group `knowledge`.
    """
    return [name for name in registered(_GROUP) if name not in COMMANDS and "." not in name]


def _description(name: str) -> str:
    """First sentence about a registered command, or the reason why it cannot be loaded."""
    try:
        command: click.Command = load(_GROUP, name)
    except InputError as error:
        return error.faults[0].message
    return command.get_short_help_str(limit=100)


@click.group(cls=_LazyGroup, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(__version__, prog_name="rocs-bt")
def group() -> None:
    """Robots that plan with behaviour trees and react with rules, on one shared knowledge graph.

    Start with: rocs-bt run exp1. The manual: rocs-bt docs.
    """


def main() -> NoReturn:
    """Entry point of `rocs-bt`."""
    keep_current_folder_off_path()
    guard_streams()
    end_by_signals()
    sys.exit(call(sys.argv[1:]))


def call(arguments: Sequence[str]) -> int:
    """Run one command line, given the arguments after `rocs-bt`; returns the exit code."""
    try:
        # The arguments are passed as the context's object, so that a report can contain its command line.
        code = group.main(list(arguments), prog_name="rocs-bt", standalone_mode=False, obj=tuple(arguments))
        return code if isinstance(code, int) else 0
    except click.exceptions.Exit as stop:
        return int(stop.exit_code)
    except click.ClickException as error:  # errors of the command line
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
        # An unusable file is an input error; an error without a file is a defect.
        if error.filename is None:
            echo(f"the engine failed: {error.strerror or error}.", err=True)
            return 3
        echo(f"cannot use '{error.filename}': {error.strerror}. Choose another path.", err=True)
        return 2
    except Exception as error:  # noqa: BLE001 - boundary of the process: a defect must not exit with 1, as a failed run
        echo_traceback(error)
        echo("the engine failed: this is a defect of rocs_bt. Please report the lines above.", err=True)
        return 3


def _interrupted(error: BaseException | None) -> int:
    """Report an interruption; returns its exit code."""
    number = int(getattr(error, "signal", signal.SIGINT))
    with discard_if_closed():
        echo("\n".join([f"{error}" or "interrupted.", *getattr(error, "__notes__", ())]), err=True)
    return 128 + number
