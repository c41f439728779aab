"""Query: a compiled query of the graph.

query = compile_query("object where moves and distance(pose, robot) < 2 m order by distance(pose, robot) limit 3")
query.ask(graph, context).names
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any, TypeAlias

import msgspec

from ...base.errors import KnowledgeError
from ..readable import Readable
from ..schema import Schema
from .context import Execution, QueryContext
from .parameter import Parameter, read_parameters
from .steps import Code, Match, Step, walk


class Answers(msgspec.Struct, frozen=True):
    """Answers to a query, in the order of `order by` or else sorted by name; false if there are none.

    Attributes:
        variables: Names of the query's variables.
        rows: One tuple for each answer: the node found for each of `variables`.
        columns: Expressions of the `give` section, as written.
        values: One tuple for each answer: the value of each of `columns`, None if unknown.
    """

    variables: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    columns: tuple[str, ...] = ()
    values: tuple[tuple[Any, ...], ...] = ()

    def __len__(self) -> int:
        return len(self.rows)

    @property
    def names(self) -> list[str]:
        """Names of the nodes found for the first variable, without duplicates."""
        return list(dict.fromkeys(row[0] for row in self.rows if row))

    @property
    def first(self) -> str | None:
        """The first of `names`; None if there is none."""
        return self.rows[0][0] if self.rows and self.rows[0] else None

    @property
    def dicts(self) -> list[dict[str, Any]]:
        """Each answer as a dict of variables and columns."""
        values = self.values or ((),) * len(self.rows)
        return [
            {**dict(zip(self.variables, row, strict=True)), **dict(zip(self.columns, given, strict=True))}
            for row, given in zip(self.rows, values, strict=True)
        ]


NO_ROBOT = QueryContext()
Found: TypeAlias = tuple[tuple[str, ...], tuple[Any, ...]]  # the nodes of an answer, and the values of its columns


@dataclass(frozen=True)
class QueryTime:
    """Query time of `as of`.

    Attributes:
        value: Time [s], or the name of the parameter that contains the time.
        ago: Whether the time is counted back from now.
    """

    value: float | str
    ago: bool = False


@dataclass(frozen=True, eq=False)
class Query:
    """A compiled query, made by `compile_query`; it keeps no state between executions.

    Attributes:
        text: Source text.
        schema: Schema that the queried graphs must have.
        variables: Names of the query's variables.
        columns: Expressions of the `give` section.
        parameters: Types of the required parameters, by name.
        as_of: Time of the `as of` section; None for the present.
    """

    text: str
    schema: Schema
    variables: tuple[str, ...]
    columns: tuple[str, ...]
    parameters: Mapping[str, Parameter]
    as_of: QueryTime | None
    _count: tuple[int, int]
    _shown: tuple[int, ...]
    _edges: tuple[int, ...]
    _steps: Sequence[Step]
    _order: tuple[Code, bool] | None
    _nearest: Code | None
    _limit: int | None
    _give: Sequence[Code]
    _since: int | str | None
    _texts: Sequence[str]
    _signals: Mapping[str, int]

    def ask(self, graph: Readable, context: QueryContext = NO_ROBOT, **parameters: Any) -> Answers:
        """Find all answers; no write to the graph can happen in between.

        Args:
            graph: Graph to query; a query `as of` a time queries the context's past instead.
            context: Querying robot, its pose, the time, its signals and its past.
            parameters: Values of the query's parameters, by name.

        Raises:
            KnowledgeError: A parameter is missing, unknown or of another type, the graph has another schema, or there
                is no history for an `as of` query.
        """
        graph, match = self._begin(graph, context, parameters)
        with graph.locked():
            found = self._found(match)
            near = self._nearest is not None and self._nearest(match) is not None
            if near and not self._give:  # the answers are found in order of distance already
                return Answers(self.variables, tuple(islice(found, self._limit)), self.columns)
            rows = self._ordered(self._with_values(found, match), near, match)
        return Answers(
            self.variables,
            tuple([row for row, _ in rows]),
            self.columns,
            tuple([values for _, values in rows]) if self._give else (),
        )

    def holds(self, graph: Readable, context: QueryContext = NO_ROBOT, **parameters: Any) -> bool:
        """Whether there is any answer; stops at the first. The arguments are those of `ask`.

        Raises:
            KnowledgeError: See `ask`.
        """
        graph, match = self._begin(graph, context, parameters)
        with graph.locked():
            found = self._found(match)
            return next(found, None) is not None

    def _begin(self, graph: Readable, context: QueryContext, given: Mapping[str, Any]) -> tuple[Readable, Match]:
        types, values = read_parameters(given) if given else ({}, {})
        if types != self.parameters:
            raise KnowledgeError(
                f"the query '{self.text}' needs the parameters {_listed(self.parameters)}; found {_listed(types)}."
            )
        if self.as_of is not None:
            t = self._time(self.as_of, context.t, values)
            if context.past is None:
                raise KnowledgeError(
                    f"no history of the graph is given, so its state at {t:g} s is not available. Query a recording or "
                    "the Knowledge of a running agent, which keep it."
                )
            graph, context = context.past.as_of(t), context._replace(pose=None, t=t, signal=NO_ROBOT.signal)
        if graph.schema is not self.schema and graph.schema != self.schema:
            raise KnowledgeError(f"the query '{self.text}' was compiled for another schema; compile it for this one.")
        execution = Execution(graph, context, values, self._texts, self._signals)
        return graph, Match(*self._count, execution)

    def _time(self, moment: QueryTime, now: float, values: Mapping[str, Any]) -> float:
        value: float = values[moment.value] if isinstance(moment.value, str) else moment.value
        return now - value if moment.ago else value

    def _found(self, match: Match) -> Iterator[tuple[str, ...]]:
        """Yield the answers one by one, each as a tuple of nodes; `match` is that of the last one yielded."""
        names, shown, since = match.n, self._shown, self._since
        matches = walk(self._steps, match)
        if since is not None:
            revision = int(match.c.p[since]) if isinstance(since, str) else since
            matches = filter(lambda _: self._changed(match, revision), matches)
        only = shown[0] if len(shown) == 1 else -1

        def row(_: None) -> tuple[str, ...]:
            return (names[only],) if only >= 0 else tuple([names[i] for i in shown])

        return map(row, matches)  # faster than one more generator

    def _changed(self, match: Match, since: int) -> bool:
        """Whether a node or an edge of the match has changed after the revision `since`."""
        return any(match.r[i]["revision"] > since for i in self._shown) or any(
            match.e[j] is not None and match.e[j]["revision"] > since for j in self._edges
        )

    def _with_values(self, found: Iterator[tuple[str, ...]], match: Match) -> Iterator[Found]:
        give = self._give
        for row in found:
            yield row, tuple([_plain(code(match)) for code in give]) if give else ()

    def _ordered(self, found: Iterator[Found], near: bool, match: Match) -> list[Found]:
        """Sort the answers and keep as many as the query's limit allows."""
        limit = self._limit
        if near:
            return list(islice(found, limit))
        if self._order is None:
            rows = list(found)
            rows.sort(key=_by_name)
            return rows[:limit]
        keyed = [(self._key(match), *each) for each in found]
        keyed.sort(key=_by_key)
        return [(row, values) for _, row, values in keyed[:limit]]

    def _key(self, match: Match) -> float:
        if self._order is None:
            return 0.0
        code, descending = self._order
        value = code(match)
        if value is None:
            return math.nan
        return -float(value) if descending else float(value)


def _by_name(each: Found) -> tuple[str, ...]:
    return each[0]


def _by_key(each: tuple[float, tuple[str, ...], tuple[Any, ...]]) -> tuple[bool, float, tuple[str, ...]]:
    key, row, _ = each
    unknown = math.isnan(key)
    return unknown, 0.0 if unknown else key, row


def _listed(parameters: Mapping[str, Parameter]) -> str:
    return ", ".join(f"{name} ({kind})" for name, kind in parameters.items()) or "none"


def _plain(value: Any) -> Any:
    """An immutable copy of a value; a live view becomes a tuple of its present values."""
    return tuple(value.tolist()) if hasattr(value, "tolist") else value
