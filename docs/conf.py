"""Sphinx configuration of the manual: `make docs` builds it from the pages of this folder and the docstrings."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

from rocs_bt.version import __version__

project = "rocs_bt"
author = "The rocs_bt authors"
version = release = __version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_click"]
source_suffix = {".md": "markdown"}
exclude_patterns = ["README.md"]
nitpicky = False

html_theme = "furo"
html_title = f"rocs_bt {version}"
html_static_path: list[str] = []
html_show_sourcelink = False
html_copy_source = False

myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 4

autodoc_typehints = "signature"
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True, "show-inheritance": True}
napoleon_google_docstring = True
napoleon_use_rtype = False

ROOT = Path(__file__).resolve().parent.parent
FOLDERS = ("planners", "rules", "robots", "scenarios", "examples")  # whose README.md is the page content/<folder>
_LINK = re.compile(r"\[(?P<text>[^\]]*)\]\((?P<path>[^)\s#:]+)(?P<anchor>#[^)\s]*)?\)")


def _read(app: Any, name: str, source: list[str]) -> None:
    """Take the page of a content folder from its README.md, and resolve links at files outside of this folder."""
    page = Path(app.srcdir, name)
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

    source[0] = _LINK.sub(link, source[0])


def setup(app: Any) -> None:
    """Register the hook."""
    app.connect("source-read", _read)
