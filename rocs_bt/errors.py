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
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path


@dataclass(frozen=True)
class Fault:
    """One error, warning or note about user input.

    Attributes:
        message: One sentence: what was expected and what was found.
        file: File of the fault, if any.
        line: 1-based line, 0 if unknown.
        column: 1-based column, 0 if unknown.
        hint: Correction; empty if the message suffices.
        warning: Whether the content still runs.
        note: Whether nothing is known to be wrong, such as an undecided check; a note is also a warning.
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
    """Invalid user input; `faults` contains all faults found, not only the first."""

    def __init__(self, *faults: Fault | str) -> None:
        self.faults: tuple[Fault, ...] = tuple(Fault(f) if isinstance(f, str) else f for f in faults)
        super().__init__("\n".join(str(f) for f in self.faults))

    def at(self, file: Path | None, line: int = 0, column: int = 0) -> InputError:
        """Copy of the error in which each fault without a file has this position."""
        return type(self)(*(f.at(file, line, column) for f in self.faults))


class UnitError(InputError):
    """Quantity without a unit, with an unknown unit, or of the wrong dimension."""


class UnknownName(InputError):
    """Name that does not exist."""


class RateError(InputError):
    """Rate that is not positive, or does not divide the next higher rate."""


class WiringError(InputError):
    """Blocks connected in a way that the architecture does not allow (paper, 5.1)."""


class KnowledgeError(RocsError):
    """Write or query refused by the knowledge schema."""


class PipelineError(RocsError):
    """Action used against its contract."""


class DeviceError(RocsError):
    """Failure of a sensor or an actuator, or its refusal of a request."""


class ActuatorError(DeviceError):
    """An actuator's driver raised. Whether the device received the command is unknown, so its agent is stopped.

    Attributes:
        kind: `raised`; or `ended` or `hung`, for the process of an isolated actuator.
    """

    def __init__(self, message: str, kind: str = "raised") -> None:
        self.kind = kind
        super().__init__(message)


class BlockError(RocsError):
    """A block of an agent, or an actuator, raised, ended or hung.

    Attributes:
        block: Name of the block or actuator, such as `R2/monitor sonar` or `R2/wheels`.
        kind: `raised`, `ended` or `hung`.
        detail: Reason.
        owner: `content` for an actuator, since its driver belongs to the robot's content; else `engine`.
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
    """Recording that cannot be read, or that lacks what an operation needs."""


@contextmanager
def located_at(file: Path | None, line: int = 0) -> Iterator[None]:
    """Attribute errors raised inside the context to a line of a content file.

    Faults without a file get this position. KnowledgeError and PipelineError become InputErrors, because names from
    content cause them.

    Args:
        file: Content file.
        line: 1-based line; 0 if unknown.

    Raises:
        InputError: Replaces any KnowledgeError or PipelineError.
    """
    try:
        yield
    except InputError as error:
        raise error.at(file, line) from error
    except (KnowledgeError, PipelineError) as error:
        raise InputError(Fault(str(error), file, line)) from error


def did_you_mean(name: str, known: Iterable[str], what: str = "It") -> str:
    """Hint for an unknown name: the closest name, then all names.

    Args:
        name: Unknown name.
        known: Existing names.
        what: Owner of the names, which begins the list, such as `The robot`.
    """
    names = sorted(known)
    if not names:
        return f"{what} has none."
    close = difflib.get_close_matches(name, names, n=1)
    start = f"Did you mean '{close[0]}'? " if close else ""
    shown = names if len(names) <= 24 else [*names[:24], f"... {len(names) - 24} more"]
    return f"{start}{what} has: {', '.join(shown)}."


def unknown(kind: str, name: str, known: Iterable[str], owner: str = "There") -> Fault:
    """Fault for a name that does not exist, with the existing names as hint."""
    names: Sequence[str] = sorted(known)
    hint = did_you_mean(name, names, what=owner)
    if owner == "There":
        hint = hint.replace("There has: ", "There are: ").replace("There has none.", "There are none.")
    return Fault(f"no {kind} is named '{name}'.", hint=hint)


def interrupts(error: BaseException) -> bool:
    """Whether an exception interrupts the program or a generator, and so is no fault of the code that raised it."""
    return isinstance(error, (KeyboardInterrupt, GeneratorExit))
