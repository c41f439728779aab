"""README.md: its program prints what it says, its command too, its links lead somewhere.

`python tests/examples/test_readme.py` runs both and writes what they print into README.md.
"""

import ast
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text("utf-8")
PROGRAM = re.compile(r"```python\n(.*?)```\n\nIt prints:\n\n```text\n(.*?)```", re.DOTALL)
COMMAND = re.compile(r"```console\n\$ (rocs-bt .*?)\n(.*?)```", re.DOTALL)
SPEED = re.compile(r"in [\d.]+ s \([\d.]+ times real time\)")  # of this machine at this moment


def run(arguments, folder):
    done = subprocess.run(
        [sys.executable, *arguments], cwd=folder, capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def run_program(folder):
    (folder / "program.py").write_text(PROGRAM.search(README).group(1), "utf-8")
    return run(["-W", "error", "program.py"], folder)


def run_command(folder):
    return run(["-m", "rocs_bt", *COMMAND.search(README).group(1).split()[1:]], folder)


def test_the_program_prints_what_it_says(tmp_path):
    assert run_program(tmp_path) == PROGRAM.search(README).group(2)


def test_the_program_has_no_more_than_25_lines():
    program = PROGRAM.search(README).group(1)
    ast.parse(program)
    assert len(program.splitlines()) <= 25


def test_the_command_prints_what_it_says(tmp_path):
    assert SPEED.sub("", run_command(tmp_path)) == SPEED.sub("", COMMAND.search(README).group(2))


def test_the_rule_is_the_shipped_one():
    (quoted,) = re.findall(r"```toml\n(.*?)```", README, re.DOTALL)
    ((name, rule),) = tomllib.loads(quoted)["rule"].items()
    shipped = tomllib.loads((ROOT / "rules" / "avoid_collision.toml").read_text("utf-8"))["rule"][name]
    assert {key: shipped[key] for key in rule} == rule


PAGES = [ROOT / "README.md", *ROOT.glob("docs/*.md"), *ROOT.glob("*/README.md")]


@pytest.mark.parametrize("page", sorted(PAGES), ids=lambda p: p.relative_to(ROOT).as_posix())
def test_links_lead_somewhere(page):
    text = re.sub(r"```.*?```", "", page.read_text("utf-8"), flags=re.DOTALL)
    links = [link.partition("#")[0] for link in re.findall(r"\]\(([^)\s]+)\)", text)]
    dead = [link for link in links if link and "://" not in link and not (page.parent / link).exists()]
    assert dead == []


def test_the_picture_is_small():
    assert (ROOT / "docs" / "exp1.png").stat().st_size < 200_000


def test_versions_agree():
    version = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["version"]
    assert f"\nversion: {version}\n" in (ROOT / "CITATION.cff").read_text("utf-8")


if __name__ == "__main__":
    import tempfile

    with tempfile.TemporaryDirectory() as empty:
        printed, shown = run_program(Path(empty)), run_command(Path(empty))
    found = PROGRAM.search(README)
    text = README[: found.start(2)] + printed + README[found.end(2) :]
    found = COMMAND.search(text)
    if SPEED.sub("", found.group(2)) != SPEED.sub("", shown):
        text = text[: found.start(2)] + shown + text[found.end(2) :]
    (ROOT / "README.md").write_text(text, "utf-8")
