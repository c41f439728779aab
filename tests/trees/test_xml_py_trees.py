"""Defaults of trees and includes as py_trees writes them, against py_trees' own parser."""

import itertools
from typing import ClassVar

import py_trees
import pytest
from py_trees.parsers.behaviour_tree_xml import parse_behaviour_tree_xml
from py_trees.ports import PortInformation, PortsMixin

from rocs_bt.trees.nodes import BUILTIN, Instant, Tree
from rocs_bt.trees.status import SUCCESS
from rocs_bt.trees.xml import load_xml, read_document, verify, write_tree

READ: list[tuple[str, str]] = []


class TheirReader(PortsMixin, py_trees.behaviour.Behaviour):
    INPUT_PORTS: ClassVar = {"value": PortInformation(str)}
    OUTPUT_PORTS: ClassVar = {}

    def update(self):
        READ.append((self.name.rpartition(".")[2], self.get_input("value")))
        return py_trees.common.Status.SUCCESS


class Reader(Instant):
    value: str

    def update(self):
        READ.append((self.name, self.value))
        return SUCCESS


def read_by(root):
    READ.clear()
    root.tick_once()
    return list(READ)


SUB = '<Sequence name="s"><Reader name="r1" value="{a}"/><Reader name="r2" value="{b}"/></Sequence>'
DEFAULTS = ("", 'a="1" b="text"', 'a="{x}" b="2"', 'b="{x}"')
GIVEN = ('a="7" b="8"', 'a="{x}"', 'b="{y}"', "")
CASES = [case for case in itertools.product(DEFAULTS, GIVEN) if all(f"{key}=" in " ".join(case) for key in "ab")]


@pytest.mark.parametrize(("defaults", "given"), CASES)
def test_attributes_of_a_tree_are_defaults_as_in_py_trees(tmp_path, defaults, given):
    file = tmp_path / "a.xml"
    file.write_text(
        '<root main_tree_to_execute="Main"><BehaviorTree ID="Main" x="of x" y="of y"><Sequence name="top">'
        f'<SubTree ID="Sub" name="one" {given}/><Reader name="r0" value="{{x}}"/>'
        '<Reader name="r3" value="{y}"/></Sequence></BehaviorTree>'
        f'<BehaviorTree ID="Sub" {defaults}>{SUB}</BehaviorTree></root>'
    )
    theirs = read_by(parse_behaviour_tree_xml(str(file), node_registry={"Reader": TheirReader}))
    with pytest.warns(UserWarning, match="BTCPP_format is missing"):
        root = load_xml(file, BUILTIN.with_([Reader]))
    assert read_by(Tree(root).root) == theirs
    assert len(theirs) == 4


@pytest.mark.parametrize("element", ['Import src="b.xml"', 'Include file="b.xml"', 'import file="b.xml"'])
def test_files_are_included_as_in_py_trees(tmp_path, element):
    (tmp_path / "b.xml").write_text(
        f'<root BTCPP_format="4"><BehaviorTree ID="Sub" a="1" b="2">{SUB}</BehaviorTree></root>'
    )
    main = f'<{element}/><BehaviorTree ID="Main"><Sequence name="t"><SubTree ID="Sub"/></Sequence></BehaviorTree>'
    (tmp_path / "a.xml").write_text(f'<root BTCPP_format="4" main_tree_to_execute="Main">{main}</root>')
    theirs = read_by(parse_behaviour_tree_xml(str(tmp_path / "a.xml"), node_registry={"Reader": TheirReader}))
    assert read_by(Tree(load_xml(tmp_path / "a.xml", BUILTIN.with_([Reader]))).root) == theirs


def test_a_default_that_no_node_reads_is_a_warning_and_defaults_are_written_again():
    text = (
        '<root BTCPP_format="4" main_tree_to_execute="M"><BehaviorTree ID="M" a="1" b="2" gaol="3">'
        f"{SUB}</BehaviorTree></root>"
    )
    document = read_document(text)
    (warning,) = verify(document, BUILTIN.with_([Reader]))
    assert (warning.message, warning.warning) == ("no node of the tree 'M' uses the key 'gaol'.", True)
    with pytest.warns(UserWarning, match="gaol"):
        root = load_xml(text, BUILTIN.with_([Reader]))
    assert read_document(write_tree(root, document=document)).main().defaults == {"a": "1", "b": "2", "gaol": "3"}
