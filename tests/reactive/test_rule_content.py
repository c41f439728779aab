"""What rule files hold besides rules: thresholds and who overrides them, included files, modes, inline tests."""

import numpy as np
import pytest

from rocs_bt.base.signal import Signal
from rocs_bt.base.units import ANGLE, LENGTH, SPEED, MetresPerSecond
from rocs_bt.declare import Location
from rocs_bt.expression import Environment
from rocs_bt.interfaces.action import AtomicAction, Progress
from rocs_bt.reactive import Override, RuleModel, included_files, load_rules, read_rules, run_tests

ENVIRONMENT = Environment.packed(
    [Signal("front", 3, (LENGTH,)), Signal("speed", 1, (SPEED,)), Signal("pose", 3, (LENGTH, LENGTH, ANGLE))]
)


class Move(AtomicAction):
    """Moves."""

    speed: MetresPerSecond = 0.5
    label: str = ""

    def act(self, body):
        return Progress.SUCCEEDED


ACTIONS = {"Move": Move}
HEAD = 'format = "reflex/1"\n'
RULE = '[rule.{}]\nwhen = "{}"\npriority = {}\naction = {{ name = "Move" }}\n'


def write(folder, name, text):
    file = folder / name
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(HEAD + text, encoding="utf-8")
    return file


def load(file, **overrides):
    return load_rules(file, ENVIRONMENT, ACTIONS, overrides={k: Override(v) for k, v in overrides.items()})


def latched(model, front, t=0.0, speed=0.0):
    model.react(np.array([front, front, front, speed, 0, 0, 0]), t)
    return [name.rpartition("/")[2] for name in model.latched]


def faults(file, **overrides):
    return [str(f) for f in read_rules(file, ENVIRONMENT, ACTIONS, overrides=overrides)[1]]


class TestThresholds:
    TEXT = '[threshold]\nnear = "0.4 m"\nwait = "0.2 s"\n[alias]\nclose = "min(front) < near"\n' + RULE.format(
        "A", "close", 1
    ).replace("priority", 'for = "wait"\npriority')

    def test_they_are_names_in_expressions_and_times(self, tmp_path):
        rules = load(write(tmp_path, "a.toml", self.TEXT))
        assert rules.thresholds == {"near": 0.4, "wait": 0.2}
        assert rules.rules[0].hold == 0.2
        model = RuleModel(rules)
        assert (latched(model, 0.39, 0.0), latched(model, 0.39, 0.2)) == ([], ["A"])

    def test_a_robot_has_its_own(self, tmp_path):
        rules = load(write(tmp_path, "a.toml", self.TEXT), near="50 cm", wait="0 s")
        assert rules.thresholds == {"near": 0.5, "wait": 0.0}
        assert latched(RuleModel(rules), 0.45) == ["A"]

    @pytest.mark.parametrize(
        ("own", "message"),
        [
            ({"nar": "1 m"}, "no threshold of 'a' is named 'nar'. Did you mean 'near'?"),
            ({"near": "1 s"}, "'near' must be in m, found '1 s' which is in s"),
            ({"near": 1}, "'near' needs a unit, found the bare number 1"),
            ({"wait": "-1 s"}, "for must be a time of 0 s or more, but the threshold 'wait' is -1 s"),
        ],
    )
    def test_what_a_robot_gets_wrong_is_told_at_its_place(self, tmp_path, own, message):
        file, robot = write(tmp_path, "a.toml", self.TEXT), tmp_path / "robot.toml"
        told = faults(file, **{k: Override(v, Location(robot, 7, 3)) for k, v in own.items()})
        assert len(told) == 1
        assert message in told[0]
        assert told[0].startswith(f"{robot}:7:3: " if "for must" not in message else str(file))


class TestInclude:
    def test_rules_aliases_and_thresholds_come_along(self, tmp_path):
        common = write(
            tmp_path, "rules/parts/common.toml", '[threshold]\nnear = "0.4 m"\n[alias]\nclose = "min(front) < near"\n'
        )
        stop = write(tmp_path, "rules/stop.toml", 'include = ["parts/common.toml"]\n' + RULE.format("Stop", "close", 9))
        top = write(
            tmp_path,
            "rules/all.toml",
            'include = ["stop.toml", "parts/common.toml"]\n[threshold]\nnear = "0.6 m"\n'
            + RULE.format("Slow", "close and speed > 1 m/s", 1),
        )
        rules = load(top)
        assert [rule.name for rule in rules.rules] == ["all/Stop", "all/Slow"]
        assert list(rules.files) == [common, stop, top]
        assert included_files(top) == [common, stop]
        assert latched(RuleModel(rules), 0.5, speed=2.0) == ["Stop", "Slow"]
        assert latched(RuleModel(load(stop)), 0.5) == []

    def test_a_circle_is_found(self, tmp_path):
        a = write(tmp_path, "a.toml", 'include = ["b.toml"]\n' + RULE.format("A", "True", 1))
        b = write(tmp_path, "b.toml", 'include = ["a.toml"]\n')
        assert faults(a) == [f"{b}:2:1: the files include each other: a.toml -> b.toml -> a.toml."]

    @pytest.mark.parametrize(
        ("named", "message"),
        [
            ("../../x.toml", "is outside of"),
            ("/etc/passwd", "is outside of"),
            ("none.toml", "no file"),
            ("bad.toml", "bad.toml:2:5: not valid TOML"),
            ("strange.toml", "strange.toml:2:1: unknown key 'zzz' in the file"),
            ("twice.toml", "an included file already has a rule named 'A'"),
            ("tie.toml", "A has the same priority 1 as B, but another action"),
        ],
    )
    def test_mistakes(self, tmp_path, named, message):
        write(tmp_path, "rules/bad.toml", "a = = 1")
        write(tmp_path, "rules/strange.toml", "zzz = 1")
        write(tmp_path, "rules/twice.toml", RULE.format("A", "True", 3))
        write(tmp_path, "rules/tie.toml", RULE.format("B", "True", 1).replace('"Move"', '"Move", label = "b"'))
        top = write(tmp_path, "rules/a.toml", f'include = ["{named}"]\n' + RULE.format("A", "True", 1))
        told = faults(top)
        assert any(message in t for t in told), told


def test_absurdly_many_rules_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("rocs_bt.reactive.rule_file.MAX_RULES", 2)
    text = "".join(RULE.format(f"R{i}", "True", i) for i in range(3))
    assert any("at most 2 rules" in t for t in faults(write(tmp_path, "a.toml", text)))


class TestModes:
    def test_a_rule_lives_in_its_modes(self, tmp_path):
        text = RULE.format("A", "min(front) < 1 m", 1).replace("priority", 'modes = ["drive", "dock"]\npriority')
        model = RuleModel(load(write(tmp_path, "a.toml", text + RULE.format("B", "min(front) < 1 m", 2))))
        assert latched(model, 0.5) == ["B"]
        model.enter("dock")
        assert latched(model, 0.5) == ["A", "B"]
        model.enter("rest")
        (told, _) = model.react(np.array([0.5] * 7), 0.1)
        assert (told.rule, told.latched) == ("a/A", False)
        assert model.latched == ("a/B",)

    def test_a_latch_survives_a_reload_where_the_rule_has_the_same_name(self, tmp_path):
        text = RULE.format("A", "min(front) < 1 m", 1).replace("priority", 'until = "min(front) > 2 m"\npriority')
        model = RuleModel(load(write(tmp_path, "a.toml", text + RULE.format("B", "min(front) < 1 m", 2))))
        assert latched(model, 0.5, 5.0) == ["A", "B"]
        model.replace(load(write(tmp_path, "a.toml", RULE.format("C", "True", 3) + text)))
        assert model.latched == ("a/A", "a/B")
        assert latched(model, 1.5, 5.1) == ["C", "A"]
        assert latched(model, 2.5, 5.2) == ["C"]


class TestInline:
    def results(self, tmp_path, body):
        rule = RULE.format("A", "min(front) < 1 m and held(speed > 1 m/s, 0.1 s)", 1)
        rule = rule.replace('{ name = "Move" }', '{ name = "Move", speed = "speed * 2", label = "x" }')
        return run_tests(load(write(tmp_path, "a.toml", rule + "[[rule.A.test]]\n" + body)))

    def test_what_passes(self, tmp_path):
        (result,) = self.results(
            tmp_path,
            'name = "fast"\ngiven = { front = ["5 m", "inf m", "50 cm"], speed = "2 m/s" }\n'
            'at = [{ t = "0 s" }, { t = "0.1 s" }, { t = "0.2 s", "front[1:]" = "2 m" },\n'
            '{ t = "0.3 s", front = "nan" }]\n'
            'expect = [{ t = "0 s", fires = false }, { t = "0.1 s", fires = true, speed = "4 m/s", label = "x" },\n'
            '{ t = "0.2 s", fires = false }, { t = "0.3 s", fires = false }]\n',
        )
        assert (result.rule, result.test, result.passed, result.message) == ("a/A", "fast", True, "")

    @pytest.mark.parametrize(
        ("expect", "message"),
        [
            (
                "fires = true",
                "the rule does not fire, but 'fires = true' is expected; guard values: min(front) = 0.5",
            ),
            ('speed = "1 m/s"', "speed = 1.0 is expected, but the rule does not fire"),
        ],
    )
    def test_what_fails_says_what_was_seen(self, tmp_path, expect, message):
        (result,) = self.results(
            tmp_path,
            'given = { front = "0.5 m", speed = "2 m/s" }\nat = [{ t = "0 s" }]\n'
            f'expect = [{{ t = "0 s", {expect} }}]\n',
        )
        assert message in result.message
        assert (result.test, result.passed, result.position.line) == ("A, test 1", False, 9)

    def test_a_parameter_that_differs(self, tmp_path):
        (result,) = self.results(
            tmp_path,
            'given = { front = "0.5 m", speed = "2 m/s" }\nat = [{ t = "0 s" }, { t = "1 s" }]\n'
            'expect = [{ t = "1 s", fires = true, speed = "3 m/s" }]\n',
        )
        assert "at t = 1 s speed is 4.0, but 3.0 is expected" in result.message
