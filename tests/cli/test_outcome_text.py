"""The lines that a run prints at its end: short for many robots, with the moment to ask about."""

import re

import msgspec
import pytest

from rocs_bt.cli.outcome import outcome_text
from rocs_bt.event import AgentStopped, ContactBegan, RuleChanged
from rocs_bt.record.file.header import AgentInfo, RunHeader
from rocs_bt.record.file.recorder import Recorder
from tests import synthetic


def summary(outcomes: dict[str, str], factor: float = 64.5, sim_time: float = 20.0):
    made = synthetic.summary()
    agents = {
        name: msgspec.structs.replace(made.agents["R2"], outcome=outcome, reason="" if outcome == "success" else "why")
        for name, outcome in outcomes.items()
    }
    return msgspec.structs.replace(made, agents=agents, real_time_factor=factor, sim_time=sim_time)


def fired(t, agent):
    return RuleChanged(t=t, agent=agent, rule="r/Flinch", phase="fired", priority=1)


def suggested(folder, outcomes, events):
    agents = tuple(AgentInfo(name=name, robot="r", mission="m") for name in outcomes)
    recorder = Recorder(folder / "run.mcap", RunHeader(scenario="x", seed=1, agents=agents))
    for event in events:
        recorder.emit(event)
    recorder.close()
    text = outcome_text(summary(outcomes), folder, None)
    return re.search(r"--why (\S+(?: --agent \S+)?)   or", text)[1]


@pytest.mark.parametrize(
    ("outcomes", "events", "moment"),
    [
        ({"A": "success"}, [], "5.0"),
        ({"A": "success"}, [fired(3.25, "A"), fired(4.0, "A")], "3.25"),
        ({"A": "success", "B": "success"}, [fired(3.25, "B")], "3.25 --agent B"),
        ({"A": "timeout"}, [fired(3.25, "A"), AgentStopped(t=20.4, agent="A", by="end")], "20.39"),
        ({"A": "success", "B": "failed"}, [AgentStopped(t=t, agent=a, by="x") for t, a in ((9.0, "A"), (12.02, "B"))],
         "12.01 --agent B"),
        ({"A": "collision"}, [ContactBegan(t=7.5, agent="A", other="box", kind="struck"),
                              ContactBegan(t=8.5, agent="A", other="box", kind="collision"),
                              AgentStopped(t=20.0, agent="A", by="end")], "8.49"),
    ],
)  # fmt: skip  # a case begins on its own line
def test_try_next_names_the_moment_of_the_failure_or_of_the_first_reflex(tmp_path, outcomes, events, moment):
    assert suggested(tmp_path, outcomes, events) == moment


def test_many_robots_have_one_line_each(tmp_path):
    outcomes = {f"R{i}": "success" if i % 3 else "timeout" for i in range(20)}
    text = outcome_text(summary(outcomes, factor=0.31), tmp_path, None)
    lines = re.sub("\x00[^\x00]*\x00", "", text).splitlines()  # without marks of colours
    assert len(lines) == 22
    assert "20 agents: 13 success, 7 timeout" in lines[0]
    assert "(0.31 times real time)" in lines[0]
    assert [line.split()[0] for line in lines[1:21]] == list(outcomes)
    assert "R0 timeout in 12.3 s (moved 3.10 m, 2 reflexes): why" in lines[1]


@pytest.mark.parametrize(("factor", "words"), [(0.004, "0.004"), (0.31, "0.31"), (3.4, "3"), (64.5, "64")])
def test_a_run_slower_than_real_time_does_not_take_0_times_real_time(tmp_path, factor, words):
    assert f"({words} times real time)" in outcome_text(summary({"A": "success"}, factor=factor), tmp_path, None)


def test_what_a_reflex_interrupted_is_counted_in_words_that_say_what_is_counted(tmp_path):
    assert "2 actions resumed after a reflex" in outcome_text(summary({"A": "success"}), tmp_path, None)
