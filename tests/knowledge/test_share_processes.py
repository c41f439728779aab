"""Real processes on loopback, over zenoh: one is killed, another cannot tell the time, and strangers knock."""

from __future__ import annotations

import json
import signal
import socket
import subprocess
import sys
from datetime import UTC, datetime
from pathlib import Path

import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.share.keys import MemberKeys, make_keys
from rocs_bt.share.zenoh_network import ZenohNetwork, check_address

from .. import needs
from ..waiting import GUARD, until

needs.package("zenoh")

PROGRAM = Path(__file__).with_name("share_process.py")


class Process:
    def __init__(self, name, listen, peers, keys="", error=0.0, within=()):
        command = [*within, sys.executable, str(PROGRAM), name, listen, str(keys), str(error), *peers]
        self.popen = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        assert json.loads(self.popen.stdout.readline()) == "ready"

    def do(self, line):
        self.popen.stdin.write(line + "\n")
        self.popen.stdin.flush()
        return json.loads(self.popen.stdout.readline())

    def kill(self):
        self.popen.send_signal(signal.SIGKILL)
        self.end()

    def end(self):
        self.popen.stdin.close()
        self.popen.wait(GUARD)
        self.popen.stdout.close()


@pytest.fixture
def processes():
    started = []

    def start(*args, **kwargs):
        started.append(Process(*args, **kwargs))
        return started[-1]

    yield start
    for process in started:
        if process.popen.poll() is None:
            process.end()


def free_ports(count):
    sockets = [socket.socket() for _ in range(count)]
    for each in sockets:
        each.bind(("127.0.0.1", 0))
    ports = [each.getsockname()[1] for each in sockets]
    for each in sockets:
        each.close()
    return [f"127.0.0.1:{port}" for port in ports]


def agree(*processes):
    """What all say, when they say the same and have told all."""
    said = [process.do("ask") for process in processes]
    if any(s["pending"] or s["acknowledged"] < s["written"] for s in said) or not all(s["peers"] for s in said):
        return None
    return said if all(s["live"] == said[0]["live"] and s["graph"] == said[0]["graph"] for s in said) else None


def pass_time(first, second):
    """Let so much pass between two that share that whoever is heard at all is heard by now."""
    for i in range(20):
        (first if i % 2 else second).do(f"set box {i}")
        until(lambda: agree(first, second))


@pytest.mark.parametrize("secure", [False, True], ids=["plain", "tls"])
def test_one_is_killed_and_comes_back_and_all_are_equal(processes, tmp_path, secure):
    addresses = free_ports(3)
    folders = make_keys(tmp_path / "keys", ["R0", "R1", "R2"], datetime.now(UTC)) if secure else ["", "", ""]

    def start(i, error=0.0):
        others = [a for a in addresses if a != addresses[i]]
        return processes(f"R{i}", addresses[i], others, keys=folders[i], error=error)

    first, second, third = start(0), start(1, error=1e7), start(2, error=-3600.0)
    for i, process in enumerate((first, second, third)):
        process.do(f"add box{i}")
        process.do("add common")
        process.do(f"set common {i}")
    until(lambda: agree(first, second, third))
    third.do("set box2 7")
    until(lambda: (said := third.do("ask"))["acknowledged"] == said["written"])
    third.kill()
    for i in range(50):
        first.do(f"set box0 {i}")
        second.do(f"set box1 {i}")
    second.do("remove common")
    until(lambda: first.do("ask")["peers"] == ["R1"])
    back = start(2)
    back.do("set box2 8") if "box2" in until(lambda: back.do("ask")["graph"]) else None
    said = until(lambda: agree(first, second, back))[0]
    assert said["graph"] == {
        "box0": {"radius": 49.0},
        "box1": {"radius": 49.0},
        "box2": {"radius": said["graph"]["box2"]["radius"]},
    }
    assert said["graph"]["box2"]["radius"] in (7.0, 8.0)  # acknowledged before the kill, or written after it
    assert back.do("say R0 hello") is True
    assert first.do("ask")["letters"] == ["hello"]
    assert first.do("ask")["counts"]["unauthenticated"] == 0


def test_who_comes_first_finds_who_comes_later_and_they_find_each_other_through_it(processes):
    addresses = free_ports(3)
    early = [processes(f"R{i}", addresses[i], addresses[:1]) for i in (1, 2)]
    late = processes("R0", addresses[0], [])
    for process in early:
        process.do("add box")
    until(lambda: all(len(process.do("ask")["peers"]) == 2 for process in (late, *early)))
    assert until(lambda: agree(late, *early))[0]["graph"] == {"box": {}}


def test_who_has_no_key_of_the_group_is_not_heard(processes, tmp_path):
    addresses = free_ports(3)
    group = make_keys(tmp_path / "keys", ["R0", "R1"], datetime.now(UTC))
    (stranger,) = make_keys(tmp_path / "others", ["M"], datetime.now(UTC))
    first = processes("R0", addresses[0], addresses[1:2], keys=group[0])
    second = processes("R1", addresses[1], addresses[:1], keys=group[1])
    third = processes("M", addresses[2], addresses[:2], keys=stranger)
    first.do("add box")
    third.do("add evil")
    until(lambda: agree(first, second))
    pass_time(first, second)
    assert third.do("ask")["peers"] == []
    for process in (first, second):
        said = process.do("ask")
        assert "M" not in said["peers"]
        assert list(said["graph"]) == ["box"]
    assert list(third.do("ask")["graph"]) == ["evil"]


def test_a_member_of_the_line_without_the_secret_is_counted(processes, tmp_path):
    """On loopback lines are open to every user of the host; the group's secret is what tells members apart."""
    (address,) = free_ports(1)
    folders = make_keys(tmp_path / "keys", ["R0", "R1"], datetime.now(UTC))
    (folders[1] / "group.key").write_bytes(b"x" * 32)
    first = processes("R0", address, [], keys=folders[0])
    liar = processes("R1", "127.0.0.1:0", [address], keys=folders[1])
    liar.do("add evil")
    counts = until(lambda: (c := first.do("ask")["counts"])["unauthenticated"] and c)
    assert counts["merged"] == 0
    assert first.do("ask")["graph"] == {}


def test_off_loopback_needs_keys_and_says_how_to_get_them(tmp_path):
    for address in ("0.0.0.0:7447", "192.168.1.5:7447", "robot.local:7447", "[::]:7447"):
        with pytest.raises(InputError, match="is not on this host; sharing with other hosts needs keys"):
            check_address(address, private=False)
        check_address(address, private=True)
    for address in ("127.0.0.1:7447", "localhost:0", "[::1]:7447"):
        check_address(address, private=False)
    for address in ("7447", "host:", ":7447", "host:port", "host:70000"):
        with pytest.raises(InputError, match="is not an address"):
            check_address(address, private=True)
    with pytest.raises(InputError, match="is not on this host"):
        ZenohNetwork("127.0.0.1:0", ["10.0.0.1:7447"])
    with pytest.raises(InputError, match=r"lacks authority\.pem, member\.pem, member\.key, group\.key"):
        MemberKeys.read(tmp_path)


def test_an_address_that_is_taken_is_an_error_that_says_so():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        with pytest.raises(InputError, match="Is the address taken"):
            ZenohNetwork(f"127.0.0.1:{taken.getsockname()[1]}")


def test_keys_are_private_and_signed_by_the_group(tmp_path):
    from cryptography import x509

    (one,) = make_keys(tmp_path, ["R2"], datetime.now(UTC))
    (two,) = make_keys(tmp_path, ["R3"], datetime.now(UTC))
    authority = x509.load_pem_x509_certificate((tmp_path / "authority.pem").read_bytes())
    for folder in (one, two):
        assert all(file.stat().st_mode & 0o077 == 0 for file in folder.iterdir())
        member = x509.load_pem_x509_certificate((folder / "member.pem").read_bytes())
        member.verify_directly_issued_by(authority)
        assert not (folder / "authority.key").exists()
        assert MemberKeys.read(folder).secret == MemberKeys.read(one).secret
    with pytest.raises(InputError, match="has keys already"):
        make_keys(tmp_path, ["R2"], datetime.now(UTC))
    with pytest.raises(InputError, match="cannot name a member"):
        make_keys(tmp_path, ["../evil"], datetime.now(UTC))
