"""Python content: loaded by its path, under a stable module name, by nobody else (docs/architecture.md)."""

from __future__ import annotations

import ast
import functools
import hashlib
import importlib.util
import re
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from types import ModuleType
from typing import Any

from .errors import Fault, InputError, unknown
from .raised import CONTENT_PREFIX, CodeLocation, content_line, describe

_REFERENCE = re.compile(r"[^:]+\.py:[A-Za-z_]\w*")


def is_reference(name: str) -> bool:
    """Whether a name has the form `file.py:Class`."""
    return _REFERENCE.fullmatch(name) is not None


def module_name(path: Path) -> str:
    """The name under which a file's module stands in `sys.modules`: its stem, and a digest of its whole path.

    Stable, so that tracebacks, dataclasses and pickles hold; never the same for two files.
    """
    place = path.resolve()
    return f"{CONTENT_PREFIX}{place.stem}_{hashlib.sha256(str(place).encode()).hexdigest()[:12]}"


def load_module(path: Path) -> ModuleType:
    """The module of a Python file; run once in a process.

    Raises:
        InputError: The file cannot be read, or raises while it is run; with the line.
    """
    name = module_name(path)
    if name in sys.modules:
        return sys.modules[name]
    if not path.is_file():
        raise InputError(Fault("this Python file cannot be read.", path, hint="There is no such file."))
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise InputError(Fault("this is no Python file.", path, hint="Its name must end in '.py'."))
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        with running(path):
            spec.loader.exec_module(module)
    except InputError:
        del sys.modules[name]
        raise
    return module


def classes_in(path: Path) -> dict[str, int]:
    """Top-level classes of a file with their lines; the file is not run.

    Raises:
        InputError: The file cannot be read, or is not valid Python.
    """
    return {n.name: n.lineno for n in _parse(path).body if isinstance(n, ast.ClassDef)}


def functions_in(path: Path) -> dict[str, int]:
    """Top-level functions of a file with their lines; the file is not run.

    Raises:
        InputError: The file cannot be read, or is not valid Python.
    """
    return {n.name: n.lineno for n in _parse(path).body if isinstance(n, ast.FunctionDef)}


def texts_in(path: Path) -> set[str]:
    """String constants of a file; the file is not run.

    Raises:
        InputError: The file cannot be read, or is not valid Python.
    """
    return {n.value for n in ast.walk(_parse(path)) if isinstance(n, ast.Constant) and isinstance(n.value, str)}


def load_class(path: Path, name: str) -> type:
    """Load a class of a Python file.

    Raises:
        InputError: The file does not load, or has no such class; lists its classes.
    """
    found = getattr(load_module(path), name, None)
    if not isinstance(found, type):
        raise InputError(unknown("class", name, classes_in(path), f"'{path.name}'").at(path))
    return found


def guarded(build: Callable[..., Any], path: Path) -> Callable[..., Any]:
    """Wrap a function of content: its exceptions become faults of its file. The signature is unchanged."""

    @functools.wraps(build)
    def safe(*args: Any, **kwargs: Any) -> Any:
        with running(path):
            return build(*args, **kwargs)

    return safe


@contextmanager
def running(path: Path, *owners: object, passing: type[Exception] | tuple[type[Exception], ...] = ()) -> Iterator[None]:
    """Context that converts exceptions of content, including `sys.exit`, to faults of its file with the line.

    Args:
        path: File of the content.
        owners: Classes or functions of the file; if the engine refuses a value that they returned, the fault is at
            their definition.
        passing: Exceptions that are not converted.

    Raises:
        InputError: The content raised another exception.
    """
    try:
        yield
    except passing:
        raise
    except InputError as error:  # raised by the engine or other content; the fault is at the calling line
        raise error.at(path, fault_of(path, error, *owners).line) from error
    except (Exception, SystemExit) as error:  # content may raise anything
        raise InputError(fault_of(path, error, *owners)) from error


def running_class(cls: type, *passing: type[Exception]) -> AbstractContextManager[None]:
    """As `running` for a class of content, but InputErrors are not converted; no effect for a class of the engine."""
    if not cls.__module__.startswith(CONTENT_PREFIX):
        return nullcontext()
    file = sys.modules[cls.__module__].__file__ or ""
    return running(Path(file), cls, passing=(InputError, *passing))


def _parse(path: Path) -> ast.Module:
    try:
        return ast.parse(path.read_text(encoding="utf-8"), str(path))
    except OSError as error:
        raise InputError(Fault("this Python file cannot be read.", path, hint=f"{error.strerror}.")) from error
    except (RecursionError, MemoryError) as error:  # the parser raises either for deeply nested brackets
        raise InputError(Fault("not valid Python: nested too deeply.", path)) from error
    except (SyntaxError, ValueError) as error:
        raise InputError(fault_of(path, error)) from error


def fault_of(path: Path, error: BaseException, *owners: object) -> Fault:
    """Fault for an exception of content, at the innermost line of content.

    Args:
        path: File of the content.
        error: The exception.
        owners: Classes or functions of the file; without a line of content the fault is at their definition.
    """
    if isinstance(error, SyntaxError) and error.filename in (None, str(path)):
        return Fault(f"not valid Python: {error.msg}.", path, error.lineno or 0, error.offset or 0)
    place = content_line(error, *owners) or CodeLocation(path, 0)
    name = next((f"{owner.__name__} of" for owner in owners if isinstance(owner, type)), "running")
    return Fault(f"{name} this file raised {describe(error)}", place.file, place.line)
