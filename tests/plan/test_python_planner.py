"""Planners in Python: classes of every form declare their parameters by annotations."""

import pytest

from rocs_bt import Catalog, run
from rocs_bt.base.errors import InputError
from rocs_bt.check import check_content

BASE = """
from dataclasses import InitVar, dataclass, field

from rocs_bt import PositiveMetresPerSecond, Twist2


class Ahead:
    def reset(self, task, rng):
        pass

    def act(self, observation):
        return Twist2(self.speed)


"""
PLAIN = "class Mine(Ahead):\n    speed: PositiveMetresPerSecond = 0.1\n"
FORMS = {
    "plain": PLAIN,
    "another default": PLAIN.replace("Mine", "Fast") + "\n\nclass Mine(Fast):\n    speed = 0.2\n",
    "dataclass": "@dataclass(kw_only=True)\n"
    + PLAIN
    + "    gains: list[float] = field(default_factory=list)\n    count: int = field(default=0, init=False)\n"
    + "    half: InitVar[bool] = False\n\n    def __post_init__(self, half):\n"
    + "        self.speed *= 0.5 if half else 1.0\n",
    "slots": 'class Mine(Ahead):\n    __slots__ = ("speed",)\n    speed: PositiveMetresPerSecond\n',
    "constructor": PLAIN + "\n    def __init__(self):\n        self.speed = 2.0 * self.speed\n",
}
DEFAULT = {"plain": 0.1, "another default": 0.2, "dataclass": 0.1, "slots": None, "constructor": 0.2}


def planner(project, text, parameters=""):
    (project / "planners").mkdir(exist_ok=True)
    (project / "planners/mine.py").write_text(BASE + text, "utf-8")
    file = project / "planners/mine.toml"
    file.write_text(f'format = "planner/1"\ndoc = "Ahead."\npython = "mine.py:Mine"\n\n[parameters]\n{parameters}\n')
    return file


@pytest.mark.parametrize("form", FORMS)
def test_its_fields_are_its_parameters(tmp_path, form):
    double = 2.0 if form == "constructor" else 1.0
    for given, speed in (("", DEFAULT[form]), ('speed = "0.15 m/s"', double * 0.15)):
        file = planner(tmp_path, FORMS[form], given)
        if speed is None:
            (fault,) = check_content([file]).faults
            assert fault.message == "the mission needs speed."
            continue
        assert not check_content([file]).faults
        catalog = Catalog(tmp_path)
        spec = catalog.load_planner("mine").drives(catalog.load_scenario("exp1"), "R2")
        path = run(spec, catalog, duration=2.0).summary.agents["R2"].path_length
        assert path == pytest.approx(2.0 * speed, rel=0.25)


def test_a_constructor_with_parameters_is_refused_with_advice(tmp_path):
    text = (
        "class Mine(Ahead):\n    def __init__(self, *, speed: PositiveMetresPerSecond):\n        self.speed = speed\n"
    )
    file = planner(tmp_path, text, 'speed = "0.1 m/s"')
    (fault,) = check_content([file]).faults
    assert fault.message == "the constructor of 'Mine' needs speed."
    assert "Declare it by an annotation of the class" in str(fault)
    catalog = Catalog(tmp_path)
    spec = catalog.load_planner("mine").drives(catalog.load_scenario("exp1"), "R2")
    with pytest.raises(InputError, match="the constructor of 'Mine' needs speed"):
        run(spec, catalog, duration=1.0)


def test_a_planner_outside_of_planners_has_its_class_beside_it(tmp_path):
    file, elsewhere = planner(tmp_path, PLAIN), tmp_path / "drafts"
    file.parent.rename(elsewhere)
    catalog = Catalog(tmp_path)
    spec = catalog.load_planner(str(elsewhere / file.name)).drives(catalog.load_scenario("exp1"), "R2")
    assert run(spec, catalog, duration=1.0).summary.agents["R2"].path_length == pytest.approx(0.1, rel=0.25)
