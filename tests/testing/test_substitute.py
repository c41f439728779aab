"""Substitution rules, BehaviorTree.CPP's JSON form of them, and faults on purpose."""

import json

import pytest

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import InputError
from rocs_bt.base.nesting import descendants
from rocs_bt.catalog import Catalog
from rocs_bt.testing.missions import Breaks, Flaky, Raises, ScriptedOutcomes, inject, play, read_rules, substitute
from rocs_bt.trees.error import TreeError
from rocs_bt.trees.nodes import Tree
from rocs_bt.trees.status import outcome_name
from rocs_bt.trees.xml import load_xml

TEXT = """<root BTCPP_format="4" main_tree_to_execute="Main">
  <BehaviorTree ID="Main">
    <Sequence name="top">
      <Script name="one" code="a := 1"/>
      <SubTree ID="Sub" name="mysub"/>
      <Script name="two" code="b := 1"/>
    </Sequence>
  </BehaviorTree>
  <BehaviorTree ID="Sub">
    <Sequence>
      <AlwaysSuccess name="action_a"/>
      <AlwaysSuccess name="action_b"/>
    </Sequence>
  </BehaviorTree>
</root>"""


def document(body):
    return f'<root BTCPP_format="4"><BehaviorTree ID="M">{body}</BehaviorTree></root>'


def tags(root):
    return {node.name: node.tag for node in descendants(root)}


def tick(root, times=1):
    clock = SimulatedClock(0.1)
    tree, found = Tree(root, clock=clock), []
    for _ in range(times):
        found.append(outcome_name(tree.tick()))
        clock.advance()
    return found


class TestFilters:
    @pytest.mark.parametrize(
        ("filter", "changed"),
        [
            ("one", {"one"}),
            ("Script", {"one", "two"}),
            ("mysub/action_a", {"action_a"}),
            ("mysub/action_*", {"action_a", "action_b"}),
            ("mysub/action_?", {"action_a", "action_b"}),
            ("*wo", {"two"}),
            ("t?o", {"two"}),
            ("[to]*", None),
        ],
    )
    def test_names_paths_classes_and_wildcards(self, filter, changed):
        root = load_xml(TEXT)
        if changed is None:
            with pytest.raises(InputError, match="matches no node"):
                substitute(root, {filter: "AlwaysFailure"})
            return
        found = tags(substitute(root, {filter: "AlwaysFailure"}))
        assert {name for name, tag in found.items() if tag == "AlwaysFailure"} == changed

    def test_a_name_outranks_a_class_and_a_class_a_pattern_whatever_the_order(self):
        rules = {"*o*": {"return_status": "FAILURE"}, "Script": "AlwaysFailure", "two": ScriptedOutcomes("S")}
        found = tags(substitute(load_xml(TEXT), {**rules, "top": "Fallback"}))
        assert (found["one"], found["two"], found["action_a"]) == ("AlwaysFailure", "Scripted", "TestNode")

    def test_among_patterns_the_first_counts(self):
        rules = {"mysub/action_a*": "AlwaysFailure", "mysub/action*": "TestNode"}
        found = tags(substitute(load_xml(TEXT), rules))
        assert (found["action_a"], found["action_b"]) == ("AlwaysFailure", "TestNode")

    def test_a_pattern_means_nodes_with_children_too_as_in_behaviortree_cpp(self):
        found = tags(substitute(load_xml(TEXT), {"mysub/*": "TestNode"}))
        assert found["Sequence"] == "TestNode"
        assert "action_a" not in found

    def test_a_subtree_and_the_root_can_be_replaced(self):
        assert tags(substitute(load_xml(TEXT), {"mysub": "AlwaysFailure"}))["mysub"] == "AlwaysFailure"
        assert tick(substitute(load_xml(TEXT), {"top": "AlwaysFailure"})) == ["FAILURE"]

    def test_a_control_takes_over_the_children(self):
        root = substitute(load_xml(TEXT), {"top": "Fallback"})
        assert [child.name for child in root.children] == ["one", "mysub", "two"]
        assert all(child.parent is root for child in root.children)
        assert tick(root) == ["SUCCESS"]

    def test_all_filters_that_mean_nothing_are_told_with_what_is_there(self):
        with pytest.raises(InputError) as caught:
            substitute(load_xml(TEXT), {"ones": "TestNode", "x*": "TestNode", "two": "TestNode"})
        first, second = caught.value.faults
        assert "'ones' matches no node of this tree" in first.message
        assert "Did you mean 'one'" in first.hint
        assert "'x*'" in second.message

    def test_a_rule_that_names_no_class(self):
        with pytest.raises(InputError, match="no node is named 'AlwysFailure'"):
            substitute(load_xml(TEXT), {"one": "AlwysFailure"})


class TestTestNodes:
    def test_the_json_form_of_behaviortree_cpp(self):
        rules = read_rules(
            json.dumps(
                {
                    "TestNodeConfigs": {
                        "Slow": {"async_delay": 200, "return_status": "SUCCESS", "post_script": "c := 7"},
                        "Fails": {"return_status": "FAILURE"},
                    },
                    "SubstitutionRules": {"mysub/action_*": "AlwaysSuccess", "two": "Slow", "one": "Fails"},
                }
            )
        )
        root = substitute(load_xml(TEXT), rules | {"one": ScriptedOutcomes("S")})
        assert tick(root, 3) == ["RUNNING", "RUNNING", "SUCCESS"]
        assert root.board["c"] == 7
        assert tick(substitute(load_xml(TEXT), rules)) == ["FAILURE"]

    def test_a_file_of_rules(self, tmp_path):
        file = tmp_path / "rules.json"
        file.write_text('{"SubstitutionRules": {"one": "AlwaysFailure"}}')
        assert read_rules(file) == {"one": "AlwaysFailure"}

    @pytest.mark.parametrize("text", ["{", "[]", "{}", '{"SubstitutionRules": []}'])
    def test_what_is_no_such_document(self, text):
        with pytest.raises(InputError, match=r"substitution rules|SubstitutionRules"):
            read_rules(text)

    def test_a_config_with_an_unknown_key_is_refused(self):
        with pytest.raises(InputError, match="no port is named 'return_staus'"):
            substitute(load_xml(TEXT), {"one": {"return_staus": "FAILURE"}})

    def test_letters_for_a_pattern_leave_built_in_nodes_alone(self):
        text = TEXT.replace('<AlwaysSuccess name="action_b"/>', '<GoTo name="action_b" goal="g"/>')
        trace = play(text, leaves={"mysub/*": "RS"}, catalog=Catalog())
        assert trace["action_a"] == "S ."
        assert trace["action_b"] == "R S"


class TestFaults:
    BODY = document('<KeepRunningUntilFailure><AlwaysSuccess name="a"/></KeepRunningUntilFailure>')

    def run(self, make, times=6):
        return tick(inject(load_xml(self.BODY), {"a": make}), times)

    def test_breaks_from_a_round_on(self):
        assert self.run(lambda node: Breaks("b", node, at=3), 4) == ["RUNNING", "RUNNING", "FAILURE", "FAILURE"]

    def test_breaks_for_some_rounds(self):
        assert self.run(lambda node: Breaks("b", node, at=2, rounds=1), 4) == [
            "RUNNING",
            "FAILURE",
            "RUNNING",
            "RUNNING",
        ]

    def test_one_that_freezes_runs_into_a_timeout(self):
        text = document('<Timeout msec="250"><AlwaysSuccess name="a"/></Timeout>')
        root = inject(load_xml(text), {"a": lambda node: Breaks("b", node, outcome="RUNNING")})
        assert tick(root, 4) == ["RUNNING", "RUNNING", "RUNNING", "FAILURE"]

    def test_flaky_is_the_same_for_the_same_seed_and_fails_as_often_as_it_says(self):
        first, second = (self.run(lambda node: Flaky("f", node, probability=0.3, seed=4), 2000) for _ in range(2))
        other = self.run(lambda node: Flaky("f", node, probability=0.3, seed=5), 2000)
        assert first == second != other
        assert 500 < first.count("FAILURE") < 700

    def test_an_error_is_told_with_its_node(self):
        with pytest.raises(TreeError, match="r: the gripper is gone"):
            self.run(lambda node: Raises("r", node, at=2, message="the gripper is gone"))

    def test_every_node_of_a_pattern_and_the_root(self):
        root = inject(load_xml(TEXT), {"mysub/action_*": lambda n: Breaks(f"{n.name} jam", n, at=9), "top": _never})
        assert [n.name for n in descendants(root) if isinstance(n, Breaks)] == ["never", "action_a jam", "action_b jam"]
        assert all(child.parent is node for node in descendants(root) for child in node.children)
        assert tick(root) == ["SUCCESS"]

    def test_in_play(self):
        body = '<RetryUntilSuccessful num_attempts="3"><GoTo name="a" goal="g"/></RetryUntilSuccessful>'
        jam = {"a": lambda node: Breaks("jam", node, rounds=2)}
        trace = play(document(body), leaves={"a": "S"}, faults=jam, catalog=Catalog())
        assert (trace["jam"], trace["a"]) == ("F F S", ". . S")


def _never(node):
    return Breaks("never", node, at=10**6)
