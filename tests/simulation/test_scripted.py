"""What a script causes is recorded as scripted: faults of devices, pushes, facts and doors; log and `--why` say so."""

import pytest

from rocs_bt import run
from rocs_bt.catalog import Catalog
from rocs_bt.event import ScriptActed
from rocs_bt.record import Recording
from rocs_bt.record.explanation.why import Why
from rocs_bt.record.fold.tracks import Tracks
from rocs_bt.testing import faults

CATALOG = Catalog()
SENSORS = [f for f in faults.FaultySensor.__subclasses__() if f not in (faults.RaisingSensor, faults.HangingSensor)]


def tracks_of(folder, prepare, **options):
    run("exp1", CATALOG, duration=1.2, out=folder, report=False, prepare=prepare, **options)
    return Tracks.of_recording(Recording.open(folder))


@pytest.mark.parametrize("fault", SENSORS, ids=lambda fault: fault.__name__)
def test_a_broken_sensor_is_said_to_be_scripted(tmp_path, fault):
    given = {"value": 0.1} if fault is faults.LyingSensor else {}
    tracks = tracks_of(tmp_path, lambda world: faults.break_sensor(world, "sonar", fault, at=0.4, **given))
    (line,) = (line for line in tracks.log if "breaks" in line.text)
    assert (line.t, line.agent, line.about) == (0.4, "R2", ("R2", "sensor", "sonar"))
    assert line.text == f"{fault.__name__} breaks the sensor sonar (scripted)"
    fired = next(e for e in tracks.events if getattr(e, "phase", "") == "fired" and e.t >= 0.4)
    assert f"{line.text} since t = 0.40 s" in Why(tracks, fired.t, "R2").answer


def test_a_fault_that_has_ended_is_no_cause_and_a_fault_that_has_not_begun_is_not_recorded(tmp_path):
    def prepare(world):
        faults.break_sensor(world, "sonar", faults.LyingSensor, value=3.0, at=0.1, until=0.3)
        faults.break_actuator(world, "wheels", faults.RefusingActuator, at=9.0)

    tracks = tracks_of(tmp_path, prepare)
    assert [e.sentence for e in tracks.events if isinstance(e, ScriptActed)] == [
        "LyingSensor breaks the sensor sonar until 0.30 s (scripted)"
    ]
    fired = next(e for e in tracks.events if getattr(e, "phase", "") == "fired")
    assert fired.t > 0.3
    assert "scripted" not in Why(tracks, fired.t, "R2").answer


def test_a_broken_actuator_is_said_to_be_scripted(tmp_path):
    tracks = tracks_of(tmp_path, lambda world: faults.break_actuator(world, "wheels", faults.RefusingActuator, at=0.4))
    assert "RefusingActuator breaks the actuator wheels (scripted)" in [line.text for line in tracks.log]


def test_the_doors_of_a_scenario_say_what_the_script_means(tmp_path):
    run("team", CATALOG, duration=2.0, out=tmp_path, report=False)
    tracks = Tracks.of_recording(Recording.open(tmp_path))
    states = sorted(tracks.steps(name, "actor").v for name in ("door_1", "door_2", "door_3"))
    assert states == [["moves", "open"], ["shut"], ["shut"]]
    lines = [line.text for line in tracks.log if line.agent == "" and "door" in line.text]
    name = lines[0].partition(" ")[0]
    assert lines == [f"{name} begins to move (scripted)", f"{name} is open since 1.00 s"]
    assert [actor.parameters.get("at_target") for actor in CATALOG.load_scenario("team").actors[:3]] == ["open"] * 3
