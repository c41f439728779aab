"""Every example runs as a person runs it, and prints what its docstring says that it prints.

`python tests/examples/test_examples.py` runs them all and writes what they print into their docstrings.
"""

import ast
import os
import re
import subprocess
import sys
import textwrap
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = sorted((ROOT / "examples").glob("t*.py"))
AWAKE = str(ROOT / "tests" / "awake.py")
HEAD = "\nOutput:\n\n"


def run(example, folder, *launcher):
    """What it prints, run in an empty folder without a display; by a launcher, if there is one."""
    environment = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
    done = subprocess.run(
        [sys.executable, "-W", "error", *launcher, str(example)],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    return done.stdout


def quoted(example):
    """What its docstring says that it prints."""
    return textwrap.dedent(ast.get_docstring(ast.parse(example.read_text("utf-8"))).split(HEAD)[1]).strip("\n") + "\n"


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda p: p.stem)
def test_it_prints_what_it_says(example, tmp_path):
    launcher = [AWAKE] if "import drive" in example.read_text("utf-8") else []  # it runs on wall time
    assert run(example, tmp_path, *launcher) == quoted(example)
    assert list(tmp_path.iterdir()) == []  # and leaves nothing behind


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda p: p.stem)
def test_its_header_is_that_of_a_script_which_needs_us_alone(example):
    block = re.match(r"# /// script\n((?:#.*\n)+?)# ///\n", example.read_text("utf-8"))
    header = tomllib.loads(re.sub(r"^# ?", "", block.group(1), flags=re.MULTILINE))
    ours = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    assert header["dependencies"] == [ours["name"]]
    assert header["requires-python"] == ours["requires-python"].split(",")[0]


def test_the_course_is_numbered_and_in_the_readmes_table():
    text = (ROOT / "examples" / "README.md").read_text("utf-8")
    listed = re.findall(r"^\| \[`(\w+\.py)`\]\((\w+\.py)\) \|", text, re.MULTILINE)
    assert listed == [(p.name, p.name) for p in EXAMPLES]
    assert [int(p.name[1:3]) for p in EXAMPLES] == list(range(1, len(EXAMPLES) + 1))


def test_every_extension_point_of_the_paper_is_filled_by_a_users_class():
    """Paper, 5.3: mandatory, deliberative, reactive and optional ones."""
    tree = ast.parse((ROOT / "examples" / "t04_extension_points.py").read_text("utf-8"))
    bases = {ast.unparse(b).removeprefix("rocs_bt.") for c in tree.body if isinstance(c, ast.ClassDef) for b in c.bases}
    assert bases == {
        "Sensor",
        "Actuator",
        "AtomicAction",
        "MacroAction",
        "Monitor",
        "Analyze",
        "Plan",
        "ReactiveModel",
        "WorldModel",
        "RobotModel",
        "StrategyModel",
    }


if __name__ == "__main__":
    import tempfile

    for path in EXAMPLES:
        with tempfile.TemporaryDirectory() as empty:
            printed = textwrap.indent(run(path, empty), "    ")
        before, after = path.read_text("utf-8").split(HEAD)
        path.write_text(before + HEAD + printed + '"""' + after.split('"""', 1)[1], "utf-8")
