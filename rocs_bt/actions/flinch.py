"""Flinch: back off from obstacles that are too close."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

from ..base.geometry import Pose2, Twist2
from ..base.units import NOT_NEGATIVE, Metres, MetresPerSecond, PositiveMetres, PositiveSeconds
from ..interfaces.action import AtomicAction, Body, Failure, Progress, Reason
from .known_ground import known_bend, known_speed
from .room import Gaps, bend_off, corner_sweep
from .turn import TurnAngle

STANDING = 0.05  # [m/s] speed below which a robot with neutral wheels counts as stationary
SLOW = 0.15  # [m/s] speed below which backing off counts as failed
CENTRED = 0.04  # [m] difference of the gaps ahead and behind up to which the robot does not creep
BESIDE = 0.15  # [m] minimum gap beside the robot for creeping
TURN = math.radians(60.0)  # [rad] angle of the turn to get out, ...
RATE = 2.5  # [rad/s] ... and its rate
FEELING = 0.2  # [m/s] maximum speed over unknown ground
PUSHED = 0.04  # [m] displacement by a push from which on the robot drives back, ...
BACK = 0.01  # [m] ... until this displacement is left
CERTAIN = 0.01  # [m] `pose_spread` above which a correction of the pose might be mistaken for a push
LOST = 0.3  # [m] displacement after which the robot holds its new position instead
JUMP = 0.6  # [m/s] apparent speed above which the pose has jumped because of a better fix
PULL = 8.0  # [1/s] speed of driving back [m/s] per metre of displacement


@dataclass
class _Course:
    """State of one drive forward or backward, or of one standstill."""

    sign: int  # 1 ahead, -1 back, 0 standstill
    begun: float  # [s]
    start: Pose2 | None = None  # first known pose; in a standstill, the pose to hold
    last: Pose2 | None = None  # in a standstill, the pose one period ago
    blind: float = 0.0  # [m] distance driven without a pose, by the commanded speed
    pushed: bool = False  # whether the robot drives back to `start`


class Flinch(AtomicAction):
    """Back off: drive ahead or back for a distance, or hold the position.

    The robot drives straight, or with the curvature of the signal `bend_off` if the robot has it. The distance is
    measured with the pose; while the pose is lost, with the commanded speed, because a reflex must not wait.

    It drives only over ground that it has seen to be free or has driven over, and slows down before other ground. If
    there is none in its direction, the action fails as BLOCKED; with `get_out`, the robot holds its position and turns.

    A robot with a speed of zero holds its position. Locked wheels slide when another robot pushes, so with `resist` the
    robot drives back once it was pushed 0.04 m ahead or back, until it is back in position or was pushed 0.3 m away.
    Pushes from the side and jumps of the pose are not resisted, nor is any push while pose or speed is not known or
    `pose_spread` exceeds 0.01 m.

    With `get_out` the action reads the groups `front`, `left_gap`, `right_gap` and `rear`. Between two obstacles, one
    close ahead and one close behind, the robot holds its position. If it is still slow after `timeout`, backing off
    does not help: it turns 60 deg on the spot toward the freer side and drives ahead, if the corners of its hull have
    room; otherwise, between two obstacles, it creeps to the middle. Robots with the signal `bend_off` have too few
    beams for this and for `resist`.

    An `update` that switches between ahead, back and standstill restarts distance and time limit.

    Attributes:
        speed: Speed, negative backward, 0 to hold the position [m/s].
        distance: Distance to drive [m].
        timeout: Time limit of each drive, after which the action fails or gets out; a standstill has none [s].
        get_out: Whether to stop between two obstacles, and to turn out if backing off does not help.
        boxed: Gap ahead and behind below which the robot is between two obstacles [m].
        clearance: Margin beside the area that the corners sweep in a turn; not needed on the side of the turn [m].
        creep: Speed of creeping to the middle, 0 for never [m/s].
        unknown: Distance that the robot may drive over unknown ground, at 0.2 m/s at most [m].
        resist: Maximum speed of driving back to the held position, 0 for never [m/s].
    """

    speed: MetresPerSecond
    distance: PositiveMetres = 0.08
    timeout: PositiveSeconds = 1.5
    get_out: bool = False
    boxed: Annotated[Metres, NOT_NEGATIVE] = 0.25
    clearance: Annotated[Metres, NOT_NEGATIVE] = 0.03
    creep: Annotated[MetresPerSecond, NOT_NEGATIVE] = 0.1
    unknown: Annotated[Metres, NOT_NEGATIVE] = 0.0
    resist: Annotated[MetresPerSecond, NOT_NEGATIVE] = 0.3
    _begun: float = math.inf
    _course: _Course | None = None
    _turn: TurnAngle | None = None
    _out: bool = False
    _crept: float = 0.0

    def act(self, body: Body) -> Progress | Failure:
        if not self.get_out:
            return self._drive_off(body, self.speed)
        now, gaps = body.clock.now(), Gaps.known(body)
        self._begun = min(self._begun, now)
        boxed = max(gaps.front, gaps.rear) < self.boxed
        in_vain = now - self._begun > self.timeout - 0.5 * body.period and _slow(body) and _has_beams_all_round(body)
        if in_vain and (turn := self._turn_out(body, gaps)) is not None:
            done = turn.act(body)
            if done is not Progress.SUCCEEDED:
                return done
            self._out = True
        if self._turn is not None:  # done, or no more room
            self._turn, self._course, self._begun = None, None, now
        if not boxed:
            return self._drive_off(body, abs(self.speed) if self._out else self.speed)
        off_centre = gaps.front - gaps.rear
        creeps = in_vain and abs(off_centre) > CENTRED and min(gaps.left, gaps.right) > BESIDE
        return self._drive_off(body, math.copysign(self.creep, off_centre) if creeps else 0.0)

    def _turn_out(self, body: Body, gaps: Gaps) -> TurnAngle | None:
        """Action that turns on the spot toward the freer side; None if the corners of the hull have no room."""
        sweep, ends = corner_sweep(body), min(gaps.front, gaps.rear)
        room = {1: min(ends, gaps.right) - sweep, -1: min(ends, gaps.left) - sweep}
        beside = {1: gaps.left, -1: gaps.right}
        free = [side for side in (1, -1) if room[side] > self.clearance and beside[side] > sweep]
        if self._turn is None and free:
            side = max(free, key=lambda side: beside[side])
            self._turn = TurnAngle(angle=side * TURN, rate=RATE, tolerance=0.1 * TURN)
        return self._turn if self._turn is not None and math.copysign(1, self._turn.angle) in free else None

    def _drive_off(self, body: Body, speed: float) -> Progress | Failure:
        """Drive forward or backward for the distance; with a speed of 0, hold the position."""
        bend = known_bend(body, speed, bend_off(body, speed))
        known = known_speed(body, speed, bend)
        if speed and not known and self._crept < self.unknown:
            known = math.copysign(min(FEELING, abs(speed)), speed)
            self._crept += abs(known) * body.period
        if speed and not known and not self.get_out:
            way = "ahead" if speed > 0.0 else "behind"
            allowed = f"the parameter 'unknown' allows {self.unknown:g} m of such ground"
            where = f"the ground {way}, to which its speed of {speed:.2g} m/s leads"
            return Failure(Reason.BLOCKED, f"{where}, is neither seen to be free nor driven; {allowed}")
        speed = known
        now, sign = body.clock.now(), (speed > 0.0) - (speed < 0.0)
        if self._course is None or self._course.sign != sign:
            self._course = _Course(sign, now)
        if sign == 0:
            _drive(body, self._back(body, self._course))
            return Progress.RUNNING
        gained = self._gained(body, self._course, speed)
        if gained >= self.distance:
            return Progress.SUCCEEDED
        if now - self._course.begun > self.timeout - 0.5 * body.period:
            return Failure(Reason.TIMEOUT, f"gained {gained:.2f} m of {self.distance:.2f} m in {self.timeout:.1f} s")
        _drive(body, speed, bend)
        return Progress.RUNNING

    def _gained(self, body: Body, course: _Course, speed: float) -> float:
        """Distance that the robot has driven since the start of the course [m]."""
        pose = _pose(body)
        if pose is None:
            course.blind += abs(speed) * body.period
            return course.blind
        course.start = course.start or pose
        return course.sign * _ahead(course.start, pose)

    def _back(self, body: Body, course: _Course) -> float:
        """Speed at which the robot drives back to the position to hold [m/s]; 0 if it was not pushed."""
        pose, last, speed = _pose(body), course.last, body.knowledge.robot.speed(body.clock.now())
        course.last = pose
        if pose is None or last is None or pose.distance(last) > JUMP * body.period or math.isnan(speed):
            course.start = None
        if pose is None or course.start is None or pose.distance(course.start) > LOST:
            course.start, course.pushed = pose if abs(speed) < STANDING else None, False
            return 0.0
        off = _ahead(pose, course.start)
        resist = self.resist if _certain(body) and _has_beams_all_round(body) else 0.0
        course.pushed = resist > 0.0 and abs(off) > (BACK if course.pushed else PUSHED)
        return math.copysign(min(PULL * abs(off), resist), off) if course.pushed else 0.0


def _has_beams_all_round(body: Body) -> bool:
    """Whether the robot has range sensors on all sides; a robot without them has the signal `bend_off` instead."""
    return "bend_off" not in body.knowledge.signals


def _certain(body: Body) -> bool:
    """Whether a displacement of the pose can be taken for a push.

    A pose estimator also displaces the pose when it corrects its estimate. Its signal `pose_spread` must therefore be
    below `CERTAIN`; a robot without this signal measures its pose.
    """
    signals = body.knowledge.signals
    return "pose_spread" not in signals or signals.value("pose_spread", body.clock.now()) < CERTAIN


def _slow(body: Body) -> bool:
    """Whether the robot hardly moves."""
    return abs(body.knowledge.robot.speed(body.clock.now())) < SLOW


def _pose(body: Body) -> Pose2 | None:
    """Pose of the robot; None while it is lost."""
    pose = body.knowledge.robot.pose(body.clock.now())
    return pose if all(map(math.isfinite, pose)) else None


def _ahead(pose: Pose2, place: Pose2) -> float:
    """Distance from a pose to a position, along the pose's heading [m]; negative if the position is behind."""
    return pose.distance(place) * math.cos(pose.bearing(place))


def _drive(body: Body, speed: float, bend: float = 0.0) -> None:
    twist = Twist2(speed, speed * bend)
    body.move(twist)
