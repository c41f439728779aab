"""Exceptions that content raises (leaves, actions, sensors and other extensions), with name and source line."""

from __future__ import annotations

import functools
import inspect
import os
import re
import site
import sys
import sysconfig
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from traceback import walk_tb
from types import FrameType, ModuleType
from typing import Any

from .errors import ActuatorError, RocsError, did_you_mean

CONTENT_PREFIX = "rocs_bt_content_"
"""Prefix of the names of content modules, as loaded by `python_content`."""

_UNKNOWN = re.compile(r"cannot import name '(\w+)' from 'rocs_bt\b")

_MAX_LENGTH = 400
"""Maximum length of the message of an exception [characters]; longer messages are truncated."""


@dataclass(frozen=True)
class CodeLocation:
    """Location of a line of code in a file."""

    file: Path
    line: int  # 1-based

    def __str__(self) -> str:
        return f"{self.file.name}:{self.line}"


@dataclass(frozen=True)
class Raised:
    """Description of an exception that a leaf, action, sensor or other content raised.

    Attributes:
        kind: Kind of content, such as `leaf`, `action`, `sensor`.
        content: Name of the content: the path of a leaf, the class of an action, the name of a sensor.
        detail: Type and message of the exception.
        location: Line of content that raised the exception; None if no line of content was involved.
    """

    kind: str
    content: str
    detail: str
    location: CodeLocation | None = None

    @classmethod
    def of(cls, kind: str, content: str, error: BaseException, *owners: object) -> Raised:
        """Create the description of an exception."""
        if isinstance(error, RecordedException):
            return error.raised
        return cls(kind, content, describe(error), raised_at(error, *owners))

    def __str__(self) -> str:
        where = "" if self.location is None else f" ({self.location})"
        return f"{self.kind} '{self.content}' raised {self.detail}{where}"


class RecordedException(RocsError):
    """Raised in a replay in place of an exception that content raised in the recorded run."""

    def __init__(self, raised: Raised) -> None:
        self.raised = raised
        super().__init__(str(raised))


def describe(error: BaseException) -> str:
    """Type and message of an exception in one line. This never raises, even if the exception's `__str__` does."""
    if isinstance(error, SystemExit):
        return f"SystemExit({error.code!r:.40})"
    try:
        message = " ".join(str(error).split())
    except Exception:  # noqa: BLE001 - the exception's own `__str__` may raise anything
        message = "(its message cannot be read)"
    if len(message) > _MAX_LENGTH:
        message = f"{message[:_MAX_LENGTH]} ..."
    name = type(error).__name__
    return f"{name}: {message}{_hint(error)}" if message else name


def _hint(error: BaseException) -> str:
    """Remedy for an unknown attribute of a method or of an object or module of rocs_bt; else empty."""
    if isinstance(error, ImportError) and (name := _UNKNOWN.match(str(error))) and error.name in sys.modules:
        return f". {_advice(sys.modules[error.name], name[1])}"
    if not isinstance(error, AttributeError) or not error.name:
        return ""
    if isinstance(error.obj, ModuleType):
        return f". {_advice(error.obj, error.name)}" if error.obj.__name__.partition(".")[0] == "rocs_bt" else ""
    if inspect.isroutine(error.obj):
        called = f"{error.obj.__name__}()"
        return f". It must be called: write {called}.{error.name}"
    classes = [cls for cls in type(error.obj).__mro__ if cls.__module__.partition(".")[0] == "rocs_bt"]
    names = sorted({name for cls in classes for name in vars(cls) if not name.startswith("_")})
    return f". {type(error.obj).__name__} has: {', '.join(names)}" if names else ""


def _advice(module: ModuleType, name: str) -> str:
    """Advice of a module about a name that it does not have."""
    members = vars(module)
    known = members.get("__all__") or [each for each in members if not each.startswith("_")]
    return str(members.get("ADVICE", {}).get(name) or did_you_mean(name, known, module.__name__))


def raised_at(error: BaseException, *owners: object) -> CodeLocation | None:
    """Location at which content raised an exception, or caused it.

    This is the innermost frame of content in the traceback. There is none if the engine refused a value that content
    returned. Then the location is the definition of the first of `owners` that belongs to content, or else the
    innermost frame.
    """
    if (location := content_line(error, *owners)) is not None:
        return location
    frames = list(walk_tb(error.__traceback__))
    return _location(*frames[-1]) if frames else None


def content_line(error: BaseException, *owners: object) -> CodeLocation | None:
    """Location as in `raised_at`, but None if neither a frame nor an owner belongs to content."""
    for each in causes(error):
        if found := [(frame, line) for frame, line in walk_tb(each.__traceback__) if is_content(frame)]:
            return _location(*found[-1])
    for owner in owners:
        if (location := definition_of(owner)) is not None:
            return location
    return None


def called_at() -> CodeLocation | None:
    """Innermost line in the call stack that belongs to a mission or other content; None if there is none."""
    frame = inspect.currentframe()
    while frame is not None and not is_content(frame):
        frame = frame.f_back
    return None if frame is None else _location(frame, frame.f_lineno)


def waiting_at(steps: Any) -> CodeLocation | None:
    """Location of the innermost line of content at which a generator is suspended; None if there is none."""
    found = None
    while (frame := getattr(steps, "gi_frame", None)) is not None:
        found = _location(frame, frame.f_lineno) if is_content(frame) else found
        steps = getattr(steps, "gi_yieldfrom", None)
    return found


def causes(error: BaseException) -> Iterator[BaseException]:
    """An exception and its chain of explicit causes (`raise ... from ...`), outermost first."""
    seen: set[int] = set()
    each: BaseException | None = error
    while each is not None and id(each) not in seen:
        seen.add(id(each))
        yield each
        each = each.__cause__


def from_actuator(error: BaseException) -> bool:
    """Whether the driver of an actuator raised an exception, so that no other content is responsible."""
    return any(isinstance(each, ActuatorError) for each in causes(error))


def owners_of(error: BaseException) -> Iterator[Any]:
    """Objects with methods in the traceback of an exception, innermost first; those of its causes come first."""
    for each in reversed(list(causes(error))):
        for frame, _ in reversed(list(walk_tb(each.__traceback__))):
            code = frame.f_code
            if code.co_argcount and (name := code.co_varnames[0]) in frame.f_locals:
                yield frame.f_locals[name]


def is_content(frame: FrameType) -> bool:
    """Whether a frame belongs to content, and not to the engine, Python's library or an installed package."""
    return _is_content(frame.f_globals.get("__name__", ""), frame.f_code.co_filename)


@functools.lru_cache(maxsize=1024)
def _is_content(module: str, file: str) -> bool:
    return module.startswith(CONTENT_PREFIX) or not file.startswith(("<", *_installed()))


@functools.cache
def _installed() -> tuple[str, ...]:
    """Folders of the engine, Python's library and installed packages, each with a trailing separator."""
    names = ("stdlib", "platstdlib", "purelib", "platlib")
    here = Path(__file__).parents[1]
    folders = [
        str(here),
        str(here.resolve()),
        *(sysconfig.get_paths()[name] for name in names),
        *site.getsitepackages(),
    ]
    return tuple(sorted({os.path.join(folder, "") for folder in (*folders, site.getusersitepackages())}))


def definition_of(owner: object) -> CodeLocation | None:
    """Location of the definition of a function, a class, or the class of an object; None if it is not content."""
    if isinstance(owner, CodeLocation):
        return owner
    target = owner if inspect.isroutine(owner) or isinstance(owner, type) else type(owner)
    try:
        target = inspect.unwrap(target) if callable(target) else target
        file, line = inspect.getsourcefile(target), inspect.getsourcelines(target)[1]
    except (OSError, TypeError, ValueError):  # built-in, or defined at a prompt
        return None
    if file is None or not _is_content(getattr(target, "__module__", "") or "", file):
        return None
    return CodeLocation(Path(file), max(line, 1))


def _location(frame: FrameType, line: int) -> CodeLocation:
    return CodeLocation(Path(frame.f_code.co_filename), line)
