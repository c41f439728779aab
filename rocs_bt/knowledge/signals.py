"""Signal table: measured values, which change in every control period (docs/architecture.md).

All values are in one float64 array. A value outside its bounds is stored as NaN, and a value older than the signal's
`max_age` is read as NaN: NaN is the single indicator of failure. A range without echo is +inf, which is valid if the
bounds allow it.
"""

from __future__ import annotations

import math
import threading
from array import array
from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from typing import TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from ..base.errors import KnowledgeError, unknown
from ..base.signal import Signal

Array: TypeAlias = NDArray[np.float64]
Values: TypeAlias = float | Sequence[float] | Array

# Tolerance [s] for rounding of times, so that a value with an age of exactly max_age is valid.
_SLACK = 5e-7


class SignalWriter:
    """Handle for repeated writes of one signal, without a lookup; made by `SignalTable.writer`."""

    __slots__ = ("_expires", "_high", "_lock", "_low", "_table", "_view", "revision", "spec", "stamp")

    def __init__(self, table: SignalTable, spec: Signal, view: Array, expires: Array, lock: threading.Lock) -> None:
        self._table = table
        self._view = view
        self._expires = expires
        self._lock = lock
        self._low, self._high = spec.bounds
        self.spec = spec
        self.stamp = -math.inf
        self.revision = 0

    def write(self, values: Values, t: float) -> None:
        """Write the newest values.

        Args:
            values: SI units, shape (size,), or a plain number if the size is 1; copied.
            t: Time of measurement of the values [s].

        Raises:
            KnowledgeError: Wrong size, not numbers, or a time that is not finite.
        """
        checked = self.checked(values, t)
        with self._lock:
            self.store(checked, t)

    def checked(self, values: Values, t: float) -> Array | float:
        """Check values and convert them to the stored form, with NaN for values out of bounds; see `write`."""
        if not math.isfinite(t):
            raise KnowledgeError(f"signal '{self.spec.name}' was written with the time {t!r}; give it in seconds.")
        if type(values) is float and self.spec.size == 1:
            return values if self._low <= values <= self._high else math.nan
        try:
            found = np.array(values, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise KnowledgeError(f"signal '{self.spec.name}' takes numbers, found {values!r}.") from error
        if found.shape != self._view.shape and not (found.ndim == 0 and self.spec.size == 1):
            raise KnowledgeError(
                f"signal '{self.spec.name}' has {self.spec.size} values, found {found.size} of shape {found.shape}."
            )
        if self._low > -math.inf:
            np.putmask(found, found < self._low, math.nan)
        if self._high < math.inf:
            np.putmask(found, found > self._high, math.nan)
        return found

    def store(self, checked: Array | float, t: float) -> None:
        """Store checked values; the caller holds the table's lock."""
        self._view[:] = checked
        self._expires.fill(t + self.spec.max_age + _SLACK)
        self.stamp = t
        self.revision += 1
        self._table.revision += 1


class _Batch:
    """Adjacent signals of equal `max_age` that a writer, such as a monitor, repeatedly writes together."""

    __slots__ = ("_bounds", "_expires", "_max_age", "_sizes", "_values", "writers")

    def __init__(self, writers: Sequence[SignalWriter], values: Array, expires: Array) -> None:
        specs = [writer.spec for writer in writers]
        self._sizes = tuple(spec.size for spec in specs)
        each = [spec.bounds for spec in specs for _ in range(spec.size)]
        edges = [0, *(i for i, (a, b) in enumerate(pairwise(each), 1) if a != b), len(each)]
        self._bounds = [(*each[a], slice(a, b)) for a, b in pairwise(edges) if a < b]
        self._max_age = specs[0].max_age
        self._values = values
        self._expires = expires
        self.writers = tuple(writers)

    def store(self, values: Iterable[Values], t: float) -> bytes | None:
        """Store valid values and return them packed as float64; None, without storing, if they need the full check.

        The caller holds the table's lock.
        """
        flat: list[float] = []
        for value, size in zip(values, self._sizes, strict=True):
            if type(value) is not list or len(value) != size:
                return None
            flat += value
        try:
            # min and max may miss a NaN, which is harmless: a NaN is stored as NaN with or without the full check.
            for low, high, part in self._bounds:
                if not (low <= min(flat[part]) and max(flat[part]) <= high):
                    return None
            packed = array("d", flat).tobytes()
        except (TypeError, ValueError):
            return None
        self._values[:] = np.frombuffer(packed)
        self._expires.fill(t + self._max_age + _SLACK)
        for writer in self.writers:
            writer.stamp = t
            writer.revision += 1
        return packed


class SignalTable:
    """All signals of one agent.

    Declare every signal, then call `freeze`. The first read or write freezes the table too, because the array of values
    cannot grow afterwards.

    Attributes:
        revision: Number of writes to all signals so far.
    """

    def __init__(self) -> None:
        self._specs: dict[str, Signal] = {}
        self._slices: dict[str, slice] = {}
        self._writers: dict[str, SignalWriter] = {}
        self._batches: dict[tuple[str, ...], _Batch | None] = {}
        self._lock = threading.Lock()
        self._frozen = False
        self.size = 0
        self.revision = 0

    def declare(self, signal: Signal) -> None:
        """Declare a signal.

        Raises:
            KnowledgeError: The name is taken, the table is frozen, or the declaration is invalid.
        """
        if self._frozen:
            raise KnowledgeError(f"signal '{signal.name}' came too late: the table is in use; declare it before.")
        if signal.name in self._specs:
            raise KnowledgeError(f"signal '{signal.name}' is declared twice; rename one of them.")
        if problem := _problem(signal):
            raise KnowledgeError(f"signal '{signal.name}' {problem}.")
        self._specs[signal.name] = signal
        self._slices[signal.name] = slice(self.size, self.size + signal.size)
        self.size += signal.size

    def freeze(self) -> None:
        """End the declarations and allocate the array of values, all NaN; further calls have no effect."""
        with self._lock:
            if self._frozen:
                return
            self._values = np.full(self.size, math.nan)
            # One expiry for each value, not for each signal: a snapshot finds stale values in one comparison.
            self._expires = np.full(self.size, -math.inf)
            # Live views of both: for a few numbers plain Python is faster than numpy.
            self._numbers = cast("memoryview[float]", self._values.data)
            self._ends = cast("memoryview[float]", self._expires.data)
            for name, spec in self._specs.items():
                span = self._slices[name]
                self._writers[name] = SignalWriter(self, spec, self._values[span], self._expires[span], self._lock)
            self._frozen = True

    @property
    def frozen(self) -> bool:
        """Whether declarations have ended."""
        return self._frozen

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all signals in the order of declaration, which is the order of their values in a snapshot."""
        return tuple(self._specs)

    def __contains__(self, name: str) -> bool:
        return name in self._specs

    def spec(self, name: str) -> Signal:
        """The declaration of a signal.

        Raises:
            KnowledgeError: No such signal; lists what exists.
        """
        try:
            return self._specs[name]
        except KeyError:
            raise self._no_signal(name) from None

    def slice_of(self, name: str) -> slice:
        """Position of a signal's values in a snapshot."""
        self.spec(name)
        return self._slices[name]

    def writer(self, name: str) -> SignalWriter:
        """A handle for repeated writes of one signal."""
        try:
            return self._writers[name]
        except KeyError:
            self.spec(name)
            self.freeze()
            return self._writers[name]

    def write(self, name: str, values: Values, t: float) -> None:
        """Write the newest values of a signal; see `SignalWriter.write`."""
        self.writer(name).write(values, t)

    def update(self, values: Mapping[str, Values], t: float) -> bytes | None:
        """Write several signals of one sample atomically; if one is refused, none is written.

        Returns:
            All values packed as float64 if every one was stored unchanged; None if some may have become NaN.
        """
        names = tuple(values)
        batch = self._batches.get(names) or self._batch(names)
        if batch is not None and math.isfinite(t):
            with self._lock:
                if (packed := batch.store(values.values(), t)) is not None:
                    self.revision += len(batch.writers)
                    return packed
        # All are checked before the first is stored, and outside of the lock, which readers of each period wait for.
        checked = [(w := self.writer(name), w.checked(v, t)) for name, v in values.items()]
        with self._lock:
            for writer, value in checked:
                writer.store(value, t)
        return None

    def read(self, name: str, t: float) -> Array:
        """A copy of a signal's values, shape (size,); NaN if stale at time t [s], invalid or out of bounds."""
        writer = self.writer(name)
        with self._lock:
            return self._read(writer, t)

    def value(self, name: str, t: float) -> float:
        """The value of a signal of size 1; NaN if stale at time t [s], invalid or out of bounds.

        Raises:
            KnowledgeError: The signal has another size.
        """
        writer = self.writer(name)
        if writer.spec.size != 1:
            raise KnowledgeError(f"signal '{name}' has {writer.spec.size} values, not one; use read().")
        at = self._slices[name].start
        with self._lock:
            return math.nan if self._ends[at] < t else self._numbers[at]

    def numbers(self, name: str, t: float) -> list[float]:
        """A signal's values as a list of floats, otherwise as from `read`; much faster for a few values."""
        self.writer(name)
        span = self._slices[name]
        with self._lock:
            values: list[float] = [*self._numbers[span]]
            stale = self._ends[span.start] < t
        return [math.nan] * len(values) if stale else values

    def snapshot(self, t: float, out: Array | None = None) -> Array:
        """Values of all signals at one moment, shape (size,); NaN for signals that are stale at time t [s].

        Args:
            t: Present time, from which the ages are computed [s].
            out: Buffer to copy into, shape (size,); None for a new one.

        Returns:
            `out`. A concurrent write is seen completely or not at all.

        Raises:
            KnowledgeError: The buffer has another shape or type, or is not contiguous.
        """
        if not self._frozen:
            self.freeze()
        if out is None:
            out = np.empty(self.size)
        elif out.shape != self._values.shape or out.dtype != np.float64 or not out.flags.c_contiguous:
            found = f"{out.dtype} {out.shape}, with strides {out.strides}"
            raise KnowledgeError(f"a snapshot needs contiguous float64 of shape ({self.size},), found {found}.")
        with self._lock:
            out[:] = self._values
            np.putmask(out, self._expires < t, math.nan)
        return out

    def view(self, name: str) -> Array:
        """Live, read-only view of a signal's newest values, shape (size,); not NaN when stale, so check `stamp`."""
        self.writer(name)
        view = self._values[self._slices[name]]
        view.flags.writeable = False
        return view

    def stamp(self, name: str) -> float:
        """Time of measurement of a signal's newest values [s]; -inf before the first write."""
        return self.writer(name).stamp

    def revision_of(self, name: str) -> int:
        """Number of writes of a signal so far."""
        return self.writer(name).revision

    def _batch(self, names: tuple[str, ...]) -> _Batch | None:
        """The batch of these signals; None unless they are adjacent in this order and have one `max_age`."""
        try:
            return self._batches[names]
        except KeyError:
            writers = [self.writer(name) for name in names]
            spans = [self._slices[name] for name in names]
            adjacent = all(a.stop == b.start for a, b in pairwise(spans))
            alike = len({writer.spec.max_age for writer in writers}) == 1
            whole = slice(spans[0].start, spans[-1].stop) if spans else slice(0, 0)
            batch = _Batch(writers, self._values[whole], self._expires[whole]) if adjacent and alike else None
            self._batches[names] = batch
            return batch

    def _read(self, writer: SignalWriter, t: float) -> Array:
        span = self._slices[writer.spec.name]
        if self._expires.item(span.start) < t:
            return np.full(writer.spec.size, math.nan)
        return self._values[span].copy()

    def _no_signal(self, name: str) -> KnowledgeError:
        return KnowledgeError(str(unknown("signal", name, self._specs, "The robot")))


def _problem(signal: Signal) -> str:
    low, high = signal.bounds
    if not signal.name:
        return "has no name"
    if signal.size < 1:
        return f"must have at least one value, found size {signal.size}"
    if len(signal.dimensions) not in (1, signal.size):
        return f"has {signal.size} values but {len(signal.dimensions)} dimensions; give one, or one for each"
    if not low <= high:
        return f"has the bounds [{low}, {high}]; the lower must not exceed the upper"
    if not signal.max_age > 0.0:
        return f"must have a positive max_age, found {signal.max_age} s"
    return ""
