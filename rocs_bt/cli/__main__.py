"""Runs `rocs-bt` by `python -m rocs_bt.cli`."""

from .main import main

main()
