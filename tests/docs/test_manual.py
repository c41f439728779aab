"""The manual: it builds without a warning, its links resolve, and it needs no network."""

from __future__ import annotations

import importlib.util
import re
import subprocess
import sys
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

import rocs_bt
from rocs_bt.cli import docs
from rocs_bt.cli.main import COMMANDS, call

from .. import needs

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
PAGES = {p.relative_to(DOCS).with_suffix("").as_posix() for p in DOCS.rglob("*.md")} - {"index"}
INTERNAL = {"cli", "declare"}
"""Packages that the API reference omits."""


@pytest.fixture(scope="module")
def site(tmp_path_factory) -> Path:
    needs.package(*needs.MANUAL)
    spec = importlib.util.spec_from_file_location("build_manual", DOCS / "build.py")
    build = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(build)
    if build.is_current(build.BUILT):
        return build.BUILT
    folder = tmp_path_factory.mktemp("site") / "manual"
    done = subprocess.run([sys.executable, DOCS / "build.py", folder, "-W"], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return folder


class Page(HTMLParser):
    """What a page links to, what it loads, and its anchors."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: list[str] = []
        self.loads: list[str] = []
        self.anchors: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        values = dict(attrs)
        self.anchors |= {values[key] for key in ("id", "name") if values.get(key)}
        if tag == "a" and values.get("href"):
            self.links.append(values["href"])
        if tag in ("script", "img", "iframe", "source", "video", "audio", "embed") and values.get("src"):
            self.loads.append(values["src"])
        if tag == "link" and values.get("href"):
            self.loads.append(values["href"])


@cache
def page_of(path: Path) -> Page:
    return Page(path.read_text("utf-8"))


def test_the_site_has_every_page(site):
    for name in (*PAGES, "index", "search"):
        assert (site / f"{name}.html").is_file(), name


def test_nothing_is_loaded_from_the_network(site):
    for path in site.rglob("*.html"):
        for target in page_of(path).loads:
            parts = urlsplit(target)
            assert parts.scheme in ("", "data"), f"{path.name} loads {target}"
            assert not parts.netloc, f"{path.name} loads {target}"
    for path in site.rglob("*.css"):
        text = path.read_text("utf-8")
        assert not re.search(r"url\(\s*['\"]?(https?:)?//|@import", text), path
    assert not [p for p in site.rglob("*") if p.suffix in (".woff", ".woff2", ".ttf", ".eot")]


def test_every_internal_link_resolves(site):
    broken = []
    for path in site.rglob("*.html"):
        if "_static" in path.parts or "_downloads" in path.parts:
            continue
        for target in (*page_of(path).links, *page_of(path).loads):
            parts = urlsplit(target)
            if parts.scheme or parts.netloc:
                continue
            file = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if not file.is_file():
                broken.append(f"{path.name}: {target}")
            elif parts.fragment and file.suffix == ".html" and unquote(parts.fragment) not in page_of(file).anchors:
                broken.append(f"{path.name}: {target} (no such anchor)")
    assert broken == []


def test_the_site_is_small(site):
    assert sum(p.stat().st_size for p in site.rglob("*") if p.is_file()) <= 10.5e6


def test_every_page_is_in_exactly_one_toctree():
    entries = []
    for path in DOCS.rglob("*.md"):
        for tree in re.findall(r"```\{toctree\}\n(.*?)```", path.read_text("utf-8"), re.DOTALL):
            folder = path.parent.relative_to(DOCS)
            entries += [(folder / line).as_posix() for line in tree.split("\n") if line and not line.startswith(":")]
    assert sorted(entries) == sorted(PAGES)


def test_every_public_package_is_in_the_reference():
    pages = [p.read_text("utf-8") for p in (DOCS / "reference").glob("*.md")]
    documented = set(re.findall(r"automodule:: rocs_bt\.([\w.]+)", "".join(pages)))
    here = Path(rocs_bt.__file__).parent
    found = {p.stem for p in here.glob("[a-z]*.py")} | {p.parent.name for p in here.glob("[a-z]*/__init__.py")}
    assert found - INTERNAL - {"testing"} <= documented
    for name in documented & {p.parent.name for p in here.glob("[a-z]*/__init__.py")}:
        below = {f"{name}.{p.parent.name}" for p in (here / name).glob("[a-z]*/__init__.py")}
        assert below <= documented


def test_the_command_line_reference_has_every_command(site):
    text = (site / "reference" / "cli.html").read_text("utf-8")
    for name in COMMANDS:
        assert f"rocs-bt-{name}" in text, name


def test_docs_opens_the_manual(monkeypatch, tmp_path, capsys):
    page = tmp_path / "rocs_bt" / "_manual" / "index.html"
    page.parent.mkdir(parents=True)
    page.write_text("")
    opened = []
    monkeypatch.setattr(docs, "_PACKAGE", tmp_path / "rocs_bt")
    monkeypatch.setattr("webbrowser.open", lambda uri: opened.append(uri) or True)
    assert call(["docs"]) == 0
    assert opened == [page.as_uri()]
    assert capsys.readouterr().out == ""
    assert call(["docs", "--path"]) == 0
    assert capsys.readouterr().out == f"{page}\n"
    assert len(opened) == 1


def test_docs_prints_the_path_where_there_is_no_browser(monkeypatch, tmp_path, capsys):
    page = tmp_path / "build" / "manual" / "index.html"
    page.parent.mkdir(parents=True)
    page.write_text("")
    monkeypatch.setattr(docs, "_PACKAGE", tmp_path / "rocs_bt")
    monkeypatch.setattr("webbrowser.open", lambda uri: False)
    assert call(["docs"]) == 0
    assert capsys.readouterr().out == f"{page}\n"


def test_docs_without_a_manual_says_how_to_get_it(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(docs, "_PACKAGE", tmp_path / "rocs_bt")
    assert call(["docs"]) == 2
    assert "Install a wheel" in capsys.readouterr().err
