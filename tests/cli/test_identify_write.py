"""`rocs-bt identify --write` at the front door: a robot that is worse than its base is measured, and drives again."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import pytest

from rocs_bt.catalog import Catalog
from rocs_bt.cli.main import call
from rocs_bt.simulation import identify as identification
from rocs_bt.simulation.identify import Identified, IdentifiedAxis, IdentifiedWheels

SHIPPED = Catalog().shipped / "robots"
LATE = """\
format = "robot/3"
base = "jackal"                    # ours
doc = "A Jackal with late motors."

[[actuator]]
name = "wheels"
delay = "0.4 s"                    # a radio link
"""
ICE = 'format = "robot/3"\nbase = "jackal"\ndoc = "On ice."\nmodel = "own.xml"\n'


@pytest.fixture
def late(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A Jackal with late motors, in a project."""
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "robots" / "late"
    folder.mkdir(parents=True)
    (folder / "robot.toml").write_text(LATE, "utf-8")
    return folder / "robot.toml"


def axis_of(speed: float, lag: float, latency: float, deceleration: float, stop: float) -> IdentifiedAxis:
    """Figures of one axis that fit the braking model."""
    braking = {"latency": latency, "deceleration": deceleration, "stop_distance": stop, "misfit": 0.001}
    return IdentifiedAxis(max_speed=speed, lag=lag, braking=(), **braking)


@pytest.fixture
def measured(monkeypatch: pytest.MonkeyPatch) -> Identified:
    """What identify finds on that robot, without moving it."""
    axes = {
        "vx": axis_of(1.986, 0.4131, 0.4006, 4.966, 1.193),
        "wz": axis_of(7.16, 0.431, 0.397, 15.63, 4.481),
    }
    wheels = IdentifiedWheels(
        effective_wheel_separation=0.5523, icr_offset=0.064, wheel_separation_error=0.012, slowest_turn=0.95
    )
    found = Identified(robot="late", axes=axes, wheels=wheels)
    monkeypatch.setattr(identification, "identify", lambda *_: found)
    return found


def said(capsys: pytest.CaptureFixture[str], *arguments: str, code: int = 0) -> str:
    assert call(list(arguments)) == code
    out, err = capsys.readouterr()
    return out + err


def played(robot: str, scene: str, out: Path) -> str:
    call(["run", scene, f"--planner=hybrid@{robot}", "--out", str(out)])
    agents = json.loads((out / "summary.json").read_text("utf-8"))["agents"]
    return str(next(iter(agents.values()))["outcome"])


def test_a_late_robot_is_measured_and_checked(late: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "'late' is not identified" in said(capsys, "check", str(late))
    said(capsys, "identify", "late", "--write")
    assert "no faults" in said(capsys, "check", str(late))


@pytest.mark.soak
@pytest.mark.parametrize(("text", "scene"), [(LATE, "barn_like-2"), (ICE, "barn_like-2")])
def test_a_worse_robot_drives_after_it_was_measured(
    late: Path, capsys: pytest.CaptureFixture[str], text: str, scene: str
) -> None:
    model = (SHIPPED / "jackal" / "robot.xml").read_text("utf-8")
    (late.parent / "own.xml").write_text(re.sub(r'friction="1 ', 'friction="0.1 ', model), "utf-8")
    late.write_text(text, "utf-8")
    assert "'late' is not identified" in said(capsys, "check", str(late))
    assert played("late", scene, late.parent / "before") == "collision"
    said(capsys, "identify", "late", "--write")
    assert "no faults" in said(capsys, "check")
    assert played("late", scene, late.parent / "after") == "success"


@pytest.mark.usefixtures("measured")
def test_the_changed_lines_are_shown_and_the_others_stay(late: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = said(capsys, "identify", "late", "--write")
    assert '+latency = "0.451 s"' in text
    assert late.read_text("utf-8").startswith(LATE)
    assert re.findall(r"^(\w+) = .*  # measured by rocs-bt identify$", late.read_text("utf-8"), re.MULTILINE) == [
        "delay",
        "lag",
        "latency",
    ]
    assert "needs no correction" in said(capsys, "identify", "late", "--write")
    response = Catalog(late.parents[2]).load_robot("late").locomotion.response
    assert (response.delay, response.lag, response.latency) == (0.401, 0.0125, 0.451)


@pytest.mark.usefixtures("measured")
def test_margins_stay(late: Path, capsys: pytest.CaptureFixture[str]) -> None:
    late.write_text(LATE + '\n[locomotion]\nlatency = "0.6 s"  # a margin\ndeceleration = "2 m/s2"\n', "utf-8")
    said(capsys, "identify", "late", "--write")
    text = late.read_text("utf-8")
    assert 'latency = "0.6 s"  # a margin\ndeceleration = "2 m/s2"\ndelay = "0.401 s"' in text
    assert "no faults" in said(capsys, "check", str(late))


@pytest.mark.usefixtures("measured")
@pytest.mark.parametrize("options", [["--write", "--dry-run"], []])
def test_without_write_or_with_dry_run_the_file_stays(
    late: Path, capsys: pytest.CaptureFixture[str], options: list[str]
) -> None:
    text = said(capsys, "identify", "late", *options)
    assert ('+latency = "0.451 s"' in text) == ("--write" in options)
    assert late.read_text("utf-8") == LATE
    assert late.with_name("identified.toml").exists() != ("--dry-run" in options)


@pytest.mark.usefixtures("measured")
def test_as_json_with_write_only_json_is_printed(late: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert json.loads(said(capsys, "identify", "late", "--write", "--json"))["robot"] == "late"
    assert "latency" in late.read_text("utf-8")


def test_a_shipped_robot_is_refused_with_a_copy(late: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = (SHIPPED / "jackal" / "robot.toml").read_bytes()
    for name in ("jackal", str(SHIPPED / "jackal" / "robot.toml")):
        text = said(capsys, "identify", name, "--write", code=2)
        assert "shipped with rocs_bt" in text
        assert 'base = "jackal"' in text
        assert f"cp -r {SHIPPED / 'jackal'} {late.parents[1] / 'jackal'}" in text
    assert (SHIPPED / "jackal" / "robot.toml").read_bytes() == before


def test_a_read_only_file_is_refused_before_it_is_measured(late: Path, capsys: pytest.CaptureFixture[str]) -> None:
    late.chmod(0o444)
    assert "read-only" in said(capsys, "identify", "late", "--write", code=2)
    assert late.read_text("utf-8") == LATE
    assert not late.with_name("identified.toml").exists()


def test_a_file_that_is_edited_during_the_measurement_is_not_overwritten(
    late: Path, measured: Identified, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def edit_and_identify(*_: object) -> Identified:
        late.write_text(LATE + "# edited\n", "utf-8")
        return measured

    monkeypatch.setattr(identification, "identify", edit_and_identify)
    assert "was changed during the measurement" in said(capsys, "identify", "late", "--write", code=2)
    assert late.read_text("utf-8") == LATE + "# edited\n"


@pytest.mark.usefixtures("measured")
def test_a_link_to_the_file_stays_a_link(late: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    elsewhere = tmp_path / "elsewhere.toml"
    shutil.move(late, elsewhere)
    late.symlink_to(elsewhere)
    said(capsys, "identify", "late", "--write")
    assert late.is_symlink()
    assert "latency" in elsewhere.read_text("utf-8")
