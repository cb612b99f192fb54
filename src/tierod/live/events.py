"""Events of a drive: to the terminal as JSON lines, and to programs over WebSocket."""

from __future__ import annotations

import contextlib
import json
import math
import threading
from collections.abc import Callable, Mapping
from typing import Any

from tierod.core.errors import InputError, MissingExtra

SCHEMA = 1
"""Version of the events: each is one JSON object with "event", "schema", and what `docs/how-to/run-live.md` lists."""


def line(kind: str, content: Mapping[str, Any]) -> str:
    """An event as one line of JSON; what is no number is null."""
    return json.dumps({"event": kind, "schema": SCHEMA, **_plain(dict(content))}, ensure_ascii=False, default=str)


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(name): _plain(each) for name, each in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


class Hub:
    """Gives every event to all who listen; one who fails is left out.

    `say` may be called from one thread only.
    """

    def __init__(self) -> None:
        self._listeners: list[Callable[[str], None]] = []

    def add(self, listener: Callable[[str], None]) -> None:
        """Give it all events from now on, a line each."""
        self._listeners.append(listener)

    def say(self, kind: str, content: Mapping[str, Any]) -> None:
        """Give an event to all listeners."""
        text = line(kind, content)
        for listener in list(self._listeners):
            try:
                listener(text)
            except BrokenPipeError:
                self._listeners.remove(listener)


class Socket:
    """A WebSocket server on this computer alone; who connects gets every event from then on.

    Args:
        port: on 127.0.0.1

    Raises:
        MissingExtra: websockets is not installed
        InputError: the port is taken
    """

    def __init__(self, port: int):
        try:
            from websockets.sync.server import ServerConnection, serve
        except ImportError:
            raise MissingExtra("websockets", "live", "events over WebSocket") from None
        self._clients: set[ServerConnection] = set()
        self._lock = threading.Lock()

        def handle(client: ServerConnection) -> None:
            with self._lock:
                self._clients.add(client)
            # Waits until the other end goes; what it sends is not looked at.
            with contextlib.suppress(Exception):
                for _ in client:
                    pass
            with self._lock:
                self._clients.discard(client)

        try:
            self._server = serve(handle, "127.0.0.1", port, max_size=1 << 16)
        except OSError as error:
            raise InputError(
                f"the port {port} cannot be opened ({error.strerror or error}); give another one"
            ) from None
        self.port = int(self._server.socket.getsockname()[1])
        threading.Thread(target=self._server.serve_forever, daemon=True).start()

    def __call__(self, text: str) -> None:
        """Send an event to all."""
        with self._lock:
            clients = list(self._clients)
        for client in clients:
            with contextlib.suppress(Exception):
                client.send(text)

    def close(self) -> None:
        """End the server."""
        self._server.shutdown()
