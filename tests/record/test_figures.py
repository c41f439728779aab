"""The figures show what was recorded."""

import copy
import itertools
import math

import msgspec
import numpy as np
import pytest
from matplotlib.colors import to_hex

from rocs_bt.base.errors import InputError, RecordingError
from rocs_bt.base.geometry import Pose2, wrap_angle
from rocs_bt.event import ActuatorCommanded, AgentStopped, AtomicStarted, BodyMoved, pack
from rocs_bt.record.figures.figure import OTHER, ROUTES
from rocs_bt.record.figures.plot import FIGURES, write_figures
from rocs_bt.record.figures.rules import Compared, RuleTrace, draw_rules
from rocs_bt.record.file.header import Outline, Place, RunHeader
from rocs_bt.record.file.recorder import Recorder
from rocs_bt.record.file.recording import Recording
from rocs_bt.record.fold.history import History

from .. import synthetic


@pytest.fixture(scope="module")
def run(recording):
    return History(recording)


def artists(canvas, prefix):
    return [a for axes in canvas.axes for a in axes.get_children() if (a.get_gid() or "").startswith(prefix)]


ON_WHEELS = [figure for figure in FIGURES if figure.name != "height"]  # the figures of robots on wheels


def named(name):
    return next(f for f in FIGURES if f.name == name)


def test_history_knows_routes_switches_and_reflexes(run):
    agent = run.agents["R2"]
    assert [s.value for s in agent.routes] == ["deliberative", "reactive"] * 2 + ["deliberative", "idle"]
    assert len(agent.switches) == 4
    assert len(agent.reflexes()) == 2
    assert all(0.5 < s.end - s.begin < 5.0 for s in agent.reflexes())
    assert [s.value.action for s in agent.runs()] == ["GoTo", "AvoidCollision", "GoTo", "AvoidCollision", "GoTo"]


def test_the_arena_shows_paths_by_route_actions_and_switches(run):
    canvas = named("arena").make([run])
    paths = artists(canvas, "arena-0-R2-path")
    agent = run.agents["R2"]
    assert [to_hex(p.get_color()) for p in paths] == [ROUTES[s.value] for s in agent.routes]
    # The stretches together are the whole path that the simulation told.
    told = [(e.x, e.y) for e in synthetic.events() if isinstance(e, BodyMoved) and e.body == "R2"]
    drawn = {tuple(p) for line in paths for p in line.get_xydata().tolist()}
    assert drawn == set(told)
    for route in ("deliberative", "reactive"):
        (dots,) = artists(canvas, f"arena-0-R2-actions-{route}")
        begun = [e for e in synthetic.events() if isinstance(e, AtomicStarted) and e.route == route]
        assert len(dots.get_xdata()) == len(begun)
    (squares,) = artists(canvas, "arena-0-R2-switches")
    assert len(squares.get_offsets()) == 4
    (other,) = artists(canvas, "arena-0-R1-path")
    assert to_hex(other.get_color()) == OTHER
    assert len(artists(canvas, "arena-outline")) == len(run.header.outlines)
    assert len(artists(canvas, "arena-place")) == 1


def test_heights_of_ground_are_in_centimetres_below_a_metre(run):
    high = copy.copy(run)
    heights = {"mat": 0.0125, "kerb": 0.995, "hill": 1.0, "dam": 10.0}
    grounds = tuple(Outline.box(name, Pose2(0.0, 0.0), (1.0, 1.0), height) for name, height in heights.items())
    high.header = msgspec.structs.replace(run.header, grounds=grounds)
    canvas = named("arena").make([high])
    texts = {text.get_text() for text in canvas.axes[0].texts}
    assert {"mat, 1.25 cm", "kerb, 99.5 cm", "hill, 1 m", "dam, 10 m"} <= texts


def test_names_in_the_arena_are_inside_and_do_not_overlap(run):
    crowded = copy.copy(run)
    names = ["north_of_the_tower", "east_of_the_tower", "checkpoint"]
    at = [(2.0, 1.0), (2.1, 1.02), (0.0, 0.0)]
    places = [Place(name=n, x=x, y=y, known=n != "checkpoint") for n, (x, y) in zip(names, at, strict=True)]
    ground = Outline(name="mound", points=((2.3, 1.0), (2.3, 0.5), (1.9, 0.5), (1.9, 1.0)), height=0.04)
    crowded.header = msgspec.structs.replace(run.header, places=tuple(places), grounds=(ground,))
    canvas = named("arena").make([crowded])
    canvas.draw_without_rendering()
    (axes,), boxes = canvas.axes, {t.get_text(): t.get_window_extent() for t in canvas.axes[0].texts}
    assert "checkpoint" not in boxes
    labels = [boxes[name] for name in ("mound, 4 cm", *names[:2])]
    assert all(axes.bbox.x0 <= box.x0 and box.x1 <= axes.bbox.x1 for box in labels)
    assert not any(a.overlaps(b) for a, b in itertools.combinations(labels, 2))


def test_a_wide_arena_and_its_legend_are_inside_the_picture(run):
    wide = copy.copy(run)
    yard = Outline.box("yard", Pose2(0.0, 0.0), (7.2, 6.2))
    wide.header = msgspec.structs.replace(run.header, outlines=(yard,))
    canvas = named("arena").make([wide])
    canvas.draw_without_rendering()
    box = canvas.get_tightbbox()  # [inch]
    assert box.x0 >= 0.0
    assert box.x1 <= canvas.get_figwidth()


def test_the_legend_of_the_arena_wraps_a_long_list_of_bodies(run):
    crowded = copy.copy(run)
    crowded.bodies = run.bodies | {f"door_{i}": run.bodies["R1"] for i in range(5)}
    canvas = named("arena").make([crowded])
    (label,) = [text for text in canvas.axes[0].get_legend().get_texts() if "door_4" in text.get_text()]
    assert label.get_text().splitlines() == ["R1, door_0, door_1,", "door_2, door_3, door_4"]


def test_the_coordinates_are_those_of_every_body(run):
    canvas = named("coordinates").make([run])
    for i, what in enumerate("xy"):
        (r1,) = artists(canvas, f"coordinates-0-{what}-R1")
        np.testing.assert_array_equal(r1.get_ydata(), run.bodies["R1"].pose[:, i])
        assert len(artists(canvas, f"coordinates-0-{what}-R2")) == len(run.agents["R2"].routes)


def test_activation_has_a_row_for_the_route_each_rule_and_each_action(run):
    canvas = named("activation").make([run])
    (axes,) = canvas.axes
    assert [t.get_text() for t in axes.get_yticklabels()] == [
        "route",
        "rule AvoidCollision",
        "GoTo()",
        "AvoidCollision()",
    ]
    bars = artists(canvas, "activation-0-R2")
    assert [len(b.get_paths()) for b in bars] == [6, 2, 3, 2]


def test_commands_of_wheels_are_shown_with_the_true_speeds(run):
    canvas = named("commands").make([run])
    assert len(canvas.axes) == 2
    command = run.agents["R2"].commands["wheels"]
    for wheel in (0, 1):
        (commanded,) = artists(canvas, f"commands-0-R2-{wheel}-command")
        (true,) = artists(canvas, f"commands-0-R2-{wheel}-true")
        np.testing.assert_array_equal(commanded.get_ydata()[:-1], command.rows()[:, wheel])
        np.testing.assert_array_equal(true.get_ydata(), run.bodies["R2"].wheels[:, wheel])


@pytest.mark.parametrize(
    ("count", "labels"),
    [
        (1, ["wheel 1"]),
        (2, ["left", "right"]),
        (3, ["front left", "rear", "front right"]),
        (4, ["front left", "front right", "rear left", "rear right"]),
        (6, [f"wheel {n}" for n in range(1, 7)]),
    ],
)
def test_each_wheel_has_its_label(tmp_path, count, labels):
    recorder = Recorder(tmp_path / "run.mcap", synthetic.header())
    for k in range(3):
        data = pack([0.1 * k] * count)
        recorder.emit(ActuatorCommanded(t=0.05 * k, agent="R2", actuator="wheels", route="deliberative", data=data))
    recorder.close()
    canvas = named("commands").make([History(Recording.open(recorder.path))])
    assert [axes.get_ylabel() for axes in canvas.axes] == [f"{label} [m/s]" for label in labels]


def test_all_panels_of_rules_show_the_same_time():
    t, on = np.arange(5) * 0.5, np.array([False, True, True, False, False])
    sides = Compared("d", "1 m", np.linspace(0.0, 2.0, 5), np.ones(5))
    traces = [RuleTrace(name, on, on, {"m": [sides], "m/s": [sides]}) for name in ("A", "B", "C")]
    canvas = draw_rules(t, traces, ("A", "C"), "title")
    assert len(canvas.axes) == 5
    assert {axes.get_xlim() for axes in canvas.axes} == {(0.0, 2.0)}


def test_commands_of_twists_are_shown_with_the_true_speeds_of_the_axes(tmp_path):
    header = synthetic.header()
    agent = msgspec.structs.replace(header.agents[0], axes=("vx", "vy", "vz", "wz"))
    recorder = Recorder(tmp_path / "run.mcap", msgspec.structs.replace(header, agents=(agent,)))
    for k in range(80):  # ahead at 0.5 m/s, left at 0.2 m/s, up at 0.1 m/s, turning at 1 rad/s
        t, turn = 0.05 * k, 0.05 * k
        x = 0.5 * math.sin(turn) + 0.2 * (math.cos(turn) - 1.0)
        y = 0.5 * (1.0 - math.cos(turn)) + 0.2 * math.sin(turn)
        pose = {"x": x, "y": y, "yaw": wrap_angle(turn), "height": 0.1 * t, "roll": 0.0, "pitch": 0.0}
        recorder.emit(BodyMoved(t=t, agent="R2", body="R2", **pose))
        data = pack([0.5, 0.2, 0.1, 1.0])
        recorder.emit(ActuatorCommanded(t=t, agent="R2", actuator="rotors", route="deliberative", data=data))
    recorder.close()
    canvas = named("commands").make([History(Recording.open(recorder.path))])
    assert [axes.get_ylabel() for axes in canvas.axes] == [
        "forward [m/s]",
        "left [m/s]",
        "up [m/s]",
        "turn [rad/s]",
    ]
    for i, speed in enumerate((0.5, 0.2, 0.1, 1.0)):
        (true,) = artists(canvas, f"commands-0-R2-{i}-true")
        np.testing.assert_allclose(true.get_ydata()[1:-1], speed, atol=1e-3)


def test_two_runs_are_laid_over_each_other(run):
    for figure in ON_WHEELS:
        one, two = figure.make([run]), figure.make([run, run])
        first = artists(two, f"{figure.name}-0")
        second = artists(two, f"{figure.name}-1")
        assert len(first) == len(second) == len(artists(one, f"{figure.name}-0")) > 0


def test_files_are_written_and_the_same_each_time(recording, tmp_path):
    paths = write_figures([recording], tmp_path / "a", formats=("png", "svg"))
    assert sorted(p.name for p in paths) == sorted(f"{f.name}.{e}" for f in ON_WHEELS for e in ("png", "svg"))
    for path in paths:
        assert path.read_bytes().startswith(b"\x89PNG" if path.suffix == ".png" else b"<?xml")
    for path in write_figures([Recording.open(recording.path)], tmp_path / "b", formats=("svg",)):
        assert path.read_bytes() == (tmp_path / "a" / path.name).read_bytes()
    png = (tmp_path / "a" / "activation.png").read_bytes()
    assert named("activation").render([History(recording)], "png") == png


def test_a_run_with_nothing_in_it_can_be_drawn(tmp_path):
    Recorder(tmp_path / "run.mcap", RunHeader(scenario="empty", seed=1)).close()
    Recorder(tmp_path / "agents.mcap", synthetic.header()).close()
    for name in ("run.mcap", "agents.mcap"):
        assert len(write_figures([Recording.open(tmp_path / name)], tmp_path / "out", formats=("svg",))) == len(
            ON_WHEELS
        )


def test_wrong_wishes_are_told(recording, tmp_path):
    with pytest.raises(InputError, match=r"unknown format 'bmp'.*png, svg, pdf"):
        write_figures([recording], tmp_path, formats=("bmp",))
    with pytest.raises(InputError, match="no recording"):
        write_figures([], tmp_path)
    (tmp_path / "file").write_text("")
    with pytest.raises(RecordingError, match="cannot be written"):
        write_figures([recording], tmp_path / "file")


def test_no_route_has_the_wheels_of_an_agent_that_was_stopped(tmp_path):
    def told(t):
        return ActuatorCommanded(t=t, agent="R2", actuator="wheels", route="reactive", data=pack([0.0, 0.0]))

    recorder = Recorder(tmp_path / "run.mcap", synthetic.header())
    for event in (told(0.0), AgentStopped(t=0.5, agent="R2", by="the end"), told(0.5), told(2.0)):
        recorder.emit(event)
    recorder.close()
    routes = History(Recording.open(tmp_path / "run.mcap")).agents["R2"].routes
    assert [(s.value, s.begin, s.end) for s in routes] == [("reactive", 0.0, 0.5), ("idle", 0.5, 2.0)]
