"""Header of a recording: scenario, agents, content, versions, and the geometry that figures show."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import msgspec

from ...base.errors import Fault, InputError
from ...base.geometry import Pose2
from ...base.signal import Signal
from ...base.units import TIME, parse_unit, read_quantity
from ...event import GuardInfo, TreeNode

Point = tuple[float, float]

LARGEST = 1e9
"""Maximum magnitude of a number of a header that is not damaged, in SI units."""

SWAP_FORM = "Write NODE=FILE@TIME or NODE=FILE:TREE@TIME, such as 'visit first=careful.xml@12.5'."
"""Hint of a fault of a swap."""

MOST = 1_000_000
"""Maximum count, such as that of the values of a signal."""


class Outline(msgspec.Struct, frozen=True, kw_only=True):
    """Outline of an obstacle from above, world frame.

    Attributes:
        name: Name in the world file.
        points: Corners of a polygon [m]; for a circle, only the centre.
        radius: Radius of a circle [m]; 0 for a polygon.
        height: Height [m].
    """

    name: str
    points: tuple[Point, ...]
    radius: float = 0.0
    height: float = 0.0

    @staticmethod
    def box(name: str, pose: Pose2, size: Point, height: float = 0.0) -> Outline:
        """Outline of a box with a length and a width [m], centred at a pose."""
        x, y = size[0] / 2.0, size[1] / 2.0
        corners = ((x, y), (-x, y), (-x, -y), (x, -y))
        return Outline(name=name, points=tuple(pose.transform(*c) for c in corners), height=height)

    @staticmethod
    def circle(name: str, centre: Point, radius: float, height: float = 0.0) -> Outline:
        """Outline of a circle with a radius [m]."""
        return Outline(name=name, points=(centre,), radius=radius, height=height)


class Place(msgspec.Struct, frozen=True, kw_only=True):
    """Named place, such as a goal or a dock; `radius` is its tolerance [m].

    `known`: Whether an agent knows the place. Figures omit the names of others, such as checkpoints.
    """

    name: str
    x: float  # [m]
    y: float  # [m]
    yaw: float = 0.0  # [rad]
    kind: str = "goal"
    radius: float = 0.0
    known: bool = True


class Beam(msgspec.Struct, frozen=True, kw_only=True):
    """Beam of a range sensor, body frame: origin, direction, measuring range and cone."""

    x: float  # [m]
    y: float  # [m]
    yaw: float  # [rad]
    reach: float  # [m]
    nearest: float = 0.0  # minimum range [m]
    name: str = ""
    cone: float = 0.0  # full angle [rad]; 0 for a ray
    elevation: float = 0.0  # angle of the direction above the horizontal [rad]


class Fan(msgspec.Struct, frozen=True, kw_only=True):
    """Rays of a laser scanner, body frame.

    Attributes:
        x, y: Origin [m].
        yaw: Direction of the first, rightmost ray [rad].
        step: Angle between neighbouring rays, counter-clockwise [rad].
        rays: Number of rays.
        reach: Maximum range [m].
        nearest: Minimum range [m].
        sweep: Time from the first ray of a scan to the last [s].
    """

    x: float
    y: float
    yaw: float
    step: float
    rays: int
    reach: float
    nearest: float = 0.0
    sweep: float = 0.0


class BodyShape(msgspec.Struct, frozen=True, kw_only=True):
    """Primitive of a body.

    Attributes:
        kind: `box`, `sphere`, `ellipsoid`, `cylinder` or `capsule`.
        size: Half edges or radii x, y, z; of a cylinder and a capsule radius and half length; radius of a sphere [m].
        position: Position x, y, z in the frame of the link [m].
        quaternion: Orientation w, x, y, z in the frame of the link.
        tint: Red, green, blue and opacity, each 0 to 1.
        link: Link that carries it: 0 for the base, else its index in `BodyInfo.links` plus 1.
    """

    kind: str
    size: tuple[float, ...]
    position: tuple[float, ...]
    quaternion: tuple[float, ...]
    tint: tuple[float, ...]
    link: int = 0


class BodyLink(msgspec.Struct, frozen=True, kw_only=True):
    """Link on a joint, as a frame at the joint.

    Attributes:
        parent: Link that carries the joint, numbered as in `BodyShape`; it comes earlier.
        position: Position in the frame of the parent [m].
        quaternion: Orientation w, x, y, z in the frame of the parent with the joint at 0.
        axis: Unit vector of the joint.
        turns: Whether the joint turns about its axis; else it slides along it.
    """

    parent: int
    position: tuple[float, ...]
    quaternion: tuple[float, ...]
    axis: tuple[float, ...]
    turns: bool = True


class BodyInfo(msgspec.Struct, frozen=True, kw_only=True):
    """Moving body.

    Attributes:
        name: Name as in `BodyMoved.body`; the agent's name for an agent's body.
        hull: Outline from above [m], body frame.
        beams: Beams of the range sensors by sensor, in the order of the sensor's values.
        fans: Rays of the laser scanners by sensor.
        height: Height [m].
        shapes: Primitives, drawn in 3D.
        links: Links on joints; `BodyMoved.joints` has their values for a robot without wheels.
        base: Height of the base's origin over the ground, if `BodyMoved` has none [m].
        script: Name of the script that moves it; empty for an agent's body, and for what only contacts move.
        states: Poses x [m], y [m], yaw [rad] of a door that is `open` and `shut`, by this word.
    """

    name: str
    hull: tuple[Point, ...]
    beams: Mapping[str, tuple[Beam, ...]] = {}
    fans: Mapping[str, Fan] = {}
    height: float = 0.2
    shapes: tuple[BodyShape, ...] = ()
    links: tuple[BodyLink, ...] = ()
    base: float = 0.0
    script: str = ""
    states: Mapping[str, tuple[float, float, float]] = {}


class SubtreeSwap(msgspec.Struct, frozen=True):
    """Replacement of a subtree of a mission by a tree of an XML mission, at a time of a run.

    Attributes:
        node: Path of the root of the subtree as in the report, or its name if unique; with several agents possibly
            `AGENT:NODE`.
        mission: Name or file of the XML mission with the new tree.
        at: Simulated time [s]; ticks from this time on tick the new tree.
        tree: ID of the tree in the mission; empty for its main tree.
    """

    node: str
    mission: str
    at: float
    tree: str = ""

    def __str__(self) -> str:
        """The swap in the form `NODE=FILE:TREE@TIME`."""
        return f"{self.node}={self.mission}{self.tree and ':' + self.tree}@{self.at:g}"

    @classmethod
    def read(cls, text: str) -> SubtreeSwap:
        """Read a swap in this form; the tree may be left out, and the time is in seconds or has a unit.

        The last `=` and the last `@` count, because the names of nodes may contain both.

        Raises:
            InputError: The text has another form.
        """
        rest, _, time = text.rpartition("@")
        node, _, mission = rest.rpartition("=")
        file, _, tree = mission.partition(":")
        if not (node and file and time):
            raise InputError(Fault(f"'{text}' is not a swap of a subtree.", hint=SWAP_FORM))
        return cls(node, file, read_quantity(time, TIME, f"the time of the swap '{text}'"), tree)


class SignalInfo(msgspec.Struct, frozen=True, kw_only=True):
    """Declaration of an agent's signal, in the order of the snapshots; see `Signal`.

    Attributes:
        units: Unit of each value, or one unit for all values.
        low: Minimum valid value; None for no bound.
        high: Maximum valid value; None for no bound.
        max_age: Validity of a value [s]; None for unlimited.
        late: Whether an Analyze block writes the signal after the reflexes of the period, in lockstep.
    """

    name: str
    size: int = 1
    units: tuple[str, ...] = ("1",)
    low: float | None = None
    high: float | None = None
    max_age: float | None = None
    late: bool = False

    @staticmethod
    def of(signal: Signal, late: bool = False) -> SignalInfo:
        """Convert the declaration of a signal."""
        low, high, age = (v if math.isfinite(v) else None for v in (*signal.bounds, signal.max_age))
        units = tuple(map(str, signal.dimensions))
        return SignalInfo(name=signal.name, size=signal.size, units=units, low=low, high=high, max_age=age, late=late)

    def signal(self) -> Signal:
        """Convert back to a declaration, without its doc.

        Raises:
            UnitError: A unit is unknown.
        """
        return Signal(
            self.name,
            self.size,
            tuple(parse_unit(unit).dimension for unit in self.units),
            (-math.inf if self.low is None else self.low, math.inf if self.high is None else self.high),
            math.inf if self.max_age is None else self.max_age,
        )


class RequirementInfo(msgspec.Struct, frozen=True, kw_only=True):
    """Requirement of the scenario: name, agent, condition and description."""

    name: str
    agent: str
    text: str
    doc: str = ""


class SensorInfo(msgspec.Struct, frozen=True, kw_only=True):
    """Sensor of an agent.

    Attributes:
        name: Name in robot.toml.
        signals: Signals that its monitor writes.
        derived: Signals that analysers write from these.
    """

    name: str
    signals: tuple[str, ...]
    derived: tuple[str, ...] = ()


class AgentInfo(msgspec.Struct, frozen=True, kw_only=True):
    """Agent: names of robot, mission and rules, nodes of the tree (parents before children), and signals.

    `inactive` contains the rules that are inactive at the start, each with the required signals that the robot lacks.
    `axes` contains the axes of a motion command, such as `vx`; empty for a robot on wheels. `guards` describes the
    rules. `faults` names the faults that the simulation gives the robot's devices, such as `lidar: drop_out 0.1`.
    """

    name: str
    robot: str
    mission: str
    rules: tuple[str, ...] = ()
    inactive: Mapping[str, tuple[str, ...]] = {}
    nodes: tuple[TreeNode, ...] = ()
    signals: tuple[SignalInfo, ...] = ()
    axes: tuple[str, ...] = ()
    guards: tuple[GuardInfo, ...] = ()
    sensors: tuple[SensorInfo, ...] = ()
    faults: tuple[str, ...] = ()


class RunHeader(msgspec.Struct, frozen=True, kw_only=True):
    """Description of a run, written before it starts.

    Attributes:
        scenario: Name of the scenario.
        seed: Seed of the episode.
        mode: `lockstep` or `threaded`.
        command: Command line that repeats the run.
        versions: Version by package.
        content_hash: SHA-256 of all content used.
        rates: Rates of `physics`, `control`, `plan` ... [Hz].
        agents: Agents, in the scenario's order.
        bodies: Moving bodies of agents and actors.
        outlines: Outlines of the obstacles in the world.
        grounds: Outlines of the ground that is not level.
        places: Goals and other named places.
        requirements: Requirements of the scenario.
        recalled: Loaded knowledge of earlier runs, as JSON (docs/knowledge.md); empty without any.
        swaps: Replacements of subtrees of missions that the run was asked for, ordered by time.
        start: Time of the first period [s].
        simulated: Whether the world was simulated. If not, poses are the robots' own estimates.
        commands: Commands of a person that the run takes, such as `pause`; none without a source of commands.
    """

    scenario: str
    seed: int
    mode: str = "lockstep"
    command: str = ""
    versions: Mapping[str, str] = {}
    content_hash: str = ""
    rates: Mapping[str, float] = {}
    agents: tuple[AgentInfo, ...] = ()
    bodies: tuple[BodyInfo, ...] = ()
    outlines: tuple[Outline, ...] = ()
    grounds: tuple[Outline, ...] = ()
    places: tuple[Place, ...] = ()
    requirements: tuple[RequirementInfo, ...] = ()
    recalled: str = ""
    swaps: tuple[SubtreeSwap, ...] = ()
    start: float = 0.0
    simulated: bool = True
    commands: tuple[str, ...] = ()

    def check(self) -> None:
        """Check what types do not say: numbers within the limits of a run, and signals that can be declared.

        Raises:
            ValueError: The header contains an impossible value.
        """
        if not 0.0 <= self.start <= LARGEST:
            raise ValueError(f"the run starts at {self.start:g} s")
        if slow := [f"{name}: {rate:g} Hz" for name, rate in self.rates.items() if not 0.0 <= rate <= MOST / 10]:
            raise ValueError(f"it has the rate {slow[0]}")
        for value in _numbers([self.bodies, self.outlines, self.grounds, self.places, self.agents]):
            if not abs(value) <= (MOST if isinstance(value, int) else LARGEST):
                raise ValueError(f"it has the number {value:g}")
        for agent in self.agents:
            if wrong := next(filter(None, (guard.faults for guard in agent.guards)), ""):
                raise ValueError(wrong)
            for declared in agent.signals:
                if not declared.name:
                    raise ValueError(f"a signal of '{agent.name}' has no name")
                low, high = declared.signal().bounds
                if low > high:
                    raise ValueError(f"signal '{declared.name}' has the bounds {low:g} and {high:g}")

    @property
    def label(self) -> str:
        """Short name of the run, such as `exp1-7`."""
        return f"{self.scenario}-{self.seed}"

    def bounds(self) -> tuple[float, float, float, float]:
        """Minimum x, minimum y, maximum x and maximum y of obstacles and ground [m]; NaN for an empty world."""
        drawn = (*self.outlines, *self.grounds)
        xs = [x + sign * o.radius for o in drawn for x, _ in o.points for sign in (-1, 1)]
        ys = [y + sign * o.radius for o in drawn for _, y in o.points for sign in (-1, 1)]
        if not xs:
            return (math.nan,) * 4
        return min(xs), min(ys), max(xs), max(ys)


def _numbers(value: Any) -> Iterator[float]:
    """Numbers in a value of a header."""
    if isinstance(value, (int, float)):
        yield value
    elif isinstance(value, msgspec.Struct):
        for name in value.__struct_fields__:
            yield from _numbers(getattr(value, name))
    elif isinstance(value, (tuple, list)):
        for each in value:
            yield from _numbers(each)
    elif isinstance(value, Mapping):
        for each in value.values():
            yield from _numbers(each)
