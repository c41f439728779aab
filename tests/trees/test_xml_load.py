"""Loading trees from XML: each feature of BehaviorTree.CPP's version 4, then the same trees as the C++ engine."""

# ruff: noqa: E501 - a document stands in one line

from collections import Counter
from itertools import product

import pytest

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import InputError
from rocs_bt.trees.nodes import BUILTIN, Instant, Leaf, Output, Tree
from rocs_bt.trees.script import form
from rocs_bt.trees.status import FAILURE, RUNNING, SUCCESS, outcome_name
from rocs_bt.trees.xml import load_xml, read_document

from .. import needs

pytestmark = pytest.mark.filterwarnings("ignore::rocs_bt.trees.TreeWarning")


class Say(Instant):
    """Keeps what it says."""

    message: str = "hello"

    def update(self):
        self.board.root.set_local("said", f"{self.board.root.texts().get('said', '')}{self.message};")
        return SUCCESS


class Think(Instant):
    """Writes a text."""

    text: Output[str]

    def update(self):
        self.text = "the answer is 42"
        return SUCCESS


class Work(Leaf):
    """RUNNING for two ticks."""

    def initialise(self):
        self.left = 2

    def update(self):
        self.left -= 1
        return RUNNING if self.left >= 0 else SUCCESS


class BatteryLow(Instant):
    """FAILURE."""

    kind = "Condition"

    def update(self):
        return FAILURE


NODES = BUILTIN.with_([Say, Think, Work, BatteryLow])


def document(*trees, model="", attributes='BTCPP_format="4" main_tree_to_execute="Main"'):
    named = "".join(
        f'<BehaviorTree ID="{"Main" if i == 0 else f"Sub{i}"}">{body}</BehaviorTree>' for i, body in enumerate(trees)
    )
    return f"<root {attributes}>{named}{f'<TreeNodesModel>{model}</TreeNodesModel>' if model else ''}</root>"


def run(text, **keys):
    tree = Tree(load_xml(text, NODES), clock=SimulatedClock(0.1))
    for key, value in keys.items():
        tree.board[key] = value
    outcome = tree.settle()
    return outcome_name(outcome), tree.board


def said(text, **keys):
    outcome, board = run(text, **keys)
    return outcome, (board.texts().get("said", ""))


def sub(attributes=""):
    return f'<SubTree ID="Sub1" {attributes}/>'


SAY = '<Say message="{{{}}}"/>'.format


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        # compact and explicit syntax
        (document("<Say/>"), "hello;"),
        (document('<Action ID="Say" message="a" name="speaker"/>'), "a;"),
        (document('<Control ID="Sequence"><Action ID="Say"/><Condition ID="AlwaysSuccess"/></Control>'), "hello;"),
        (document('<Decorator ID="Inverter"><Condition ID="BatteryLow"/></Decorator>'), ""),
        # ports: literals, keys, spaces around them, {=}
        (document('<Sequence><Think text="{t}"/><Say message="{t}"/></Sequence>'), "the answer is 42;"),
        (document('<Sequence><Think text="{=}"/><Say message=" {text} "/></Sequence>'), "the answer is 42;"),
        (document('<Sequence><Think text="="/><Say message="{text}"/></Sequence>'), "the answer is 42;"),
        (document('<Sequence><Script code="message := \'b\'"/><Say message="{=}"/></Sequence>'), "b;"),
        # subtrees: boards of their own, remapping, literals, autoremap, private keys, the global board
        (
            document("<Sequence><Think text='{t}'/><SubTree ID='Sub1' in='{t}'/></Sequence>", SAY("in")),
            "the answer is 42;",
        ),
        (document(sub('in="c"'), SAY("in")), "c;"),
        (
            document("<Sequence><Think text='{t}'/><SubTree ID='Sub1' t='{=}'/></Sequence>", SAY("t")),
            "the answer is 42;",
        ),
        (
            document("<Sequence><Think text='{t}'/><SubTree ID='Sub1' _autoremap='1'/></Sequence>", SAY("t")),
            "the answer is 42;",
        ),
        (document("<Sequence><Think text='{t}'/><SubTree ID='Sub1' /></Sequence>", SAY("@t")), "the answer is 42;"),
        (
            document(
                "<Sequence><SubTree ID='Sub1' out='{t}'/><Say message='{t}'/></Sequence>", '<Think text="{out}"/>'
            ),
            "the answer is 42;",
        ),
        (
            document("<Sequence><SubTree ID='Sub1' /><Say message='{g}'/></Sequence>", "<Script code=\"@g := 'd'\"/>"),
            "d;",
        ),
        (document("<Sequence><SubTree ID='Sub1' a='1'/><SubTree ID='Sub1' a='2'/></Sequence>", SAY("a")), "1;2;"),
        # a model's defaults
        (document(sub(""), SAY("in"), model='<SubTree ID="Sub1"><input_port name="in" default="e"/></SubTree>'), "e;"),
        (
            document(
                sub('in="f"'), SAY("in"), model='<SubTree ID="Sub1"><input_port name="in" default="e"/></SubTree>'
            ),
            "f;",
        ),
        # conditions, ill-formed attributes, comments, CDATA
        (
            document(
                '<Sequence><Say message="a" _skipIf="1 < 2 && true"/><Say message="b" _while="1 &lt; 2"/></Sequence>'
            ),
            "b;",
        ),
        (document('<Say message="a" _onSuccess="said = said .. \'post\'"/>'), "a;post"),
        (document("<!-- a --><Sequence><!-- <Say/> --><Say message='b'/><![CDATA[<Say/>]]></Sequence>"), "b;"),
        (document('<Say message="a&#10;&quot;b&quot;"/>'), 'a\n"b";'),
        # attributes of editors, unknown children of root
        (
            document('<Say _description="what it says" _uid="3"/>').replace("<root", "<?xml version='1.0'?>\n<root"),
            "hello;",
        ),
        (document("<Say/>", attributes='main_tree_to_execute="Main"'), "hello;"),
        ('<root BTCPP_format="4"><BehaviorTree><Say/></BehaviorTree></root>', "hello;"),
        (document("<Say/>", attributes='BTCPP_format="4" project_name="x"'), "hello;"),
        ('<root BTCPP_format="4"><BehaviorTree ID="a b.c"><Say/></BehaviorTree></root>', "hello;"),
    ],
)
def test_each_feature(text, expected):
    assert said(text) == ("SUCCESS", expected)


def test_the_main_tree_may_be_named_by_the_caller_and_must_be_when_nobody_else_does():
    text = '<root BTCPP_format="4"><BehaviorTree ID="a"><Say/></BehaviorTree><BehaviorTree ID="b"><Work/></BehaviorTree></root>'
    assert isinstance(load_xml(text, NODES, main="b"), Work)
    with pytest.raises(InputError, match="names no main tree"):
        load_xml(text, NODES)
    with pytest.raises(InputError, match="no tree is named 'c'"):
        load_xml(text, NODES, main="c")


def test_version_3_is_converted_with_a_notice():
    text = """<root main_tree_to_execute="Main"><BehaviorTree ID="Main"><SequenceStar>
      <SetBlackboard value="hi" output_key="greeting"/>
      <SubTree ID="Sub" in="greeting" __shared_blackboard="false"/>
      <SubTreePlus ID="Sub" in="{greeting}" __autoremap="true"/>
      <Action ID="Say" message="end"/></SequenceStar></BehaviorTree>
      <BehaviorTree ID="Sub"><Say message="{in}"/></BehaviorTree></root>"""
    assert said(text) == ("SUCCESS", "hi;hi;end;")
    (notice,) = read_document(text).faults
    assert notice.warning
    assert "version 3" in notice.message


@pytest.mark.parametrize("name", ["a b", "a.b", "a:b", "root"])
def test_names_that_4_10_refuses_are_warned_of_and_refused_when_strict(name):
    text = (
        f'<root BTCPP_format="4" main_tree_to_execute="{name}"><BehaviorTree ID="{name}"><Say/></BehaviorTree></root>'
    )
    load_xml(text, NODES)
    with pytest.raises(InputError, match=r"BehaviorTree\.CPP 4\.10 rejects it"):
        load_xml(text, NODES, strict=True)


class TestInclude:
    @pytest.fixture
    def write(self, tmp_path):
        def write(name, body="", *includes, main=""):
            file = tmp_path / name
            file.parent.mkdir(parents=True, exist_ok=True)
            lines = "".join(f'<include path="{i}"/>\n' for i in includes)
            file.write_text(f'<root BTCPP_format="4" {main}>\n{lines}{body}</root>')
            return file

        return write

    def test_paths_are_relative_to_the_file_that_names_them(self, write, tmp_path):
        write("sub/deep/c.xml", '<BehaviorTree ID="C"><Say message="c"/></BehaviorTree>')
        write("sub/b.xml", '<BehaviorTree ID="B"><SubTree ID="C"/></BehaviorTree>', "deep/c.xml")
        a = write("a.xml", '<BehaviorTree ID="A"><SubTree ID="B"/></BehaviorTree>', "sub/b.xml", "./sub/../sub/b.xml")
        assert said_of(a) == "c;"
        assert [f.name for f in read_document(a).files] == ["a.xml", "b.xml", "c.xml"]

    def test_the_including_file_replaces_a_tree_with_a_warning(self, write):
        write("b.xml", '<BehaviorTree ID="A"><Say message="b"/></BehaviorTree>')
        a = write("a.xml", '<BehaviorTree ID="A"><Say message="a"/></BehaviorTree>', "b.xml")
        assert said_of(a) == "a;"
        assert any("there is another tree 'A'" in f.message for f in read_document(a).faults)

    def test_a_cycle_is_told(self, write):
        write("b.xml", '<BehaviorTree ID="B"><Say/></BehaviorTree>', "a.xml")
        a = write("a.xml", '<BehaviorTree ID="A"><SubTree ID="B"/></BehaviorTree>', "b.xml")
        with pytest.raises(InputError, match=r"b\.xml:2:10: 'a\.xml' includes itself: b\.xml -> a\.xml"):
            load_xml(a, NODES)

    @pytest.mark.parametrize("path", ["../out.xml", "/etc/passwd", "link/out.xml", "none.xml", ""])
    def test_what_lies_outside_or_nowhere_is_refused(self, write, tmp_path, path):
        (tmp_path / "out.xml").write_text("<root/>")
        a = write("project/a.xml", '<BehaviorTree ID="A"><Say/></BehaviorTree>', path)
        (tmp_path / "project" / "link").symlink_to(tmp_path)
        with pytest.raises(InputError, match=r"a\.xml:2:\d+: .*(is outside of|no file is named|has no path)"):
            load_xml(a, NODES)

    def test_a_text_includes_nothing(self):
        with pytest.raises(InputError, match="is not in a file"):
            load_xml('<root BTCPP_format="4"><include path="a.xml"/><BehaviorTree ID="A"><Say/></BehaviorTree></root>')


def said_of(file):
    tree = Tree(load_xml(file, NODES), clock=SimulatedClock(0.1))
    assert tree.settle() is SUCCESS
    return tree.board["said"]


@pytest.mark.parametrize(
    ("attributes", "forms"),
    [
        ('<AlwaysSuccess _skipIf="counted &lt; -3"/>', 1),
        ('<AlwaysSuccess _skipIf="counted{0} &lt; -{0}"/>', 1),
        ('<AlwaysSuccess _onSuccess="counted := {0}" _failureIf="counted{0} &gt; {0}.5"/>', 2),
        ("<Script code=\"counted := {0}; counted += '{0}'\"/>", 1),
    ],
    ids=["same", "other names", "two attributes", "node"],
)
def test_scripts_of_one_form_are_parsed_once_in_a_load(attributes, forms, monkeypatch):
    counts = Counter()

    def count(module, name):
        function = getattr(module, name)

        def counting(*args):
            counts[name] += 1
            return function(*args)

        monkeypatch.setattr(module, name, counting)

    form._form.cache_clear()
    count(form, "parse_statements")
    inside = "".join(attributes.format(i) for i in range(1, 301))
    tree = Tree(load_xml(document(f"<Sequence>{inside}</Sequence>"), NODES))
    assert len(tree.nodes) == 301
    assert counts == {"parse_statements": forms}


# The C++ engine.
@pytest.mark.parametrize("block", range(6))
def test_what_is_loaded_does_what_the_cpp_engine_loads(block):
    needs.package("behaviortreepy")
    from . import test_conformance as of

    class Loaded(of.Ours):
        """Ours, but from the text that the C++ engine is given."""

        def made(self, spec):
            classes = [self.leaf(s) for s in spec.all() if s.outcomes]
            return load_xml(of.xml(spec), BUILTIN.with_(classes))

        def leaf(self, spec):
            kind, script = (of.AtOnce if spec.tag[0] == "Y" else of.Stateful), of.Outcomes(spec, self.log)

            def make(self, name, /, **attributes):
                kind.__init__(self, script, attributes)

            return type(spec.tag, (kind,), {"__init__": make, "tag": spec.tag})

    of.Ours = Loaded
    for seed in range(50_000 + block * 50, 50_050 + block * 50):
        of.compare(seed)


def both(text, keys):
    """What our engine and the C++ one make of a document: outcome and board, or `raises`."""
    cpp = needs.package("behaviortreepy")

    def ours():
        tree = Tree(load_xml(text))
        tree.board.update(keys)
        return outcome_name(tree.tick()), {k: tree.board[k] for k in WATCHED if k in tree.board}

    def theirs():
        board = cpp.Blackboard.create()
        for key, value in keys.items():
            board.set_string(key, value)
        factory = cpp.BehaviorTreeFactory()
        status = factory.create_tree_from_text(text, board).tick_once()
        return status.name, {k: board.get_string(k) for k in board.get_keys() if k in WATCHED}

    outcomes = []
    for engine, error in ((ours, InputError), (theirs, RuntimeError)):
        try:
            outcomes.append(engine())
        except error:
            outcomes.append("raises")
    return outcomes


WATCHED = ("seen", "p", "q", "=")


@pytest.mark.parametrize("remap", ["", '_autoremap="true"', '_autoremap="0"'])
@pytest.mark.parametrize("default", ["", 'default=""', 'default="{=}"', 'default="="', 'default="{q}"', 'default="x"'])
def test_the_defaults_of_a_subtree_are_those_of_the_cpp_engine(default, remap):
    model = f'<SubTree ID="Sub1"><input_port name="p" {default}/></SubTree>'
    boards = ({}, {"p": "v"}, {"p": "v", "q": "other", "=": "odd"})
    for given, script in product(("", 'p="{=}"', 'p="="', 'p="{q}"', 'p="x"'), ("@seen := p", "p := 'w'")):
        text = document(sub(f"{given} {remap}"), f'<Script code="{script}"/>', model=model)
        for keys in boards:
            ours, theirs = both(text, keys)
            assert ours == theirs, (given, script, keys)


@pytest.mark.parametrize("before", ["// a comment\n", "text <!-- c --> more", "<?xml version='1.0'?>\n# by hand\n"])
def test_text_before_the_root_is_skipped_with_a_warning_as_in_the_cpp_engine(before):
    text = before + document("<AlwaysSuccess/>")
    assert both(text, {}) == [("SUCCESS", {})] * 2
    faults = read_document(text).faults
    assert {f.message for f in faults} == {"there is text before the root element."}
    assert all(f.warning and f.line for f in faults)


@pytest.mark.parametrize("text", ["{0} text", "<a/>{0}", "</x>{0}", "a < b {0}"])
def test_other_things_around_the_root_are_refused_as_in_the_cpp_engine(text):
    assert both(text.format(document("<AlwaysSuccess/>")), {}) == ["raises", "raises"]
