"""Checking trees before they run: each thing that a check finds, at its line and column, all of it at once."""

# ruff: noqa: E501 - a document stands in one line

import sys

import pytest
from py_trees.common import Status

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import Fault, InputError
from rocs_bt.trees.examine import blocking_faults, examine
from rocs_bt.trees.nodes import BUILTIN, Leaf, Output, Tree
from rocs_bt.trees.script import compiler
from rocs_bt.trees.status import SUCCESS
from rocs_bt.trees.xml import load_xml, make_nodes, read_document, verify


class Drive(Leaf):
    """Drives."""

    goal: str
    rounds: int = 1
    pose: Output[str]

    def update(self):
        return SUCCESS


NODES = BUILTIN.with_([Drive])


def found(*lines, tail=""):
    """Faults of a document whose main tree stands in these lines, the first of which is line 3."""
    text = "\n".join(
        ['<root BTCPP_format="4" main_tree_to_execute="M">', '<BehaviorTree ID="M">', *lines, "</BehaviorTree>"]
    )
    document = read_document(f"{text}{tail}</root>")
    faults = [*document.faults, *verify(document, NODES)]
    if not any(not f.warning for f in faults):
        faults += examine(Tree(make_nodes(document, NODES)))
    return [(f.line, f.column, "warning" if f.warning else "wrong", f"{f.message} {f.hint}") for f in faults]


SUB = '\n<BehaviorTree ID="S"><Drive goal="{goal}"/></BehaviorTree>'


@pytest.mark.parametrize(
    "line",
    [
        '<Drive goal="a" rounds="2" pose="{p}"/>',
        '<Sequence><Drive goal="a" pose="{p}"/><Drive goal="{p}"/></Sequence>',
        "<Sequence><Script code=\"g := 'a'; n := 1; n += 2\"/><Drive goal='{g}' rounds='{n}'/></Sequence>",
        "<Sequence><Script code=\"@g := 'a'\"/><SubTree ID='S' goal='{g}'/></Sequence>",
        "<Fallback><AlwaysFailure/><ForceFailure><AlwaysSuccess/></ForceFailure><AlwaysSuccess/></Fallback>",
        '<Sequence><SetBlackboard value="3" output_key="n"/><Repeat num_cycles="{n}"><AlwaysSuccess/></Repeat><AlwaysSuccess/></Sequence>',
        '<Sequence><AlwaysSuccess _skipIf="a == 1"/><Script code="a := 1"/></Sequence>',
        '<LoopInt queue="1;2" value="{i}"><ScriptCondition code="i > 0"/></LoopInt>',
        '<Switch2 variable="{undefined}" case_1="1" case_2="2"><AlwaysSuccess/><AlwaysSuccess/><AlwaysSuccess/></Switch2>',
        '<SubTree ID="S" goal="home"/>',
    ],
)
def test_what_is_fine_is_not_told(line):
    assert found(line, tail=SUB if "ID='S'" in line or 'ID="S"' in line else "") == []


def test_keys_with_two_types_and_names_that_are_no_numbers_are_told_each_at_its_place():
    """Only a bound tree knows them: one that is looked at takes them down and goes on, and any other is refused."""
    loop = "<LoopDouble queue='1' value='{x}'><AlwaysSuccess/></LoopDouble>"
    lines = ["<Sequence>", "<Drive goal='a' rounds='{x}'/>", loop, "<Drive goal='a' rounds='many'/>", loop]
    text = "\n".join(['<root BTCPP_format="4"><BehaviorTree ID="M">', *lines, "</Sequence></BehaviorTree></root>"])
    faults = []
    Tree(load_xml(text, NODES), faults=faults)
    assert [(f.line, f.column) for f in faults] == [(4, 23), (5, 17), (6, 23)]
    assert "'Drive': port 'rounds': 'many' is not a whole number" in faults[1].message
    with pytest.raises(InputError) as caught:
        Tree(load_xml(text, NODES))
    assert list(caught.value.faults) == faults
    Tree(load_xml(text.replace(loop, ""), NODES), enums={"many": 3})


def test_a_stand_in_that_bears_a_built_in_name_is_not_taken_for_it():
    """A wrong node has a stand-in while the rest is examined, and may have no children."""
    text = "<Sequence><Repeat/><Inverter/><Fallback><AlwaysSuccess/><AlwaysFailure/></Fallback></Sequence>"
    document = read_document(f'<root BTCPP_format="4"><BehaviorTree ID="M">{text}</BehaviorTree></root>')
    (told,) = examine(Tree(make_nodes(document, NODES, lenient=True)))
    assert "'AlwaysFailure': is never ticked" in told.message


def test_what_keeps_a_node_from_telling_its_doubts_is_told():
    class Shy(Leaf):
        rounds: int = 1

        def bound_faults(self):
            yield "rounds", Fault(f"{self.rounds} are too many.")

    def told(rounds):
        return [f.message for f in examine(Tree(Shy("shy", rounds=rounds), faults=[]))]

    assert told("2") == ["'shy': 2 are too many."]
    assert told("many") == ["'shy': port 'rounds': 'many' is not a whole number."]


@pytest.mark.parametrize(
    ("body", "told"),
    [
        ("sleep(1)", "calls time.sleep"),
        ("t.sleep(1)", "calls time.sleep"),
        ("input()", "calls input"),
        ("requests.get('x')", "calls requests.get"),
        ("self.thread.wait()", "calls self.thread.wait"),
        ("while True:\n            pass", "contains an endless loop"),
        ("while True:\n            break", ""),
        ("self.mission.wait('2 s')", ""),
        ("', '.join('a')", ""),
        ("pass", ""),
    ],
)
def test_leaves_that_would_block_are_found_in_their_text(tmp_path, body, told):
    head = "import time as t, requests\nfrom time import sleep\nclass A:\n    def update(self):\n        "
    faults = list(blocking_faults(head + body, tmp_path / "a.py"))
    assert [told in f.message for f in faults] == ([True] if told else [])
    assert all((f.line, f.column) == (5, 9) for f in faults)


@pytest.mark.parametrize(
    ("text", "restarted"),
    [
        ("<ReactiveSequence><Sleep msec='10'/>{}</ReactiveSequence>", True),
        ("<ReactiveFallback><Inverter><Sleep msec='10'/></Inverter>{}</ReactiveFallback>", True),
        ("<ReactiveSequence><Sequence><Script code='x := 1'/><Sleep msec='10'/></Sequence>{}</ReactiveSequence>", True),
        ("<ReactiveSequence><AlwaysSuccess/><Delay delay_msec='9'><AlwaysSuccess/></Delay>{}</ReactiveSequence>", True),
        ("<ReactiveSequence><Sleep msec='0'/>{}</ReactiveSequence>", False),
        ("<ReactiveSequence><Sleep msec='10' _skipIf='x == 1'/>{}</ReactiveSequence>", False),
        ("<ReactiveSequence><RunOnce><Sleep msec='10'/></RunOnce>{}</ReactiveSequence>", False),
        ("<ReactiveSequence><Sleep msec='10'/><AlwaysSuccess/></ReactiveSequence>{}", False),
        ("<ReactiveSequence><ScriptCondition code='x == 1'/>{}</ReactiveSequence>", False),
        ("<Sequence><Sleep msec='10'/>{}</Sequence>", False),
    ],
)
def test_a_reactive_node_that_restarts_a_later_child_for_ever_is_told(text, restarted):
    """What the check says is what the ticks do: the last child never ends."""
    inside = text.format('<Sleep name="last" msec="1000"/>')
    document = f'<root BTCPP_format="4"><BehaviorTree ID="M"><Sequence>{inside}</Sequence></BehaviorTree></root>'
    clock = SimulatedClock(0.1)
    tree = Tree(load_xml(document), clock=clock, faults=[])
    tree.board["x"] = 0
    told = [f for f in examine(tree) if "restarts" in f.message]
    assert bool(told) is restarted
    assert all(f.warning and f.line == 1 for f in told)
    outcomes = []
    for _ in range(40):
        outcomes.append(tree.tick())
        clock.advance()
    if restarted:
        assert set(outcomes) == {Status.RUNNING}


def steps_of(call) -> int:
    """Number of lines of Python that a call executes."""
    count = 0

    def trace(frame, event, argument):
        nonlocal count
        count += event == "line"
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        call()
    finally:
        sys.settrace(before)
    return count


def chain(length):
    """Each tree uses the next one."""
    return [*(f'<SubTree ID="T{i + 1}"/>' for i in range(length - 1)), "<AlwaysSuccess/>"]


def star(length):
    """The first tree uses all others."""
    uses = "".join(f'<SubTree ID="T{i}"/>' for i in range(1, length))
    return [f"<Sequence>{uses}</Sequence>", *["<AlwaysSuccess/>"] * (length - 1)]


def ladder(length):
    """Each tree uses the next two."""
    return [
        *(
            f'<Fallback><SubTree ID="T{i + 1}"/><SubTree ID="T{min(i + 2, length - 1)}"/></Fallback>'
            for i in range(length - 1)
        ),
        "<AlwaysSuccess/>",
    ]


@pytest.mark.parametrize("shape", [chain, star, ladder])
@pytest.mark.parametrize("turned", [False, True])
def test_the_work_of_a_check_grows_in_proportion_to_the_number_of_trees(shape, turned):
    def work(length):
        trees = [f'<BehaviorTree ID="T{i}">{body}</BehaviorTree>' for i, body in enumerate(shape(length))]
        text = "".join(reversed(trees) if turned else trees)
        document = read_document(f'<root BTCPP_format="4" main_tree_to_execute="T0">{text}</root>')
        return steps_of(lambda: verify(document, BUILTIN))

    assert work(400) < 2.3 * work(200)


@pytest.mark.parametrize(
    "leaf",
    [
        '<AlwaysSuccess _skipIf="k{0} &gt; {0}" _onSuccess="n := {0}"/>',
        '<Script code="n := n + {0}"/>',
        '<ScriptCondition code="k{0} &lt; {0}"/>',
        '<Precondition if="k{0} &lt; {0}"><AlwaysSuccess/></Precondition>',
        '<TestNode return_status="SUCCESS" success_script="n := {0}" post_script="n := {0}"/>',
    ],
)
def test_scripts_are_compiled_when_the_tree_is_built_and_never_in_a_tick(leaf, monkeypatch):
    compiled = []
    monkeypatch.setattr(compiler, "_Compiler", lambda *args, made=compiler._Compiler: compiled.append(1) or made(*args))
    inside = "".join(leaf.format(i) for i in range(1, 51))
    tree = Tree(
        load_xml(f'<root BTCPP_format="4"><BehaviorTree ID="M"><Sequence>{inside}</Sequence></BehaviorTree></root>')
    )
    tree.board.update({"n": 0.0} | {f"k{i}": 0.5 for i in range(51)})
    built = len(compiled)
    assert built >= 50
    for _ in range(3):
        tree.tick()
    assert len(compiled) == built
