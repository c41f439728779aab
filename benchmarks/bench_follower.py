"""The follower on the reference problem, compared with pure pursuit and an IPOPT NLP, interleaved in one process.

Each controller drives its own plant over the whole path. The controllers alternate round by round, so that
disturbances of the machine affect all alike. Times are thread CPU time. A tick of the follower is a complete
`Follower.step`, measured with and without the sampling of the path reference; for the NLP only the solve counts.
Cross-track errors are exact distances from the polyline after the first 3 s.

Run it with `python benchmarks follower`, or all benchmarks with `make bench`.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np
from follower_peers import DRIVE, PERIOD, Nlp, Plant, PurePursuit, anchored, corners, distance_to
from row import Row, size

from rocs_bt.base.geometry import Pose2
from rocs_bt.control.follower import Follower
from rocs_bt.control.reference import Preview, Reference

TICKS, ROUNDS, SETTLED = size((400, 5, 60), (4, 1, 2))
OURS = "follower"
BUDGET, RATIO, CROSS = 80e-6, 3.0, 0.008  # [s], [1], [m]


@dataclass
class Run:
    """Run of one controller."""

    tick: Callable[[Plant], tuple[np.ndarray, float]]
    plant: Plant = field(default_factory=Plant)
    times: list[float] = field(default_factory=list)
    positions: list[tuple[float, float]] = field(default_factory=list)

    def step(self) -> None:
        command, seconds = self.tick(self.plant)
        self.times.append(seconds)
        self.plant.move(command)
        self.positions.append(self.plant.pose[:2])


class Sampled(Reference):
    """Reference with a preview sampled beforehand, so that a tick can be timed without the sampling."""

    def __init__(self) -> None:
        self.inner = anchored()
        self.preview: Preview | None = None

    def sample(self, pose, twist, times, lead):
        if self.preview is None:
            self.preview = self.inner.sample(pose, twist, times, lead)
        return self.preview


def follower(sampling: bool) -> Callable[[Plant], tuple[np.ndarray, float]]:
    ours, reference = Follower(DRIVE, timer=time.thread_time), Sampled()
    times = 0.1 * np.arange(1, 21)

    def tick(plant: Plant) -> tuple[np.ndarray, float]:
        reference.preview = None
        if not sampling:
            reference.sample(plant.pose, DRIVE.twist(plant.command), times, 0.0)
        command = ours.step(plant.pose, None, reference, PERIOD)
        return command.values, command.solve_time

    return tick


def pursuit(look_ahead: float) -> Callable[[Plant], tuple[np.ndarray, float]]:
    controller = PurePursuit(look_ahead)

    def tick(plant: Plant) -> tuple[np.ndarray, float]:
        start = time.thread_time()
        command = controller(plant.pose, plant.command)
        return command, time.thread_time() - start

    return tick


def nlp(tuned: bool) -> Callable[[Plant], tuple[np.ndarray, float]]:
    controller = Nlp(tuned)

    def tick(plant: Plant) -> tuple[np.ndarray, float]:
        p = controller.prepare(Pose2(*plant.pose), plant.command)
        start = time.thread_time()
        command = controller.solve(p, plant.command)
        return command, time.thread_time() - start

    return tick


CONTROLLERS: dict[str, Callable[[], Callable[[Plant], tuple[np.ndarray, float]]]] = {
    OURS: lambda: follower(sampling=False),
    "follower with path sampling": lambda: follower(sampling=True),
    "pure pursuit 0.25 m": lambda: pursuit(0.25),
    "pure pursuit 0.40 m": lambda: pursuit(0.4),
    "ipopt, tuned": lambda: nlp(tuned=True),
    "ipopt, default": lambda: nlp(tuned=False),
}


def run() -> Iterator[Row]:
    """All rows."""
    times: dict[str, list[float]] = {name: [] for name in CONTROLLERS}
    runs: dict[str, Run] = {}
    for _ in range(ROUNDS):
        runs = {name: Run(make()) for name, make in CONTROLLERS.items()}
        for name, one in runs.items():
            for _ in range(TICKS):
                one.step()
            times[name] += one.times
    medians = {name: float(np.median(t)) for name, t in times.items()}
    line = corners()
    for name, one in runs.items():
        cross = distance_to(line, np.array(one.positions[SETTLED:]))
        yield from _rows(name, np.array(times[name]), medians[OURS], cross)


def _rows(name: str, times: np.ndarray, ours: float, cross: np.ndarray) -> list[Row]:
    median, p99 = float(np.median(times)), float(np.percentile(times, 99))
    rms, most = float(np.sqrt(np.mean(cross**2))), float(cross.max())
    first = name == OURS
    return [
        Row(
            f"{name}: tick, median",
            median * 1e6,
            "us",
            "" if first else OURS,
            None if first else median / ours,
            "<= 80 us" if first else "",
            median <= BUDGET if first else None,
        ),
        Row(
            f"{name}: tick, p99",
            p99 * 1e6,
            "us",
            "its median",
            p99 / median,
            "<= 3x median" if first else "",
            p99 <= RATIO * median if first else None,
        ),
        Row(
            f"{name}: cross-track rms",
            rms * 100,
            "cm",
            budget="<= 0.8 cm" if first else "",
            holds=rms <= CROSS if first else None,
        ),
        Row(f"{name}: cross-track max", most * 100, "cm"),
    ]
