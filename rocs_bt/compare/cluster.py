"""A Dask cluster as an executor, for sweeps that are too long for one machine (the extra `cluster`)."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager

from ..errors import InputError

_PATIENCE = 5.0
"""How long a scheduler may take to answer [s]."""


@contextmanager
def dask_executor(address: str) -> Iterator[Executor]:
    """The workers of a running Dask scheduler, until the block ends.

    Its workers need this package in the same version, and the project's files at the same place. Give each one thread:
    a process plays one episode at a time.

    Args:
        address: The scheduler's, such as `tcp://10.0.0.1:8786`; or the file that it writes.

    Raises:
        InputError: Dask is not installed, or no scheduler answers there.
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
