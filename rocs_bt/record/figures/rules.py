"""Figures of rule files on recordings: guard signals and latches over time, and firings by threshold."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .figure import INK, MUTED, OTHER, PLACE, ROUTES, WORST, make_canvas, render_canvas, write_files

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

_COLOURS = (INK, PLACE, "#7b3fb5", WORST, "#0f7a72", ROUTES["deliberative"], MUTED)
_ROOM = 4.0  # range of a panel as a multiple of its largest threshold; signals beyond it are cut off
Series = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Compared:
    """One comparison in a rule's guard, with the values of both sides over time.

    Attributes:
        left, right: Both sides as written in the rule. left_values, right_values: Values of both sides, shape (n,) or
        (n, k).
        releases: Whether the comparison belongs to the rule's `until`.
    """

    left: str
    right: str
    left_values: Series
    right_values: Series
    releases: bool = False


@dataclass(frozen=True, eq=False)
class RuleTrace:
    """One rule evaluated on a recording.

    Attributes:
        name: Rule's name.
        latched: Whether the rule was latched at each sample, shape (n,).
        wins: Whether the rule won at each sample, shape (n,).
        panels: Comparisons of the guard, by unit.
    """

    name: str
    latched: NDArray[np.bool_]
    wins: NDArray[np.bool_]
    panels: Mapping[str, Sequence[Compared]]


def draw_rules(t: Series, traces: Sequence[RuleTrace], shown: Sequence[str], title: str) -> Canvas:
    """Draw signals and thresholds of some rules over time, and when each rule of the file is latched and wins.

    Args:
        t: Times [s], shape (n,).
        traces: All rules of the file.
        shown: Names of the rules to draw with their signals.
        title: Title of the figure.
    """
    panels = [(trace, unit) for trace in traces if trace.name in shown for unit in trace.panels]
    heights = [1.0] * len(panels) + [0.28 * (len(traces) + 1)]

    def draw(canvas: Canvas) -> None:
        canvas.suptitle(title, x=0.01, ha="left", fontsize=10)
        grid = canvas.subplots(len(heights), 1, sharex=True, squeeze=False, gridspec_kw={"height_ratios": heights})
        for i, (axes, (trace, unit)) in enumerate(zip(grid[:-1, 0], panels, strict=True)):
            _panel(axes, t, trace, unit, f"rules-{i}")
        _latches(grid[-1, 0], t, traces)
        grid[-1, 0].set_xlabel("t [s]")
        if len(t):
            grid[-1, 0].set_xlim(t[0], max(t[-1], t[0] + 0.1))

    return make_canvas((7.6, 0.9 + 1.35 * sum(heights)), draw)


def draw_sweep(
    name: str, unit: str, values: Series, firings: Mapping[str, Series], now: Sequence[float], what: str
) -> Canvas:
    """Draw the number of firings of a rule for each value of a threshold.

    Args:
        name: Threshold's name.
        unit: Unit of the threshold.
        values: Values of the threshold, shape (n,).
        firings: Numbers of firings by run, shape (n,).
        now: Present value of the threshold in each run.
        what: Rule's name.
    """
    from matplotlib.ticker import MaxNLocator

    def draw(canvas: Canvas) -> None:
        axes = canvas.add_subplot()
        for i, present in enumerate(sorted(set(now))):
            label, gid = f"now {present:g} {unit}", f"tune-now-{i}" if i else "tune-now"
            axes.axvline(present, color=WORST, lw=1.2, ls=(0, (1, 1.5)), label=label, gid=gid)
        single = len(firings) == 1
        for i, (run, counts) in enumerate(firings.items()):
            style: dict[str, Any] = {"color": ROUTES["reactive"], "lw": 1.6} if single else {"color": MUTED, "lw": 0.8}
            axes.plot(values, counts, "o-", ms=3, label=run if single or i < 6 else None, gid=f"tune-{i}", **style)
        if not single:
            total = np.sum(list(firings.values()), axis=0)
            axes.plot(values, total, "o-", color=ROUTES["reactive"], ms=4, label="all runs", gid="tune-all")
        axes.set_xlabel(f"{name} [{unit}]")
        axes.set_ylabel("firings")
        axes.set_title(f"{what}: firings by {name}")
        axes.set_ylim(bottom=0.0)
        axes.yaxis.set_major_locator(MaxNLocator(integer=True))
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))

    return make_canvas((7.2, 3.6), draw)


def write_picture(name: str, canvas: Canvas, folder: Path) -> list[Path]:
    """Write a canvas as PNG and SVG; returns the paths of the files.

    Raises:
        RecordingError: A file cannot be written.
    """
    return write_files(
        {folder / f"{name}.{form}": partial(render_canvas, name, lambda: canvas, form) for form in ("png", "svg")}
    )


def spans(t: Series, on: NDArray[np.bool_]) -> list[tuple[float, float]]:
    """Intervals in which a condition was true [s], each from the first true sample to the next false one or the end."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], on, [False]]).astype(int)))
    last = len(t) - 1
    return [(float(t[a]), float(t[min(b, last)])) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def _panel(axes: Axes, t: Series, trace: RuleTrace, unit: str, gid: str) -> None:
    colours: dict[str, str] = {}
    drawn_already: set[tuple[str, bool]] = set()
    for compared in trace.panels[unit]:
        color = colours.setdefault(compared.left, _COLOURS[len(colours) % len(_COLOURS)])
        for text, values, right in (
            (compared.left, compared.left_values, False),
            (compared.right, compared.right_values, True),
        ):
            if (text, compared.releases and right) in drawn_already:
                continue
            drawn_already.add((text, compared.releases and right))
            style = (":" if compared.releases else "--") if right else "-"
            finite = np.where(np.isfinite(values), values, np.nan)
            lines = axes.plot(t, finite, color=color, ls=style, lw=1.0 if right else 1.3, gid=f"{gid}-line")
            lines[0].set_label(_short(f"until {text}" if compared.releases and right else text))
    for begin, end in spans(t, trace.latched):
        axes.axvspan(begin, max(end, begin + 0.01), color=ROUTES["reactive"], alpha=0.13, lw=0, gid=f"{gid}-latched")
    low, high = _limits(trace.panels[unit])
    axes.set_ylim(low, high)
    axes.set_ylabel(f"[{unit}]")
    axes.set_title(trace.name.rpartition("/")[2], fontsize=9)
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.05), fontsize=7, handlelength=1.6)


def _limits(compared: Sequence[Compared]) -> tuple[float, float]:
    """Limits of a panel's y axis: all thresholds, and signal values near them."""
    right = np.concatenate([c.right_values.ravel() for c in compared])
    left = np.concatenate([c.left_values.ravel() for c in compared])
    right, left = right[np.isfinite(right)], left[np.isfinite(left)]
    both = np.concatenate([left, right])
    if not both.size:
        return 0.0, 1.0
    low, high = float(both.min()), float(both.max())
    reach = _ROOM * float(np.abs(right).max(initial=0.0))
    if reach > 0.0:
        low, high = max(low, -reach), min(high, reach)
    room = 0.06 * max(high - low, 1e-6 * max(1.0, math.fabs(high)))
    return low - room, high + room


def _latches(axes: Axes, t: Series, traces: Sequence[RuleTrace]) -> None:
    for y, trace in enumerate(traces):
        for on, color, height, what in (
            (trace.latched, ROUTES["idle"], 0.3, "latched"),
            (trace.wins, ROUTES["reactive"], 0.62, "wins"),
        ):
            bars = [(a, max(b - a, 0.02)) for a, b in spans(t, on)]
            axes.broken_barh(bars, (y - height / 2, height), facecolors=color, edgecolors="none", gid=f"{what}-{y}")
    axes.set_yticks(range(len(traces)), [trace.name.rpartition("/")[2] for trace in traces])
    axes.set_ylim(len(traces) - 0.4, -0.6)
    axes.grid(axis="y", visible=False)
    axes.tick_params(axis="y", length=0)
    axes.set_title("latched (grey) and winning (blue)", fontsize=9, color=OTHER)


def _short(text: str) -> str:
    return text if len(text) <= 34 else f"{text[:31]}..."
