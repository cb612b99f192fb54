"""Judging of pieces in a thread, so that work of tens of milliseconds delays neither log nor display."""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor

from tierod.live.engine import Engine, Piece


class Judging:
    """Judges one piece after another; the result does not depend on the scheduling of the thread.

    Args:
        threaded: whether a thread judges; else `begin` does
    """

    def __init__(self, threaded: bool):
        self._pool = ThreadPoolExecutor(1, "judge") if threaded else None
        self._piece: Piece | None = None
        self._future: Future[None] | None = None

    @property
    def busy(self) -> bool:
        """Whether a piece is being judged, or was judged and is not settled yet."""
        return self._piece is not None

    def begin(self, engine: Engine) -> None:
        """Judge the frames received so far; must not be called while `busy`.

        Args:
            engine: engine of the drive
        """
        piece = self._piece = engine.cut()
        if piece is None:
            return
        if self._pool is None:
            engine.work(piece)
        else:
            self._future = self._pool.submit(engine.work, piece)

    def ended(self, engine: Engine, wait: bool = False) -> bool:
        """Whether a piece was judged since the last call.

        Args:
            engine: engine of the drive
            wait: whether to wait for a piece that is being judged
        """
        if self._piece is None or (self._future is not None and not wait and not self._future.done()):
            return False
        if self._future is not None:
            self._future.result()
        piece, self._piece, self._future = self._piece, None, None
        engine.settle(piece)
        return True

    def close(self) -> None:
        """End the thread after its current work."""
        if self._pool is not None:
            self._pool.shutdown()
