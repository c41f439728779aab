"""What does not fit `_numbers.c` is refused, and never read or written beyond its end."""

import struct

import numpy as np
import pytest

import rocs_bt.knowledge.signals as signals
import rocs_bt.record.container as container
from rocs_bt.compiled import PLAIN
from rocs_bt.geometry import Pose2, Twist2


@pytest.mark.usefixtures("kernel")
@pytest.mark.parametrize(
    "values", [[[1.0], (2.0,)], [[1.0], ["two"]], [[1.0], [None]], [[1.0], 2.0], [[1.0], [2.0, 3.0]]]
)
def test_signals_that_need_a_closer_look(values):
    for filling in (signals.fill, PLAIN["fill"]):
        target, bounds = np.zeros(2), np.array([[-9.0, 9.0, 0.0, 2.0]])
        assert filling(target, np.zeros(2), 2.5, values, (1, 1), bounds) is None
        assert not target.any()


@pytest.mark.usefixtures("kernel")
def test_what_does_not_fit_is_refused():
    from rocs_bt import _numbers

    ground, frame, spots, way = np.zeros((3, 3)), (0.0, 0.0, 1.0, 0.0), np.zeros((4, 2)), np.zeros((4, 3))
    read_only = np.zeros((3, 3))
    read_only.flags.writeable = False
    bounds = np.array([[0.0, 1.0, 0.0, 1.0]])
    wrong = [
        (_numbers.fill, (np.zeros(1), np.zeros(2), 1.0, [[0.5]], (1,), bounds)),
        (_numbers.fill, (np.zeros(1), np.zeros(1), 1.0, [[0.5]], [1], bounds)),
        (_numbers.fill, (np.zeros(1), np.zeros(1), 1.0, 0.5, (1,), bounds)),
        (_numbers.fill, (np.zeros(1), np.zeros(1), 1.0, [[0.5]], (1,), bounds[:, :3])),
        (_numbers.along_at, ([(0.0,) * 6], np.zeros((2, 4)), np.zeros((2, 4, 3)))),
        (_numbers.along_at, ([(0.0,) * 6], np.zeros((1, 4)), np.zeros((1, 5, 3)))),
        (_numbers.along_at, ([(0.0,) * 5], np.zeros((1, 4)), np.zeros((1, 4, 3)))),
        (_numbers.arc_positions, ((0.0, 0.0), (1.0, 0.0, 0.0), [0.1])),
        (_numbers.arc_positions, (Pose2(0.0, 0.0), Twist2(1.0), ["soon"])),
        (_numbers.arc_positions, (Pose2(0.0, 0.0), Twist2(1.0))),
        (_numbers.hull_gaps, ([Pose2(0.0, 0.0)], [], (0.1, 0.1), 0.1)),
        (_numbers.mark_at, (ground, frame, np.zeros((4, 3)), 0.0)),
        (_numbers.mark_at, (ground, frame, np.zeros((4, 2), dtype=np.float32), 0.0)),
        (_numbers.mark_at, (np.zeros((3, 4)), frame, spots, 0.0)),
        (_numbers.mark_at, (read_only, frame, spots, 0.0)),
        (_numbers.strides_at, (ground, frame, spots, 0.0)),
        (_numbers.strides_at, (ground, frame, np.zeros((4, 1, 1, 3)), 0.0)),
        (_numbers.strides_at, (ground, frame[:3], spots[:, None, None], 0.0)),
        (_numbers.within, (np.zeros((1,) * 9), 0.0)),
        (_numbers.pull, (way, Pose2(0.0, 0.0), way[:3], [], [0.0], (1.0, 0.1, 0.5, 0.3))),
        (_numbers.pull, (way, Pose2(0.0, 0.0), way, [way[:2]], [0.0], (1.0, 0.1, 0.5, 0.3))),
        (_numbers.pull, (way, Pose2(0.0, 0.0), way, [], [0.0] * 65, (1.0, 0.1, 0.5, 0.3))),
        (_numbers.chunked, ([(0, 1, 2, "data")], 0, {0: []})),
        (_numbers.chunked, ([(0, 1, 2)], 0, {0: []})),
        (_numbers.chunked, ((), 0, {})),
        (_numbers.turn_on, (np.zeros(5), 0.1, 0.9, np.zeros(4), np.zeros((5, 5)))),
        (_numbers.turn_on, (np.zeros(5), 0.1, 0.9, np.zeros(5), np.zeros((4, 5)))),
        (_numbers.sight, (np.zeros(5), (0.0,) * 3, 1.0, 0.1, np.zeros((1, 5)), np.zeros(2))),
        (_numbers.sight, (np.zeros(5), (0.0,) * 2, 1.0, 0.1, np.zeros((2, 5)), np.zeros(2))),
        (_numbers.sight, (np.zeros(5), (0.0,) * 3, "far", 0.1, np.zeros((2, 5)), np.zeros(2))),
        (_numbers.inverse, (np.zeros((1, 2)), np.zeros((2, 2)))),
        (_numbers.inverse, (np.zeros((2, 2)), read_only[:2, :2])),
        (_numbers.stations_at, ([spots[:, 0].copy()] * 3, (0.0,) * 4, np.zeros(2), np.zeros(2))),
        (_numbers.stations_at, ((np.zeros(2), np.zeros(2), np.zeros(3)), (0.0,) * 4, np.zeros(2), np.zeros(2))),
        (_numbers.stations_at, ((np.zeros(0),) * 3, (0.0,) * 4, np.zeros(2), np.zeros(2))),
        (_numbers.stations_at, ((np.zeros(2),) * 3, (0.0,) * 3, np.zeros(2), np.zeros(2))),
        (_numbers.stations_at, ((np.zeros(2),) * 3, (0.0,) * 4, np.zeros(2), np.zeros(3))),
        (_numbers.path_stages, (np.zeros((2, 5)), (0.0,) * 3, np.zeros(2), np.zeros((3, 6)))),
        (_numbers.path_stages, (np.zeros((3, 5)), (0.0,) * 3, np.zeros(2), np.zeros((2, 6)))),
        (_numbers.path_stages, (np.zeros((2, 4)), (0.0,) * 3, np.zeros(2), np.zeros((2, 6)))),
        (_numbers.bent_at, (Pose2(0.0, 0.0), np.zeros((2, 5)), np.zeros((2, 1)), np.zeros((3, 2, 4)))),
        (_numbers.bent_at, (Pose2(0.0, 0.0), np.zeros((2, 5)), np.zeros((1, 1)), np.zeros((3, 2, 5)))),
        (_numbers.bent_at, (Pose2(0.0, 0.0), np.zeros((2, 5)), np.zeros((2, 1)), np.zeros((3, 1, 5)))),
        (_numbers.bent_at, (Pose2(0.0, 0.0), np.zeros((2, 5)), np.zeros((2, 1)), np.zeros((2, 2, 5)))),
        (_numbers.turned_at, (Pose2(0.0, 0.0), [way[:, 0].copy()] * 3, (1.0,) * 4, np.zeros(5), np.zeros((3, 4, 5)))),
        (_numbers.turned_at, (Pose2(0.0, 0.0), (np.zeros(4),) * 3, (1.0,) * 4, np.zeros(5), np.zeros((3, 3, 5)))),
        (_numbers.turned_at, (Pose2(0.0, 0.0), (np.zeros(4),) * 3, (1.0,) * 4, np.zeros(5), np.zeros((3, 4, 6)))),
        (
            _numbers.turned_at,
            (Pose2(0.0, 0.0), (np.zeros(4), np.zeros(3), np.zeros(4)), (1.0,) * 4, np.zeros(5), np.zeros((3, 4, 5))),
        ),
        (_numbers.least_apart, (way, way[:3], (0.1, 0.1))),
        (_numbers.least_apart, (way[:0], way[:0], (0.1, 0.1))),
        (_numbers.costs_at, (np.zeros((3, 2, 4)), way, [], (0.1, 0.1), (1.0,) * 5, 5, np.zeros(2))),
        (_numbers.costs_at, (np.zeros((3, 2, 4)), way, [], (0.1, 0.1), (1.0,) * 5, 0, np.zeros(2))),
        (_numbers.costs_at, (np.zeros((3, 2, 4)), way[:3], [], (0.1, 0.1), (1.0,) * 5, 4, np.zeros(2))),
        (_numbers.costs_at, (np.zeros((3, 2, 4)), way, [way[:3]], (0.1, 0.1), (1.0,) * 5, 4, np.zeros(2))),
        (_numbers.costs_at, (np.zeros((3, 2, 4)), way, [None], (0.1, 0.1), (1.0,) * 5, 4, np.zeros(2))),
        (_numbers.costs_at, (np.zeros((3, 2, 4)), way, None, (0.1, 0.1), (1.0,) * 5, 4, np.zeros(2))),
        (_numbers.costs_at, (np.zeros((3, 2, 4)), way, [], (0.1, 0.1), (1.0,) * 4, 4, np.zeros(2))),
        (_numbers.costs_at, (np.zeros((3, 2, 4)), way, [], (0.1, 0.1), (1.0,) * 5, 4, np.zeros(3))),
        (_numbers.costs_at, (np.zeros((2, 2, 4)), way, [], (0.1, 0.1), (1.0,) * 5, 4, np.zeros(2))),
        (_numbers.pull, (way, Pose2(0.0, 0.0), way, [None], [0.0], (1.0, 0.1, 0.5, 0.3))),
    ]
    for function, given_ones in wrong:
        with pytest.raises((TypeError, ValueError, BufferError)):
            function(*given_ones)


@pytest.mark.usefixtures("kernel")
@pytest.mark.parametrize("message", [(-1, 0, 0), (2**16, 0, 0), (0, -1, 0), (0, 2**32, 0), (0, 0, -1), (0, 0, 2**64)])
def test_numbers_that_are_too_large_for_a_message_are_refused(message):
    index = {message[0]: []}
    with pytest.raises(OverflowError):
        container.chunked([(*message, b"")], 0, index)
    with pytest.raises(struct.error):
        PLAIN["chunked"]([(*message, b"")], 0, index)
