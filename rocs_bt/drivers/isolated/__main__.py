"""Entry point of an isolated actuator's process: `python -m rocs_bt.drivers.isolated DESCRIPTOR`."""

import sys

from .process import run_process

if __name__ == "__main__":
    run_process(int(sys.argv[1]))
