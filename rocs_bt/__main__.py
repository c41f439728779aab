"""Runs `rocs-bt` by `python -m rocs_bt`."""

import sys
from pathlib import Path

if not sys.flags.safe_path:  # `python -m` has put the current folder first
    here = sys.path.pop(0)
    if Path(here) == Path(__file__).parents[1]:  # a checkout that is not installed
        sys.path.append(here)

from .cli.main import main

main()
