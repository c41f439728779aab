"""Lock of the folder in which a run writes, so that two runs do not mix their files."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from ...base.errors import Fault, InputError


class FolderLock:
    """Lock of a folder; it ends with the process, however that ends, and leaves no file.

    Args:
        folder: Folder that exists.

    Raises:
        InputError: Another run is writing in the folder.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = -1
        if sys.platform == "win32":  # no such locks
            return
        import fcntl

        self._folder = os.open(folder, os.O_RDONLY)
        try:
            fcntl.flock(self._folder, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            owner = _owner(os.fstat(self._folder).st_ino)
            self.close()
            message = f"another run is writing in '{folder}'{f', process {owner}' if owner else ''}."
            raise InputError(Fault(message, hint=f"Write for example: --out {free_folder(folder)}")) from None
        except OSError:  # a file system without locks
            self.close()

    def close(self) -> None:
        """Remove the lock; a second call does nothing."""
        if self._folder >= 0:
            os.close(self._folder)
            self._folder = -1


def writer_of(folder: Path) -> str:
    """Id of the process that writes in a folder; empty if none does, or if the system does not tell it.

    The folder is not locked for a moment to find out, because a run that begins then would be refused.
    """
    try:
        return _owner(folder.stat().st_ino)
    except OSError:
        return ""


def free_folder(folder: Path) -> Path:
    """First of `NAME-2`, `NAME-3` ... beside a folder that does not exist."""
    number = 2
    while (free := folder.with_name(f"{folder.name}-{number}")).exists():
        number += 1
    return free


def _owner(inode: int) -> str:
    """Id of the process that has locked a folder; empty if the system does not tell it."""
    try:
        lines = Path("/proc/locks").read_text("ascii").splitlines()
    except OSError:
        return ""
    # 1: FLOCK  ADVISORY  WRITE 1234 08:01:5678 0 EOF
    words = [line.split() for line in lines if "FLOCK" in line and "->" not in line]
    return next((each[4] for each in words if each[5].rpartition(":")[2] == str(inode)), "")
