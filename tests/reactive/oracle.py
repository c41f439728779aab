"""z3 on expressions: a solver that shares nothing with the prover. Signals have finite bounds, and are valid."""

from fractions import Fraction

import z3

from rocs_bt.expression import evaluate


def exact(value):
    return z3.Q(*Fraction(value).as_integer_ratio())


def least(values):
    found = values[0]
    for value in values[1:]:
        found = z3.If(value < found, value, found)
    return found


def greatest(values):
    return -least([-v for v in values])


def flat(values):
    return [v for value in values for v in (value if isinstance(value, list) else [value])]


def spread(node, values):
    """Value by value where it is a group."""
    if not node.kind.size:
        return single(node, values)
    rows = [[v[i] if isinstance(v, list) else v for v in values] for i in range(node.kind.size)]
    return [single(node, row) for row in rows]


SIGNS = {
    "<": lambda a, b: a < b, "<=": lambda a, b: a <= b, ">": lambda a, b: a > b, ">=": lambda a, b: a >= b,
    "==": lambda a, b: a == b, "!=": lambda a, b: a != b,
}  # fmt: skip  # a table


def single(node, v):
    match node.op:
        case "neg":
            return -v[0]
        case "+":
            return v[0] + v[1]
        case "-":
            return v[0] - v[1]
        case "*":
            return v[0] * v[1]
        case "/":
            return v[0] / v[1]
        case "compare":
            return z3.And([SIGNS[s](a, b) for s, a, b in zip(node.signs, v, v[1:], strict=False)])
        case "and":
            return z3.And(v)
        case "or":
            return z3.Or(v)
        case "not":
            return z3.Not(v[0])
        case "if":
            return z3.If(v[0], v[1], v[2])
        case "abs":
            return z3.If(v[0] < 0, -v[0], v[0])
        case "clip":
            return least([greatest(v[:2]), v[2]])
        case "side":
            return z3.If(v[0] >= 0, z3.RealVal(1), z3.RealVal(-1))
        case "sign":
            return z3.If(v[0] > 0, z3.RealVal(1), z3.If(v[0] < 0, z3.RealVal(-1), z3.RealVal(0)))
        case "min":
            return least(flat(v))
        case "max":
            return greatest(flat(v))
        case "min_valid":
            return least(flat(v[:1]))
        case "sum":
            return z3.Sum(flat(v))
        case "mean":
            return z3.Sum(flat(v)) / len(flat(v))
        case "dot":
            return z3.Sum([a * b for a, b in zip(flat(v[:1]), v[1], strict=True)])
        case "count":
            return z3.Sum([z3.If(c, z3.RealVal(1), z3.RealVal(0)) for c in flat(v)])
        case "any":
            return z3.Or(flat(v))
        case "all":
            return z3.And(flat(v))
    raise NotImplementedError(node.op)


class Oracle:
    """Tells whether expressions over an environment's signals can be true.

    Args:
        environment: The signals.
        milliseconds: How long z3 may take for one expression.
    """

    def __init__(self, environment, milliseconds=2000):
        self._variables = [z3.Real(f"x{i}") for i in range(environment.size)]
        self._milliseconds = milliseconds
        self._domain = []
        for name, signal in environment.signals.items():
            low, high = map(exact, signal.bounds)
            for variable in self._variables[environment.offsets[name] :][: signal.size]:
                self._domain += [variable >= low, variable <= high]

    def satisfiable(self, node):
        """True, False, or None where z3 gives up."""
        solver = z3.Solver()
        solver.set("timeout", self._milliseconds)
        solver.add(*self._domain, self._formula(node))
        found = solver.check()
        return None if found == z3.unknown else found == z3.sat

    def _formula(self, node):
        if node.op == "truth":
            return z3.BoolVal(node.value)
        if node.op == "vector":
            return [exact(arg.value) for arg in node.args]
        if node.op == "read":
            group = self._variables[node.start : node.stop]
            return group if node.kind.size else group[0]
        if node.constant and not node.kind.boolean and not node.kind.size:
            return exact(evaluate(node, ()))
        return spread(node, [self._formula(arg) for arg in node.args])
