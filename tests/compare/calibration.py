"""Sweeps whose truth is known: how often intervals hold it, and how often verdicts are false.

python tests/compare/calibration.py [episodes per cell]   prints tables of coverage (docs/statistics.md)
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Sequence
from functools import cache

import numpy as np
from scipy.special import betaincinv, ndtr

from rocs_bt.compare.metric import metric
from rocs_bt.compare.statistics import always_valid, mean_difference, mean_over_scenes, rate, scene_means
from rocs_bt.compare.verdict import judge

SCENES, SEEDS, ALIKE = (20, 50, 100, 300), (1, 3, 10), (0.0, 0.3, 0.7, 1.0)
RATES = (0.5, 0.8, 0.9, 0.95, 0.98)
LIMIT = 100.0  # [s]


def chances(p: float, alike: float, shared: np.ndarray) -> np.ndarray:
    """Each scene's chance of success: mean p, intra-class correlation `alike`, ordered as the scenes' ease is."""
    if alike == 0.0 or p == 1.0:
        return np.full(shared.shape, p)
    ease = ndtr(shared)
    if alike == 1.0:
        return (ease < p).astype(float)
    size = (1.0 - alike) / alike
    return betaincinv(p * size, (1.0 - p) * size, ease)


def eases(rng: np.random.Generator, scenes: int, planners: int, common: float = 0.7) -> list[np.ndarray]:
    """How easy each scene is for each planner: correlated standard normals."""
    shared = rng.standard_normal(scenes)
    own = [rng.standard_normal(scenes) for _ in range(planners)]
    return [np.sqrt(common) * shared + np.sqrt(1.0 - common) * each for each in own]


def successes(rng: np.random.Generator, p: float, alike: float, ease: np.ndarray, seeds: int) -> np.ndarray:
    """values[scene, seed] of success."""
    return (rng.random((len(ease), seeds)) < chances(p, alike, ease)[:, None]).astype(float)


def times(rng: np.random.Generator, p: float, ease: np.ndarray, seeds: int, slower: float = 1.0) -> np.ndarray:
    """values[scene, seed] of time: skewed over scenes, a little different by seed, the limit where it fails."""
    took = 20.0 * slower * np.exp(-0.5 * ease[:, None] + 0.2 * rng.standard_normal((len(ease), seeds)))
    return np.where(successes(rng, p, 0.3, ease, seeds) > 0.0, np.minimum(took, LIMIT), LIMIT)


def cover_rate(rng: np.random.Generator, scenes: int, seeds: int, alike: float, p: float, count: int) -> float:
    """How often the interval of a success rate holds the true one."""
    held = 0
    for _ in range(count):
        (ease,) = eases(rng, scenes, 1)
        found = rate(successes(rng, p, alike, ease, seeds))
        held += found.low <= p <= found.high
    return held / count


def cover_difference(
    rng: np.random.Generator, scenes: int, seeds: int, alike: float, rates: tuple[float, float], count: int
) -> float:
    """How often the interval of the difference of two success rates holds the true one."""
    held, truth = 0, rates[0] - rates[1]
    for _ in range(count):
        a, b = (successes(rng, p, alike, e, seeds) for p, e in zip(rates, eases(rng, scenes, 2), strict=True))
        found = mean_difference(scene_means(a - b), span=1.0)
        held += found.low - 1e-12 <= truth <= found.high + 1e-12
    return held / count


@cache
def mean_time(p: float, slower: float) -> float:
    """The true mean, near enough: of many scenes."""
    rng = np.random.default_rng(1)
    return float(times(rng, p, rng.standard_normal(200_000), 1, slower).mean())


def cover_time(rng: np.random.Generator, scenes: int, p: float, count: int) -> tuple[float, float]:
    """How often the intervals of a mean time, and of a difference of mean times, hold the true ones."""
    slower = 1.1
    truth = mean_time(p, 1.0)
    apart = truth - mean_time(p, slower)
    held = np.zeros(2)
    for _ in range(count):
        ease = eases(rng, scenes, 2)
        a, b = times(rng, p, ease[0], 3), times(rng, p, ease[1], 3, slower)
        one, other = mean_over_scenes(a), mean_difference(scene_means(a - b))
        held += one.low <= truth <= one.high, other.low <= apart <= other.high
    return tuple(held / count)


def false_verdicts(rng: np.random.Generator, scenes: int, seeds: int, alike: float, p: float, count: int) -> float:
    """How often two planners of the same success rate are told apart."""
    told = 0
    for _ in range(count):
        values = tuple(successes(rng, p, alike, ease, seeds) for ease in eases(rng, scenes, 2))
        told += judge(("a", "b"), values, metric("success"), span=1.0).word != "inconclusive"
    return told / count


@cache
def equal_pace(careful: float, quick: float) -> float:
    """How much longer the hasty one may take where it succeeds, so that both have the same mean time."""
    from scipy.optimize import brentq

    aim = mean_time(careful, 1.0)
    return float(brentq(lambda slower: mean_time(quick, slower) - aim, 0.1, 1.0, xtol=1e-4))


def false_time_verdicts(rng: np.random.Generator, scenes: int, count: int) -> float:
    """How often two planners of the same mean time are told apart, though one varies more: fast, and failing more."""
    told, careful, quick = 0, 0.98, 0.85
    slower = equal_pace(careful, quick)
    for _ in range(count):
        ease = eases(rng, scenes, 2)
        values = times(rng, careful, ease[0], 3), times(rng, quick, ease[1], 3, slower)
        told += judge(("a", "b"), values, metric("time"), span=LIMIT).word != "inconclusive"
    return told / count


def false_stops(rng: np.random.Generator, scenes: int, seeds: int, alike: float, p: float, count: int) -> float:
    """How often two planners of the same success rate are told apart by looking after each of many scenes."""
    told = 0
    for _ in range(count):
        a, b = (successes(rng, p, alike, ease, seeds) for ease in eases(rng, scenes, 2))
        told += always_valid(scene_means(a - b), 1.0)[1] <= 0.05  # p only falls: once told, told at the end
    return told / count


def stopping(rng: np.random.Generator, rates: tuple[float, float], most: int, count: int) -> tuple[float, float]:
    """How often looking after each scene tells two planners apart, and after how many scenes on average."""
    told, used = 0, 0
    for _ in range(count):
        a, b = (successes(rng, p, 0.3, e, 3) for p, e in zip(rates, eases(rng, most, 2), strict=True))
        differences = scene_means(a - b)
        low, high = 0, most
        if always_valid(differences, 1.0)[1] <= 0.05:
            told += 1
            while low + 1 < high:  # the first scene after which it is told
                middle = (low + high) // 2
                low, high = (low, middle) if always_valid(differences[:middle], 1.0)[1] <= 0.05 else (middle, high)
        used += high
    return told / count, used / count


def table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table in markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in lines)


def grid(measure: Callable[..., float], cells: Sequence[object], count: int, seed: int) -> list[list[object]]:
    """One row for each number of scenes, seeds and likeness; one column for each cell, in percent."""
    rows: list[list[object]] = []
    for scenes in SCENES:
        for seeds in SEEDS:
            for alike in ALIKE if seeds > 1 else ALIKE[:1]:
                rng = np.random.default_rng([seed, scenes, seeds, round(10 * alike)])
                found = [measure(rng, scenes, seeds, alike, cell, count) for cell in cells]
                rows.append([scenes, seeds, alike if seeds > 1 else "–", *(f"{100 * each:.1f}" for each in found)])
    return rows


def main(count: int) -> None:
    """Print every table."""
    head = ["scenes", "seeds", "ICC"]
    print(f"{count} sweeps in each cell; percent.\n\n### Coverage of the 95 % interval of a success rate\n")
    print(table([*head, *(f"rate {p:g}" for p in RATES)], grid(cover_rate, RATES, count, 1)), flush=True)
    pairs = ((0.5, 0.5), (0.8, 0.6), (0.9, 0.9), (0.97, 0.9), (0.98, 0.98))
    print("\n### Coverage of the 95 % interval of a difference of two success rates\n")
    names = [f"{a:g} and {b:g}" for a, b in pairs]
    print(table([*head, *names], grid(cover_difference, pairs, count, 2)), flush=True)
    print("\n### Coverage of the 95 % intervals of a mean time and of a difference (failures count with the limit)\n")
    rows = []
    for p in (1.0, 0.97, 0.9, 0.8):
        found = [cover_time(np.random.default_rng([3, n]), n, p, count) for n in SCENES]
        rows.append([f"{p:g}", *(f"{100 * one:.1f}, {100 * two:.1f}" for one, two in found)])
    print(table(["success rate", *(f"{n} scenes" for n in SCENES)], rows), flush=True)
    print("\n### False verdicts on two equal planners\n")
    print(table([*head, *(f"rate {p:g}" for p in RATES)], grid(false_verdicts, RATES, count, 4)), flush=True)
    print("\n### False verdicts on two planners of equal mean time, one fast with more failures\n")
    row = [f"{100 * false_time_verdicts(np.random.default_rng([5, n]), n, count):.1f}" for n in SCENES]
    print(table([f"{n} scenes" for n in SCENES], [row]), flush=True)
    few = max(2 * count // 5, 50)
    print("\n### False verdicts on two equal planners, evaluated after every scene up to 500\n")
    rows = []
    for seeds, alike in ((1, 0.0), (3, 0.0), (3, 0.3), (3, 1.0)):
        rng = np.random.default_rng([6, seeds, round(10 * alike)])
        rows.append([seeds, alike, *(f"{100 * false_stops(rng, 500, seeds, alike, p, few):.1f}" for p in RATES)])
    print(table(["seeds", "ICC", *(f"rate {p:g}" for p in RATES)], rows), flush=True)
    print(
        "\n### Two different planners, evaluated after every scene up to 500: decided sweeps, and scenes until then\n"
    )
    rows = []
    for pair in ((0.9, 0.5), (0.9, 0.7), (0.95, 0.85), (0.97, 0.92)):
        told, used = stopping(np.random.default_rng([7, round(100 * pair[1])]), pair, 500, few)
        rows.append([f"{pair[0]:g} and {pair[1]:g}", f"{100 * told:.1f}", f"{used:.0f}"])
    print(table(["rates", "decided", "scenes on average"], rows))


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1000)
