"""Parser of scripts: tokens, the syntax tree, and precedence climbing with the levels of BehaviorTree.CPP 4.10."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

from ...errors import Fault
from ..error import TreeError


class ScriptError(TreeError):
    """A script that cannot be read, or that could not go on.

    Args:
        text: The script.
        at: Where in it, counted from 0.
        fault: What is wrong.
    """

    def __init__(self, text: str, at: int, *faults: Fault | str) -> None:
        self.text = text
        self.column = at
        super().__init__(*faults)


def short(text: str) -> str:
    """A script in a message: the beginning of a long one."""
    return text if len(text) <= 80 else text[:77] + "..."


Scalar = float | int | str
"""What a script computes with; truth is a number, 1.0 or 0.0."""


@dataclass(frozen=True)
class Literal:
    """A number, a string, `true` or `false`."""

    value: Scalar
    at: int


@dataclass(frozen=True)
class Name:
    """An enum or a key of the board; `@key` is one of the root board."""

    name: str
    at: int


@dataclass(frozen=True)
class Unary:
    """`-`, `~` or `!` and its operand."""

    operator: str
    operand: Expression
    at: int


@dataclass(frozen=True)
class Binary:
    """An arithmetic, bitwise, logical or joining operator between two operands."""

    operator: str
    left: Expression
    right: Expression
    at: int


@dataclass(frozen=True)
class Comparison:
    """A chain such as `1 < x <= 3`: one operand more than operators."""

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
    """`name := value`, which creates a key, or one of `= += -= *= /=`, which need one."""

    operator: str
    target: Name
    value: Expression
    at: int


Expression = Literal | Name | Unary | Binary | Comparison | Conditional | Assignment


def walk(expression: Expression) -> Iterator[Expression]:
    """An expression and all in it, from left to right."""
    yield expression
    for part in parts(expression):
        yield from walk(part)


def parts(expression: Expression) -> tuple[Expression, ...]:
    """What an expression is directly made of, from left to right."""
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
    """A piece of a script.

    Attributes:
        kind: `number`, `string`, `name`, `operator` or `end`.
        text: As it stands.
        at: Where it begins, counted from 0.
    """

    kind: str
    text: str
    at: int


def tokens(text: str) -> list[Token]:
    """The tokens of a script, the last one of kind `end`.

    Raises:
        ScriptError: At what is no token.
    """
    found, at = [], 0
    while at < len(text):
        match = _TOKEN.match(text, at)
        if match is None:
            hint = "Strings end with the quote that they begin with." if text[at] in "'\"" else ""
            raise ScriptError(text, at, Fault(f"{text[at]!r} begins nothing that scripts know.", hint=hint))
        if match["suffix"]:
            hint = "Write 3.0 rather than 3., and begin names with a letter."
            raise ScriptError(text, at, Fault(f"{match['number'] + match['suffix']!r} is no number.", hint=hint))
        if match.lastgroup != "space":
            kind = "number" if match["number"] else str(match.lastgroup)
            found.append(Token(kind, match[0], at))
        at = match.end()
    return [*found, Token("end", "", len(text))]


ASSIGNMENTS = (":=", "=", "+=", "-=", "*=", "/=")
COMPARISONS = ("==", "!=", "<", ">", "<=", ">=")

_LEVELS = (("||",), ("&&",), COMPARISONS, ("|", "^"), ("&",), ("+", "-", ".."), ("*", "/"))
"""Binary operators, those that bind least first; each level is left associative, comparisons chain."""

MAX_DEPTH = 40
"""How deep parentheses and prefixes may nest; deeper ones are no script that a person wrote."""

MAX_TERMS = 200
"""How many operators a statement may have."""

MAX_LENGTH = 10_000
"""How many characters a script may have."""


MAX_DIGITS = 400
"""How many characters a number may have."""


def parse_statements(text: str) -> tuple[Expression, ...]:
    """The statements of a script, in order.

    Raises:
        ScriptError: The text is no script; the error has the place.
    """
    if len(text) > MAX_LENGTH:
        raise ScriptError(text, 0, Fault(f"a script of {len(text)} characters; at most {MAX_LENGTH} are read."))
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
        """A statement begins."""
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
            raise self._wrong(f"this nests deeper than {MAX_DEPTH}", self.token)
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
                raise self._wrong(f"this nests deeper than {MAX_DEPTH}", operator)
        # BehaviorTree.CPP reads a plus sign as part of a number.
        plus = self.accept("+")
        if plus and self.token.kind != "number":
            raise self._wrong("a '+' may stand only before a number", plus)
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
    """The value of a number's text: an integer where it has neither point nor exponent."""
    if text.isdigit():
        return int(text)
    return int(text, 16) if text[:2] in ("0x", "0X") else float(text)
