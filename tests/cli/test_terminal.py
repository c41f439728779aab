"""What reaches the terminal is plain text, whatever names, texts and exceptions hold."""

from __future__ import annotations

import ast
import io
import subprocess
import sys
import threading
import unicodedata
import warnings
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import rocs_bt as package
from rocs_bt.base.clock import SimulatedClock
from rocs_bt.cli import main, terminal
from rocs_bt.cli.terminal import echo, guard_streams, safe, show_table, styled

ROOT = Path(package.__file__).parent
SOURCES = sorted(p for p in ROOT.rglob("*.py") if "_content" not in p.parts and "project" not in p.parts)
PIPES = {"studio/__main__.py", "drivers/isolated/process.py"}  # they write to a pipe of their parent's
EVIL = "\x1b]0;owned\x07\x1b[31m\x9b2J\u202egnp\r\x08"


def harmless(text: str) -> bool:
    """Whether no character is a control character, half of one, or a mark that turns the reading order."""
    bad = [c for c in text if unicodedata.category(c) in ("Cc", "Cs", "Zl", "Zp") or c == "\u202e"]
    return set(bad) <= {"\t", "\n"}


def printing(tree: ast.AST) -> list[str]:
    """All calls and names in a module by which something may reach the terminal."""
    found = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "print":
            found.append("print")
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            found.append(f"{node.value.id}.{node.attr}")
        if isinstance(node, ast.ImportFrom) and node.module in ("rich.console", "rich.table"):
            found.append(node.module)
    dangerous = {
        "print", "click.echo", "click.secho", "click.style", "click.confirm", "click.prompt", "sys.stdout.write",
        "traceback.print_exc", "traceback.print_exception", "warnings.showwarning", "rich.console", "rich.table",
    }  # fmt: skip  # names, several on a line
    return [name for name in found if name in dangerous]


def test_nothing_but_the_terminal_module_prints():
    names = {file: file.relative_to(ROOT).as_posix() for file in SOURCES}
    found = {
        name: printing(ast.parse(file.read_text("utf-8")))
        for file, name in names.items()
        if name != "cli/terminal.py" and name not in PIPES
    }
    # The progress bar has no text but a safe one.
    assert {name: calls for name, calls in found.items() if calls} == {"cli/progress.py": ["rich.console"]}


@given(st.text(alphabet=st.characters()))
def test_a_text_is_made_safe_and_nothing_else_is_changed(text):
    made = safe(text)
    assert harmless(made)
    assert safe(made) == made
    if all(c == "\n" or c.isprintable() for c in text):
        assert made == text


def test_only_our_own_styles_reach_a_terminal(monkeypatch):
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    screen = Terminal()
    monkeypatch.setattr(sys, "stdout", screen)
    monkeypatch.delenv("NO_COLOR", raising=False)
    echo(f"{styled(EVIL, fg='red', bold=True)} and {EVIL}")
    show_table([[EVIL, "2"]], ["a [bold]", EVIL], styles={0: "green"}, indent=2)
    text = screen.getvalue()
    assert text.startswith("\x1b[31m\x1b[1m\\x1b]0;owned\\x07")
    assert "a [bold]" in text
    for code in ("\x1b[31m", "\x1b[1m", "\x1b[0m", "\x1b[32m"):
        text = text.replace(code, "")
    assert harmless(text.replace("\x1b[1;32m", "").replace("\x1b[1m", ""))


def test_a_text_that_guesses_the_form_of_a_style_has_none(capsys):
    echo("\x00guess:31\x00red")
    assert capsys.readouterr().out == "\\x00guess:31\\x00red\n"


@pytest.mark.parametrize("encoding", ["ascii", "latin-1", "utf-8"])
def test_what_a_stream_cannot_encode_is_escaped(monkeypatch, encoding):
    stream = io.TextIOWrapper(io.BytesIO(), encoding=encoding)
    monkeypatch.setattr(sys, "stdout", stream)
    echo("ü – \udc80 fine")
    stream.flush()
    assert b"fine" in stream.buffer.getvalue()


def hostile(project: Path) -> None:
    """Puts terminal escapes wherever a project can hold them."""
    scenario = project / "scenarios" / "first.toml"
    escaped = "".join(f"\\u{ord(c):04x}" for c in EVIL)
    scenario.write_text(scenario.read_text().replace('doc = "', f'doc = "{escaped}'))
    bad = scenario.with_name("bad.toml")
    bad.write_text(f'format = "scenario/2"\n"{escaped}" = 1\nworld = "{escaped}"\nduration = "{escaped}"\n')
    (project / "rules" / f"calm{EVIL}.toml").write_text(f'format = "{escaped}"\n')
    (project / "planners" / "missions" / "loud.py").write_text(
        f'"""{EVIL!r}"""\n\n\ndef build(mission):\n    raise ValueError({EVIL!r})\n'
    )
    (project / "planners" / "missions" / "leafy.py").write_text(
        f'"""One leaf."""\n\n\ndef build(mission):\n    return mission.wait("1 s", name={EVIL!r})\n'
    )
    (project / "planners" / "missions" / "tree.xml").write_text(
        '<root BTCPP_format="4"><BehaviorTree ID="Tree"><Sleep name="&#x9b;2J" mseck="1&#x202e;"/>'
        "</BehaviorTree></root>"
    )


@pytest.mark.parametrize(
    "arguments",
    [
        ["list"],
        ["list", "--json"],
        ["check"],
        ["check", "--json"],
        ["check", "--no-code"],
        ["show", "leafy"],
        ["show", "leafy", "--format", "xml"],
        ["show", "tree"],
        ["run", "bad"],
        ["run", f"{EVIL}"],
        ["run", "first", f"--{EVIL}"],
        [f"{EVIL}"],
        ["replay", f"{EVIL}"],
        ["show", "--palette"],
        ["new", f"here{EVIL}"],
        ["doctor"],
    ],
    ids=lambda a: ascii(" ".join(a))[:30],
)
def test_no_command_lets_an_escape_through(project, rocs_bt, arguments):
    hostile(project)
    told = rocs_bt(*arguments)
    assert told.out + told.err
    assert harmless(told.out + told.err)


def test_a_mission_that_raises_escapes_and_its_report_do_not_reach_the_terminal(project, rocs_bt):
    hostile(project)
    scenario = project / "scenarios" / "first.toml"
    text = scenario.read_text().partition("[agent.parameters]")[0]
    for mission in ("loud", "leafy"):
        scenario.write_text(text.replace('"patrol"', f'"{mission}"'))
        told = rocs_bt("run", "first", "--for", "3")
        assert harmless(told.out + told.err)
    told = rocs_bt("replay", "runs/first-1", "--why", "0.5")
    assert told.code == 0
    assert harmless(told.out + told.err)


def test_the_traceback_of_a_defect_is_safe(rocs_bt, monkeypatch):
    def fail(*args: object, **kwargs: object) -> None:
        raise ZeroDivisionError(EVIL)

    monkeypatch.setattr(main.group, "main", fail)
    told = rocs_bt("list")
    assert told.code == 3
    assert "Traceback" in told.err
    assert "owned" in told.err
    assert harmless(told.err)


def test_warnings_and_exceptions_of_threads_are_safe(capsys, monkeypatch):
    monkeypatch.setattr(warnings, "showwarning", warnings.showwarning)
    monkeypatch.setattr(threading, "excepthook", threading.excepthook)
    guard_streams()

    def fail() -> None:
        raise ValueError(EVIL)

    warnings.showwarning(UserWarning(EVIL), UserWarning, EVIL, 1)
    thread = threading.Thread(target=fail, name=EVIL)
    thread.start()
    thread.join()
    err = capsys.readouterr().err
    assert err.count("owned") >= 4
    assert harmless(err)


def test_the_process_guards_its_streams(project):
    (project / "planners" / "missions" / "warns.py").write_text(
        f'"""Warns."""\nimport warnings\nwarnings.warn({EVIL!r})\n\n\n'
        'def build(mission):\n    return mission.wait("1 s")\n'
    )
    command = [sys.executable, "-m", "rocs_bt", "check", "planners/missions/warns.py"]
    done = subprocess.run(command, cwd=project, capture_output=True, text=True, check=True)
    assert "owned" in done.stderr
    assert harmless(done.stdout + done.stderr)


def test_a_bar_has_a_plain_name(monkeypatch):
    screen = io.StringIO()
    monkeypatch.setattr(sys, "stderr", screen)
    from rocs_bt.cli.progress import ProgressBar

    with ProgressBar(f"{EVIL}[red]", 10.0) as progress:
        progress._start()
        assert progress._bar.tasks[0].description == safe(f"{EVIL}[red]")
        assert "[red]" in progress._bar.columns[0].render(progress._bar.tasks[0]).plain


def test_without_a_terminal_a_line_a_minute_says_how_far_it_is(monkeypatch, capsys):
    from rocs_bt.cli import progress

    now = SimulatedClock(25.0)
    monkeypatch.setattr(progress, "WallClock", lambda: now)
    with progress.ProgressBar(f"{EVIL}office", 40.0, "episodes") as shown:
        for done in range(8):
            shown(done)
            now.advance()
    lines = capsys.readouterr().err.splitlines()
    name = safe(f"{EVIL}office")
    assert lines == [f"{name}: {done} of at most 40 episodes after {25 * done} s" for done in (3, 6)]


def test_terminal_is_what_the_commands_use():
    assert main.echo is terminal.echo
