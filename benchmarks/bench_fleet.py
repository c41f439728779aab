"""Many agents in one world: EXP3 with complete agents, and the cost per robot for 1, 2, 5, 10 and 20 robots.

CPU time in one process, lockstep, recorded to a file. The measured loop runs from the first control period to the
last: observing and judging, all agents, recording, and physics. Each period's time is its median over several plays
of the same seed, since a shared machine has pauses (periods.py).

The fleet repeats EXP3: a floor of walled squares, each with a robot that visits the corners and one that follows it
by its robot sensor; there are no walkers, so every robot has an agent. With an odd number the last robot visits
corners alone. Robot sensors reach into neighbouring squares, but walls hide the robots there.

The growth is the slope of a straight line through the logarithms of cost and number: at a slope of at most 1 the cost
per robot grows at most in proportion to the number of robots. The line is drawn in runs/bench/fleet.png and fleet.svg.

Run it with `python benchmarks fleet`, or all benchmarks with `make bench`.
"""

from __future__ import annotations

import math
import statistics
import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from periods import clocked
from row import Row, size

import rocs_bt
from rocs_bt.catalog import Catalog

SEEDS = range(1, size(4, 2))
COUNTS = size((1, 2, 5, 10, 20), (1, 2))
PACE, FLEET_PACE, SLOPE = 20.0, 3.0, 1.0
DURATION = size(None, 0.5)  # [s] of EXP3; None is the scenario's
SPAN = size(15.0, 0.5)  # [s] simulated time of a fleet; no robot finishes by then
PITCH = 5.0  # [m] from one square to the next
PICTURE = Path("runs/bench")

CORNER = """
[[place]]
name = "{name}"
x = "{x} m"
y = "{y} m"
agents = ["{agent}"]
"""
LEADER = """
[[agent]]
name = "{name}"
robot = "pioneer_p3dx"
mission = "corners"
rules = ["avoid_collision"]
x = "{x} m"
y = "{y} m"
yaw = "45 deg"
[agent.parameters]
first = "{name}_1"
second = "{name}_2"
third = "{name}_3"
fourth = "{name}_4"
"""
FOLLOWER = """
[[agent]]
name = "{name}"
robot = "summit_xl"
mission = "follow_robot"
rules = ["avoid_collision"]
x = "{x} m"
y = "{y} m"
yaw = "45 deg"
[agent.parameters]
leader = "{leader}"
distance = "1.5 m"
room = "1.3 m"
cruise = "0.8 m/s"
"""
WALL = '<geom name="{name}" type="box" size="{sx} {sy} 0.25" pos="{x} {y} 0.25"/>'


@dataclass(frozen=True)
class Timed:
    """One seed: number of agents, simulated time and CPU time of the loop [s]."""

    robots: int
    simulated: float
    loop: float


def fleet(project: Path, robots: int) -> None:
    """Write a project with a scenario `fleet` that has the given number of robots with agents."""
    squares = math.ceil(robots / 2)
    wide = math.ceil(math.sqrt(squares))
    deep = math.ceil(squares / wide)
    scenario = [
        f'format = "scenario/2"\ndoc = "{robots} robots with agents."\nworld = "squares"\nduration = "{SPAN} s"'
    ]
    for square in range(squares):
        x, y = PITCH * (square % wide), PITCH * (square // wide)
        leader = f"L{square + 1}"
        scenario.append(LEADER.format(name=leader, x=x + 0.5, y=y + 0.5))
        for i, (east, north) in enumerate(((1.7, 1.7), (1.7, -1.7), (-1.7, 1.7), (-1.7, -1.7)), 1):
            scenario.append(CORNER.format(name=f"{leader}_{i}", x=x + east, y=y + north, agent=leader))
        if 2 * square + 1 < robots:
            scenario.append(FOLLOWER.format(name=f"F{square + 1}", x=x - 1.2, y=y - 1.2, leader=leader))
    walls = [
        WALL.format(name=f"column_{i}", sx=0.025, sy=PITCH * deep / 2, x=PITCH * (i - 0.5), y=PITCH * (deep - 1) / 2)
        for i in range(wide + 1)
    ]
    walls += [
        WALL.format(name=f"row_{i}", sx=PITCH * wide / 2, sy=0.025, x=PITCH * (wide - 1) / 2, y=PITCH * (i - 0.5))
        for i in range(deep + 1)
    ]
    worlds = project / "scenarios" / "worlds"
    worlds.mkdir(parents=True)
    floor = '<geom name="floor" type="plane" size="0 0 0.1"/>'
    body = "\n".join([floor, *walls])
    (worlds / "squares.xml").write_text(f'<mujoco model="squares"><worldbody>{body}</worldbody></mujoco>')
    (project / "scenarios" / "fleet.toml").write_text("\n".join(scenario))


def timed(catalog: Catalog, name: str, seed: int, out: Path, duration: float | None = None) -> Timed:
    """One seed of a scenario, recorded."""
    summaries: list[rocs_bt.Summary] = []

    def play(tick: Callable[[float], None]) -> str:
        result = rocs_bt.run(name, catalog, seed=seed, duration=duration, out=out, report=False, progress=tick)
        summaries.append(result.summary)
        return str(result.summary.trajectory_hash)

    loop = sum(clocked(play))
    return Timed(len(summaries[-1].agents), summaries[-1].sim_time, loop)


def fleet_of(count: int, folder: Path) -> Timed:
    """The fastest seed of a fleet."""
    project = folder / f"fleet_{count}"
    fleet(project, count)
    runs = [timed(Catalog(project), "fleet", seed, folder / "run") for seed in SEEDS]
    return min(runs, key=lambda run: run.loop / run.simulated)


def slope(costs: Mapping[int, float]) -> float:
    """Exponent of the growth of a cost with the number of robots: least squares through the logarithms."""
    import numpy as np

    return float(np.polyfit(np.log(list(costs)), np.log(list(costs.values())), 1)[0])


def draw(costs: Mapping[int, float], growth: float) -> None:
    """Plot the cost per robot over the number of robots."""
    from matplotlib.figure import Figure

    canvas = Figure(figsize=(6.4, 4.0), layout="constrained")
    axes = canvas.subplots()
    counts = list(costs)
    axes.plot(counts, [1e3 * c for c in costs.values()], "o-", label=f"measured: exponent {growth:.2f}")
    axes.plot(
        counts, [1e3 * costs[counts[0]] * n for n in counts], ":", color="grey", label="proportional to the number"
    )
    axes.set(
        xscale="log",
        yscale="log",
        xlabel="robots with agents in one world",
        ylabel="CPU time per robot and simulated second [ms]",
        title="Cost per robot",
        xticks=counts,
        xticklabels=counts,
    )
    axes.minorticks_off()
    axes.grid(visible=True, alpha=0.3)
    axes.legend()
    PICTURE.mkdir(parents=True, exist_ok=True)
    for form in ("png", "svg"):
        canvas.savefig(PICTURE / f"fleet.{form}", dpi=160)


def run() -> Iterator[Row]:
    """All rows; also draws the figure."""
    costs: dict[int, float] = {}
    with tempfile.TemporaryDirectory() as folder:
        experiment = [timed(Catalog(), "exp3", seed, Path(folder) / "run", DURATION) for seed in SEEDS]
        pace = statistics.median(run.simulated / run.loop for run in experiment)
        yield Row("EXP3: complete agents, recorded", pace, "x real time", "", None, f">= {PACE:g}x", pace >= PACE)
        for count in COUNTS:
            found = fleet_of(count, Path(folder))
            costs[count] = found.loop / found.simulated / found.robots
            yield row_of(found, costs[count] / costs[1])
    growth = slope(costs)
    draw(costs, growth)
    name, allowed = "fleet: growth exponent of the cost per robot", f"<= {SLOPE:g}"
    yield Row(name, growth, "", "", None, allowed, growth <= SLOPE)


def row_of(found: Timed, ratio: float) -> Row:
    """Row of a fleet; the ratio is the cost per robot relative to a single robot."""
    name, rate = f"fleet: {found.robots} robots with agents, recorded", found.simulated / found.loop
    judged = found.robots == 10
    budget, holds = (f">= {FLEET_PACE:g}x", rate >= FLEET_PACE) if judged else ("", None)
    return Row(name, rate, "x real time", "one robot alone", ratio, budget, holds)
