"""Mission files: their parameters, their checks, and those that we ship."""

import importlib.util
from pathlib import Path

import py_trees
import pytest
from py_trees.behaviour import Behaviour
from py_trees.composites import Sequence

from rocs_bt.base.errors import InputError
from rocs_bt.base.geometry import Pose2
from rocs_bt.base.units import SPEED, PositiveMetresPerSecond
from rocs_bt.catalog import Catalog
from rocs_bt.expression import Environment, compile_expression
from rocs_bt.plan import Mission, mission_arguments, mission_parameters

from .checking import check_mission

FOLDER = Path(__file__).parents[2] / "planners" / "missions"
SHIPPED = sorted(FOLDER.glob("*.py"))


def load(file):
    spec = importlib.util.spec_from_file_location(file.stem, file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def typed(
    mission: Mission, *, goal: str, cruise: PositiveMetresPerSecond = 0.5, rounds: int = 2, loud: bool = False
) -> Behaviour:
    return mission.act("GoTo", goal=goal, cruise=cruise)


@pytest.fixture
def check(rig):
    def run(build, *, robot="ant (A in yard)", **parameters):
        environment = Environment.of(rig.knowledge.signals)
        return check_mission(
            build,
            actions=rig.actions,
            knowledge=rig.knowledge,
            clock=rig.clock,
            parameters=parameters,
            compile_guard=lambda text: compile_expression(text, environment),
            robot=robot,
        )

    return run


class TestParameters:
    def test_they_are_the_keyword_only_parameters_of_build(self):
        found = mission_parameters(typed)
        assert list(found) == ["goal", "cruise", "rounds", "loud"]
        assert (found["goal"].hint, found["goal"].required) == (str, True)
        assert (found["cruise"].dimension, found["cruise"].default) == (SPEED, 0.5)

    def test_a_files_values_become_si_numbers(self):
        given = {"goal": "dock", "cruise": "30 cm/s", "rounds": 3, "loud": True}
        assert mission_arguments(typed, given) == {
            "goal": "dock",
            "cruise": pytest.approx(0.3),
            "rounds": 3,
            "loud": True,
        }

    def test_build_must_have_its_form(self):
        def positional(mission, goal: str, *, cruise=0.5): ...
        def empty(): ...

        with pytest.raises(InputError) as caught:
            mission_parameters(positional)
        assert "'goal' of build is not keyword-only" in str(caught.value)
        assert "'cruise' of build has no type" in str(caught.value)
        with pytest.raises(InputError, match="takes no mission"):
            mission_parameters(empty)
        with pytest.raises(InputError, match="cannot be read"):
            mission_parameters(3)

    def test_an_annotation_that_means_nothing_is_told(self):
        def build(mission: Mission, *, goal: "Nowhere" = 1): ...  # noqa: F821 - that it means nothing is the point

        with pytest.raises(InputError, match="Nowhere"):
            mission_parameters(build)


class TestCheck:
    def test_a_goal_that_is_nowhere_is_a_warning_when_places_are_known(self, rig, check):
        assert check(typed, goal="dok") == []
        rig.knowledge.world.place("dock", Pose2(1.0, 0.0), kind="goal")
        (fault,) = check(typed, goal="dok")
        assert fault.warning
        assert "Did you mean 'dock'" in str(fault)

    @pytest.mark.parametrize("root", [None, "GoTo", py_trees.behaviours.Running])
    def test_build_must_return_a_tree(self, check, root):
        def build(mission: Mission):
            return root

        (fault,) = check(build)
        assert "not a py_trees behaviour" in str(fault)

    def test_a_leaf_that_is_in_no_tree_is_a_warning(self, check):
        def build(mission: Mission):
            mission.act("TurnTo", yaw=1.0)
            return mission.wait(1.0)

        (fault,) = check(build)
        assert fault.warning
        assert "test_mission_files.py:108: warning: 'TurnTo': this leaf was created but is not in the tree." in str(
            fault
        )

    def test_wall_clocks_and_shared_blackboards_are_warned_of(self, check):
        class Writes(py_trees.behaviours.Running):
            def __init__(self):
                super().__init__("writes")
                self.attach_blackboard_client()

        def build(mission: Mission):
            timed = py_trees.decorators.Timeout("hurry", child=Writes(), duration=1.0)
            return Sequence("s", memory=True, children=[py_trees.timers.Timer("timer"), timed])

        faults = check(build)
        assert all(f.warning for f in faults)
        text = "\n".join(map(str, faults))
        for name in ("'timer' reads the wall clock", "'hurry' reads the wall clock", "'writes' uses py_trees' Blackb"):
            assert name in text


class TestShipped:
    @pytest.mark.parametrize("file", SHIPPED, ids=lambda f: f.stem)
    def test_every_mission_explains_itself_and_has_no_faults(self, rig, check, file):
        rig.knowledge.world.place("goal", Pose2(1.0, 0.0), kind="goal")
        rig.knowledge.world.place("object", Pose2(2.0, 0.0), kind="object")
        assert load(file).__doc__
        build = Catalog().load_mission(file.stem)
        needed = {n: n for n, p in mission_parameters(build).items() if p.required}
        # A goal that this rig does not have is a doubt; anything else would be a fault.
        assert [f for f in check(build, robot="", **needed) if not f.warning] == []

    @pytest.mark.parametrize("file", SHIPPED, ids=lambda f: f.stem)
    def test_every_mission_is_in_the_readmes_table(self, file):
        assert f"`{file.stem}`" in (FOLDER.parent / "README.md").read_text()
