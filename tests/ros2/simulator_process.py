"""`rocs-bt sim` as a process."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
from pathlib import Path

PATIENCE = 60.0  # [s] far longer than the start, or the end, of the simulator may take


class SimulatorProcess:
    """A simulator that runs.

    Args:
        options: Options of `rocs-bt sim`, and the scenario.
        environment: Environment of the process.
        folder: Folder in which it runs.

    Attributes:
        process: The process.
        text: What it has printed on stdout; after `end`, all of it.
        errors: What it has printed on stderr; after `end`, all of it.
    """

    def __init__(self, options: tuple[str, ...], environment: dict[str, str], folder: Path) -> None:
        command = [sys.executable, "-m", "rocs_bt", "sim", "--ros2", *options]
        self.process = subprocess.Popen(
            command, env=environment, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        self.text = self.errors = ""
        assert self.process.stdout is not None
        guard = threading.Timer(PATIENCE, self.process.kill)
        guard.start()
        while "Ready." not in self.text:
            line = self.process.stdout.readline()
            assert line, f"the simulator ended: {self.process.communicate()}"
            self.text += line
        guard.cancel()

    def until_said(self, text: str) -> None:
        """Wait until it prints a line with a text on stderr."""
        assert self.process.stderr is not None
        guard = threading.Timer(PATIENCE, self.process.kill)
        guard.start()
        assert any(text in line for line in iter(self.process.stderr.readline, "")), f"it never said {text!r}"
        guard.cancel()

    def end(self, number: int = signal.SIGTERM) -> int:
        """End the process by a signal, and return its exit code."""
        self.process.send_signal(number)
        return self.wait()

    def wait(self) -> int:
        """Wait for the end, and return the exit code."""
        text, self.errors = self.process.communicate(timeout=PATIENCE)
        self.text += text
        return self.process.returncode

    def close(self) -> None:
        """End the process, however it fares."""
        self.process.kill()
        self.process.communicate()
