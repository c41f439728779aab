"""Parser of scripts, by precedence climbing; BehaviorTree.CPP 4.10 has the same levels."""

from __future__ import annotations

from ...errors import Fault
from .error import ScriptError, short
from .lexer import Token, tokens
from .syntax import (
    Assignment,
    Binary,
    Comparison,
    Conditional,
    Expression,
    Literal,
    Name,
    Unary,
)

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
