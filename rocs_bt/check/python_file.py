"""Python content: it parses; nothing of it is run here."""

from __future__ import annotations

from collections.abc import Iterable

from ..catalog import Catalog, Entry, classes_in, functions_in
from ..errors import Fault
from ..trees.examine import blocking_faults


def check_python(entry: Entry, catalog: Catalog) -> Iterable[Fault]:
    """That a Python file is Python, has something that content can name, and has no leaf that would block."""
    if not classes_in(entry.path) and not functions_in(entry.path):
        yield Fault("the file has no class and no function, so nothing can name it.", entry.path, warning=True)
    yield from blocking_faults(entry.path.read_text(encoding="utf-8"), entry.path)
