"""The page as one self-contained HTML file, with all of its modules, style and data."""

from __future__ import annotations

import base64
import hashlib
import html
import re
import zlib
from pathlib import Path
from string import Template

from ..base.files import read_text

WEB = Path(__file__).parent / "web"
_IMPORT = re.compile(r'^import (\{[^}]*\}) from "\./(.+?)";\n', re.MULTILINE)
_EXPORT = re.compile(r"^export (?:const|class) (\w+)", re.MULTILINE)


def render_page(title: str, data: bytes, second: bytes = b"") -> str:
    """The page of a run that is over; it works offline, from a file, and loads nothing.

    Another packed run, `second`, is shown over the first unless it is empty.
    """
    program, start, style = bundle("app.js"), read_text(WEB / "start.js"), read_text(WEB / "studio.css")
    policy = (
        f"default-src 'none'; script-src '{_digest(start)}' '{_digest(program)}'; style-src '{_digest(style)}'; "
        "img-src data:; base-uri 'none'; form-action 'none'"
    )
    texts = {name: zlib.compress(text.encode(), 9) for name, text in (("style", style), ("program", program))}
    parts = {"data": data, "second": second, **texts}
    scripts = [
        f'<script type="application/octet-stream" id="{name}">{base64.b64encode(part).decode()}</script>'
        for name, part in parts.items()
        if part
    ]
    head = f'<meta http-equiv="Content-Security-Policy" content="{policy}">'
    return _page(title, head, "app", "Loading the run …", "\n".join([*scripts, f"<script>{start}</script>"]))


#: Pages that a server has: title, styles, module, main element, and the text until the module has its data.
SERVED = {
    "run": ("rocs_bt live", ("studio",), "app", "app", "Waiting for the run …"),
    "home": ("rocs_bt studio", ("studio", "home"), "home", "home", "Loading the project …"),
    "edit": ("rocs_bt editor", ("studio", "edit"), "edit", "editor", "Loading the file …"),
}


def served_page(name: str) -> str:
    """A page of a server, of `SERVED`; the browser asks for its modules and styles by their names."""
    title, styles, module, main, waiting = SERVED[name]
    head = "\n".join(f'<link rel="stylesheet" href="{style}.css">' for style in styles)
    return _page(title, head, main, waiting, f'<script type="module" src="{module}.js"></script>')


def _page(title: str, head: str, main: str, waiting: str, scripts: str) -> str:
    page = Template(read_text(WEB / "page.html"))
    return page.substitute(title=html.escape(title), head=head, main=main, waiting=waiting, scripts=scripts)


def bundle(entry: str) -> str:
    """A module and all modules that it imports as one script: each is a function that returns what it exports."""
    scopes: dict[str, str] = {}

    def visit(name: str) -> None:
        text = read_text(WEB / name)
        for _, imported in _IMPORT.findall(text):
            if imported not in scopes:
                visit(imported)
        text = _IMPORT.sub(lambda found: f"const {found[1]} = {_scope(found[2])};\n", text)
        exported = ", ".join(_EXPORT.findall(text))
        scopes[name] = (
            f"const {_scope(name)} = (() => {{\n{_EXPORT.sub(_declared, text)}return {{ {exported} }};\n}})();"
        )

    visit(entry)
    return "\n".join(scopes.values())


def _scope(name: str) -> str:
    return f"${name.removesuffix('.js')}"


def _declared(found: re.Match[str]) -> str:
    return found[0].removeprefix("export ")


def _digest(text: str) -> str:
    return f"sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}"
