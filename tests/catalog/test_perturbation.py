"""Perturbations change the simulated robot, and never the model that its agent has of it."""

from __future__ import annotations

from pathlib import Path

import pytest

from rocs_bt.base.errors import InputError, UnknownName
from rocs_bt.base.units import NONE, Quantity
from rocs_bt.catalog import Catalog, Perturbation, RobotSpec, parse_perturbation, perturbed
from rocs_bt.declare import replaced
from rocs_bt.event.sink import NullSink
from rocs_bt.simulation.simulated_world import build_world

CATALOG = Catalog()
SHIPPED = CATALOG.load_perturbations()
JACKAL = CATALOG.load_robot("jackal")


def values(robot: RobotSpec, key: str) -> list[float]:
    devices = [*robot.sensors, *robot.actuators]
    return [d.arguments[key] for d in devices if key in d.arguments]


def test_each_shipped_perturbation_changes_the_jackal_as_written() -> None:
    found = {name: each.of(JACKAL) for name, each in SHIPPED.items()}
    assert [s.noise for s in found["noise"].sensors] == [3.0 * s.noise for s in JACKAL.sensors]
    assert values(found["delay"], "delay") == pytest.approx([0.2])
    assert values(found["wheel_radius"], "wheel_radius") == pytest.approx([0.098 * 1.05] * 2)
    assert [s.drop_out for s in found["lost_scans"].sensors] == [0.2, 0.0, 0.0, 0.0]
    assert values(found["odometry"], "odometry") == [0.01, 0.01]
    assert found["friction"].variant.friction == 0.3
    assert found["body"].variant.size == pytest.approx(1.1)
    assert values(found["body"], "wheel_radius") == pytest.approx([0.098 * 1.1] * 2)


@pytest.mark.parametrize("robot", [entry.name for entry in CATALOG.list("robot") if "ros2" not in entry.name])
def test_what_the_agent_knows_never_changes(robot: str) -> None:
    spec = CATALOG.load_robot(robot)
    for each in SHIPPED.values():
        try:
            found = each.of(spec)
        except InputError:
            continue
        same = replaced(found, sensors=spec.sensors, actuators=spec.actuators, variant=spec.variant)
        assert same == spec
        assert found != spec
        assert [s.size for s in found.sensors] == [s.size for s in spec.sensors]


def test_a_world_has_the_perturbed_robot_and_its_agent_the_model_of_the_file() -> None:
    scenario = CATALOG.load_scenario("circle_box")
    agent = scenario.agents[0]
    changed = (SHIPPED["body"], SHIPPED["friction"])
    cold = replaced(scenario, agents=(replaced(agent, perturbations=changed), *scenario.agents[1:]))
    warm_world, cold_world = (build_world(each, CATALOG, 1, NullSink()) for each in (scenario, cold))
    assert cold_world.devices(agent.name).robot == warm_world.devices(agent.name).robot
    hulls = [sum(each.world.model.geom_size[:, 0]) for each in (warm_world, cold_world)]
    assert hulls[1] > hulls[0]
    assert 0.3 in cold_world.world.model.geom_friction[:, 0]
    assert 0.3 not in warm_world.world.model.geom_friction[:, 0]


def test_perturbations_are_applied_one_after_the_other() -> None:
    twice = perturbed(JACKAL, (SHIPPED["delay"], SHIPPED["delay"].at(0.3)))
    assert values(twice, "delay") == pytest.approx([0.5])


def test_a_default_of_a_driver_is_a_value_and_a_missing_key_an_error() -> None:
    robot = CATALOG.load_robot("pioneer_p3dx")
    assert values(robot, "delay") == []
    assert values(SHIPPED["delay"].of(robot), "delay") == pytest.approx([0.1])
    odd = Perturbation(name="odd", device="sensor", keys=("counts",), change="times", strength=Quantity(2.0, NONE))
    with pytest.raises(InputError, match="'odd' has no effect on 'jackal': no sensor has a value of 'counts'"):
        odd.of(JACKAL)


def test_a_name_with_a_strength_selects_a_perturbation() -> None:
    assert [str(parse_perturbation(each, SHIPPED)) for each in ("noise=6", " delay ")] == ["noise=6", "delay=0.1"]
    assert parse_perturbation("delay=200 ms", SHIPPED).amount == "0.2 s"
    assert parse_perturbation("delay=0.2", SHIPPED).next().amount == "0.4 s"
    assert SHIPPED["friction"].next().strength.value == pytest.approx(0.15)


@pytest.mark.parametrize("text", ["delay=-1", "delay=3 m", "delay=often", "delay=0", "delay=inf", "delay="])
def test_an_invalid_strength_is_refused(text: str) -> None:
    with pytest.raises(InputError):
        parse_perturbation(text, SHIPPED)


def test_an_unknown_perturbation_is_refused_with_those_that_exist() -> None:
    with pytest.raises(UnknownName, match="perturbation"):
        CATALOG.load_planner("tree~nois")


def test_a_planner_with_perturbations_has_their_names() -> None:
    planner = CATALOG.load_planner("tree@pioneer_p3dx~noise=6~delay")
    assert planner.name == "tree@pioneer_p3dx~noise=6~delay=0.1"
    assert (planner.robot, [each.strength.value for each in planner.perturbations]) == ("pioneer_p3dx", [6.0, 0.1])


def written(folder: Path, text: str) -> Catalog:
    (folder / "robots").mkdir(parents=True)
    (folder / "robots" / "perturbations.toml").write_text(f'format = "perturbations/1"\n{text}', encoding="utf-8")
    return Catalog(folder)


OWN = '[perturbation.slow]\ndevice = "actuator"\nkeys = ["max_acceleration"]\nchange = "times"\nstrength = 0.5\n'


def test_a_project_adds_its_own_and_replaces_a_shipped_one(tmp_path: Path) -> None:
    found = written(tmp_path, OWN + OWN.replace("slow", "noise")).load_perturbations()
    assert set(found) == {*SHIPPED, "slow"}
    assert found["noise"].device == "actuator"
    assert values(found["slow"].of(JACKAL), "max_acceleration") == pytest.approx([2.5])


def test_a_share_never_exceeds_one() -> None:
    scans = SHIPPED["lost_scans"].at(1.0)
    assert scans.of(JACKAL) != JACKAL
    with pytest.raises(InputError, match=r"'drop_out' is a share from 0 to 1, and 'lost_scans=1.6' makes it 1.6"):
        scans.at(1.6).of(JACKAL)
