"""The first view of the studio, two runs over each other from it, episodes of comparisons, and copies of content."""

import json

import pytest

from rocs_bt.compare.record import EpisodeRecord
from rocs_bt.compare.replay import episode_folder
from rocs_bt.compare.store import Cost, EpisodeStore
from rocs_bt.record.file.folder_lock import FolderLock
from rocs_bt.record.file.recorder import Recorder
from rocs_bt.studio.runs import Runs

from .. import synthetic
from ..pages import unpacked
from .test_door import SCENARIO, Studio, arrives, record
from .test_page import faults, text
from .test_page import until as shown


def episode(planner, outcome, seed=1, scene="exp1"):
    key = f"{planner}{scene}{seed}"
    return EpisodeRecord(key=key, planner=planner, family=scene, scene=scene, seed=seed, outcome=outcome, sim_time=3.0)


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    folder = tmp_path_factory.mktemp("project")
    (folder / "scenarios").mkdir()
    (folder / "scenarios" / "mine.toml").write_text(SCENARIO)
    record(folder / "runs" / "one")
    record(folder / "runs" / "two", events=synthetic.events(1.0))
    record(folder / "runs" / "cut", summary=False)
    cut = folder / "runs" / "cut" / "run.mcap"
    cut.write_bytes(cut.read_bytes()[:-20_000])
    record(folder / "runs" / "broken", summary=False)
    data = bytearray((folder / "runs" / "broken" / "run.mcap").read_bytes())
    data[len(data) // 2] ^= 0xFF
    (folder / "runs" / "broken" / "run.mcap").write_bytes(data)
    (folder / "runs" / "empty").mkdir()
    (folder / "runs" / "empty" / "run.mcap").write_bytes(b"no recording")
    record(folder / episode_folder("<b>tree", "exp1", 1))
    with EpisodeStore(folder / "runs" / "compare") as store:
        for each in (
            episode("<b>tree", "success"),
            episode("tree_no_reflexes", "collision"),
            episode("none", "timeout"),
        ):
            store.put(each, Cost(1.0, 1.0))
    return folder


@pytest.fixture(scope="module")
def studio(project):
    with Studio(project) as studio:
        yield studio


class TestRequests:
    def test_a_run_that_goes_on_is_packed_up_to_now(self, tmp_path):
        lock = None
        (tmp_path / "going").mkdir()
        lock, recorder = FolderLock(tmp_path / "going"), Recorder(tmp_path / "going" / "run.mcap", synthetic.header())
        for event in synthetic.events(2.0):
            recorder.emit(event)
        about, _ = unpacked(Runs(tmp_path).head("going", whole=True).body)
        assert about["missing"].startswith("The run goes on")
        recorder.close(synthetic.summary())
        lock.close()
        assert unpacked(Runs(tmp_path).head("going", whole=True).body)[0]["missing"] == ""

    def test_only_an_episode_that_is_stored_is_played(self, studio):
        for wrong in ({"planner": "../evil.toml"}, {"scene": "dock"}, {"seed": 2}):
            answer = studio.post("play", **{"planner": "none", "scene": "exp1", "seed": 1, **wrong})
            assert "is stored" in answer["error"]

    def test_only_shipped_content_is_copied(self, studio, project):
        for wrong in (
            {"kind": "scenario", "name": "mine"},
            {"kind": "scenario", "name": str(project / "x.toml")},
            {"kind": "secret", "name": "x"},
            {"kind": "robot", "name": "../../etc"},
        ):
            assert studio.post("copy", **wrong)["error"]
        assert "--allow-code" in studio.post("copy", kind="robot", name="quadrotor")["error"]
        assert not (project / "robots" / "quadrotor").exists()

    def test_content_that_is_new_is_listed_without_a_restart(self, studio, project):
        (project / "scenarios" / "later.toml").write_text(SCENARIO)
        scenarios = json.loads(studio.get("project"))["content"]["scenario"]
        assert {"name": "later", "own": True}.items() <= next(s for s in scenarios if s["name"] == "later").items()
        (project / "scenarios" / "later.toml").unlink()


@pytest.mark.browser
class TestFirstView:
    def test_two_runs_are_selected_and_shown_over_each_other(self, browser, studio):
        browser.open(studio.url)
        shown(browser, "document.querySelector('.run')")
        for name in ("two", "cut", "one"):  # the last two count
            browser.evaluate(f"document.querySelector('[aria-label=\"select {name}\"]').click()")
        assert text(browser, ".notice a") == "compare cut and one"
        browser.evaluate("document.querySelector('.notice a').click()")
        arrives(browser, "document.querySelector('.differences')")
        assert text(browser, ".time").startswith("cut and one′, ")
        assert "R2′" in text(browser, "select[aria-label=robot]")
        assert "second run" in text(browser, ".legend")
        assert "The run was killed" in text(browser, ".cut")
        browser.evaluate("dispatchEvent(new KeyboardEvent('keydown', { key: 'o' }))")
        arrives(browser, "document.querySelector('.notice:not([hidden])')")
        assert text(browser, "[role=status]").startswith("Select the run to compare with cut.")
        assert faults(browser) == []

    @pytest.mark.parametrize(
        ("second", "said"), [("broken", "damaged"), ("empty", "cannot be shown"), ("gone", "no run")]
    )
    def test_a_second_run_that_cannot_be_read_leaves_the_first(self, browser, studio, second, said):
        browser.open("about:blank")
        browser.open(f"{studio.url}run?run=one&second={second}")
        shown(browser, "document.querySelector('.inspector h3')")
        assert said in text(browser, ".cut")
        assert [error for error in faults(browser) if "422" not in error] == []
        browser.errors.clear()

    def test_runs_are_sorted_and_searched_with_their_cause(self, browser, studio):
        browser.open(studio.url)
        shown(browser, "document.querySelector('.run')")
        names = "[...document.querySelectorAll('.run b')].map((e) => e.innerText)"
        browser.evaluate(
            "(e => { e.value = 'name'; e.dispatchEvent(new Event('change')); })(document.querySelector('select'))"
        )
        found = browser.evaluate(names)
        assert found == sorted(found, key=str.casefold)
        browser.evaluate(
            "(e => { e.value = 'TREE-EXP'; e.dispatchEvent(new Event('input')); })(document.querySelector('input'))"
        )
        assert browser.evaluate(names) == ["_b_tree-exp1-1"]
        assert faults(browser) == []

    def test_an_episode_is_opened_or_played_first(self, browser, studio, project):
        browser.open(studio.url)
        shown(browser, "document.querySelector('.scene')")
        buttons = browser.evaluate("[...document.querySelectorAll('.scene button')].map((e) => e.innerText)")
        assert buttons == [
            "both",
            "<b>tree success 3.0 s",
            "▶ none timeout 3.0 s",
            "▶ tree_no_reflexes collision 3.0 s",
        ]
        browser.evaluate("document.querySelectorAll('.scene button')[3].click()")
        arrives(browser, "document.querySelector('.inspector h3')")
        assert text(browser, ".inspector h3") == "R2: collision"
        assert (project / episode_folder("tree_no_reflexes", "exp1", 1) / "report.html").exists()
        browser.open(studio.url)
        shown(browser, "document.querySelector('.scene')")
        assert "▶" not in browser.evaluate("document.querySelectorAll('.scene button')[3].innerText")
        assert faults(browser) == []

    @pytest.mark.parametrize("width", [390, 800, 1366, 2200])
    def test_nothing_overflows_on_any_screen(self, browser, studio, width):
        size = {"width": width, "height": 844, "deviceScaleFactor": 1, "mobile": False}
        browser.call("Emulation.setDeviceMetricsOverride", **size)
        try:
            browser.open("about:blank")
            browser.open(f"{studio.url}#with=one")
            shown(browser, "document.querySelector('.scene')")
            right = "[...document.querySelectorAll('#home *')].map((e) => e.getBoundingClientRect().right)"
            assert max(browser.evaluate(right)) <= width
            fonts = "[...document.querySelectorAll('#home *')].map((e) => parseFloat(getComputedStyle(e).fontSize))"
            assert min(browser.evaluate(fonts)) >= 11
        finally:
            browser.call("Emulation.clearDeviceMetricsOverride")


@pytest.mark.browser
def test_an_empty_folder_says_how_to_begin(browser, tmp_path):
    with Studio(tmp_path) as studio:
        browser.open(studio.url)
        shown(browser, "document.querySelector('.first')")
        begin = browser.evaluate("[...document.querySelectorAll('.first button')].map((e) => e.innerText)")
        assert begin == ["▶ watch exp1", "change exp1", "change a reflex"]
        browser.evaluate("document.querySelectorAll('.first button')[1].click()")
        arrives(
            browser, "document.querySelector('textarea') && location.href.includes('edit?file=scenarios%2Fexp1.toml')"
        )
        assert (tmp_path / "scenarios" / "exp1.toml").is_file()
        browser.open(studio.url)
        shown(browser, "document.querySelector('.kind .own')")
        assert browser.evaluate("document.querySelector('.first')") is None
        assert text(browser, ".kind .own b") == "exp1"
        assert faults(browser) == []
