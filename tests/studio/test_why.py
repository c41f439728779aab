"""Why, and why not: the page gives the answers of the command line, at any time."""

import base64
import random
import re

import msgspec
import numpy as np
import pytest

from rocs_bt import run
from rocs_bt.event import (
    AgentStopped,
    BlockFailed,
    BodyMoved,
    GuardInfo,
    MotionHeld,
    MotionReleased,
    NodeTicked,
    RobotPushed,
    SubtreeSwapped,
    TicketChanged,
    TreeNode,
)
from rocs_bt.expression import evaluate, parse
from rocs_bt.record import AgentInfo, Recording, RunHeader, environment_of, samples
from rocs_bt.record.explanation.why import Why
from rocs_bt.record.explanation.why_not import why_not
from rocs_bt.record.file.recorder import Recorder
from rocs_bt.record.fold.states import GuardState, RuleState
from rocs_bt.record.fold.tracks import Tracks
from rocs_bt.studio.pack import pack
from rocs_bt.studio.page import bundle
from rocs_bt.studio.report import render_report

NAN, INF = float("nan"), float("inf")
FALL = {"agent": "R2", "body": "R2", "x": 0.0, "y": 0.0, "yaw": 0.0, "height": 0.1, "pitch": 0.0}
TRIED = (
    TreeNode(path="try", type="RetryUntilSuccessful", children=("GoTo goal",)),
    TreeNode(path="GoTo goal", type="Act"),
)
HARM = [
    SubtreeSwapped(t=0.3, agent="R2", node="GoTo goal", by="try", nodes=TRIED),
    NodeTicked(t=0.3, agent="R2", node="try", status="RUNNING", feedback="attempt 1/3"),
    RobotPushed(t=1.02, agent="R2", body="R2", force=(0.0, 33.3, 1.0), duration=0.125),
    MotionHeld(t=2.6, agent="R2", actuator="wheels", reason="emergency stop"),
    MotionReleased(t=3.0, agent="R2", actuator="wheels"),
    BodyMoved(t=3.4, roll=0.9, **FALL),
    BodyMoved(t=3.6, roll=1.57, **FALL),
    BodyMoved(t=3.8, roll=0.0, **FALL),
    BlockFailed(t=4.2, agent="R2", block="plan", kind="raised", detail="KeyError: 3\nand more"),
    AgentStopped(t=4.3, agent="R2", by="its failure"),
]
TURNS = [
    TicketChanged(t=1.9 + 0.06 * k, agent="R2", ticket=90 + k, action="Flinch", priority="HIGH", state=state, by=by)
    for k, by in enumerate(["late/TurnAway", "late/Flinch"] * 5)
    for state in ("RUNNING", "CANCELLED")
]


@pytest.fixture(scope="module", params=[("exp1", 6.0), ("exp3", 6.0), ("exp1_quadruped", 4.0), ("harm", 5.0)])
def recorded(request, tmp_path_factory):
    name, duration = request.param
    out = tmp_path_factory.mktemp(name)
    run("exp1" if name == "harm" else name, seed=1, duration=duration, out=out, report=False)
    found = Recording.open(out)
    if name != "harm":
        return found
    recorder = Recorder(out / "harm.mcap", found.header)
    whole = [e for e in found.events() if e.t < 4.3 and not isinstance(e, AgentStopped)]
    for event in sorted([*whole, *HARM, *TURNS], key=lambda e: e.t):
        recorder.emit(event)
    recorder.close()
    return Recording.open(recorder.path)


@pytest.fixture(scope="module")
def tracks(recorded):
    return Tracks.of_recording(recorded)


@pytest.fixture(scope="module")
def page(recorded, browser):
    """A browser with the modules of the page and the data of the report."""
    report = render_report(recorded, recorded.summary)
    data = re.search(r'id="data">([^<]*)<', report)[1]
    script = f"{bundle('why.js')}\n{bundle('run.js')}\nwindow.$why = $why; return $run.Run.from('{data}');"
    browser.evaluate(f"(async () => {{ {script} }})().then((found) => {{ window.found = found; }})")
    return browser


def times(tracks, count=60):
    chosen = random.Random(7)
    return [*(chosen.uniform(0.0, tracks.end) for _ in range(count)), *np.arange(0.0, tracks.end, 0.25).tolist()]


def test_the_page_says_why_with_the_words_of_the_command_line(tracks, page):
    for agent in (a.name for a in tracks.header.agents):
        at = times(tracks)
        found = page.evaluate(f"{at}.map((t) => $why.why(found, '{agent}', t))")
        assert found == [Why(tracks, t, agent).answer for t in at]
        counted = any("attempt 1/3" in note.v for note in tracks.of(agent, "note").values())
        assert any("(attempt 1/3)" in text for text in found) == counted
        alternate = any("alternate" in text for text in found)
        assert alternate == (tracks.get(agent, "alternation") is not None)


def test_the_text_of_the_command_line_is_short_and_its_numbers_are_too(tracks):
    for agent in (a.name for a in tracks.header.agents):
        for why in (Why(tracks, t, agent) for t in times(tracks)):
            answer, title, evidence = str(why).partition("\nEvidence at ")
            assert (answer, bool(title), evidence.count("\n") <= 10) == (why.answer, True, True)
            text = "\n".join(line for line in f"{answer}\n{evidence}".split("\n") if not line.startswith("true pose"))
            numbers = re.findall(r"\d+\.\d+(?! s)\b", re.sub(r"t ?= ?\d+\.\d+|\d+\.\d+ s\b", "", text))
            assert [each for each in numbers if len(each.replace(".", "").lstrip("0")) > 3] == [], text


def parts(text):
    """Words and numbers of a text; numbers are rounded on the page."""
    number = r"-?\d+\.?\d*(?:e[+-]\d+)?|inf|nan"
    return re.sub(number, "#", text), [float(n) for n in re.findall(number, text)]


def test_the_page_says_why_a_rule_did_not_fire(tracks, page):
    for agent in tracks.header.agents:
        at = times(tracks, 20)
        for rule in (guard.rule for guard in agent.guards):
            found = page.evaluate(f"{at}.map((t) => $why.whyNot(found, '{agent.name}', '{rule}', t).because)")
            for t, text in zip(at, found, strict=True):
                (words, given), (said, shown) = parts(why_not(tracks, t, agent.name, rule).because), parts(text)
                assert words == said, (rule, t)
                assert np.allclose(given, shown, rtol=0.02, atol=0.002), (rule, t)


def test_what_held_a_rule_back_makes_its_guard_true_and_nothing_less_does(tracks):
    seen = 0
    for agent in tracks.header.agents:
        environment = environment_of(agent)
        period, x = samples(tracks, agent)
        for guard in agent.guards:
            tree = parse(guard.sources[0], environment)
            for i in range(0, len(period), 7):
                answer = why_not(tracks, period[i], agent.name, guard.rule)
                if tree.temporal or answer.because.startswith(("it ", "the ")):
                    continue
                truth = evaluate(tree, x[i].tolist())
                if answer.because.startswith("its guard"):
                    assert truth is True or (truth is None and "cannot be evaluated" in answer.because)
                    continue
                assert bool(answer.held) == (truth is not True), (guard.rule, period[i])
                seen += len(answer.held)
                for held in answer.held:
                    assert held.text in guard.comparisons
    assert seen


SIDES = [
    ({"held": [0]}, (2.0, 1.0, 0.0), "'y < 1 m' does not hold by 1 m (2 against 1 m)"),
    ({"held": [0]}, (4.0, 1.0, 0.0), "'y < 1 m' does not hold by 3 m (4 against 1 m; 4 m is the maximum)"),
    ({"held": [0]}, (4.0004, 1.0, 0.0), "'y < 1 m' does not hold by 3 m (4 against 1 m; 4 m is the maximum)"),
    ({"held": [-1]}, (0.5, 1.0, 1.0), "'y < 1 m' must not hold, but holds by 0.5 m (0.5 against 1 m)"),
    ({"held": [0]}, (NAN, 1.0, NAN), "'y < 1 m' is not decided, because a value is not known"),
    ({"held": [0]}, (NAN, NAN, 0.0), "'y < 1 m' does not hold"),
    ({"held": [0]}, (INF, 1.0, 0.0), "'y < 1 m' does not hold (inf against 1 m)"),
    ({"mode": "drive"}, (), "it acts in mode 'dock' or 'park' only, and the mode is 'drive'"),
    ({"since": 9.877}, (), "its guard has held for 0.12 s of the 0.3 s that it must"),
    ({"since": 9.0, "ready": 10.4}, (), "its cooldown ends in 0.40 s"),
    (
        {"since": 9.9, "ready": 10.4},
        (),
        "its guard has held for 0.10 s of the 0.3 s that it must and its cooldown ends in 0.40 s",
    ),
    ({"since": 9.0}, (), "its guard holds"),
    ({"since": 9.0, "blind": True}, (), "its guard cannot be evaluated, which counts as true"),
    ({}, (), "nothing that it compares can make its guard true"),
    ({"replaced": True}, (), "its rule file was replaced, and the new one does not have it"),
]
GUARD = GuardInfo(
    rule="f/R",
    when="y < 1 m",
    sources=("y < 1 m",),
    comparisons=("y < 1 m",),
    units=("m",),
    hold=0.3,
    cooldown=1.0,
    modes=("dock", "park"),
    limits=((4.0, "4 m is the maximum"),),
)


@pytest.mark.parametrize(("state", "row", "said"), SIDES)
def test_what_keeps_a_rule_back_is_said_by_both_with_its_numbers(browser, state, row, said):
    tracks = Tracks(
        RunHeader(scenario="s", seed=0, agents=(AgentInfo(name="a", robot="", mission="", guards=(GUARD,)),))
    )
    tracks.end = 10.0
    tracks.begun("a", "guard", "f/R").put(1.0, GuardState(**state))
    if row:
        tracks.samples("a", "compare", "f/R\n0", 3).extend([1.0], np.array([row]))
    both_say(browser, tracks, said)


def test_only_blind_has_a_guard_that_can_never_hold(recorded):
    guards = [guard for agent in recorded.header.agents for guard in agent.guards]
    assert {guard.rule.rpartition("/")[2] for guard in guards if guard.only_invalid} == {"Blind"}
    assert all(len(guard.units) == len(guard.comparisons) > 0 for guard in guards)


def test_a_header_without_the_units_of_comparisons_is_refused():
    agent = AgentInfo(name="a", robot="", mission="", guards=(msgspec.structs.replace(GUARD, units=()),))
    with pytest.raises(ValueError, match="the comparisons of 'f/R' do not have one unit each"):
        RunHeader(scenario="s", seed=0, agents=(agent,)).check()


WAITS = [
    (RuleState(waits=True, latched=True), 5, "it is latched and waits for another rule"),
    (RuleState(waits=True, behind="f/S"), 5, "it is latched and waits for S"),
    (RuleState(waits=True, behind="f/S"), 6, "it is latched and waits for S, which has a higher priority"),
    (
        RuleState(waits=True, behind="f/S", firing=(0.754, "fired", "")),
        6,
        "it is latched, fired last at t = 0.75 s, and waits for S, which has a higher priority",
    ),
]


@pytest.mark.parametrize(("state", "above", "said"), WAITS)
def test_a_rule_that_waits_says_for_which_and_why(browser, state, above, said):
    guards = (msgspec.structs.replace(GUARD, priority=5), msgspec.structs.replace(GUARD, rule="f/S", priority=above))
    tracks = Tracks(RunHeader(scenario="s", seed=0, agents=(AgentInfo(name="a", robot="", mission="", guards=guards),)))
    tracks.end = 10.0
    tracks.begun("a", "rule", "f/R").put(1.0, state)
    both_say(browser, tracks, said)


def test_a_guard_that_can_never_hold_says_that_only_invalid_signals_make_its_rule_fire(browser):
    guards = (msgspec.structs.replace(GUARD, only_invalid=True),)
    tracks = Tracks(RunHeader(scenario="s", seed=0, agents=(AgentInfo(name="a", robot="", mission="", guards=guards),)))
    tracks.end = 10.0
    tracks.begun("a", "guard", "f/R").put(1.0, GuardState(held=(0,)))
    tracks.samples("a", "compare", "f/R\n0", 3).extend([1.0], np.array([(2.0, 1.0, 0.0)]))
    said = "'y < 1 m' does not hold by 1 m (2 against 1 m); it fires only when its signals are invalid"
    both_say(browser, tracks, said)


def both_say(browser, tracks, said):
    """The command line and the page answer alike to why a rule did not fire."""
    assert why_not(tracks, 10.0, "a", "f/R").because == said
    data = base64.b64encode(pack(tracks, {})).decode()
    ask = "then((r) => $why.whyNot(r, 'a', 'f/R', 10))"
    script = f"{bundle('why.js')}\n{bundle('run.js')}\nreturn $run.Run.from('{data}').{ask};"
    assert browser.evaluate(f"(() => {{ {script} }})()")["because"] == said
