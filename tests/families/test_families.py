"""What holds for every family that we ship, and that barn_like is as hard as BARN."""

from __future__ import annotations

import math
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import fisher_exact

from rocs_bt import Catalog, run
from rocs_bt.base.errors import InputError
from rocs_bt.check import check_content
from rocs_bt.compare import Family, Scene, length_of, load_family

CATALOG = Catalog()
FAMILIES = [entry.name for entry in CATALOG.list("family")]


@pytest.fixture(scope="module", params=FAMILIES)
def scenes(request: pytest.FixtureRequest) -> tuple[Family, list[Scene]]:
    family = load_family(CATALOG, request.param)
    return family, [family.scene(i) for i in range(4)]


def test_a_scene_is_told_wholly(scenes: tuple[Family, list[Scene]]) -> None:
    family, made = scenes
    assert [scene.name for scene in made] == [f"{family.name}-{i}" for i in range(4)]
    assert len({scene.world for scene in made}) == 4
    for scene in made:
        assert scene.difficulty
        assert all(math.isfinite(value) for value in scene.difficulty.values())
        assert scene.difficulty.keys() == made[0].difficulty.keys()
        assert scene.reference_length == pytest.approx(sum(map(math.dist, scene.reference, scene.reference[1:])))
        assert all(f"`{name}`" in (type(family).__doc__ or "") for name in scene.difficulty)


def test_scenes_are_the_same_wherever_they_are_made() -> None:
    code = (
        "from hashlib import sha256\nfrom rocs_bt import Catalog\nfrom rocs_bt.compare import load_family\n"
        "c = Catalog()\n"
        "for e in c.list('family'):\n"
        "    s = load_family(c, e.name).scene(3); print(e.name, sha256((s.toml + s.world).encode()).hexdigest())"
    )
    seeds = [
        subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=env).stdout
        for env in ({"PYTHONHASHSEED": "7"}, {"PYTHONHASHSEED": "8"})
    ]
    assert len(seeds[0].splitlines()) == len(FAMILIES)
    assert seeds[0] == seeds[1]


def test_a_scene_is_a_project_that_checks_and_runs(scenes: tuple[Family, list[Scene]], tmp_path: Path) -> None:
    _, made = scenes
    made[0].write(tmp_path)
    found = check_content([tmp_path])
    assert not found.faults, found.faults
    assert len(found.files) == 2
    catalog = Catalog(tmp_path)
    first = run(catalog.load_scenario(made[0].name), catalog, seed=1, duration=0.5, report=False).summary
    agents = {name: agent.outcome for name, agent in first.agents.items()}
    assert "R" in agents
    assert not {"error", "collision"} & set(agents.values())


def test_who_drives_has_no_part_in_the_world(scenes: tuple[Family, list[Scene]]) -> None:
    family, made = scenes
    other = load_family(CATALOG, family.name, {"rules": "", "robot": "summit_xl"}).scene(0)
    assert other.world == made[0].world
    assert other.scenario != made[0].scenario


def test_other_parameters_make_other_worlds() -> None:
    family = load_family(CATALOG, "maze", {"loops": 3})
    assert family.scene(0).reference != load_family(CATALOG, "maze").scene(0).reference


def test_parameters_are_typed_and_held_to_their_bounds() -> None:
    family = load_family(CATALOG, "crossing", {"people": 3, "speed": "50 cm/s"})
    assert family.parameters["people"] == 3
    assert family.parameters["speed"] == pytest.approx(0.5)
    assert family.parameters["wide"] == 7.0
    with pytest.raises(InputError) as caught:
        load_family(CATALOG, "crossing", {"peple": 3, "speed": "-1 m/s", "wide": 3, "people": "many"})
    told = [fault.message for fault in caught.value.faults]
    assert [text.split()[0] for text in told] == ["wide", "speed", "people", "no"]


def as_published(scene: Scene) -> list[tuple[float, float]]:
    """A reference way where the challenge puts its cells: one west, and 0.1 m south, of where they are."""
    return [scene.reference[0], *((x - 0.15, y - 0.1) for x, y in scene.reference[1:-1]), scene.reference[-1]]


@pytest.mark.parametrize("count", [75, pytest.param(300, marks=pytest.mark.soak)])
def test_barn_like_is_as_hard_as_barn(count: int) -> None:
    """Its first worlds and the 300 published ones: medians and means within 5 %, shares that no test tells apart."""
    family = load_family(CATALOG, "barn_like")
    made = [family.scene(i) for i in range(count)]
    assert len({scene.world for scene in made}) == count
    published = {"cylinders": (87, 166, 271), "length": (10.05, 11.23, 13.74), "clearance": (0.181, 0.225, 0.975)}
    ways = [as_published(scene) for scene in made]
    found = {
        "cylinders": np.array([scene.difficulty["cylinders"] for scene in made]),
        "length": np.array([length_of(way) for way in ways]),
        "clearance": np.array([scene.floor.clearance(way) for way, scene in zip(ways, made, strict=True)]),
    }
    for name, (least, median, most) in published.items():
        assert np.median(found[name]) == pytest.approx(median, rel=0.05), name
        assert ((least <= found[name]) & (found[name] <= most)).mean() >= 0.95, name
    assert found["cylinders"].mean() == pytest.approx(169.1, rel=0.05)
    assert found["length"].mean() / 2.0 == pytest.approx(5.71, rel=0.05)  # [s] at 2 m/s
    for bound, theirs in ((0.333, 222), (0.215, 2)):
        ours = int((found["clearance"] < bound).sum())
        assert fisher_exact([[ours, count - ours], [theirs, 300 - theirs]]).pvalue > 0.01, bound


def test_every_barn_like_world_has_room_for_a_robot_of_five_cells() -> None:
    """That is what the published generator asks of a world; the cylinders stand where the published ones do."""
    family = load_family(CATALOG, "barn_like")
    for index in range(0, 60, 6):
        scene = family.scene(index)
        posts = [g for g in ET.fromstring(scene.world).iter("geom") if g.get("type") == "cylinder"]
        places = np.array([[float(word) for word in (g.get("pos") or "").split()[:2]] for g in posts])
        assert {g.get("size") for g in posts} == {"0.075 0.5"}
        assert (places[:, 1] < 5.0).sum() == 94  # the corridor, the same in all
        assert len(posts) == 94 + scene.difficulty["cylinders"]
        lattice = (places - (-4.425, 0.075)) / 0.15
        assert np.abs(lattice - lattice.round()).max() < 1e-9
        assert lattice.round().max(axis=0).tolist() == [29, 63]
        for cell in scene.reference[1:-1]:
            assert np.abs(places - cell).max(axis=1).min() > 0.44  # nothing within two cells
