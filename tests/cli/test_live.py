"""`run --live`: the page is told, shown while the run goes on and after it, and goes with Ctrl-C."""

import json
import re
import signal
import socket
import subprocess
import sys
import urllib.request

import pytest

from .. import needs
from ..waiting import GUARD


def test_the_page_stays_after_the_end_until_somebody_interrupts(tmp_path):
    command = [sys.executable, "-m", "rocs_bt", "run", "exp1", "--live", "--for", "0.3", "--no-report"]
    with subprocess.Popen(
        [*command, "--out", tmp_path / "run"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            url = re.fullmatch(r"Live: (http://127\.0\.0\.1:\d+/\S+/)\n", process.stderr.readline())[1]
            assert process.stderr.readline() == "The live page stays open until Ctrl-C.\n"
            told = {}
            with urllib.request.urlopen(url + "events", timeout=GUARD) as stream:
                while "R2|outcome|" not in told:  # a browser that comes at once may hear of the end a moment later
                    line = stream.readline()
                    if line.startswith(b"data: "):
                        told |= {address: v for address, _, _, v, *_ in json.loads(line[6:])["tracks"]}
            assert told["R2|outcome|"][0]["outcome"] == "timeout"
            assert told["R2|pose|"]
            process.send_signal(signal.SIGINT)
            out, err = process.communicate(timeout=GUARD)
        finally:
            process.kill()
    assert (process.returncode, err) == (1, "")
    assert "R2 timeout" in out
    with pytest.raises(OSError, match="refused"):
        urllib.request.urlopen(url, timeout=GUARD)


def test_a_port_that_is_taken_is_told_before_the_run(rocs_bt, tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        told = rocs_bt("run", "exp1", "--live", "--port", taken.getsockname()[1], "--out", tmp_path / "run")
    assert told.code == 2
    assert re.search(r"port \d+ is not available: .*--port", told.err)
    assert not (tmp_path / "run").exists()


STOPPED = """
import fcntl, os, signal, sys
from rocs_bt.cli.main import call
from rocs_bt.studio.live import LivePage

begin = LivePage.begin

def begin_and_stop(page, header):
    fcntl.fcntl(page._process.stdin, fcntl.F_SETPIPE_SZ, 4096)
    os.kill(page._process.pid, signal.SIGSTOP)
    begin(page, header)

LivePage.begin = begin_and_stop
sys.exit(call(sys.argv[1:]))
"""


@needs.linux("can make pipes small")
def test_a_page_that_is_stopped_keeps_neither_the_run_nor_the_command_from_ending(tmp_path):
    command = ["run", "exp1", "--live", "--for", "0.3", "--no-report", "--out", tmp_path / "run"]
    done = subprocess.run([sys.executable, "-c", STOPPED, *command], capture_output=True, text=True, timeout=GUARD)
    assert done.returncode == 1
    assert "R2 timeout" in done.stdout
    assert done.stderr.splitlines()[1:] == [
        "The live page stays open until Ctrl-C.",
        "The live page stopped responding and was closed.",
    ]
