"""Rule files that change while their agent runs: read anew, checked, and put in force, or left alone."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from ..action import Action
from ..clock import Clock
from ..errors import InputError
from ..event import EventSink, RulesReplaced
from ..expression import Environment
from ..knowledge import Knowledge
from ..reactive import Override, RuleModel, RuleSet, included_files, load_rules, rule_misfits

POLL = 0.2
"""How often a watching thread looks at the files [s]."""


class RuleFile:
    """One rule file in force in an agent.

    Args:
        file: The file.
        environment: The agent's signals.
        actions: The agent's actions by name.
        overrides: The robot's own values of thresholds, by name.
        knowledge: All that the robot knows.
        keep: Gives what was read before by another agent of the same content, or else reads it.

    Attributes:
        model: Its rules, live.

    Raises:
        InputError: The file is wrong.
    """

    def __init__(
        self,
        file: Path,
        environment: Environment,
        actions: Mapping[str, type[Action]],
        overrides: Mapping[str, Override],
        knowledge: Knowledge,
        keep: Callable[[Callable[[], RuleSet]], RuleSet] = lambda read: read(),
    ) -> None:
        self.file = file
        self._environment = environment
        self._actions = actions
        self._overrides = overrides
        self._knowledge = knowledge
        self._stamps: dict[Path, tuple[int, int] | None] = {}
        self.model = RuleModel(self._stamped(keep(self._load)))

    def changed(self) -> bool:
        """Whether the file, or one that it includes, is another than when it was read last."""
        return any(stamp != _stamp(path) for path, stamp in self._stamps.items())

    def reload(self) -> RuleSet:
        """Read the file anew, check it, and put its rules in force from the next snapshot on; safe from any thread.

        Rules of the same name stay latched and keep their timers; windows of temporal operations begin anew.

        Returns:
            What is in force now.

        Raises:
            InputError: Something in it is wrong, with every fault; the old rules stay in force.
        """
        from ..reactive.analysis import examine_rules

        before = {path: _stamp(path) for path in self._stamps}  # what changes while it is read is another change
        found = examine_rules(self.file, self._environment, self._actions, self._overrides)
        wrong = [fault for fault in found if not fault.warning]
        try:
            rules = self._load()
        except InputError as error:
            wrong = wrong or list(error.faults)
        if wrong:
            # A file that it includes from now on may be the one to mend.
            self._stamps = {path: _stamp(path) for path in included_files(self.file)} | before
            raise InputError(*wrong)
        rules = self._stamped(rules)
        self._stamps |= {path: stamp for path, stamp in before.items() if path in self._stamps}
        self.model.replace(rules)
        return rules

    def look(self, agent: str, clock: Clock, sink: EventSink) -> None:
        """Reload the file if it has changed, and tell of it as a RulesReplaced event of the agent."""
        if not self.changed():
            return
        try:
            rules = self.reload()
        except InputError as error:
            first, *more = error.faults
            others = f" ({len(more)} more)" if more else ""
            accepted, detail = False, f"the old rules stay in force: {first}{others}"
        else:
            accepted, detail = True, f"{len(rules.rules)} rules in force: {', '.join(r.name for r in rules.rules)}"
        sink.emit(RulesReplaced(t=clock.now(), agent=agent, rules=self.file.stem, accepted=accepted, detail=detail))

    def _load(self) -> RuleSet:
        rules = load_rules(self.file, self._environment, self._actions, overrides=self._overrides)
        if faults := list(rule_misfits(rules.rules, self._actions, self._knowledge)):
            raise InputError(*faults)
        return rules

    def _stamped(self, rules: RuleSet) -> RuleSet:
        self._stamps = {path: _stamp(path) for path in rules.files}
        return rules


class RuleWatch:
    """Looks at rule files from a thread of its own, which no control waits for; a context manager.

    Args:
        files: The files, with the agents whose they are.
        clock: Time, for the events.
        sink: Where RulesReplaced events go; safe under threads.
    """

    def __init__(self, files: Iterable[tuple[str, RuleFile]], clock: Clock, sink: EventSink) -> None:
        self._files = list(files)
        self._clock = clock
        self._sink = sink
        self._stop = threading.Event()
        self._failure: Exception | None = None
        self._thread = threading.Thread(target=self._run, name="rule files", daemon=True)

    def __enter__(self) -> RuleWatch:
        if self._files:
            self._thread.start()
        return self

    def __exit__(self, *exc: object) -> None:
        self._stop.set()
        if self._files:
            self._thread.join()
        if self._failure is not None:
            raise self._failure

    def look(self) -> None:
        """Look at all files now."""
        for agent, file in self._files:
            file.look(agent, self._clock, self._sink)

    def before(self, watch: Callable[[float], bool]) -> Callable[[float], bool]:
        """A function that looks, and then does what `watch` does; for lockstep, once a control period."""

        def look_and_watch(t: float) -> bool:
            self.look()
            return watch(t)

        return look_and_watch if self._files else watch

    def _run(self) -> None:
        try:
            while not self._stop.wait(POLL):
                self.look()
        except Exception as error:  # noqa: BLE001 - the thread's boundary: kept, and raised where it is waited for
            self._failure = error


def _stamp(path: Path) -> tuple[int, int] | None:
    """What tells that a file is another one: when it was written and how long it is; None where there is none."""
    try:
        status = path.stat()
    except OSError:
        return None
    return status.st_mtime_ns, status.st_size
