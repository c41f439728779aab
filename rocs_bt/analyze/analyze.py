"""Base class of all analysers."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from itertools import chain

from ..channel import AnalyzeSubscriber, MonitorSubscriber, Publisher, Signals, Stamped, check_wire
from ..event import Change, EventSink, SignalsWritten, Value, pack
from ..knowledge import Knowledge
from ..signal import Signal


class Analyze(MonitorSubscriber, ABC):
    """Processes the samples of its monitors and publishes a Change only when something changed.

    One Analyze may listen to several Monitors. A user's analyser implements `process` (paper, 5.3: a deliberative
    extension point), which covers the paper's DataProcessor and DataAggregator and has access to Knowledge.

    An analyser that computes signals for other blocks, such as a localisation, declares them in `signals` and writes
    them to Knowledge. Analysers that expect these signals read them there, because analysers are not connected to each
    other. In lockstep the writer runs before them.

    Args:
        name: Name in robot.toml.
        knowledge: Knowledge to read and write.
        sink: Event sink.

    Attributes:
        from_knowledge: Expected signals that another Analyze writes; set by the agent.
    """

    def __init__(self, name: str, knowledge: Knowledge, sink: EventSink) -> None:
        super().__init__()
        self.name = name
        self.knowledge = knowledge
        self.from_knowledge: Sequence[str] = ()
        self._sink = sink
        self._publisher: Publisher[Change] = Publisher(name)

    def expects(self) -> Sequence[str]:
        """Names of the signals that it needs from its monitors or from another Analyze; none by default."""
        return ()

    def signals(self) -> Sequence[Signal]:
        """Signals that it writes, declared in Knowledge before the first period; none by default."""
        return ()

    @abstractmethod
    def process(self, samples: Sequence[Stamped[Signals]]) -> Iterable[Change]:
        """Process the samples that arrived since the last call and yield the changes.

        Args:
            samples: Samples, oldest first, never empty.
        """

    def attach(self, plan: AnalyzeSubscriber) -> None:
        """Connect a Plan to the changes of this analyser.

        Raises:
            WiringError: The argument is not a Plan.
        """
        check_wire(f"Analyze '{self.name}'", plan, AnalyzeSubscriber)
        self._publisher.connect(plan.inbox)

    def run(self, t: float) -> None:
        """Process all queued samples and publish the changes, at time t [s]."""
        samples = self.inbox.drain()
        if not samples:
            return
        if self.from_knowledge:
            known = {name: self.knowledge.signals.numbers(name, t) for name in self.from_knowledge}
            samples.append(Stamped(t, self.knowledge.agent, known))
        for change in self.process(samples):
            self._sink.emit(change)
            self._publisher.publish(t, change)

    def write(self, t: float, values: Signals) -> None:
        """Write the signals that this Analyze block computes, in one update valid at time t [s]."""
        self.knowledge.signals.update(values, t)
        self._sink.emit(
            SignalsWritten(
                t=t,
                agent=self.knowledge.agent,
                monitor=self.name,
                signals=tuple(values),
                sizes=tuple(map(len, values.values())),
                data=pack(chain.from_iterable(values.values())),
            )
        )

    def change(self, t: float, kind: str, subject: str = "", **values: Value) -> Change:
        """A Change with this analyser as its source."""
        agent = self.knowledge.agent
        return Change(t=t, agent=agent, source=self.name, kind=kind, subject=subject, values=values)
