"""A named pipe in place of a file is refused by every reader; none waits for content that never comes."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from rocs_bt import Recording
from rocs_bt.document import read_toml
from rocs_bt.errors import RocsError
from rocs_bt.python_content import classes_in
from rocs_bt.trees.xml.document import read_text


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes here")
@pytest.mark.parametrize("read", [read_toml, read_text, classes_in, Recording.open])
def test_a_pipe_is_refused(read: Callable[[Path], object], tmp_path: Path) -> None:
    path = tmp_path / "pipe"
    os.mkfifo(path)
    with pytest.raises(RocsError, match="it is not a regular file"):
        read(path)
