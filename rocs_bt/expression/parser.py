"""Parser of expressions: from text to a typed tree.

The text is never executed. Python's module `ast` parses its structure; then `_Reader` accepts a few types of syntax
and rejects all others (attributes, calls of unlisted functions, strings, lambdas, comprehensions ...).
"""

from __future__ import annotations

import ast
import math
import re
import warnings
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

from ..base.errors import Fault, InputError, did_you_mean, unknown
from ..base.signal import Signal
from ..base.units import NONE, TIME, Quantity
from .absent import absent_name
from .argument_kinds import Misuse, same_dimension, same_size
from .environment import Environment
from .evaluator import Expression, evaluate
from .node import TRUTH, Kind, Node
from .operators import FUNCTIONS
from .quantities import Folded, fold_quantities

MAX_LENGTH = 1000  # characters
MAX_DEPTH = 40  # nested operations
MAX_SIZE = 500  # operations
MIN_WINDOW = 1e-3  # [s]
MAX_WINDOW = 3600.0  # [s]

_ARITHMETIC = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}
_WORD = re.compile(r"[A-Za-z_]\w*")
_KEYWORDS = frozenset({"and", "or", "not", "if", "else", "True", "False"})
_SIGNS = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!="}
_AHEAD = "A requirement may begin with 'always', and contain 'implies' and 'within 0.2 s'. "
_HELP = "Allowed: numbers with units, signals, + - * /, comparisons, and, or, not, a if b else c, functions."


def parse(text: str, environment: Environment, ahead: bool = False) -> Node:
    """Parse an expression to a typed tree.

    Args:
        text: Expression such as `min(front) < stop_distance + 0.10 m and speed > 0.05 m/s`.
        environment: Meaning of the names in the expression.
        ahead: Whether `within` and `always`, which refer to later samples, are allowed, as in requirements.

    Raises:
        InputError: The text is not an expression of the language, has unknown names, mixes dimensions or kinds, or is
            too long or too deeply nested. Each fault has its column in the text, counted from 1.
    """
    if len(text) > MAX_LENGTH:
        raise InputError(Fault(f"an expression has at most {MAX_LENGTH} characters, found {len(text)}."))
    if not text.strip():
        raise InputError(Fault("the expression is empty.", hint=_HELP))
    folded = fold_quantities(text, texts=environment.forms is not None)
    if folded.always and not ahead:
        raise InputError(Fault("'always' is allowed only in requirements.", column=1 + text.index("always")))
    indent = len(text) - len(folded.text.lstrip())
    help_text = (_AHEAD if ahead else "") + _HELP
    node = _Reader(text, indent, folded, environment, ahead).read(_syntax(folded.text[indent:], indent, help_text))
    _bounded(node)
    return node


def _bounded(node: Node) -> None:
    """Reject an expression that its aliases make too large, before other functions traverse it."""
    depth, operations = node.extent
    if depth > MAX_DEPTH:
        raise InputError(Fault(f"an expression is at most {MAX_DEPTH} deep, found {depth} with its aliases."))
    if operations > MAX_SIZE:
        message = f"an expression has at most {MAX_SIZE} operations, found {operations} with its aliases."
        raise InputError(Fault(message))


def _syntax(folded: str, indent: int, hint: str) -> ast.expr:
    deep = max(_depths(folded), default=0)
    if deep > MAX_DEPTH:
        raise InputError(Fault(f"an expression is at most {MAX_DEPTH} deep, found {deep} open brackets."))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of Python's own compiler, such as an invalid escape in a text
            return ast.parse(folded, mode="eval").body
    except SyntaxError as error:
        column = indent + max(1, error.offset or 1)
        message = f"not an expression: {error.msg.rstrip('.')}."
        raise InputError(Fault(message, column=column, hint=hint)) from error
    except (ValueError, RecursionError, MemoryError) as error:
        raise InputError(Fault(f"an expression is at most {MAX_DEPTH} deep.")) from error


def _depths(text: str) -> list[int]:
    depth, found = 0, []
    for bracket in re.findall(r"[()\[\]]", text):
        depth += 1 if bracket in "([" else -1
        found.append(depth)
    return found


def _span(signal: Signal) -> float:
    low, high = signal.bounds
    return high - low


def compile_expression(text: str, environment: Environment) -> Expression:
    """Parse and compile an expression with a single value.

    Raises:
        InputError: See `parse`.
    """
    return Expression(parse(text, environment))


class _Reader:
    """Converter from Python's syntax tree to a typed tree."""

    def __init__(self, text: str, indent: int, folded: Folded, environment: Environment, ahead: bool) -> None:
        self._text = text
        self._ahead = ahead
        self._indent = indent
        self._folded = folded
        self._names = environment
        self._depth = 0

    def read(self, tree: ast.expr) -> Node:
        """Convert a syntax tree to a typed tree; all unknown names are reported together."""
        # Fast path: if all words are known, the tree need not be searched for unknown names.
        words = {*_WORD.findall(self._folded.text)}
        if self._names.forms is not None or all(self._known(word) or word in _KEYWORDS for word in words):
            return self._node(tree)
        called = {id(node.func) for node in ast.walk(tree) if isinstance(node, ast.Call)}
        faults = [
            self._fault(
                node,
                unknown("function", node.id, FUNCTIONS, "The language")
                if id(node) in called
                else absent_name(node.id, self._names.names),
            )
            for node in ast.walk(tree)
            if isinstance(node, ast.Name) and not self._known(node.id)
        ]
        if faults:
            raise InputError(*faults)
        return self._node(tree)

    def _known(self, name: str) -> bool:
        return name in self._names.signals or name in self._names.aliases or name in FUNCTIONS or name == "inf"

    def _node(self, tree: ast.expr) -> Node:
        self._depth += 1
        if self._depth > MAX_DEPTH:
            raise self._refusal(tree, f"an expression is at most {MAX_DEPTH} deep.")
        try:
            return self._whitelist(tree)
        except Misuse as error:
            raise self._refusal(tree, f"'{self._source(tree)}': {error}", hint=self._bare_hint(tree)) from error
        finally:
            self._depth -= 1

    def _whitelist(self, tree: ast.expr) -> Node:
        if self._names.forms is not None and (found := self._names.forms.read(tree, self._at)) is not None:
            return replace(found, text=self._source(tree), column=self._at(tree) + 1)
        match tree:
            case ast.Constant():
                return self._constant(tree)
            case ast.Name():
                return self._name(tree)
            case ast.Subscript():
                return self._index(tree)
            case ast.UnaryOp():
                return self._unary(tree)
            case ast.BinOp():
                return self._binary(tree)
            case ast.Compare():
                return self._compare(tree)
            case ast.BoolOp():
                return self._logic(tree)
            case ast.IfExp():
                return self._choice(tree)
            case ast.Call():
                return self._call(tree)
            case ast.List():
                return self._vector(tree)
        raise self._refusal(tree, f"'{self._source(tree)}' is not allowed in an expression.", hint=_HELP)

    def _at(self, tree: ast.expr) -> int:
        """Offset of a subexpression in the text, counted from 0."""
        return tree.col_offset + self._indent

    def _made(self, tree: ast.expr, op: str, kind: Kind, args: tuple[Node, ...] = (), **more: Any) -> Node:
        return Node(op, kind, args, **more, text=self._source(tree), column=self._at(tree) + 1)

    def _constant(self, tree: ast.Constant) -> Node:
        if isinstance(tree.value, bool):
            return self._made(tree, "truth", TRUTH, value=tree.value)
        if not isinstance(tree.value, (int, float)):
            raise self._refusal(tree, f"'{self._source(tree)}' is not allowed in an expression.", hint=_HELP)
        return self._number(tree, self._finite(tree))

    def _finite(self, tree: ast.Constant) -> float:
        try:
            value = float(tree.value)  # type: ignore[arg-type]  # a number, checked by _constant
        except OverflowError:
            value = math.inf
        if math.isinf(value):
            raise self._refusal(
                tree, f"the number '{self._source(tree)}' is too large.", hint="Write inf for infinity."
            )
        return value

    def _number(self, tree: ast.expr, value: float) -> Node:
        unit = self._folded.units.get(self._at(tree), Quantity(1.0, NONE))
        return self._made(tree, "number", Kind(unit.dimension), value=value * unit.value)

    def _name(self, tree: ast.Name) -> Node:
        name = tree.id
        if name == "inf":
            return self._number(tree, math.inf)
        if name in self._names.aliases:
            meant = self._names.aliases[name]
            return replace(meant, text=name, column=self._at(tree) + 1)
        if name not in self._names.signals:
            raise self._refusal(tree, f"'{name}' is a function: write {FUNCTIONS[name].usage}.")
        signal, start = self._names.signals[name], self._names.offsets[name]
        kind = Kind(signal.dimension, 0 if signal.size == 1 else signal.size)
        return self._made(tree, "read", kind, start=start, stop=start + signal.size, span=_span(signal))

    def _index(self, tree: ast.Subscript) -> Node:
        base = self._node(tree.value)
        if base.op != "read":
            raise self._refusal(tree, f"only signals and their slices have an index, but {base.text} is computed.")
        size = base.stop - base.start
        if isinstance(tree.slice, ast.Slice):
            return self._slice(tree, tree.slice, base)
        at = self._whole(tree.slice)
        if not -size <= at < size:
            raise self._refusal(tree, f"{base.text} has {size} values, so there is no {base.text}[{at}].")
        return self._values(tree, base.start + at % size, base.start + at % size + 1, single=True)

    def _slice(self, tree: ast.Subscript, part: ast.Slice, base: Node) -> Node:
        size = base.stop - base.start
        if part.step is not None:
            raise self._refusal(tree, "a slice has no step.")
        low = 0 if part.lower is None else self._whole(part.lower)
        high = size if part.upper is None else self._whole(part.upper)
        low, high = (low + size if low < 0 else low), (high + size if high < 0 else high)
        if not 0 <= low < high <= size:
            raise self._refusal(tree, f"'{self._source(tree)}' is empty or beyond the {size} values of {base.text}.")
        return self._values(tree, base.start + low, base.start + high, single=False)

    def _values(self, tree: ast.expr, start: int, stop: int, single: bool) -> Node:
        name = next(n for n, at in self._names.offsets.items() if at <= start < at + self._names.signals[n].size)
        declared, offset = self._names.signals[name].dimensions, self._names.offsets[name]
        dimensions = set(declared if len(declared) == 1 else declared[start - offset : stop - offset])
        shared = dimensions.pop() if len(dimensions) == 1 else None
        kind, span = Kind(shared, 0 if single else stop - start), _span(self._names.signals[name])
        return self._made(tree, "read", kind, start=start, stop=stop, span=span)

    def _whole(self, tree: ast.expr) -> int:
        sign, inner = 1, tree
        if isinstance(tree, ast.UnaryOp) and isinstance(tree.op, ast.USub):
            sign, inner = -1, tree.operand
        if isinstance(inner, ast.Constant) and type(inner.value) is int:
            return sign * inner.value
        raise self._refusal(tree, f"an index is a whole number, found '{self._source(tree)}'.")

    def _unary(self, tree: ast.UnaryOp) -> Node:
        arg = self._node(tree.operand)
        if isinstance(tree.op, ast.Not):
            if (window := self._folded.within.get(self._at(tree))) is not None:
                return self._within(tree, arg, window)
            self._truth(arg, "not")
            return self._made(tree, "not", TRUTH, (arg,))
        kind = Kind(same_dimension([arg], "a sign"), arg.kind.size)
        if isinstance(tree.op, ast.UAdd):
            return arg
        if arg.op == "number":
            return self._made(tree, "number", kind, value=-arg.value)
        return self._made(tree, "neg", kind, (arg,))

    def _binary(self, tree: ast.BinOp) -> Node:
        op = _ARITHMETIC.get(type(tree.op))
        if op is None:
            raise self._refusal(tree, f"'{self._source(tree)}' is not allowed in an expression.", hint=_HELP)
        args = (self._node(tree.left), self._node(tree.right))
        size = same_size(args, f"'{op}'")
        if op in "+-":
            return self._made(tree, op, Kind(same_dimension(args, f"'{op}'"), size), args)
        left, right = (same_dimension([arg], f"'{op}'") for arg in args)
        dimension = left * right if op == "*" else left / right
        return self._made(tree, op, Kind(dimension, size), args)

    def _compare(self, tree: ast.Compare) -> Node:
        signs = tuple(_SIGNS.get(type(op), "") for op in tree.ops)
        if "" in signs:
            raise self._refusal(tree, f"'{self._source(tree)}' is not allowed in an expression.", hint=_HELP)
        args = tuple(self._node(arg) for arg in [tree.left, *tree.comparators])
        same_dimension(args, f"'{signs[0]}'")
        kind = Kind(None, same_size(args, f"'{signs[0]}'"), boolean=True)
        return self._made(tree, "compare", kind, args, signs=signs)

    def _logic(self, tree: ast.BoolOp) -> Node:
        op = "and" if isinstance(tree.op, ast.And) else "or"
        args = tuple(self._node(value) for value in tree.values)
        if op == "or" and self._folded.implies:
            return self._implied(tree, list(zip(tree.values, args, strict=True)))
        for arg in args:
            self._truth(arg, op)
        return self._made(tree, op, TRUTH, args)

    def _implied(self, tree: ast.BoolOp, parts: list[tuple[ast.expr, Node]]) -> Node:
        """Convert an `or` of which some operators were written as `implies`, and replaced before Python's parser ran.

        `implies` has lower precedence than `or` and associates to the right.
        """
        gaps = [(left[0].end_col_offset or 0, right[0].col_offset) for left, right in pairwise(parts)]
        marks = [any(a <= at - self._indent < b for at in self._folded.implies) for a, b in gaps]
        split = marks.index(True) + 1 if True in marks else len(parts)
        for _, arg in parts[:split]:
            self._truth(arg, "implies" if split == 1 else "or")
        left = tuple(arg for _, arg in parts[:split])
        first = left[0] if split == 1 else self._made(tree, "or", TRUTH, left)
        if split == len(parts):
            return first
        other = self._implied(tree, parts[split:])
        self._truth(other, "implies")
        return self._made(tree, "or", TRUTH, (Node("not", TRUTH, (first,), text=f"not ({first.text})"), other))

    def _within(self, tree: ast.UnaryOp, arg: Node, window: Quantity | str) -> Node:
        if not self._ahead:
            raise self._refusal(
                tree,
                "'within' refers to the future, which is allowed only in requirements.",
                hint="For the past, write once(test, 2 s).",
            )
        self._truth(arg, "within")
        if isinstance(window, str):
            meant = self._names.aliases.get(window)
            if meant is None:
                raise self._refusal(tree, unknown("threshold", window, self._names.aliases).message)
        else:
            meant = Node("number", Kind(window.dimension), value=window.value, text=str(window))
        return self._made(tree, "within", TRUTH, (arg,), value=self._window(tree, meant))

    def _window(self, tree: ast.expr, node: Node) -> float:
        """Length of a time window [s], from its constant expression."""
        length = evaluate(node, ()) if node.constant and not node.kind.size else None
        if node.kind != Kind(TIME) or length is None:
            raise self._refusal(tree, f"a window is a fixed time, such as 0.5 s, but {node.text} is {node.kind.words}.")
        if not MIN_WINDOW <= length <= MAX_WINDOW:
            raise self._refusal(tree, f"a window is {MIN_WINDOW:g} s to {MAX_WINDOW:g} s, found {node.text}.")
        return float(length)

    def _vector(self, tree: ast.List) -> Node:
        args = tuple(self._node(part) for part in tree.elts)
        if not args or any(arg.op != "number" for arg in args):
            raise self._refusal(tree, f"a list holds numbers, at least one, found {self._source(tree)}.")
        return self._made(tree, "vector", Kind(same_dimension(args, "a list"), len(args)), args)

    def _choice(self, tree: ast.IfExp) -> Node:
        test, then, other = (self._node(part) for part in (tree.test, tree.body, tree.orelse))
        self._truth(test, "if")
        if then.kind.boolean != other.kind.boolean or then.kind.size != other.kind.size:
            raise Misuse(f"{then.text} is {then.kind.words}, but {other.text} is {other.kind.words}.")
        if not then.kind.boolean:
            same_dimension([then, other], "if")
        return self._made(tree, "if", then.kind, (test, then, other))

    def _call(self, tree: ast.Call) -> Node:
        if not isinstance(tree.func, ast.Name) or tree.func.id not in FUNCTIONS:
            called = self._source(tree.func)
            raise self._refusal(
                tree, f"no function is named '{called}'.", did_you_mean(called, FUNCTIONS, "The language")
            )
        function = FUNCTIONS[tree.func.id]
        if tree.keywords or any(isinstance(arg, ast.Starred) for arg in tree.args):
            raise self._refusal(tree, f"{tree.func.id} takes plain values.", hint=f"Write {function.usage}.")
        args = tuple(self._node(arg) for arg in tree.args)
        window = 0.0
        try:
            if function.window:
                if len(args) < 2:
                    raise Misuse(f"it takes a length of time as the last value, found {len(args)} in all.")
                window, args = self._window(tree.args[-1], args[-1]), args[:-1]
            kind = function.kind(args)
        except Misuse as error:
            raise self._refusal(tree, f"'{self._source(tree)}': {error}", hint=f"Write {function.usage}.") from error
        return self._made(tree, tree.func.id, kind, args, value=window)

    def _truth(self, node: Node, word: str) -> None:
        if node.kind.boolean and node.kind.size:
            raise Misuse(f"'{word}' needs one true or false, but {node.text} has {node.kind.size}; use any or all.")
        if not node.kind.boolean:
            raise Misuse(f"'{word}' needs true or false, but {node.text} is {node.kind.words}.")

    def _source(self, tree: ast.expr) -> str:
        end = (tree.end_col_offset or tree.col_offset) + self._indent
        written = self._text[self._at(tree) : self._folded.ends.get(end, end)]
        return " ".join(written.split())

    def _fault(self, tree: ast.expr, fault: Fault) -> Fault:
        return Fault(fault.message, column=self._at(tree) + 1, hint=fault.hint)

    def _refusal(self, tree: ast.expr, message: str, hint: str = "") -> InputError:
        return InputError(self._fault(tree, Fault(message, hint=hint)))

    def _bare_hint(self, tree: ast.expr) -> str:
        """Hint about a number without a unit next to a quantity; empty if there is none."""
        parts: Sequence[ast.expr] = [tree.left, *tree.comparators] if isinstance(tree, ast.Compare) else []
        if isinstance(tree, ast.BinOp):
            parts = [tree.left, tree.right]
        for part in parts:
            plain = isinstance(part, ast.Constant) and not isinstance(part.value, str)
            if plain and self._at(part) not in self._folded.units:
                return "Write the number with its unit, such as '0.5 m' or '60 deg'."
        return ""
