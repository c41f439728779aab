"""`rocs-bt studio`: the runs and the content of a project, runs that it starts, and what a person sees of them."""

import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import urllib.error
import urllib.request

import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.event import OutcomeDecided
from rocs_bt.record.file.folder_lock import FolderLock
from rocs_bt.record.file.recorder import Recorder
from rocs_bt.studio.feed import Feed
from rocs_bt.studio.launch import _Child, _unlinked
from rocs_bt.studio.runs import Runs

from .. import synthetic
from ..noise import WAYS, write_noisy_project
from ..pages import unpacked
from ..waiting import GUARD, until
from .test_page import click, faults, press, text
from .test_page import until as shown

SCENARIO = """doc = "A robot drives to the origin."
base = "exp1"
"""
COMMAND = [sys.executable, "-m", "rocs_bt", "studio", "--no-browser"]


def record(folder, *, events=(), summary=True):
    """A run in a folder; without a summary it was killed."""
    folder.mkdir(parents=True)
    recorder = Recorder(folder / "run.mcap", synthetic.header())
    for event in events or synthetic.events(2.0):
        recorder.emit(event)
    recorder.close(synthetic.summary() if summary else None)
    if summary:
        (folder / "summary.json").write_text(synthetic.summary().to_json())


def states(runs):
    return {run["name"]: run["state"] for run in runs.list()}


class TestList:
    def test_each_run_has_its_state_and_the_newest_is_first(self, tmp_path):
        record(tmp_path / "done")
        record(tmp_path / "killed", summary=False)
        record(tmp_path / "odd")
        (tmp_path / "odd" / "summary.json").write_text("{")
        record(tmp_path / "going", summary=False)
        (tmp_path / "empty").mkdir()
        for k, name in enumerate(("odd", "done", "going", "killed")):
            os.utime(tmp_path / name / "run.mcap", (k + 1.0, k + 1.0))
        lock = FolderLock(tmp_path / "going")
        runs = Runs(tmp_path)
        assert [*states(runs).items()] == [
            ("killed", "cut off"),
            ("going", "running"),
            ("done", "over"),
            ("odd", "damaged"),
        ]
        done = runs.list()[2]
        assert done["outcomes"] == {"R2": synthetic.summary().agents["R2"].outcome}
        lock.close()
        assert states(runs)["going"] == "cut off"
        shutil.rmtree(tmp_path / "done")
        assert "done" not in states(runs)

    def test_a_project_without_runs_has_none(self, tmp_path):
        assert Runs(tmp_path / "runs").list() == []

    def test_links_that_lead_out_of_the_project_are_not_shown(self, tmp_path):
        record(tmp_path / "outside")
        (tmp_path / "runs").mkdir()
        (tmp_path / "runs" / "folder").symlink_to(tmp_path / "outside")
        (tmp_path / "runs" / "file").mkdir()
        (tmp_path / "runs" / "file" / "run.mcap").symlink_to(tmp_path / "outside" / "run.mcap")
        runs = Runs(tmp_path / "runs")
        assert runs.list() == []
        for name in ("folder", "file", "..", "../outside", ".", "/etc"):
            with pytest.raises(Exception, match="no run is named"):
                runs.head(name)

    def test_a_damaged_recording_shows_what_is_before_the_damage(self, tmp_path):
        record(tmp_path / "whole")
        about, _ = unpacked(Runs(tmp_path).head("whole").body)
        assert about["missing"] == ""
        data = bytearray((tmp_path / "whole" / "run.mcap").read_bytes())
        data[len(data) // 2] ^= 0xFF
        record(tmp_path / "broken", summary=False)
        (tmp_path / "broken" / "run.mcap").write_bytes(data)
        about, _ = unpacked(Runs(tmp_path).head("broken").body)
        assert "damaged" in about["missing"]
        assert about["header"]["scenario"] == synthetic.header().scenario
        (tmp_path / "broken" / "run.mcap").write_bytes(data[: len(data) // 2])
        about, _ = unpacked(Runs(tmp_path).head("broken").body)
        assert "killed" in about["missing"]

    def test_a_recording_that_grows_goes_on_until_its_end(self, tmp_path):
        folder, events = tmp_path / "going", synthetic.events(4.0)
        folder.mkdir()
        lock, recorder = FolderLock(folder), Recorder(folder / "run.mcap", synthetic.header())
        for event in events[: len(events) // 2]:
            recorder.emit(event)
        runs = Runs(tmp_path)
        until(lambda: runs.head("going").body != b"null")
        feed, half = runs.feed("going"), json.loads(runs.head("going").body)["end"]
        assert 1.0 < half < 2.5
        for event in events[len(events) // 2 :]:
            recorder.emit(event)
        until(lambda: json.loads(runs.head("going").body)["end"] > 3.0)
        recorder.emit(OutcomeDecided(t=4.0, agent="R2", outcome="success"))
        recorder.close(synthetic.summary())
        (folder / "summary.json").write_text(synthetic.summary().to_json())
        lock.close()
        until(lambda: feed.closed)
        assert feed.about["missing"] == ""
        assert feed.about["results"]["R2"]["outcome"] == "success"
        assert unpacked(runs.head("going").body)[0]["end"] == pytest.approx(4.0)

    def test_a_start_that_fails_says_why_and_leaves_the_earlier_recording(self, tmp_path):
        record(tmp_path / "mine-1")
        runs = Runs(tmp_path)
        for name in ("mine-1", "new-1"):
            runs.show(name, feed := Feed())
            feed.close({"missing": "a fault of the content"})
            with pytest.raises(InputError, match="a fault of the content"):
                runs.head(name)
        assert unpacked(runs.head("mine-1").body)[0]["missing"] == ""
        with pytest.raises(InputError, match="a fault of the content"):  # there is nothing else to show
            runs.head("new-1")

    def test_a_run_that_goes_on_is_followed_after_one_of_the_same_name_that_was_started_here(self, tmp_path):
        runs = Runs(tmp_path)
        runs.show("mine-1", over := Feed())
        over.begin(synthetic.header())
        over.close()
        assert runs.feed("mine-1") is over
        folder = tmp_path / "mine-1"
        folder.mkdir()
        lock, recorder = FolderLock(folder), Recorder(folder / "run.mcap", synthetic.header())
        until(lambda: runs.head("mine-1").body != b"null")
        growing = runs.feed("mine-1")
        assert not growing.closed
        recorder.close(synthetic.summary())
        lock.close()
        until(lambda: growing.closed)


class Studio:
    """A studio in a process of its own, and requests to it."""

    def __init__(self, folder, *arguments, **environment):
        self.process = subprocess.Popen(
            [*COMMAND, *arguments],
            cwd=folder,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            env={**os.environ, "SSH_CONNECTION": "", **environment},
        )
        self.lines = []
        for line in self.process.stdout:
            self.lines.append(line)
            if "Ctrl-C" in line:
                break
        self.url = next(iter(re.findall(r"http://\S+/", "".join(self.lines))), "")

    def get(self, name):
        with urllib.request.urlopen(self.url + name, timeout=GUARD) as answer:
            return answer.read()

    def post(self, name, /, **body):
        origin = self.url.rsplit("/", 2)[0]
        fields = {"Origin": origin, "Content-Type": "application/json"}
        request = urllib.request.Request(self.url + name, json.dumps(body).encode(), fields)
        try:
            with urllib.request.urlopen(request, timeout=GUARD) as answer:
                return json.loads(answer.read())
        except urllib.error.HTTPError as error:
            return json.loads(error.read())

    def state(self, name):
        return next((run["state"] for run in json.loads(self.get("runs")) if run["name"] == name), None)

    def __enter__(self):
        return self

    def __exit__(self, *exc):
        self.process.send_signal(signal.SIGINT)
        self.lines += self.process.communicate(timeout=GUARD)[0]


def refusal(folder, *arguments):
    """What is said of arguments that are refused."""
    done = subprocess.run([*COMMAND, *arguments], cwd=folder, capture_output=True, text=True, timeout=GUARD)
    assert done.returncode == 2
    return done.stderr


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    folder = tmp_path_factory.mktemp("project")
    (folder / "scenarios").mkdir()
    (folder / "scenarios" / "mine.toml").write_text(SCENARIO)
    (folder / "scenarios" / "wrong.toml").write_text('base = "exp1"\nduratoin = "3 s"\n')
    record(folder / "runs" / "old")
    return folder


@pytest.fixture(scope="module")
def studio(project):
    with Studio(project) as studio:
        yield studio


def test_over_ssh_it_prints_the_tunnel_to_type(project):
    with Studio(project, SSH_CONNECTION="10.0.0.2 50000 192.168.7.9 22") as studio:
        port = re.search(r":(\d+)/", studio.url)[1]
    assert f"ssh -N -L {port}:127.0.0.1:{port} " in "".join(studio.lines)
    assert "@192.168.7.9" in "".join(studio.lines)
    assert studio.process.returncode == 130


def test_a_port_that_was_asked_for_and_is_busy_is_an_error_and_else_the_next_one_is_taken(project, studio):
    busy = int(re.search(r":(\d+)/", studio.url)[1])
    said = refusal(project, "--port", str(busy))
    assert re.search(rf"port {busy} is not available: .*--port", said)
    with Studio(project) as second:
        assert second.url
        assert f":{busy}/" not in second.url


@pytest.mark.parametrize("path", ["nothing", "scenarios/mine.toml"])
def test_what_is_neither_project_nor_run_is_refused(project, path):
    assert path in refusal(project, path)


def test_wrong_wishes_are_refused_with_the_reason(studio):
    assert "exp1" in studio.post("start", scenario="exp")["error"]
    assert "seed" in studio.post("start", scenario="mine", seed=-1)["error"]
    assert "mode" in studio.post("start", scenario="mine", mode="fast")["error"]
    assert "out" in studio.post("start", scenario="mine", out="/etc")["error"]
    assert "cannot be controlled" in studio.post("control?run=old", kind="pause")["error"]
    assert "cannot be controlled" in studio.post("stop?run=--help")["error"]
    assert "no run" in studio.post("stop")["error"]
    assert "kind" in studio.post("control?run=old", kind="explode")["error"]


def test_a_scenario_with_faults_tells_them(studio):
    name = studio.post("start", scenario="wrong")["run"]
    with pytest.raises(urllib.error.HTTPError) as refused:
        until(lambda: studio.get(f"head?run={name}") != b"null")
    assert "duratoin" in json.loads(refused.value.read())["error"]


@pytest.mark.parametrize("linked", ["", "run.mcap", "summary.json", "report.html"])
@pytest.mark.parametrize("name", ["mine-5", "mine-5-2"])
def test_a_run_does_not_write_through_links(tmp_path, linked, name):
    (tmp_path / "outside").mkdir()
    (tmp_path / "outside" / "file").write_text("mine")
    folder = tmp_path / "runs" / name
    folder.parent.mkdir()
    if linked:
        folder.mkdir()
        (folder / linked).symlink_to(tmp_path / "outside" / "file")
    else:
        folder.symlink_to(tmp_path / "outside" / "new")  # leads to nothing yet
    with pytest.raises(InputError, match=rf"{name}.*is a link"):
        _unlinked(folder, folder.parent)
    assert _unlinked(folder.parent / "other-1", folder.parent) == folder.parent / "other-1"


def test_a_start_whose_recording_is_a_link_is_refused(project, studio):
    folder, outside = project / "runs" / "mine-55", project / "outside"
    folder.mkdir()
    outside.write_text("mine")
    (folder / "run.mcap").symlink_to(outside)
    assert "is a link" in studio.post("start", scenario="mine", seed=55)["error"]
    assert outside.read_text() == "mine"
    shutil.rmtree(folder)


def test_a_run_that_sends_what_cannot_be_read_ends_and_says_so(tmp_path, monkeypatch):
    wrong = "os.write(int(os.environ['ROCS_BT_STUDIO'].split()[0]), bytes([1, 0, 0, 0, 0xC1]))"
    popen, code = subprocess.Popen, f"import os, time; {wrong}; time.sleep(600)"
    monkeypatch.setattr(subprocess, "Popen", lambda _, **given: popen([sys.executable, "-c", code], **given))
    child = _Child([], tmp_path, "", tmp_path)
    until(lambda: child.over)
    assert "cannot read the data of the run" in child.feed.about["missing"]


@pytest.mark.browser
def test_what_content_prints_is_on_the_page_and_a_process_that_outlives_the_run_keeps_nothing_open(browser, tmp_path):
    with Studio(write_noisy_project(tmp_path / "loud", alive=600.0)) as studio:
        name = studio.post("start", scenario="loud", duration=0.5)["run"]
        until(lambda: studio.state(name) == "over")
        about, _ = unpacked(studio.get(f"head?run={name}"))
        assert about["missing"] == ""
        assert about["results"]["R2"]["outcome"] == "timeout"
        lines = json.loads(studio.get(f"output?run={name}")).split("\n")
        assert {f"{way} {at}" for way in WAYS for at in ("import", "tick")} <= set(lines)
        browser.open(f"{studio.url}run?run={name}")
        arrives(browser, "document.querySelector('.output')")
        click(browser, ".tabs button", "about")
        click(browser, ".output summary", "output of the run")
        shown(browser, "document.querySelector('.output pre').textContent.includes('child tick')")
        browser.open("about:blank")
        assert faults(browser) == []


def test_of_endless_output_the_end_is_kept(tmp_path, monkeypatch):
    popen, code = subprocess.Popen, "print('x' * 5_000_000, end=''); print(*range(10_000), sep='\\n')"
    monkeypatch.setattr(subprocess, "Popen", lambda _, **given: popen([sys.executable, "-c", code], **given))
    child = _Child([], tmp_path, "", tmp_path)
    until(lambda: child.over)
    assert child.output.endswith("9998\n9999")
    assert len(child.output) < 2_000


def arrives(browser, script):
    """Wait until an expression is true in the page to which the browser goes."""

    def look():
        try:
            return browser.evaluate(f"Boolean({script})")
        except RuntimeError:  # it is on its way
            return False

    until(look)


@pytest.mark.browser
def test_a_project_in_a_browser_from_its_list_to_a_run_that_is_controlled(browser, studio, project):
    browser.open(studio.url)
    shown(browser, "document.querySelector('.run')")
    assert "old" in text(browser, ".runs")
    assert text(browser, ".kind li").split("\n")[0].strip().startswith("▶")
    assert browser.evaluate("[...document.querySelectorAll('.kind > ul > li')].every((row) => row.className === 'own')")
    assert browser.evaluate("document.querySelector('.kind details').open") is False  # what is shipped is folded
    browser.evaluate("document.querySelector('[aria-label=\"run mine\"]').click()")
    arrives(browser, "location.pathname.endsWith('/run') && document.querySelector('.clock')")
    shown(browser, "parseFloat(document.querySelector('.clock').textContent) > 0.2")
    press(browser, "p")
    shown(browser, "document.querySelector('.control').innerText.includes('continue')")
    press(browser, "x")
    shown(browser, "document.querySelector('.log').innerText.includes('step')")
    press(browser, "Home")
    assert text(browser, ".clock") == "0.00 s"  # scrubbed back while the run is paused
    browser.evaluate("document.querySelector('.head').click()")
    click(browser, ".control button", "reload")
    shown(browser, "document.querySelector('.log').innerText.includes('reload')")
    click(browser, ".control button", "▶ continue")
    shown(browser, "document.querySelector('.control').innerText.includes('pause')")
    click(browser, ".control button", "■ stop")
    shown(browser, "document.querySelector('.head').textContent === 'ended'")
    shown(browser, "document.querySelector('.badge').textContent === 'interrupted'")
    assert studio.state("mine-1") == "over"
    summary = json.loads((project / "runs" / "mine-1" / "summary.json").read_text())
    assert summary["agents"]["R2"]["outcome"] == "interrupted"
    press(browser, "a")  # again
    arrives(browser, "document.querySelector('.head')?.textContent === 'live'")
    browser.open(studio.url)
    shown(browser, "document.querySelector('.run .badge')?.textContent === 'running'")
    browser.call("Emulation.setDeviceMetricsOverride", width=390, height=800, deviceScaleFactor=1, mobile=True)
    assert browser.evaluate("document.documentElement.scrollWidth") <= 390
    browser.call("Emulation.clearDeviceMetricsOverride")
    browser.open(studio.url + "run?run=old")
    shown(browser, "document.querySelector('header')")
    assert "again" in text(browser, ".control")
    browser.open("about:blank")
    assert faults(browser) == []


def test_a_subtree_is_swapped_while_the_run_is_paused_and_a_refused_swap_changes_nothing(studio):
    name = studio.post("start", scenario="mine", seed=9, duration=2.0)["run"]
    until(lambda: b"header" in studio.get(f"head?run={name}"))
    head = json.loads(studio.get(f"head?run={name}"))["header"]["agents"][0]
    node = head["nodes"][-1]["path"]
    studio.post(f"control?run={name}", kind="pause", by="a stranger")
    studio.post(f"control?run={name}", kind="swap", agent=head["name"], node=node, mission="nothing")
    studio.post(f"control?run={name}", kind="swap", agent=head["name"], node=node, mission="dock")
    studio.post(f"control?run={name}", kind="continue")
    until(lambda: studio.state(name) == "over")
    about, _ = unpacked(studio.get(f"head?run={name}"))
    said = [text for _, _, _, text, _ in about["log"] if text.startswith("the page: ")]
    assert [text.split()[2] for text in said] == ["pause", "swap", "swap", "continue"]
    assert "refused: no mission is named 'nothing'" in said[1]
    assert "refused" not in said[2]


def test_a_studio_that_ends_ends_its_runs_in_order(project):
    with Studio(project) as studio:
        name = studio.post("start", scenario="mine", seed=7)["run"]
        until(lambda: b"header" in studio.get(f"head?run={name}"))
    assert (
        json.loads((project / "runs" / name / "summary.json").read_text())["agents"]["R2"]["outcome"] == "interrupted"
    )
    assert (project / "runs" / name / "report.html").exists()


def test_a_studio_that_is_killed_leaves_its_run_to_end_whole(project):
    studio = Studio(project)
    name = studio.post("start", scenario="mine", seed=8, duration=1.5)["run"]
    until(lambda: b"header" in studio.get(f"head?run={name}"))
    studio.post(f"control?run={name}", kind="pause")
    studio.process.kill()
    studio.process.communicate(timeout=GUARD)
    until(lambda: (project / "runs" / name / "summary.json").exists())  # a pause without a page ends


def test_a_port_of_a_stranger_is_left_alone(project):
    with socket.create_server(("127.0.0.1", 0)) as taken, Studio(project) as studio:
        assert f":{taken.getsockname()[1]}/" not in studio.url


@pytest.mark.browser
def test_a_scenario_is_edited_saved_and_run_by_one_key(browser, studio, project):
    browser.open(studio.url)
    shown(browser, "document.querySelector('.kind .own a')")
    browser.evaluate("document.querySelector('.kind a[title=\"scenarios/mine.toml\"]').click()")
    arrives(browser, "globalThis.editor?.drawn")
    browser.evaluate("editor.code.area.setSelectionRange(0, 0), editor.code.replace(0, 0, '# mine\\n')")
    shown(browser, "editor.drawn === editor.code.text && editor.drawn.startsWith('# mine')")
    browser.evaluate("void editor.run()")  # not awaited: it leaves the page
    arrives(browser, "location.pathname.endsWith('/run') && document.querySelector('.clock')")
    assert (project / "scenarios" / "mine.toml").read_text().startswith("# mine\n")
    name = browser.evaluate("new URLSearchParams(location.search).get('run')")
    studio.post(f"stop?run={name}")
    until(lambda: studio.state(name) == "over")
    browser.open("about:blank")
    assert faults(browser) == []
