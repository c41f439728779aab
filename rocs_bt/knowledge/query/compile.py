"""Compiler from a query text to a Query with a plan of steps.

To find all answers, each variable of a query is bound to the nodes of the graph, one after the other. The plan orders
the variables and makes each test as early as possible. Variables for a named node, or for nodes near a position, are
bound first; then variables linked to bound ones; then the others in the order of the query. The order does not
change the answers.
"""

from __future__ import annotations

import ast
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...base.errors import Fault, InputError, UnitError
from ...base.units import NONE, TIME, parse_quantity
from ...expression import FUNCTIONS, Expression, Misuse, Node, Values, evaluate, kernel_missing, parse
from ...expression.environment import SignalLayout
from ..schema import SCHEMA, Schema
from .names import Names
from .parameter import HELPERS, Parameter
from .pattern import AbsentClause, Link, Pattern, Section, read_pattern, sections_of
from .query import Query, QueryTime
from .scope import ExpressionScope, Slot
from .steps import Absent, Code, Follow, Joined, Match, Near, Pin, Scan, Step, Test

_PARTS = re.compile(r"\b([nrec])\b(?=[\[.])")


def code_of(source: str) -> Code:
    """Compile the code of a slot, which `ExpressionScope` writes without text of users, to a function of a `Match`."""
    parts = [f"{name} = match.{name}" for name in dict.fromkeys(_PARTS.findall(source))]
    names: dict[str, Any] = {"__builtins__": {"float": float}, **HELPERS}
    exec("\n    ".join(["def code(match):", *parts, f"return {source}"]), names)
    code: Code = names["code"]
    return code


_FEW = 8  # up to this many rows, calls of the kernel are faster than numpy


class Formula:
    """Expression as a function of the query's `Match`, which returns the value, or None if unknown."""

    def __init__(self, node: Node, slots: Sequence[Slot]) -> None:
        reads = node.reads()
        codes = (slots[i].code if i in reads else "nan" for i in range(max(reads, default=-1) + 1))
        self.read = code_of(f"[{', '.join(codes)}]")
        self._expression, self._series = Expression(node), Values([node])
        self._expression.prepare()

    def __call__(self, match: Match) -> float | bool | None:
        return self._expression(self.read(match))

    def hold(self, rows: Sequence[Sequence[float]]) -> list[bool]:
        """Whether a condition holds for several results of `read`."""
        if len(rows) <= _FEW and not kernel_missing():
            return [self._expression(row) is True for row in rows]
        (truth,) = self._series(np.array(rows, float), np.zeros(len(rows)))
        held: list[bool] = (truth == 1.0).tolist()
        return held


def test_of(nodes: Sequence[Node], slots: Sequence[Slot]) -> Formula:
    """Formula that is true if all expressions hold."""
    return Formula(nodes[0] if len(nodes) == 1 else Node("and", nodes[0].kind, tuple(nodes)), slots)


@dataclass(frozen=True)
class Clause:
    """Operand of the top-level `and` of `where`, with indices of the variables and links that it depends on."""

    node: Node
    variables: frozenset[int]
    links: frozenset[int]


def conditions_of(node: Node | None, slots: Sequence[Slot]) -> list[Clause]:
    """Split an expression at its top-level `and` into conditions, which can be tested separately."""
    if node is None:
        return []
    if node.op == "and":
        return [condition for arg in node.args for condition in conditions_of(arg, slots)]
    read = [slots[i] for i in node.reads()]
    none = frozenset[int]()
    return [Clause(node, none.union(*(s.variables for s in read)), none.union(*(s.links for s in read)))]


class Planner:
    """Planner of the steps of one query.

    Args:
        schema: Schema of the graph.
        pattern: Variables and links of the query.
        scope: Slots of the query: the values that its expressions read.
        conditions: Operands of the query's `where`.
        nearest: Index of the variable with nodes wanted in order of distance, and source code of the position from
            which the distance is measured; None without such an order.
    """

    def __init__(
        self,
        schema: Schema,
        pattern: Pattern,
        scope: ExpressionScope,
        conditions: Sequence[Clause],
        nearest: tuple[int, str] | None,
    ) -> None:
        self._schema = schema
        self._pattern = pattern
        self._scope = scope
        self._pending = list(conditions)
        self._nearest = nearest
        self._bound: set[int] = set()
        self._edges: set[int] = set()

    def steps(self) -> list[Step]:
        """Plan all steps of the query, in the order of their execution."""
        shown = [i for i, variable in enumerate(self._pattern.variables) if not variable.hidden]
        steps: list[Step] = [Test(test_of(early, self._scope.slots))] if (early := self._ready()) else []
        steps += self._join(shown, [*enumerate(self._pattern.links)], self._bound, list(self._pattern.absent))
        return steps

    def _join(
        self, variables: Sequence[int], links: list[tuple[int, Link]], bound: set[int], absent: list[AbsentClause]
    ) -> list[Step]:
        """Steps that bind these variables, and check these links and `no` clauses."""
        steps: list[Step] = []
        left = [i for i in variables if i not in bound]
        while True:
            steps += self._checks(links, bound, absent)
            if not left:
                return steps
            step, variable = self._next(left, links, bound)
            left.remove(variable)
            bound.add(variable)
            steps.append(step)
            if (tests := self._ready()) and isinstance(step, Scan):
                steps[-1] = Scan(step.variable, step.kind, step.near, test_of(tests, self._scope.slots))
            elif tests:
                steps.append(Test(test_of(tests, self._scope.slots)))

    def _next(self, left: list[int], links: list[tuple[int, Link]], bound: set[int]) -> tuple[Step, int]:
        """Choose the next variable to bind, and the step that binds it; removes a link that the step follows."""
        for i in left:
            if (step := self._pinned(i)) is not None:
                return step, i
        for i in left:
            if (near := self._near(i)) is not None:
                return Scan(i, self._pattern.variables[i].kind or "", near, None), i
        for j, link in links:
            forward = link.source in bound
            other = link.target if forward else link.source
            if other in left and (forward or link.target in bound):
                links.remove((j, link))
                self._edges.add(j)
                return Follow(link, j, forward, self._kinds(other)), other
        return Scan(left[0], self._pattern.variables[left[0]].kind or "", None, None), left[0]

    def _checks(self, links: list[tuple[int, Link]], bound: set[int], absent: list[AbsentClause]) -> list[Step]:
        """Steps for all links, conditions and `no` clauses with only bound variables."""
        steps: list[Step] = []
        for j, link in [*links]:
            if link.source in bound and link.target in bound:
                links.remove((j, link))
                self._edges.add(j)
                steps.append(Joined(link, j))
        if tests := self._ready():
            steps.append(Test(test_of(tests, self._scope.slots)))
        for clause in [*absent]:
            hidden, missing = clause
            if all(end in bound or end in hidden for link in missing for end in (link.source, link.target)):
                absent.remove(clause)
                # Each clause has its own scope: no other clause is tested within it.
                steps.append(Absent(self._join(hidden, [(-1, link) for link in missing], set(bound), [])))
        return steps

    def _ready(self) -> list[Node]:
        """Remove and return the conditions that can be tested, since all their variables and links are bound."""
        ready = [c for c in self._pending if c.variables <= self._bound and c.links <= self._edges]
        self._pending = [c for c in self._pending if c not in ready]
        return [c.node for c in ready]

    def _pinned(self, i: int) -> Step | None:
        variable = self._pattern.variables[i]
        if variable.node is not None:
            name = variable.node
            return Pin(i, None, lambda match: name)
        for condition in self._pending:
            node = condition.node
            if node.op == "compare" and node.args[0].op == "read" and condition.variables == {i}:
                same = self._scope.slots[node.args[0].start].same
                if same is not None and same[0] == i:
                    return Pin(i, self._kinds(i), code_of(same[1]))
        return None

    def _near(self, i: int) -> Near | None:
        """Smallest limit on the distance of a variable to a constant position; None without such a condition."""
        best: Near | None = None
        for condition in self._pending:
            found = _reach(condition.node, self._scope.slots)
            if found is not None and found[0] == i and (best is None or found[2] < best.within):
                best = Near(code_of(found[1]), found[2], own=self._own(i))
        if self._nearest is not None and self._nearest[0] == i:
            code = self._nearest[1]
            within = [r[2] for c in self._pending if (r := _reach(c.node, self._scope.slots)) and r[:2] == (i, code)]
            return Near(code_of(code), min(within, default=math.inf), sorted=not within, own=self._own(i))
        return best

    def _own(self, i: int) -> bool:
        return "robot" in (self._kinds(i) or ())

    def _kinds(self, i: int) -> frozenset[str] | None:
        kind = self._pattern.variables[i].kind
        return None if kind is None else self._schema.families[kind]


def _reach(node: Node, slots: Sequence[Slot]) -> tuple[int, str, float] | None:
    """Split a condition such as `distance(variable, position) < 2 m`; None for any other condition.

    Returns:
        Index of the variable, source code of the position, maximum distance [m].
    """
    if node.op != "compare" or len(node.signs) != 1:
        return None
    left, right, sign = node.args[0], node.args[1], node.signs[0]
    if sign in (">", ">="):
        left, right, sign = right, left, "<"
    if sign not in ("<", "<=") or left.op != "read" or left.kind.size or not right.constant or right.kind.size:
        return None
    near, value = slots[left.start].near, evaluate(right, ())
    if near is None or value is None:
        return None
    return near[0], near[1], float(value)


_NAME = re.compile(r"[A-Za-z_]\w*(\s*\.\s*[A-Za-z_]\w*)*")
MAX_LENGTH = 1000
"""Maximum number of characters of a query."""


def compile_query(
    text: str,
    schema: Schema = SCHEMA,
    signals: SignalLayout | None = None,
    parameters: Mapping[str, Parameter] | None = None,
) -> Query:
    """Compile a query.

    Args:
        text: Query such as `object where moves and distance(pose, robot) < 2 m order by distance(pose, robot) limit 3`.
        schema: Schema of the graph.
        signals: The robot's signals, which the query may name; None if unknown.
        parameters: Types of the parameters, by name.

    Raises:
        InputError: The text is not a query; each fault has its 1-based column, and its line if there are several.
    """
    try:
        return _Compiler(text, schema, signals, parameters or {}).query()
    except InputError as error:
        raise type(error)(*(_located(fault, text) for fault in error.faults)) from error


def _located(fault: Fault, text: str) -> Fault:
    """Convert the column of a fault, counted in the whole text, to line and column if the text has several lines."""
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
        self._scope = ExpressionScope(text, self._names)

    def query(self) -> Query:
        """Compile the sections of the text to a query."""
        pattern, scope = self._pattern, self._scope
        where = self._where()
        order, nearest = self._order()
        limit = self._limit()
        give = self._give()
        as_of, since = self._moment(), self._since()
        if not pattern.variables and where is None:
            raise self._sections[""].fault("the query has no pattern.", "Begin with a kind, or with 'where'.")
        conditions = conditions_of(where, scope.slots)
        if nearest is not None and (len(pattern.variables) > 1 or limit is None):
            nearest = None
        return Query(
            self._text,
            self._schema,
            tuple(pattern.variables[i].name for i in pattern.shown),
            tuple(label for label, _ in give),
            self._parameters,
            as_of,
            (len(pattern.variables), len(pattern.links)),
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
        if (single := self._reduced(node)) is not None:
            value = single.args[0]
            order = f"For the row with the largest, write: order by {value.text} descending limit 1."
            hint = f"Write: {value.text}." if value.kind.boolean else order
            raise section.fault(f"'{single.text}' is of one value: an expression sees one row, not all rows.", hint)
        return node

    def _reduced(self, node: Node) -> Node | None:
        """First use of a function of groups, such as `max`, on one value of a row; None if there is none."""
        for each in node.walk():
            groups = each.args[:1] if each.op in ("dot", "min_valid") else each.args
            if each.op in FUNCTIONS and "(group" in FUNCTIONS[each.op].usage and [a.kind.size for a in groups] == [0]:
                slots = [self._scope.slots[i] for i in each.reads()]
                if any(slot.variables or slot.links for slot in slots):  # not a signal with one value
                    return each
        return None

    def _where(self) -> Node | None:
        section = self._sections.get("where")
        if section is None:
            return None
        node = self._expression(section)
        if not node.kind.boolean or node.kind.size:
            raise section.fault(f"'where' needs true or false, but '{node.text}' is {node.kind.words}.")
        return node

    def _order(self) -> tuple[tuple[Code, bool] | None, tuple[int, str] | None]:
        """Code of the sort value and whether to sort descending; variable and position if the value is a distance."""
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
        return (Formula(node, self._scope.slots), bool(descending)), nearest

    def _limit(self) -> int | None:
        section = self._sections.get("limit")
        if section is None:
            return None
        if not section.content.isdecimal() or int(section.content) < 1:
            raise section.fault(f"'limit' needs a whole number from 1, found '{section.content}'.")
        return int(section.content)

    def _give(self) -> list[tuple[str, Code]]:
        section = self._sections.get("give")
        return [] if section is None else [self._given(part) for part in section.split()]

    def _given(self, part: Section) -> tuple[str, Code]:
        """Label and code of one `give` column: a name is read from the graph, anything else is an expression."""
        label = " ".join(part.content.split())
        if not label:
            raise part.fault("nothing is between two commas.", at=part.start)
        if _NAME.fullmatch(label) is None:
            node = self._expression(part)
            if node.kind.size:
                raise part.fault(f"'give' needs single values, but '{label}' has {node.kind.size}.")
            return label, Formula(node, self._scope.slots)
        try:
            tree = ast.parse(label, mode="eval").body
            meaning = self._scope.meaning(tree, lambda each: part.start)
        except (Misuse, SyntaxError) as error:
            raise part.fault(f"'{label}': {error}") from error
        if meaning.sort == "edge":
            raise part.fault(f"'{label}' is an edge.", "Write one of its attributes, as in connects.length.")
        return label, code_of(meaning.code)

    def _moment(self) -> QueryTime | None:
        section = self._sections.get("as of")
        if section is None:
            return None
        words = re.sub(r"\s+ago$", "", section.content)
        ago = words != section.content
        if words in self._parameters:
            kind = self._parameters[words]
            if kind.type is not float or kind.dimension not in (NONE, TIME):
                raise section.fault(f"'as of' needs a time [s], but '{words}' is {kind}.")
            return QueryTime(words, ago)
        try:
            quantity = parse_quantity(words)
        except UnitError as error:
            hint = "Write for example: as of 12.5 s, or as of 2 s ago."
            raise section.fault(error.faults[0].message, hint) from error
        if quantity.dimension != TIME:
            raise section.fault(f"'as of' needs a time, found '{words}'.", "Write for example: as of 12.5 s.")
        return QueryTime(quantity.value, ago)

    def _since(self) -> int | str | None:
        section = self._sections.get("changed since")
        if section is None:
            return None
        if section.content in self._parameters:
            if self._parameters[section.content] != Parameter(float):
                raise section.fault(f"'changed since' needs a revision, but '{section.content}' is not a number.")
            return section.content
        if not section.content.isdecimal():
            raise section.fault(f"'changed since' needs a revision, a whole number, found '{section.content}'.")
        return int(section.content)
