"""Episodes that nobody played, with whatever endings a test wants."""

from __future__ import annotations

import numpy as np

from rocs_bt.compare.record import EpisodeRecord

LIMIT = 60.0


def episode(planner, scene, seed=1, outcome="success", time=20.0, **metrics):
    """A record; a failure takes all the time, a collision a quarter of it."""
    success = outcome == "success"
    ended = time if success else LIMIT / 4 if outcome == "collision" else LIMIT
    x = np.linspace(0.0, 3.0 if success else 1.5, 20)
    track = np.stack([x, 0.4 * np.sin(2.0 * x + seed + len(planner))], axis=1).astype(np.float32)
    return EpisodeRecord(
        key=f"{planner}/{scene}/{seed}",
        planner=planner,
        family=scene.rpartition("-")[0],
        scene=scene,
        seed=seed,
        outcome=outcome,
        reason="" if success else f"it came to {outcome}",
        metrics={
            "success": float(success),
            "collision": float(outcome == "collision"),
            "time": time if success else LIMIT,
            "path_length": 3.0 + 0.01 * seed,
            **metrics,
        },
        sim_time=ended,
        time_limit=LIMIT,
        difficulty={"density": 0.1 + 0.01 * int(scene.rpartition("-")[2])},
        track=track.tobytes(),
    )


def table(planner, endings, seeds=1, family="field", **metrics):
    """Records from a text of endings, a letter an episode: success, collision, failed, k (stuck), timeout, error."""
    words = {"s": "success", "c": "collision", "f": "failed", "k": "stuck", "t": "timeout", "e": "error"}
    return [
        episode(planner, f"{family}-{i // seeds}", 1 + i % seeds, words[letter], **metrics)
        for i, letter in enumerate(endings.replace(" ", ""))
    ]
