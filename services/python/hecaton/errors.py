"""Exceptions of the package. Each has a text for people, and `kind` and `subject` for programs."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ._hecaton import Outcome

__all__ = ["Error", "Unreachable", "Rejected", "NoAnswer", "Closed", "InvalidArgument", "GoalFailed", "WaitTimeout"]


class Error(Exception):
    """Base class. `kind` is a word, such as "unknown_name"; `subject` is the name that it is about, or empty."""

    def __init__(self, text: str, kind: str = "error", subject: str = "") -> None:
        super().__init__(text, kind, subject)
        self.text = text
        self.kind = kind
        self.subject = subject

    def __str__(self) -> str:
        return self.text


class Unreachable(Error):
    """No cell answers, or the process that is needed does not. Nothing has changed."""


class Rejected(Error):
    """The supervisor rejects an order, or the world service an edit. Nothing has changed. `kind` is a cause's."""


class NoAnswer(Error):
    """The world service is reachable, but has not answered within the time limit. The edit may have been made."""


class Closed(Error):
    """The connection was closed, also during a wait; `kind` "forked": it belongs to the parent of this process."""


class InvalidArgument(Error, ValueError):
    """An invalid argument: a cell file, a domain, an unknown arm, or a wrong value or type of another argument."""


class _GoalError(Error):
    def __init__(self, text: str, kind: str, subject: str, outcome: Outcome | None = None) -> None:
        super().__init__(text, kind, subject)
        self.outcome = outcome

    def __reduce__(self) -> tuple[type[_GoalError], tuple[str, str, str]]:
        return type(self), (self.text, self.kind, self.subject)  # an outcome cannot be pickled


class GoalFailed(_GoalError):
    """A goal ended unreached: rejected, cancelled, replaced or timed out.

    `kind` and `subject` are the cause's, such as "goal_in_collision" and "post"; `outcome` has the rest. It is None
    after pickling, as between processes.
    """


class WaitTimeout(_GoalError):
    """The time limit of a wait passed before the goal ended. The goal continues.

    `kind` is that of the present cause, such as "path_blocked", else "blocked", "active" or "unanswered".
    """
