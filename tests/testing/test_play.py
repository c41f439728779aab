"""Missions without a robot: letters, what is known, signals, time, and the trace of it all."""

import py_trees
import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import Catalog
from rocs_bt.plan import mission_parameters
from rocs_bt.testing.missions import ScriptedOutcomes, play
from rocs_bt.trees.error import TreeError

CATALOG = Catalog()


def document(body, more=""):
    return f'<root BTCPP_format="4"><BehaviorTree ID="Main">{body}</BehaviorTree>{more}</root>'


def run(body, more="", **given):
    return play(document(body, more), catalog=CATALOG, **given)


class TestLetters:
    @pytest.mark.parametrize(
        ("letters", "cells", "outcome"),
        [("S", "S", "SUCCESS"), ("RRS", "R R S", "SUCCESS"), ("RF", "R F", "FAILURE"), ("K", "K", "SKIPPED")],
    )
    def test_a_letter_a_tick(self, letters, cells, outcome):
        trace = run('<Gadget size="3" gap="{gap}"/>', leaves={"Gadget": letters})
        assert (trace["Gadget"], trace.outcome) == (cells, outcome)

    def test_the_last_letter_goes_on_over_all_starts(self):
        trace = run('<Repeat num_cycles="3"><Gadget/></Repeat>', leaves={"Gadget": "RSR"}, ticks=6)
        assert trace["Gadget"] == "R SR R R R R"
        assert trace.outcome == "RUNNING"

    @pytest.mark.parametrize("letters", ["", "RXS", "rs"])
    def test_wrong_letters_are_refused(self, letters):
        with pytest.raises(InputError, match="invalid scripted outcomes"):
            run("<Gadget/>", leaves={"Gadget": letters})

    def test_output_ports_are_written_on_success(self):
        body = '<Sequence><ComputeRoute goal="g" planner="visibility" path="{way}"/></Sequence>'
        for letters, written in (("RS", True), ("R", False), ("F", False)):
            leaves = {"ComputeRoute": ScriptedOutcomes(letters, path=[(0.0, 0.0), (1.0, 0.0)])}
            board = run(body, leaves=leaves, ticks=3).board
            assert ("way" in board and board["way"] == [(0.0, 0.0), (1.0, 0.0)]) == written
        with pytest.raises(InputError, match="cannot write 'pth'"):
            run('<ComputeRoute goal="g" planner="visibility"/>', leaves={"ComputeRoute": ScriptedOutcomes("S", pth=1)})

    def test_what_stands_in_keeps_the_conditions_of_the_original(self):
        trace = run(
            '<Sequence><GoTo goal="a" _skipIf="stay" _onSuccess="n := 1"/><GoTo name="b" goal="b" _onSuccess="n := 2"/>'
            "</Sequence>",
            leaves={"GoTo": "S", "b": "S"},
            board={"stay": True},
        )
        assert trace["GoTo"] == "K"
        assert trace.board["n"] == 2


class TestMissions:
    @pytest.mark.parametrize("name", [entry.name for entry in CATALOG.list("mission")])
    def test_every_shipped_mission_plays_to_its_end(self, name):
        needed = [p.name for p in mission_parameters(CATALOG.load_mission(name)).values() if p.required]
        # These end when no task, or no goal, is left.
        ends = {"errands": {"Ask": "SSSSF"}, "patrol_charge": {"Ask": "SF", "a goal is left": "F"}}
        leaves = {"*": "RS"} | ends.get(name, {})
        known = {"R2": (2.0, 0.0)} if name in ("circle", "inspect") else {}  # it needs the position of its object
        parameters = dict.fromkeys(needed, "R2")
        trace = play(name, leaves=leaves, knowledge=known, parameters=parameters, catalog=CATALOG)
        assert trace.outcome == "SUCCESS"
        assert trace.ticks > 1

    def test_a_python_mission_as_a_subtree(self):
        trace = run('<SubTree ID="corners" cruise="0.3 m/s"/>', leaves={"GoTo": "S"})
        assert trace["GoTo corner_4"] == "S"

    def test_a_shipped_python_mission_by_name(self):
        trace = play("corners", leaves={"GoTo": "RS", "GoTo corner_3": "F"}, catalog=CATALOG)
        assert trace.outcome == "FAILURE"
        assert trace["GoTo corner_2"] == ". . R S ." or trace["GoTo corner_2"].split()[-2:] == ["R", "S"]
        assert trace.reason == "as scripted"

    def test_parameters_are_those_of_a_scenarios_file(self):
        trace = play("go_to", leaves={"*": "S"}, parameters={"goal": "dock", "facing": "90 deg"}, catalog=CATALOG)
        assert trace["GoTo dock"].split()[0] == "S"
        with pytest.raises(InputError, match="no parameter is named 'gaol'"):
            play("go_to", leaves={"*": "S"}, parameters={"gaol": "dock"}, catalog=CATALOG)

    def test_a_build_of_ones_own_with_py_trees_own_nodes(self):
        def build(mission):
            return py_trees.composites.Sequence(
                "both", memory=True, children=[mission.act("GoTo", goal="a"), py_trees.behaviours.Success("done")]
            )

        trace = play(build, leaves={"GoTo": "RS"}, catalog=CATALOG)
        assert trace["both"] == "R S"
        assert trace["GoTo a"] == "R S"
        assert trace["done"] == ". S"

    def test_an_xml_file_with_its_parameters(self, tmp_path):
        file = tmp_path / "m.xml"
        port = '<input_port name="n" type="int" default="2"/>'
        model = f'<TreeNodesModel><SubTree ID="Main">{port}</SubTree></TreeNodesModel>'
        file.write_text(document('<Repeat num_cycles="{n}"><GoTo goal="a"/></Repeat>', model))
        assert len(play(file, leaves={"GoTo": "S"}, catalog=CATALOG).outcomes) == 2
        assert len(play(file, leaves={"GoTo": "S"}, parameters={"n": 4}, catalog=CATALOG).outcomes) == 4

    def test_one_tree_of_a_document(self):
        other = '<BehaviorTree ID="Other"><AlwaysFailure/></BehaviorTree>'
        text = document("<AlwaysSuccess/>", other).replace("<root ", '<root main_tree_to_execute="Main" ')
        assert play(text, catalog=CATALOG).outcome == "SUCCESS"
        assert play(text, main="Other", catalog=CATALOG).outcome == "FAILURE"

    def test_a_leaf_that_would_need_a_robot_is_refused_with_what_to_write(self):
        with pytest.raises(InputError, match=r'need a robot: b\..*leaves={"b": "RRS"}'):
            run('<Sequence><GoTo name="a" goal="a"/><GoTo name="b" goal="b"/></Sequence>', leaves={"a": "S"})

    def test_a_node_that_nobody_has_and_nobody_scripts_is_unknown(self):
        with pytest.raises(InputError, match="'Gadget'"):
            run("<Gadget/>")

    def test_a_mission_is_ticked_once_at_least(self):
        with pytest.raises(InputError, match="at least 1, found 0"):
            run("<AlwaysSuccess/>", ticks=0)

    def test_what_a_node_cannot_do_is_told_with_its_path(self):
        with pytest.raises(TreeError, match="Script::1"):
            run('<Script code="x += 1"/>')


class TestSurroundings:
    def test_signals_carry_their_units(self):
        line = '<When expression="min(front) < 0.5 m and heat > 30 K"/>'
        assert run(line, signals={"front": ["1 m", "40 cm"], "heat": "31 K"}).outcome == "SUCCESS"
        assert run(line, signals={"front": ["1 m", "60 cm"], "heat": "31 K"}).outcome == "FAILURE"
        assert run(line, signals={"heat": "31 K"}).reason.endswith("min(front) = invalid, heat = 31 K")

    def test_what_is_known(self):
        known = {"dock": (1.0, 2.0), "crate": {"kind": "object", "pose": (0.0, 0.0), "radius": 0.4}}
        trace = run('<Sequence><Known node="dock" attribute="pose"/><Known node="crate"/></Sequence>', knowledge=known)
        assert trace.outcome == "SUCCESS"
        assert trace.knowledge.world.goals() == ["dock"]
        trace = run('<Known node="x"/>', knowledge=lambda k: k.graph.add("x", "object"))
        assert trace.outcome == "SUCCESS"

    def test_something_happens_before_a_tick(self):
        trace = run(
            '<WaitForChange kind="goal"/>',
            then={3: lambda mission: mission.knowledge.world.place("g", Pose2(1.0, 0.0), kind="goal")},
        )
        assert trace["WaitForChange"] == "R R S"

    def test_time_is_that_of_a_clock_that_nothing_else_moves(self):
        trace = run('<Sleep msec="250"/>', step=0.1)
        assert trace.times == pytest.approx((0.0, 0.1, 0.2, 0.3))
        assert run('<Sleep msec="250"/>', step=0.5).times == (0.0, 0.5)

    def test_what_it_says_is_kept(self):
        trace = run('<Sequence><Speak text="hello"/><Log text="n" value="{n}"/></Sequence>', board={"n": 1})
        assert trace.said == ("hello", "n 1")

    def test_settling_goes_on_at_once(self):
        body = '<Repeat num_cycles="3"><AlwaysSuccess/></Repeat>'
        assert run(body).ticks == 3
        assert run(body, settle=True).ticks == 1


class TestTrace:
    BODY = (
        '<ReactiveSequence><When name="clear" expression="front > 1 m"/>'
        '<Sequence name="way"><GoTo name="leg" goal="a"/><GoTo name="leg" goal="b"/></Sequence></ReactiveSequence>'
    )

    def trace(self):
        return run(
            self.BODY,
            leaves={"leg": "R"},
            signals={"front": "2 m"},
            then={3: lambda mission: mission.knowledge.signals.write("front", [0.5], mission.clock.now())},
        )

    def test_halts_are_seen(self):
        trace = self.trace()
        assert trace["clear"] == "S S F"
        assert trace["way"] == "R R H"
        assert trace["ReactiveSequence/way/leg"] == "R R H"
        assert trace["ReactiveSequence/way/leg#2"] == ". . ."

    def test_a_name_that_two_have_and_one_that_none_has(self):
        trace = run(
            '<Sequence><Sequence name="a"><AlwaysSuccess name="x"/></Sequence><AlwaysSuccess name="x"/></Sequence>'
        )
        with pytest.raises(InputError, match=r"2 nodes are named 'x'.*Sequence/a/x, Sequence/x"):
            trace["x"]
        with pytest.raises(InputError, match="no node is named 'y'"):
            trace["y"]

    def test_it_is_drawn(self):
        assert str(self.trace()).splitlines() == [
            "ReactiveSequence                         R R F",
            "  clear                                  S S F",
            "  way                                    R R H",
            "    leg                                  R R H",
            "    leg#2                                . . .",
            "FAILURE after 3 ticks: 'front > 1 m' does not hold: front = 0.5 m",
        ]
