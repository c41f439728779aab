"""Base class of all analysers."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from itertools import chain
from typing import Any, ClassVar

from ..base.signal import Signal
from ..declare import Declared
from ..event import Change, EventSink, SignalsWritten, Value, pack
from ..interfaces.channel import AnalyzeSubscriber, MonitorSubscriber, Publisher, Signals, Stamped, check_wire
from ..knowledge import Knowledge


class Analyze(Declared, MonitorSubscriber, ABC):
    """Base class of analysers, which process samples of monitors and publish a Change when something has changed.

    An analyser may receive samples of several monitors. A user's analyser implements `process` (paper, 5.3: a
    deliberative extension point), which does the work of the paper's DataProcessor and DataAggregator and can use
    Knowledge.

    An analyser that computes signals for other blocks, such as a localisation, declares them in `signals` and writes
    them to Knowledge. Other analysers that expect these signals read them from Knowledge, because analysers are not
    connected to each other. In lockstep mode, the analyser that writes a signal runs before those that read it.

    Annotations of the class declare its keys in robot.toml, as of an action; `__post_init__` may compute further
    attributes.

    Args:
        name: Name in robot.toml.
        knowledge: Knowledge to read and write.
        sink: Sink that receives the analyser's events.
        parameters: Values of the declared keys, SI units.

    Attributes:
        from_knowledge: Names of expected signals that another analyser writes; set by the agent.
        before_reflexes: Whether the analyser runs before the reflexes of a period in lockstep mode, so that rules read
            its signals in the period of the sample. It delays the reflexes, so `process` must be fast. It has no effect
            if another analyser writes a signal that is expected.
    """

    before_reflexes: ClassVar[bool] = False

    def __init__(self, name: str, knowledge: Knowledge, sink: EventSink, **parameters: Any) -> None:
        MonitorSubscriber.__init__(self)
        self.name = name
        self.knowledge = knowledge
        self.from_knowledge: Sequence[str] = ()
        self._now = -math.inf
        self._sink = sink
        self._publisher: Publisher[Change] = Publisher(name)
        Declared.__init__(self, **parameters)

    def expects(self) -> Sequence[str]:
        """Names of the signals that the analyser needs from its monitors or from other analysers; none by default."""
        return ()

    def signals(self) -> Sequence[Signal]:
        """Declarations of the signals that the analyser writes; they are added to Knowledge before the first period."""
        return ()

    @abstractmethod
    def process(self, samples: Sequence[Stamped[Signals]]) -> Iterable[Change] | None:
        """Process the samples that have arrived since the last call, and yield the Changes; None is none.

        Args:
            samples: Samples of the monitors, oldest first; at least one.
        """

    def attach(self, plan: AnalyzeSubscriber) -> None:
        """Connect a Plan to the changes of this analyser.

        Raises:
            WiringError: The argument is not a Plan.
        """
        check_wire(f"Analyze '{self.name}'", plan, AnalyzeSubscriber)
        self._publisher.connect(plan.inbox)

    def run(self, t: float) -> None:
        """Process all queued samples, and publish the Changes. `t` is the present time [s]."""
        samples = self.inbox.drain()
        if not samples:
            return
        self._now = t
        if self.from_knowledge:
            known = {name: self.knowledge.signals.numbers(name, t) for name in self.from_knowledge}
            samples.append(Stamped(t, self.knowledge.agent, known))
        for change in self.process(samples) or ():
            self._sink.emit(change)
            self._publisher.publish(t, change)

    def write(self, t: float, values: Signals) -> None:
        """Write signals that this analyser has computed, all with the time stamp t [s]."""
        self.knowledge.signals.update(values, t)
        self._sink.emit(
            SignalsWritten(
                t=(now := self.now(t)),
                stamp=None if now == t else t,
                agent=self.knowledge.agent,
                monitor=self.name,
                signals=tuple(values),
                sizes=tuple(map(len, values.values())),
                data=pack(chain.from_iterable(values.values())),
            )
        )

    def now(self, t: float) -> float:
        """Present time [s], for a sample of the time t [s], which is earlier if its sensor is late."""
        return max(t, self._now)

    def change(self, t: float, kind: str, subject: str = "", **values: Value) -> Change:
        """Create a Change with this analyser as its source.

        Args:
            t: Time of the sample [s]; the Change is of the present time.
            kind: Kind of the Change, such as `arrived`.
            subject: Name of the node that has changed.
            values: Values that describe the Change.
        """
        agent = self.knowledge.agent
        return Change(t=self.now(t), agent=agent, source=self.name, kind=kind, subject=subject, values=values)
