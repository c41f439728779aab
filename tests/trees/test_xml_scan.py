"""Reading XML: what expat reads is read the same, what BehaviorTree.CPP reads too, and what is hostile is refused."""

# ruff: noqa: E501 - a document stands in one line

import random
import re
import xml.etree.ElementTree as Tree

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.base.errors import InputError
from rocs_bt.trees.xml import load_xml, read_document
from rocs_bt.trees.xml import scan as scanner
from rocs_bt.trees.xml.element import Source
from rocs_bt.trees.xml.scan import MAX_ATTRIBUTES, MAX_DEPTH, MAX_ELEMENTS, MAX_VALUE, scan

pytestmark = pytest.mark.filterwarnings("ignore::rocs_bt.trees.TreeWarning")

NAMES = st.from_regex(r"[A-Za-z_][A-Za-z0-9_.\-]{0,6}", fullmatch=True)
TEXTS = st.text(
    st.characters(codec="utf-8", exclude_categories=("Cs", "Cc"), exclude_characters="\ufffe\uffff"), max_size=8
)


def tree(depth):
    below = st.lists(tree(depth - 1), max_size=3) if depth else st.just([])
    return st.builds(Made, NAMES, st.dictionaries(NAMES, TEXTS, max_size=3), below, TEXTS, st.booleans())


class Made:
    """An element, and how it is written."""

    def __init__(self, tag, attributes, children, text, comment):
        self.tag, self.attributes, self.children, self.text, self.comment = tag, attributes, children, text, comment

    def __repr__(self):
        return self.write()

    def write(self):
        attributes = "".join(f" {n}\n = '{escape(v)}'" for n, v in self.attributes.items())
        inside = (
            escape(self.text) + "".join(c.write() for c in self.children) + ("<!-- & < -->" if self.comment else "")
        )
        return f"<{self.tag}{attributes}\t>{inside}</{self.tag} >" if inside else f"<{self.tag}{attributes} />"


def escape(text):
    for raw, entity in (("&", "&amp;"), ("<", "&lt;"), (">", "&#62;"), ("'", "&#x27;"), ('"', "&quot;")):
        text = text.replace(raw, entity)
    return text


def plain(element):
    return element.tag, dict(element.attributes), element.text, [plain(c) for c in element.children]


def oracle(element):
    text = "".join([element.text or "", *(c.tail or "" for c in element)]).strip(" \t\r\n")
    return element.tag, dict(element.attrib), text, [oracle(c) for c in element]


@given(tree(3))
def test_what_expat_reads_is_read_the_same(made):
    text = f"<?xml version='1.0'?>\n<!-- first -->{made.write()}\n"
    root, warnings = scan(Source(text))
    assert not warnings
    theirs = oracle(Tree.fromstring(text))

    def stripped(element):
        tag, attributes, text, children = element
        return tag, attributes, text.strip(), [stripped(c) for c in children]

    assert stripped(plain(root)) == stripped(theirs)


@given(tree(2))
def test_every_element_and_attribute_knows_its_place(made):
    source = Source(f"\n\n{made.write()}")
    root, _ = scan(source)
    lines = source.text.split("\n")
    todo = [root]
    while todo:
        element = todo.pop()
        line, column = source.position(element.at)
        assert lines[line - 1][column - 1 :].startswith(f"<{element.tag}")
        for name, position in element.attribute_positions.items():
            line, column = source.position(position.name)
            assert lines[line - 1][column - 1 :].startswith(name)
            assert source.text[position.value - 1] == "'"
        todo += element.children


BOMB = '<!DOCTYPE a [<!ENTITY x "ha"><!ENTITY y "&x;&x;">]><a>&y;</a>'


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (BOMB, "1:1: .*a document type or an entity is declared"),
        ('<!DOCTYPE a SYSTEM "file:///etc/passwd"><a/>', "document type"),
        ("<a>" * (MAX_DEPTH + 1) + "</a>" * (MAX_DEPTH + 1), f"nested more than {MAX_DEPTH} deep"),
        (f'<a v="{"x" * (MAX_VALUE + 1)}"/>', f"{MAX_VALUE + 1} characters; the maximum is {MAX_VALUE}"),
        (f'<a v="{"x" * 2_000_000}"/>', "2000000 characters"),
        (f"<a>{'<b/>' * MAX_ELEMENTS}</a>", f"more than {MAX_ELEMENTS} elements"),
        (
            "<a " + " ".join(f'x{i}=""' for i in range(MAX_ATTRIBUTES + 1)) + "/>",
            f"more than {MAX_ATTRIBUTES} attributes",
        ),
        ("<a>\x00</a>", r"U\+0000"),
        ("<a>\n  <b></a>", "2:6: .*expected </b> for the tag of line 2, found </a>. Write the same name in both"),
        ("<a><b/>", "1:1: .*<a> is not closed"),
        ("<a/><b/>", "1:5: .*second root"),
        ("<a/>text", "1:5: .*text outside"),
        ("", "no element"),
        ("<a b=c/>", "1:4: .*expected an attribute"),
        ('<a b="c/>', "1:6: .*no closing"),
        ('<a b="1" b="2"/>', "1:10: .*'b' twice"),
        ("</a>", "has no opening tag"),
        ("<a><!-- b", "comment is not closed"),
        ("<a>< b/></a>", "1:4: .*does not begin a tag"),
        ('<a>\n<b c="1>\n<d e="2"/>\n</a>', "2:6: .*closing quote is missing"),
    ],
)
def test_what_cannot_be_read_is_refused_with_place_and_reason(tmp_path, text, reason):
    file = tmp_path / "mission.xml"
    file.write_text(text)
    with pytest.raises(InputError) as told:
        read_document(file)
    assert re.search(reason, str(told.value)), str(told.value)
    assert len(str(told.value)) < 600


SEED = """<?xml version="1.0"?>
<root BTCPP_format="4" main_tree_to_execute="Main">
  <!-- a mission -->
  <BehaviorTree ID="Main"><Sequence name="all" _while="a != 9" _onHalted="x := 1 + 2 * (3 - y)">
    <SubTree ID="Sub" key="{other}" text="it's" _autoremap="true"/>
    <Repeat num_cycles="3"><Script code="a := b &amp;&amp; c ? 'd' .. 'e' : 0x1F"/></Repeat>
    <Switch2 variable="{x}" case_1="1" case_2="2"><AlwaysSuccess/><AlwaysFailure/><AlwaysSuccess/></Switch2>
  </Sequence></BehaviorTree>
  <BehaviorTree ID="Sub"><Precondition if="a &lt; 3.5e2 || !b" else="RUNNING"><Sleep msec="10"/></Precondition></BehaviorTree>
  <TreeNodesModel><SubTree ID="Sub"><input_port name="key" default="{=}">what</input_port></SubTree></TreeNodesModel>
</root>"""
PIECES = [*"<>/\"'&{}=@;\n1\u00e9(", ":=", "<!--", "]]>", "<a>", "</", "ID"]
WORDS = [
    "a",
    "b",
    "x",
    "1",
    "0.5",
    "'c'",
    "true",
    "==",
    "<",
    "&&",
    "!",
    "(",
    ")",
    "?",
    ":",
    "{x}",
    "{=}",
    "SUCCESS",
    ";",
    ":=",
]


def mutate(draw):
    """A document that is a little wrong: in the values of its attributes, or anywhere."""
    text = SEED
    for _ in range(draw.choice([1, 1, 2, 3, 8])):
        if draw.random() < 0.6:
            at, to = draw.choice([m.span(1) for m in re.finditer(r'="([^"]*)"', text)] or [(0, 0)])
            words = [*text[at:to].split(), *draw.choices(WORDS, k=draw.randint(1, 3))]
            draw.shuffle(words)
            piece = " ".join(words[: draw.randint(0, len(words))])
        else:
            at, to = sorted(draw.randrange(len(text) + 1) for _ in range(2))
            to = min(to, at + draw.choice([0, 1, 5, 60]))
            piece = draw.choice([*PIECES, text[to : to + draw.randint(1, 90)], ""]) * draw.choice([1, 1, 1, 3])
        text = text[:at] + piece + text[to:]
    return text


def survive(seed):
    """Load, and tick what loads; anything but a fault that a person can read is a defect."""
    from rocs_bt.base.clock import SimulatedClock
    from rocs_bt.trees.examine import examine
    from rocs_bt.trees.nodes import Tree as Bound
    from rocs_bt.trees.xml import write_tree

    try:
        root = load_xml(mutate(random.Random(seed)))
        tree = Bound(root, clock=SimulatedClock(0.1))
        tree.board.update({"a": 1, "b": 1, "c": 2, "x": 1})
        examine(tree)
        assert load_xml(write_tree(root))
        for _ in range(3):
            tree.tick()
    except InputError as error:
        assert str(error)
        return False
    return True


@settings(deadline=None)
@given(st.integers(0, 10**9))
def test_whatever_a_document_holds_it_is_read_or_refused(seed):
    survive(seed)


AROUND = [
    ("", ""),
    ("<a>", "</a>"),
    ("<a>one <b/> <b/>two", " three</a>"),
    ("<a>\r\n ", ' b\u00a0<c/> <d e="&amp;lt;"/></a>'),
    (SEED, ""),
]


@st.composite
def nearly_xml(draw):
    """A document with spaces, text and both kinds of quotes, cut and patched in up to three places."""
    between = draw(st.sampled_from([" ", "\n\t", ""]))
    inside = between.join(draw(st.lists(tree(2).map(Made.write), min_size=1, max_size=3)))
    before, after = draw(st.sampled_from(AROUND))
    text = before + inside + after
    for _ in range(draw(st.integers(0, 3))):
        at, to = sorted(draw(st.tuples(*[st.integers(0, len(text))] * 2)))
        piece = draw(st.sampled_from([*PIECES, " ", "\r\n", "&lt;", "&#65;", "</a>", "<b c='d' e = \"f\">"]))
        text = text[:at] + piece + text[min(to, at + draw(st.sampled_from([0, 1, 9]))) :]
    return text


def scanned(make, text):
    """All that a scanner finds in a text: elements with their places, and warnings; or why it is refused."""
    try:
        root, warnings = make(Source(text)).document()
    except InputError as error:
        return str(error)

    def whole(element):
        inside = [whole(child) for child in element.children]
        return (
            element.tag,
            element.at,
            element.attributes,
            element.attribute_positions,
            element.text,
            element.comments,
            inside,
        )

    return whole(root), [str(warning) for warning in warnings]


class Slow(scanner._Scanner):
    """A scanner that takes each tag attribute by attribute."""

    def tags(self):
        pass


@settings(deadline=None, max_examples=300)
@given(nearly_xml())
def test_the_quick_scanner_finds_what_the_slow_one_finds(text):
    assert scanned(scanner._Scanner, text) == scanned(Slow, text)


@pytest.mark.soak
def test_mutated_documents_and_scripts(record_property):
    import time

    end, count, loaded = time.monotonic() + 1800, 0, 0
    while time.monotonic() < end:
        loaded += survive(count)
        count += 1
    record_property("documents", count)
    print(f"{count} mutated documents, {loaded} of them loaded and ticked")
    assert count > 10_000
    assert loaded > count / 10
