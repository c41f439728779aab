"""Random trees against the C++ engine: the same outcomes, the same calls and halts, the same board after each tick.

behaviortreepy is BehaviorTree.CPP 4.8.2 with a thin binding; where there is no wheel of it these tests are skipped.
What is left out of the random trees is what docs/bring-a-mission.md lists.
"""

from __future__ import annotations

import random
from dataclasses import dataclass, field
from xml.sax.saxutils import quoteattr

import pytest

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import InputError
from rocs_bt.trees.board import Board
from rocs_bt.trees.btlog import BtLog
from rocs_bt.trees.nodes import BUILTIN, Instant, Leaf, Tree
from rocs_bt.trees.script import compile_script, parse_script
from rocs_bt.trees.status import FAILURE, IDLE, RUNNING, SKIPPED, SUCCESS, outcome_name

from .. import needs

engine = needs.package("behaviortreepy")

OUTCOMES = {"S": SUCCESS, "F": FAILURE, "R": RUNNING, "K": SKIPPED}
NAMES = {"S": "SUCCESS", "F": "FAILURE", "R": "RUNNING", "K": "SKIPPED"}
BEGIN = "x := 1; y := 0; f := 0.5; t := 'a'; h := 0.0"
KEYS = ("x", "y", "f", "t", "h")
NUMBERS = ("x", "y", "f")
TICKS = 9


@dataclass
class Spec:
    """A node of a random tree."""

    tag: str
    attributes: dict[str, str] = field(default_factory=dict)
    children: list[Spec] = field(default_factory=list)
    outcomes: str = ""

    def all(self) -> list[Spec]:
        return [self, *(node for child in self.children for node in child.all())]


class Draw:
    """Draws trees from a seed."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        self.leaves = 0
        self.halts = self.random.random() < 0.3  # `_onHalted` of all nodes at a halt of the tree is theirs alone

    def tree(self) -> Spec:
        return self.node(self.random.choice((1, 1, 1, 2, 2, 2, 3, 4)))

    def node(self, depth: int, guarded: bool = True) -> Spec:
        spec = self.leaf() if depth == 0 or self.random.random() < 0.12 else self.inner(depth - 1)
        if guarded and self.random.random() < 0.4:
            spec.attributes |= self.conditions()
        return spec

    def leaf(self) -> Spec:
        draw = self.random.random()
        if draw < 0.55:
            self.leaves += 1
            kinds = self.random.choice(["SFR", "SSR", "FFR", "SFRRR", "SSFFRK", "RRK"])
            return Spec(f"L{self.leaves}", outcomes="".join(self.random.choices(kinds, k=self.random.randint(1, 7))))
        if draw < 0.7:
            return self.at_once()
        if draw < 0.8:
            return Spec("Script", {"code": self.assignment()})
        if draw < 0.87:
            return Spec("ScriptCondition", {"code": self.truth()})
        return self.random.choice(
            [
                Spec("AlwaysSuccess"),
                Spec("AlwaysFailure"),
                Spec("SetBlackboard", {"value": "{x}", "output_key": "z"}),
                Spec("SetBlackboard", {"value": "text", "output_key": "u"}),
                Spec("WasEntryUpdated", {"entry": "{x}"}),
            ]
        )

    def at_once(self) -> Spec:
        self.leaves += 1
        return Spec(f"Y{self.leaves}", outcomes="".join(self.random.choices("SF", k=self.random.randint(1, 5))))

    def inner(self, depth: int) -> Spec:
        kind = self.random.choice((self.control, self.control, self.decorator, self.branch, self.subtree))
        return kind(depth)

    def children(self, depth: int, count: int) -> list[Spec]:
        return [self.node(depth) for _ in range(count)]

    def control(self, depth: int) -> Spec:
        tags = ("Sequence", "Fallback", "ReactiveSequence", "ReactiveFallback", "AsyncSequence", "AsyncFallback")
        tag = self.random.choice((*tags, "SequenceWithMemory", "Parallel", "ParallelAll", "Parallel"))
        count = self.random.randint(1, 4)
        attributes = {}
        if tag == "Parallel" and self.random.random() < 0.8:
            attributes = {
                "success_count": str(self.random.randint(-count, count)),
                "failure_count": str(self.random.randint(-count, count)),
            }
        elif tag == "ParallelAll":
            attributes = {"max_failures": str(self.random.randint(-count, count))}
        return Spec(tag, attributes, self.children(depth, count))

    def branch(self, depth: int) -> Spec:
        tag = self.random.choice(("IfThenElse", "WhileDoElse", "Switch2", "Switch3"))
        if tag.startswith("Switch"):
            cases = int(tag[-1])
            value = self.random.choice(["{x}", "{y}", "{t}", "{none}"])
            attributes = {"variable": value} | {
                f"case_{i + 1}": self.random.choice(["0", "1", "1.0", "a", "2", "{x}"]) for i in range(cases)
            }
            return Spec(tag, attributes, self.children(depth, cases + 1))
        count = self.random.randint(2, 3)
        condition = self.node(min(depth, 1), guarded=False)
        if condition.tag.startswith("Loop"):
            condition = Spec("Sequence", {}, [condition])  # a node that resets it
        if tag == "IfThenElse" and count == 2:
            condition = self.at_once()
        return Spec(tag, {}, [condition, *self.children(depth, count - 1)])

    def decorator(self, depth: int) -> Spec:
        tag, attributes = self.random.choice(
            [
                ("Inverter", {}),
                ("ForceSuccess", {}),
                ("ForceFailure", {}),
                ("KeepRunningUntilFailure", {}),
                ("Repeat", {"num_cycles": self.random.choice(["0", "1", "2", "3", "-1", "{x}"])}),
                ("RetryUntilSuccessful", {"num_attempts": self.random.choice(["0", "1", "2", "3", "-1", "{x}"])}),
                ("Timeout", {"msec": "100000"}),
                ("RunOnce", {"then_skip": self.random.choice(["true", "false"])}),
                ("Precondition", {"if": self.truth(), "else": self.random.choice(list(NAMES.values()))}),
                ("SkipUnlessUpdated", {"entry": "{y}"}),
                ("WaitValueUpdate", {"entry": "{y}"}),
                ("LoopInt", {"queue": "1;2;3", "value": "{y}", "if_empty": self.random.choice(["SUCCESS", "FAILURE"])}),
                ("LoopString", {"queue": "b;c", "value": "{t}"}),
                ("LoopDouble", {"queue": "0.5;2", "value": "{f}"}),
            ]
        )
        # Theirs does not halt what is under the two that wait for a key, nor asks a halted Precondition again.
        child = self.at_once() if "entry" in attributes or tag == "Precondition" else self.node(depth)
        return Spec(tag, dict(attributes), [child])

    def subtree(self, depth: int) -> Spec:
        if self.random.random() < 0.5:
            attributes = {"_autoremap": "true"}
            if self.random.random() < 0.5:
                attributes |= {"x": self.random.choice(["{y}", "{x}", "{=}"])}
        else:
            attributes = dict.fromkeys(KEYS, "{=}")
            attributes["x"] = self.random.choice(["{y}", "{x}"])
            attributes["y"] = self.random.choice(["{x}", "{y}", "{=}"])
        return Spec("SubTree", attributes, [self.node(depth)])

    def conditions(self) -> dict[str, str]:
        found = {}
        for name in ("_failureIf", "_successIf", "_skipIf", "_while"):
            if self.random.random() < (0.4 if name in ("_skipIf", "_while") else 0.1):
                found[name] = self.truth() if self.random.random() < 0.5 else self.toggle()
        for name in ("_onFailure", "_onSuccess", "_post"):
            if self.random.random() < 0.2:
                found[name] = self.assignment()
        if not self.halts and self.random.random() < 0.4:
            found["_onHalted"] = f"h += {self.random.randint(1, 3)}"
        return found

    def toggle(self) -> str:
        """A condition that the assignments turn often."""
        return f"{self.random.choice('xy')} {self.random.choice(['<', '>='])} {self.random.choice('0123')}"

    def value(self, depth: int = 2) -> str:
        draw = self.random.random()
        if depth == 0 or draw < 0.4:
            return self.random.choice([*NUMBERS, "@x", "0", "1", "2", "3", "0.5", "2.5", "true"])
        if draw < 0.8:
            return f"({self.value(depth - 1)} {self.random.choice('+-*/')} {self.value(depth - 1)})"
        if draw < 0.9:
            return f"({self.truth(depth - 1)} ? {self.value(depth - 1)} : {self.value(depth - 1)})"
        return f"({self.random.choice('-!~')}{self.value(0)})"

    def truth(self, depth: int = 2) -> str:
        draw = self.random.random()
        if draw < 0.6 or depth == 0:
            chain = " ".join(
                f"{self.random.choice(['<', '>', '<=', '>=', '==', '!='])} {self.value(1)}"
                for _ in range(self.random.choice((1, 1, 1, 2)))
            )
            return f"{self.value(1)} {chain}"
        if draw < 0.75:
            return f"t {self.random.choice(['==', '!=', '<'])} '{self.random.choice('abc')}'"
        return f"({self.truth(depth - 1)} {self.random.choice(['&&', '||'])} {self.truth(depth - 1)})"

    def assignment(self) -> str:
        one = self.random.choice(
            [
                f"x = {self.random.choice('0123')}",
                f"y = {self.random.choice('0123')}",
                f"x := (y + {self.random.choice('12')})",
                f"y += {self.random.choice('12')}",
                f"f = {self.value()}",
                f"f {self.random.choice(['+=', '-=', '*='])} {self.value(1)}",
                f"t = '{self.random.choice('abc')}'",
                "t = (t + 'b')",
                "t = t .. 'c'",
                f"w := {self.value()}",
                f"@g := {self.value(1)}",
                f"_p := {self.value(1)}",
                f"x += {self.value(1)}",
            ]
        )
        return one if self.random.random() < 0.75 else f"{one}; {self.assignment()}"


def xml(root: Spec) -> str:
    trees: list[str] = []

    def text(spec: Spec) -> str:
        attributes = "".join(f" {name}={quoteattr(value)}" for name, value in spec.attributes.items())
        inside = "".join(text(child) for child in spec.children)
        if spec.tag == "SubTree":
            trees.append(f'<BehaviorTree ID="T{len(trees)}">{inside}</BehaviorTree>')
            return f'<SubTree ID="T{len(trees) - 1}"{attributes}/>'
        return f"<{spec.tag}{attributes}>{inside}</{spec.tag}>"

    main = f'<BehaviorTree ID="Main">{text(root)}</BehaviorTree>'
    return f'<root BTCPP_format="4" main_tree_to_execute="Main">{main}{"".join(trees)}</root>'


class Theirs:
    """The C++ engine."""

    errors = (RuntimeError, ValueError)

    def __init__(self, root: Spec) -> None:
        self.log: list[str] = []
        factory = engine.BehaviorTreeFactory()
        for spec in root.all():
            if spec.outcomes:
                self.register(factory, spec)
        self.board = engine.Blackboard.create()
        begin = factory.create_tree_from_text(xml(Spec("Script", {"code": BEGIN})), self.board)
        begin.tick_exactly_once()
        factory.register_behavior_tree_from_text(xml(root))
        self.factory, self.tree = factory, factory.create_tree("Main", self.board)

    def register(self, factory, spec: Spec) -> None:
        script, log = Outcomes(spec, self.log), {name: getattr(engine.NodeStatus, name) for name in NAMES.values()}
        if spec.tag[0] == "Y":
            factory.register_simple_action(spec.tag, lambda *_: log[NAMES[script("tick")]])
        else:
            factory.register_simple_stateful_action(
                spec.tag,
                lambda *_: log[NAMES[script("start")]],
                lambda *_: log[NAMES[script("run")]],
                lambda *_: script.halt(),
            )

    def tick(self) -> str:
        return str(self.tree.tick_exactly_once()).rpartition(".")[2]

    def halt(self) -> None:
        self.tree.halt_tree()

    def texts(self) -> dict[str, str]:
        found = {}
        for key in sorted(self.board.get_keys()):
            try:
                found[key] = self.board.get_string(key).replace("-nan", "nan")
            except RuntimeError:  # declared, and empty
                continue
        return found


class Outcomes:
    """What a leaf comes to, call after call; the last one for ever."""

    def __init__(self, spec: Spec, log: list[str]) -> None:
        self.name, self.outcomes, self.log, self.calls = spec.tag, spec.outcomes, log, 0

    def __call__(self, word: str) -> str:
        outcome = self.outcomes[min(self.calls, len(self.outcomes) - 1)]
        self.calls += 1
        self.log.append(f"{self.name}.{word}={outcome}")
        return outcome

    def halt(self) -> None:
        self.log.append(f"{self.name}.halt")


class Ours:
    """The engine under test."""

    errors = (InputError,)

    def __init__(self, root: Spec) -> None:
        self.log: list[str] = []
        board = Board()
        compile_script(parse_script(BEGIN), board)()
        self.tree = Tree(self.made(root), board=board, clock=SimulatedClock(0.1))

    def made(self, spec: Spec):
        children = [self.made(child) for child in spec.children]
        if spec.outcomes:
            kind = AtOnce if spec.tag[0] == "Y" else Stateful
            return kind(Outcomes(spec, self.log), spec.attributes)
        return BUILTIN.make(spec.tag, spec.tag, children, spec.attributes)

    def tick(self) -> str:
        return outcome_name(self.tree.tick())

    def halt(self) -> None:
        self.tree.halt()

    def texts(self) -> dict[str, str]:
        return self.tree.board.texts()


class Stateful(Leaf):
    def __init__(self, script: Outcomes, attributes: dict[str, str]) -> None:
        super().__init__(script.name, **attributes)
        self.script = script
        self.word = "start"

    def initialise(self) -> None:
        self.word = "start"

    def update(self):
        word, self.word = self.word, "run"
        return OUTCOMES[self.script(word)]

    def terminate(self, new_status) -> None:
        if new_status is IDLE:
            self.script.halt()


class AtOnce(Instant):
    def __init__(self, script: Outcomes, attributes: dict[str, str]) -> None:
        super().__init__(script.name, **attributes)
        self.script = script

    def update(self):
        return OUTCOMES[self.script("tick")]


def story(side, ticks: list[str]) -> list[object]:
    """What a side does tick after tick; it ends with "raised" where it raised."""
    told: list[object] = []
    for do in ticks:
        side.log.clear()
        try:
            outcome = side.tick() if do == "tick" else side.halt()
        except side.errors:
            return [*told, ("raised", [call for call in side.log if not call.endswith(".halt")])]
        told.append((outcome, list(side.log), side.texts()))
    return told


def compare(seed: int) -> None:
    draw = Draw(seed)
    root = draw.tree()
    ticks = ["tick" if not draw.halts or draw.random.random() < 0.85 else "halt" for _ in range(TICKS)]
    made = []
    for side in (Theirs, Ours):
        try:
            made.append(side(root))
        except side.errors as error:
            if "async child" in str(error):
                return  # a check of theirs, which the trees of later versions need not pass
            made.append(None)
    assert (made[0] is None) == (made[1] is None), xml(root)
    if made[0] is not None and made[1] is not None:
        theirs, ours = (story(side, ticks) for side in made)
        assert ours == theirs, f"seed {seed}\n{xml(root)}"


@pytest.mark.parametrize("block", range(10))
def test_random_trees_do_what_the_cpp_engine_does(block):
    for seed in range(block * 50, block * 50 + 50):
        compare(seed)


def test_logs_of_random_trees_have_parents_around_their_children(tmp_path):
    """Laws of BehaviorTree.CPP's log; `test_a_log_is_built_as_one_of_the_cpp_engine` compares with the engine's own."""
    for seed in range(80):
        draw = Draw(seed)
        try:
            side = Ours(draw.tree())
        except InputError:
            continue
        log = BtLog(tmp_path / "a.btlog", side.tree)
        story(side, ["tick" if draw.random.random() < 0.85 else "halt" for _ in range(TICKS)])
        log.close()
        nodes, status = side.tree.nodes, {}
        uids = {node.id: uid for uid, node in enumerate(nodes, 1)}
        for uid, now in changes_in(tmp_path / "a.btlog"):
            node, before = nodes[uid - 1], status.get(uid, 0)
            status[uid] = now
            assert now != before, seed
            if now:
                assert node.parent is None or status[uids[node.parent.id]] == 1, (seed, "the parent runs")
            if now != 1:
                assert all(status.get(uids[child.id], 0) == 0 for child in node.children), (seed, "children are reset")
            if node.children:
                assert (before, now) not in {(0, 2), (0, 3)} or not entered(node), (
                    seed,
                    "a parent ends after it began",
                )


def changes_in(path):
    """Records of a log: uid and status."""
    data = path.read_bytes()
    begin = 31 + int.from_bytes(data[19:23], "little")
    return [(int.from_bytes(data[i + 6 : i + 8], "little"), data[i + 8]) for i in range(begin, len(data), 9)]


def entered(node) -> bool:
    """Whether a node always ticks a child before it ends: no pre-condition and no class of it decides otherwise."""
    return not node.conditions and node.tag in ("Sequence", "Fallback", "Inverter", "ForceSuccess", "ForceFailure")


@pytest.mark.soak
@pytest.mark.parametrize("block", range(20))
def test_many_random_trees_do_what_the_cpp_engine_does(block):
    for seed in range(1000 + block * 500, 1000 + block * 500 + 500):
        compare(seed)
