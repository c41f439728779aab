"""The quick form of an expression: plain Python, for keys that hold what most keys hold (see `writer`)."""

from __future__ import annotations

from typing import Final

from .form import Slots
from .parser import Binary, Comparison, Conditional, Expression, Literal, Name, Unary

FLOAT, RAW, TRUTH, TEXT = "float", "raw", "truth", "text"
"""What is known of a value: a float; a float or an int; true or false; a string."""

# The negated forms are those of the C++ source; with NaN they are not the same as the plain ones.
_COMPARE: Final = {
    "==": "-E <= {0} - {1} <= E",
    "!=": "not -E <= {0} - {1} <= E",
    "<": "not {0} >= {1}",
    ">": "not {0} <= {1}",
    "<=": "not {0} > {1}",
    ">=": "not {0} < {1}",
}
_COMPARE_TEXT: Final = {**_COMPARE, "==": "{0} == {1}", "!=": "{0} != {1}"}
_CHAINS: Final = {"+": "+-", "-": "+-", "*": "*", "/": "", "&&": "&&", "||": "||"}
"""The operators on the left that need no parentheses: chains may be longer than Python nests."""


class Unfit(Exception):
    """An expression that has no quick form."""


class Quick:
    """Writes expressions, and collects what their keys must hold.

    Args:
        slots: The slots of the script.
    """

    def __init__(self, slots: Slots) -> None:
        self._slots = slots
        self._numbers: set[int] = set()
        self._truths: set[int] = set()
        self._texts: set[int] = set()

    def checks(self) -> str:
        """The condition under which what was written may be used; empty if always."""
        numbers = (f"(v{i}.__class__ is float or v{i}.__class__ is int)" for i in sorted(self._numbers))
        truths = (
            f"(v{i}.__class__ is float or v{i}.__class__ is bool or v{i}.__class__ is int and 0 <= v{i} <= 1)"
            for i in sorted(self._truths)
        )
        texts = (f"v{i}.__class__ is str" for i in sorted(self._texts))
        return " and ".join([*numbers, *truths, *texts])

    def truth(self, expression: Expression) -> str:
        """The source of a value that is asked as a condition.

        Raises:
            Unfit: It has no quick form.
        """
        if isinstance(expression, Name) and not self._slots.is_enum(expression):
            self._truths.add(self._slots.of(expression))
            return f"(v{self._slots.of(expression)} != 0)"
        text, known = self._value(expression)
        if known in (RAW, TEXT):
            raise Unfit
        return text if known == TRUTH else f"({text} != 0)"

    def value(self, expression: Expression) -> tuple[str, str]:
        """The source of a value, and whether it is FLOAT, RAW or TEXT.

        Raises:
            Unfit: It has no quick form.
        """
        text, known = self._value(expression)
        return (f"(1.0 if {text} else 0.0)", FLOAT) if known == TRUTH else (text, known)

    def real(self, expression: Expression) -> str:
        """The source of a value as a float.

        Raises:
            Unfit: It has no quick form.
        """
        text, known = self._operand(expression)
        if known == FLOAT:
            return text
        return f"({text} if {text}.__class__ is float else float({text}))" if text[0] == "v" else f"float({text})"

    def _value(self, expression: Expression) -> tuple[str, str]:
        match expression:
            case Literal():
                return f"s{self._slots.of(expression)}", TEXT if isinstance(expression.value, str) else RAW
            case Name():
                return self._name(expression)
            case Unary("-"):
                return f"(-{self.real(expression.operand)})", FLOAT
            case Unary("!"):
                text, known = self._value(expression.operand)
                if known != TEXT:
                    return f"(not {text})", TRUTH
            case Binary("&&" | "||"):
                operator = "and" if expression.operator == "&&" else "or"
                left = self._left(expression, self.truth(expression.left))
                return f"({left} {operator} {self.truth(expression.right)})", TRUTH
            case Binary("..") | Binary("+", Literal(str())) | Binary("+", _, Literal(str())):
                return self._joined(expression), TEXT
            case Binary("+" | "-" | "*" | "/"):
                return self._arithmetic(expression), FLOAT
            case Comparison():
                return self._comparison(expression), TRUTH
            case Conditional():
                return self._conditional(expression)
        raise Unfit

    def _name(self, name: Name) -> tuple[str, str]:
        slot = self._slots.of(name)
        if slot in self._slots.enums:
            return f"f{slot}", FLOAT
        self._numbers.add(slot)
        return f"v{slot}", RAW

    def _operand(self, expression: Expression) -> tuple[str, str]:
        """A number as an operand: literals are floats."""
        if isinstance(expression, Literal) and not isinstance(expression.value, str):
            return f"f{self._slots.of(expression)}", FLOAT
        text, known = self.value(expression)
        if known == TEXT:
            raise Unfit
        return text, known

    def _text(self, expression: Expression) -> str:
        """The source of a string."""
        if isinstance(expression, Name) and not self._slots.is_enum(expression):
            self._texts.add(self._slots.of(expression))
            return f"v{self._slots.of(expression)}"
        text, known = self._value(expression)
        if known != TEXT:
            raise Unfit
        return text

    def _joined(self, expression: Binary) -> str:
        left, right = self._text(expression.left), self._text(expression.right)
        if isinstance(expression.left, Binary):
            left = left[1:-1]
        return f"({left} + {right})"

    def _left(self, expression: Binary, text: str) -> str:
        left = expression.left
        chained = isinstance(left, Binary) and left.operator in _CHAINS[expression.operator]
        return text[1:-1] if chained else text

    def _arithmetic(self, expression: Binary) -> str:
        (left, known), (right, also) = self._operand(expression.left), self._operand(expression.right)
        if expression.operator == "/":
            if isinstance(expression.left, Binary) and expression.left.operator == "/":
                return f"{left[:-1]}, {right})"
            return f"quotient({left}, {right})"
        if known == also == RAW:  # the sum of two ints would be an int
            left = self.real(expression.left)
        return f"({self._left(expression, left)} {expression.operator} {right})"

    def _comparison(self, expression: Comparison) -> str:
        if not all(isinstance(e, Name | Literal) for e in expression.operands[1:-1]):
            raise Unfit  # it would be computed twice
        texts = any(isinstance(e, Literal) and isinstance(e.value, str) for e in expression.operands)
        compare = _COMPARE_TEXT if texts else _COMPARE
        operands = [self._text(e) if texts else self._operand(e)[0] for e in expression.operands]
        pairs = zip(expression.operators, operands, operands[1:], strict=False)
        return "(" + " and ".join(f"({compare[o].format(a, b)})" for o, a, b in pairs) + ")"

    def _conditional(self, expression: Conditional) -> tuple[str, str]:
        condition = self._value(expression.condition)[0]
        (then, known), (otherwise, also) = self.value(expression.then), self.value(expression.otherwise)
        if TEXT in (known, also) and known != also:
            raise Unfit
        return f"({then} if {condition} else {otherwise})", known if known == also else RAW
