"""What several rooms' tests share: a robot without physics whose wheels do just what they are told, and a browser."""

import functools
import math
import signal

import hypothesis
import pytest

from rocs_bt.actions import action_table
from rocs_bt.base import clock
from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import DeviceError
from rocs_bt.base.geometry import Pose2, wrap_angle
from rocs_bt.base.signal import Signal
from rocs_bt.base.units import ANGLE, LENGTH, SPEED, TURN_RATE
from rocs_bt.control.follower import Follower
from rocs_bt.control.locomotion_kinds import make_locomotion
from rocs_bt.event import ListSink
from rocs_bt.execute import Execute, RobotBody
from rocs_bt.interfaces.actuator_limits import ActuatorLimits
from rocs_bt.interfaces.device import Actuator
from rocs_bt.interfaces.pipeline import Pipeline, Priority
from rocs_bt.interfaces.safety_gate import SafetyGate
from rocs_bt.knowledge import Knowledge

from . import awake as waking
from . import chromium, needs

# No test is one of speed. `make test` tries the same examples in each run, `make soak` new ones.
hypothesis.settings.register_profile("repeatable", deadline=None, derandomize=True)
hypothesis.settings.register_profile("explore", deadline=None)
hypothesis.settings.load_profile("repeatable")

# A background job inherits ignored signals, and so does what tests start.
for _number, _handler in ((signal.SIGINT, signal.default_int_handler), (signal.SIGHUP, signal.SIG_DFL)):
    if signal.getsignal(_number) is signal.SIG_IGN:
        signal.signal(_number, _handler)

DRIVE = make_locomotion("differential", wheel_separation=0.331, max_wheel_speed=1.2, max_wheel_acceleration=1.5)
_follower = functools.cache(Follower)  # one for all tests of a drive: whoever uses it resets it first


class _Wheels(Actuator):
    """Wheels, or another body, that move as commanded at once."""

    def __init__(self, size):
        super().__init__("wheels", size)
        self.speeds = [0.0] * size
        self.broken = False

    def command(self, values):
        if self.broken:
            raise DeviceError("the motor driver does not answer")
        self.speeds = list(values)

    def neutral(self):
        self.speeds = [0.0] * self.size


class Rig:
    """Execute of an agent on such a robot, in lockstep.

    Args:
        period: Control period [s].
        ring: Whether the robot has a size, beams all round and an estimated pose, instead of the signals of few beams.
        locomotion: How the robot moves.
        more: Declarations of further signals, instead of those of its beams.

    Attributes:
        pose: Where the robot truly is.
        lost: True while no pose comes from its sensors.
        heard: Further signals by name, each with its value, which are written with the pose.
        path: Every pose so far.
    """

    def __init__(self, period=0.05, ring=False, locomotion=DRIVE, more=None):
        self.clock, self.sink = SimulatedClock(period), ListSink()
        self.locomotion, self.wheels = locomotion, _Wheels(len(locomotion.values))
        self.pose, self.lost, self.path = Pose2(0.0, 0.0, 0.0), False, []
        self.heard = {"pose_spread": 0.0} if ring else {}
        self.knowledge = Knowledge("R1", self.clock, self.sink)
        self.knowledge.robot.locomotion = locomotion
        gaps = [(name, 1, (LENGTH,)) for name in ("front", "rear", "left_gap", "right_gap")]
        few = (
            ("room_ahead", 5, (LENGTH,) * 5),
            ("room_behind", 5, (LENGTH,) * 5),
            ("room_turned", 12, (LENGTH,) * 12),
            ("free_turn", 2, (ANGLE,) * 2),
            ("bend_off", 2, (ANGLE / LENGTH,) * 2),
        )
        if ring:
            self.knowledge.graph.set("R1", length=0.455, width=0.381)
        for name, size, dimensions in (
            ("pose", 3, (LENGTH, LENGTH, ANGLE)),
            *((("wheel_speeds", len(locomotion.wheels), (SPEED,)),) if locomotion.wheels else ()),
            *((("lateral_speed", 1, (SPEED,)),) if "vy" in locomotion.axes else ()),
            *((("climb", 1, (SPEED,)),) if "vz" in locomotion.axes else ()),
            ("speed", 1, (SPEED,)),
            ("turn_rate", 1, (TURN_RATE,)),
            *([*gaps, *((("pose_spread", 1, (LENGTH,)),) if ring else few)] if more is None else more),
        ):
            self.knowledge.signals.declare(Signal(name, size, dimensions, max_age=0.15))
        self.knowledge.signals.freeze()
        self.actions = action_table()
        self.pipeline = Pipeline(self.clock, self.sink, "R1")
        fastest = tuple(locomotion.max_speed.tolist())
        limits = ActuatorLimits(tuple(-limit for limit in fastest), fastest, together=True)
        self.gate = SafetyGate(self.wheels, self.clock, limits, period=period, max_age=0.2, sink=self.sink, agent="R1")
        self.body = RobotBody(
            knowledge=self.knowledge,
            locomotion=locomotion,
            follower=_follower(locomotion),
            clock=self.clock,
            period=period,
            actuators={"wheels": self.gate},
            motion="wheels",
            sink=self.sink,
        )
        self.execute = Execute(self.pipeline, self.body)
        self.sense()

    def sense(self):
        t, signals = self.clock.now(), self.knowledge.signals
        twist = self.locomotion.twist3(self.wheels.speeds)
        if not self.lost:
            signals.write("pose", self.pose, t)
        if self.locomotion.wheels:
            signals.write("wheel_speeds", self.wheels.speeds, t)
        for name, value in (("lateral_speed", twist.left), ("climb", twist.up)):
            if name in signals:
                signals.write(name, [value], t)
        signals.write("speed", [twist.forward], t)
        signals.write("turn_rate", [twist.turn], t)
        for name, value in self.heard.items():
            signals.write(name, value if isinstance(value, tuple) else [value], t)

    def submit(self, action, priority=Priority.NORMAL, by="test"):
        return self.pipeline.submit(action, priority, by)

    def run(self, periods=1):
        """Execute, move on, sense."""
        for _ in range(periods):
            self.execute.run(self.clock.now())
            self.move(self.locomotion.twist3(self.wheels.speeds), self.body.period)
            self.clock.advance()
            self.sense()

    def move(self, twist, period):
        half, ahead, aside = 0.5 * period * twist.turn, twist.forward * period, twist.left * period
        x, y = Pose2(self.pose.x, self.pose.y, self.pose.yaw + half).transform(ahead, aside)
        self.pose = Pose2(x, y, wrap_angle(self.pose.yaw + 2.0 * half))
        self.path.append(self.pose)

    def finish(self, ticket, limit=2000):
        """Run until a ticket has ended; the periods that took."""
        for count in range(limit):
            if ticket.state.done:
                return count
            self.run()
        raise AssertionError(f"{ticket} has not ended after {limit} periods, at {self.pose}")

    def of(self, kind):
        return [e for e in self.sink.events if isinstance(e, kind)]

    def put(self, x, y, degrees=0.0):
        """Put the robot somewhere."""
        self.pose = Pose2(x, y, math.radians(degrees))
        self.sense()


@pytest.fixture
def rig():
    return Rig()


@pytest.fixture(scope="session")
def make_rig():
    return Rig


def pytest_addoption(parser):
    parser.addoption("--real-time", action="store_true", help="threads run at once and by the wall clock itself")


@pytest.fixture
def awake(monkeypatch, request):
    """Wall clocks stand still while the machine does: for all tests of threads (tests/awake.py)."""
    if request.config.getoption("--real-time"):
        yield
        return
    with waking.one_processor(), waking.Awake() as time:
        monkeypatch.setattr(clock, "time", time)
        yield


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    browser = chromium.Browser(needs.browser(), tmp_path_factory.mktemp("chromium"))
    yield browser
    browser.close()


@pytest.fixture(scope="session")
def recording(tmp_path_factory):
    """A recorded run like EXP1."""
    from rocs_bt.record.file.recorder import Recorder
    from rocs_bt.record.file.recording import Recording

    from . import synthetic

    recorder = Recorder(tmp_path_factory.mktemp("exp1") / "run.mcap", synthetic.header())
    for event in synthetic.events():
        recorder.emit(event)
    recorder.close(synthetic.summary())
    return Recording.open(recorder.path)
