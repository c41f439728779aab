"""Nav2's control nodes against small models of their rules, with random outcomes of the children."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocs_bt.trees.error import TreeError
from rocs_bt.trees.status import RUNNING

from .scripted import Bench


class Model:
    """Rules of one node: `tick` takes a function from the index of a child to its next letter."""

    def __init__(self, count, **ports):
        self.count, self.ports = count, ports
        self.reset()

    def reset(self):
        self.at = self.tries = self.failed = 0


class Pipeline(Model):
    def tick(self, child):
        letters = []
        for i in range(self.count):
            letters.append(child(i))
            if letters[i] == "F":
                self.reset()
                return "F"
            if letters[i] == "R" and i >= self.at:
                self.at = i
                return "R"
        self.reset()
        return "K" if set(letters) == {"K"} else "S"


class Recovery(Model):
    def tick(self, child):
        limit = self.ports["number_of_retries"]
        while True:
            if self.at == 0:
                letter = child(0)
                if letter == "R":
                    return "R"
                if letter != "F" or self.tries >= limit:
                    self.reset()
                    return letter
            letter = child(1)
            self.at = 1
            if letter == "R":
                return "R"
            if letter == "F":
                self.reset()
                return "F"
            self.at = 0
            if letter == "K":
                return "F"  # the number of retries stays
            self.tries += 1


class Robin(Model):
    def tick(self, child):
        skipped = 0
        while self.failed + skipped < self.count:
            letter = child(self.at)
            if letter == "R":
                return "R"
            self.at += 1
            last = self.at == self.count
            self.failed += letter == "F"
            skipped += letter == "K"
            if last and not self.ports["wrap_around"]:
                break
            self.at %= self.count
            if letter == "S":
                self.failed = 0
                return "S"
        self.reset()
        return "K" if skipped == self.count else "F"


class Nonblocking(Model):
    def tick(self, child):
        letters = []
        for i in range(self.count):
            letters.append(child(i))
            if letters[-1] == "F":
                return "F"
        return "S" if set(letters) == {"S"} else "R"


class Persistent(Model):
    def __init__(self, count, **ports):
        self.key = 0
        super().__init__(count, **ports)

    def tick(self, child):
        while self.key < self.count:
            letter = child(self.key)
            if letter == "R":
                return "R"
            if letter == "F":
                self.key = 0
                return "F"
            self.key += 1
        self.key = 0
        return "S"


class PauseResume(Model):
    """States are the indices of the children: run, paused, on pause, on resume."""

    def tick(self, child, paused=False):
        if paused and self.at in (0, 3):
            self.at = 2
        elif not paused and self.at in (1, 2):
            self.at = 3
        after = {2: 1, 3: 0}
        if self.at >= self.count:
            self.at = after.get(self.at, self.at)
            return "R"
        letter = child(self.at)
        if letter == "F" or (letter in "SK" and self.at == 0):
            self.reset()
            return "F" if letter == "F" else "S"
        if letter in "SK":
            self.at = after.get(self.at, self.at)
        return "R"


MODELS = {
    "PipelineSequence": (Pipeline, "SFRK"),
    "RecoveryNode": (Recovery, "SFRK"),
    "RoundRobin": (Robin, "SFRK"),
    "NonblockingSequence": (Nonblocking, "SFR"),
    "PersistentSequence": (Persistent, "SFRK"),
    "PauseResumeController": (PauseResume, "SFRK"),
}
PORTS = {
    "RecoveryNode": st.fixed_dictionaries({"number_of_retries": st.integers(0, 3)}),
    "RoundRobin": st.fixed_dictionaries({"wrap_around": st.booleans()}),
}
STEPS = st.lists(st.sampled_from(["tick", "tick", "tick", "tick", "halt", "pause"]), min_size=1, max_size=12)


@pytest.mark.parametrize("tag", MODELS)
@given(data=st.data())
def test_a_control_node_does_what_its_model_does(tag, data):
    model, letters = MODELS[tag]
    count = 2 if tag == "RecoveryNode" else data.draw(st.integers(1, 4))
    scripts = [data.draw(st.text(letters, min_size=1, max_size=6)) for _ in range(count)]
    ports = data.draw(PORTS.get(tag, st.just({})))
    bench, rules = Bench(), model(count, **ports)
    keys = {"PersistentSequence": {"current_child_idx": "{at}"}, "PauseResumeController": {"paused": "{paused}"}}
    root = bench.node(tag, *scripts, **ports, **keys.get(tag, {}))
    bench.tree(root, at=0, paused=False)
    calls, expected, paused = [0] * count, [], False

    def child(i):
        letter = scripts[i][min(calls[i], len(scripts[i]) - 1)]
        calls[i] += 1
        expected.append(f"{chr(65 + i)}={letter}")
        return letter

    for step in data.draw(STEPS):
        if step == "halt":
            if root.status is RUNNING:
                bench.built.halt()
                rules.reset()
            continue
        if step == "pause":
            paused = not paused
            bench.built.board["paused"] = paused
        expected.clear()
        outcome = rules.tick(child, paused) if tag == "PauseResumeController" else rules.tick(child)
        found = bench.tick().split()
        ticked = [f"{word[0]}={word[-1]}" for word in found[1:] if not word.endswith("halt")]
        names = {"SUCCESS": "S", "FAILURE": "F", "RUNNING": "R", "SKIPPED": "K"}
        assert (names[found[0]], ticked) == (outcome, expected)
        if outcome in "SFK":
            running = [c.name for c in root.children if c.status is RUNNING]
            assert not running or (tag == "RecoveryNode" and outcome == "F")
        if tag == "PersistentSequence":
            assert bench.built.board["at"] == rules.key


def test_before_lyrical_the_last_child_of_a_round_robin_is_as_good_as_the_others(bench):
    bench.of("RoundRobin", "S", "S")
    assert bench.ticks(2) == ["SUCCESS A.start=S", "FAILURE B.start=S"]
    again = Bench().of("RoundRobin", "S", "S", wrap_around=True)
    assert again.ticks(3) == ["SUCCESS A.start=S", "SUCCESS B.start=S", "SUCCESS A.start=S"]


def test_a_key_without_a_value_counts_as_the_default(bench):
    bench.tree(bench.node("RecoveryNode", "F", "S", number_of_retries="{nothing}"))
    assert bench.tick() == "FAILURE A.start=F B.start=S A.start=F"
    with pytest.raises(TreeError, match="at"):
        Bench().of("PersistentSequence", "S", current_child_idx="{at}").tick()


def test_a_nonblocking_sequence_has_no_skipped_children():
    with pytest.raises(TreeError, match="SKIPPED"):
        Bench().of("NonblockingSequence", "K").tick()
