"""The report of a comparison: one page that needs nothing else, and tables in Markdown."""

from __future__ import annotations

import csv
import html
import io
import json
import re
import urllib.parse
from collections import Counter

import numpy as np
import pytest

from rocs_bt.base.errors import RecordingError
from rocs_bt.catalog import Catalog
from rocs_bt.compare import Comparison
from rocs_bt.compare.replay import episode_folder, recorded_page, replay_command
from rocs_bt.compare.report import exported, markdown, render_comparison, sceneries, standings, write_comparison
from rocs_bt.record import Outline, RunHeader

from .records import episode, table


def sceneries_of(scenes):
    post = Outline.circle("post", (1.0, 0.5), 0.1, 1.0)
    return {scene: RunHeader(scenario=scene, seed=0, outlines=(post,)) for scene in scenes}


@pytest.fixture(scope="module")
def comparison():
    rng = np.random.default_rng(1)
    records = []
    for planner, chance in (("good", 0.95), ("middling", 0.7), ("bad <b>", 0.3)):
        for scene in range(24):
            for seed in (1, 2):
                outcome = "success" if rng.random() < chance else str(rng.choice(["collision", "stuck"]))
                records.append(episode(planner, f"field-{scene}", seed, outcome, float(rng.uniform(15.0, 30.0))))
    return Comparison(records)


@pytest.fixture(scope="module")
def page(comparison):
    return render_comparison(comparison, sceneries=sceneries_of, command="rocs-bt compare good middling")


def test_it_is_one_file_that_refers_to_nothing_outside(page):
    without_names = re.sub(r'xmlns(:\w+)?="[^"]*"', "", page).replace("http://www.w3.org/2000/svg", "")
    assert "http:" not in without_names
    assert "https:" not in without_names
    assert not re.search(r"<(link|script|img|iframe)[^>]*\s(src|href)=\"(?!data:)", page)
    ids = Counter(re.findall(r'\sid="([^"]+)"', page))
    assert [i for i, n in ids.items() if n > 1] == []
    wanted = set(re.findall(r'(?:xlink:)?href="#([^"]+)"', page)) | set(re.findall(r"url\(#([^)]+)\)", page))
    assert wanted <= set(ids)


def test_it_says_who_leads_and_by_what_right(comparison, page):
    assert re.search(r"<h1>good leads and is better than [12] of 2 others in success\.</h1>", page)
    assert "144 episodes: 24 scenes, 2 seeds of each" in page
    rows = re.findall(r"<tr>.*?</tr>", page.partition('id="table-leaderboard"')[2].partition("</table>")[0], re.S)
    assert ["good" in rows[1], "middling" in rows[2], "bad &lt;b&gt;" in rows[3]] == [True] * 3
    good = comparison.estimate("good", "success")
    assert f"{100 * good.value:.1f} % ({100 * good.low:.1f} to {100 * good.high:.1f})" in rows[1]
    for verdict in comparison.verdicts(("success", "collision", "time")):
        assert f"{verdict.superiority:.2f}" in page or f"{1 - verdict.superiority:.2f}" in page
    assert page.count('class="status better"') + page.count('class="status inconclusive"') == 9
    assert "<b>bad" not in page
    assert "mujoco" in page
    assert "rocs-bt compare good middling" in page


def test_falls_over_time_are_drawn_if_a_robot_fell(page):
    falling = [episode("good", "field-0"), episode("good", "field-1", outcome="fell", clean=0.0, fell=1.0)]
    fallen = render_comparison(Comparison(falling), sceneries=sceneries_of)
    assert ("Falls over time" in page, "Falls over time" in fallen) == (False, True)
    assert re.search(r"<td>50.0 % \(\S+ to \S+\)</td>", fallen.partition("fell")[2])


def test_every_failure_and_disagreement_can_be_played_again(comparison, page):
    for record in comparison.records:
        if not record.success:
            assert (
                page.count(replay_command(record).replace("'", "&#39;").replace("<", "&lt;").replace(">", "&gt;")) >= 2
            )
    assert page.count('class="disagreement"') == 12
    both = re.findall(r'data-copy="(rocs-bt plot \S+ \S+) --out (\S+)"', page)
    assert len(both) == 12
    replayed = {str(episode_folder(r.planner, r.scene, r.seed)) for r in comparison.records}
    assert {folder for command, _ in both for folder in command.split()[2:]} <= replayed
    assert len({out for _, out in both}) == 12
    assert 'id="disagreement-0-outline-0"' in page  # what stands there is drawn
    assert page.count('id="disagreement-3-end"') == 1


def test_what_was_played_again_is_opened_by_a_link(comparison, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    winner, loser = next((d.winner, d.loser) for d in comparison.disagreements(*comparison.planners[:2]))
    pages = [recorded_page(loser), recorded_page(winner), recorded_page(winner, loser)]
    for page in pages:
        page.parent.mkdir(parents=True)
        page.write_text("a page")
    (tmp_path / "out").mkdir()
    write_comparison(comparison, tmp_path / "out" / "report.html")
    text = (tmp_path / "out" / "report.html").read_text("utf-8")
    links = {urllib.parse.unquote(link) for link in re.findall(r'<a href="([^"]+)">open</a>', text)}
    assert {(tmp_path / "out" / link).resolve() for link in links} == {page.resolve() for page in pages}


def test_all_episodes_are_in_its_data(comparison, page):
    data = json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.S)[1])
    assert data == json.loads(json.dumps(exported(comparison, comparison.verdicts(("success", "collision", "time")))))
    assert len(data["rows"]) == 144
    first = dict(zip(data["columns"], data["rows"][0], strict=True))
    assert (first["planner"], first["scene"], first["seed"]) == ("good", "field-0", 1)
    assert first["density"] == 0.1
    assert len(data["verdicts"]) == 9


def test_the_same_episodes_give_the_same_page(comparison, page):
    assert render_comparison(comparison, sceneries=sceneries_of, command="rocs-bt compare good middling") == page


def test_the_matrices_say_what_the_verdicts_say(comparison, page):
    planners = [row.planner for row in standings(comparison, ("success",))]
    tables = re.findall(r'<table class="matrix">.*?</table>', page, re.S)
    assert [re.search(r"<caption>(.*?)</caption>", t)[1] for t in tables] == [
        "success [points]",
        "collision [points]",
        "time [s]",
    ]
    verdicts = comparison.verdicts(("success", "collision", "time"))
    for table_, name in zip(tables, ("success", "collision", "time"), strict=True):
        rows = re.findall(r'<th scope="row">.*?</tr>', table_, re.S)
        cells = [re.findall(r'<td class="(\w+)"(?: title="([^"]*)")?>', row) for row in rows]
        assert [cells[i][i][0] for i in range(3)] == ["self"] * 3
        for verdict in (v for v in verdicts if v.metric == name):
            a, b = planners.index(verdict.a), planners.index(verdict.b)
            there, back = {
                "better": ("better", "worse"),
                "not better": ("worse", "better"),
                "inconclusive": ("open", "open"),
            }[verdict.word]
            assert (cells[a][b][0], cells[b][a][0]) == (there, back)
            by = f"{100 * verdict.difference:+z.1f} points" if name != "time" else f"{verdict.difference:+.3g} s"
            claim = f"{verdict.a} against {verdict.b} in {name}: {verdict.word}, {by} ("
            assert html.unescape(cells[a][b][1]).startswith(claim)


def test_two_planners_have_no_matrix_but_their_verdicts_at_once():
    page = render_comparison(Comparison([*table("one", "ss"), *table("other", "sc")]), metrics=("success",))
    assert 'class="matrix"' not in page
    assert "<details open><summary>The claim in numbers" in page
    assert "0 of 1 claim conclusive" in page


def test_counts_of_one_are_told_as_such():
    page = render_comparison(Comparison([*table("one", "ss"), *table("other", "sc")]))
    assert '<p class="lead">4 episodes: 2 scenes, 1 seed of each.</p>' in page
    assert "Once one planner succeeds" in page
    only = render_comparison(Comparison(table("only", "s")))
    assert "comparison of 1 planner<" in only
    assert "1 episode: the scene field-0, 1 seed" in only
    for told in (page, only):
        assert not re.search(r"\b1 (seeds|scenes|episodes|planners|claims|failures)\b", told)


def test_a_single_planner_in_a_single_scene_has_a_page_too():
    page = render_comparison(Comparison(table("only", "ssc", seeds=3)))
    assert "only succeeds in 66.7 %" in page
    assert "apply to this scene only" in page
    assert "None: in every episode" in page
    assert "Verdicts" not in page
    assert "None: every episode succeeded" in render_comparison(Comparison(table("only", "ss")))


def test_a_folder_that_cannot_be_made_is_told(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(RecordingError, match=r"report .* cannot be written"):
        write_comparison(Comparison(table("only", "s")), tmp_path / "file" / "report.html")


def test_what_stands_in_a_scenario_is_found_by_its_name():
    found = sceneries(["exp1", "exp1"], Catalog())
    assert list(found) == ["exp1"]
    assert len(found["exp1"].outlines) >= 4
    assert "goal" in [place.name for place in found["exp1"].places]


def test_markdown_has_the_same_tables(comparison):
    verdicts = comparison.verdicts(("success",))
    told = markdown(comparison, ("success", "time"), verdicts)
    assert told.startswith("**good leads and is better than")
    leaderboard, judged, failures = (p for p in told.split("\n\n") if p.startswith("|"))
    assert [line.split(" | ")[0] for line in leaderboard.splitlines()[2:]] == ["| good", "| middling", "| bad <b>"]
    assert judged.count("\n") == 4
    assert "| good better than middling in success |" in judged
    assert failures.count("`rocs-bt run") == 20
    assert "more failures" in told


@pytest.mark.browser
def test_in_a_browser_everything_is_drawn_and_can_be_taken_away(browser, page, tmp_path):
    (tmp_path / "report.html").write_text(page)
    browser.open((tmp_path / "report.html").as_uri())
    assert browser.evaluate("[...document.querySelectorAll('figure svg')].every(s => s.clientWidth > 150)")
    assert browser.evaluate("document.querySelectorAll('.figures figure').length") == 5
    rows = list(csv.reader(io.StringIO(browser.evaluate("episodes()"))))
    assert len(rows) == 145
    assert rows[0][:4] == ["planner", "family", "scene", "seed"]
    told = json.loads(browser.evaluate("everything()"))
    assert told["episodes"][0]["planner"] == "good"
    assert len(told["verdicts"]) == 9
    svg = browser.evaluate("standalone(document.getElementById('figure-profile'))")
    assert svg.startswith("<svg")
    assert "var(" not in svg
    table = browser.evaluate("tableCsv(document.getElementById('table-leaderboard'))")
    assert next(csv.reader(io.StringIO(table)))[0] == "planner"
    folded = list(csv.reader(io.StringIO(browser.evaluate("tableCsv(document.getElementById('table-verdicts'))"))))
    assert [len(folded), {len(row) for row in folded}] == [10, {8}]
    assert all(
        re.fullmatch(r"\S.* over .*\S", row[0]) and row[2].endswith(("better", "inconclusive")) for row in folded[1:]
    )
    saved = (
        "(() => { const names = []; HTMLAnchorElement.prototype.click = function () { names.push(this.download); };"
        "document.querySelectorAll('[data-save], .table-csv, [data-svg]').forEach(b => b.click()); return names; })()"
    )
    names = browser.evaluate(saved)
    assert {"episodes.csv", "comparison.json", "table-leaderboard.csv", "figure-profile.svg"} <= set(names)
    assert browser.errors == []
    assert [u for u in browser.requests if not u.startswith(("file:", "data:", "blob:"))] == []


@pytest.mark.browser
def test_in_a_browser_the_matrix_of_eight_planners_fits_a_telephone(browser, tmp_path):
    endings = {name: "s" * (24 - 3 * i) + "c" * 3 * i for i, name in enumerate(("dynamic_window", *"abcdefg"))}
    many = Comparison([record for name, letters in endings.items() for record in table(name, letters)])
    (tmp_path / "many.html").write_text(render_comparison(many, metrics=("success",)))
    shown = "[...document.querySelectorAll('.matrix td.better')].map(c => c.innerText.trim())"
    wide = "(s => [s.scrollWidth <= s.clientWidth, s.clientWidth])(document.querySelector('.matrices .scroll'))"
    for width, form in ((1200, r"\+\d+\.\d"), (390, r"\+")):
        browser.call("Emulation.setDeviceMetricsOverride", width=width, height=800, deviceScaleFactor=1, mobile=False)
        browser.open((tmp_path / "many.html").as_uri())
        assert browser.evaluate(wide)[0]
        told = browser.evaluate(shown)
        assert len(told) > 8
        assert all(re.fullmatch(form, text) for text in told)
    browser.call("Emulation.clearDeviceMetricsOverride")
    assert browser.errors == []


@pytest.mark.browser
def test_in_a_browser_it_fits_a_telephone_and_the_dark(browser, page, tmp_path):
    (tmp_path / "report.html").write_text(page)
    browser.call("Emulation.setDeviceMetricsOverride", width=390, height=800, deviceScaleFactor=1, mobile=True)
    browser.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark"}])
    browser.open((tmp_path / "report.html").as_uri())
    assert browser.evaluate("document.documentElement.scrollWidth") <= 390
    body = "getComputedStyle(document.body)"
    paper, ink = browser.evaluate(f"[{body}.backgroundColor, {body}.color]")
    brightness = [sum(map(int, re.findall(r"\d+", c)[:3])) for c in (paper, ink)]
    assert brightness[0] < 150 < 600 < brightness[1]
    line = browser.evaluate("getComputedStyle(document.documentElement).getPropertyValue('--planner-0').trim()")
    assert line == "#7db4f6"
    browser.call("Emulation.setEmulatedMedia", features=[])
    browser.call("Emulation.clearDeviceMetricsOverride")
    assert browser.errors == []
