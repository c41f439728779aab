"""Make the pictures of the gallery: `python docs/gallery.py [NAME ...]`, all thirteen by default.

The commands of docs/gallery.md are run in build/gallery, and the pictures that they leave are copied to docs/gallery.
Finished runs in build/gallery are kept; delete the folder after a change of behaviour.
"""

from __future__ import annotations

import contextlib
import re
import shlex
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from PIL import Image

from rocs_bt.cli.main import call

DOCS = Path(__file__).resolve().parent
PAGE = DOCS / "gallery.md"
_PICTURE = re.compile(
    r"!\[[^\]]+\]\(gallery/(?P<name>[\w-]+)\.(?P<form>png|svg)\)\n\n(?P<caption>[^\n]+)\n\n```console\n(?P<commands>[^`]+)```"
)
_COLOURS = 48
_SOURCES = {  # file that the last command of a picture writes
    "exp1-seeds": "runs/overlay/arena.png",
    "exp1-activation": "runs/exp1-1/figures/activation.png",
    "exp1-wheels": "runs/exp1-1/figures/commands.png",
    "exp1-rules": "runs/exp1-1/rules/avoid_collision-R2.png",
    "exp2-arena": "runs/exp2-1/figures/arena.png",
    "exp3-arena": "runs/exp3-1/figures/arena.png",
    "exp3-knowledge": "knowledge.svg",
    "dock-arena": "runs/dock-1/figures/arena.png",
    "inspect-arena": "runs/inspect-1/figures/arena.png",
    "patrol-height": "runs/patrol_rough-1/figures/height.png",
    "team-arena": "runs/team-1/figures/arena.png",
    "barn-arena": "runs/barn_like-17-1/figures/arena.png",
    "comparison": "comparison.html",
}


@dataclass(frozen=True)
class Picture:
    """A picture of the gallery.

    Attributes:
        name: Stem of the file in docs/gallery.
        form: `png` or `svg`.
        caption: Sentence below the picture.
        commands: Commands that make it, without the prompt.
    """

    name: str
    form: str
    caption: str
    commands: tuple[str, ...]


def pictures() -> list[Picture]:
    """Read the pictures from the page."""
    found = _PICTURE.finditer(PAGE.read_text("utf-8"))
    return [Picture(p["name"], p["form"], p["caption"], tuple(p["commands"].splitlines())) for p in found]


def make(picture: Picture, work: Path, target: Path) -> Path:
    """Run the commands of a picture and copy the picture.

    Args:
        picture: Picture to make.
        work: Folder in which the commands are run; its finished runs are kept.
        target: Folder of the picture.

    Returns:
        Path of the picture.
    """
    work.mkdir(parents=True, exist_ok=True)
    target.mkdir(parents=True, exist_ok=True)
    with contextlib.chdir(work):
        for command in picture.commands:
            program, *arguments = shlex.split(command.removeprefix("$ "))
            if program != "rocs-bt":
                raise ValueError(f"{picture.name}: not a command of rocs-bt: {command}")
            if not _is_finished(arguments):
                call(arguments)
    source, path = work / _SOURCES[picture.name], target / f"{picture.name}.{picture.form}"
    if picture.form == "png":
        Image.open(source).convert("RGB").quantize(_COLOURS, dither=Image.Dither.NONE).save(path, optimize=True)
    else:
        path.write_text(_as_image(source.read_text("utf-8")), "utf-8", newline="\n")
    return path


def _is_finished(arguments: Sequence[str]) -> bool:
    """Whether a command is a run, or generates a scene, with an existing result."""
    if arguments[0] == "scene":
        return Path("scenarios", f"{arguments[1]}-{arguments[2]}.toml").is_file()
    seed = arguments[arguments.index("--seed") + 1] if "--seed" in arguments else "1"
    return arguments[0] == "run" and Path("runs", f"{arguments[1]}-{seed}", "summary.json").is_file()


def _as_image(text: str) -> str:
    """An SVG file on white; of an HTML page, its first drawing of paths in a scene, in the light colours."""
    if not text.startswith("<svg"):
        colours = dict(reversed(re.findall(r"(--[\w-]+): (#\w+);", text)))
        start = text.index("<svg", text.index('id="figure-disagreement-0"'))
        text = text[start : text.index("</svg>", start)] + "</svg>\n"
        text = re.sub(r"var\((--[\w-]+)\)", lambda match: colours[match[1]], text)
        text = text.replace("*{", "svg { background: #ffffff; font-family: sans-serif } *{", 1)
    text = re.sub(r"@media \(prefers-color-scheme: dark\) \{.*?\} \}\n", "", text, flags=re.DOTALL)
    return text.replace(".knowledge {", ".knowledge { background: #ffffff;", 1)


if __name__ == "__main__":
    for made in pictures():
        if not sys.argv[1:] or made.name in sys.argv[1:]:
            make(made, DOCS.parent / "build" / "gallery", DOCS / "gallery")
