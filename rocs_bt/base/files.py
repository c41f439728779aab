"""Reading and writing of files: the only place where the engine opens a file that a user names.

Only regular files of limited size are read: a named pipe or a device could block for ever or never end. A file is
written as a whole or not at all. Libraries that open files themselves, such as SQLite, get paths that
`check_regular` has seen.
"""

from __future__ import annotations

import errno
import os
import shutil
import stat
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from io import BufferedWriter
from pathlib import Path
from typing import BinaryIO

from .errors import Fault, InputError

MOST_TEXT = 64_000_000
"""Maximum size of a text file [bytes]."""

MOST_BYTES = 1 << 32
"""Maximum size of any other file [bytes]."""

_MOST_KEPT = 1_000_000
"""Maximum size of a file of which `read_once` keeps the content [bytes]; larger ones are meshes and maps."""

_UNSAVED: ContextVar[Mapping[str, bytes]] = ContextVar("unsaved", default={})  # noqa: B039 - is never changed
_KEPT: ContextVar[dict[str, bytes] | None] = ContextVar("kept", default=None)
_NO_WAIT = getattr(os, "O_NONBLOCK", 0)  # Windows has no pipes in its file system
_SPECIAL = {
    stat.S_IFIFO: (errno.EINVAL, "it is a named pipe, not a regular file"),
    stat.S_IFSOCK: (errno.EINVAL, "it is a socket, not a regular file"),
    stat.S_IFCHR: (errno.EINVAL, "it is a device, not a regular file"),
    stat.S_IFBLK: (errno.EINVAL, "it is a device, not a regular file"),
    stat.S_IFDIR: (errno.EISDIR, "it is a folder, not a file"),
}


@contextmanager
def unsaved(texts: Mapping[Path, str]) -> Iterator[None]:
    """Context in which files have the texts of an editor; a file need not exist on disk.

    Only this thread and the functions that it calls see them. Libraries that open files themselves, such as MuJoCo and
    the import of Python modules, see the files on disk.
    """
    given = {os.path.realpath(path): text.encode() for path, text in texts.items()}
    token = _UNSAVED.set({**_UNSAVED.get(), **given})
    try:
        yield
    finally:
        _UNSAVED.reset(token)


@contextmanager
def read_once() -> Iterator[None]:
    """Context in which each file is opened once, so that checked and built content is the same if a file changes.

    Only this thread and the functions that it calls share the contents, which are forgotten at the end of the outermost
    context. The import of Python modules opens their files itself.
    """
    token = _KEPT.set({} if (kept := _KEPT.get()) is None else kept)
    try:
        yield
    finally:
        _KEPT.reset(token)


def _unsaved(path: Path | str) -> bytes | None:
    """Unsaved content of a file; None if the file has that on disk."""
    texts = _UNSAVED.get()
    return texts.get(os.path.realpath(path)) if texts else None


def check_regular(path: Path, most: int = MOST_BYTES) -> None:
    """Check that a path leads to a regular file, so that reading it ends; a path without a file passes.

    Args:
        path: File, possibly a link.
        most: Maximum size [bytes].

    Raises:
        OSError: The path leads to something else, or the file is too large.
    """
    try:
        status = path.stat()
    except FileNotFoundError:
        return
    except ValueError as error:  # a NUL in the name
        raise OSError(errno.EINVAL, "it is not a valid path", str(path)) from error
    _check(status, path, most)


def read_bytes(path: Path, most: int = MOST_BYTES) -> bytes:
    """Content of a regular file.

    Args:
        path: File to read.
        most: Maximum size [bytes].

    Raises:
        OSError: The file cannot be read, is not a regular file, or is too large.
    """
    if (content := _unsaved(path)) is not None:
        return content
    kept, key = _KEPT.get(), os.path.abspath(path)
    if kept is not None and key in kept:
        return kept[key]
    with open_regular(path, most) as file:
        try:
            content = file.read()
        except MemoryError as error:
            raise OSError(errno.ENOMEM, os.strerror(errno.ENOMEM), str(path)) from error
    if kept is not None and len(content) <= _MOST_KEPT:
        kept[key] = content
    return content


def open_regular(path: Path, most: int = MOST_BYTES) -> BinaryIO:
    """Open a regular file for reading.

    Args:
        path: File to read.
        most: Maximum size [bytes].

    Raises:
        OSError: The file cannot be read, is not a regular file, or is too large.
    """
    check_regular(path, most)
    file = open(path, "rb", opener=lambda name, flags: os.open(name, flags | _NO_WAIT))  # noqa: SIM115 - is returned open
    try:
        _check(os.fstat(file.fileno()), path, most)  # it may have been replaced
    except OSError:
        file.close()
        raise
    return file


def read_text(path: Path, most: int = MOST_TEXT, *, raw: bool = False) -> str:
    """Text of a regular file in UTF-8.

    Args:
        path: File to read.
        most: Maximum size [bytes].
        raw: Whether line ends stay as they are in the file; else each is a newline.

    Raises:
        InputError: The file cannot be read, is not a regular file, is too large, or is not UTF-8.
    """
    try:
        text = read_bytes(path, most).decode("utf-8")
    except OSError as error:
        raise InputError(Fault(f"cannot read the file: {error.strerror}.", path)) from error
    except UnicodeDecodeError as error:
        raise InputError(Fault(f"the file is not UTF-8 text: {error.reason} at byte {error.start}.", path)) from error
    return text if raw else text.replace("\r\n", "\n").replace("\r", "\n")


def is_file(path: Path) -> bool:
    """Whether a path leads to a file, that is, to something that exists and is no folder.

    Unlike `Path.is_file`, this is True for a named pipe, so that its reader refuses it, and does not raise an error if
    the name is too long.
    """
    return (os.path.exists(path) and not os.path.isdir(path)) or _unsaved(path) is not None


def same_file(path: Path, other: Path) -> bool:
    """Whether two paths lead to the same file, also one that is not saved yet."""
    return os.path.realpath(path) == os.path.realpath(other)


def create(path: Path) -> BufferedWriter:
    """Open a file to write it piece by piece; an existing file is emptied.

    Raises:
        OSError: The file cannot be written, or the path leads to something that is not a regular file.
    """
    check_regular(path)
    return open(path, "wb", opener=lambda name, flags: os.open(name, flags | _NO_WAIT, 0o666))


def write_whole(path: Path, content: str | bytes, mode: int = 0o666) -> None:
    """Write a file atomically: an existing file is replaced only when the new one is complete; its mode stays.

    Args:
        path: File to write, or a link to it; its folder must exist.
        content: Content; a text is written as UTF-8.
        mode: Mode of a new file, before the umask.

    Raises:
        OSError: The file cannot be written, as on a full disk; no partial file remains.
    """
    check_regular(path)
    target = Path(os.path.realpath(path))
    part = target.with_name(f".{target.name[:200]}.{os.getpid()}.part")
    try:
        try:
            with open(part, "wb", opener=lambda name, flags: os.open(name, flags, mode)) as file:
                file.write(content.encode("utf-8") if isinstance(content, str) else content)
            if target.exists():
                shutil.copymode(target, part)
            part.replace(target)
        except BaseException:  # remove the partial file, then raise again
            part.unlink(missing_ok=True)
            raise
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from error


def check_writable(path: Path) -> None:
    """Check that `write_whole` can write a file later, as far as this is known now; nothing is changed.

    Raises:
        OSError: The path leads to something that is not a regular file, or the folder cannot be written.
    """
    check_regular(path)
    if not os.access(path.absolute().parent, os.W_OK | os.X_OK):
        raise OSError(errno.EACCES, os.strerror(errno.EACCES), str(path))


@contextmanager
def new_folder(folder: Path) -> Iterator[None]:
    """Context that writes the content of a folder; if it fails, nothing remains.

    Raises:
        OSError: The folder exists and is not empty.
    """
    existed = folder.exists()
    if existed and any(folder.iterdir()):
        raise OSError(errno.EEXIST, os.strerror(errno.EEXIST), str(folder))
    try:
        yield
    except BaseException:  # remove what was written, then raise again
        with suppress(OSError):
            shutil.rmtree(folder)
            if existed:
                folder.mkdir()
        raise


def _check(status: os.stat_result, path: Path, most: int) -> None:
    if special := _SPECIAL.get(stat.S_IFMT(status.st_mode)):
        raise OSError(*special, str(path))
    if status.st_size > most:
        size = f"it has {status.st_size / 1e6:,.0f} MB; the maximum is {most / 1e6:,.0f} MB"
        raise OSError(errno.EFBIG, size, str(path))


def confined(named: str | Path, folder: Path, roots: Iterable[Path]) -> Path:
    """Absolute path, links resolved, of a content file's path, if inside one of the roots; it need not exist.

    Raises:
        InputError: The file is outside all roots, or the text is not a valid path.
    """
    allowed = [root.resolve() for root in roots]
    try:
        path = (folder / named).resolve()
    except (OSError, RuntimeError, ValueError) as error:  # a cycle of links, a NUL
        raise InputError(Fault(f"'{named}' is not a valid path: {error}.")) from error
    if not any(path.is_relative_to(root) for root in allowed):
        where = " and ".join(f"'{root}'" for root in dict.fromkeys(allowed))
        leads = "" if str(path) == os.path.normpath(folder.resolve() / named) else f", which leads to '{path}',"
        raise InputError(Fault(f"'{named}'{leads} is outside of {where}.", hint="Move the file into the project."))
    return path
