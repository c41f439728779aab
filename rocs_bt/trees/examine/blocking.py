"""Check for blocking calls in the methods of leaves; it parses the source text and does not run it."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

from ...base.errors import Fault

METHODS = ("initialise", "update", "terminate", "tick_once", "halted")
"""Names of the methods that a tick calls."""

_CALLS = (
    "time.sleep",
    "input",
    "os.system",
    "os.wait",
    "select.select",
    "socket.create_connection",
    "subprocess.run",
    "subprocess.call",
    "subprocess.check_call",
    "subprocess.check_output",
    "urllib.request.urlopen",
    "asyncio.run",
)
_MODULES = ("requests", "httpx")
_WAITS = ("accept", "acquire", "communicate", "recv", "recvfrom", "wait")
_HINT = "Start it in initialise, check in update whether it has ended, and return RUNNING until then."


def blocking_faults(text: str, file: Path) -> Iterator[Fault]:
    """Warnings about blocking calls and endless loops in a Python file, in the methods that a tick calls.

    Args:
        text: Python source text of the file.
        file: Path of the file, for the warnings.
    """
    module = ast.parse(text)
    names = dict(_imported(module))
    for cls in (n for n in module.body if isinstance(n, ast.ClassDef)):
        for method in (n for n in cls.body if isinstance(n, ast.FunctionDef) and n.name in METHODS):
            for node in ast.walk(method):
                called = _blocking(node, names)
                if called:
                    message = f"{cls.name}.{method.name} {called}, which blocks the robot's plan."
                    line, column = getattr(node, "lineno", 0), getattr(node, "col_offset", 0) + 1
                    yield Fault(message, file, line, column, hint=_HINT, warning=True)


def _imported(module: ast.Module) -> Iterator[tuple[str, str]]:
    """Pairs of an imported name and its full name, such as `sleep` and `time.sleep` for `from time import sleep`."""
    for node in ast.walk(module):
        if isinstance(node, ast.Import):
            yield from ((a.asname or a.name, a.name) for a in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield from ((a.asname or a.name, f"{node.module}.{a.name}") for a in node.names)


def _blocking(node: ast.AST, names: dict[str, str]) -> str:
    if isinstance(node, ast.While) and isinstance(node.test, ast.Constant) and node.test.value:
        ends = any(isinstance(n, (ast.Break, ast.Return, ast.Raise)) for n in ast.walk(node))
        return "" if ends else "contains an endless loop"
    if not isinstance(node, ast.Call):
        return ""
    name = _dotted(node.func, names)
    if name in _CALLS or name.partition(".")[0] in _MODULES:
        return f"calls {name}"
    waits = isinstance(node.func, ast.Attribute) and node.func.attr in _WAITS
    # A call with an argument is not reported: the argument is most likely a timeout of 0, or the method is unrelated.
    return f"calls {ast.unparse(node.func)}" if waits and not node.args and not node.keywords else ""


def _dotted(node: ast.expr, names: dict[str, str]) -> str:
    parts: list[str] = []
    while isinstance(node, ast.Attribute):
        parts.append(node.attr)
        node = node.value
    if not isinstance(node, ast.Name):
        return ""
    return ".".join([names.get(node.id, node.id), *reversed(parts)])
