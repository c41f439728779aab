"""Reloading of rule files while their agent runs: a changed file is checked, then activated or rejected."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from queue import SimpleQueue

from ..base.clock import Clock
from ..base.errors import InputError, unknown
from ..base.files import read_text
from ..base.words import inactive_rule
from ..event import EventSink, GuardInfo, RulesReplaced
from ..expression import Environment
from ..interfaces.action import Action
from ..knowledge import Knowledge
from ..reactive import Override, RuleModel, RuleSet, included_files, load_rules, rule_misfits

Describe = Callable[[str, RuleSet], tuple[GuardInfo, ...]]
"""Describes the guards of an agent's rules."""

POLL = 0.2
"""Interval at which the thread of a RuleWatch checks the files [s]."""


class ReloadableRules:
    """Rule file of an agent, which can be reloaded while the agent runs.

    Args:
        file: Path of the rule file.
        environment: Signals of the agent.
        actions: Actions of the agent, by name.
        overrides: Values of thresholds that robot.toml declares, by name of the threshold.
        knowledge: Knowledge of the agent.
        cached: Cache of parsed rules, which agents with the same content share.

    Attributes:
        model: Reactive model of the active rules.

    Raises:
        InputError: The file is invalid.
    """

    def __init__(
        self,
        file: Path,
        environment: Environment,
        actions: Mapping[str, type[Action]],
        overrides: Mapping[str, Override],
        knowledge: Knowledge,
        cached: Callable[[Callable[[], RuleSet]], RuleSet] = lambda read: read(),
    ) -> None:
        self.file = file
        self._environment = environment
        self._actions = actions
        self._overrides = overrides
        self._knowledge = knowledge
        self._stamps: dict[Path, tuple[int, int] | None] = {}
        self._texts: dict[str, str] = {}
        self.model = RuleModel(self._stamped(cached(self._load)))

    def changed(self) -> bool:
        """Whether the file, or a file that it includes, has changed since it was last loaded."""
        return any(stamp != _stamp(path) for path, stamp in self._stamps.items())

    def reload(self) -> RuleSet:
        """Read and check the file again, and activate its rules from the next snapshot on. Thread-safe.

        Rules of the same name keep their latches and timers; the time windows of temporal operators are reset.

        Returns:
            Rules that are now active.

        Raises:
            InputError: The file is invalid; the error lists all faults. The previous rules stay active.
        """
        from ..reactive.analysis import examine_rules

        before = {path: _stamp(path) for path in self._stamps}  # a change during the load is a later change
        rules, faults = examine_rules(self.file, self._environment, self._actions, self._overrides)
        wrong = [fault for fault in faults if not fault.warning]
        if rules is not None and not wrong:
            wrong = list(rule_misfits(rules.rules, self._actions, self._knowledge))
        if rules is None or wrong:
            # The fault may be in a newly included file, so this file is watched, too.
            self._stamps = {path: _stamp(path) for path in included_files(self.file)} | before
            raise InputError(*wrong)
        rules = self._stamped(rules)
        self._stamps |= {path: stamp for path, stamp in before.items() if path in self._stamps}
        self.model.replace(rules)
        return rules

    def reload_as(
        self, agent: str, clock: Clock, sink: EventSink, describe: Describe = lambda agent, rules: ()
    ) -> None:
        """Reload the file, and emit a RulesReplaced event of the agent, with all that a replay needs."""
        before, texts, guards = self._texts, dict[str, str](), tuple[GuardInfo, ...]()
        try:
            rules = self.reload()
        except InputError as error:
            first, *more = error.faults
            others = f" ({len(more)} more)" if more else ""
            accepted, detail, before = False, f"the old rules stay active: {first}{others}", {}
        else:
            active = f"active rules ({len(rules.rules)}): {', '.join(r.name for r in rules.rules)}"
            robot = self._knowledge.graph.attributes(agent).get("model", agent)
            inactive = [inactive_rule(rule.name, [robot], rule.missing).rstrip(".") for rule in rules.inactive]
            accepted, detail, texts = True, "; ".join([active, *inactive]), self._texts
            guards = describe(agent, rules)
        sink.emit(
            RulesReplaced(
                t=clock.now(),
                agent=agent,
                rules=self.file.stem,
                accepted=accepted,
                detail=detail,
                before=before,
                texts=texts,
                guards=guards,
            )
        )

    def _load(self) -> RuleSet:
        rules = load_rules(self.file, self._environment, self._actions, overrides=self._overrides)
        if faults := list(rule_misfits(rules.rules, self._actions, self._knowledge)):
            raise InputError(*faults)
        return rules

    def _stamped(self, rules: RuleSet) -> RuleSet:
        self._stamps = {path: _stamp(path) for path in rules.files}
        self._texts = {os.path.relpath(path, self.file.parent): read_text(path) for path in rules.files}
        return rules


class RuleWatch:
    """Watcher that reloads changed rule files, in a separate thread, so that control is not delayed; a context manager.

    Args:
        files: Pairs of an agent's name and a rule file of this agent.
        clock: Clock of the events.
        sink: Sink that receives the RulesReplaced events; it must be thread-safe.
        watching: Whether files are reloaded when they have changed, and not only on request.
        describe: Description of an agent's new guards, for the events.
    """

    def __init__(
        self,
        files: Iterable[tuple[str, ReloadableRules]],
        clock: Clock,
        sink: EventSink,
        *,
        watching: bool,
        describe: Describe = lambda agent, rules: (),
    ) -> None:
        self._files = list(files)
        self._describe = describe
        self._clock = clock
        self._sink = sink
        self._watching = watching
        self._requested: SimpleQueue[tuple[str, ReloadableRules]] = SimpleQueue()
        self._stop = threading.Event()
        self._failure: Exception | None = None
        self._thread = threading.Thread(target=self._run, name="rule files", daemon=True)

    def __enter__(self) -> RuleWatch:
        self._thread.start()
        return self

    def __exit__(self, *exc: object) -> None:
        self._stop.set()
        self._thread.join()
        if self._failure is not None:
            raise self._failure

    def request(self, rules: str, agent: str = "") -> None:
        """Have a rule file reloaded at the next check, even if it has not changed; thread-safe.

        Args:
            rules: Name of the rule file.
            agent: Agent that reloads it; every agent with such a file if empty.

        Raises:
            InputError: No such agent has such a rule file.
        """
        found = [(name, file) for name, file in self._files if file.file.stem == rules and agent in ("", name)]
        if not found:
            known = {file.file.stem for name, file in self._files if agent in ("", name)}
            raise InputError(unknown("rule file", rules, known, agent or "The run"))
        for each in found:
            self._requested.put(each)

    def check(self) -> None:
        """Reload the requested files, and if the files are watched all changed ones, now."""
        while not self._requested.empty():
            agent, file = self._requested.get()
            file.reload_as(agent, self._clock, self._sink, self._describe)
        for agent, file in self._files if self._watching else ():
            if file.changed():
                file.reload_as(agent, self._clock, self._sink, self._describe)

    def _run(self) -> None:
        try:
            while not self._stop.wait(POLL):
                self.check()
        except Exception as error:  # noqa: BLE001 - thread boundary: `__exit__` raises it
            self._failure = error


def _stamp(path: Path) -> tuple[int, int] | None:
    """Modification time [ns] and size of a file; None if there is no file."""
    try:
        status = path.stat()
    except OSError:
        return None
    return status.st_mtime_ns, status.st_size
