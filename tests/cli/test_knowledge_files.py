"""`rocs-bt run --knowledge` and `rocs-bt knowledge show|export|import`, through the front door."""

from __future__ import annotations

import json

import pytest


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A short run of exp1."""
    from rocs_bt import run
    from rocs_bt.catalog import Catalog

    out = tmp_path_factory.mktemp("finished")
    run("exp1", Catalog(), out=out, duration=2.0, report=False)
    return out


def test_a_run_tells_what_it_remembered_and_where_it_keeps_it(rocs_bt, tmp_path):
    for expected in ("Knowledge: k.json", "R2 loaded 0 nodes and 0 relations of earlier runs."):
        told = rocs_bt("run", "exp1", "--for", "0.2", "--no-report", "--out", tmp_path / "r", "--knowledge", "k.json")
        assert told.code == 1
        assert expected in told.out


def test_show_draws_a_page_a_picture_and_a_list(rocs_bt, finished, tmp_path):
    told = rocs_bt("knowledge", "show", finished)
    assert (told.code, told.out) == (0, f"Knowledge of R2: {finished / 'knowledge.html'}\n")
    assert "Knowledge of R2" in (finished / "knowledge.html").read_text()
    told = rocs_bt("knowledge", "show", finished / "run.mcap", "--format", "svg", "--at", "1", "--out", "a.svg")
    assert told.code == 0
    assert (tmp_path / "a.svg").read_text().startswith("<svg")
    told = rocs_bt("knowledge", "show", finished, "--format", "text", "--at", "0")
    assert "R2 pursues goal\n" in told.out
    assert "goal goal: pose (0, 0, 0), tolerance 0.1\n" in told.out


def test_export_import_export_is_the_same_to_the_byte(rocs_bt, finished, tmp_path):
    first = rocs_bt("knowledge", "export", finished, "--at", "1.5")
    assert first.code == 0
    (tmp_path / "a.json").write_text(first.out)
    assert rocs_bt("knowledge", "export", "a.json").out == first.out
    assert rocs_bt("knowledge", "import", "a.json", "k.json").code == 0
    assert (tmp_path / "k.json").read_text() == first.out
    told = rocs_bt("knowledge", "import", "a.json", "k.json", "--agent", "R9")
    assert told.code == 0
    assert "of R9" in told.out
    assert [agent["agent"] for agent in json.loads((tmp_path / "k.json").read_text())["agents"]] == ["R2", "R9"]
    assert rocs_bt("knowledge", "export", "k.json", "--agent", "R2").out == first.out
    assert "contains the knowledge of R2, R9" in rocs_bt("knowledge", "export", "k.json").err
    assert "'R7'" in rocs_bt("knowledge", "export", "k.json", "--agent", "R7").err


def test_what_cannot_be_read_is_told(rocs_bt, finished, tmp_path):
    (tmp_path / "bad.json").write_text('{"format": "knowledge/1",\n"nodes": [{"name": 3}]}')
    (tmp_path / "odd.json").write_bytes(b"\xff\xfe\x00")
    for arguments, expected in (
        (("import", "bad.json", "k.json"), "there is no 'agents'"),
        (("import", "odd.json", "k.json"), "not UTF-8 text"),
        (("import", "none.json", "k.json"), "none.json"),
        (("show", "nowhere"), "there is no knowledge 'nowhere'"),
        (("show", finished, "--agent", "R7"), "R2"),
        (("show", tmp_path), "no recording is named"),
        (("export", finished, "--at", "-3"), "-3"),
        (("query", finished, "place", "--at", "nan"), "found 'nan'"),
    ):
        told = rocs_bt("knowledge", *arguments)
        assert told.code == 2, told
        assert expected in told.err
    assert not (tmp_path / "k.json").exists()
