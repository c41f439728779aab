"""What can go wrong, as types.

RocsError
├── InputError              what a person wrote is wrong (exit 2); carries one or more Faults
│   ├── UnitError           a quantity has no unit, an unknown one, or the wrong dimension
│   ├── UnknownName         a name that nothing answers to; lists what exists
│   ├── RateError           rates that do not divide, or are not positive
│   └── WiringError         blocks connected in a way the architecture does not allow
├── KnowledgeError          a write or a query that the schema refuses
├── PipelineError           an action used against its contract (submitted twice, yielded by no macro ...)
├── DeviceError             a sensor or an actuator that refuses or is broken
│   └── ActuatorError       an actuator's driver raised; its agent is stopped
├── BlockError              a block raised, ended or hung; keeps block and cause
├── RecordingError          a recording that cannot be read, or does not fit
└── RecordedException       an exception of content, raised again in a replay (raised.py)

Every message says what was asked, what was found, what exists and what to do.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path


@dataclass(frozen=True)
class Fault:
    """One thing that is wrong in what a person wrote.

    Attributes:
        message: What was asked and what was found, in one sentence.
        file: The file at fault, if there is one.
        line: 1-based line, 0 when unknown.
        column: 1-based column, 0 when unknown.
        hint: What to do; empty when the message says it all.
        warning: True when the content still runs.
        note: True when nothing is known to be wrong, such as where a check could not decide; a note is a warning, too.
    """

    message: str
    file: Path | None = None
    line: int = 0
    column: int = 0
    hint: str = ""
    warning: bool = False
    note: bool = False

    def at(self, file: Path | None, line: int = 0, column: int = 0) -> Fault:
        """The same fault with a place, kept where it already has one."""
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
    """The root of everything this package raises on purpose."""


class InputError(RocsError):
    """What a person wrote is wrong; `faults` holds every fault that was found, not only the first."""

    def __init__(self, *faults: Fault | str) -> None:
        self.faults: tuple[Fault, ...] = tuple(Fault(f) if isinstance(f, str) else f for f in faults)
        super().__init__("\n".join(str(f) for f in self.faults))

    def at(self, file: Path | None, line: int = 0, column: int = 0) -> InputError:
        """The same error with a place on each fault that has none."""
        return type(self)(*(f.at(file, line, column) for f in self.faults))


class UnitError(InputError):
    """A quantity without a unit, with an unknown one, or of the wrong dimension."""


class UnknownName(InputError):
    """A name that nothing answers to."""


class RateError(InputError):
    """A rate that is not positive, or does not divide the one above it."""


class WiringError(InputError):
    """Blocks connected in a way that the architecture does not allow (paper, 5.1)."""


class KnowledgeError(RocsError):
    """A write or a query that the knowledge schema refuses."""


class PipelineError(RocsError):
    """An action used against its contract."""


class DeviceError(RocsError):
    """A sensor or an actuator that refuses, or is broken."""


class ActuatorError(DeviceError):
    """The driver of an actuator raised. No command is known to have reached the device, so its agent is stopped.

    Attributes:
        kind: `raised`; or `ended` or `hung`, of the process of an isolated actuator.
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
        owner: `content` if an actuator failed, whose driver belongs to the robot's content; else `engine`.
    """

    def __init__(self, block: str, kind: str, detail: str, owner: str = "engine") -> None:
        self.block = block
        self.kind = kind
        self.detail = detail
        self.owner = owner
        super().__init__(f"{'actuator' if owner == 'content' else 'block'} '{block}' {kind}: {detail}")

    def __reduce__(self) -> tuple[type[BlockError], tuple[str, str, str, str]]:
        return type(self), (self.block, self.kind, self.detail, self.owner)  # to be pickled


class RecordingError(RocsError):
    """A recording that cannot be read, or that does not fit what is asked of it."""


@contextmanager
def located_at(file: Path | None, line: int = 0) -> Iterator[None]:
    """Whoever is refused in here was refused for what stands in a file.

    Faults that have no place get this one, and what Knowledge or a Pipeline refuses becomes a fault: content decides
    the names that they are given.

    Args:
        file: The file.
        line: 1-based; 0 when unknown.

    Raises:
        InputError: Instead of any KnowledgeError or PipelineError.
    """
    try:
        yield
    except InputError as error:
        raise error.at(file, line) from error
    except (KnowledgeError, PipelineError) as error:
        raise InputError(Fault(str(error), file, line)) from error


def did_you_mean(name: str, known: Iterable[str], what: str = "It") -> str:
    """The hint of an unknown name: the closest one, then all there are.

    Args:
        name: What was asked for.
        known: What exists.
        what: The owner of the names, to begin the list with, such as `The robot`.
    """
    names = sorted(known)
    if not names:
        return f"{what} has none."
    close = difflib.get_close_matches(name, names, n=1)
    start = f"Did you mean '{close[0]}'? " if close else ""
    shown = names if len(names) <= 24 else [*names[:24], f"... {len(names) - 24} more"]
    return f"{start}{what} has: {', '.join(shown)}."


def unknown(kind: str, name: str, known: Iterable[str], owner: str = "There") -> Fault:
    """The fault of a name that does not exist: what was asked, and what there is."""
    names: Sequence[str] = sorted(known)
    hint = did_you_mean(name, names, what=owner)
    if owner == "There":
        hint = hint.replace("There has: ", "There are: ").replace("There has none.", "There are none.")
    return Fault(f"no {kind} is named '{name}'.", hint=hint)


def interrupts(error: BaseException) -> bool:
    """Whether an exception ends the program or a generator, and is not a fault of whoever raised it."""
    return isinstance(error, (KeyboardInterrupt, GeneratorExit))
