"""One thread of Python for each connection with callbacks: it takes events from C++ and calls the subscribers."""

from __future__ import annotations

import os
import sys
import threading
from typing import Callable, Protocol, TypeVar

from ._hecaton import Fault, NativeGoal, Progress, Session

T = TypeVar("T")


class Subscriber(Protocol):
    """Receives the progress of one goal, in the thread of the events."""

    def progress(self, progress: Progress) -> None: ...

    def closed(self) -> None:
        """The connection was closed before the goal ended."""


class Events:
    """Subscriptions of one session. Thread-safe. The thread starts with the first subscription."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._process = os.getpid()
        # Reentrant: the garbage collector may close a connection in the middle of a delivery.
        self._lock = threading.RLock()
        self._thread: threading.Thread | None = None
        self._goals: dict[str, list[Subscriber]] = {}
        self._on_fault: Callable[[Fault], object] | None = None

    def subscribe(self, goal: NativeGoal, subscriber: Subscriber) -> None:
        """Calls `subscriber` with the newest progress and each later one, until the goal ends."""
        with self._lock:
            self._goals.setdefault(goal.id, []).append(subscriber)
            self._start()
        try:
            goal.watch()
        except BaseException:
            self.unsubscribe(goal.id, subscriber)
            raise

    def unsubscribe(self, goal: str, subscriber: Subscriber) -> None:
        with self._lock:
            subscribers = self._goals.get(goal, [])
            if subscriber in subscribers:
                subscribers.remove(subscriber)
            if not subscribers:
                self._goals.pop(goal, None)

    def on_fault(self, callback: Callable[[Fault], object] | None) -> None:
        with self._lock:
            self._on_fault = callback
            if callback is None:
                return
            self._start()
        self._session.watch_faults()

    def close(self) -> None:
        """Closes the session and ends the thread. In a child of os.fork() it does nothing: both are the parent's."""
        if os.getpid() != self._process:
            return
        self._session.close()
        with self._lock:
            thread, left = self._thread, [each for group in self._goals.values() for each in group]
            self._goals.clear()
        for subscriber in left:
            subscriber.closed()
        # The last reference to a connection may go in a callback: a thread cannot join itself.
        if thread is not None and thread is not threading.current_thread():
            thread.join()

    def _start(self) -> None:
        if self._thread is None and not self._session.closed:
            self._thread = threading.Thread(target=self._run, name="hecaton-events", daemon=True)
            self._thread.start()

    def _run(self) -> None:
        while (event := self._session.next_event()) is not None:
            if isinstance(event, Fault):
                callback = self._on_fault
                if callback is not None:
                    _call(callback, event)
            else:
                self._deliver(event)

    def _deliver(self, progress: Progress) -> None:
        with self._lock:
            if progress.ended:
                subscribers = self._goals.pop(progress.goal, [])
            else:
                subscribers = list(self._goals.get(progress.goal, []))
        for subscriber in subscribers:
            _call(subscriber.progress, progress)


def _call(callback: Callable[[T], object], argument: T) -> None:
    """An exception of a callback is printed, as in other threads; the next event is delivered."""
    try:
        callback(argument)
    except Exception:
        sys.excepthook(*sys.exc_info())
