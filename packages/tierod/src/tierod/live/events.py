"""Events of a drive: to the terminal as JSON lines, to programs over WebSocket, and to readers in this program.

A `Hub` passes every event to all listeners. `Events` serves a web server of this program: several readers, each with
a queue of its own, from threads or from coroutines:

    source = Events()
    hub.add(source)
    async for event in source.subscribed():  # dicts with "event", "schema" and what run-live.md lists
        await client.send_json(event)

A reader that joins in the middle of a drive first gets the newest `begin`, `state` and verdicts.
"""

from __future__ import annotations

import contextlib
import json
import threading
from collections import deque
from collections.abc import AsyncIterator, Callable, Generator, Iterable, Mapping
from typing import Any

from tierod.core.errors import InputError, MissingExtra
from tierod.report.document import plain

SCHEMA = 2
"""Version of the events: each is one JSON object with "event", "schema", and what `docs/how-to/run-live.md` lists."""


def line(kind: str, content: Mapping[str, Any]) -> str:
    """An event as one line of JSON; values that are not finite become null."""
    return json.dumps({"event": kind, "schema": SCHEMA, **plain(dict(content))}, ensure_ascii=False)


class Hub:
    """Passes every event to all listeners; a listener whose pipe is broken is removed.

    `say` may be called from any thread; events are passed on one at a time, while `lock` is held.
    """

    def __init__(self) -> None:
        # Reentrant: a listener may report a problem of its own while it receives an event.
        self.lock = threading.RLock()
        self._listeners: list[Callable[[str], None]] = []

    def add(self, listener: Callable[[str], None]) -> None:
        """Add a listener, which receives every event from now on as one line of JSON."""
        self._listeners.append(listener)

    def say(self, kind: str, content: Mapping[str, Any]) -> None:
        """Send an event to all listeners."""
        text = line(kind, content)
        with self.lock:
            for listener in list(self._listeners):
                try:
                    listener(text)
                except BrokenPipeError:
                    self._listeners.remove(listener)


class Watching:
    """Keeps track of the messages sent about a drive."""

    def __init__(self, hub: Hub):
        self._hub = hub
        self._said: set[str] = set()
        self._missing: dict[str, None] = {}

    def begin(self) -> None:
        """Forget all reports at the beginning of a drive."""
        self._said.clear()
        self._missing = {}

    def once(self, key: str, text: str) -> None:
        """Report a problem once per drive."""
        if key not in self._said:
            self._said.add(key)
            self._hub.say("problem", {"text": text})

    def missing(self, names: Iterable[str], time: float) -> None:
        """Report signals that have fallen silent, and signals that have returned.

        Args:
            time: time in the drive [s]
        """
        now = dict.fromkeys(names)
        for name in now.keys() - self._missing.keys():
            text = f"{name} is no longer received; monitors that need it do not judge"
            self._hub.say("problem", {"time": time, "signal": name, "text": text})
        for name in self._missing.keys() - now.keys():
            self._hub.say("signal", {"time": time, "signal": name, "text": f"{name} is received again"})
        self._missing = now


class Events:
    """Source of events for several readers; a slow reader loses the oldest events, and delays no other.

    Args:
        most: largest number of events that wait for a reader
    """

    def __init__(self, most: int = 1000):
        self._most = most
        self._lock = threading.Condition()
        self._queues: list[deque[dict[str, Any]]] = []
        self._latest: dict[str, dict[str, Any]] = {}
        self._closed = False

    def __call__(self, text: str) -> None:
        event = json.loads(text)
        kind = event["event"]
        with self._lock:
            if kind == "begin":
                self._latest.clear()
            if kind in ("begin", "state", "verdict"):
                self._latest[f"{kind} {event.get('monitor', '')}"] = event
            for queue in self._queues:
                queue.append(event)
            self._lock.notify_all()

    def close(self) -> None:
        """Let readers end after the events that are queued."""
        with self._lock:
            self._closed = True
            self._lock.notify_all()

    def read(self, pause: float | None = None) -> Generator[dict[str, Any], None, None]:
        """Events from now on, until `close`.

        Args:
            pause: time without an event after which an empty one is given, so that the reader gets control again [s]
        """
        queue: deque[dict[str, Any]] = deque(maxlen=self._most)
        with self._lock:
            queue.extend(self._latest.values())
            self._queues.append(queue)
        try:
            while True:
                with self._lock:
                    if not queue and not self._closed:
                        self._lock.wait(pause)
                    event = queue.popleft() if queue else None
                    if event is None and self._closed:
                        return
                if event is not None or pause is not None:
                    yield event or {}
        finally:
            with self._lock:
                self._queues[:] = [each for each in self._queues if each is not queue]

    async def subscribed(self) -> AsyncIterator[dict[str, Any]]:
        """Events for a coroutine, until `close`; it may be cancelled at any time."""
        import asyncio

        events = self.read(pause=0.2)
        try:
            while (event := await asyncio.to_thread(next, events, None)) is not None:
                if event:
                    yield event
        finally:
            # After a cancellation a thread may still run the generator, which cannot be closed until its next event.
            with contextlib.suppress(ValueError):
                events.close()


class Socket:
    """WebSocket server on this computer only; a client receives every event from its connection on.

    Args:
        port: port on 127.0.0.1; 0 takes a free one

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
            # Waits until the client disconnects; its messages are ignored.
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
        with self._lock:
            clients = list(self._clients)
        for client in clients:
            with contextlib.suppress(Exception):
                client.send(text)

    def close(self) -> None:
        """End the server."""
        self._server.shutdown()
