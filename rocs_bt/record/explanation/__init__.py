"""Explanations of a run: why an agent did what it did, what held a rule back, and where two runs differ."""
