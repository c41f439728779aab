"""Thresholds that are computed: from each other, from an including file, and from constants of the robot."""

from dataclasses import replace

import numpy as np
import pytest

from rocs_bt.actions import ACTIONS
from rocs_bt.base.signal import Signal
from rocs_bt.base.toml_table import read_toml
from rocs_bt.base.units import LENGTH, SPEED, TIME, Quantity
from rocs_bt.control.body_values import BODY_VALUES
from rocs_bt.declare import Location
from rocs_bt.expression import Environment
from rocs_bt.reactive import Override, load_rules, read_rules

SIGNALS = Environment.packed([Signal("front", 3, (LENGTH,)), Signal("speed", 1, (SPEED,))])
RULE = '\n[rule.A]\nwhen = "min(front) < near"\npriority = 1\naction = { name = "Stop" }\n'
ROBOT = '[robot]\nlatency = "0.1 s"\ndeceleration = "2 m/s2"\n'
NEAR = '[threshold]\nnear = "fast * latency + fast * fast / (2 * deceleration) + gap"\ngap = "0.2 m"\nfast = "1 m/s"\n'


def write(folder, text, name="a.toml"):
    file = folder / name
    file.write_text('format = "reflex/1"\n' + text + RULE * (name == "a.toml"), encoding="utf-8")
    return file


def thresholds(file, robot=None, **overrides):
    own = {name: Override(value) for name, value in overrides.items()}
    return load_rules(file, replace(SIGNALS, robot=robot or {}), ACTIONS, overrides=own).thresholds


def test_a_threshold_follows_from_others_in_any_order_and_from_the_robot(tmp_path):
    file = write(tmp_path, ROBOT + NEAR)
    assert thresholds(file)["near"] == pytest.approx(0.1 + 0.25 + 0.2)
    assert thresholds(file, robot={"latency": Quantity(0.4, TIME)})["near"] == pytest.approx(0.4 + 0.25 + 0.2)
    assert thresholds(file, gap="0.5 m", latency="0 s")["near"] == pytest.approx(0.25 + 0.5)
    assert thresholds(file, gap="0.5 m", near="0.3 m")["near"] == 0.3


def test_an_including_file_changes_what_follows_from_its_thresholds(tmp_path):
    write(tmp_path, ROBOT + NEAR, "parts.toml")
    top = write(tmp_path, 'include = ["parts.toml"]\n[threshold]\nfast = "2 m/s"\ngap = "fast * 0.1 s"\n')
    assert thresholds(top)["near"] == pytest.approx(0.2 + 1.0 + 0.2)


@pytest.mark.parametrize("seed", range(20))
def test_random_chains_have_the_values_of_python(tmp_path, seed):
    rng, lines, values = np.random.default_rng(seed), [], {}
    for i in range(8):
        known = [*values, "0.5 m"]
        a, b = rng.choice(known, 2)
        text = f"{rng.choice(['min', 'max'])}({a}, {b}) + {rng.integers(1, 9)} * {rng.choice(known)}"
        values[f"t{i}"] = eval(text.replace(" m", ""), {"min": min, "max": max} | values)
        lines.append(f't{i} = "{text}"')
    rng.shuffle(lines)
    found = thresholds(write(tmp_path, '[threshold]\nnear = "0.4 m"\n' + "\n".join(lines) + "\n"))
    assert {name: found[name] for name in values} == pytest.approx(values, rel=1e-3)


def test_a_wrong_override_of_a_computed_threshold_is_told_at_the_robots_file(tmp_path):
    file, robot = write(tmp_path, ROBOT + NEAR), tmp_path / "robot.toml"
    (fault,) = read_rules(file, SIGNALS, ACTIONS, overrides={"near": Override("1 s", Location(robot, 7, 3))})[1]
    assert str(fault).startswith(f"{robot}:7:3: 'near' must be in m")


def test_every_constant_of_a_body_can_be_named(tmp_path):
    lines = "\n".join(f'{name} = "1 {value.dimension}"' for name, value in BODY_VALUES.items())
    text = f'format = "reflex/1"\n[threshold]\nnear = "1 m"\n[robot]\n{lines}\n{RULE}'
    rules = load_rules(read_toml(tmp_path / "a.toml", text), SIGNALS, ACTIONS)
    assert {name: rules.dimensions[name] for name in BODY_VALUES} == {n: v.dimension for n, v in BODY_VALUES.items()}
