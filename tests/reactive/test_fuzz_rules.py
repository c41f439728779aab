"""Coverage-guided fuzzing of the rule loader and the checker.

Inputs that reach new lines, or go from a line to another one for the first time, are kept and mutated further. Whatever
the input, the only answer besides success is an InputError, within a second of CPU time, and nothing of it is run.
"""

import builtins
import random
import re
import sys
import tempfile
import time
from pathlib import Path

import pytest

import rocs_bt
from rocs_bt.actions import ACTIONS
from rocs_bt.catalog import shipped_root
from rocs_bt.errors import InputError
from rocs_bt.expression import FUNCTIONS, MAX_DEPTH, MAX_LENGTH, MAX_SIZE, Environment
from rocs_bt.expression.parser import MAX_WINDOW
from rocs_bt.reactive import load_rules
from rocs_bt.reactive.analysis import examine_rules
from rocs_bt.signal import Signal
from rocs_bt.units import ANGLE, LENGTH, SPEED, TURN_RATE

INF = float("inf")
ENVIRONMENT = Environment.packed(
    [
        *(Signal(name, 4, (LENGTH,), (0.0, INF), 0.15) for name in ("front", "left_gap", "right_gap", "rear")),
        Signal("goal_distance", 1, (LENGTH,), (0.0, INF), 0.15),
        Signal("speed", 1, (SPEED,), (-1.2, 1.2), 0.15),
        Signal("turn_rate", 1, (TURN_RATE,), (-5.0, 5.0), 0.15),
        Signal("pose", 3, (LENGTH, LENGTH, ANGLE), (-1e6, 1e6), 0.15),
    ]
)


def pieces(file):
    """A rule file with each of its rules alone: small inputs are quick."""
    text = re.sub(r"(?m)(^|\s+)#.*$|^doc = .*\n", "", file.read_text(encoding="utf-8"))  # prose is no use to mutate
    head, *rules = re.split(r"(?m)^(?=\[rule\.\w+\]$)", text)
    return [head + each for each in rules]


SEEDS = [piece for file in sorted((shipped_root() / "rules").glob("*.toml")) for piece in pieces(file)]
SEEDS.append(
    """format = "reflex/1"
[threshold]
near = "0.4 m"
[alias]
gap = "min(left_gap) - min(right_gap)"
[rule.A]
tags = ["safety"]
modes = ["drive"]
when = "held(min(front) < near, 0.2 s) and not once(speed < 0 m/s, 1 s) or since(gap > 0 m, front[0] < 1 m, 2 s)"
until = "time_since(all(front < 0.5 m)) > 1 s and rate(speed, 0.5 s) > 0 m/s2"
for = "0.05 s"
cooldown = "0.5 s"
trigger = "level"
priority = 5
on_invalid = "hold"
max_hold = "0.5 s"
[rule.A.action]
name = "TurnAngle"
angle = "clip(atan2(pose[1], pose[0]) + wrap_angle(pose[2]), -1 rad, 1 rad) * side(dot(front[0:2], [1, -1]))"
[rule.A.action.on_invalid]
angle = "60 deg"
[[rule.A.test]]
given = { front = 3.0, speed = 0.3 }
at = [ { t = 0.00, front = 0.3 }, { t = 0.3 } ]
expect = [ { t = 0.3, fires = true } ]
"""
)
WORDS = [
    *FUNCTIONS, *ENVIRONMENT.names,
    "near", "to_goal", "ahead", "if", "else", "and", "or", "not", "in", "is", "lambda", "inf", "True", "0", "1",
    "0.5 m", "1e308", "1e-320", "9" * 40, "0.1 s", "60 deg", "1 m/s", "2 m2", "-", "+", "*", "/", "**", "//", "%",
    "<", "<=", ">", ">=", "==", "!=", "(", ")", "[", "]", "[0]", "[1:3]", "[-1]", "[99]", ",", ":", ".", "canary()",
    "__import__('os')", "front.__class__", "(lambda: canary())()", "f'{canary()}'", "[canary() for x in front]",
    "always", "implies", "within", '"', "'", '\\', "é", "\x00", "=", "\n", "when", "until", "[rule.B]",
    "priority = 5", 'on_invalid = "trip"', 'include = ["x.toml"]', "{", "}", 'trigger = "level"', 'for = "1 s"',
    'cooldown = "0.5 s"', 'keep = ["angle"]', "name = ", "[alias]", "[threshold]", "[[rule.A.test]]", "-inf m",
]  # fmt: skip
TOKEN = re.compile(r"\w+|\s+|[^\w\s]")
ENGINE = str(Path(rocs_bt.__file__).parent)
WATCHED = tuple(f"{ENGINE}/{room}" for room in ("expression", "reactive", "document", "units", "quantities"))


class Coverage:
    """Which line was followed by which, in the rooms under test."""

    def __init__(self):
        self.seen = set()
        self._calls = {}
        self._new = False

    def __enter__(self):
        self._new, self._before = False, sys.gettrace()
        sys.settrace(self._call)
        return self

    def __exit__(self, *error):
        sys.settrace(self._before)

    @property
    def grew(self):
        return self._new

    def _call(self, frame, event, arg):
        code = frame.f_code
        if not code.co_filename.startswith(WATCHED):
            return None
        calls = self._calls[code] = self._calls.get(code, 0) + 1
        if calls > 200 and calls % 32:
            return None  # what is called all the time has little new to tell, and tracing is slow
        last = 0

        def line(frame, event, arg):
            nonlocal last
            if event == "line":
                step = (code, last, frame.f_lineno)
                last = frame.f_lineno
                if step not in self.seen:
                    self.seen.add(step)
                    self._new = True
            return line

        return line


class Fuzzer:
    """Mutates a corpus, and keeps what reaches something new."""

    def __init__(self, seed):
        self.draw = random.Random(seed)
        self.corpus = list(SEEDS)
        self.coverage = Coverage()
        self.inputs = self.refused = self.slow = 0
        self.slowest = 0.0

    def mutated(self):
        tokens = TOKEN.findall(self.draw.choice(self.corpus))
        for _ in range(self.draw.choice([1, 1, 2, 4, 8])):
            self._mutate(tokens)
        return "".join(tokens)[:20000]

    def _mutate(self, tokens):
        draw = self.draw
        at, size = draw.randrange(len(tokens) + 1), draw.choice([1, 1, 2, 5, 20])
        kind = draw.randrange(8)
        if kind == 0:
            del tokens[at : at + size]
        elif kind == 1:
            tokens.insert(at, draw.choice(WORDS))
        elif kind == 2:
            tokens[at : at + 1] = [draw.choice(WORDS)]
        elif kind == 3:
            tokens[at:at] = tokens[at : at + size] * draw.choice([1, 1, 3, 60])
        elif kind == 4:
            other = TOKEN.findall(draw.choice(self.corpus))
            start = draw.randrange(len(other))
            tokens[at : at + size] = other[start : start + draw.choice([1, 5, 40, 200])]
        elif kind == 5:
            numbers = [i for i, token in enumerate(tokens) if token.isdecimal()]
            if numbers:
                tokens[draw.choice(numbers)] = draw.choice(["0", "1", "3", "7", str(draw.randrange(10**6)), "9" * 400])
        elif kind == 6 and tokens:
            other = draw.randrange(len(tokens))
            here = min(at, len(tokens) - 1)
            tokens[here], tokens[other] = tokens[other], tokens[here]
        else:
            deep = draw.choice([3, 10, 39, 41, 200])
            tokens.insert(at, "(" * deep + draw.choice(WORDS) + ")" * deep)

    def run(self, folder, text):
        """Load and check one input."""
        file = folder / "fuzzed.toml"
        file.write_text(text, encoding="utf-8", errors="surrogatepass")
        self.inputs += 1
        with self.coverage:
            faults = examine_rules(file, ENVIRONMENT, ACTIONS)
        if self.coverage.grew:
            self.corpus.append(text)
        start = time.process_time()
        if self.draw.random() < 0.2 or self.coverage.grew:
            self._handled(file)  # without the tracer, which makes it slow
            took = time.process_time() - start
            self.slowest = max(self.slowest, took)
            assert took < 1.0, f"{took:.2f} s of CPU time for:\n{text}"
        assert all(fault.message and fault.file for fault in faults), text
        assert not CALLED, f"it was run:\n{text}"

    def _handled(self, file):
        faults = examine_rules(file, ENVIRONMENT, ACTIONS)
        wrong = any(not fault.warning for fault in faults)
        try:
            load_rules(file, ENVIRONMENT, ACTIONS)
        except InputError as error:
            self.refused += 1
            assert wrong, f"refused, but called fine by the checker: {error}"
            assert error.faults
        return faults


CALLED = []


@pytest.fixture
def canary(monkeypatch):
    """Where nobody may come: a builtin that tells when it is called."""
    monkeypatch.setattr(builtins, "canary", lambda: CALLED.append(1), raising=False)
    CALLED.clear()


def campaign(seed, inputs, seconds=INF):
    fuzzer, end = Fuzzer(seed), time.monotonic() + seconds
    with tempfile.TemporaryDirectory() as folder:
        for text in SEEDS:
            fuzzer.run(Path(folder), text)
        while fuzzer.inputs < inputs and time.monotonic() < end:
            text = fuzzer.mutated()
            try:
                fuzzer.run(Path(folder), text)
            except RecursionError as error:
                raise AssertionError(f"too deep, with seed {seed}:\n{text}") from error
    return fuzzer


@pytest.mark.usefixtures("canary")
def test_mutated_rule_files_are_read_or_refused():
    fuzzer = campaign(seed=1, inputs=100)
    assert len(fuzzer.corpus) > len(SEEDS) + 5, "coverage guides nothing"
    assert 0 < fuzzer.refused < 2 * fuzzer.inputs


@pytest.mark.soak
@pytest.mark.usefixtures("canary")
def test_mutated_rule_files_are_read_or_refused_for_half_an_hour():
    seed = random.SystemRandom().randrange(10**9)
    print(f"seed {seed}")
    fuzzer = campaign(seed, inputs=10**9, seconds=1800.0)
    print(
        f"{fuzzer.inputs} rule files, {fuzzer.refused} refusals, {len(fuzzer.corpus)} of them reached something new, "
        f"{len(fuzzer.coverage.seen)} steps covered, slowest {fuzzer.slowest:.2f} s of CPU time"
    )


def rule(when):
    return f'format = "reflex/1"\n[rule.A]\nwhen = "{when}"\npriority = 1\n[rule.A.action]\nname = "Stop"\n'


ABSURD = {
    "length": (rule("speed > 0 m/s or " * 100 + "speed > 1 m/s"), f"at most {MAX_LENGTH} characters"),
    "brackets": (rule("(" * 60 + "speed" + ")" * 60 + " > 0 m/s"), f"at most {MAX_DEPTH} deep"),
    "minuses": (rule("-" * 60 + "speed > 0 m/s"), f"at most {MAX_DEPTH} deep"),
    "nots": (rule("not " * 60 + "speed > 0 m/s"), f"at most {MAX_DEPTH} deep"),
    "calls": (rule("min(" * 60 + "speed" + ")" * 60 + " > 0 m/s"), f"at most {MAX_DEPTH} deep"),
    "aliases": (
        'format = "reflex/1"\n[alias]\na0 = "speed + speed"\n'
        + "".join(f'a{i + 1} = "a{i} + a{i}"\n' for i in range(20))
        + rule("a20 > 0 m/s").partition("\n")[2],
        f"at most {MAX_SIZE} operations",
    ),
    "number": (rule("speed > " + "9" * 400 + " m/s"), "too large"),
    "index": (rule("front[" + "9" * 100 + "] > 0 m"), "has 4 values"),
    "window": (rule("held(speed > 0 m/s, 99999 h)"), f"{MAX_WINDOW:g} s"),
    "priority": (rule("speed > 0 m/s").replace("= 1\n", "= " + "9" * 18 + "\n"), "priority is between"),
    "integer": (rule("speed > 0 m/s").replace("= 1\n", "= " + "9" * 30 + "\n"), "more than 64 bits"),
}


@pytest.mark.parametrize("what", ABSURD)
def test_the_absurd_is_refused_with_the_limit(tmp_path, what):
    text, limit = ABSURD[what]
    file = tmp_path / "absurd.toml"
    file.write_text(text, encoding="utf-8")
    start = time.process_time()
    faults = examine_rules(file, ENVIRONMENT, ACTIONS)
    assert time.process_time() - start < 1.0
    assert limit in " ".join(str(fault) for fault in faults)
    with pytest.raises(InputError, match=re.escape(limit)):
        load_rules(file, ENVIRONMENT, ACTIONS)


ATTACKS = [
    "__import__('os').system('x')", "canary()", "(lambda: canary())()", "front.__class__", "[canary() for x in front]",
    "speed if canary() else speed", "f'{canary()}'", "speed > canary", "min(*front)", "(x := canary())", "canary",
]  # fmt: skip


@pytest.mark.usefixtures("canary")
@pytest.mark.parametrize("attack", ATTACKS)
def test_nothing_of_a_rule_file_is_run(tmp_path, attack):
    file = tmp_path / "attack.toml"
    file.write_text(rule(attack), encoding="utf-8")
    assert any(not fault.warning for fault in examine_rules(file, ENVIRONMENT, ACTIONS))
    with pytest.raises(InputError):
        load_rules(file, ENVIRONMENT, ACTIONS)
    assert not CALLED


def test_the_greatest_numbers_are_numbers(tmp_path):
    file = tmp_path / "great.toml"
    file.write_text(rule("speed < 1e307 m/s"), encoding="utf-8")
    assert not any(fault.message.startswith("cannot") for fault in examine_rules(file, ENVIRONMENT, ACTIONS))
