"""Pages of docs/: their code is that of the examples, their topics are those of the recorder."""

import ast
import itertools
import re
import textwrap
import tomllib
from pathlib import Path

import click
import pytest

from rocs_bt.cli.main import group
from rocs_bt.event import BodyMoved
from rocs_bt.plan import Mission
from rocs_bt.plan.context import MissionContext
from rocs_bt.record import WORLD_EVENTS
from rocs_bt.record.file import codec

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
EXAMPLES = [p.read_text("utf-8") for p in (ROOT / "examples").glob("t*.py")]


def squeezed(text):
    return re.sub(r"\s+", " ", text)


@pytest.mark.parametrize("page", ["bring-your-own-body.md", "extending.md", "put-it-on-your-robot.md", "recording.md"])
def test_its_code_is_taken_from_the_examples(page):
    text = (DOCS / page).read_text("utf-8")
    text = re.sub(r"Save as `[^`]+`:\n\n```\w+\n.*?```", "", text, flags=re.DOTALL)  # files, which other tests run
    blocks = re.findall(r"```(?:python|toml)\n(.*?)```", text, re.DOTALL)
    assert blocks
    whole = [squeezed(e) for e in EXAMPLES]
    for block in blocks:
        if page != "recording.md":
            assert any(squeezed(textwrap.dedent(block)).strip() in e for e in whole), block
        else:  # single lines, in their order
            lines = [line.strip() for line in block.splitlines()]
            assert any(all(line in e for line in lines) for e in EXAMPLES), block


def test_every_extension_point_has_a_section_with_code():
    text = (DOCS / "extending.md").read_text("utf-8")
    for point in (
        "Sensor",
        "Actuator",
        "Action",
        "Monitor",
        "Analyze",
        "Plan",
        "ReactiveModel",
        "WorldModel",
        "RobotModel",
        "StrategyModel",
    ):
        (section,) = re.findall(rf"^### {point}\n(.*?)(?=^##|\Z)", text, re.MULTILINE | re.DOTALL)
        assert "```python" in section


def test_every_method_of_a_mission_in_the_pages_exists():
    pages = [*DOCS.glob("*.md"), *ROOT.glob("*/README.md"), ROOT / "README.md"]
    named = {name for page in pages for name in re.findall(r"\bmission\.(\w+)\(", page.read_text("utf-8"))}
    assert {"act", "enter"} <= named
    assert {
        name for name in named if not hasattr(Mission, name) and f" {name}: " not in MissionContext.__doc__
    } == set()


def test_every_topic_is_documented_and_no_other():
    text = (DOCS / "recording.md").read_text("utf-8")
    told = re.findall(r"^\| `/AGENT/(\w+)` \| (\w+) \|", text, re.MULTILINE)
    assert sorted(told) == sorted((codec.topic_of(k, "R2").removeprefix("/R2/"), k.__name__) for k in codec.KINDS)


def test_the_events_that_a_replay_leaves_out_are_named():
    text = (DOCS / "recording.md").read_text("utf-8")
    (named,) = re.findall(r"The simulator's own events \((.*?)\) are left out", squeezed(text))
    assert re.findall(r"`(\w+)`", named) == [k.__name__ for k in WORLD_EVENTS]
    assert BodyMoved in WORLD_EVENTS


def test_every_page_is_in_the_index_and_there_are_few_and_short_ones():
    index = (DOCS / "index.md").read_text("utf-8")
    lines = {p.name: p.read_text("utf-8").count("\n") for p in DOCS.glob("*.md") if p.name != "index.md"}
    assert lines.keys() <= set(re.findall(r"\]\(([\w-]+\.md)\)", index))
    assert len(lines) <= 28, "merge pages that tell one task"
    assert {name: n for name, n in lines.items() if n > 400} == {}, "cut what another page says"


def test_the_listed_folders_are_those_that_exist():
    text = (DOCS / "architecture.md").read_text("utf-8")
    listing = re.search(r"## Folders and layers\n\n```text\n(.*?)```", text, re.DOTALL).group(1)
    named = set(re.findall(r"\b(\w+)/", listing)) - {"planners", "rules", "robots", "scenarios", "rocs_bt"}
    folders = {p.name for p in (ROOT / "rocs_bt").iterdir() if (p / "__init__.py").is_file()}
    assert named == folders
    modules = {p.stem for p in (ROOT / "rocs_bt").glob("*.py")} - {"__init__"}
    assert {w for w in re.findall(r"\b[a-z_]+\b", listing) if w in modules} == modules


def test_the_listed_layers_have_the_order_of_the_import_contract():
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["importlinter"]["contracts"]
    layers = next(reversed(contract["layers"]) for contract in contracts if contract["type"] == "layers")
    text = (DOCS / "architecture.md").read_text("utf-8")
    lines = re.search(r"## Folders and layers\n\n```text\n(.*?)```", text, re.DOTALL)[1].splitlines()[2:]
    line_of = {name: i for i, line in reversed([*enumerate(lines)]) for name in re.findall(r"[a-z0-9_]+", line[:90])}
    order = [[line_of[name] for name in layer.split(" | ")] for layer in layers]
    assert all(max(lower) <= min(upper) for lower, upper in itertools.pairwise(order)), order


def test_every_python_block_of_every_page_is_python():
    for page in [ROOT / "README.md", *DOCS.glob("*.md")]:
        for block in re.findall(r"```python\n(.*?)```", page.read_text("utf-8"), re.DOTALL):
            ast.parse(textwrap.dedent(block))


def test_every_command_and_option_of_the_pages_exists():
    context, used = click.Context(group), 0
    for page in [*DOCS.glob("*.md"), ROOT / "README.md", *ROOT.glob("*/README.md")]:
        for line in re.findall(r"(?:^|`)(?:\$ | {4})?rocs-bt ([a-z][^`\n]*)", page.read_text("utf-8"), re.MULTILINE):
            words = line.split(" #")[0].split()
            command = group
            while isinstance(command, click.Group) and words and words[0] != "battery":  # of an example
                command = command.get_command(context, words.pop(0))
                assert command is not None, f"{page.name}: rocs-bt {line}"
            known = {option for p in command.params for option in (*p.opts, *p.secondary_opts)} | {"--help"}
            options = {w.strip("[]").rstrip(",.").partition("=")[0] for w in words if w.startswith("--")}
            assert options <= known, f"{page.name}: rocs-bt {line}"
            used += len(options)
    assert used > 150
