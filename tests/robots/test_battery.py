"""The battery that any robot can have: charge, power, chargers, and what reads its signal."""

import pytest

from rocs_bt import run
from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import Catalog
from rocs_bt.control.locomotion_kinds import make_locomotion
from rocs_bt.declare import replaced
from rocs_bt.devices.simulated.flat import FlatRobot, FlatWorld
from rocs_bt.event import KnowledgeChanged, ListSink
from rocs_bt.plan import xml_mission
from tests.made_devices import make_device

DRIVE = make_locomotion("differential", wheel_separation=0.3, max_wheel_speed=1.0, max_wheel_acceleration=1.0)
GIVEN = {"capacity": 1000.0, "idle_power": 10.0, "motion_power": 20.0, "charge_power": 110.0, "charge": 0.5}


def charges(motion, pose, seconds=2, **given):
    clock = SimulatedClock(0.5)
    robot = FlatRobot(FlatWorld(clock, places={"charger": Pose2(1.0, 0.0)}), DRIVE, pose)
    robot.motion = motion
    sensor = make_device(robot.world, robot.name, "battery", "battery", {**GIVEN, **given})
    found = [sensor.read().values[0]]
    for _ in range(2 * seconds):
        clock.advance()
        found.append(sensor.read().values[0])
    return found


@pytest.mark.parametrize(
    ("motion", "pose", "power"),
    [
        ([0.0, 0.0], Pose2(0.0, 0.0), -10.0),
        ([0.3, 0.3], Pose2(0.0, 0.0), -30.0),
        ([-0.1, 0.1], Pose2(0.0, 0.0), -30.0),
        ([0.0, 0.0], Pose2(0.71, 0.0), 100.0),  # at the charger
        ([0.0, 0.0], Pose2(0.69, 0.0), -10.0),
    ],
)
def test_the_charge_is_the_integral_of_the_power(motion, pose, power):
    found = charges(motion, pose)
    assert found == pytest.approx([0.5 + power * 0.5 * step / 1000.0 for step in range(5)])


def test_the_charge_stays_between_empty_and_full():
    assert charges([0.3, 0.3], Pose2(0.0, 0.0), charge=0.01)[-1] == 0.0
    assert charges([0.0, 0.0], Pose2(1.0, 0.0), charge=0.99)[-1] == 1.0
    assert charges([0.0, 0.0], Pose2(1.0, 0.0), chargers=("other",))[-1] < 0.5


def test_the_patrol_visits_the_nearest_goal_first_and_charges_in_time():
    sink = ListSink()
    summary = run("patrol_charge", Catalog(), seed=1, report=False, sinks=[sink]).summary
    agent = summary.agents["R1"]
    assert agent.outcome == "success", agent.reason
    assert agent.requirements[0].margin > 0.1
    visits = [e.subject for e in sink.events if isinstance(e, KnowledgeChanged) and e.name == "visited"]
    assert visits == ["corner_1", "corner_4", "corner_3", "corner_2"]


@pytest.mark.parametrize(
    ("robot", "low"), [("jackal_battery", ["0.5"]), ("jackal", [])], ids=["a battery of 40 %", "no battery"]
)
def test_nav2s_condition_reads_the_signal(robot, low):
    conditions = ["0.2", "0.5", '0.5" is_voltage="true']
    steps = [f'<IsBatteryLow min_battery="{c}"/>' for c in conditions]
    steps = [step if c in low else f"<Inverter>{step}</Inverter>" for c, step in zip(conditions, steps, strict=True)]
    text = f'<root BTCPP_format="4"><BehaviorTree ID="M"><Sequence>{"".join(steps)}</Sequence></BehaviorTree></root>'
    catalog = Catalog()
    scenario = catalog.load_scenario("patrol_charge")
    scenario = replaced(
        scenario,
        agents=(replaced(scenario.agents[0], robot=robot, success=replaced(scenario.agents[0].success, after={})),),
        requirements=(),
    )
    build = catalog.with_content(xml_mission(text, dialect="nav2"))
    result = run(scenario, catalog, duration=0.5, report=False, missions={"R1": build})
    assert "the mission returned SUCCESS" in result.summary.agents["R1"].reason
