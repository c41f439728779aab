"""Analyze: the common part of all analysers."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from itertools import chain

from ..channel import AnalyzeSubscriber, MonitorSubscriber, Publisher, Signals, Stamped, check_wire
from ..event import Change, EventSink, SignalsWritten, Value, pack
from ..knowledge import Knowledge
from ..signal import Signal


class Analyze(MonitorSubscriber, ABC):
    """Processes what its monitors published and publishes a Change only when something changed.

    One Analyze may listen to several Monitors. A user's analyser implements `process` (paper, 5.3: a deliberative
    extension point): both the paper's DataProcessor and DataAggregator, with Knowledge at hand. One that finds numbers
    for everybody, as a localisation does, declares them in `signals` and writes them: those that expect them read them
    from Knowledge, where no wire leads from one Analyze to another. In lockstep it comes before these.

    Args:
        name: What robot.toml calls it.
        knowledge: Where it reads and writes what it knows of the world.
        sink: Where events go.

    Attributes:
        from_knowledge: The signals that it expects and that another Analyze writes; given by the agent.
    """

    def __init__(self, name: str, knowledge: Knowledge, sink: EventSink) -> None:
        super().__init__()
        self.name = name
        self.knowledge = knowledge
        self.from_knowledge: Sequence[str] = ()
        self._sink = sink
        self._publisher: Publisher[Change] = Publisher(name)

    def expects(self) -> Sequence[str]:
        """The signals that its monitors, or another Analyze, must write for it; none as shipped."""
        return ()

    def signals(self) -> Sequence[Signal]:
        """The signals that it writes itself; declared in Knowledge before the first period; none as shipped."""
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
        if self.from_knowledge:
            known = {name: self.knowledge.signals.numbers(name, t) for name in self.from_knowledge}
            samples.append(Stamped(t, self.knowledge.agent, known))
        for change in self.process(samples):
            self._sink.emit(change)
            self._publisher.publish(t, change)

    def write(self, t: float, values: Signals) -> None:
        """Write signals of its own, all at once, as true at time t [s]."""
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
        """A Change signed by this analyser."""
        agent = self.knowledge.agent
        return Change(t=t, agent=agent, source=self.name, kind=kind, subject=subject, values=values)
