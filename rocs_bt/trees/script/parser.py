"""Parser of scripts: tokens, syntax tree, and precedence climbing with the levels of BehaviorTree.CPP 4.10.

In all expressions, `at` is the position in the script, counted from 0.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

from ...base.errors import Fault
from ..error import TreeError


class ScriptError(TreeError):
    """Raised if a script cannot be parsed, or fails when it runs.

    Args:
        text: The script.
        at: Position in the script, counted from 0.
        faults: Descriptions of the faults.
    """

    def __init__(self, text: str, at: int, *faults: Fault | str) -> None:
        self.text = text
        self.column = at
        super().__init__(*faults)


def short(text: str) -> str:
    """Script for a message; a long script is truncated."""
    return text if len(text) <= 80 else text[:77] + "..."


Scalar = float | int | str
"""Values of scripts; truth is a number, 1.0 or 0.0."""


@dataclass(frozen=True)
class Literal:
    """Number, string, `true` or `false`."""

    value: Scalar
    at: int


@dataclass(frozen=True)
class Name:
    """Enum name or blackboard key; `@key` is a key of the root blackboard."""

    name: str
    at: int


@dataclass(frozen=True)
class Unary:
    """`-`, `~` or `!` with its operand."""

    operator: str
    operand: Expression
    at: int


@dataclass(frozen=True)
class Binary:
    """Arithmetic, bitwise, logical or concatenation operator with its two operands."""

    operator: str
    left: Expression
    right: Expression
    at: int


@dataclass(frozen=True)
class Comparison:
    """Chain such as `1 < x <= 3`; there is one more operand than operators."""

    operators: tuple[str, ...]
    operands: tuple[Expression, ...]
    at: int


@dataclass(frozen=True)
class Conditional:
    """`condition ? then : otherwise`."""

    condition: Expression
    then: Expression
    otherwise: Expression
    at: int


@dataclass(frozen=True)
class Assignment:
    """`name := value`, which creates a key, or one of `= += -= *= /=`, which need an existing key."""

    operator: str
    target: Name
    value: Expression
    at: int


Expression = Literal | Name | Unary | Binary | Comparison | Conditional | Assignment


def walk(expression: Expression) -> Iterator[Expression]:
    """An expression and all its subexpressions, from left to right."""
    yield expression
    for part in parts(expression):
        yield from walk(part)


def parts(expression: Expression) -> tuple[Expression, ...]:
    """Direct subexpressions, from left to right."""
    match expression:
        case Unary():
            return (expression.operand,)
        case Binary():
            return (expression.left, expression.right)
        case Comparison():
            return expression.operands
        case Conditional():
            return (expression.condition, expression.then, expression.otherwise)
        case Assignment():
            return (expression.target, expression.value)
        case _:
            return ()


_TOKEN = re.compile(
    r"""
    (?P<space>(?:\s|\\\r?\n)+)
  | (?P<number>0[xX][0-9a-fA-F]+|\d+(?:\.\d+)?(?:[eE][+-]?\d+)?)(?P<suffix>(?:\.(?!\.)|[A-Za-z_])?)
  | (?P<string>'[^']*'|"[^"]*")
  | (?P<name>[^\W\d]\w*|@\w*)
  | (?P<operator>:=|\+=|-=|\*=|/=|==|!=|<=|>=|&&|\|\||\.\.|[-+*/=<>&|^~!?:;()])
    """,
    re.VERBOSE,
)


class Token(NamedTuple):
    """Token of a script."""

    kind: str  # `number`, `string`, `name`, `operator` or `end`
    text: str
    at: int  # position of its first character, counted from 0


def tokens(text: str) -> list[Token]:
    """Tokens of a script; the last one has the kind `end`.

    Raises:
        ScriptError: The text contains something that is not a token.
    """
    found, at = [], 0
    while at < len(text):
        match = _TOKEN.match(text, at)
        if match is None:
            hint = "Close the string with the same quote." if text[at] in "'\"" else ""
            raise ScriptError(text, at, Fault(f"unexpected character {text[at]!r}.", hint=hint))
        if match["suffix"]:
            hint = "Write 3.0 rather than 3., and begin names with a letter."
            raise ScriptError(text, at, Fault(f"{match['number'] + match['suffix']!r} is not a number.", hint=hint))
        if match.lastgroup != "space":
            kind = "number" if match["number"] else str(match.lastgroup)
            found.append(Token(kind, match[0], at))
        at = match.end()
    return [*found, Token("end", "", len(text))]


ASSIGNMENTS = (":=", "=", "+=", "-=", "*=", "/=")
COMPARISONS = ("==", "!=", "<", ">", "<=", ">=")

_LEVELS = (("||",), ("&&",), COMPARISONS, ("|", "^"), ("&",), ("+", "-", ".."), ("*", "/"))
"""Binary operators from lowest to highest precedence; each level is left associative, comparisons chain."""

MAX_DEPTH = 40
"""Maximum nesting of parentheses and prefixes, which prevents stack overflow; hand-written scripts are far below it."""

MAX_TERMS = 200
"""Maximum number of operators in a statement."""

MAX_LENGTH = 10_000
"""Maximum number of characters of a script."""


MAX_DIGITS = 400
"""Maximum number of characters of a number."""


def parse_statements(text: str) -> tuple[Expression, ...]:
    """Parse a script to its statements, in order.

    Raises:
        ScriptError: The text is not a valid script; the error contains the position.
    """
    if len(text) > MAX_LENGTH:
        raise ScriptError(text, 0, Fault(f"the script has {len(text)} characters; the maximum is {MAX_LENGTH}."))
    parser = _Parser(text)
    statements: list[Expression] = []
    while True:
        while parser.accept(";"):
            pass
        if parser.token.kind == "end":
            return tuple(statements)
        parser.begin()
        statements.append(parser.statement())


class _Parser:
    def __init__(self, text: str) -> None:
        self._text = text
        self._tokens = tokens(text)
        self._next = 0
        self._depth = 0
        self._terms = 0

    @property
    def token(self) -> Token:
        return self._tokens[self._next]

    def begin(self) -> None:
        """Begin a statement: reset the count of operators."""
        self._terms = 0

    def accept(self, *operators: str) -> Token | None:
        token = self.token
        if token.kind != "operator" or token.text not in operators:
            return None
        self._terms += 1
        if self._terms > MAX_TERMS:
            raise self._wrong(f"a statement of more than {MAX_TERMS} operators", token)
        self._next += 1
        return token

    def statement(self) -> Expression:
        left = self._conditional()
        operator = self.accept(*ASSIGNMENTS)
        if operator is None:
            return left
        if not isinstance(left, Name):
            raise self._wrong("only a name can be assigned to", operator)
        value = self._conditional()
        if (again := self.token).kind == "operator" and again.text in ASSIGNMENTS:
            raise self._wrong("assignments cannot be chained", again)
        return Assignment(operator.text, left, value, operator.at)

    def _conditional(self) -> Expression:
        condition = self._binary(0)
        mark = self.accept("?")
        if mark is None:
            return condition
        then = self._nested()
        if not self.accept(":"):
            raise self._wrong("a ':' is missing after '?'", self.token)
        otherwise = self._binary(0)
        if (again := self.token).kind == "operator" and again.text == "?":
            raise self._wrong("'?' cannot be chained without parentheses", again)
        return Conditional(condition, then, otherwise, mark.at)

    def _nested(self) -> Expression:
        self._depth += 1
        if self._depth > MAX_DEPTH:
            raise self._wrong(f"more than {MAX_DEPTH} nested levels", self.token)
        inner = self.statement()
        self._depth -= 1
        return inner

    def _binary(self, level: int) -> Expression:
        if level == len(_LEVELS):
            return self._prefix()
        if _LEVELS[level] is COMPARISONS:
            return self._comparison(level)
        left = self._binary(level + 1)
        while operator := self.accept(*_LEVELS[level]):
            left = Binary(operator.text, left, self._binary(level + 1), operator.at)
        return left

    def _comparison(self, level: int) -> Expression:
        operands, operators = [self._binary(level + 1)], list[str]()
        at = self.token.at
        while operator := self.accept(*COMPARISONS):
            operators.append(operator.text)
            operands.append(self._binary(level + 1))
        return Comparison(tuple(operators), tuple(operands), at) if operators else operands[0]

    def _prefix(self) -> Expression:
        prefixes = []
        while operator := self.accept("-", "~", "!"):
            prefixes.append(operator)
            if len(prefixes) > MAX_DEPTH:
                raise self._wrong(f"more than {MAX_DEPTH} nested levels", operator)
        # BehaviorTree.CPP reads a plus sign as part of a number.
        plus = self.accept("+")
        if plus and self.token.kind != "number":
            raise self._wrong("a '+' prefix is allowed only before a number", plus)
        operand = self._atom()
        for operator in reversed(prefixes):
            operand = Unary(operator.text, operand, operator.at)
        return operand

    def _atom(self) -> Expression:
        token = self.token
        if self.accept("("):
            inner = self._nested()
            if not self.accept(")"):
                raise self._wrong("a ')' is missing", self.token)
            return inner
        self._next += token.kind != "end"
        if token.kind == "number":
            if len(token.text) > MAX_DIGITS:
                raise self._wrong(f"a number of more than {MAX_DIGITS} characters", token)
            return Literal(number_of(token.text), token.at)
        if token.kind == "string":
            return Literal(token.text[1:-1], token.at)
        if token.kind == "name":
            if token.text in ("true", "false"):
                return Literal(int(token.text == "true"), token.at)
            if token.text == "@":
                raise self._wrong("'@' names no key", token)
            return Name(token.text, token.at)
        raise self._wrong("a value is missing", token)

    def _wrong(self, what: str, token: Token) -> ScriptError:
        found = f"before '{token.text}'" if token.text else "at the end"
        return ScriptError(
            self._text,
            token.at,
            Fault(f"in the script '{short(self._text)}': {what} {found} (character {token.at + 1})."),
        )


def number_of(text: str) -> int | float:
    """Convert the text of a number: to an integer if it has neither point nor exponent, else to a float."""
    if text.isdigit():
        return int(text)
    return int(text, 16) if text[:2] in ("0x", "0X") else float(text)
