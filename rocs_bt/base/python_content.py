"""Loading of Python content: files become modules with stable names (docs/architecture.md).

A folder of content is a package without code of its own, so that a file can import another file of the same folder (a
sibling) by `from .sibling import Name`.
"""

from __future__ import annotations

import ast
import functools
import hashlib
import importlib
import importlib.util
import os
import re
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass
from importlib.machinery import ModuleSpec, SourceFileLoader
from pathlib import Path
from types import ModuleType
from typing import Any

from .errors import Fault, InputError, did_you_mean, unknown
from .files import check_regular, is_file, read_text
from .raised import CONTENT_PREFIX, CodeLocation, content_line, describe

_REFERENCE = re.compile(r"[^:]+\.py:[A-Za-z_]\w*")


def is_reference(name: str) -> bool:
    """Whether a name has the form `file.py:Class`."""
    return _REFERENCE.fullmatch(name) is not None


def module_name(path: Path) -> str:
    """Name of a file's module in `sys.modules`: the package of its folder, a dot, and the file's stem.

    The package is named after the folder, with a digest of the folder's path. Names are stable, so that tracebacks,
    dataclasses and pickles work. Two files never have the same name.
    """
    place = path.resolve()
    digest = hashlib.sha256(str(place.parent).encode()).hexdigest()[:12]
    # A dot would begin a submodule; no file name contains a slash.
    folder, stem = place.parent.name.replace(".", "/"), place.stem.replace(".", "/")
    return f"{CONTENT_PREFIX}{folder}_{digest}.{stem}"


def load_module(path: Path) -> ModuleType:
    """Load a Python file as a module; in each process the file is run once.

    Raises:
        InputError: The file, or a sibling that it imports, cannot be read or raises an exception; with the line.
    """
    name = module_name(path)
    package, known = name.partition(".")[0], set(sys.modules)
    if name not in known:
        if not is_file(path):
            raise InputError(Fault("this Python file cannot be read.", path, hint="There is no such file."))
        if path.resolve().suffix != ".py":
            raise InputError(Fault("this is no Python file.", path, hint="Its name must end in '.py'."))
        _outline(path)  # refuses what is no regular file, which an import would wait for
    if package not in known:
        folder = ModuleType(package, "Folder of content.")
        folder.__path__ = [str(path.resolve().parent)]
        sys.modules.setdefault(package, folder)
    try:
        with running(path):
            return importlib.import_module(name)
    except BaseException:  # whatever the file raises, no half-loaded module stays; raised again
        for each in [m for m in set(sys.modules) - known if m.startswith(f"{package}.")]:
            del sys.modules[each]
            vars(sys.modules[package]).pop(each.rpartition(".")[2], None)
        raise


class _SiblingFinder:
    """Import hook for packages of content; the modules of a package are the Python files of one folder.

    Subfolders and links are not searched, so that a file belongs to one module only.
    """

    @staticmethod
    def find_spec(name: str, folders: Sequence[str] | None = None, target: object = None) -> ModuleSpec | None:
        """Module spec of a file of content; None if the importing package is not content."""
        if not (name.startswith(CONTENT_PREFIX) and folders):
            return None
        file = Path(folders[0], f"{name.rpartition('.')[2].replace('/', '.')}.py")
        if file.is_symlink():
            raise ModuleNotFoundError(f"'{file.name}' is a link. Put the file itself into the folder.")
        siblings = [each.name for each in file.parent.glob("*.py") if is_file(each) and not each.is_symlink()]
        if file.name not in siblings:
            raise ModuleNotFoundError(str(unknown("file", file.name, siblings, "The folder")))
        check_regular(file)
        _loaded[name] = file, _state(file)
        return importlib.util.spec_from_file_location(name, file, loader=_Source(name, str(file)))


class _Source(SourceFileLoader):
    """Loader that neither reads nor writes bytecode: that of an edit within the same second would be taken for new."""

    def path_stats(self, path: Any) -> Mapping[str, Any]:
        raise OSError(f"no bytecode of {path}")


_loaded: dict[str, tuple[Path, tuple[int, ...]]] = {}  # by module: its file, and the state of the file before


def _state(file: Path) -> tuple[int, ...]:
    """What changes when a file changes; empty if there is none."""
    try:
        stat = file.stat()
    except OSError:
        return ()
    return stat.st_mtime_ns, stat.st_size, stat.st_ino


def has_changed_content() -> bool:
    """Whether a file that this process has loaded has changed since; only a new process loads it again."""
    return any(name in sys.modules and _state(file) != state for name, (file, state) in [*_loaded.items()])


sys.meta_path.insert(0, _SiblingFinder)


def with_siblings(path: Path) -> list[Path]:
    """Paths of a Python file and of the siblings that it imports, directly or indirectly; no file is run.

    Raises:
        InputError: A file cannot be read, or is not valid Python.
    """
    found, folder = [path], path.resolve().parent
    for file in found:  # the list grows in the loop
        named = [folder / f"{stem}.py" for stem in _outline(file).siblings]
        found += [each for each in named if is_file(each) and each not in (*found, path.resolve())]
    return found


def classes_in(path: Path) -> dict[str, int]:
    """Top-level classes of a Python file, with their lines; the file is not run.

    Raises:
        InputError: The file cannot be read, or is not valid Python.
    """
    return dict(_outline(path).classes)


def lacks_class(path: Path, name: str) -> Fault | None:
    """Fault of a Python file that has no class of a name, or that cannot be read; the file is not run."""
    try:
        classes = classes_in(path)
    except InputError as error:
        return error.faults[0]
    hint = did_you_mean(name, classes, f"'{path.name}'")
    return None if name in classes else Fault(f"'{path.name}' has no class '{name}'.", hint=hint)


def functions_in(path: Path) -> dict[str, int]:
    """Top-level functions of a Python file, with their lines; the file is not run.

    Raises:
        InputError: The file cannot be read, or is not valid Python.
    """
    return dict(_outline(path).functions)


def texts_in(path: Path) -> set[str]:
    """String constants in a Python file; the file is not run.

    Raises:
        InputError: The file cannot be read, or is not valid Python.
    """
    return set(_outline(path).texts)


def load_class(path: Path, name: str) -> type:
    """Load a class of a Python file.

    Raises:
        InputError: The file cannot be loaded, or has no such class; the error lists its classes.
    """
    found = getattr(load_module(path), name, None)
    if not isinstance(found, type):
        raise InputError(unknown("class", name, classes_in(path), f"'{path.name}'").at(path))
    return found


def guarded(build: Callable[..., Any], path: Path) -> Callable[..., Any]:
    """Wrap a function of a user's file so that its exceptions become faults of the file; it keeps its signature."""

    @functools.wraps(build)
    def safe(*args: Any, **kwargs: Any) -> Any:
        with running(path):
            return build(*args, **kwargs)

    return safe


@contextmanager
def running(path: Path, *owners: object, passing: type[Exception] | tuple[type[Exception], ...] = ()) -> Iterator[None]:
    """Context that converts exceptions of content, including `sys.exit`, to faults in the file, with the line.

    Args:
        path: File of the content.
        owners: Classes or functions of the file. If the engine refuses a value that one of them returned, the fault is
            at its definition.
        passing: Types of exceptions that are not converted.

    Raises:
        InputError: The content raised another exception.
    """
    try:
        yield
    except passing:
        raise
    except InputError as error:  # raised by the engine or other content; the fault is at the calling line
        place = fault_of(path, error, *owners)
        raise error.at(place.file, place.line) from error
    except (Exception, SystemExit) as error:  # content may raise anything
        raise InputError(fault_of(path, error, *owners)) from error


def running_class(cls: type, *passing: type[Exception]) -> AbstractContextManager[None]:
    """Context as `running` for a user's class, except that InputErrors pass; does nothing for a class of the engine."""
    if not cls.__module__.startswith(CONTENT_PREFIX):
        return nullcontext()
    file = sys.modules[cls.__module__].__file__ or ""
    return running(Path(file), cls, passing=(InputError, *passing))


@dataclass(frozen=True)
class _Outline:
    """What a Python file contains: siblings that it imports, top-level definitions with lines, string constants."""

    siblings: tuple[str, ...]
    classes: Mapping[str, int]
    functions: Mapping[str, int]
    texts: frozenset[str]


@functools.lru_cache(256)  # one check asks dozens of times
def _outline_of(text: str, name: str) -> _Outline:
    tree = ast.parse(text, name)
    nodes = list(ast.walk(tree))
    imports = [n for n in nodes if isinstance(n, ast.ImportFrom) and n.level == 1]
    siblings = [stem for n in imports for stem in ([n.module] if n.module else [alias.name for alias in n.names])]
    return _Outline(
        tuple(dict.fromkeys(siblings)),
        {n.name: n.lineno for n in tree.body if isinstance(n, ast.ClassDef)},
        {n.name: n.lineno for n in tree.body if isinstance(n, ast.FunctionDef)},
        frozenset(n.value for n in nodes if isinstance(n, ast.Constant) and isinstance(n.value, str)),
    )


def _outline(path: Path) -> _Outline:
    try:
        return _outline_of(read_text(path), str(path))
    except (RecursionError, MemoryError) as error:  # the parser raises either for deeply nested brackets
        raise InputError(Fault("not valid Python: nested too deeply.", path)) from error
    except (SyntaxError, ValueError) as error:
        raise InputError(fault_of(path, error)) from error


def fault_of(path: Path, error: BaseException, *owners: object) -> Fault:
    """Create a fault about an exception of content, at the innermost line of content in the traceback.

    If no line of content is in the traceback, the fault is at the definition of `owners`.
    """
    if isinstance(error, SyntaxError) and (file := _invalid(error, path)) is not None:
        return Fault(f"not valid Python: {error.msg}.", file, error.lineno or 0, error.offset or 0)
    place = content_line(error, *owners) or CodeLocation(path, 0)
    name = next((f"{owner.__name__} of" for owner in owners if isinstance(owner, type)), "running")
    return Fault(f"{name} this file raised {describe(error)}", place.file, place.line)


def _invalid(error: SyntaxError, path: Path) -> Path | None:
    """File with the invalid syntax: this file or a sibling. None if content itself parsed another text."""
    if error.filename in (None, str(path)):
        return path
    folder, file = os.path.split(str(error.filename))
    return Path(folder, file) if folder == str(path.resolve().parent) and file.endswith(".py") else None
