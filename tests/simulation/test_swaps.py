"""Swaps of a run: subtrees of missions that XML missions replace at a time, asked for before the run."""

from __future__ import annotations

import json

import pytest

from rocs_bt import run
from rocs_bt.agent import Agent
from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import InputError, RecordingError
from rocs_bt.catalog import Catalog
from rocs_bt.cli.main import call
from rocs_bt.event import ListSink, SubtreeSwapped, SwapRefused, TicketChanged
from rocs_bt.record import Recording, SubtreeSwap, explain
from rocs_bt.running import RunOptions, replay
from rocs_bt.running.swaps import rehearse_swaps

from ..pages import log_of


def document(body, ports="", name="new", models=True):
    model = f'<TreeNodesModel><SubTree ID="{name}">{ports}</SubTree></TreeNodesModel>' if models else ""
    return (
        f'<root BTCPP_format="4" main_tree_to_execute="{name}">\n'
        f'<BehaviorTree ID="{name}">{body}</BehaviorTree>\n{model}</root>'
    )


SLOW = document(
    '<Sequence name="slowly"><GoTo goal="{place}" cruise="{slow}"/></Sequence>',
    '<input_port name="place"/><input_port name="slow" type="m/s" default="0.1 m/s"/>',
)

PLACE = '<input_port name="place" type="{}"/>'
COUNT = '<Sequence><Ask query="place" count="{{k}}"/>{}</Sequence>'


@pytest.fixture
def write(tmp_path):
    def write(name, content):
        file = tmp_path / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(content, encoding="utf-8")
        return str(file)

    return write


def rounds(**options):
    """R2's events in the first seconds of `rounds`, and the result."""
    sink = ListSink()
    result = run("rounds", Catalog(), seed=1, duration=2.0, report=False, sinks=[sink], **options)
    return [e for e in sink.events if e.agent == "R2"], result


class TestRun:
    def test_the_new_tree_takes_over_at_its_time_with_the_board_of_its_place(self, write):
        events, result = rounds(swaps=[SubtreeSwap("visit first", write("slow.xml", SLOW), 1.0)])
        (swap,) = [e for e in events if isinstance(e, SubtreeSwapped)]
        place = "Repeat/one round/visit first"
        assert (swap.t, swap.node, swap.by) == (1.0, f"{place}/Sequence", f"{place}/slowly")
        tickets = [(e.t, e.parameters["cruise"], e.state) for e in events if isinstance(e, TicketChanged)]
        assert tickets[2:5] == [(1.0, 0.4, "CANCELLED"), (1.0, 0.1, "QUEUED"), (1.0, 0.1, "RUNNING")]
        assert {e.parameters["goal"] for e in events if isinstance(e, TicketChanged)} == {"west"}
        assert result.summary.agents["R2"].path_length < 0.7

    def test_a_replay_makes_it_too_and_the_file_counts_as_content(self, write, tmp_path):
        file = write("slow.xml", SLOW)
        _, result = rounds(swaps=[SubtreeSwap("visit first", file, 1.0)], out=tmp_path / "run")
        recording = Recording.open(result.recording)
        assert recording.header.swaps == (SubtreeSwap("R2:visit first", file, 1.0),)
        assert "--swap 'R2:visit first=" in recording.header.command
        assert replay(recording, Catalog()) is None
        assert "SubtreeSwapped" in explain(recording, 1.0, "R2").text(everything=True)
        assert call(["report", str(tmp_path / "run")]) == 0
        (swap,) = [e for e in recording.events() if isinstance(e, SubtreeSwapped)]
        assert swap.sentence in log_of(tmp_path / "run/report.html")
        write("slow.xml", SLOW.replace("0.1 m/s", "0.3 m/s"))
        with pytest.raises(RecordingError, match="the content of 'rounds' has changed"):
            replay(recording, Catalog())
        difference = replay(recording, Catalog(), changed_content=True)
        assert difference is not None
        assert difference.t == pytest.approx(1.0, abs=0.06)

    def test_a_swap_by_an_equal_tree_that_has_not_been_ticked_changes_no_motion(self):
        _, plain = rounds()
        _, swapped = rounds(swaps=[SubtreeSwap("visit second", "rounds", 0.5, "visit")])
        assert swapped.summary.trajectory_hash == plain.summary.trajectory_hash

    def test_a_swap_at_the_start_is_before_the_first_tick(self, write):
        events, _ = rounds(swaps=[SubtreeSwap("visit first", write("slow.xml", SLOW), 0.0)])
        assert {e.parameters["cruise"] for e in events if isinstance(e, TicketChanged)} == {0.1}

    def test_a_later_swap_may_name_a_node_of_an_earlier_one(self, write):
        stop = write("stop.xml", document('<Sleep name="stop" msec="60000"/>', models=False))
        swaps = [SubtreeSwap("slowly", stop, 1.5), SubtreeSwap("visit first", write("slow.xml", SLOW), 1.0)]
        events, _ = rounds(swaps=swaps)
        assert [(e.t, e.by.rpartition("/")[2]) for e in events if isinstance(e, SubtreeSwapped)] == [
            (1.0, "slowly"),
            (1.5, "stop"),
        ]

    def test_threads_make_it_between_two_ticks(self, write):
        swap = SubtreeSwap("visit first", write("slow.xml", SLOW), 0.3)
        sink = ListSink()
        run("rounds", Catalog(), mode="threaded", duration=0.9, report=False, sinks=[sink], swaps=[swap])
        assert [e.by.rpartition("/")[2] for e in sink.events if isinstance(e, SubtreeSwapped)] == ["slowly"]


class TestRefused:
    """What does not fit is refused before the run starts."""

    @pytest.fixture
    def tried(self):
        catalog = Catalog()
        scenario = catalog.load_scenario("rounds")
        return lambda *swaps, spec=scenario: rehearse_swaps(swaps, spec, catalog, seed=1, duration=10.0)

    @pytest.mark.parametrize(
        ("node", "message"),
        [
            ("visit frist", r"no node is named 'visit frist'\. Did you mean 'visit first'"),
            ("R2:visit frist", r"no node is named 'visit frist'\. Did you mean 'visit first'"),
            ("Sequence", r"2 nodes are named 'Sequence': .*visit first/Sequence.*Give the path"),
            ("R9:visit first", r"no node is named 'R9:visit first'"),
            ("", r"no node is named ''"),
        ],
    )
    def test_nodes(self, tried, write, node, message):
        with pytest.raises(InputError, match=message):
            tried(SubtreeSwap(node, write("slow.xml", SLOW), 1.0))

    @pytest.mark.parametrize("at", [10.0, 1e9, -0.1, float("nan"), float("inf")])
    def test_times(self, tried, write, at):
        with pytest.raises(InputError, match=r"is not within the run, which is from 0 s to 10 s"):
            tried(SubtreeSwap("visit first", write("slow.xml", SLOW), at))

    @pytest.mark.parametrize(
        ("text", "message"),
        [
            ("<root", r"new\.xml:1:\d+: "),
            (document("<Nope/>"), r"new\.xml:2:24: .*no node is named 'Nope'"),
            (document('<GoTo goal="west" cruise="fast"/>'), r"new\.xml:2:\d+: .*'fast' is not a quantity"),
            (document("<Sequence/>"), r"new\.xml:2:\d+: "),
            (document("<AlwaysSuccess/>", '<input_port name="gaol"/>'), r"xml:3:\d+: .*needs 'gaol'.* It has: .*place"),
            (
                document("<AlwaysSuccess/>", PLACE.format("int")),
                r"xml:3:\d+: .*the port 'place'.*'west' is not a whole",
            ),
            (
                document("<AlwaysSuccess/>", PLACE.format("m/s")),
                r"xml:3:\d+: .*place.*: 'west' is no.* quantity",
            ),
            (document(COUNT.format('<Ask query="place" names="{k}"/>')), r"xml:2:\d+: .*'k' is of type int, not list"),
            (document(COUNT.format("<Script code=\"k := 'many'\"/>")), r"xml:2:\d+: .*the key 'k' is a number"),
        ],
    )
    def test_files(self, tried, write, text, message):
        with pytest.raises(InputError, match=message):
            tried(SubtreeSwap("visit first", write("new.xml", text), 1.0))

    def test_trees_and_missions_that_do_not_exist(self, tried, write):
        with pytest.raises(InputError, match=r"slow\.xml:1:1: no tree is named 'old'. The document has: new"):
            tried(SubtreeSwap("visit first", write("slow.xml", SLOW), 1.0, "old"))
        with pytest.raises(InputError, match=r"no mission is named 'roundz'\. Did you mean 'rounds'"):
            tried(SubtreeSwap("visit first", "roundz", 1.0))
        with pytest.raises(InputError, match="'corners' is no mission in XML"):
            tried(SubtreeSwap("visit first", "corners", 1.0))

    def test_several_agents(self, write):
        catalog = Catalog()
        scenario = catalog.load_scenario("exp3")
        file = write("new.xml", document("<AlwaysSuccess/>", models=False))
        with pytest.raises(InputError, match=r"no node is named 'nowhere'\. The run has: .*FollowRobot"):
            rehearse_swaps([SubtreeSwap("nowhere", file, 1.0)], scenario, catalog, seed=1, duration=10.0)
        swaps = [SubtreeSwap("R3:FollowRobot", file, 1.0), SubtreeSwap("R2:GoTo corner_1", file, 2.0)]
        assert rehearse_swaps(swaps, scenario, catalog, seed=1, duration=10.0) == tuple(swaps)

    def test_hardware(self):
        with pytest.raises(InputError, match="remove the option swaps"):
            RunOptions(swaps=[SubtreeSwap("a", "b.xml", 1.0)]).refuse_other("hardware")


class TestProject:
    """A mission whose keys get their types in the run."""

    @pytest.fixture
    def project(self, write, tmp_path):
        write("scenarios/job.toml", JOB)
        write("planners/nodes/word.py", WORD)
        return tmp_path

    def run(self, project, body, new, at, write, capsys):
        write("planners/missions/work.xml", document(body, PORTS, "work"))
        swap = f"job={write('new.xml', new)}@{at}"
        scenario, out = str(project / "scenarios/job.toml"), str(project / "run")
        call(["run", scenario, "--swap", swap, "--for", "1", "--out", out, "--no-report"])
        return capsys.readouterr().err

    def test_a_key_whose_type_the_run_has_fixed_refuses_the_new_tree(self, project, write, capsys):
        body = '<Sequence><Put/><Sleep name="job" msec="60000"/></Sequence>'
        new = document('<Word number="{n}"/>', models=False)
        err = self.run(project, body, new, "500 ms", write, capsys)
        assert "0.50 s, R2: 'job' was not replaced: " in err
        assert "the key 'n' is of type" in err
        recording = Recording.open(project / "run")
        assert replay(recording, Catalog(project)) is None
        events = list(recording.events())
        assert [e.node for e in events if isinstance(e, SwapRefused)] == ["job"]

    def test_a_swap_after_the_end_of_the_run_is_named(self, project, write, capsys):
        new = document("<AlwaysSuccess/>", models=False)
        err = self.run(project, '<AlwaysFailure name="job"/>', new, 0.9, write, capsys)
        assert "new.xml@0.9' was not made, because the run had ended." in err
        assert json.loads((project / "run/summary.json").read_text("utf-8"))["sim_time"] < 0.9


JOB = """format = "scenario/2"
base = "rounds"
[[agent]]
name = "R2"
mission = "work"
"""

WORD = """from rocs_bt.trees.nodes import SUCCESS, Instant

class Put(Instant):
    def update(self):
        self.board["n"] = [7.0]
        return SUCCESS

class Word(Instant):
    number: int

    def update(self):
        return SUCCESS
"""

PORTS = """<input_port name="first" default="a"/><input_port name="second" default="b"/>
<input_port name="rounds" type="int" default="1"/><input_port name="cruise" type="m/s" default="0.1 m/s"/>
<input_port name="rest" type="int" default="1"/>"""


@pytest.mark.parametrize(
    ("text", "swap"),
    [
        ("care=careful.xml@12", SubtreeSwap("care", "careful.xml", 12.0)),
        ("a >= b=x/y.xml:T@0.5", SubtreeSwap("a >= b", "x/y.xml", 0.5, "T")),
        ("R2:a/b#2=rounds:visit@1 min", SubtreeSwap("R2:a/b#2", "rounds", 60.0, "visit")),
        ("me@home=a.xml@500 ms", SubtreeSwap("me@home", "a.xml", 0.5)),
    ],
)
def test_its_text(text, swap):
    assert SubtreeSwap.read(text) == swap
    assert SubtreeSwap.read(str(swap)) == swap


@pytest.mark.parametrize("text", ["", "a", "a=b", "a@1", "=b@1", "a=@1", "a=:t@1", "a=b@", "a=b@soon", "a=b@1 m"])
def test_no_text_of_a_swap(text):
    with pytest.raises(InputError, match=r"Write NODE=FILE@TIME|must be a quantity in s"):
        SubtreeSwap.read(text)


def test_an_agent_swaps_between_two_turns_of_its_plan_only(make_turning_agent):
    agent, told = make_turning_agent
    agent.decide(0.0)
    assert told == [False]
    assert agent.swap("outer", agent.plan.load(document("<AlwaysSuccess/>", models=False))) is True
    assert agent.plan.root.name == "AlwaysSuccess"
    agent.stop()
    assert agent.swap("AlwaysSuccess", agent.plan.load(document("<AlwaysFailure/>", models=False))) is True
    assert agent.plan.root.name == "AlwaysSuccess"


@pytest.fixture
def make_turning_agent():
    """An agent with a leaf that tries to swap during its own tick, and what it was told."""
    from py_trees.behaviour import Behaviour
    from py_trees.common import Status
    from py_trees.composites import Sequence

    from rocs_bt.agent import AgentRuntime, Controller
    from rocs_bt.testing.mock_agent import mock_agent

    told = []

    class Rash(Behaviour):
        def update(self):
            told.append(agent.swap("outer", None))
            return Status.RUNNING

    def build(mission):
        return Sequence("outer", memory=True, children=[Rash("rash")])

    runtime = AgentRuntime(SimulatedClock(0.05), ListSink())
    agent: Agent = mock_agent(Catalog().load_robot("pioneer_p3dx"), Controller(build), runtime)[0]
    return agent, told
