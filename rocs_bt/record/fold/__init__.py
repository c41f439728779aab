"""What held at any time of a run, folded once from its events: tracks, samples, arrays."""
