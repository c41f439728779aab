"""Dialects of missions in XML: the nodes of each, and the dialect that a mission without a declared one has."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from functools import cache
from pathlib import Path

from ..base.errors import Fault, InputError, unknown
from ..interfaces.vocabulary import NATIVE, Vocabulary, vocabularies, vocabulary_of
from ..trees.nodes import BUILTIN, Registry
from ..trees.xml.document import Document

Defined = Callable[[set[str]], Collection[str]]


@cache
def shipped_nodes(dialect: str = "") -> Registry:
    """Node classes of all packages for missions of a dialect, without the robot's actions."""
    own, distribution = vocabulary_of(dialect)
    nodes = BUILTIN if own is None or own.nodes is None else own.nodes(distribution)
    return nodes.with_(node for known in vocabularies().values() for node in known.anywhere())


@cache
def elsewhere() -> Mapping[str, tuple[str, str]]:
    """Message and hint for each node that exists only in another dialect, by its name."""
    return {
        tag: (
            f"'{tag}' is a node of {known.title}.",
            f'Write nodes = "{name}" in the scenario; check and show take --nodes {name}.',
        )
        for name, known in _recognisable().items()
        for tag in _foreign(name)
    }


def recognise(tags: set[str], defined: Defined = lambda names: ()) -> str:
    """Dialect of nodes that exist only in it; rocs_bt's own if there are none.

    Args:
        tags: Names of the node classes that a mission uses.
        defined: Function from names of node classes to those that the project defines.
    """
    for name, known in _recognisable().items():
        only = tags & _foreign(name) - known.common
        if only - set(defined(only)):
            return name
    return NATIVE


def tags_of(document: Document) -> set[str]:
    """Names of all node classes that the trees of a document use, including SubTree."""
    return {element.node_tag for element in document.elements()}


def dialect_in(document: Document, declared: str = "", defined: Defined = lambda names: ()) -> str:
    """Dialect of a document's nodes: the declared one, or as recognised.

    A dialect without a distribution gets the one that a model of the document names, if any.

    Raises:
        InputError: The document names an unknown distribution.
    """
    dialect = declared or recognise(tags_of(document), defined)
    own, _ = vocabulary_of(dialect)
    for element in (e for model in document.models.values() for e in model.metadata()):
        if own is not None and (named := element.attributes.get(own.named, "")):
            if named not in own.distributions:
                fault = unknown("distribution", named, own.distributions)
                raise InputError(element.fault(fault.message, fault.hint, attribute=own.named))
            return dialect if ":" in dialect else f"{dialect}:{named}"
    return dialect


def recognised(file: Path | None, declared: str, dialect: str) -> list[Fault]:
    """Note that a mission was recognised; empty if its dialect was declared or is rocs_bt's own.

    Args:
        file: File of the mission; None for a text.
        declared: Dialect that the user named; empty for none.
        dialect: Dialect of the mission.
    """
    own, distribution = vocabulary_of(dialect)
    if declared or own is None:
        return []
    message = f"this is a mission of {own.title}, read as one of {distribution.title()}; {own.about}."
    return [Fault(message, file, hint=own.hint, warning=True, note=True)]


def _recognisable() -> Mapping[str, Vocabulary]:
    return {name: known for name, known in vocabularies().items() if known.title}


@cache
def _foreign(dialect: str) -> frozenset[str]:
    """Names of the nodes of a dialect that rocs_bt's own does not have."""
    return frozenset(shipped_nodes(dialect).keys() - shipped_nodes(NATIVE).keys())
