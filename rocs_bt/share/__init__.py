"""Sharing of knowledge between agents of one process, of several processes, or of several hosts (paper, 4.2)."""
