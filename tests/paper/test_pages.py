"""`python -m benchmarks.paper`, whole: two runs of each experiment, their figures, the page and its numbers."""

from __future__ import annotations

import json
import re
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

import pytest

from benchmarks.paper.__main__ import main
from benchmarks.paper.page import COUNTERPARTS
from rocs_bt.record import Recording

SEEDS = (1, 2)
NUMBERS = ("5b", "7b", "8", "9a", "9b", "9c", "9d", "9e")  # of the paper's figures


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("figures") / "paper"
    assert main(["--seeds", str(len(SEEDS)), "--out", str(folder)]) == 0
    return folder


@pytest.fixture(scope="module")
def summaries(made) -> dict[str, list[dict]]:
    names = ("exp1", "exp2", "exp3")
    return {n: [json.loads((made / f"runs/{n}-{s}/summary.json").read_text()) for s in SEEDS] for n in names}


class Captions(HTMLParser):
    """The rows of every caption of the page, by experiment and agent; a pair may have several captions."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[tuple[tuple[str, str], dict[str, str]]] = []
        self._tag = self._label = ""

    def handle_starttag(self, tag, attrs):
        self._tag = tag
        given = dict(attrs)
        if tag == "dl" and given.get("class") == "caption":
            self.found.append(((given["data-scenario"], given["data-agent"]), {}))

    def handle_endtag(self, tag):
        self._tag = ""

    def handle_data(self, data):
        if self._tag == "dt":
            self._label = data
        elif self._tag == "dd" and self.found:
            self.found[-1][1][self._label] = data.replace("\u00a0", " ")


def exact(hits: int, of: int) -> str:
    """A share with its Clopper-Pearson interval, from the beta distribution."""
    from scipy.stats import beta

    low = 0.0 if hits == 0 else beta.ppf(0.025, hits, of - hits + 1)
    high = 1.0 if hits == of else beta.ppf(0.975, hits + 1, of - hits)
    return f"{hits} of {of}, {100 * hits / of:.1f} % ({100 * low:.1f} to {100 * high:.1f} %)"


def ends(values: list[float], form: str, scale: float = 1.0) -> str:
    """Mean and bootstrap interval of two values: a quarter of all resamples is the one twice, so it is their range."""
    low, high = sorted(scale * v for v in values)
    return f"{form.format((low + high) / 2.0)} ({form.format(low)} to {form.format(high)}"


def test_every_figure_is_there_in_three_forms(made):
    assert tuple(part.number for part in COUNTERPARTS) == NUMBERS
    for number in NUMBERS:
        svg, pdf, png = (made / f"figure-{number}.{form}" for form in ("svg", "pdf", "png"))
        assert ElementTree.parse(svg).getroot().tag.endswith("svg")
        assert pdf.read_bytes().startswith(b"%PDF")
        assert png.read_bytes().startswith(b"\x89PNG")
        assert min(path.stat().st_size for path in (svg, pdf, png)) > 8_000


def test_the_figures_show_the_robots_that_the_paper_shows(made):
    def ids(number):
        return set(re.findall(r'id="([^"]+)"', (made / f"figure-{number}.svg").read_text()))

    assert {"figure-5b-0-R1-path", "figure-5b-0-R2-start", "figure-5b-route"} <= ids("5b")
    assert {"figure-7b-0-R1-path", "figure-7b-0-R3-start"} <= ids("7b")
    assert {f"figure-8-{name}-hull" for name in ("R1", "R2", "R3")} <= ids("8")
    for number in ("9a", "9b", "9c"):
        assert {f"figure-{number}-R2", f"figure-{number}-R3"} <= ids(number)
    assert any(i.startswith("figure-9d-0-R2-path") for i in ids("9d"))
    assert not any("-R3-" in i or "-R1-" in i for i in ids("9d"))
    assert any(i.startswith("figure-9e-0-R3-path") for i in ids("9e"))


def test_every_number_in_a_caption_comes_from_the_summaries(made, summaries):
    captions = Captions()
    captions.feed((made / "paper.html").read_text("utf-8"))
    assert len(captions.found) == sum(len(part.agents) for part in COUNTERPARTS)
    for (scenario, name), told in captions.found:
        runs = summaries[scenario]
        mine = [run["agents"][name] for run in runs]
        assert told["success"] == exact(sum(m["outcome"] == "success" for m in mine), 2)
        assert told["collided"] == exact(sum(m["collisions"] > 0 for m in mine), 2)
        assert told["struck while stationary"] == exact(sum(m["struck"] > 0 for m in mine), 2)
        shares = [m["time_reactive"] / (m["time_reactive"] + m["time_deliberative"]) for m in mine]
        assert told["reactive time"] == ends(shares, "{:.1f}", 100.0).replace(" (", " % (") + " %)"
        rates = [60.0 * m["route_switches"] / run["sim_time"] for m, run in zip(mine, runs, strict=True)]
        assert told["switches per minute"] == ends(rates, "{:.2f}") + ")"
        errors = [m["following"]["distance_error"] for m in mine if m["following"]]
        wanted = ends(errors, "{:.3f}").replace(" (", " m (") + " m)" if errors else "does not follow"
        assert told["follow-distance error"] == wanted
    assert any("does not follow" not in told["follow-distance error"] for _, told in captions.found)


def test_the_numbers_are_there_for_a_script_too(made, summaries):
    found = json.loads((made / "figures.json").read_text())
    assert found["seeds"] == 2
    for scenario, runs in summaries.items():
        for name in runs[0]["agents"]:
            hits = sum(run["agents"][name]["outcome"] == "success" for run in runs)
            assert found["experiments"][scenario][name]["success"]["value"] == hits / 2


def test_the_runs_that_are_drawn_are_those_that_were_counted(made, summaries):
    for scenario, runs in summaries.items():
        (drawn,) = (made / "runs").glob(f"{scenario}-*/run.mcap")
        recording = Recording.open(drawn)
        (counted,) = [run for run in runs if run["seed"] == recording.header.seed]
        assert recording.summary is not None
        assert recording.summary.trajectory_hash == counted["trajectory_hash"]


def test_the_page_says_what_the_paper_reports_and_needs_nothing_else(made):
    page = (made / "paper.html").read_text("utf-8")
    for part in COUNTERPARTS:
        assert f"Figure {part.number} – " in page
    assert "tries to remain there" in page
    assert not re.search(r"<(link|script|img|iframe)[^>]*\s(src|href)=", page)
    assert "python -m benchmarks.paper --seeds 2" in page


@pytest.mark.browser
def test_in_a_browser_every_figure_is_drawn_and_no_error_is_logged(browser, made):
    browser.open((made / "paper.html").as_uri())
    widths = browser.evaluate("[...document.querySelectorAll('figure svg')].map(s => s.getBoundingClientRect().width)")
    assert len(widths) == len(NUMBERS)
    assert min(widths) > 300
    assert browser.evaluate("document.querySelectorAll('dl.caption dd').length") == 6 * 10
    browser.call("Emulation.setDeviceMetricsOverride", width=390, height=800, deviceScaleFactor=1, mobile=True)
    browser.open((made / "paper.html").as_uri())
    assert browser.evaluate("document.documentElement.scrollWidth") <= 390
    assert browser.errors == []
    assert [url for url in browser.requests if not url.startswith(("file:", "data:"))] == []


def test_one_seed_is_refused_since_it_says_nothing_of_others():
    with pytest.raises(SystemExit, match="2"):
        main(["--seeds", "1"])
