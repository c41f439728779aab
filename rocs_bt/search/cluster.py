"""Dask cluster as an executor, for sweeps too large for one machine (extra `cluster`)."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager

from ..base.errors import InputError

_PATIENCE = 5.0
"""Timeout of the connection to the scheduler [s]."""


@contextmanager
def dask_executor(address: str) -> Iterator[Executor]:
    """Executor over the workers of a running Dask scheduler, valid inside the block.

    The workers need the same version of this package, and the project's files at the same path. Start them with one
    thread each, because a process plays only one episode at a time.

    Args:
        address: Scheduler address, such as `tcp://10.0.0.1:8786`, or its scheduler file (`.json`).

    Raises:
        InputError: Dask is not installed, or no scheduler answers.
    """
    try:
        from distributed import Client
    except ImportError as error:
        raise InputError("a Dask cluster needs the extra 'cluster': pip install 'rocs_bt[cluster]'.") from error
    try:
        where = {"scheduler_file": address} if address.endswith(".json") else {"address": address}
        client = Client(**where, timeout=_PATIENCE)
    except (OSError, ValueError) as error:
        raise InputError(f"no Dask scheduler answers at '{address}': {error}. Start one: dask scheduler.") from error
    with client:
        yield client.get_executor(pure=False)
