"""What two scenarios share and what differs (paper, 6.2: Q2 and Q3)."""

from __future__ import annotations

import sys
import tomllib
from functools import cache
from typing import Any

import pytest

from benchmarks.paper.provenance import is_counted, package_of
from benchmarks.paper.reuse import Reuse, Share, diff
from benchmarks.paper.settings import Setting
from rocs_bt.actions import ACTIONS
from rocs_bt.catalog import Catalog, content_hash
from rocs_bt.event import AtomicStarted, ListSink, TicketChanged
from rocs_bt.running import Run, RunOptions

CATALOG = Catalog()


@cache
def between(first: str, second: str) -> Reuse:
    return diff(CATALOG.load_scenario(first), CATALOG.load_scenario(second), CATALOG)


def by_kind(shares: tuple[Share, ...]) -> dict[str, Share]:
    return {share.kind: share for share in shares}


def differing(settings: tuple[Setting, ...]) -> dict[str, tuple[str, str]]:
    return {row.what: (row.first, row.second) for row in settings if not row.same}


def named_by_robot(name: str) -> set[str]:
    """The classes of blocks that a robot.toml names."""
    told = tomllib.loads(CATALOG.find("robot", name).path.read_text("utf-8"))
    return {row["class"] for part in ("monitor", "analyze") for row in told[part]}


def test_exp1_to_exp2_changes_the_robot_and_the_scenario_and_no_mission_no_rules_and_no_engine():
    found = between("exp1", "exp2")
    content = by_kind(found.content)
    assert {kind for kind, share in content.items() if not share.same} == {"scenario", "world", "robot"}
    assert content["mission"].both == ("go_to",)
    assert content["rules"].both == ("avoid_collision",)
    (mind, actor) = found.robots
    assert (mind.first, mind.second) == ("R2", "R3")
    assert {"mission", "rules", "mission's goal", "mission's cruise"}.isdisjoint(mind.differing())
    assert "robot" in mind.differing()
    assert (actor.first, actor.second, actor.differing()) == ("R1", "R1", ())


def test_exp1_to_exp2_changes_these_settings_and_no_other():
    found = between("exp1", "exp2")
    assert set(differing(found.settings)) == {"world", "place goal", "agents"}
    assert differing(found.robots[0].settings) == {
        "robot": ("pioneer_p3dx", "summit_xl"),
        "start": ("-1 m, 2 m, -1.1 rad", "-1.2 m, -0.975 m, 0.733 rad"),
        "success's at": ("once", "end"),
        "mission's hold": ("", "true"),
        "mission's facing": ("", "-135 deg"),
    }


def test_what_only_exp2_is_made_of_is_chosen_by_robot_toml_and_by_the_scenarios_parameters():
    code = by_kind(between("exp1", "exp2").code)
    assert {room for room, share in code.items() if not share.same} <= {
        "actions",
        "analyze",
        "control",
        "devices",
        "monitor",
    }
    assert not any(share.first for share in code.values()), "what EXP1 is made of, EXP2 is made of too"
    assert code["actions"].second in ((), ("TurnTo",))  # `facing`
    assert set(code["analyze"].second) <= named_by_robot("summit_xl")
    assert named_by_robot("summit_xl") & set(code["monitor"].second)
    assert "RobotSensor" in code["devices"].second


def test_exp2_to_exp3_changes_r3s_mission_alone():
    found = between("exp2", "exp3")
    content = by_kind(found.content)
    assert content["rules"].same
    assert content["world"].same
    assert content["robot"].same
    r3 = next(robot for robot in found.robots if robot.first == "R3")
    assert r3.second == "R3"
    assert {"robot", "rules"}.isdisjoint(r3.differing())
    # What else differs is where it starts, how it is judged, and what the mission is told.
    assert {s for s in r3.differing() if not s.startswith("mission's ")} == {
        "mission",
        "start",
        "success's goal",
        "success's at",
    }
    assert {share.kind for share in r3.code if not share.same} == {"actions"}


def test_exp2_to_exp3_changes_these_settings_beside_r3s_and_no_other():
    found = between("exp2", "exp3")
    told = differing(found.settings)
    places = {f"place {name}" for name in ("goal", "corner_1", "corner_2", "corner_3", "corner_4")}
    assert set(told) == {"duration", "agents", *places}
    assert (told["duration"], told["agents"]) == (("60 s", "90 s"), ("R3", "R2, R3"))
    r3, r1, r2 = (next(r for r in found.robots if r.second == name) for name in ("R3", "R1", "R2"))
    assert {s for s in r3.differing() if s.startswith("mission's ")} == {
        f"mission's {name}"
        for name in ("goal", "cruise", "hold", "facing", "leader", "distance", "room", "safety", "rest")
    }
    assert differing(r1.settings) == {
        "start": ("1.5 m, -1 m, 0 rad", "0.256 m, 1.9 m, 0 rad"),
        "jitter": ("0.3 m, 0.3 m, 3.142 rad", "0.3 m, 0.2 m, 3.142 rad"),
        "script's max_speed": ("0.3 m/s", "0.2 m/s"),
    }
    assert not r2.first, "R2 is new"


def test_a_robot_without_counterpart_is_new_and_the_other_way_round_is_gone():
    there, back = between("exp2", "exp3"), between("exp3", "exp2")
    assert [r.second for r in there.robots if not r.first] == ["R2"]
    assert [r.first for r in back.robots if not r.second] == ["R2"]
    assert [(s.first, s.second) for s in back.code] == [(s.second, s.first) for s in there.code]


def test_a_scenario_shares_everything_with_itself():
    found = between("exp3", "exp3")
    assert all(share.same for share in (*found.content, *found.code, *found.settings))
    assert all(not robot.differing() for robot in found.robots)


def test_pieces_have_the_hash_of_their_bytes():
    for piece in between("exp1", "exp2").pieces["first"]:
        entry = CATALOG.find(piece.kind, piece.name)
        assert piece.content_hash == content_hash([entry])
        assert piece.lines == sum(len(f.read_text("utf-8").splitlines()) for f in entry.files())


def test_content_of_one_name_and_other_bytes_is_changed(tmp_path):
    (tmp_path / "exp1.toml").write_bytes(CATALOG.find("scenario", "exp1").path.read_bytes() + b"# mine\n")
    found = diff(CATALOG.load_scenario("exp1"), CATALOG.load_scenario(str(tmp_path / "exp1.toml")), CATALOG)
    content = by_kind(found.content)
    assert content["scenario"].changed == ("exp1",)
    assert {kind for kind, share in content.items() if not share.same} == {"scenario"}


@pytest.mark.parametrize(("scenario", "seconds"), [("exp2_localised", 3.0), ("exp3", 5.0)])
def test_what_a_run_really_makes_once_it_drives_is_among_what_was_found(scenario: str, seconds: float) -> None:
    made: set[type] = set()

    def note(frame: Any, event: str, _: object) -> None:
        if event == "call" and frame.f_code.co_name == "__init__" and "self" in frame.f_locals:
            made.add(type(frame.f_locals["self"]))

    sink = ListSink()
    before = sys.getprofile()
    sys.setprofile(note)
    try:
        options = RunOptions(duration=seconds, sinks=[sink])
        Run(CATALOG.load_scenario(scenario), CATALOG, options).conduct()
    finally:
        sys.setprofile(before)
    code = by_kind(between(scenario, scenario).code)
    taken = {e.action for e in sink.events if isinstance(e, (TicketChanged, AtomicStarted))} & set(ACTIONS)
    assert taken
    assert taken <= set(code["actions"].both)
    rooms = ("actions", "analyze", "control", "monitor")
    counted = {(package_of(cls), cls.__name__) for cls in made if is_counted(cls) and package_of(cls) in rooms}
    assert ("control", "TimedReference" if scenario == "exp3" else "PathReference") in counted
    assert counted <= {(share.kind, name) for share in code.values() for name in share.both}
