"""HTML page with the paper's figures and ours side by side (paper, 6.3 to 6.5)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from rocs_bt.base.errors import RecordingError
from rocs_bt.compare.report.page import inline_svg, render_page
from rocs_bt.record import Recording
from rocs_bt.record.figures.figure import Figure
from rocs_bt.record.fold.history import History

from .figures import Axis, Paths, Scene, Trajectory

FORMATS = ("svg", "pdf", "png")
PAGE = "paper.html"


@dataclass(frozen=True)
class Counterpart:
    """One of the paper's figures, and its counterpart.

    Attributes:
        number: Number in the paper.
        scenario: Experiment of the figure.
        agents: Agents listed in the caption.
        figure: Figure class of the counterpart.
        reported: Contents of the paper's figure and text.
    """

    number: str
    scenario: str
    agents: tuple[str, ...]
    figure: Figure
    reported: str


@dataclass(frozen=True)
class Experiment:
    """Results of one experiment.

    Attributes:
        scenario: Name of the scenario.
        recording: Recording of the drawn run.
        chosen: Text on the choice of that run.
        captions: Labels and texts over all runs, by agent.
    """

    scenario: str
    recording: Recording
    chosen: str
    captions: Mapping[str, Sequence[tuple[str, str]]]


COUNTERPARTS = (
    Counterpart(
        "5b",
        "exp1",
        ("R2",),
        Trajectory("figure-5b", "EXP1: the path of R2, and the actions in its pipeline", "R2"),
        "One run. R2 starts at the top, close to the walls and to the box, and reaches the origin. Its path is red "
        "where the deliberative route is active and blue where the reactive one is, squares mark each change, "
        "small dots are actions, and the path of R1 is black. Each time the reactive route cuts in the pipeline is "
        "cleared, and R2 has to plan anew from where it is.",
    ),
    Counterpart(
        "7b",
        "exp2",
        ("R3",),
        Trajectory("figure-7b", "EXP2: the path of R3, and the actions in its pipeline", "R3"),
        "One run, drawn as Figure 5b. R3 reaches its goal around x = 1.2, y = 1.2, and from then on tries to "
        "remain there, reacting only when R1 gets too close.",
    ),
    Counterpart(
        "8",
        "exp3",
        ("R2", "R3"),
        Scene("figure-8", "EXP3: start positions"),
        "A picture of the simulated scene with three robots: R1 in red, R2 in red and black, and R3 on four "
        "wheels. Ours is a top view with the range sensor cones of the robots that have an agent.",
    ),
    Counterpart(
        "9a",
        "exp3",
        ("R2", "R3"),
        Paths("figure-9a", "EXP3: the paths of R2 and R3"),
        "One run. R2 goes to the four corners, one after the other, and plans anew at each. R3 follows R2 at a "
        "safe distance, but sometimes changes its course so as not to hit a wall, R1, or R2 where that stops to "
        "turn.",
    ),
    Counterpart(
        "9b",
        "exp3",
        ("R3",),
        Axis("figure-9b", "EXP3: x of R2 and R3 over time", 0),
        "The same run along x over time: the paper observes that R3 follows R2 during the whole experiment.",
    ),
    Counterpart(
        "9c",
        "exp3",
        ("R3",),
        Axis("figure-9c", "EXP3: y of R2 and R3 over time", 1),
        "The same run along y over time, with the same observation.",
    ),
    Counterpart(
        "9d",
        "exp3",
        ("R2",),
        Trajectory("figure-9d", "EXP3: which route is active in R2", "R2", others=False),
        "The path of R2 by route, squares at each change. The scene is more complex than before, and the paper "
        "finds that the robots change their behaviour much more often.",
    ),
    Counterpart(
        "9e",
        "exp3",
        ("R3",),
        Trajectory("figure-9e", "EXP3: which route is active in R3", "R3", others=False),
        "The path of R3 by route, as for R2.",
    ),
)
"""Counterparts in the paper's order."""


def write_paper(experiments: Sequence[Experiment], folder: Path, *, seeds: int, command: str) -> list[Path]:
    """Draw the counterparts of the paper's figures, and write the page.

    Args:
        experiments: One per experiment of the counterparts.
        folder: Output folder; created if missing.
        seeds: Number of runs per experiment in the captions.
        command: Command line that reproduces the page.

    Returns:
        The page, then the figures.

    Raises:
        RecordingError: A recording is damaged, or a file cannot be written.
    """
    by_name = {experiment.scenario: experiment for experiment in experiments}
    runs = {name: History(experiment.recording) for name, experiment in by_name.items()}
    paths, sections = [folder / PAGE], []
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for part in COUNTERPARTS:
            drawn = {form: part.figure.render([runs[part.scenario]], form) for form in FORMATS}
            for form, data in drawn.items():
                paths.append(folder / f"{part.figure.name}.{form}")
                paths[-1].write_bytes(data)
            experiment = by_name[part.scenario]
            sections.append(
                {
                    "part": part,
                    "chosen": experiment.chosen,
                    "captions": {name: experiment.captions[name] for name in part.agents},
                    "svg": inline_svg(part.figure.name, drawn["svg"].decode()),
                }
            )
        page = render_page(
            "paper.html",
            beside=Path(__file__).parent,
            sections=sections,
            experiments=experiments,
            seeds=seeds,
            command=command,
        )
        paths[0].write_text(page, encoding="utf-8")
    except OSError as error:
        raise RecordingError(f"the figures cannot be written to '{folder}': {error.strerror}.") from error
    return paths
