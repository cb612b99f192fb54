"""Connections of the server: half-open ones end after some time, and never keep others from being answered."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any

import h11
import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol

if TYPE_CHECKING:
    from tierod.web.site import Limits


class BoundedConnection(H11Protocol):
    """A connection with a time limit for the header of a request, and for pauses within its body."""

    config: BoundedConfig
    _timer: asyncio.TimerHandle | None = None
    _since = 0.0

    def connection_made(self, transport: Any) -> None:
        """Begin; beyond the largest number, the connection ends that has waited longest for its own client."""
        super().connection_made(transport)
        self._since = self.loop.time()
        if len(self.connections) > self.config.limits.connections:
            waiting = [each for each in self.connections if isinstance(each, BoundedConnection) and each.waits]
            min(waiting or [self], key=lambda each: each._since).drop()
        self._watch(self.config.limits.header_time)

    @property
    def waits(self) -> bool:
        """Whether the client still owes a part of its request."""
        return self.conn.their_state in (h11.IDLE, h11.SEND_BODY)

    def data_received(self, data: bytes) -> None:
        """Handle the next bytes; the time for a header runs from its first byte, that of a body is one pause."""
        before, limits = self.conn.their_state, self.config.limits
        super().data_received(data)
        if not self.waits:
            self._watch(None)
        elif self.conn.their_state is not before or before is h11.SEND_BODY or self._timer is None:
            self._since = self.loop.time()
            self._watch(limits.header_time if self.conn.their_state is h11.IDLE else limits.body_pause)

    def on_response_complete(self) -> None:
        """Wait for the next request of the client."""
        super().on_response_complete()
        if self.conn.their_state is not h11.SEND_BODY:
            self._watch(None)

    def connection_lost(self, exc: Exception | None) -> None:
        """End."""
        self._watch(None)
        super().connection_lost(exc)

    def drop(self) -> None:
        """End the connection at once."""
        self.connections.discard(self)
        self.transport.abort()

    def _watch(self, seconds: float | None) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._timer = None if seconds is None else self.loop.call_later(seconds, self._late)

    def _late(self) -> None:
        if self.waits:
            self.drop()


class BoundedConfig(uvicorn.Config):
    """Configuration of a server whose connections have limits."""

    def __init__(self, app: Any, limits: Limits, **others: Any):
        super().__init__(app, http=BoundedConnection, **others)
        self.limits = limits
