"""Watching trees: the logs that other tools replay."""

from .btlog import STATUSES, BtLog

__all__ = ["STATUSES", "BtLog"]
