"""Two rules or actions that alternate without progress, against a count by brute force."""

import numpy as np
import pytest

import rocs_bt
from rocs_bt.catalog import Catalog
from rocs_bt.event import BodyMoved, OutcomeDecided, TicketChanged
from rocs_bt.record import Recording
from rocs_bt.record.explanation.why import Why
from rocs_bt.record.file.header import AgentInfo, RunHeader
from rocs_bt.record.fold.alternation import ALTERNATING, NEAR, SHARE, livelock
from rocs_bt.record.fold.tracks import Tracks

HEADER = RunHeader(scenario="x", seed=1, agents=(AgentInfo(name="R", robot="r", mission="m"),))
NAMES = ("f/A", "f/B", "GoTo", "Wait")


def ticket(t, number, name, state="RUNNING"):
    reflex = "/" in name
    by, action = (name, "Flinch") if reflex else ("m/leaf", name)
    priority = "HIGH" if reflex else "NORMAL"
    return TicketChanged(t=t, agent="R", ticket=number, action=action, priority=priority, state=state, by=by)


def folded(events):
    tracks = Tracks(HEADER)
    tracks.take(sorted(events, key=lambda event: event.t))
    return tracks


def moves(path):
    return [BodyMoved(t=t, agent="R", body="R", x=x, y=y, yaw=0.0) for t, x, y in path]


def played(seed):
    """Random tickets and a random path that lingers, so that there is progress and none."""
    random = np.random.default_rng(seed)
    path = np.cumsum(random.normal(0.0, random.choice([0.02, 0.08]), (200, 2)), axis=0)
    poses = [(0.1 * k, *xy) for k, xy in enumerate(path.tolist())]
    pair = random.choice(NAMES, 2, replace=False)
    names = [random.choice(NAMES) if random.random() < 0.08 else pair[k % 2] for k in range(40)]
    runs = [(round(0.013 + 0.47 * k, 3), k + 1, str(name)) for k, name in enumerate(names)]
    ends = [(t + 0.3, k, name) for t, k, name in runs if random.random() < 0.05]
    events = [ticket(*run) for run in runs] + [ticket(*end, "SUCCEEDED") for end in ends]
    return events + moves(poses), poses, runs, ends


def brute(poses, runs, ends, t):
    """Begin, changes and distance of the longest alternation that ends with the last change until a time."""
    turns = []
    for begin, number, name in (run for run in runs if run[0] <= t):
        if turns and turns[-1][1] == name:
            turns[-1][2].append(number)
        else:
            turns.append((begin, name, [number]))
    now = max(run[0] for run in runs if run[0] <= t)
    done = {number for at, number, _ in ends if at <= t}
    for i in range(len(turns)):
        window = turns[i:]
        here = max(k for k, pose in enumerate(poses) if pose[0] <= window[0][0])
        there = [pose for pose in poses[here:] if pose[0] < now]
        moved = max(np.hypot(x - poses[here][1], y - poses[here][2]) for _, x, y in there)
        if len({name for _, name, _ in window}) > 2 or moved > NEAR:
            continue
        plan = {name for _, name, _ in window if "/" not in name}
        well = {name for _, name, numbers in window if "/" not in name and done & set(numbers)}
        if len(window) > ALTERNATING and (not plan or plan - well):
            return window[0][0], len(window) - 1, window[-1][0]
        return None
    return None


def test_it_is_what_a_count_by_brute_force_finds():
    seen = 0
    for seed in range(12):
        events, poses, runs, ends = played(seed)
        track = folded(events).get("R", "alternation")
        for t in sorted(each[0] for each in (*runs, *ends)):
            found = track.at(t) if track else None
            expected = brute(poses, runs, ends, t)
            assert (found and (found.begin, found.changes, found.last)) == expected, (seed, t)
            seen += expected is not None
    assert seen > 100


def alternating(count, step=0.0, names=("f/A", "GoTo"), state="CANCELLED"):
    """Events of a run of `count` turns of 1 s each; the robot moves by `step` in each [m]."""
    events = [ticket(0.5 + k, k, names[k % 2]) for k in range(count)]
    events += [ticket(1.4 + k, k, names[k % 2], state) for k in range(count)]
    return events + moves([(0.1 * k, 0.1 * step * k, 0.0) for k in range(10 * count + 10)])


@pytest.mark.parametrize(
    ("events", "claimed"),
    [
        (alternating(20), True),
        (alternating(6), False),  # five changes
        (alternating(20, step=0.2), False),  # slow progress
        (alternating(20, names=("GoTo", "Wait"), state="SUCCEEDED"), False),  # a mission that repeats
        (alternating(20, names=("GoTo", "Wait"), state="FAILED"), True),
        (alternating(20, names=("f/A", "Wait"), state="SUCCEEDED"), False),  # the plan gets on
        (alternating(20, names=("f/A", "f/B"), state="SUCCEEDED"), True),  # reflexes always succeed
        ([event for event in alternating(20) if not isinstance(event, BodyMoved)], False),  # no pose
    ],
)
def test_nothing_is_claimed_of_a_robot_that_gets_on(events, claimed):
    tracks = folded(events)
    found = livelock(tracks.steps("R", "alternation"), OutcomeDecided(t=20.5, agent="R", outcome="timeout"), 0.0)
    assert (found is not None) == claimed
    assert ("alternate 19 times" in Why(tracks, min(20.0, tracks.end)).answer) == claimed


@pytest.mark.parametrize(
    ("outcome", "t", "explained"),
    [
        ("timeout", 20.0, True),
        ("timeout", 18.5 / SHARE, True),
        ("timeout", 20.0 / SHARE, False),  # less than a quarter of the time
        ("failed", 20.0, True),
        ("failed", 22.0, False),  # something else came after it
        ("stuck", 20.0, True),
        ("collision", 20.0, False),
        ("success", 20.0, False),
    ],
)
def test_it_explains_an_end_that_it_caused(outcome, t, explained):
    track = folded(alternating(20)).get("R", "alternation")
    found = livelock(track, OutcomeDecided(t=t, agent="R", outcome=outcome), 0.0)
    assert (found is not None) == explained
    if found:
        text = "A and GoTo alternate 19 times from 0.50 s to 19.50 s, and the robot stays within 0.00 m"
        assert found.text == text


# All but those on hardware.
SIMULATED = [entry.name for entry in Catalog.here().list("scenario") if entry.name != "exp1_ros2"]


@pytest.mark.soak
@pytest.mark.parametrize("scenario", SIMULATED)
def test_no_shipped_scenario_that_succeeds_has_one_at_its_end(scenario, tmp_path):
    result = rocs_bt.run(scenario, out=tmp_path, report=False)
    tracks = Tracks.of_recording(Recording.open(tmp_path))
    for name, agent in result.summary.agents.items():
        track = tracks.get(name, "alternation")
        for found in [each for each in (track.v if track else []) if each]:
            rows = tracks.get(name, "pose").rows()
            first, last = np.searchsorted(tracks.get(name, "pose").t, (found.begin, found.last))
            assert np.hypot(*(rows[first:last, :2] - rows[first, :2]).T).max() <= NEAR + 0.05
        assert ("alternate" in agent.reason) <= (agent.outcome in ("timeout", "failed", "stuck"))
