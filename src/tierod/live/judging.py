"""Judging of pieces in a thread, so that work of tens of milliseconds does not delay a tick."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor

from tierod.live.checkpoint import State
from tierod.live.engine import Engine, Piece

Collect = Callable[[], Mapping[str, State] | None]
"""Function that collects the states of the monitors for a checkpoint; None if no checkpoint is due."""


class Judging:
    """Judges one piece after another; the result does not depend on the scheduling of the thread.

    Args:
        threaded: whether a thread judges; else `begin` does
    """

    def __init__(self, threaded: bool):
        self._pool = ThreadPoolExecutor(1, "judge") if threaded else None
        self._piece: Piece | None = None
        self._future: Future[Mapping[str, State] | None] | None = None
        self._done: Mapping[str, State] | None = None

    @property
    def busy(self) -> bool:
        """Whether a piece is being judged, or was judged and is not settled yet."""
        return self._piece is not None

    def begin(self, engine: Engine, collect: Collect) -> None:
        """Judge the frames received so far; must not be called while `busy`.

        Args:
            engine: engine of the drive
            collect: called after the piece was judged
        """
        piece = self._piece = engine.cut()
        if piece is None:
            return

        def work() -> Mapping[str, State] | None:
            engine.work(piece)
            return collect()

        if self._pool is None:
            self._done = work()
        else:
            self._future = self._pool.submit(work)

    def ended(self, engine: Engine, wait: bool = False) -> tuple[bool, Mapping[str, State] | None]:
        """Whether a piece was judged since the last call, and the states collected; the ticks continue from it.

        Args:
            engine: engine of the drive
            wait: whether to wait for a piece that is being judged
        """
        if self._piece is None or (self._future is not None and not wait and not self._future.done()):
            return False, None
        found = self._done if self._future is None else self._future.result()
        piece, self._piece, self._future, self._done = self._piece, None, None, None
        engine.settle(piece)
        return True, found

    def close(self) -> None:
        """End the thread after its current work."""
        if self._pool is not None:
            self._pool.shutdown()
