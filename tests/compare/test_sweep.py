"""Sweeps: each episode once, whoever plays it, however often it is interrupted."""

from __future__ import annotations

import json
import multiprocessing
import os
import random
import signal
import subprocess
import sys
import time
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import pytest

import rocs_bt
from rocs_bt import run
from rocs_bt.base.errors import InputError, RocsError
from rocs_bt.catalog import Catalog, PlannerSpec
from rocs_bt.compare import EpisodeStore, ScenarioScene, SweepOptions, sweep
from rocs_bt.compare.episode import Episode
from rocs_bt.compare.key import _NOT_PLAYED, EpisodeKeys
from rocs_bt.compare.pool import EXIT_TIMEOUT, WorkerPool
from rocs_bt.compare.record import EpisodeRecord, decode_record, encode_record
from rocs_bt.compare.runner import EpisodeRunner, run_episode
from rocs_bt.compare.store import Cost
from rocs_bt.declare import replaced

from .patient import Patient


class Here(Executor):
    """Plays everything at once, in this process, and counts."""

    def __init__(self):
        self.played = []

    def submit(self, fn, /, *args, **kwargs):
        self.played.append(args[0])
        future: Future = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:  # noqa: BLE001 - as executors do
            future.set_exception(error)
        return future


class Ends(Executor):
    """Plays nothing: a function ends the future of each episode."""

    def __init__(self, end):
        self.end = end

    def submit(self, fn, /, *args, **kwargs):
        future: Future = Future()
        self.end(future)
        return future


def bytes_of(found):
    return b"\n".join(encode_record(record) for record in found.records())


def test_a_sweep_has_every_planner_scene_and_seed_once_and_in_order(catalog):
    told = []
    here = Here()
    found = sweep(["none", "tree"], ["short"], (1, 2), catalog=catalog, executor=here, progress=told.append)
    records = list(found.records())
    assert [(r.planner, r.scene, r.seed) for r in records] == [
        (planner, "short", seed) for planner in ("none", "tree") for seed in (1, 2)
    ]
    assert (found.played, told) == (4, [0, 1, 2, 3, 4])
    again = sweep(["none", "tree"], ["short"], (1, 2, 3), catalog=catalog, executor=here, store=found.store)
    assert again.played == 2  # seed 3 of both
    assert len(here.played) == 6


def test_a_record_is_what_the_run_was(catalog, project):
    (record,) = sweep(["tree"], ["short"], (4,), catalog=catalog, executor=Here()).records()
    tree = catalog.load_planner("tree")
    summary = run(tree.drives(catalog.load_scenario("short"), "R2"), catalog, seed=4).summary
    agent = summary.agents["R2"]
    assert record.trajectory_hash == summary.trajectory_hash
    assert (record.outcome, record.sim_time, record.time_limit) == (agent.outcome, summary.sim_time, 2.0)
    assert record.metrics["path_length"] == agent.path_length
    assert record.metrics["min_clearance"] == agent.min_clearance
    assert record.metrics["time"] == 2.0  # it did not arrive: T_max
    assert record.path[0] == pytest.approx(record.path[-1], abs=1.0)
    assert decode_record(encode_record(record)) == record


def test_robots_are_compared_in_the_scenarios_own_mission(catalog, project):
    """The episode of `@ROBOT` is the run of the same scenario with that robot."""
    scenario = catalog.load_scenario("short")
    scenario = replaced(scenario, agents=(replaced(scenario.agents[0], robot="robotino"), *scenario.agents[1:]))
    record, usual = sweep(["@robotino", "tree@robotino"], ["short"], (4,), catalog=catalog, executor=Here()).records()
    assert record.planner == "@robotino"
    expected = run(scenario, catalog, seed=4).summary
    assert record.trajectory_hash == usual.trajectory_hash == expected.trajectory_hash
    assert record.content == expected.content_hash


def test_the_code_that_no_episode_depends_on_exists():
    package = Path(rocs_bt.__file__).parent
    assert [name for name in _NOT_PLAYED if not list(package.glob(f"{name}*"))] == []


def test_a_changed_robot_has_another_key(catalog, project):
    def key():
        return EpisodeKeys(Catalog(project)).of(Catalog(project).load_planner("@mine"), ScenarioScene("short"), 1)

    (project / "robots" / "mine").mkdir(parents=True)
    file = project / "robots" / "mine" / "robot.toml"
    file.write_text('format = "robot/3"\nbase = "robotino"\n', "utf-8")
    first = key()
    file.write_text('format = "robot/3"\nbase = "robotino"\ndoc = "Another."\n', "utf-8")
    assert key() != first


def test_the_content_of_an_episode_is_that_of_its_own_robot(catalog, project):
    """One runner plays several robots in one scene; the catalog that it keeps tells them apart."""
    found = sweep(["none", "@robotino", "@jackal"], ["short"], (4,), catalog=catalog, executor=Here()).records()
    scenario = catalog.load_scenario("short")
    for record in found:
        planner = catalog.load_planner(record.planner)
        assert record.content == run(planner.drives(scenario, "R2"), catalog, seed=4).summary.content_hash


def test_a_robot_by_its_path_is_the_robot_in_this_folder(catalog, project):
    """Also if the catalog has another robot of this name."""
    other = project / "elsewhere" / "robotino"
    other.mkdir(parents=True)
    (other / "robot.toml").write_text('format = "robot/3"\nbase = "jackal"\n', "utf-8")
    by_path, by_name = f"@{other}", "@robotino"
    path, name, base = sweep([by_path, by_name, "@jackal"], ["short"], (4,), catalog=catalog, executor=Here()).records()
    assert (path.planner, name.planner) == (by_path, by_name)
    assert path.trajectory_hash == base.trajectory_hash != name.trajectory_hash
    assert catalog.load_planner(f"@{catalog.find('robot', 'jackal').path}").name == "@jackal"


def test_a_robot_that_does_not_fit_the_scenario_is_refused(catalog, project):
    """Its sensors are too slow or too fast for the scenario's rates."""
    (project / "robots" / "mine").mkdir(parents=True)
    (project / "robots" / "mine" / "robot.toml").write_text(
        'format = "robot/3"\nbase = "robotino"\n[[actuator]]\nname = "wheels"\nmax_command_age = "10 ms"\n', "utf-8"
    )
    with pytest.raises(InputError, match=r"goes to neutral 0\.01 s after a command"):
        sweep(["@mine"], ["short"], (1,), catalog=catalog, executor=Here())


def test_caches_change_nothing(project):
    """Whatever a bench has played before, an episode comes out as one of a fresh bench, and as one without a bench."""
    tree, none = (Catalog().load_planner(name) for name in ("tree", "none"))
    trials = [
        Episode("", planner, ScenarioScene(scene), seed)
        for seed in (1,)
        for scene in ("exp1", "exp1_localised", "dock")
        for planner in (tree, none)
    ]
    trials = [replace(episode, project=project) for episode in trials]
    runner = EpisodeRunner(project)
    shortened = _Short(runner)
    kept = [shortened.play(episode) for episode in trials]
    random.Random(1).shuffle(trials)
    again = {(t.planner.name, t.scene.name, t.seed): shortened.play(t) for t in trials}
    for record in kept:
        assert again[record.planner, record.scene, record.seed] == record
        episode = next(t for t in trials if (t.planner.name, t.scene.name, t.seed) == _place(record))
        assert _Short(EpisodeRunner(project)).play(episode) == record
        plain = Catalog(project)
        spec = episode.planner.drives(plain.load_scenario(record.scene), "R2")
        summary = run(replaced(spec, duration=3.0), plain, seed=episode.seed).summary
        assert (summary.trajectory_hash, summary.content_hash) == (record.trajectory_hash, record.content)


def _place(record):
    return record.planner, record.scene, record.seed


class _Short:
    """A bench whose scenarios end after three seconds."""

    def __init__(self, runner):
        self._runner = runner

    def play(self, episode):
        setting = self._runner.prepare(episode.scene)
        short = replace(setting, scenario=replaced(setting.scenario, duration=3.0))
        self._runner._prepared[episode.scene] = short
        return self._runner.play(episode)


def test_what_an_episode_depends_on_makes_its_key_and_nothing_else(project, catalog, planner):
    planner("told", "return 0.0, 0.0")
    told, tree = catalog.load_planner("told"), catalog.load_planner("tree")
    place = ScenarioScene("short")

    def key(who=tree, where=place, seed=1):
        return EpisodeKeys(Catalog(project)).of(who, where, seed)

    same = [key(), key(replaced(tree, doc="Other words.", source="x"))]
    assert same[0] == same[1]
    others = [
        key(told),
        key(seed=2),
        key(where=ScenarioScene("exp1")),
        key(where=ScenarioScene("short", "R2")),
        key(replaced(tree, parameters={"cruise": "0.3 m/s"})),
        key(replaced(tree, latency=0.1)),
        key(replaced(tree, latency=None)),
        key(replaced(tree, rules=())),
        key(replaced(tree, name="other")),
    ]
    assert len({*others, same[0]}) == len(others) + 1
    before = key(told)
    file = project / "planners" / "told.py"
    file.write_text(file.read_text().replace("0.0, 0.0", "0.0, 0.1"))
    assert key(told) != before
    before = key()
    scenario = project / "scenarios" / "short.toml"
    scenario.write_text(scenario.read_text().replace('"2 s"', '"3 s"'))
    assert key() != before
    before = key()
    (project / "rules").mkdir()
    text = catalog.find("rules", "avoid_collision").path.read_text()
    (project / "rules" / "avoid_collision.toml").write_text(text + "\n# Another byte.\n")
    assert key() != before


def test_the_store_holds_what_was_put_and_exports_it_sorted(tmp_path):
    def record(key, planner, seed):
        return EpisodeRecord(key=key, planner=planner, family="f", scene="f-1", seed=seed, outcome="success")

    records = [record("3", "b", 1), record("1", "a", 2), record("2", "a", 1)]
    with EpisodeStore(tmp_path / "store") as store:
        for each in records:
            store.put(each, Cost(1.0, 0.5))
        store.put(records[0], Cost(2.0, 1.0))
        assert store.count() == 3
    with EpisodeStore(tmp_path / "store") as store:
        assert list(store.records(["1", "9", "3"])) == [records[1], records[0]]
        assert store.get("9") is None
        assert (store.outcome("3"), store.outcome("9")) == ("success", "")
        assert store.cost(["1", "3", "9"]) == Cost(3.0, 1.5)
        assert store.export(tmp_path / "lines.jsonl", ["3", "2"]) == 2
        lines = (tmp_path / "lines.jsonl").read_bytes().splitlines()
        assert [decode_record(line) for line in lines] == [records[2], records[0]]


def test_two_stores_on_one_file_see_each_others_episodes(tmp_path):
    one, other = EpisodeStore(tmp_path), EpisodeStore(tmp_path)
    record = EpisodeRecord(key="1", planner="a", family="f", scene="f-1", seed=1, outcome="stuck")
    one.put(record, Cost(0.0, 0.0))
    assert other.get("1") == record
    one.close()
    other.close()


def test_an_episode_that_breaks_is_a_record_and_is_tried_again_only_when_asked(project, catalog, planner):
    planner("told", "return 0.0, 0.0")
    here, breaks = Here(), Ends(lambda future: future.set_exception(RuntimeError("no more memory")))
    first = sweep(["told"], ["short"], (1, 2), catalog=catalog, executor=breaks)
    assert [r.outcome for r in first.records()] == ["error", "error"]
    assert all("RuntimeError: no more memory" in r.reason for r in first.records())
    assert not any(r.reproducible for r in first.records())
    assert all(r.metrics["success"] == 0.0 and r.metrics["min_clearance"] is None for r in first.records())
    second = sweep(["told"], ["short"], (1, 2), catalog=catalog, executor=here, store=first.store)
    assert second.played == 0
    again = SweepOptions(retry_errors=True)
    third = sweep(["told"], ["short"], (1, 2), catalog=catalog, executor=here, store=first.store, options=again)
    assert [r.outcome for r in third.records()] == ["timeout", "timeout"]


def test_wrong_content_ends_a_sweep_and_says_what(project, catalog):
    wrong = PlannerSpec(name="wrong", mission="go_to", parameters={"speed": "1 m/s"})
    with pytest.raises(InputError, match="no parameter is named 'speed'"):
        sweep([wrong], ["short"], catalog=catalog, executor=Here())
    with pytest.raises(InputError, match="two planners are named 'tree'"):
        sweep(["tree", "tree"], ["short"], catalog=catalog, executor=Here())
    with pytest.raises(InputError, match="no agent is named 'R9'"):
        sweep(["tree"], [ScenarioScene("short", "R9")], catalog=catalog, executor=Here())


def test_without_code_no_worker_runs_any(project, planner):
    planner("told", "return 0.0, 0.0")
    with pytest.raises(InputError, match="--no-code"):
        sweep(["told"], ["short"], catalog=Catalog(project, code=False), options=SweepOptions(workers=1))


def test_an_executor_that_is_shut_down_is_said_so(catalog):
    shut = Ends(lambda future: (future.cancel(), future.set_running_or_notify_cancel()))
    with pytest.raises(RocsError, match="the executor failed"):
        sweep(["none"], ["short"], catalog=catalog, executor=shut)


def test_a_sweep_ends_after_the_first_scene_that_is_enough_and_repeats(project, catalog):
    text = (project / "scenarios" / "short.toml").read_text()
    names = [f"short_{i}" for i in range(6)]
    for name in names:
        (project / "scenarios" / f"{name}.toml").write_text(text.replace('"2 s"', '"1 s"'))
    asked = []

    def stop_when(records):
        asked.append(len(records))
        return len(records) >= 6

    catalog, options = Catalog(project), SweepOptions(stop_when=stop_when)
    with ThreadPoolExecutor(3) as threads:
        executors = Here(), threads
        found = [sweep(["none", "tree"], names, catalog=catalog, executor=e, options=options) for e in executors]
    assert asked == [2, 4, 6, 2, 4, 6]
    assert [r.scene for r in found[0].records()] == names[:3] * 2
    assert bytes_of(found[0]) == bytes_of(found[1])
    assert 6 <= found[0].played <= 12


@pytest.fixture
def hung(project, planner):
    """A planner that hangs in C, holding the interpreter's lock, with seed 2 and no other."""
    return planner(
        "hung",
        "return 0.0, 0.0",
        reset="x = rng.integers(0, 2**62); import pathlib; p = pathlib.Path(os.environ['ROCS_HANG']); "
        "(p.with_name('tried').open('a').write('x'), ctypes.PyDLL(None).sleep(1000000)) if str(x) == p.read_text() "
        "else None",
        top="import ctypes",
    )


def test_a_hung_c_call_is_ended_by_the_wall_limit_and_the_sweep_goes_on(project, catalog, hung, monkeypatch, tmp_path):
    file = tmp_path / "draw"
    monkeypatch.setenv("ROCS_HANG", str(file))
    # What the planner draws with seed 2 is told by a run in this process.
    from rocs_bt.simulation import stream

    rng = stream("short", 2, "R2", "hung.py:Told")
    file.write_text(str(rng.integers(0, 2**62)))
    with WorkerPool(2) as pool:
        patient = Patient(pool, lambda episode: (episode.planner.name, episode.seed) == ("hung", 2))
        options = SweepOptions(wall_limit=8.0)
        found = sweep(["hung", "none"], ["short"], (1, 2, 3), catalog=catalog, executor=patient, options=options)
    outcomes = {(r.planner, r.seed): r.outcome for r in found.records()}
    assert outcomes.pop(("hung", 2)) == "limit"
    assert set(outcomes.values()) == {"timeout"}
    (record,) = [r for r in found.records() if r.outcome == "limit"]
    assert "wall limit of 8 s" in record.reason
    assert (record.metrics["success"], record.metrics["time"], record.time_limit) == (0.0, 2.0, 2.0)
    assert not record.reproducible
    assert (tmp_path / "tried").read_text() == "x"


def test_an_episode_is_ended_by_its_wall_limit_in_silence(capfd):
    episode = Episode("key", PlannerSpec(name="none", mission=""), ScenarioScene("exp1"), 1, wall_limit=0.01)
    process = multiprocessing.get_context("spawn").Process(target=run_episode, args=(episode,))
    process.start()
    process.join()
    assert process.exitcode == EXIT_TIMEOUT
    assert capfd.readouterr() == ("", "")


SCRIPT = """
import sys
from pathlib import Path
from rocs_bt.catalog import Catalog
from rocs_bt.compare import EpisodeStore, SweepOptions, sweep

if __name__ == "__main__":
    project, store, seeds, planners = Path(sys.argv[1]), Path(sys.argv[2]), int(sys.argv[3]), sys.argv[4].split(",")
    with EpisodeStore(store) as kept:
        options = SweepOptions(workers=2)
        found = sweep(planners, ["short"], range(1, seeds + 1), catalog=Catalog(project), store=kept, options=options)
        print(found.played)
        kept.export(store / "lines.jsonl", found.keys)
"""


def kill_often(project, tmp_path, kills, seeds, planners):
    """Start a sweep, kill it with all its processes, again and again; what is there after each kill; the last lines.

    Every third is killed while it starts, the others after a random number of episodes and some more time.
    """
    script = tmp_path / "sweep.py"
    script.write_text(SCRIPT)
    draw, counts = random.Random(7), []
    store = tmp_path / "killed"
    command = [sys.executable, str(script), str(project), str(store), str(seeds), planners]
    with EpisodeStore(store) as kept:
        for kill in range(kills):
            process = subprocess.Popen(
                command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True
            )
            wanted = kept.count() + (draw.randint(1, seeds // 6) if kill % 3 else 0)
            while kept.count() < wanted and process.poll() is None:
                time.sleep(0.02)
            time.sleep(draw.uniform(0.0, 0.3 if kill % 3 else 3.0))
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            counts.append(kept.count())
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return counts, int(done.stdout), (store / "lines.jsonl").read_bytes()


def undisturbed(project, tmp_path, seeds, planners):
    found = sweep(
        planners.split(","), ["short"], range(1, seeds + 1), catalog=Catalog(project), options=SweepOptions(workers=2)
    )
    found.store.export(tmp_path / "lines.jsonl", found.keys)
    return (tmp_path / "lines.jsonl").read_bytes()


def test_a_sweep_that_is_killed_goes_on_where_it_was(project, tmp_path):
    counts, left, lines = kill_often(project, tmp_path, 2, 30, "none,tree")
    assert counts == sorted(counts)
    assert 0 < left == 60 - counts[-1] < 60
    assert lines == undisturbed(project, tmp_path, 30, "none,tree")


@pytest.mark.soak
def test_a_sweep_that_is_killed_twenty_times_ends_as_an_undisturbed_one(project, tmp_path):
    counts, left, lines = kill_often(project, tmp_path, 20, 300, "none,tree,random")
    sys.stdout.write(f"episodes after each kill: {counts}; left for the last sweep: {left}\n")
    assert counts == sorted(counts)
    assert 0 < left == 900 - counts[-1] < 900
    assert lines == undisturbed(project, tmp_path, 300, "none,tree,random")


def test_the_command_gives_the_same_bytes_for_the_same_content(project, monkeypatch, capsys):
    from rocs_bt.cli.main import call

    monkeypatch.chdir(project)
    told = []
    for store, workers in (("a", "1"), ("b", "2"), ("b", "2")):
        arguments = ["tree", "none", "--scenario", "short", "--seeds", "2", "--store", store, "--jobs", workers]
        assert call(["compare", *arguments, "--json", "--export", f"{store}.jsonl"]) == 0
        told.append(capsys.readouterr().out)
    assert told[0] == told[1] == told[2]
    assert (project / "a.jsonl").read_bytes() == (project / "b.jsonl").read_bytes()
    found = json.loads(told[0])
    assert set(found) == {"results", "verdicts"}
    assert [(r["planner"], r["seed"]) for r in found["results"]] == [("tree", 1), ("tree", 2), ("none", 1), ("none", 2)]
    assert not {"wall", "cpu", "track", "wall_time"} & set(found["results"][0])
    assert {v["metric"] for v in found["verdicts"]} == {"success", "collision", "time"}
