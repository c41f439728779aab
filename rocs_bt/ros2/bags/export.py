"""Export of a recording as a rosbag2 folder, for `ros2 bag`, rviz, PlotJuggler and Foxglove."""

from __future__ import annotations

import errno
import math
import sqlite3
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

from ...base.errors import Fault, InputError, RecordingError, UnknownName
from ...base.files import new_folder
from ...catalog import Catalog, RobotSpec
from ...event import Event
from ...record import Recording, RunHeader
from ..messages.type_store import TypeStore, import_rosbags
from .messages import Published
from .topics import RecordedTopics

STORAGES = ("mcap", "sqlite3")
"""Storage formats of rosbag2."""

MAX_GAP = 600.0
"""Maximum time between two events of a recording that is not damaged [s]."""

_DISTRO = "jazzy"
_VERSION = 9  # of rosbag2's format: that of Jazzy and Kilted
_LATEST = 2**31 - 1  # maximum of the field `sec` of time stamps [s]


@dataclass(frozen=True)
class ExportedBag:
    """Bag that was written.

    Attributes:
        folder: Folder of the bag.
        topics: Message type and number of messages by topic, ordered by name.
        duration: Time from the first to the last message [s].
        unknown_robots: Names of robots that the catalog does not have, so that topics which need their drivers or
            their locomotion are missing.
    """

    folder: Path
    topics: Mapping[str, tuple[str, int]]
    duration: float
    unknown_robots: tuple[str, ...] = ()


def export_rosbag(
    recording: Recording,
    folder: Path,
    catalog: Catalog | None = None,
    *,
    storage: str = "mcap",
    start: float = 0.0,
) -> ExportedBag:
    """Write a recording as a rosbag2 folder. Equal recordings give equal bytes.

    Args:
        recording: The recording; a truncated one is exported up to its end.
        folder: Folder of the bag, which must not exist.
        catalog: Source of the robots; the project around the current folder by default.
        storage: `mcap` or `sqlite3`.
        start: Time of the bag at the start of the run [s since 1970].

    Raises:
        InputError: The folder exists, the time is out of range, or the package rosbags is not installed.
        RecordingError: The recording is damaged.
        OSError: The bag cannot be written.
    """
    rosbag2 = import_rosbags("rosbags.rosbag2")
    if folder.exists():
        raise InputError(Fault(f"'{folder}' exists.", hint="Choose another folder for the bag, or remove this one."))
    if not 0.0 <= start <= _LATEST:
        raise InputError(Fault(f"the start time must be 0 to {_LATEST} seconds since 1970, found {start:.12g} s."))
    types = TypeStore(_DISTRO)
    robots, unknown_robots = _robots(recording.header, catalog or Catalog.here())
    joints = {name: _joints(robot) for name, robot in robots.items()}
    topics = RecordedTopics(recording.header, robots, joints, start)
    writer = rosbag2.Writer(folder, version=_VERSION, storage_plugin=rosbag2.StoragePlugin[storage.upper()])
    with _written(folder), new_folder(folder), writer:
        writer.set_custom_data("rocs_bt", recording.header.label)
        _write(writer, topics.published(_plausible(recording, _LATEST - start)), types)
    found = {c.topic: (c.msgtype, writer.counts[c.id]) for c in writer.connections}
    duration = max(0, writer.max_timestamp - writer.min_timestamp) * 1e-9
    return ExportedBag(folder, dict(sorted(found.items())), duration, unknown_robots)


@contextmanager
def _written(folder: Path) -> Iterator[None]:
    """Context that names the bag in errors of writing, which SQLite and MCAP raise without a file."""
    try:
        yield
    except sqlite3.Error as error:
        raise OSError(errno.EIO, str(error), str(folder)) from error
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(folder)) from error


def start_time(text: str) -> float:
    """Read a time of day or a number of seconds.

    Args:
        text: Seconds since 1970, or a date and time as in ISO 8601, such as `2026-11-20T10:00:00+01:00`; without an
            offset, local time.

    Returns:
        Time [s since 1970].

    Raises:
        InputError: The text is no time.
    """
    with suppress(ValueError):
        if math.isfinite(seconds := float(text)):
            return seconds
    try:
        return datetime.fromisoformat(text).timestamp()
    except (ValueError, OverflowError, OSError) as error:
        hint = "Write seconds since 1970, or a date and time as in '2026-11-20T10:00:00+01:00'."
        raise InputError(Fault(f"'{text}' is no time.", hint=hint)) from error


def _robots(header: RunHeader, catalog: Catalog) -> tuple[dict[str, RobotSpec], tuple[str, ...]]:
    """Robots by agent, and the names of those that the catalog does not have."""
    found, missing = {}, []
    for agent in header.agents:
        try:
            found[agent.name] = catalog.load_robot(agent.robot)
        except UnknownName:  # the robot belongs to another project
            missing.append(agent.robot)
    return found, tuple(dict.fromkeys(missing))


def _joints(robot: RobotSpec) -> Mapping[str, str]:
    """Joints by motor, from the robot's model."""
    if robot.model is None:
        return {}
    from ...devices.mujoco.compose import read_model

    try:
        model = read_model(robot.model)
    except InputError:  # a faulty model is no reason to refuse a recording
        return {}
    return {motor.name: motor.target for motor in model.actuators}


def _plausible(recording: Recording, end: float) -> Iterator[Event]:
    """Events of a recording, of which each is at a plausible time: a bag has a message for each period.

    Args:
        recording: The recording.
        end: Maximum time of an event [s].

    Raises:
        RecordingError: A time is negative, no number, or far after that of the event before; or a time stamp of ROS
            cannot hold it.
    """
    last = recording.header.start
    for event in recording.events():
        if not 0.0 <= event.t <= last + MAX_GAP:
            raise RecordingError(f"the recording is damaged: an event at {event.t:g} s follows one at {last:g} s.")
        if event.t > end:
            raise RecordingError(f"a time stamp of ROS cannot hold the event at {event.t:g} s. Use an earlier --start.")
        last = max(last, event.t)
        yield event


def _write(writer: Any, published: Iterable[Published], types: TypeStore) -> None:
    connections: dict[tuple[str, str], Any] = {}
    for topic, t, kind, fields, latched in published:
        if (topic, kind) not in connections:
            profiles = [_profile(latched)]
            connections[topic, kind] = writer.add_connection(
                topic, kind, typestore=types.store, offered_qos_profiles=profiles
            )
        writer.write(connections[topic, kind], round(t * 1e9), types.serialize(types.make(kind, **fields)))


def _profile(latched: bool) -> Any:
    """Quality of service with which `ros2 bag play` publishes a topic."""
    interfaces = import_rosbags("rosbags.interfaces")
    forever = interfaces.QosTime(9223372036, 854775807)  # infinite, as rmw has it
    durability = interfaces.QosDurability.TRANSIENT_LOCAL if latched else interfaces.QosDurability.VOLATILE
    return interfaces.Qos(
        history=interfaces.QosHistory.KEEP_LAST,
        depth=1 if latched else 10,
        reliability=interfaces.QosReliability.RELIABLE,
        durability=durability,
        deadline=forever,
        lifespan=forever,
        liveliness=interfaces.QosLiveliness.AUTOMATIC,
        liveliness_lease_duration=forever,
        avoid_ros_namespace_conventions=False,
    )
