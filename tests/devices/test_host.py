"""Host: the objects that drivers share."""

from __future__ import annotations

import pytest

from rocs_bt.base.clock import WallClock
from rocs_bt.devices.host import Host


class Line:
    def __init__(self, closed, name, error=None):
        self.closed, self.name, self.error = closed, name, error

    def close(self):
        self.closed.append(self.name)
        if self.error is not None:
            raise self.error


def test_all_shared_objects_are_closed_whatever_one_of_them_raises():
    host, closed = Host(WallClock()), []
    for name, error in (("a", OSError("the first")), ("b", RuntimeError("the second")), ("c", None)):
        host.share(name, lambda name=name, error=error: Line(closed, name, error))
    with pytest.raises(OSError, match="the first"):
        host.close()
    assert closed == ["a", "b", "c"]
