"""`rocs-bt compare --cold`: what it prints, and what it refuses before anything is played."""

from __future__ import annotations

import json

SHORT = 'format = "scenario/2"\nbase = "exp1"\nduration = "0.5 s"\n'


def test_a_cold_comparison_prints_stores_and_exports_its_losses(rocs_bt, tmp_path):
    (tmp_path / "scenarios").mkdir()
    (tmp_path / "scenarios" / "brief.toml").write_text(SHORT)
    ask = ["compare", "tree", "--scenario", "brief", "--seeds", 2, "--metric", "success", "--jobs", 1]
    told = rocs_bt(*ask, "--cold", "--markdown", "a.md", "--report", "a.html")
    assert told.code == 0, told.err
    assert "14 played now" in told.out
    assert "friction=0.3" in told.out
    assert "not played: tree: the perturbation 'noise' has no effect on 'pioneer_p3dx'" in told.err
    for name in ("a.md", "a.html"):
        assert "wheel_radius=0.05" in (tmp_path / name).read_text()
    again = rocs_bt(*ask, "--perturb", "body", "--perturb", "delay=0.3 s", "--outward", "--json")
    found = json.loads(again.out)
    names = [each["perturbation"] for each in found["cold"]]
    assert names == ["body=0.1", "delay=0.3", "all"]
    assert [each["reason"] for each in found["outward"]] == ["it never succeeds without the perturbation"] * 2
    hashes = {each["planner"]: each["trajectory_hash"] for each in found["results"] if each["seed"] == 1}
    assert len(set(hashes.values())) == 3
    assert "cold" not in json.loads(rocs_bt(*ask, "--json").out)
