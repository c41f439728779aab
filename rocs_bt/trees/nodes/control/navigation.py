"""Control nodes of Nav2 (nav2_behavior_tree, plugins/control) that do not need ROS."""

from __future__ import annotations

from collections.abc import Sequence as Many
from enum import IntEnum
from typing import Annotated, Any, cast

from py_trees.composites import Sequence as StockSequence

from ...status import FAILURE, IDLE, RUNNING, SKIPPED, SUCCESS, Outcome
from ..base_classes import Control, counted_text, halt
from ..port import InOut


class _Nav(Control):
    run_aware_children = cast("Many[Any]", ())  # without an annotation, which would declare a port

    def read(self, port: str) -> Any:
        """Value of a port; as in Nav2, a key without a value counts as the port's default."""
        key, declared = self.key(port), self.ports[port]
        lacks = key is not None and key not in self.board and not declared.required
        return declared.default if lacks else super().read(port)

    def _begin(self) -> None:
        """At the start of a run, notify the children that keep state between runs."""
        for node in self.run_aware_children if self.status is not RUNNING else ():
            node.begin()

    def _tick(self, child: Any, skippable: bool = False) -> Outcome:
        outcome: Outcome = child.tick_once() or child.status
        if outcome is IDLE or (outcome is SKIPPED and not skippable):
            raise self.no_outcome(child, outcome)
        self.current_child = child
        return outcome

    def _finish(self, outcome: Outcome) -> Outcome:
        """End the node with an outcome; RUNNING descendants are halted."""
        self.halt_children()
        self.status = IDLE if outcome is SKIPPED else outcome
        return outcome


class PipelineSequence(_Nav, StockSequence):
    """Ticks its first child until it succeeds, then the first two until the second succeeds, and so on.

    Children that succeeded before are ticked again in each tick; if such a child is now RUNNING, the children after it
    are still ticked. FAILURE of any child ends the node. Children that are skipped are passed over; if all are, so is
    the node.
    """

    memory = False

    def tick_once(self) -> Outcome:
        self._begin()
        skipped = 0
        for index, child in enumerate(self.children):
            outcome = self._tick(child, skippable=True)
            skipped += outcome is SKIPPED
            if outcome is FAILURE or (outcome is RUNNING and index >= self._index):
                self._index = index if outcome is RUNNING else 0
                return self._finish(outcome) if outcome is FAILURE else self._runs()
        self._index = 0
        return self._finish(SKIPPED if skipped == len(self.children) else SUCCESS)

    def _runs(self) -> Outcome:
        self.status = RUNNING
        return RUNNING


class NonblockingSequence(_Nav, StockSequence):
    """Ticks all children in each tick; SUCCESS if all succeed in the same tick, FAILURE as soon as one fails."""

    memory = False

    def tick_once(self) -> Outcome:
        self._begin()
        done = True
        for child in self.children:
            outcome = self._tick(child)
            if outcome is FAILURE:
                return self._finish(FAILURE)
            done = done and outcome is SUCCESS
        if done:
            return self._finish(SUCCESS)
        self.status = RUNNING
        return RUNNING


class PersistentSequence(_Nav, StockSequence):
    """Sequence that keeps its current index in a key of the blackboard, so that a halt does not reset it."""

    memory = True
    current_child_idx: Annotated[InOut[int], "key that holds the index of the current child"]

    def tick_once(self) -> Outcome:
        self.status = RUNNING
        index = self.current_child_idx
        while index < len(self.children):
            outcome = self._tick(self.children[index], skippable=True)
            if outcome is RUNNING:
                return outcome
            if outcome is FAILURE:
                self.current_child_idx = 0
                return self._finish(outcome)
            index += 1
            self.current_child_idx = index
        self.current_child_idx = 0
        return self._finish(SUCCESS)


class RecoveryNode(_Nav):
    """Ticks its first child; if it fails, ticks the second, then retries the first, at most `number_of_retries` times.

    FAILURE if the second child fails or is skipped, or if no retries are left. If the first child is skipped, so is the
    node.
    """

    min_children = max_children = 2
    number_of_retries: Annotated[int, "maximum number of retries of the first child"] = 1

    def __init__(self, name: str, children: Any = (), /, **attributes: Any) -> None:
        super().__init__(name, children, **attributes)
        self._retries = 0

    def tick_once(self) -> Outcome:
        limit = self.number_of_retries
        self.status = RUNNING
        work, recovery = self.children
        while self._retries <= limit:
            if self._index == 0:
                outcome = self._tick(work, skippable=True)
                if outcome is RUNNING:
                    return outcome
                if outcome is not FAILURE or self._retries >= limit:
                    return self._finish(outcome)
                self._index = 1
            outcome = self._tick(recovery, skippable=True)
            if outcome is RUNNING:
                return outcome
            if outcome is FAILURE:
                return self._finish(outcome)
            self._index = 0
            halt(recovery)
            if outcome is SKIPPED:
                # As in Nav2 the count is not reset here: the next run has fewer retries.
                self.status = FAILURE
                return FAILURE
            self._retries += 1
        return self._finish(FAILURE)

    def wait_text(self) -> str:
        what, first = ("recovery", 0) if self._index else ("attempt", 1)
        return counted_text(what, self._retries + 1, self.number_of_retries + first)

    def halted(self) -> None:
        super().halted()
        self._retries = 0

    def _finish(self, outcome: Outcome) -> Outcome:
        self.feedback_message = f"{self.wait_text()} failed" if outcome is FAILURE else ""
        self._index = self._retries = 0
        return super()._finish(outcome)


class RoundRobin(_Nav):
    """Ticks its children in turn until one succeeds; the next run begins after this child. FAILURE if all fail.

    As in Nav2 since Lyrical, the node also fails after its last child, even if that child succeeds, unless
    `wrap_around` is true: then the first child follows the last. SKIPPED if all children are skipped in one tick.
    """

    wrap_around: Annotated[bool, "whether the first child follows the last; always true before Lyrical"] = False

    def __init__(self, name: str, children: Any = (), /, **attributes: Any) -> None:
        super().__init__(name, children, **attributes)
        self._failed = 0

    def tick_once(self) -> Outcome:
        self.status = RUNNING
        count, skipped, wrap = len(self.children), 0, self.wrap_around
        while self._failed + skipped < count:
            outcome = self._tick(self.children[self._index], skippable=True)
            if outcome is RUNNING:
                return outcome
            self._failed += outcome is FAILURE
            skipped += outcome is SKIPPED
            self._index += 1
            if self._index == count:
                if not wrap:
                    self._explain(outcome)
                    break
                self._index = 0
            if outcome is SUCCESS:
                self._failed = 0
                return self._finish(SUCCESS)
        self._index = self._failed = 0
        return self._finish(SKIPPED if skipped == count else FAILURE)

    def _explain(self, outcome: Outcome) -> None:
        """Give the reason of a failure after the success of the last child, which is no reason itself."""
        self.feedback_message = ""
        if outcome is SUCCESS:
            self.current_child = None
            self.feedback_message = f"the last of {len(self.children)} children has ended, and wrap_around is false"

    def halted(self) -> None:
        super().halted()
        self._failed = 0


class _State(IntEnum):
    RESUMED = 0
    PAUSED = 1
    ON_PAUSE = 2
    ON_RESUME = 3


class PauseResumeController(_Nav):
    """Ticks its first child, or its second while paused; its third when a pause begins, its fourth when the pause ends.

    Nav2 uses two services for this; here `paused` is a key that any node may write.
    """

    max_children = 4
    pause_service_name: Annotated[str, "name of the service in Nav2; not used"] = ""
    resume_service_name: Annotated[str, "name of the service in Nav2; not used"] = ""
    paused: Annotated[bool, "whether the node is paused"] = False

    def __init__(self, name: str, children: Any = (), /, **attributes: Any) -> None:
        super().__init__(name, children, **attributes)
        self._state = _State.RESUMED

    def tick_once(self) -> Outcome:
        if self.status is not RUNNING:
            self._state = _State.RESUMED
            self.status = RUNNING
        pause = self.wanted()
        if pause and self._state in (_State.RESUMED, _State.ON_RESUME):
            self._turn(_State.ON_PAUSE)
        elif not pause and self._state in (_State.PAUSED, _State.ON_PAUSE):
            self._turn(_State.ON_RESUME)
        if self._state >= len(self.children):
            self._next()
            return RUNNING
        outcome = self._tick(self.children[self._state], skippable=True)
        if outcome is FAILURE:
            return self._finish(FAILURE)
        if outcome is not RUNNING:
            if self._state is _State.RESUMED:
                return self._finish(SUCCESS)
            self._next()
        return RUNNING

    def wanted(self) -> bool:
        """Whether the node is to be paused now."""
        return self.paused

    def halted(self) -> None:
        super().halted()
        self._state = _State.RESUMED

    def _turn(self, state: _State) -> None:
        self.halt_children()
        self._state = state

    def _next(self) -> None:
        after = {_State.ON_PAUSE: _State.PAUSED, _State.ON_RESUME: _State.RESUMED}
        self._state = after.get(self._state, self._state)
