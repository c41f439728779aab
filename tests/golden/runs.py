"""Golden runs: the trajectory hash of the shipped scenarios with seeds 1 to 5, and what computed it.

`python -m tests.golden.runs` plays them, prints what changed against `runs.json` and renews the runs of this kind of
machine in that file. The file changes only in commits of their own that say why. If arithmetic was only reordered, the
outcomes stay the same and the times to goal within 0.1 s; the command prints what differs by more. A change of a robot
removes its runs of other kinds of machines.
"""

from __future__ import annotations

import json
import platform
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

import rocs_bt
from rocs_bt.catalog import Catalog
from rocs_bt.compare.key import computing

FILE = Path(__file__).with_name("runs.json")
SEEDS = range(1, 6)
WITHOUT = frozenset({"circle_box", "exp1_mecanum", "exp1_omni", "exp1_ros2", "hall", "pass_person"})
"""Scenarios without golden runs, which tests/experiments plays. `exp1_ros2` is on hardware."""


def machine() -> dict[str, Any]:
    """Versions and machine that the bits of a run depend on; BLAS chooses its code by the processor."""
    versions = {name: version for name, version in computing().items() if name not in ("python", "rocs_bt")}
    simd = np.show_config(mode="dicts")["SIMD Extensions"]
    return {
        **versions,
        "python": ".".join(platform.python_version_tuple()[:2]),
        "system": platform.system(),
        "libc": " ".join(platform.libc_ver()),
        "simd": sorted([*simd["baseline"], *simd["found"]]),
        "processor": _processor(),
    }


def _processor() -> str:
    """Vendor, family and model of the processor; empty if the system does not tell."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text(encoding="utf-8").splitlines() if info.is_file() else []
    found = dict(reversed([[part.strip() for part in line.split(":", 1)] for line in lines if ":" in line]))
    return " ".join(found.get(key, "") for key in ("vendor_id", "cpu family", "model")).strip()


def play(scenario: str, seed: int, catalog: Catalog) -> dict[str, Any]:
    """One run: its trajectory hash, and each agent's outcome and time to goal [s]."""
    summary = rocs_bt.run(scenario, catalog, seed=seed).summary
    return {
        "hash": summary.trajectory_hash,
        "agents": {name: [a.outcome, a.time_to_goal] for name, a in summary.agents.items()},
    }


def shipped(catalog: Catalog) -> list[str]:
    """Names of the shipped scenarios that have golden runs."""
    return [entry.name for entry in catalog.list("scenario") if entry.name not in WITHOUT]


def stored() -> list[dict[str, Any]]:
    """Golden runs of each kind of machine: `machine`, and `runs` by scenario and seed."""
    return list(json.loads(FILE.read_text(encoding="utf-8")))


def of_this_machine(golden: list[dict[str, Any]]) -> dict[str, Any]:
    """Runs of this kind of machine; none if there are none."""
    here = machine()
    return next((dict(each["runs"]) for each in golden if each["machine"] == here), {})


def differences(old: dict[str, Any], new: dict[str, Any]) -> Iterator[str]:
    """More than reordered arithmetic explains: another outcome, or a time to goal more than 0.1 s apart."""
    for run, after in new.items():
        before = old.get(run, {"agents": {}})["agents"]
        for agent, (outcome, time) in after["agents"].items():
            was, then = before.get(agent, (None, None))
            if outcome != was or (time is None) != (then is None) or (time is not None and abs(time - then) > 0.1):
                yield f"{run} {agent}: {was} at {then} s -> {outcome} at {time} s"


def _text(golden: dict[str, Any]) -> str:
    """The runs of one kind of machine as JSON, one run a line."""
    lines = [f"  {json.dumps(run)}: {json.dumps(found)}" for run, found in golden["runs"].items()]
    return f'{{"machine": {json.dumps(golden["machine"])},\n"runs": {{\n' + ",\n".join(lines) + "\n}}"


def main() -> None:
    """Play all golden runs, print what changed and renew the file."""
    catalog = Catalog()
    runs = {f"{name} {seed}": play(name, seed, catalog) for name in shipped(catalog) for seed in SEEDS}
    golden, here = stored(), machine()
    old = of_this_machine(golden)
    changed = [run for run in runs if run not in old or runs[run]["hash"] != old[run]["hash"]]
    golden = [each for each in golden if each["machine"] != here] + [{"machine": here, "runs": runs}]
    FILE.write_text(f"[{', '.join(map(_text, golden))}]\n", encoding="utf-8")
    more = list(differences(old, runs))
    print(f"{len(changed)} of {len(runs)} hashes changed; beyond reordered arithmetic: {len(more)}", *more, sep="\n")


if __name__ == "__main__":
    main()
