"""RosPublish and RosSubscribe against plain rclpy: what holds on every transport."""

from __future__ import annotations

import time

import pytest

ECHO = """<RetryUntilSuccessful num_attempts="30"><Sequence>
  <RosPublish topic="say" type="std_msgs/msg/String" values="data = {word}" wait="30 s"/>
  <RosSubscribe topic="echo" type="std_msgs/msg/String" values="data -> {heard}" new="true" timeout="1 s"/>
</Sequence></RetryUntilSuccessful>"""  # the first echo is lost if its subscription is discovered last


def talk(transport, servers, at_work):
    tree = at_work(ECHO, transport, word="hello; 'you'")
    for word in ("hello; 'you'", "again"):
        tree.board["word"] = word
        assert tree.end() == "SUCCESS", tree.feedback
        assert servers.until("heard", word) == word
        assert tree.board["heard"] == word


def latched(transport, servers, at_work):
    tree = at_work(ECHO, transport, word="before")
    assert tree.end() == "SUCCESS"
    late = at_work(
        '<RosSubscribe topic="last" type="std_msgs/msg/String" values="data -> {x}" qos="latched"/>', transport
    )
    assert late.end() == "SUCCESS"
    assert late.board["x"] == "before"


def silence(transport, servers, at_work):
    line = '<RosSubscribe topic="beat" type="std_msgs/msg/Int32" values="data -> {n}" qos="sensor_data" {}/>'
    tree = at_work(line.replace("{}", 'max_age="0.5 s" timeout="{t}"'), transport, t="30 s")
    assert tree.end() == "SUCCESS"
    for _ in range(100):
        first = tree.board["n"]
        time.sleep(0.2)
        assert tree.end() == "SUCCESS"
        if tree.board["n"] > first + 1:
            break
    else:
        pytest.fail("each time the next message, not the newest one")
    servers.kill()
    time.sleep(0.6)
    tree.board["t"] = "0 s"
    assert tree.tick() == "FAILURE"
    assert "the newest message is" in tree.feedback


def mismatch(transport, servers, at_work):
    """Texts go to `say`, and `beat` counts by best effort."""
    beat = '<RosSubscribe topic="beat" type="std_msgs/msg/{}" timeout="0 s"/>'
    for line, words in (
        (beat.format("Int32"), ("offered best_effort, requested reliable", 'write qos="sensor_data"')),
        (beat.format("String"), ("publishes std_msgs/msg/Int32", 'write type="std_msgs/msg/Int32"')),
        (
            '<RosPublish topic="say" type="std_msgs/msg/Int32"/>',
            ("subscribes to std_msgs/msg/String", 'write type="std_msgs/msg/String"'),
        ),
    ):
        tree = at_work(line, transport)
        tree.until(lambda tree, words=words: all(word in tree.feedback for word in words))


CASES = (talk, latched, silence, mismatch)
