"""Terminal output of all commands.

Names from content files, recordings and other robots may contain control characters, which a terminal obeys. `echo`
and `show_table` therefore escape everything that is not plain text. No other module prints.
"""

from __future__ import annotations

import errno
import io
import os
import re
import sys
import threading
import traceback
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, redirect_stdout, suppress
from typing import Any, TextIO

import click

from ..base.errors import Fault
from ..base.words import counted

_UNSAFE = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f"  # control characters except tab and newline
    "\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069"  # marks that reorder text
    "\u2028\u2029\ud800-\udfff]"  # other line separators; surrogates, which no stream can encode
)
_MARK = os.urandom(8).hex()  # secret, so that content cannot style text
_stdout: TextIO | None = None  # standard output of a command that has it to itself
_STYLED = re.compile(rf"\x00{_MARK}:([0-9;]*)\x00")


def safe(text: object) -> str:
    """Escape the control characters of a text as Python does; tabs and newlines stay."""
    return _UNSAFE.sub(lambda found: found[0].encode("unicode_escape").decode(), str(text).replace("\r\n", "\n"))


def styled(text: object, *, fg: str | None = None, bold: bool | None = None) -> str:
    """Mark a text to be printed by `echo` in a colour or style; may be embedded in another text."""
    codes = re.findall(r"\x1b\[([0-9;]*)m", click.style("", fg=fg, bold=bold, reset=False))
    return f"{''.join(_mark(code) for code in codes)}{text}{_mark('0')}"


def echo(text: object = "", *, err: bool = False, nl: bool = True) -> None:
    """Print a text; control characters are escaped, except the styles of `styled`."""
    parts = _STYLED.split(str(text))  # texts and style codes alternate
    for i, part in enumerate(parts):
        parts[i] = f"\x1b[{part}m" if i % 2 else safe(part)
    _write("".join(parts), err, nl)


_SHOWN = 5  # warnings before a run


def show_warnings(faults: Sequence[Fault], command: str = "rocs-bt check") -> None:
    """Print the first warnings of a check to stderr, and the command that prints all."""
    for fault in faults[:_SHOWN]:
        echo(fault, err=True)
    if (more := len(faults) - _SHOWN) > 0:
        echo(f"{counted(more, 'more warning')}: {command}", err=True)


def show_table(
    rows: Sequence[Sequence[object]],
    head: Sequence[object],
    *,
    styles: Mapping[int, str] | None = None,
    right: Sequence[int] = (),
    indent: int = 0,
    edge: int = 80,
    err: bool = False,
    **options: Any,
) -> None:
    """Print a table, at most as wide as the terminal.

    Args:
        rows: Cells by row.
        head: Names of the columns.
        styles: Styles of rows, by index.
        right: Indices of right-aligned columns; if there are any, lines of the first column are not wrapped.
        indent: Spaces before each line.
        edge: Minimum width [characters] without a terminal; COLUMNS may increase it.
        err: Whether to print to stderr.
        options: Options of `rich.table.Table`.
    """
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(**options)
    for i, name in enumerate(head):
        table.add_column(Text(safe(name)), justify="right" if i in right else "left", no_wrap=i == 0 and bool(right))
    for i, row in enumerate(rows):
        table.add_row(*(Text(safe(cell)) for cell in row), style=(styles or {}).get(i))
    terminal, text = _stream(err).isatty(), io.StringIO()
    width = max(Console().width, 80 if terminal else edge)
    Console(file=text, width=width - indent, force_terminal=terminal, highlight=False).print(table)
    for line in text.getvalue().rstrip("\n").split("\n"):
        _write(f"{' ' * indent}{line.rstrip()}", err, True)


def echo_traceback(error: BaseException) -> None:
    """Print the traceback of a defect to stderr."""
    echo("".join(traceback.format_exception(error)), err=True, nl=False)


def guard_streams() -> None:
    """Print warnings and exceptions of threads by `echo`, in the whole process."""

    def warning(
        message: Warning | str,
        category: type[Warning],
        filename: str,
        lineno: int,
        file: TextIO | None = None,
        line: str | None = None,
    ) -> None:
        echo(warnings.formatwarning(message, category, filename, lineno), err=True, nl=False)

    def thread(hook: threading.ExceptHookArgs) -> None:
        if hook.exc_value is not None and hook.exc_type is not SystemExit:
            name = hook.thread.name if hook.thread is not None else ""
            echo(f"exception in thread '{name}':", err=True)
            echo_traceback(hook.exc_value)

    warnings.showwarning = warning
    threading.excepthook = thread


@contextmanager
def own_stdout() -> Iterator[TextIO]:
    """Context that reserves standard output, which it yields, for `echo`; content prints to standard error."""
    global _stdout
    before, kept = sys.stdout, -1
    if _is_stdout(before):  # not where a caller has put another stream in its place
        before.flush()
        kept = os.dup(1)
        os.dup2(2, 1)
    _stdout = before if kept < 0 else os.fdopen(os.dup(kept), "w", encoding=before.encoding, newline="")
    try:
        with redirect_stdout(sys.stderr):
            yield _stdout
    finally:
        if kept >= 0:
            with suppress(OSError, ValueError):  # it is closed
                _stdout.close()
            os.dup2(kept, 1)
            os.close(kept)
        _stdout = None


def _is_stdout(stream: TextIO) -> bool:
    try:
        return stream.fileno() == 1
    except (OSError, ValueError, AttributeError):
        return False


@contextmanager
def discard_if_closed() -> Iterator[None]:
    """Discard output in the context, and buffered output, if the terminal was closed."""
    try:
        yield
    except OSError as error:
        if error.errno != errno.EIO:
            raise
        nowhere = os.open(os.devnull, os.O_WRONLY)
        for stream in (1, 2):
            os.dup2(nowhere, stream)
        os.close(nowhere)


def _stream(err: bool) -> TextIO:
    return sys.stderr if err else _stdout or sys.stdout


def _mark(code: str) -> str:
    return f"\x00{_MARK}:{code}\x00"


def _write(text: str, err: bool, nl: bool) -> None:
    stream = _stream(err)
    encoding = getattr(stream, "encoding", None) or "utf-8"
    shown = text.encode(encoding, "backslashreplace").decode(encoding)
    click.echo(shown, stream, nl=nl)
