"""Hosts that a cable joins: network namespaces under keys, one host is cut off while both sides write, one is killed.

What runs here is what runs between robots, and nothing of it is on loopback. Needs the right to make namespaces.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from datetime import UTC, datetime

import pytest

from rocs_bt.share.keys import make_keys

from .. import needs
from ..waiting import GUARD, until
from . import test_share_processes as processes
from .test_share_processes import agree, pass_time

needs.package("zenoh")

PORT = 7447


def ip(*words):
    return subprocess.run(["ip", *words], check=True, capture_output=True, text=True)


class Hosts:
    """Namespaces, each with an address of its own, on one switch."""

    def __init__(self, count):
        self.mark = f"rocs{os.getpid()}"
        self.switch = f"{self.mark}s"
        self.names = [f"{self.mark}h{i}" for i in range(count)]
        self.addresses = [f"10.77.0.{i + 1}:{PORT}" for i in range(count)]

    def make(self):
        ip("netns", "add", self.switch)
        ip("-n", self.switch, "link", "add", "bridge", "type", "bridge")
        ip("-n", self.switch, "link", "set", "bridge", "up")
        for i, name in enumerate(self.names):
            ip("netns", "add", name)
            ip("-n", name, "link", "add", "cable", "type", "veth", "peer", "name", f"port{i}", "netns", self.switch)
            ip("-n", self.switch, "link", "set", f"port{i}", "master", "bridge", "up")
            ip("-n", name, "addr", "add", f"10.77.0.{i + 1}/24", "dev", "cable")
            ip("-n", name, "link", "set", "cable", "up")

    def remove(self):
        for name in (self.switch, *self.names):
            subprocess.run(["ip", "netns", "del", name], check=False, capture_output=True)

    def cable(self, host, state):
        ip("-n", self.switch, "link", "set", f"port{host}", state)

    def within(self, host):
        """What a command begins with that is to run on a host."""
        return ("ip", "netns", "exec", self.names[host])


@pytest.fixture
def hosts():
    if shutil.which("ip") is None or os.geteuid() != 0:
        pytest.skip("needs the command `ip` (iproute2) and the right to make network namespaces")
    found = Hosts(4)
    try:
        found.make()
        yield found
    except subprocess.CalledProcessError as error:
        pytest.skip(f"this machine allows no network namespaces: {error.stderr.strip()}")
    finally:
        found.remove()


@pytest.fixture
def group(hosts, tmp_path):
    """A process on each of three hosts, under keys; and what else is needed to start one."""
    folders = make_keys(tmp_path / "keys", ["R0", "R1", "R2"], datetime.now(UTC))
    started = []

    def start(i, error=0.0):
        others = [a for a in hosts.addresses[:3] if a != hosts.addresses[i]]
        listen = f"0.0.0.0:{PORT}"
        started.append(processes.Process(f"R{i}", listen, others, folders[i], error, hosts.within(i)))
        return started[-1]

    yield start
    for process in started:
        if process.popen.poll() is None:
            process.end()


@pytest.mark.soak
def test_hosts_that_were_cut_off_and_one_that_was_killed_all_know_the_same_in_the_end(hosts, group):
    first, second, third = group(0), group(1, error=1e7), group(2, error=-3600.0)
    for i, process in enumerate((first, second, third)):
        process.do(f"add box{i}")
        process.do("add common")
    until(lambda: agree(first, second, third))
    hosts.cable(0, "down")
    until(lambda: first.do("ask")["peers"] == [] and second.do("ask")["peers"] == ["R2"])
    for i in range(20):
        first.do(f"set box0 {i}")
        second.do(f"set common {100 + i}")
        first.do(f"set common {i}")
    third.do("remove box1")
    third.do("set box2 7")
    until(lambda: (said := third.do("ask"))["acknowledged"] == said["written"])  # by R1, who is all that is there
    third.kill()
    hosts.cable(0, "up")
    back = group(2)
    graph = until(lambda: agree(first, second, back))[0]["graph"]
    # R1's clock is 115 days ahead, and neither knew of the other's writes: its value stays.
    assert graph == {"box0": {"radius": 19.0}, "box2": {"radius": 7.0}, "common": {"radius": 119.0}}
    assert back.do("say R0 hello") is True
    assert first.do("ask")["letters"] == ["hello"]


STRANGER = """
import socket, ssl, sys
host, _, port = sys.argv[1].rpartition(":")
line = socket.create_connection((host, int(port)), 10.0)
line.settimeout(10.0)
said = b""
try:
    if sys.argv[2] == "tls":
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
        context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
        line = context.wrap_socket(line)
    line.sendall(bytes(64))
    said = line.recv(4096)
except ssl.SSLError as error:
    print(error.reason)
except ConnectionError as error:
    print("closed")
else:
    print("closed" if not said or said[:1] == bytes([21]) else "served")
"""
"""Connects, with or without TLS but with no certificate, and says how it was received; 21 is a TLS alert."""


@pytest.mark.soak
def test_off_loopback_who_shows_no_certificate_is_not_served(hosts, group, tmp_path):
    first, second = group(0), group(1)
    first.do("add box")
    until(lambda: agree(first, second))
    for how, answers in (("tls", {"TLSV13_ALERT_CERTIFICATE_REQUIRED"}), ("plain", {"closed"})):
        command = [*hosts.within(3), sys.executable, "-c", STRANGER, hosts.addresses[0], how]
        said = subprocess.run(command, check=True, capture_output=True, text=True, timeout=GUARD).stdout.strip()
        assert said in answers, how
    (folder,) = make_keys(tmp_path / "others", ["M"], datetime.now(UTC))
    other = processes.Process("M", f"0.0.0.0:{PORT}", hosts.addresses[:2], folder, 0.0, hosts.within(3))
    other.do("add evil")
    pass_time(first, second)
    assert other.do("ask")["peers"] == []
    other.end()
    for process in (first, second):
        said = process.do("ask")
        assert list(said["graph"]) == ["box"]
        assert len(said["peers"]) == 1
