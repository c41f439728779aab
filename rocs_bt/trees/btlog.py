"""BtLog: log file for Groot2's replay, in the format of BehaviorTree.CPP's FileLogger2.

The format (protocol 1 of BehaviorTree.CPP 4.2 and later, src/loggers/bt_file_logger_v2.cpp), little-endian:

    18 bytes   BTCPP4-FileLogger2
     1 byte    protocol, 1
     4 bytes   size of the document that follows
     n bytes   tree as XML (see `write_instances`)
     8 bytes   origin of the times below [µs]; here zero, the beginning of the run
     9 bytes   per change of status: its time [µs, 6 bytes], the node's number [2 bytes], the status [1 byte]
"""

from __future__ import annotations

import contextlib
import struct
from pathlib import Path
from typing import BinaryIO

from py_trees.behaviour import Behaviour

from ..base.errors import Fault, InputError, RecordingError
from ..base.files import create
from .nodes import BUILTIN, Node, SubTree, Tree
from .nodes.port import ExactKey
from .status import FAILURE, IDLE, RUNNING, SKIPPED, SUCCESS, Outcome
from .xml.element import Element
from .xml.write import Writer, element, model_of, to_text, value_text


def write_instances(tree: Tree, main: str) -> str:
    """Write a running tree as an XML document with `_uid` for each node and `_fullpath` for each subtree."""
    return _Instances(tree).whole(main)


class _Instances(Writer):
    def __init__(self, tree: Tree) -> None:
        super().__init__(None)
        self._root = tree.root
        self._uids = {node.id: str(uid) for uid, node in enumerate(tree.nodes, 1)}
        self._paths = tree.paths()
        self._foreign: dict[str, Element] = {}

    def whole(self, main: str) -> str:
        body = self.tree(self._root)
        first = element("BehaviorTree", {"ID": main, "_fullpath": ""}, [body])
        classes = {**BUILTIN, **self.classes}
        models = [model_of(classes[tag]) for tag in sorted(classes) if classes[tag].kind != "SubTree"]
        models += [self._foreign[tag] for tag in sorted(self._foreign) if tag not in classes]
        trees = [self.trees[uid] for uid in sorted(self.trees, key=int)]
        return to_text(element("root", {"BTCPP_format": "4"}, [first, *trees, element("TreeNodesModel", {}, models)]))

    def subtree(self, node: SubTree, body: Element) -> Element:
        uid, path = self._uids[node.id], self._paths[node.id]
        self.trees[uid] = element("BehaviorTree", {"ID": node.tree, "_fullpath": path}, [body])
        own = {"ID": node.tree, "_fullpath": path, "_uid": uid} | ({"_autoremap": "true"} if node.autoremap else {})
        return element(
            "SubTree",
            own | {n: value_text(v) for n, v in node.remaps.items() if not isinstance(v, ExactKey)} | self.rest(node),
        )

    def node(self, node: Behaviour, below: list[Element]) -> Element:
        made = super().node(node, below)
        tag = made.attributes.get("ID", made.tag)
        kind = "Control" if len(below) > 1 else "Decorator" if below else "Action"
        model = self._foreign.setdefault(tag, element(getattr(node, "kind", kind), {"ID": tag}))
        known = {port.attributes["name"] for port in model.children}
        ports = [n for n in made.attributes if n not in ("ID", "name", *known) and not n.startswith("_")]
        model.children += [element("input_port", {"name": name}) for name in ports]
        given = {**made.attributes, "name": node.name, "_uid": self._uids[node.id]}
        made.attributes = {n: given.pop(n) for n in ("ID", "name", "_uid") if n in given} | given
        return made


MAGIC = b"BTCPP4-FileLogger2\x01"
MAX_NODES = 0xFFFF
"""Largest number of nodes that the format can address."""

STATUSES = {IDLE: 0, RUNNING: 1, SUCCESS: 2, FAILURE: 3}
"""Status codes of the format. As in BehaviorTree.CPP, SKIPPED is not a status of a node and is not written."""
_FINISHED = (STATUSES[SUCCESS], STATUSES[FAILURE])
_REACTIVE = ("ReactiveSequence", "ReactiveFallback")
_FLUSH_EVERY = 0.5  # [s] of run time; a killed run loses at most this much of the log


class BtLog:
    """Writes every change of status in a tree to a log file as it happens, in the order of BehaviorTree.CPP.

    Within a tick a parent becomes RUNNING before its children change. Its finished children become IDLE before it ends
    itself, and the root becomes IDLE at the end of its last tick. Nodes of rocs_bt keep their status after they have
    ended, so these changes are derived here.

    A file can describe only one set of nodes. When a subtree is swapped, a second file is begun: `R2.btlog`, then
    `R2-2.btlog`.

    Args:
        path: Path of the log file, ending in `.btlog`.
        tree: The tree; it needs a clock.
        name: Name of the tree's root in the log.

    Raises:
        InputError: The tree has more nodes than the format can address.
        RecordingError: The file cannot be written.
    """

    def __init__(self, path: Path, tree: Tree, name: str = "MainTree") -> None:
        self._path, self._tree, self._name = path, tree, name
        self._count, self._failure = 0, ""
        self._file: BinaryIO | None = None
        self._begin()
        if self._failure:
            raise RecordingError(self._failure)
        self._unwatch = tree.watch(self._on_tick, self._on_tick_end)

    def close(self) -> None:
        """Close the log.

        Raises:
            RecordingError: The log could not be written completely.
        """
        self._unwatch()
        self._end()
        if self._failure:
            raise RecordingError(self._failure)

    def _begin(self) -> None:
        tree = self._tree
        if len(tree.nodes) > MAX_NODES:
            raise InputError(
                Fault(
                    f"the tree '{self._name}' has {len(tree.nodes)} nodes; a .btlog file can hold at most {MAX_NODES}.",
                    hint="Use the live page or the recording instead; they have no such limit.",
                )
            )
        self._nodes: tuple[Behaviour, ...] = tree.nodes
        self._uids = {node.id: uid for uid, node in enumerate(tree.nodes, 1)}
        self._stock = {node.id: node.status for node in reversed(tree.nodes) if not isinstance(node, Node)}
        self._count += 1
        self._written = bytearray(len(tree.nodes) + 1)
        self._flush_at = 0.0
        path = self._path if self._count == 1 else self._path.with_stem(f"{self._path.stem}-{self._count}")
        document = write_instances(tree, self._name).encode()
        try:
            self._file = create(path)
            self._file.write(MAGIC + struct.pack("<i", len(document)) + document + struct.pack("<q", 0))
        except OSError as error:
            self._failed(path, error)
        for uid, node in enumerate(tree.nodes, 1):
            if node.status is RUNNING:
                self._write(uid, STATUSES[RUNNING])

    def _on_tick(self, node: Behaviour, outcome: Outcome) -> None:
        """Write the changes of a node that was ticked or halted, after its children."""
        if self._nodes is not self._tree.nodes:
            self._end()
            self._begin()
        if outcome is not IDLE:
            self._start(node.parent)
        if outcome is not SKIPPED:
            self._reset_children(node, outcome)
            self._write(self._uids[node.id], STATUSES[outcome])

    def _start(self, node: Behaviour | None) -> None:
        """Write that a node and its ancestors are RUNNING, the outermost first: one of their children was ticked."""
        starting = []
        while node is not None and self._written[self._uids[node.id]] != STATUSES[RUNNING]:
            starting.append(self._uids[node.id])
            node = node.parent
        for uid in reversed(starting):
            self._write(uid, STATUSES[RUNNING])

    def _reset_children(self, node: Behaviour, outcome: Outcome) -> None:
        """Write that children are IDLE: all if the node ended; while it runs, only those that its class resets."""
        if outcome is RUNNING and len(node.children) != 1 and getattr(node, "tag", "") not in _REACTIVE:
            return
        for child in node.children:
            uid = self._uids[child.id]
            if outcome is not RUNNING or self._written[uid] in _FINISHED:
                self._write(uid, STATUSES[IDLE])

    def _on_tick_end(self) -> None:
        """Write the changes of stock py_trees nodes, which report no ticks, and the reset of the root."""
        if self._nodes is not self._tree.nodes:
            return
        for node in reversed(self._nodes):
            if self._stock.get(node.id, node.status) is not node.status:
                self._stock[node.id] = node.status
                self._on_tick(node, node.status)
        if self._written[1] in _FINISHED:
            self._write(1, STATUSES[IDLE])

    def _write(self, uid: int, status: int) -> None:
        if self._written[uid] == status or self._file is None:
            return
        self._written[uid] = status
        t = self._tree.runtime.now()
        try:
            self._file.write(round(t * 1e6).to_bytes(6, "little") + uid.to_bytes(2, "little") + bytes((status,)))
            if t >= self._flush_at:
                self._flush_at = t + _FLUSH_EVERY
                self._file.flush()
        except OSError as error:  # a full disk must not stop a robot
            self._failed(Path(self._file.name), error)

    def _end(self) -> None:
        file, self._file = self._file, None
        if file is not None:
            try:
                file.close()
            except OSError as error:
                self._failed(Path(file.name), error)

    def _failed(self, path: Path, error: OSError) -> None:
        self._failure = f"cannot write the log '{path}': {error.strerror}."
        if self._file is not None:
            with contextlib.suppress(OSError):
                self._file.close()
            self._file = None
