"""From the text of a query to a Query."""

from __future__ import annotations

import ast
import re
from collections.abc import Mapping
from dataclasses import replace

from ...errors import Fault, InputError, UnitError
from ...expression import Misuse, Node, parse
from ...expression.environment import SignalLayout
from ...units import NONE, TIME, parse_quantity
from ..schema import SCHEMA, Schema
from .names import Names
from .parameter import Parameter
from .pattern import read_pattern
from .plan import Planner, code_of, conditions_of, value_of
from .query import Moment, Query
from .scope import Scope
from .sections import Section, sections_of
from .steps import Code

_NAME = re.compile(r"[A-Za-z_]\w*(\s*\.\s*[A-Za-z_]\w*)*")
MAX_LENGTH = 1000
"""Characters that a query may have."""


def compile_query(
    text: str,
    schema: Schema = SCHEMA,
    signals: SignalLayout | None = None,
    parameters: Mapping[str, Parameter] | None = None,
) -> Query:
    """Compile a query.

    Args:
        text: Such as `object where moves and distance(pose, robot) < 2 m order by distance(pose, robot) limit 3`.
        schema: What may stand in the graph.
        signals: The robot's signals, which it may name; None where nobody knows them.
        parameters: The types of what will be handed over beside the text, by name.

    Raises:
        InputError: The text is no query; each fault has its line, if there are several, and its 1-based column.
    """
    try:
        return _Compiler(text, schema, signals, parameters or {}).query()
    except InputError as error:
        raise type(error)(*(_placed(fault, text) for fault in error.faults)) from error


def _placed(fault: Fault, text: str) -> Fault:
    """A fault at a column of the whole text, at its line and that line's column."""
    before = text[: max(0, fault.column - 1)]
    if "\n" not in text:
        return fault
    return replace(fault, line=1 + before.count("\n"), column=fault.column - 1 - before.rfind("\n"))


class _Compiler:
    def __init__(
        self, text: str, schema: Schema, signals: SignalLayout | None, parameters: Mapping[str, Parameter]
    ) -> None:
        if len(text) > MAX_LENGTH:
            raise InputError(Fault(f"a query has at most {MAX_LENGTH} characters, found {len(text)}."))
        if not text.strip():
            raise InputError(Fault("the query is empty.", hint="Write for example: object where moves."))
        self._text = text
        self._schema = schema
        self._signals = signals
        self._parameters = parameters
        self._sections = sections_of(text)
        self._pattern = read_pattern(self._sections[""], schema)
        self._names = Names(schema, self._pattern, parameters, signals)
        self._scope = Scope(text, self._names)

    def query(self) -> Query:
        """The query."""
        pattern, scope = self._pattern, self._scope
        where = self._where()
        order, nearest = self._order()
        limit = self._limit()
        give = self._give()
        as_of, since = self._moment(), self._since()
        if not pattern.things and where is None:
            raise self._sections[""].fault("the query asks for nothing.", "Begin with a kind, or with 'where'.")
        conditions = conditions_of(where, scope.slots)
        if nearest is not None and (len(pattern.things) > 1 or limit is None):
            nearest = None
        return Query(
            self._text,
            self._schema,
            tuple(pattern.things[i].name for i in pattern.shown),
            tuple(label for label, _ in give),
            self._parameters,
            as_of,
            (len(pattern.things), len(pattern.links)),
            tuple(pattern.shown),
            tuple(range(len(pattern.links))),
            Planner(self._schema, pattern, scope, conditions, nearest).steps(),
            order,
            None if nearest is None else code_of(nearest[1]),
            limit,
            [code for _, code in give],
            since,
            tuple(scope.texts),
            self._sizes(),
        )

    def _sizes(self) -> dict[str, int]:
        return {name: self._signals.spec(name).size for name in self._names.read_signals} if self._signals else {}

    def _expression(self, section: Section) -> Node:
        node = parse(section.text, self._scope.environment)
        if node.temporal:
            raise section.fault("a query looks at one moment; held, once, since and rate look at many.")
        return node

    def _where(self) -> Node | None:
        section = self._sections.get("where")
        if section is None:
            return None
        node = self._expression(section)
        if not node.kind.boolean or node.kind.size:
            raise section.fault(f"'where' needs true or false, but '{node.text}' is {node.kind.words}.")
        return node

    def _order(self) -> tuple[tuple[Code, bool] | None, tuple[int, str] | None]:
        """The order, and what must be nearest to what where that is all of it."""
        section = self._sections.get("order by")
        if section is None:
            return None, None
        descending = re.search(r"\s(descending)\s*$", section.text)
        if descending:
            section = Section(section.text[: descending.start(1)], section.start)
        node = self._expression(section)
        if node.kind.boolean or node.kind.size or node.kind.mixed:
            raise section.fault(f"'order by' needs a number, but '{node.text}' is {node.kind.words}.")
        nearest = self._scope.slots[node.start].near if node.op == "read" and not descending else None
        return (value_of(node, self._scope.slots), bool(descending)), nearest

    def _limit(self) -> int | None:
        section = self._sections.get("limit")
        if section is None:
            return None
        if not section.words.isdecimal() or int(section.words) < 1:
            raise section.fault(f"'limit' needs a whole number from 1, found '{section.words}'.")
        return int(section.words)

    def _give(self) -> list[tuple[str, Code]]:
        section = self._sections.get("give")
        return [] if section is None else [self._given(part) for part in section.split()]

    def _given(self, part: Section) -> tuple[str, Code]:
        """One column: a name is given as it stands in the graph, anything else as an expression."""
        label = " ".join(part.words.split())
        if not label:
            raise part.fault("nothing stands between two commas.", at=part.start)
        if _NAME.fullmatch(label) is None:
            node = self._expression(part)
            if node.kind.size:
                raise part.fault(f"'give' needs single values, but '{label}' has {node.kind.size}.")
            return label, value_of(node, self._scope.slots)
        try:
            tree = ast.parse(label, mode="eval").body
            meaning = self._scope.meaning(tree, lambda each: part.start)
        except (Misuse, SyntaxError) as error:
            raise part.fault(f"'{label}': {error}") from error
        if meaning.sort == "edge":
            raise part.fault(f"'{label}' is an edge.", "Write one of its attributes, as in connects.length.")
        return label, code_of(meaning.code)

    def _moment(self) -> Moment | None:
        section = self._sections.get("as of")
        if section is None:
            return None
        words = re.sub(r"\s+ago$", "", section.words)
        ago = words != section.words
        if words in self._parameters:
            kind = self._parameters[words]
            if kind.type is not float or kind.dimension not in (NONE, TIME):
                raise section.fault(f"'as of' needs a time [s], but '{words}' is {kind}.")
            return Moment(words, ago)
        try:
            quantity = parse_quantity(words)
        except UnitError as error:
            hint = "Write for example: as of 12.5 s, or as of 2 s ago."
            raise section.fault(error.faults[0].message, hint) from error
        if quantity.dimension != TIME:
            raise section.fault(f"'as of' needs a time, found '{words}'.", "Write for example: as of 12.5 s.")
        return Moment(quantity.value, ago)

    def _since(self) -> int | str | None:
        section = self._sections.get("changed since")
        if section is None:
            return None
        if section.words in self._parameters:
            if self._parameters[section.words] != Parameter(float):
                raise section.fault(f"'changed since' needs a revision, but '{section.words}' is none.")
            return section.words
        if not section.words.isdecimal():
            raise section.fault(f"'changed since' needs a revision, a whole number, found '{section.words}'.")
        return int(section.words)
