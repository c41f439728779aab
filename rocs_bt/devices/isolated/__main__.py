"""Entry point of the process of an isolated actuator: `python -m rocs_bt.devices.isolated DESCRIPTOR`."""

import sys

from .process import run_process

if __name__ == "__main__":
    run_process(int(sys.argv[1]))
