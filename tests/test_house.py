"""The house itself: imports between the folders, and what is public (docs/architecture.md)."""

from __future__ import annotations

import ast
import contextlib
import functools
import importlib
import re
import subprocess
import sys
import textwrap
import types
from pathlib import Path

import grimp
import networkx
import pytest

import rocs_bt

ROOT = Path(__file__).resolve().parent.parent
SOURCES = sorted(p for p in (ROOT / "rocs_bt").rglob("*.py") if "_content" not in p.parts)
CONTENT = sorted(p for name in ("planners", "robots", "scenarios") for p in (ROOT / name).rglob("*.py"))
TESTS = sorted((ROOT / "tests").rglob("*.py"))
HEAVY = ("casadi", "matplotlib", "mujoco", "networkx", "numpy", "py_trees", "scipy", "z3")

PUBLIC = [
    "Action",
    "Actuator",
    "Agent",
    "AgentResult",
    "Analyze",
    "AtomicAction",
    "Catalog",
    "Change",
    "Clock",
    "Comparison",
    "Count",
    "DeviceError",
    "Event",
    "Execute",
    "Failure",
    "Fault",
    "InputError",
    "Joules",
    "Kilograms",
    "Knowledge",
    "KnowledgeError",
    "ListSink",
    "MacroAction",
    "Metres",
    "MetresPerSecond",
    "MetresPerSecondSquared",
    "Mission",
    "Monitor",
    "Pipeline",
    "Plan",
    "Pose2",
    "Pose3",
    "PositiveCount",
    "PositiveMetres",
    "PositiveMetresPerSecond",
    "PositiveRadians",
    "PositiveRadiansPerSecond",
    "PositiveSeconds",
    "Priority",
    "Progress",
    "Radians",
    "RadiansPerSecond",
    "Rates",
    "ReactiveModel",
    "Reading",
    "Reason",
    "Recording",
    "RocsError",
    "RunOptions",
    "RunResult",
    "Seconds",
    "Sensor",
    "Signal",
    "SimulatedClock",
    "Summary",
    "Twist2",
    "Twist3",
    "WallClock",
    "Watts",
    "build_agent",
    "drive",
    "replay",
    "report",
    "run",
    "sweep",
]


def test_imports_point_downwards():
    linter = "from importlinter.cli import lint_imports_command as lint; lint()"
    done = subprocess.run([sys.executable, "-c", linter, "--no-cache"], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


def test_the_public_names_are_these():
    assert rocs_bt.__all__ == PUBLIC == sorted(PUBLIC)


@pytest.mark.parametrize("name", PUBLIC)
def test_every_public_name_can_be_had_and_says_what_it_is(name):
    assert getattr(rocs_bt, name).__doc__
    assert name in dir(rocs_bt)


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'Nonsense'"):
        rocs_bt.Nonsense  # noqa: B018 - looking is the test


@pytest.mark.parametrize("code", ["import rocs_bt", "import rocs_bt.cli.main as m; assert m.call(['--help']) == 0"])
def test_nothing_heavy_is_loaded_before_it_is_used(code):
    asks = f"{code}\nimport sys\nprint(sorted(set(sys.modules) & set({HEAVY!r})))"
    done = subprocess.run([sys.executable, "-c", asks], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


def test_the_command_line_knows_its_commands():
    import click

    from rocs_bt.cli.main import COMMANDS, group

    for name in COMMANDS:
        assert group.get_command(click.Context(group), name).help


@pytest.mark.parametrize("path", CONTENT, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_content_imports_public_names_only(path):
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.ImportFrom) and not node.level and node.module.partition(".")[0] == "rocs_bt":
            module = importlib.import_module(node.module)
            names = [alias.name for alias in node.names]
            assert not [name for name in (*node.module.split("."), *names) if name.startswith("_")]
            assert set(names) <= set(getattr(module, "__all__", names))
        elif isinstance(node, ast.Import):
            assert not [alias.name for alias in node.names if alias.name.startswith("rocs_bt.")]


SKIPPING = {
    "contracts/test_check_and_run.py": "faults that a family cannot have",
    "golden/test_runs.py": "kinds of processors on which no golden run was computed",
    "knowledge/test_share_hosts.py": "machines without network namespaces",
    "needs.py": "what machines may lack",
    "packaging/test_installed.py": "a checkout without its manual",
    "packaging/test_kernel_build.py": "machines without a C compiler",
    "ros2/on_rclpy/test_transports.py": "what Kilted does not tell",
    "ros2/robot_process.py": "machines without wheels of ROS 2",
}
"""Files of tests that skip tests, and when."""


def test_tests_are_skipped_in_reviewed_places_only():
    skips = re.compile(r"pytest\.(skip|importorskip|xfail)\(|mark\.(skip|skipif|xfail)\b")
    tests = ROOT / "tests"
    found = {p.relative_to(tests).as_posix() for p in tests.rglob("*.py") if skips.search(p.read_text("utf-8"))}
    assert found == set(SKIPPING)


BROAD = re.compile(r"^\s*(except\b[^#]*\b(Base)?Exception\b|except:|with [^#]*suppress\([^#)]*\b(Base)?Exception\b)")


@pytest.mark.parametrize(
    ("line", "broad"),
    [
        ("    except Exception as error:", True),
        ("except (OSError, BaseException):", True),
        ("    except:", True),
        ("        with contextlib.suppress(Exception):", True),
        ("        with suppress(Exception, SystemExit), lock:", True),
        ("    except OSError as error:  # not every Exception", False),
        ("    except IsolatedException:", False),
    ],
)
def test_what_catches_everything_is_found(line, broad):
    assert bool(BROAD.search(line)) == broad


SILENCING = re.compile(
    r"# (?:type: ignore(?:\[[^]]*\])?|(?:ruff: )?noqa(?:: *[A-Z\d, ]+)?|fmt: (?:off|skip)|pragma: no cover)"
)


def test_what_catches_everything_or_silences_a_check_says_why():
    silent = []
    for path in [*SOURCES, *CONTENT, *TESTS]:
        above = ""
        for number, line in enumerate(path.read_text("utf-8").splitlines(), 1):
            code, _, comment = SILENCING.sub("#", line).partition("#")
            reason = comment if code.strip() else above + comment
            if (BROAD.search(line) or SILENCING.search(line)) and len(re.findall(r"\w+", reason)) < 3:
                silent.append(f"{path}:{number}: {line.strip()}")
            above = comment if not code.strip() else ""
    assert silent == []


@functools.cache
def _tree(path):
    return ast.parse(path.read_text("utf-8"))


def _programs(path):
    """Programs of Python in the texts of a file, such as those that tests run in a process of its own."""
    for node in ast.walk(_tree(path)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and "rocs_bt" in node.value:
            with contextlib.suppress(SyntaxError):
                yield ast.parse(textwrap.dedent(node.value))


def _missing(program):
    """Names of rocs_bt that a program imports or replaces, and that do not exist."""
    found = {}
    for node in ast.walk(program):
        if isinstance(node, ast.ImportFrom) and (node.module or "").partition(".")[0] == "rocs_bt":
            module = importlib.import_module(node.module)
            for alias in node.names:
                if not hasattr(module, alias.name) and hasattr(module, "__path__"):
                    with contextlib.suppress(ModuleNotFoundError):
                        importlib.import_module(f"{node.module}.{alias.name}")
                found[alias.asname or alias.name] = getattr(module, alias.name, None)
                if not hasattr(module, alias.name):
                    yield f"{node.module}.{alias.name}"
        elif isinstance(node, ast.Assign) and isinstance(target := node.targets[0], ast.Attribute):
            owner = found.get(ast.unparse(target.value))
            if isinstance(owner, types.ModuleType) and not hasattr(owner, target.attr):
                yield ast.unparse(target)


def test_programs_in_texts_of_tests_use_names_that_exist():
    assert [f"{path}: {name}" for path in TESTS for program in _programs(path) for name in _missing(program)] == []


def test_no_function_is_too_long():
    """Docstrings do not count."""
    long = []
    for path in (*SOURCES, *CONTENT):
        for node in ast.walk(_tree(path)):
            if isinstance(node, ast.FunctionDef):
                first = node.body[1 if ast.get_docstring(node) and len(node.body) > 1 else 0]
                long += [f"{path.name}: {node.name}"] if node.end_lineno - first.lineno >= 60 else []
    assert long == []


SECTION = re.compile(r"^(?:Args|Attributes):\n((?:    .*\n?)+)", re.MULTILINE)
ENTRY = re.compile(r"^    (\w+): (.*(?:\n     .*)*)", re.MULTILINE)


def _words(text):
    return {word.removesuffix("s") for word in re.findall("[a-z]+", re.sub("(?<=[a-z])(?=[A-Z])", " ", text).lower())}


def _restates_only(node):
    """Whether the entries of a section say nothing but names, annotations and the docstring's first line."""
    doc = ast.get_docstring(node) or ""
    sections = SECTION.findall(doc)
    types = {x.arg: x.annotation for x in ast.walk(node) if isinstance(x, ast.arg)} if sections else {}
    types |= {ast.unparse(x.target): x.annotation for x in node.body if isinstance(x, ast.AnnAssign)}
    said = _words(
        f"{node.name} " + doc.split("\n")[0] + " the a an of its in for to by and each this all with that is name value"
    )
    for section in sections:
        known = {
            name: said | _words(f"{name} {ast.unparse(types.get(name) or ast.Name(name))}")
            for name, _ in ENTRY.findall(section)
        }
        if known and all("[" not in text and _words(text) <= known[name] for name, text in ENTRY.findall(section)):
            return True
    return False


@pytest.mark.parametrize(
    ("entry", "restates"),
    [
        ("robot: The robot.", True),
        ("robot: Name of the robot.", True),
        ("robot: Robot; its name may be empty.", False),
        ("robot: Robot [m].", False),
    ],
)
def test_what_only_restates_is_found(entry, restates):
    code = f'def f(robot: Robot):\n    """Check a robot.\n\n    Args:\n        {entry}\n    """'
    assert _restates_only(ast.parse(code).body[0]) == restates


def test_no_section_of_a_docstring_only_restates_names_and_types():
    found = []
    for path in SOURCES:
        for node in ast.walk(_tree(path)):
            if isinstance(node, ast.FunctionDef | ast.ClassDef) and _restates_only(node):
                found.append(f"{path}:{node.lineno}: {node.name}")
    assert found == [], "delete these sections, or write what name, type and first line do not say"


def test_no_module_imports_itself_through_others():
    """Imports under TYPE_CHECKING count."""
    found = grimp.build_graph("rocs_bt", exclude_type_checking_imports=False)
    graph = networkx.DiGraph((m, n) for m in found.modules for n in found.find_modules_directly_imported_by(m))
    assert len(graph) > 400
    assert [sorted(circle) for circle in networkx.strongly_connected_components(graph) if len(circle) > 1] == []


def test_the_versions_agree():
    import tomllib

    assert tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"] == rocs_bt.__version__


PINS = ["constraints.txt", "tests/ros2/requirements-jazzy.txt", "tests/ros2/requirements-kilted.txt"]


@pytest.mark.parametrize("name", PINS)
def test_pins_are_exact_and_name_no_index(name):
    for line in (ROOT / name).read_text().splitlines():
        if line and not line.startswith("#"):
            requirement, _, marker = line.partition(" ; ")
            assert requirement.count("==") == 1
            assert not marker or "python_version" in marker
            assert "://" not in line
