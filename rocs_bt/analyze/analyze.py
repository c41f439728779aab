"""Analyze: the common part of all analysers."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence

from ..channel import AnalyzeSubscriber, MonitorSubscriber, Publisher, Signals, Stamped, check_wire
from ..event import Change, EventSink, Value
from ..knowledge import Knowledge


class Analyze(MonitorSubscriber, ABC):
    """Processes what its monitors published and publishes a Change only when something changed.

    One Analyze may listen to several Monitors. A user's analyser implements `process` (paper, 5.3: a deliberative
    extension point): both the paper's DataProcessor and DataAggregator, with Knowledge at hand.

    Args:
        name: What robot.toml calls it.
        knowledge: Where it reads and writes what it knows of the world.
        sink: Where events go.
    """

    def __init__(self, name: str, knowledge: Knowledge, sink: EventSink) -> None:
        super().__init__()
        self.name = name
        self.knowledge = knowledge
        self._sink = sink
        self._publisher: Publisher[Change] = Publisher(name)

    def expects(self) -> Sequence[str]:
        """The signals that its monitors must write for it; none as shipped."""
        return ()

    @abstractmethod
    def process(self, samples: Sequence[Stamped[Signals]]) -> Iterable[Change]:
        """What changed, by the samples that arrived since the last turn, oldest first; never empty."""

    def attach(self, plan: AnalyzeSubscriber) -> None:
        """Publish to this Plan.

        Raises:
            WiringError: It is not a Plan.
        """
        check_wire(f"Analyze '{self.name}'", plan, AnalyzeSubscriber)
        self._publisher.connect(plan.inbox)

    def run(self, t: float) -> None:
        """One turn: take what arrived, process, publish."""
        samples = self.inbox.drain()
        if not samples:
            return
        for change in self.process(samples):
            self._sink.emit(change)
            self._publisher.publish(t, change)

    def change(self, t: float, kind: str, subject: str = "", **values: Value) -> Change:
        """A Change signed by this analyser."""
        agent = self.knowledge.agent
        return Change(t=t, agent=agent, source=self.name, kind=kind, subject=subject, values=values)
