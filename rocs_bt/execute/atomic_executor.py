"""AtomicActionExecutor: acts one atomic action, once a period (paper, 4.2)."""

from __future__ import annotations

from ..action import ActionFailed, AtomicAction, Failure, Progress
from ..errors import InputError, PipelineError
from ..event import AtomicStarted
from .body import RobotBody


class AtomicActionExecutor:
    """Acts atomic actions on a body, and notes where each begins.

    Args:
        body: The robot.
    """

    def __init__(self, body: RobotBody) -> None:
        self._body = body
        self._begun: AtomicAction | None = None

    def act(self, action: AtomicAction, ticket: int) -> Progress | Failure:
        """One control period's worth of it; an ActionFailed that it raises is its failure, and so is an InputError.

        Args:
            action: The action.
            ticket: The number of the ticket that it belongs to.

        Raises:
            PipelineError: It returned something else than Progress or a Failure.
        """
        if action is not self._begun:
            self._begun = action
            self._body.note(
                AtomicStarted,
                ticket=ticket,
                action=action.name,
                route=self._body.turn.route,
                parameters=action.parameters,
            )
        turn = self._body.turn
        turn.commanded, turn.action = False, action.name
        try:
            result = action.act(self._body)
        except ActionFailed as error:
            return error.failure
        except InputError as error:
            return Failure.cannot(error)
        finally:
            turn.action = ""
        if not isinstance(result, (Progress, Failure)):
            raise PipelineError(f"{action.name}.act must return a Progress or a Failure, it returned {result!r}.")
        return result
