"""From the syntax tree of a script to the source of a Python function.

An expression is written twice. The quick form is plain Python arithmetic, for keys that hold numbers; the general form
calls the functions of `arithmetic`, which take all values and tell what is wrong. The code looks at the values of the
keys, and takes the quick form where it may. Names and literals are parameters, so that scripts of one form share code:

    s0, s1   the names and the values of the literals, by slot
    f1       a numeric literal or an enum as a float
    e0, v0   the entry of a name, and its value in the present statement
    old      the value of the entry that is assigned to
"""

from __future__ import annotations

from .form import Slots
from .parser import Assignment, Binary, Comparison, Conditional, Expression, Literal, Name, Unary, walk
from .quick import FLOAT, Quick, Unfit


def write_statement(statement: Expression, slots: Slots, gives: str) -> list[str]:
    """The lines of a statement.

    Args:
        statement: The statement.
        slots: The slots of the script.
        gives: What the function returns after it: `value`, `truth`, or nothing if empty.
    """
    if isinstance(statement, Assignment):
        return _Assignment(statement, slots).lines(gives)
    general, quick = General(statement, slots), Quick(slots)
    lines = [*general.needs, *_given(general.text, gives)]
    try:
        text = quick.truth(statement) if gives == "truth" else quick.value(statement)[0]
    except Unfit:
        return [*_loads(statement, slots), *lines]
    return [*_loads(statement, slots), *_either(quick, [f"return {text}" if gives else text], lines)]


class _Assignment:
    def __init__(self, statement: Assignment, slots: Slots) -> None:
        self._statement = statement
        self._slots = slots
        self._target = slots.of(statement.target)
        self._entry = f"e{self._target}"
        self._sets = statement.operator in (":=", "=")

    def lines(self, gives: str) -> list[str]:
        value, entry = self._statement.value, self._entry
        made = f"board.declare(s{self._target})"
        found = f"board.entry(s{self._target}) or {made}" if self._statement.operator == ":=" else ""
        lines = _loads(value, self._slots)
        found = found or f"existing(board, s{self._target})"
        lines += [f"{entry} = entries[{self._target}]"]
        lines += [f"if not {entry}.alive:", f" {entry} = entries[{self._target}] = {found}"]
        lines += [f"old = {entry}.value"]
        if self._sets and isinstance(value, Literal) and not isinstance(value.value, str):
            lines += self._literal(self._slots.of(value))
        else:
            lines += self._computed(value)
        return [*lines, f"{entry}.sequence += 1", *_given(f"{entry}.value", gives)]

    def _computed(self, value: Expression) -> list[str]:
        general, quick = General(value, self._slots), Quick(self._slots)
        lines = [*general.needs, f"value = {general.text}", *self._any()]
        try:
            return _either(quick, self._quick(quick, value), lines)
        except Unfit:
            return lines

    def _quick(self, quick: Quick, value: Expression) -> list[str]:
        """Assign a number."""
        if not self._sets:
            if self._statement.operator == "/=":
                raise Unfit
            return [f"value = {quick.real(value)}", *self._number(f"(old {self._statement.operator[0]} value)")]
        if isinstance(value, Name):
            raise Unfit  # the general form is as quick
        text, known = quick.value(value)
        return [f"value = {text}", *(self._number("value") if known == FLOAT else self._any())]

    def _number(self, new: str) -> list[str]:
        """Store a float in an entry that holds a float, or an int."""
        whole = f"(new := {new}).is_integer() and -BITS < new < BITS"
        return [
            "if old.__class__ is float:",
            f" {self._entry}.value = {new}",
            f"elif old.__class__ is int and {whole}:",
            f" {self._entry}.value = int(new)",
            *self._otherwise(),
        ]

    def _any(self) -> list[str]:
        """Store a value."""
        if not self._sets:
            return [self._assigned()]
        return ["if old.__class__ is value.__class__:", f" {self._entry}.value = value", *self._otherwise()]

    def _literal(self, slot: int) -> list[str]:
        """Store a number that is known."""
        lines = [f"value = s{slot}", "if old.__class__ is value.__class__:", f" {self._entry}.value = value"]
        return [*lines, "elif old.__class__ is float:", f" {self._entry}.value = f{slot}", *self._otherwise()]

    def _otherwise(self) -> list[str]:
        return ["else:", f" {self._assigned()}"]

    def _assigned(self) -> str:
        operator = self._statement.operator
        return f"{self._entry}.value = assigned(board, s{self._target}, {self._entry}, {operator!r}, value)"


class General:
    """The general form of an expression.

    Args:
        expression: The expression.
        slots: The slots of the script.

    Attributes:
        text: Its source.
        needs: Lines before it, which see to it that its keys have values.
    """

    def __init__(self, expression: Expression, slots: Slots) -> None:
        inside = list(walk(expression))
        self._slots = slots
        self._fresh = _assigns(expression)
        # Some operands may not be computed at all; only those that are need a value.
        self._lazy = any(isinstance(e, Conditional) or _is_chain(e) for e in inside)
        self._temporaries = 0
        self.text = self._value(expression)
        self.needs: list[str] = []
        if not self._lazy and not self._fresh:
            for i in dict.fromkeys(slots.keys(expression)):
                self.needs += [f"if v{i} is None:", f" known(v{i}, s{i})"]

    def _value(self, expression: Expression) -> str:
        match expression:
            case Literal():
                return f"s{self._slots.of(expression)}"
            case Name():
                return self._name(expression)
            case Unary():
                return f"negated({expression.operator!r}, {self._value(expression.operand)})"
            case Binary():
                operators, operands = _chain(expression)
                return f"folded({tuple(operators)!r}, {', '.join(map(self._value, operands))})"
            case Comparison():
                return self._comparison(expression)
            case Conditional():
                condition, then = self._value(expression.condition), self._value(expression.then)
                return f"({then} if chosen({condition}) else {self._value(expression.otherwise)})"
            case Assignment():
                slot = self._slots.of(expression.target)
                return f"assign(board, s{slot}, {expression.operator!r}, {self._value(expression.value)})"

    def _name(self, name: Name) -> str:
        slot = self._slots.of(name)
        if slot in self._slots.enums:
            return f"f{slot}"
        if self._fresh:  # an assignment within may have changed it
            return f"known((board.entry(s{slot}) or NONE).value, s{slot})"
        return f"known(v{slot}, s{slot})" if self._lazy else f"v{slot}"

    def _comparison(self, expression: Comparison) -> str:
        operands = [self._value(e) for e in expression.operands]
        pairs, left = [], operands[0]
        for operator, right in zip(expression.operators, operands[1:], strict=True):
            after = right
            if right is not operands[-1]:
                after, self._temporaries = f"t{self._temporaries}", self._temporaries + 1
                right = f"({after} := {right})"
            pairs.append(f"compared({operator!r}, {left}, {right}, board.enums)")
            left = after
        return f"(1.0 if {' and '.join(pairs)} else 0.0)"


def _chain(expression: Binary) -> tuple[list[str], list[Expression]]:
    """The operators and operands of a chain such as `a + b - c`, which may be longer than Python nests."""
    operators, operands = list[str](), list[Expression]()
    left: Expression = expression
    while isinstance(left, Binary):
        operators.append(left.operator)
        operands.append(left.right)
        left = left.left
    return operators[::-1], [left, *operands[::-1]]


def _is_chain(expression: Expression) -> bool:
    return isinstance(expression, Comparison) and len(expression.operands) > 2


def _assigns(expression: Expression) -> bool:
    return any(isinstance(e, Assignment) for e in walk(expression))


def _loads(expression: Expression, slots: Slots) -> list[str]:
    """Look up the keys that an expression reads; one that assigns looks them up as it goes."""
    lines: list[str] = []
    for i in () if _assigns(expression) else dict.fromkeys(slots.keys(expression)):
        lines += [f"e{i} = entries[{i}]", f"if not e{i}.alive:", f" e{i} = entries[{i}] = board.entry(s{i}) or NONE"]
        lines += [f"v{i} = e{i}.value"]
    return lines


def _either(quick: Quick, lines: list[str], otherwise: list[str]) -> list[str]:
    """The quick lines where they may be used."""
    checks = quick.checks()
    if not checks:
        return lines
    return [f"if {checks}:", *(f" {line}" for line in lines), "else:", *(f" {line}" for line in otherwise)]


def _given(text: str, gives: str) -> list[str]:
    return [f"return truth({text})" if gives == "truth" else f"return {text}" if gives else text]
