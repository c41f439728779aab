"""Bag: messages of a recorded ROS network, from rosbag2 (MCAP or sqlite3) or ROS 1."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from ...base.errors import Fault, InputError, RecordingError, RocsError
from ...base.files import check_regular, is_file
from ..messages.type_store import DISTROS, TypeStore, import_rosbags

FILES = (".mcap", ".db3", ".bag")
"""File extensions of bags."""

_NEVER = 2**63 - 1  # [ns] start of an empty bag


class BagMessage(NamedTuple):
    """Message in a bag.

    Attributes:
        topic: Full name of the topic.
        time: Time at which it was recorded [ns since 1970].
        data: Message as CDR.
    """

    topic: str
    time: int
    data: bytes


@dataclass(frozen=True)
class BagTopic:
    """Topic in a bag."""

    type: str
    count: int  # as the bag declares it
    definition: str = ""  # text with those of its fields; empty if the bag has none
    idl: bool = False
    digest: str = ""  # hash of the type (RIHS01), or empty


class Bag:
    """Opened bag: the folder of a rosbag2, its file, or a ROS 1 bag.

    Attributes:
        path: Folder or file.
        topics: Topics by name.
        start: Time of the first message [ns since 1970].
        end: Time of the last message [ns since 1970].

    Raises:
        InputError: There is no bag, it cannot be read, or it is empty; or the package rosbags is not installed.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        file = _bag_file(path)
        for part in file.iterdir() if file.is_dir() else [file]:
            if is_file(part):
                check_regular(part)
        self._ros1 = file.suffix == ".bag"
        rosbag = import_rosbags("rosbags.rosbag1" if self._ros1 else "rosbags.rosbag2")
        self._types: TypeStore | None = None
        with _readable(path):
            self._reader: Any = rosbag.Reader(file)
            self._reader.open()
            try:
                self._connections = list(self._reader.connections)
                self.topics = {each.topic: self._topic(each) for each in self._connections}
                self.start, self.end = int(self._reader.start_time), int(self._reader.end_time) - 1
                empty = not self._reader.message_count or self.start == _NEVER
            except BaseException:  # raised again, after the bag is closed
                self.close()
                raise
        if empty or not self.topics:
            self.close()
            raise InputError(Fault(f"the bag '{path}' is empty: it has no messages."))

    def types(self, distro: str, topics: Iterable[str]) -> TypeStore:
        """Message types: those of a distribution, and in place of these the ones that the bag defines for some topics.

        Topics that the bag lacks are ignored.

        Raises:
            InputError: A type is unknown, or is not that of the distribution; contains all faults.
        """
        types = TypeStore(distro)
        faults: list[Fault] = []
        used = [(name, self.topics[name]) for name in topics if name in self.topics]
        for name, topic in used:
            try:
                if topic.definition:
                    with _readable(self.path):
                        _define(types, topic)
                else:
                    _check_digest(types, name, topic)
            except InputError as error:
                faults += error.faults
        if faults:
            raise InputError(*faults)
        self._types = types
        return types

    def messages(self, topics: Collection[str]) -> Iterator[BagMessage]:
        """Messages of some topics, in the order of the bag; `types` must have been called with these.

        Raises:
            RecordingError: The bag is damaged.
        """
        wanted = [each for each in self._connections if each.topic in topics]
        store = None if self._types is None or not self._ros1 else self._types.store
        if not wanted:
            return
        try:
            for connection, time, data in self._reader.messages(connections=wanted):
                content = data if store is None else store.ros1_to_cdr(data, connection.msgtype)
                yield BagMessage(connection.topic, int(time), bytes(content))
        except (RocsError, GeneratorExit, KeyboardInterrupt):
            raise
        except Exception as error:  # rosbags raises its own and those of struct, of codecs and of decompression
            raise RecordingError(f"the bag '{self.path}' is damaged: {_said(error)}.") from error

    def close(self) -> None:
        """Close the bag."""
        with suppress(Exception):  # of a damaged bag; its fault is reported already
            self._reader.close()

    def _topic(self, connection: Any) -> BagTopic:
        definition = connection.msgdef
        return BagTopic(
            type=connection.msgtype,
            count=int(connection.msgcount),
            definition=definition.data if definition.format.name in ("MSG", "IDL") else "",
            idl=definition.format.name == "IDL",
            digest="" if self._ros1 else connection.digest,
        )


def _bag_file(path: Path) -> Path:
    """Path for the reader: the folder of a rosbag2, or a file; a folder without metadata.yaml has one file."""
    if not path.exists():
        raise InputError(Fault(f"there is no bag '{path}'.", hint="Give the folder of a rosbag2, or its file."))
    if not path.is_dir():
        if path.suffix not in FILES:
            raise InputError(Fault(f"'{path}' is no bag: its name must end in {', '.join(FILES)}."))
        return path
    if is_file(path / "metadata.yaml"):
        return path
    files = sorted(file for file in path.iterdir() if file.suffix in FILES)
    if len(files) == 1:
        return files[0]
    found = f"{len(files)} files of bags" if files else "no file of a bag"
    raise InputError(
        Fault(f"'{path}' is no bag: it has no metadata.yaml, and {found}.", hint=f"Try: ros2 bag reindex {path}")
    )


@contextmanager
def _readable(path: Path) -> Iterator[None]:
    """Convert all exceptions of rosbags, which raises whatever malformed data causes."""
    try:
        yield
    except (RocsError, OSError):
        raise
    except Exception as error:  # rosbags raises its own and those of struct, of codecs and of sqlite3
        hint = "If it was cut off, try: mcap recover FILE.mcap -o FIXED.mcap; or: ros2 bag reindex FOLDER"
        raise InputError(Fault(f"the bag '{path}' cannot be read: {_said(error)}.", hint=hint)) from error


def _said(error: Exception) -> str:
    return (str(error).strip().rstrip(".") or type(error).__name__)[:300]


def _define(types: TypeStore, topic: BagTopic) -> None:
    """Replace types of the distribution by those in a definition."""
    typesys = import_rosbags("rosbags.typesys")
    parsed: dict[str, Any] = {}
    if not topic.idl:
        parsed = typesys.get_types_from_msg(topic.definition, topic.type)
    else:
        line = "=" * 80 + "\n"
        parts = topic.definition.split(line)[1:] if topic.definition.startswith(f"{line}IDL: ") else [topic.definition]
        for part in parts:
            parsed |= typesys.get_types_from_idl(part.partition("\n")[2] if part.startswith("IDL: ") else part)
    parsed.pop("std_msgs/msg/Header", None)  # equal in all distributions; rosbags removes the `seq` of ROS 1
    for name in parsed:
        types.store.types.pop(name, None)
        types.store.fielddefs.pop(name, None)
    types.store.register(parsed)


def _check_digest(types: TypeStore, name: str, topic: BagTopic) -> None:
    """Check that a type without a definition is that of the distribution."""
    types.message(topic.type)
    if not topic.digest or types.store.hash_rihs01(topic.type) == topic.digest:
        return
    fitting = [d for d in DISTROS if d != types.distro and _digest(d, topic.type) == topic.digest]
    hint = f'Write distro = "{fitting[-1]}" in [ros2].' if fitting else f"No distribution has it: {', '.join(DISTROS)}."
    message = f"the type {topic.type} of topic '{name}' is not that of {types.distro.capitalize()}."
    raise InputError(Fault(message, hint=hint))


def _digest(distro: str, name: str) -> str:
    store = TypeStore(distro).store
    return str(store.hash_rihs01(name)) if name in store.types else ""
