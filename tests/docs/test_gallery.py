"""docs/gallery.md: thirteen pictures, each with its scenario, seed and commands; one is made again."""

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

DOCS = Path(__file__).resolve().parents[2] / "docs"


@pytest.fixture(scope="module")
def gallery():
    spec = importlib.util.spec_from_file_location("manual_gallery", DOCS / "gallery.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def test_the_page_shows_thirteen_small_pictures(gallery):
    shown = {f"{p.name}.{p.form}" for p in gallery.pictures()}
    assert len(shown) == 13
    assert shown == {p.name for p in (DOCS / "gallery").iterdir()}
    assert gallery.PAGE.read_text("utf-8").count("](gallery/") == 13
    assert max(p.stat().st_size for p in (DOCS / "gallery").iterdir()) <= 60_000


def test_captions_name_scenario_and_seed_of_the_commands(gallery):
    for picture in gallery.pictures():
        scenario = picture.caption.split("`")[1]
        assert scenario.partition("-")[0] in " ".join(picture.commands), picture.name
        assert "seed" in picture.caption, picture.name
        assert all(command.startswith("$ rocs-bt ") for command in picture.commands), picture.name


def test_a_picture_is_made_again(gallery, tmp_path):
    (picture,) = (p for p in gallery.pictures() if p.name == "exp1-activation")
    made = Image.open(gallery.make(picture, tmp_path / "work", tmp_path / "gallery")).convert("L")
    kept = Image.open(DOCS / "gallery" / "exp1-activation.png").convert("L")
    assert made.size == kept.size
    apart = np.abs(np.asarray(made, float) - np.asarray(kept, float)) > 32.0
    assert apart.mean() < 0.01  # versions of the font library draw text a little differently
