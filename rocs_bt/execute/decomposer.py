"""ActionDecomposer: lazy decomposition of an action into atomic actions (paper, 4.2)."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack

from ..base.errors import InputError, PipelineError
from ..base.raised import CodeLocation, waiting_at
from ..interfaces.action import Action, ActionFailed, AtomicAction, Body, Failure, MacroAction, Reason

MAX_DEPTH = 16
"""Maximum nesting depth of macro-actions."""

MAX_STEPS = 64
"""Maximum number of decomposition steps in a row that give no atomic action."""


class ActionDecomposer:
    """Decomposition of one submitted action: a stack of macro-actions, each suspended in its method `decompose`.

    A macro-action yields its next action only after the previous one has ended, so its decisions use the Knowledge of
    that time.

    Args:
        action: Submitted action.
        body: Body of the robot, which is passed to every `decompose`.
    """

    def __init__(self, action: Action, body: Body) -> None:
        self._action = action
        self._body = body
        self._stack: list[tuple[MacroAction, Iterator[Action]]] = []
        self._atomic: AtomicAction | None = None
        self._last: Action | None = None
        self._take(action)

    def next(self) -> AtomicAction | None:
        """Atomic action to run: the same one until it has ended; None if the decomposition is complete.

        Raises:
            ActionFailed: A macro-action failed and no outer one handled the failure; or there was no atomic action
                within `MAX_STEPS` steps.
            PipelineError: A macro-action yielded an object that is no action, or the same object twice in a row.
        """
        for _ in range(MAX_STEPS):
            if self._atomic is not None or not self._stack:
                return self._atomic
            self._resume(None)
        raise ActionFailed(Reason.RUNAWAY, f"{self._action.name} made {MAX_STEPS} steps without an atomic action")

    @property
    def nested(self) -> bool:
        """Whether a macro-action waits for the end of the atomic action."""
        return bool(self._stack)

    def lines(self) -> Iterator[CodeLocation]:
        """Source lines of users' macro-actions at which these are suspended, innermost first."""
        for _, steps in reversed(self._stack):
            if (line := waiting_at(steps)) is not None:
                yield line

    def succeeded(self) -> None:
        """Record the success of the atomic action."""
        self._atomic = None

    def failed(self, failure: Failure) -> None:
        """Record the failure of the atomic action: `ActionFailed` is raised in the macro-action that yielded it.

        Raises:
            ActionFailed: No macro-action handled the failure.
        """
        self._atomic = None
        self._resume(failure)

    def cancel(self) -> None:
        """Stop the atomic action, then the macro-actions around it, the innermost first."""
        with ExitStack() as ends:  # last in, first out; each is called even if another raises
            ends.callback(self.close)
            for macro, _ in self._stack:
                ends.callback(macro.stop, self._body)
            if self._atomic is not None:
                ends.callback(self._atomic.stop, self._body)

    def close(self) -> None:
        """Close all generators, innermost first, so that their `finally` clauses run."""
        self._atomic = None
        with ExitStack() as ends:  # last in, first out; each is called even if another raises
            for _, steps in self._stack:
                if (close := getattr(steps, "close", None)) is not None:
                    ends.callback(close)
            self._stack.clear()

    def _resume(self, failure: Failure | None) -> None:
        while self._stack:
            _, steps = self._stack[-1]
            try:
                action = next(steps) if failure is None else _throw(steps, failure)
            except StopIteration:
                self._stack.pop()
                return
            except ActionFailed as error:
                self._stack.pop()
                failure = error.failure
            except InputError as error:
                self._stack.pop()
                failure = Failure.cannot(error)
            else:
                self._take(action)
                return
        if failure is not None:
            raise ActionFailed(failure.reason, failure.evidence)

    def _take(self, action: Action) -> None:
        if action is self._last:
            raise PipelineError(f"{self._action.name} yielded the same {action.name} object twice; make a new one.")
        self._last = action
        if isinstance(action, AtomicAction):
            self._atomic = action
        elif not isinstance(action, MacroAction):
            raise PipelineError(
                f"{self._action.name} was decomposed into {action!r}, which is neither an AtomicAction nor a "
                "MacroAction."
            )
        elif len(self._stack) == MAX_DEPTH:
            raise ActionFailed(Reason.RUNAWAY, f"{self._action.name} nests more than {MAX_DEPTH} macro-actions")
        else:
            self._stack.append((action, action.decompose(self._body)))


def _throw(steps: Iterator[Action], failure: Failure) -> Action:
    error = ActionFailed(failure.reason, failure.evidence)
    throw = getattr(steps, "throw", None)
    if throw is None:  # an iterator that is no generator cannot handle the failure
        raise error
    action: Action = throw(error)
    return action
