"""The link to an isolated actuator, and the process at its other end."""

from __future__ import annotations

import os
import signal
import subprocess
import time

import psutil
import pytest

from rocs_bt.base.errors import ActuatorError, DeviceError, InputError
from rocs_bt.devices.isolated import DeviceMaker, IsolatedActuator, actuator, silence

from ..isolated import WHEELS, linked
from ..waiting import until

END = ["neutral", "neutral", "neutral", "closed"]
MAX_AGE = 0.5  # [s]; a command that is held up for longer on a loaded machine would be dropped


def commands(log):
    return [line.values for line in log.lines if line.what == "command"]


def until_neutral(log):
    return log.until(lambda line: line.what == "neutral")


def until_commanded(log):
    return log.until(lambda line: line.what == "command")


def failure(link):
    """What the link's supervisor finds at last."""
    until(lambda: link.check() is not None)
    found = link.check()
    with pytest.raises(ActuatorError) as caught:
        link.command([0.1, 0.1])
    assert caught.value is found
    return found.kind, str(found)


def test_the_process_is_small_and_of_a_session_of_its_own(tmp_path):
    with linked(tmp_path) as (link, log):
        assert link.size == 2
        link.command([0.1, 0.2])
        assert until_commanded(log).values == (0.1, 0.2)
        number, session, *heavy = log.lines[0].values
        assert number == session != str(os.getsid(0))
        assert heavy == []
    assert log.last == END


def test_without_commands_it_goes_to_neutral_once_and_waits(tmp_path):
    with linked(tmp_path, max_age=MAX_AGE) as (link, log):
        link.command([0.1, 0.1])
        assert log.stop()[1] <= MAX_AGE + 0.05
        time.sleep(2 * MAX_AGE)  # no further neutral follows
        link.command([0.3, 0.3])
        assert until_commanded(log).values == (0.3, 0.3)
        until_neutral(log)  # by age again, so that the closing neutrals are counted alone
    stops = [line.what for line in log.lines if line.what != "late"]
    assert stops == ["process", "command", "neutral", "command", "neutral", *END]


def test_of_the_commands_that_wait_the_newest_is_performed(tmp_path):
    with linked(tmp_path, "waits") as (link, log):
        link.command([1.0, 1.0])
        until_commanded(log)
        for count in range(2, 100):
            link.command([float(count), 0.0])
        (tmp_path / "log.go").write_text("go")
        while until_commanded(log).values != (99.0, 0.0):
            pass
    first, *others = commands(log)
    assert first == (1.0, 1.0)
    assert len(others) < 98  # one, if all had come by then
    assert others == sorted(others)


def test_neutral_neither_waits_for_a_command_nor_is_overtaken_by_it(tmp_path):
    with linked(tmp_path, "waits") as (link, log):
        link.command([1.0, 1.0])
        until_commanded(log)
        link.command([2.0, 2.0])
        link.neutral()
        until_neutral(log)
        (tmp_path / "log.go").write_text("go")
        until_neutral(log)  # the command that was on its way ends in neutral; the one that waited is gone
        link.command([3.0, 3.0])
        until_commanded(log)
    assert commands(log) == [(1.0, 1.0), (3.0, 3.0)]


def test_requests_to_a_process_that_is_stopped_do_not_wait(tmp_path):
    with linked(tmp_path) as (link, log):
        os.kill(int(log.begin().until(lambda line: line.what == "process").values[0]), signal.SIGSTOP)
        for _ in range(5000):  # far more than the link's buffer holds
            link.command([1.0, 1.0])
        os.kill(log.process, signal.SIGCONT)
        log.until(lambda line: line.what == "command")
    assert log.last == END


def stopped(process):
    os.kill(process, signal.SIGSTOP)


def killed(process):
    os.kill(process, signal.SIGKILL)


DEATHS = {
    "killed": (killed, "ended", "its process was ended by SIGKILL"),
    "stopped": (stopped, "hung", " s: the driver hangs, or the process was stopped"),
    "holds the interpreter": (None, "hung", " s: the driver hangs, or the process was stopped"),
    "exits": (None, "ended", "its process ended with exit code 7"),
    "crashes": (None, "ended", "its process was ended by SIGSEGV"),
}


@pytest.mark.parametrize("two_owners", [True, False])
@pytest.mark.parametrize("death", DEATHS)
def test_after_the_death_of_the_process_the_main_process_sends_neutral(tmp_path, death, two_owners):
    strike, kind, words = DEATHS[death]
    if kind == "hung":
        words = (" for 1" if two_owners else "its process has not answered for 0.54") + words
    with linked(tmp_path, death, max_age=MAX_AGE, two_owners=two_owners) as (link, log), log.kept_open():
        for _ in range(20):
            link.command([0.1, 0.1])
            until_commanded(log)
        if strike is not None:
            strike(log.process)
        link.command([0.1, 0.1])
        for _ in range(3):
            until_neutral(log)
        found = failure(link)
        assert not psutil.pid_exists(log.process)  # it was killed: it never commands again
        link.neutral()  # as at the end of the run
        until_neutral(log)
    # A system that writes the memory of a crash to disk holds the process for so long that it counts as hung.
    assert death == "crashes" or (found[0] == kind and words in found[1])
    opened = [line.what for line in log.lines].count("process")
    assert opened == 2
    assert not commands(log)[20:]
    assert log.last == ["neutral", "neutral", "neutral", "closed"] or log.last == [*END[1:]]


def test_a_silent_process_is_late_while_the_standby_stops_the_device_and_then_goes_on(tmp_path):
    """As a publisher of Fast DDS that waits for 0.33 s while a peer in shared memory is checked."""
    with linked(tmp_path, max_age=MAX_AGE, two_owners=True) as (link, log):
        link.command([0.1, 0.1])
        until_commanded(log)
        os.kill(log.process, signal.SIGSTOP)
        link.command([0.1, 0.1])
        until(lambda: link.late)
        until_neutral(log)  # of the standby: the process is stopped
        os.kill(log.process, signal.SIGCONT)
        until(lambda: not link.late)
        link.command([0.2, 0.2])
        assert until_commanded(log).values == (0.2, 0.2)  # the command that waited is too old
        assert link.check() is None


@pytest.mark.parametrize("two_owners", [True, False])
def test_a_command_in_which_the_process_was_stopped_is_followed_by_neutral_at_once(tmp_path, monkeypatch, two_owners):
    """Nothing can take back the command that the system was about to send; it must not last."""
    monkeypatch.setattr(silence, "HUNG", 600.0)  # it is not killed, however late this test continues it
    monkeypatch.setattr(silence, "GRACE", 0.0 if two_owners else 600.0)
    with linked(tmp_path, "is stopped", max_age=MAX_AGE, two_owners=two_owners) as (link, log):
        for _ in range(19):
            link.command([0.1, 0.1])
            until_commanded(log)
        link.command([0.2, 0.2])
        until(lambda: psutil.Process(log.process).status() == psutil.STATUS_STOPPED)
        time.sleep(1.1 * MAX_AGE)
        os.kill(log.process, signal.SIGCONT)
        assert until_commanded(log).values == (0.2, 0.2)
        assert log.stop()[1] < 0.5 * MAX_AGE
        link.command([0.3, 0.3])
        assert until_commanded(log).values == (0.3, 0.3)
        assert link.check() is None


def test_a_device_that_cannot_be_opened_again_is_reported(tmp_path):
    with linked(tmp_path, max_age=MAX_AGE) as (link, log):
        link.command([0.1, 0.1])
        until_commanded(log)
        (tmp_path / "wheels.py").write_text("Wheels = 1\n")
        os.kill(log.process, signal.SIGKILL)
        kind, why = failure(link)
    assert kind == "ended"
    assert "was ended by SIGKILL; the main process cannot send neutral: " in why


def test_a_command_that_was_held_up_on_its_way_does_not_move_the_robot(tmp_path, monkeypatch):
    with linked(tmp_path, max_age=MAX_AGE) as (link, log):
        with monkeypatch.context() as patch:
            now = actuator.time.monotonic()
            patch.setattr(actuator.time, "monotonic", lambda: now - MAX_AGE)
            link.command([9.0, 9.0])
        until(lambda: link._answered == 1)  # it was dropped
        link.command([0.1, 0.1])
        until_commanded(log)
    assert commands(log) == [(0.1, 0.1)]


def test_a_command_waits_for_a_neutral_that_came_before_it(tmp_path):
    with linked(tmp_path, "stops slowly") as (link, log):
        link.neutral()
        until_neutral(log)
        link.command([1.0, 1.0])
        link._channel.wait(0.2)  # nothing is answered meanwhile
        (tmp_path / "log.go").write_text("go")
        until_commanded(log)
    assert [line.what for line in log.lines if line.what != "late"][1:4] == ["neutral", "stopped", "command"]


@pytest.mark.parametrize(
    ("plan", "kind", "words"),
    [
        ("refuses", "raised", "the fuse blew"),
        ("raises", "raised", "RuntimeError: a worm (wheels.py:"),
        ("calls for an exit", "raised", "SystemExit(7) (wheels.py:"),
        ("hangs", "hung", " s: the driver hangs"),  # its neutral may answer late on a busy machine
        ("hangs for good", "hung", "its process has not answered for 0.54 s: the driver hangs"),
    ],
)
def test_a_driver_that_fails_is_sent_to_neutral_and_reported(tmp_path, plan, kind, words):
    with linked(tmp_path, plan, max_age=MAX_AGE) as (link, log):
        for _ in range(20):
            link.command([0.1, 0.1])
            until_commanded(log)
        until_neutral(log)
        found = failure(link)
    assert found[0] == kind
    assert words in found[1]
    assert len(commands(log)) == 20


def test_a_neutral_that_raises_is_reported(tmp_path):
    with linked(tmp_path, "does not stop") as (link, log):
        link.neutral()
        until_neutral(log)
        kind, why = failure(link)
    assert kind == "raised"
    assert why.startswith("OSError: the wire is cut (wheels.py:")
    assert "the main process cannot send neutral: OSError: the wire is cut" in why
    assert log.last == END


def test_the_main_process_stops_a_device_whose_driver_cannot_stop_it_in_its_process(tmp_path):
    with linked(tmp_path, "does not stop apart") as (link, log):
        link.neutral()
        until_neutral(log)
        kind, why = failure(link)
        assert not psutil.pid_exists(log.process)
    assert (kind, why.partition(" (")[0]) == ("raised", "OSError: the wire is cut")
    assert "cannot send neutral" not in why
    assert log.last == END


@pytest.mark.parametrize(("number", "code"), [(signal.SIGTERM, 143), (signal.SIGHUP, 129)])
def test_a_signal_to_the_process_is_neutral_first(tmp_path, number, code):
    with linked(tmp_path) as (link, log):
        link.command([0.1, 0.1])
        until_commanded(log)
        os.kill(log.process, signal.SIGINT)  # for the main process: Ctrl-C in a terminal
        os.kill(log.process, number)
        until_neutral(log)
        link.command([0.3, 0.3])  # it hears no commands any more
        log.until(lambda line: line.what == "closed")
        assert log.last == END
        assert commands(log) == [(0.1, 0.1)]
        assert failure(link) == ("ended", f"its process ended with exit code {code}")


def test_a_process_that_does_not_end_is_killed(tmp_path, monkeypatch):
    monkeypatch.setattr(actuator, "EXIT_TIMEOUT", 0.1)
    with linked(tmp_path) as (link, log):
        link.command([0.1, 0.1])
        until_commanded(log)
        os.kill(log.process, signal.SIGSTOP)
        link.close()
        log.end()
    assert log.last[-1] == "command"


@pytest.mark.parametrize(
    ("plan", "error", "words"),
    [
        ("absent", DeviceError, "there is no robot at the other end"),
        ("raises at the start", InputError, "RuntimeError: a worm"),
        ("dies at the start", DeviceError, "its process ended with exit code 7 before the device was ready"),
    ],
)
def test_a_driver_that_cannot_start_is_reported(tmp_path, plan, error, words):
    with pytest.raises(error, match=words) as caught, linked(tmp_path, plan):
        pass
    if error is InputError:
        (fault,) = caught.value.faults
        assert fault.file == tmp_path / "wheels.py"
        assert WHEELS.splitlines()[fault.line - 1].strip() == 'raise RuntimeError("a worm")'


def test_an_interrupt_while_it_starts_leaves_no_process(tmp_path, monkeypatch):
    started = []
    make = subprocess.Popen

    def popen(*args, **kwargs):
        started.append(make(*args, **kwargs))
        return started[-1]

    def interrupted(*args):
        raise KeyboardInterrupt

    monkeypatch.setattr(subprocess, "Popen", popen)
    monkeypatch.setattr(actuator.Channel, "wait", interrupted)
    with pytest.raises(KeyboardInterrupt), linked(tmp_path):
        pass
    assert started[0].returncode is not None


def test_what_the_driver_shares_is_closed(tmp_path, monkeypatch):
    monkeypatch.setattr(actuator, "EXIT_TIMEOUT", 60.0)
    (tmp_path / "sharing.py").write_text(SHARING)
    link = IsolatedActuator(
        DeviceMaker(tmp_path / "sharing.py", "Wheels", "wheels", {"folder": str(tmp_path)}), MAX_AGE
    )
    link.close()
    link.close()
    assert sorted(p.name for p in tmp_path.glob("closed *")) == ["closed line", "closed wheels"]


SHARING = """
from pathlib import Path

from rocs_bt import Actuator


class Line:
    def __init__(self, folder):
        self.folder = folder

    def close(self):
        Path(self.folder, "closed line").touch()


class Wheels(Actuator):
    folder: str

    def __init__(self, name, host):
        super().__init__(name, 2)
        self.line = host.share("line", lambda: Line(self.folder))

    def command(self, values):
        pass

    def neutral(self):
        pass

    def close(self):
        Path(self.line.folder, "closed wheels").touch()
"""
