"""What a recording says of its run before the first event: who, where, with which content, and what to draw."""

from __future__ import annotations

import math
from collections.abc import Mapping

import msgspec

from ..event import SubtreeSwapped
from ..geometry import Pose2
from ..signal import Signal
from ..units import parse_unit

Point = tuple[float, float]


class Outline(msgspec.Struct, frozen=True, kw_only=True):
    """One solid thing of the world, from above, in the world frame.

    Attributes:
        name: The world file's name of it.
        points: Corners of a polygon [m]; a circle has its centre alone.
        radius: A circle's radius [m]; 0 for a polygon.
        height: How high it is [m].
    """

    name: str
    points: tuple[Point, ...]
    radius: float = 0.0
    height: float = 0.0

    @staticmethod
    def box(name: str, pose: Pose2, size: Point, height: float = 0.0) -> Outline:
        """A box of this length and width [m], centred at a pose."""
        x, y = size[0] / 2.0, size[1] / 2.0
        corners = ((x, y), (-x, y), (-x, -y), (x, -y))
        return Outline(name=name, points=tuple(pose.transform(*c) for c in corners), height=height)

    @staticmethod
    def circle(name: str, centre: Point, radius: float, height: float = 0.0) -> Outline:
        """A round thing of this radius [m]."""
        return Outline(name=name, points=(centre,), radius=radius, height=height)


class Place(msgspec.Struct, frozen=True, kw_only=True):
    """A place that has a name: a goal, a dock ... `radius` is its tolerance [m]."""

    name: str
    x: float  # [m]
    y: float  # [m]
    yaw: float = 0.0  # [rad]
    kind: str = "goal"
    radius: float = 0.0


class Beam(msgspec.Struct, frozen=True, kw_only=True):
    """One beam of a range sensor, in the body frame: where it begins, where it points, how far it sees."""

    x: float  # [m]
    y: float  # [m]
    yaw: float  # [rad]
    reach: float  # [m]
    cone: float = 0.0  # full angle [rad]; 0 for a ray


class Fan(msgspec.Struct, frozen=True, kw_only=True):
    """The rays of a laser scanner, in the body frame: where they begin, where they point, how far they see.

    Attributes:
        x, y: Where they begin [m].
        yaw: Where the first one points, the rightmost [rad].
        step: From one to the next, to the left [rad].
        rays: How many there are.
        reach: How far they see [m].
    """

    x: float
    y: float
    yaw: float
    step: float
    rays: int
    reach: float


class BodyInfo(msgspec.Struct, frozen=True, kw_only=True):
    """One moving body.

    Attributes:
        name: As in `BodyMoved.body`; that of its agent, where it has one.
        hull: Its outline from above, in the body frame [m].
        beams: The beams of its range sensors by the sensor's name, in the order of the sensor's values.
        fans: The rays of its laser scanners, likewise.
        height: How high it is [m].
    """

    name: str
    hull: tuple[Point, ...]
    beams: Mapping[str, tuple[Beam, ...]] = {}
    fans: Mapping[str, Fan] = {}
    height: float = 0.2


class TreeNode(msgspec.Struct, frozen=True, kw_only=True):
    """One node of a mission tree: its path from the root (names joined by `/`), its class and its children's paths."""

    path: str
    type: str
    children: tuple[str, ...] = ()


class SignalInfo(msgspec.Struct, frozen=True, kw_only=True):
    """One signal of an agent, in the order of its snapshots; see `Signal`.

    Attributes:
        units: The unit of each value, or one for all of them.
        low: The lowest valid value; None where there is none.
        high: The highest valid value; None where there is none.
        max_age: How long a value stays valid [s]; None for ever.
        late: Whether an Analyze writes it, in lockstep after the reflexes of its period.
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
        """What a recording says of a signal."""
        low, high, age = (v if math.isfinite(v) else None for v in (*signal.bounds, signal.max_age))
        units = tuple(map(str, signal.dimensions))
        return SignalInfo(name=signal.name, size=signal.size, units=units, low=low, high=high, max_age=age, late=late)

    def signal(self) -> Signal:
        """The declaration that it was made of, but for its doc.

        Raises:
            UnitError: A unit is none.
        """
        return Signal(
            self.name,
            self.size,
            tuple(parse_unit(unit).dimension for unit in self.units),
            (-math.inf if self.low is None else self.low, math.inf if self.high is None else self.high),
            math.inf if self.max_age is None else self.max_age,
        )


class RequirementInfo(msgspec.Struct, frozen=True, kw_only=True):
    """One requirement of the scenario: its name, the agent that it is about, and its text."""

    name: str
    agent: str
    text: str
    doc: str = ""


def nodes_after(swap: SubtreeSwapped) -> tuple[TreeNode, ...]:
    """The nodes of a mission tree since one of its subtrees was swapped."""
    children: dict[str, list[str]] = {}
    for path, _, parent in swap.nodes:
        children.setdefault(parent, []).append(path)
    return tuple(TreeNode(path=p, type=kind, children=tuple(children.get(p, ()))) for p, kind, _ in swap.nodes)


class AgentInfo(msgspec.Struct, frozen=True, kw_only=True):
    """One agent: its robot, mission and rules by name, the mission's nodes (the root first, parents first), signals."""

    name: str
    robot: str
    mission: str
    rules: tuple[str, ...] = ()
    nodes: tuple[TreeNode, ...] = ()
    signals: tuple[SignalInfo, ...] = ()


class RunHeader(msgspec.Struct, frozen=True, kw_only=True):
    """All that is known of a run before it starts.

    Attributes:
        scenario: The scenario's name.
        seed: The episode's seed.
        mode: `lockstep` or `threaded`.
        command: What a person types to make this run again.
        versions: Version by package name.
        content_hash: sha256 of all content used.
        rates: Turns a second by what turns: `physics`, `control`, `plan` ... [Hz].
        agents: The agents, in the scenario's order.
        bodies: All moving bodies: those of the agents, and movers.
        outlines: The world's solid things.
        places: Goals and other named places.
        requirements: What must hold over the run.
        recalled: By agent, what it remembered of earlier runs, as JSON (docs/knowledge.md).
        start: Time of the first period [s].
        simulated: Whether the world was simulated. If not, poses are the robots' own estimates.
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
    places: tuple[Place, ...] = ()
    requirements: tuple[RequirementInfo, ...] = ()
    recalled: Mapping[str, str] = {}
    start: float = 0.0
    simulated: bool = True

    @property
    def label(self) -> str:
        """A short name of the run, such as `exp1-7`."""
        return f"{self.scenario}-{self.seed}"

    def bounds(self) -> tuple[float, float, float, float]:
        """Least x, least y, greatest x and greatest y of what stands in the world [m]; NaN for an empty one."""
        xs = [x + sign * o.radius for o in self.outlines for x, _ in o.points for sign in (-1, 1)]
        ys = [y + sign * o.radius for o in self.outlines for _, y in o.points for sign in (-1, 1)]
        if not xs:
            return (math.nan,) * 4
        return min(xs), min(ys), max(xs), max(ys)
