"""Exceptions of rocs_bt.

RocsError
├── InputError              invalid user input (exit 2); carries one or more Faults
│   ├── UnitError           quantity without unit, with an unknown unit, or of the wrong dimension
│   ├── UnknownName         name that does not exist; lists the existing ones
│   ├── RateError           rates that do not divide, or are not positive
│   └── WiringError         blocks connected in a way the architecture does not allow
├── KnowledgeError          write or query refused by the schema
├── PipelineError           action used against its contract (submitted twice, not yielded by its macro ...)
├── DeviceError             failure of a sensor or an actuator
│   └── ActuatorError       an actuator's driver raised; its agent is stopped
├── BlockError              a block raised, ended or hung; keeps block and cause
├── RecordingError          recording that cannot be read, or does not fit
└── RecordedException       exception of content, raised again in a replay (raised.py)

Every message contains what was expected, what was found, what exists and what to do.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path


@dataclass(frozen=True)
class Fault:
    """Fault in user input: an error, a warning or a note.

    Attributes:
        message: One sentence: what was expected and what was found.
        file: File with the fault; None if unknown.
        line: Line of the fault, 1-based; 0 if unknown.
        column: Column of the fault, 1-based; 0 if unknown.
        hint: Text that says how to correct the fault; empty if the message suffices.
        warning: Whether it is a warning or a note, so that the content can still be run.
        note: Whether it is a note: nothing is known to be wrong, such as after an undecided check.
    """

    message: str
    file: Path | None = None
    line: int = 0
    column: int = 0
    hint: str = ""
    warning: bool = False
    note: bool = False

    def at(self, file: Path | None, line: int = 0, column: int = 0) -> Fault:
        """Copy of the fault with a position; a fault that already has a file is returned unchanged."""
        if self.file is not None:
            return self
        return replace(self, file=file, line=self.line or line, column=self.column or column)

    def __str__(self) -> str:
        where = ""
        if self.file is not None:
            where = str(self.file)
            if self.line:
                where += f":{self.line}"
                if self.column:
                    where += f":{self.column}"
            where += ": "
        hint = f" {self.hint}" if self.hint else ""
        weight = "note: " if self.note else "warning: " if self.warning else ""
        return f"{where}{weight}{self.message}{hint}"


class RocsError(Exception):
    """Base class of all exceptions that rocs_bt raises deliberately."""


class InputError(RocsError):
    """Exception about invalid user input; `faults` contains all faults that were found, not only the first."""

    def __init__(self, *faults: Fault | str) -> None:
        self.faults: tuple[Fault, ...] = tuple(Fault(f) if isinstance(f, str) else f for f in faults)
        super().__init__("\n".join(str(f) for f in self.faults))

    def at(self, file: Path | None, line: int = 0, column: int = 0) -> InputError:
        """Copy of the error in which each fault without a file gets this position."""
        return type(self)(*(f.at(file, line, column) for f in self.faults))


class UnitError(InputError):
    """Raised for a quantity without a unit, with an unknown unit, or of a wrong dimension."""


class UnknownName(InputError):
    """Raised for a name that does not exist; the message lists the existing names."""


class RateError(InputError):
    """Raised for a rate that is not positive, or that does not divide the next higher rate."""


class WiringError(InputError):
    """Raised if blocks are connected in a way that the architecture does not allow (paper, 5.1)."""


class KnowledgeError(RocsError):
    """Raised if the schema of Knowledge refuses a write or a query."""


class PipelineError(RocsError):
    """Raised if an action is used against its contract, such as submitted twice."""


class DeviceError(RocsError):
    """Raised if a sensor or an actuator fails or refuses a request."""


class ActuatorError(DeviceError):
    """Raised if the driver of an actuator raises an exception or its process fails.

    Whether the device received the command is then unknown, so the agent is stopped.

    Attributes:
        kind: `raised` for an exception; `ended` or `hung` for the process of an isolated actuator.
    """

    def __init__(self, message: str, kind: str = "raised") -> None:
        self.kind = kind
        super().__init__(message)


class BlockError(RocsError):
    """Raised if a block of an agent or an actuator has failed: it raised an exception, ended, or hung.

    Attributes:
        block: Name of the block or actuator, such as `R2/monitor sonar` or `R2/wheels`.
        kind: `raised`, `ended` or `hung`.
        detail: Reason of the failure.
        owner: Owner of the failed code: `content` for an actuator (its driver belongs to the robot); else `engine`.
    """

    def __init__(self, block: str, kind: str, detail: str, owner: str = "engine") -> None:
        self.block = block
        self.kind = kind
        self.detail = detail
        self.owner = owner
        super().__init__(f"{'actuator' if owner == 'content' else 'block'} '{block}' {kind}: {detail}")

    def __reduce__(self) -> tuple[type[BlockError], tuple[str, str, str, str]]:
        return type(self), (self.block, self.kind, self.detail, self.owner)  # for pickle


class RecordingError(RocsError):
    """Raised if a recording cannot be read or written, or lacks what an operation needs."""


@contextmanager
def located_at(file: Path | None, line: int = 0) -> Iterator[None]:
    """Context that gives errors raised in it the position of a line (0 if unknown) in a content file.

    Faults without a file get this position. A KnowledgeError or PipelineError becomes an InputError, because a name in
    content caused it.

    Raises:
        InputError: The body raised an InputError, a KnowledgeError or a PipelineError.
    """
    try:
        yield
    except InputError as error:
        raise error.at(file, line) from error
    except (KnowledgeError, PipelineError) as error:
        raise InputError(Fault(str(error), file, line)) from error


@contextmanager
def collected(faults: list[Fault] | None) -> Iterator[None]:
    """Context that adds the faults of an InputError raised in it to a list; without a list, the error passes."""
    try:
        yield
    except InputError as error:
        if faults is None:
            raise
        faults += error.faults


class NameHint(str):
    """Hint about an unknown name, for a text; an editor shows less of it, and offers the names."""

    brief: str  # without the list of names; empty if no name is close
    close: str  # closest name; empty if there is none
    names: tuple[str, ...]

    def __new__(cls, text: str, brief: str = "", close: str = "", names: tuple[str, ...] = ()) -> NameHint:
        hint = super().__new__(cls, text)
        hint.brief, hint.close, hint.names = brief, close, names
        return hint

    def and_also(self, text: str) -> NameHint:
        """The hint with another sentence."""
        return NameHint(f"{self} {text}".strip(), f"{self.brief} {text}".strip(), self.close, self.names)


def did_you_mean(name: str, known: Iterable[str], what: str = "It") -> NameHint:
    """Hint about an unknown name: the closest existing name, then all existing names.

    Args:
        name: Unknown name.
        known: Existing names.
        what: Owner of the names, such as `The robot`, with which the list begins; or its beginning, which ends in `:`.
    """
    names = sorted(known)
    if not names:
        return NameHint("There are none." if what.endswith(":") else f"{what} has none.")
    close = difflib.get_close_matches(name, names, n=1)
    brief = f"Did you mean '{close[0]}'?" if close else ""
    near = difflib.get_close_matches(name, names, n=6, cutoff=0.4) or names[:24]
    shown = names if len(names) <= 24 else [*near, f"... {len(names) - len(near)} more"]
    listed = f"{what if what.endswith(':') else f'{what} has:'} {', '.join(shown)}."
    return NameHint(f"{brief} {listed}".lstrip(), brief, "".join(close), tuple(names))


def unknown(kind: str, name: str, known: Iterable[str], owner: str = "There are:", then: str = "") -> Fault:
    """Create a fault about a name that does not exist, with the existing names in the hint."""
    return Fault(f"no {kind} is named '{name}'.", hint=did_you_mean(name, known, owner).and_also(then))


def interrupts(error: BaseException) -> bool:
    """Whether an exception only interrupts the program or a generator, so that it is no fault of any code."""
    return isinstance(error, (KeyboardInterrupt, GeneratorExit))
