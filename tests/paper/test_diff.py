"""`python -m benchmarks.paper.diff`: for people, for pages and for scripts."""

from __future__ import annotations

import json
from types import SimpleNamespace

import pytest

from benchmarks.paper.diff import main


@pytest.fixture
def compare(capsys, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)

    def run(*words):
        code = main([str(word) for word in words])
        return SimpleNamespace(code=code, **dict(zip(("out", "err"), capsys.readouterr(), strict=True)))

    return run


def test_for_people_it_is_a_table_of_content_robots_code_and_files(compare, monkeypatch):
    monkeypatch.setenv("COLUMNS", "160")
    told = compare("exp1", "exp2")
    assert (told.code, told.err) == (0, "")
    rows = [" ".join(line.split()) for line in told.out.splitlines()]
    assert "Content of exp1 and exp2" in rows
    assert "mission go_to – –" in rows
    assert "robot pioneer_p3dx – summit_xl" in rows
    assert "Settings of exp1 and exp2" in rows
    assert "duration 60 s 60 s same" in rows
    assert "agents R2 R3 differs" in rows
    assert "R2 of exp1, R3 of exp2" in rows
    assert "success's at once end differs" in rows
    assert "mission go_to go_to same" in rows
    assert "robot pioneer_p3dx summit_xl differs" in rows
    assert any(row.startswith("robot summit_xl ") and len(row.split()[-1]) == 12 for row in rows)


def test_as_json_it_has_everything(compare):
    found = json.loads(compare("exp2", "exp3", "--json").out)
    assert set(found) == {"first", "second", "content", "code", "settings", "robots", "pieces"}
    content = {row["kind"]: row for row in found["content"]}
    assert content["mission"]["first"] == ["go_to"]
    assert "follow_robot" in content["mission"]["second"]
    assert {"what": "duration", "first": "60 s", "second": "90 s"} in found["settings"]
    assert all(len(piece["content_hash"]) == 64 for piece in found["pieces"]["first"])


def test_as_markdown_rows_are_as_wide_as_their_heads(compare):
    told = compare("exp1", "exp3", "--markdown").out
    for block in told.split("\n\n"):
        rows = [line for line in block.splitlines() if line.startswith("|")]
        assert len({line.count("|") for line in rows}) <= 1


def test_as_markdown_it_has_what_differs_and_names_what_does_not(compare):
    told = compare("exp2", "exp3", "--markdown").out.splitlines()
    assert "| duration | 60 s | 90 s | differs |" in told
    assert "| script's max_speed | 0.3 m/s | 0.2 m/s | differs |" in told
    assert "| script | random_walk | random_walk | same |" in told
    assert "| jitter, latency |  |  | same |" in told


def test_a_bar_in_a_setting_ends_no_cell_of_markdown(compare, tmp_path):
    requirement = '\n[[requirement]]\nname = "a|b"\nrequire = "always speed < 1 m/s"\n'
    (tmp_path / "mine.toml").write_text('format = "scenario/2"\nbase = "exp1"\n' + requirement)
    told = compare("exp1", tmp_path / "mine.toml", "--markdown")
    assert r"| requirement a\|b | – | require: always speed < 1 m/s | differs |" in told.out, told.err


def test_what_a_file_says_is_no_markup_and_breaks_no_table(compare, tmp_path, monkeypatch):
    monkeypatch.setenv("COLUMNS", "160")
    requirement = '\n[[requirement]]\nname = "a[/b] [bold]"\nrequire = """\nalways speed\n  < 1 m/s"""\n'
    (tmp_path / "mine.toml").write_text('format = "scenario/2"\nbase = "exp1"\n' + requirement)
    plain = compare("exp1", tmp_path / "mine.toml")
    assert plain.code == 0, plain.err
    assert "requirement a[/b] [bold]" in plain.out
    told = compare("exp1", tmp_path / "mine.toml", "--markdown")
    assert "| requirement a[/b] [bold] | – | require: always speed < 1 m/s | differs |" in told.out


def test_what_does_not_exist_is_told(compare):
    told = compare("exp1", "exp9")
    assert told.code == 2
    assert "no scenario is named 'exp9'" in told.err


def test_a_robot_with_ros_2_differs_from_the_simulated_one_only_in_its_drivers(compare):
    found = json.loads(compare("exp1", "exp1_ros2", "--json").out)
    assert [s for s in found["settings"] if s["first"] != s["second"]] == []
    assert [s for robot in found["robots"] for s in robot["settings"] if s["first"] != s["second"]] == [
        {"what": "robot", "first": "pioneer_p3dx", "second": "pioneer_p3dx_ros2"}
    ]
    code = {row["kind"]: row for row in found["code"] if row["changed"] or row["first"] or row["second"]}
    assert set(code) == {"devices", "ros2"}
    assert code["devices"]["second"] == code["ros2"]["first"] == []
    assert {"ActuatorNode", "SensorNode"} <= set(code["ros2"]["second"])
    differing = {row["kind"] for row in found["content"] if row["changed"] or row["first"] or row["second"]}
    assert differing == {"scenario", "robot"}
