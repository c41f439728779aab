"""WorkerPool: an executor that outlives its processes."""

from __future__ import annotations

import os
import select
import signal
import subprocess
import sys
import time
from concurrent.futures import wait

import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.compare.pool import WorkerDied, WorkerPool

from ..waiting import GUARD, until


def square(x):
    return x * x


def where():
    return os.getpid(), os.environ["OMP_NUM_THREADS"], os.environ["TMPDIR"]


def environment():
    return dict(os.environ)


def fail():
    raise InputError("this is wrong.")


def die(signum):
    os.kill(os.getpid(), signum)


def die_once(flag):
    """Dies the first time, and tells that it was tried again the second."""
    if not os.path.exists(flag):
        open(flag, "w").close()
        os.kill(os.getpid(), signal.SIGKILL)
    return "again"


@pytest.fixture(scope="module")
def pool():
    with WorkerPool(2) as made:
        yield made


def test_results_come_back_and_exceptions_are_the_tasks_own(pool):
    assert list(pool.map(square, range(20))) == [x * x for x in range(20)]
    with pytest.raises(InputError, match="this is wrong"):
        pool.submit(fail).result()


def test_scripts_that_a_task_starts_see_their_own_folder(pool):
    assert pool.submit(environment).result().get("PYTHONSAFEPATH") == os.environ.get("PYTHONSAFEPATH")


def test_processes_are_other_ones_kept_and_single_threaded(pool):
    found = {f.result() for f in [pool.submit(where) for _ in range(20)]}
    assert os.getpid() not in {pid for pid, _, _ in found}
    assert len({pid for pid, _, _ in found}) <= 2
    assert {threads for _, threads, _ in found} == {"1"}
    assert os.environ.get("TMPDIR") not in {folder for _, _, folder in found}


def test_a_process_that_dies_is_replaced_and_its_task_tried_again(pool, tmp_path):
    assert pool.submit(die_once, str(tmp_path / "flag")).result() == "again"
    assert pool.submit(square, 3).result() == 9


def test_a_task_that_always_kills_its_process_fails_alone(pool):
    others = [pool.submit(square, x) for x in range(10)]
    with pytest.raises(WorkerDied, match="exit code -9") as died:
        pool.submit(die, signal.SIGKILL).result()
    assert died.value.exit_code == -signal.SIGKILL
    assert [f.result() for f in others] == [x * x for x in range(10)]


def test_a_hurried_end_kills_what_hangs_and_cancels_what_waits():
    pool = WorkerPool(1)
    running, waiting = pool.submit(time.sleep, 600.0), pool.submit(square, 2)
    until(running.running)
    pool.shutdown(cancel_futures=True)
    assert wait([running, waiting], timeout=0).not_done == set()
    assert isinstance(running.exception(), WorkerDied)
    assert waiting.cancelled()
    with pytest.raises(RuntimeError, match="shut down"):
        pool.submit(square, 2)


ORPHAN = """
import os, sys
from rocs_bt.compare.pool import WorkerPool

def spin(path):
    with open(path, "w") as opened:
        print(os.getpid(), file=opened, flush=True)
        while True:
            pass

if __name__ == "__main__":
    WorkerPool(1).submit(spin, sys.argv[1]).result()
"""


def test_a_worker_ends_in_the_midst_of_a_task_when_its_parent_is_killed(tmp_path):
    script, fifo = tmp_path / "sweep.py", tmp_path / "fifo"
    script.write_text(ORPHAN)
    os.mkfifo(fifo)
    with subprocess.Popen([sys.executable, script, fifo]) as parent, open(fifo) as opened:
        worker = int(opened.readline())
        parent.kill()
        parent.wait()
        gone = bool(select.select([opened], [], [], GUARD)[0])  # the worker has the other end for as long as it lives
        if not gone:
            os.kill(worker, signal.SIGKILL)
    assert gone


def test_a_quiet_end_finishes_what_waits():
    pool = WorkerPool(1)
    futures = [pool.submit(square, x) for x in range(5)]
    pool.shutdown()
    assert [f.result() for f in futures] == [0, 1, 4, 9, 16]
