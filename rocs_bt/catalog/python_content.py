"""Python content: loaded by its path, under a stable module name, by nobody else (docs/architecture.md)."""

from __future__ import annotations

import ast
import functools
import hashlib
import importlib.util
import re
import sys
import traceback
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

from ..errors import Fault, InputError, unknown
from ..raised import CONTENT_PREFIX

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
        spec.loader.exec_module(module)
    except Exception as error:  # a person's own code may raise anything, and that is an input that is wrong
        del sys.modules[name]
        raise InputError(fault_of(path, error)) from error
    return module


def classes_in(path: Path) -> dict[str, int]:
    """The classes at a file's top level and the lines they stand in, without running it.

    Raises:
        InputError: The file cannot be read, or is no Python.
    """
    return {n.name: n.lineno for n in _parse(path).body if isinstance(n, ast.ClassDef)}


def functions_in(path: Path) -> dict[str, int]:
    """The functions at a file's top level and the lines they stand in, without running it.

    Raises:
        InputError: The file cannot be read, or is no Python.
    """
    return {n.name: n.lineno for n in _parse(path).body if isinstance(n, ast.FunctionDef)}


def texts_in(path: Path) -> set[str]:
    """The texts that stand in a file, without running it.

    Raises:
        InputError: The file cannot be read, or is no Python.
    """
    return {n.value for n in ast.walk(_parse(path)) if isinstance(n, ast.Constant) and isinstance(n.value, str)}


def load_class(path: Path, name: str) -> type:
    """A class of a Python file.

    Raises:
        InputError: The file does not load, or has no class of that name; lists those that it has.
    """
    found = getattr(load_module(path), name, None)
    if not isinstance(found, type):
        raise InputError(unknown("class", name, classes_in(path), f"'{path.name}'").at(path))
    return found


def guarded(build: Callable[..., Any], path: Path) -> Callable[..., Any]:
    """A person's function, with the same signature, whose exceptions are faults of its file."""

    @functools.wraps(build)
    def safe(*args: Any, **kwargs: Any) -> Any:
        try:
            return build(*args, **kwargs)
        except InputError as error:  # told by what the mission used; the mission is where it was asked for
            raise error.at(path, fault_of(path, error).line) from error
        except Exception as error:  # a person's own code may raise anything, and that is an input that is wrong
            raise InputError(fault_of(path, error)) from error

    return safe


def _parse(path: Path) -> ast.Module:
    try:
        return ast.parse(path.read_text(encoding="utf-8"), str(path))
    except OSError as error:
        raise InputError(Fault("this Python file cannot be read.", path, hint=f"{error.strerror}.")) from error
    except (SyntaxError, ValueError, RecursionError) as error:
        raise InputError(fault_of(path, error)) from error


def fault_of(path: Path, error: Exception) -> Fault:
    """The error of a person's code, at the last of its lines that had a part in it."""
    if isinstance(error, SyntaxError):
        return Fault(f"not valid Python: {error.msg}.", path, error.lineno or 0, error.offset or 0)
    lines = [f.lineno for f in traceback.extract_tb(error.__traceback__) if f.filename == str(path)]
    line = (lines[-1] or 0) if lines else 0
    return Fault(f"running this file raised {type(error).__name__}: {error}", path, line)
