"""What is written is read again; the JSON Schema of a kind admits all files that are shipped, and no others."""

import json
import re
import tomllib
from pathlib import Path

import pytest

from rocs_bt.base.toml_table import read_toml
from rocs_bt.base.toml_text import as_toml
from rocs_bt.catalog import KINDS, Catalog
from rocs_bt.cli.main import call
from rocs_bt.cli.show import TABLES
from rocs_bt.declare import data_of, read, replaced, values_of

from .. import needs

ROOT = Path(__file__).parents[2]
FILES = {
    "identified": sorted(ROOT.glob("robots/*/identified.toml")),
    "rule_tests": sorted(ROOT.glob("rules/tests/*.toml")),
    **{kind: sorted(path for p in of.patterns for path in ROOT.glob(p)) for kind, of in KINDS.items() if of.table},
}
FILES["schema"] += ROOT.glob("rocs_bt/knowledge/schema/*.toml")


@pytest.mark.parametrize(
    ("kind", "file"), [(kind, file) for kind in ("scenario", "planner", "robot") for file in FILES[kind]], ids=str
)
@pytest.mark.parametrize("levels", [0, 2])
def test_what_is_written_is_read_again(kind, file, levels):
    spec = getattr(Catalog(), f"load_{kind}")(file.parent.name if kind == "robot" else file.stem)
    spec = replaced(spec, base="") if kind == "robot" else spec  # the tables of the base are read already
    root = read_toml(file, as_toml(data_of(spec), levels))
    again = read(type(spec), root)
    root.done()
    from_file = {name: values_of(spec)[name] for name in ("name", "file", "bases") if name in values_of(spec)}
    assert repr(replaced(again, **from_file)) == repr(spec)  # equal, also where a heading is NaN


@pytest.fixture(scope="module")
def faults(tmp_path_factory):
    """Paths of the values that the schema of a kind refuses."""
    jsonschema = needs.package("jsonschema")
    folder, checkers = tmp_path_factory.mktemp("schemas"), {}
    for kind in TABLES:
        assert call(["show", "--schema", kind, "--out", str(folder / kind)]) == 0
        schema = json.loads((folder / kind).read_text(encoding="utf-8"))
        jsonschema.Draft202012Validator.check_schema(schema)
        checkers[kind] = jsonschema.Draft202012Validator(schema)
    return lambda kind, data: {error.json_path for error in checkers[kind].iter_errors(data)}


@pytest.mark.parametrize(("kind", "file"), [(kind, file) for kind in TABLES for file in FILES[kind]], ids=str)
def test_the_schema_admits_each_shipped_file(faults, kind, file):
    assert faults(kind, tomllib.loads(file.read_text(encoding="utf-8"))) == set()


@pytest.mark.parametrize(
    ("wrong", "where"),
    [
        ({"duratoin": "5 s"}, "$"),
        ({"duration": 5.0}, "$.duration"),
        ({"duration": "5 m"}, "$.duration"),
        ({"end_on_collision": "yes"}, "$.end_on_collision"),
        ({"world": None}, "$"),
        ({"format": "scenario/1"}, "$.format"),
        ({"place": [{"name": "a", "x": "1 m"}]}, "$.place[0]"),
        ({"place": [{"name": "a", "x": "1 m", "y": "1 m", "kind": "gaol"}]}, "$.place[0].kind"),
        ({"base": "exp2", "rate": {"plan": "10 m"}}, "$.rate.plan"),
        ({"base": "exp2", "world": None, "agent": [{"name": "R2", "yaw": "1 rad"}]}, ""),
    ],
)
def test_the_schema_refuses_what_the_reader_refuses(faults, wrong, where):
    data = tomllib.loads((ROOT / "scenarios" / "exp1.toml").read_text(encoding="utf-8")) | wrong
    data = {key: value for key, value in data.items() if value is not None}
    assert faults("scenario", data) == ({where} if where else set())


@pytest.mark.parametrize("key", ["for", "cooldown", "max_hold"])
def test_times_of_rules_are_quantities_or_names_of_thresholds(faults, key):
    text = (ROOT / "rules" / "avoid_collision.toml").read_text(encoding="utf-8")
    for value, is_valid in {"0.5 s": 1, "20 ms": 1, "patience": 1, 0: 0, "5": 0, "5 m": 0, "2 patience": 0}.items():
        data = tomllib.loads(text)
        name = next(iter(data["rule"]))
        data["rule"][name] |= {key: value}
        assert faults("rules", data) == (set() if is_valid else {f"$.rule.{name}.{key}"})


def test_the_schema_has_texts_defaults_and_units(tmp_path):
    assert call(["show", "--schema", "scenario", "--out", str(tmp_path / "s.json")]) == 0
    key = json.loads((tmp_path / "s.json").read_text(encoding="utf-8"))["else"]["properties"]["duration"]
    assert (key["default"], key["description"]) == ("60 s", "Time limit of the episode [s].")
    assert [bool(re.match(key["pattern"], text)) for text in ("5 s", "5e2ms", "5", "s")] == [True, True, False, False]
