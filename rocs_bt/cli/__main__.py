"""`python -m rocs_bt.cli` is `rocs-bt`."""

from .main import main

main()
