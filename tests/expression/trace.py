"""What expressions mean over time, as plainly as possible: the oracle of compiled expressions.

A trace keeps every snapshot; a temporal operation looks back over all of them. How windows and margins are meant is
defined in `rocs_bt.expression.program`. Sources: O. Maler, D. Nickovic, "Monitoring Temporal Properties of Continuous
Signals" (2004), for the temporal operations over signals that stand from one sample to the next; A. Donze, O. Maler,
"Robust Satisfaction of Temporal Logic over Real-Valued Signals" (2010), for margins; J. Deshmukh et al., "Robust Online
Monitoring of Signal Temporal Logic" (2015), for what a margin is while parts of it are not known.
"""

import math

from rocs_bt.expression.interpreter import combine, every, known, some
from rocs_bt.expression.lower import margin_scale, mixed_units
from rocs_bt.expression.program import TOLERANCE, ring_shape


class Trace:
    """The snapshots so far, and what expressions make of them."""

    def __init__(self):
        self._forget()

    def _forget(self):
        self._times = []
        self._rows = []
        self._memo = {}
        self._kept = {}

    def append(self, x, t):
        """A new snapshot, at a time [s]; one before the last one's forgets them all."""
        if self._times and t < self._times[-1]:
            self._forget()
        self._times.append(t)
        self._rows.append(x)

    def value(self, node, i=-1):
        """The value at the i-th snapshot; None where it is invalid."""
        return self._remembered(node, i % len(self._times), None)

    def margin(self, node, i=-1):
        """How far a single truth value is from changing; None where that is not known."""
        return self._remembered(node, i % len(self._times), mixed_units(node))

    def _remembered(self, node, i, mixed):
        key = (id(node), i, mixed)
        if key not in self._memo:
            self._kept[id(node)] = node  # or its id could be another's
            self._memo[key] = known(self._value(node, i) if mixed is None else self._margin(node, i, mixed))
        return self._memo[key]

    def _value(self, node, i):
        match node.op:
            case "number" | "truth":
                return node.value
            case "vector":
                return [arg.value for arg in node.args]
            case "read":
                return list(self._rows[i][node.start : node.stop]) if node.kind.size else self._rows[i][node.start]
            case "held":
                return self._held(node.args[0], i, node.value)
            case "once":
                return some([self.value(node.args[0], j) for j in self._window(i, node.value)])
            case "since":
                return self._since(node, i)
            case "time_since":
                return self._time_since(node.args[0], i)
            case "delay" | "rate":
                return self._back(node, i)
        return combine(node, [self.value(arg, i) for arg in node.args])

    def _window(self, i, length):
        """The samples that stood at any time of a window that ends at sample i."""
        t, limit = self._times, length - TOLERANCE
        return [j for j in range(i + 1) if j == i or t[i] - t[j + 1] < limit]

    def _covered(self, i, length):
        return self._times[i] - self._times[0] >= length - TOLERANCE

    def _held(self, arg, i, length):
        if not self._covered(i, length):
            return False
        return every([self.value(arg, j) for j in self._window(i, length)])

    def _since(self, node, i):
        a, b = node.args
        return some(
            [
                every([self.value(b, j), *(self.value(a, k) for k in range(j + 1, i + 1))])
                for j in self._window(i, node.value)
            ]
        )

    def _time_since(self, arg, i):
        if self.value(arg, i) is None:
            return None
        held = [self._times[j] for j in range(i + 1) if self.value(arg, j)]
        return self._times[i] - held[-1] if held else math.inf

    def _pairs(self, i, length):
        """The samples up to i, in the groups that a ring of that window does not tell apart."""
        width, _ = ring_shape(length)
        groups = []
        for j in range(i + 1):
            if groups and self._times[j] - self._times[groups[-1][0]] < width - TOLERANCE:
                groups[-1].append(j)
            else:
                groups.append([j])
        return groups

    def _pairs_of_window(self, i, length):
        groups = self._pairs(i, length)
        ends = [self._times[group[0]] for group in groups[1:]]
        limit = length - TOLERANCE
        return [g for g, end in zip(groups, [*ends, math.inf], strict=True) if self._times[i] - end < limit]

    def _back(self, node, i):
        """`delay`: what was when the window began; `rate`: the change since, by the time since."""
        j = self._pairs_of_window(i, node.value)[0][0]
        if self._times[i] - self._times[j] < node.value - TOLERANCE:
            return None
        then = self.value(node.args[0], j)
        if node.op == "delay":
            return then
        now = self.value(node.args[0], i)
        return None if now is None or then is None else (now - then) / (self._times[i] - self._times[j])

    def _margin(self, node, i, mixed):
        def of(arg, j=i):
            return self._remembered(arg, j, mixed)

        match node.op:
            case "truth":
                return math.inf if node.value else -math.inf
            case "not":
                return _negative(of(node.args[0]))
            case "and":
                return _worst([of(arg) for arg in node.args])
            case "or":
                return _best([of(arg) for arg in node.args])
            case "if":
                return self._margin_of_choice(node, i, of)
            case "any" | "all":
                group = of(node.args[0])
                fold = _best if node.op == "any" else _worst
                return fold(group if isinstance(group, list) else [group])
            case "held" | "once":
                return self._margin_of_window(node, i, of)
            case "since":
                return self._margin_of_since(node, i, of)
            case "delay":
                j = self._pairs_of_window(i, node.value)[0][0]
                return of(node.args[0], j) if self._times[i] - self._times[j] >= node.value - TOLERANCE else None
        return self._gaps(node, i, margin_scale(node) if mixed else 1.0)

    def _margin_of_choice(self, node, i, of):
        test, then, other = (of(arg) for arg in node.args)
        if self.value(node.args[0], i) is None:  # the value is invalid, whatever the branches are
            return [None] * node.kind.size if node.kind.size else None
        if not node.kind.size:
            return _best([_worst([test, then]), _worst([_negative(test), other])])
        pairs = zip(then, other, strict=True)
        return [_best([_worst([test, a]), _worst([_negative(test), b])]) for a, b in pairs]

    def _margin_of_window(self, node, i, of):
        (arg,) = node.args
        found = [of(arg, j) for group in self._pairs_of_window(i, node.value) for j in group]
        if node.op == "held":
            return _worst(found if self._covered(i, node.value) else [-math.inf, *found])
        return _best(found if self._covered(i, node.value) else [-math.inf, *found])

    def _margin_of_since(self, node, i, of):
        a, b = node.args
        found = []
        for group in self._pairs_of_window(i, node.value):
            best = of(b, group[0])
            for j in group[1:]:
                best = _best([_worst([best, of(a, j)]), of(b, j)])
            found.append(_worst([best, *(of(a, k) for k in range(group[-1] + 1, i + 1))]))
        return _best(found)

    def _gaps(self, node, i, scale):
        values = [self.value(arg, i) for arg in node.args]
        if not node.kind.size:
            return _gap_of_chain(node.signs, values, scale)
        rows = [[v[k] if isinstance(v, list) else v for v in values] for k in range(node.kind.size)]
        return [_gap_of_chain(node.signs, row, scale) for row in rows]


def _worst(margins):
    known = [m for m in margins if m is not None]
    least = min(known, default=math.inf)
    return least if len(known) == len(margins) or least < 0.0 else None


def _best(margins):
    return _negative(_worst([_negative(m) for m in margins]))


def _negative(value):
    if isinstance(value, list):
        return [_negative(v) for v in value]
    return None if value is None else -value


def _gap_of_chain(signs, values, scale):
    return _worst([_gap(sign, a, b, scale) for sign, a, b in zip(signs, values, values[1:], strict=False)])


def _gap(sign, a, b, scale):
    """How far a comparison is from changing."""
    if a is None or b is None:
        return None
    if a == b:
        return 0.0
    if sign in ("<", "<="):
        return (b - a) / scale
    if sign in (">", ">="):
        return (a - b) / scale
    return -abs(b - a) / scale if sign == "==" else abs(b - a) / scale
