"""Sweeps on a real Dask cluster on this machine, also when a worker dies under load."""

from __future__ import annotations

import os
import signal

import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.compare import EpisodeStore, SweepOptions, sweep
from rocs_bt.compare.record import encode_record
from rocs_bt.search.cluster import dask_executor

from .. import needs
from ..waiting import GUARD
from .patient import Patient

dask = needs.package("dask")
distributed = needs.package("distributed")
pytestmark = pytest.mark.filterwarnings("ignore")  # Dask's own, of a worker that was killed


@pytest.fixture(scope="module")
def cluster():
    few = dask.config.set({"distributed.scheduler.allowed-failures": 1})
    with (
        few,
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
        ) as made,
    ):
        yield made


@pytest.fixture(autouse=True)
def patience(monkeypatch):
    monkeypatch.setattr("rocs_bt.search.cluster._PATIENCE", GUARD)


def here(catalog, seeds):
    return [
        encode_record(r)
        for r in sweep(["none", "tree"], ["short"], seeds, catalog=catalog, options=SweepOptions(workers=1)).records()
    ]


def test_a_cluster_plays_what_this_machine_plays(cluster, catalog):
    with dask_executor(cluster.scheduler_address) as executor:
        found = sweep(["none", "tree"], ["short"], (1, 2), catalog=catalog, executor=executor)
    assert [encode_record(record) for record in found.records()] == here(catalog, (1, 2))


def test_a_worker_that_is_killed_under_load_costs_nothing_but_time(cluster, catalog, tmp_path):
    killed = []

    def kill(done):
        if done >= 5 and not killed:
            pids = list(_pids(cluster).values())
            os.kill(pids[0], signal.SIGKILL)
            killed.append(pids[0])

    with dask_executor(cluster.scheduler_address) as executor, EpisodeStore(tmp_path) as store:
        found = sweep(
            ["none", "tree"], ["short"], range(1, 8), catalog=catalog, executor=executor, store=store, progress=kill
        )
        assert found.played == 14
        assert killed
        assert [encode_record(record) for record in found.records()] == here(catalog, range(1, 8))


def test_an_episode_that_hangs_on_a_cluster_ends_its_worker_and_is_a_record(cluster, catalog, planner):
    planner("hung", "ctypes.PyDLL(None).sleep(1000000); return 0.0, 0.0", top="import ctypes")
    with dask_executor(cluster.scheduler_address) as executor:
        patient = Patient(executor, lambda episode: episode.planner.name == "hung")
        found = sweep(
            ["hung", "none"], ["short"], catalog=catalog, executor=patient, options=SweepOptions(wall_limit=2.0)
        )
    assert [record.outcome for record in found.records()] == ["error", "timeout"]


def test_without_a_scheduler_it_is_said_where_none_answers(monkeypatch):
    monkeypatch.setattr("rocs_bt.search.cluster._PATIENCE", 0.2)
    with pytest.raises(InputError, match="no Dask scheduler answers at"):
        dask_executor("tcp://127.0.0.1:9").__enter__()


def _pids(cluster):
    with distributed.Client(cluster.scheduler_address) as client:
        return client.run(os.getpid)
