"""Sphinx configuration of the manual: `make docs` builds it from the pages of this folder and the docstrings."""

from __future__ import annotations

import functools
import importlib
import inspect
import os
import re
import sys
from pathlib import Path
from typing import Any

import rocs_bt
from rocs_bt.base.version import __version__

project = "rocs_bt"
author = "The rocs_bt authors"
version = release = __version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_click"]
source_suffix = {".md": "markdown"}
nitpicky = False

html_theme = "furo"
html_title = f"rocs_bt {version}"
html_static_path: list[str] = []
html_show_sourcelink = False
html_copy_source = False
html_use_index = False  # 0.4 MB of names; the search finds them

myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 4

add_module_names = False
autodoc_typehints = "signature"
autodoc_member_order = "bysource"
autodoc_inherit_docstrings = False  # an override without a docstring is described by its base
autodoc_preserve_defaults = True  # as written: a value's repr may have an address or a path of this machine
autodoc_default_options = {"members": True, "show-inheritance": True}
suppress_warnings = ["ref.python"]  # a type by its short name may be of several modules
default_role = "code"  # docstrings write names in single backticks
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_ivar = True  # otherwise an attribute of a dataclass would be described twice
napoleon_use_rtype = False
python_maximum_signature_line_length = 100

ROOT = Path(__file__).resolve().parent.parent
FOLDERS = ("planners", "rules", "robots", "scenarios", "examples")  # the README.md of each is the page content/<folder>
_MODULE = re.compile(r"^\.\. automodule:: (?P<name>[\w.]+)$", re.MULTILINE)
_SECTION = re.compile(r"(Args|Attributes|Returns|Yields|Raises|Example|Examples|Note|Notes):$")
_LINK = re.compile(r"\[(?P<text>[^\]]*)\]\((?P<path>[^)\s#:]+)(?P<anchor>#[^)\s]*)?\)")


def _read(app: Any, name: str, source: list[str]) -> None:
    """Take the page of a content folder from its README.md, and resolve links at files outside of this folder."""
    page = Path(app.srcdir, name)
    if name == "reference/api":
        source[0] = source[0].replace("<!-- names -->", _names())
    if page.parent.name == "content":
        page = ROOT / page.name / "README.md"
        source[0] = page.read_text("utf-8")

    def link(match: re.Match[str]) -> str:
        target = Path(os.path.normpath(page.parent / match["path"]))
        folder = target.relative_to(ROOT).as_posix().removesuffix("/README.md")
        if folder in FOLDERS:
            return f"[{match['text']}](/content/{folder}.md{match['anchor'] or ''})"
        if target.is_relative_to(app.srcdir):
            return f"[{match['text']}](/{target.relative_to(app.srcdir).as_posix()}{match['anchor'] or ''})"
        if target.is_file():
            text = match["text"].replace("`", "")
            return f"{{download}}`{text} </{os.path.relpath(target, app.srcdir)}>`"
        return match["text"]

    source[0] = _MODULE.sub(_described, _LINK.sub(link, source[0]))


def _described(match: re.Match[str]) -> str:
    """The automodule of a package without the names that a subpackage describes on one of its own."""
    name = match["name"]
    exported = getattr(importlib.import_module(name), "__all__", ())
    below = [m for m in _documented() if m.startswith(f"{name}.")]
    elsewhere = {n: m for m in below for n in getattr(importlib.import_module(m), "__all__", ()) if n in exported}
    if not elsewhere:
        return match[0]
    links = ", ".join(f":py:obj:`{n} <{m}.{n}>`" for n, m in sorted(elsewhere.items()))
    return f"{match[0]}\n   :exclude-members: {', '.join(sorted(elsewhere))}\n\nAlso exported: {links}."


@functools.cache
def _documented() -> list[str]:
    """The modules that the pages of reference/ document."""
    pages = [p.read_text("utf-8") for p in sorted(Path(__file__).parent.glob("reference/*.md"))]
    return [match["name"] for page in pages for match in _MODULE.finditer(page)]


def _names() -> str:
    """A table of the names of `rocs_bt`, each with a link to its description and the first line of its docstring."""
    rows = ["| name | meaning |", "|---|---|"]
    for name in rocs_bt.__all__:
        value = getattr(rocs_bt, name)
        homes = [m for m in _documented() if getattr(sys.modules.get(m), name, None) is value]
        annotation = getattr(value, "__metadata__", ())  # of the values of a parameter
        line = (inspect.getdoc(value) or "").partition("\n")[0]
        line = f"Parameter: {', '.join(map(str, annotation))}." if annotation else line
        target = f"{homes[0] if homes else 'rocs_bt'}.{name}"
        rows.append(f"| {{py:obj}}`{name} <{target}>` | {line} |")
    return "\n".join(rows)


def _docstring(app: Any, what: str, name: str, value: Any, options: Any, lines: list[str]) -> None:
    """Make a docstring reStructuredText: indented paragraphs are code; `*` and `|` outside of backticks are plain."""
    text: list[str] = []
    in_code = in_section = False
    for i, line in enumerate(lines):
        in_section = in_section or bool(_SECTION.match(line))
        starts = line.startswith("    ") and (i == 0 or not lines[i - 1].strip()) and not in_section
        if starts and not in_code:
            text += ["::", ""]
            in_code = True
        elif line.strip() and not line.startswith("    ") and in_code:
            text += [""] if text[-1] else []
            in_code = False
        text.append(line if in_code else "".join(_plain(part) for part in re.split(r"(`[^`]*`)", line)))
    lines[:] = text


def _plain(text: str) -> str:
    return text if text.startswith("`") else re.sub(r"[*|]|(?<=\w)_(?!\w)", r"\\\g<0>", text)


def _skip(app: Any, what: str, name: str, value: Any, skip: bool, options: Any) -> bool | None:
    """Leave out classes and functions of other packages."""
    foreign = not str(getattr(value, "__module__", "rocs_bt")).startswith("rocs_bt")
    return True if foreign and (inspect.isclass(value) or inspect.isroutine(value)) else None


def setup(app: Any) -> None:
    """Register the hooks."""
    app.connect("source-read", _read)
    app.connect("autodoc-skip-member", _skip)
    app.connect("autodoc-process-docstring", _docstring, priority=400)  # before napoleon
