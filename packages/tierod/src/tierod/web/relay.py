"""Relay between the process that follows the live buses and the pages that show them, and its endpoint."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Sequence
from contextlib import suppress

from fastapi import APIRouter, WebSocket
from starlette.websockets import WebSocketDisconnect

from tierod.core.processes import interpreter
from tierod.live.events import line as event

KEPT = 3000  # Number of past lines that a new page receives: the last minutes

WAITING = 2000  # Number of lines that may wait for a slow page, beside the past ones, before it loses the oldest


class Relay:
    """Starts the process that follows the buses, and passes its lines to listeners.

    Args:
        command: command of the process, which prints one JSON object per line
    """

    def __init__(self, command: Sequence[str]):
        self._command = list(command)
        self._listeners: set[asyncio.Queue[str]] = set()
        self._past: deque[str] = deque(maxlen=KEPT)
        self._process: asyncio.subprocess.Process | None = None
        self._tasks: list[asyncio.Task[None]] = []
        self._ending = False

    async def begin(self) -> None:
        """Start the process."""
        self._tasks.append(asyncio.create_task(self._follow()))

    async def end(self) -> None:
        """End the process and the tasks that read it."""
        self._ending = True
        if self._process is not None and self._process.returncode is None:
            self._process.terminate()
            try:
                await asyncio.wait_for(self._process.wait(), 5.0)
            except TimeoutError:
                self._process.kill()
        for task in self._tasks:
            task.cancel()

    def listen(self) -> asyncio.Queue[str]:
        """Queue of a new listener, which begins with the past lines."""
        queue: asyncio.Queue[str] = asyncio.Queue(KEPT + WAITING)
        for line in self._past:
            queue.put_nowait(line)
        self._listeners.add(queue)
        return queue

    def leave(self, listener: asyncio.Queue[str]) -> None:
        self._listeners.discard(listener)

    def give(self, line: str) -> None:
        """Pass a line to all listeners; a slow listener loses its oldest line."""
        self._past.append(line)
        for queue in self._listeners:
            if queue.full():
                queue.get_nowait()
            queue.put_nowait(line)

    async def _follow(self) -> None:
        pipe = asyncio.subprocess.PIPE
        self._process = await asyncio.create_subprocess_exec(
            *interpreter(*self._command), stdout=pipe, stderr=pipe, limit=1 << 22
        )
        assert self._process.stdout is not None
        assert self._process.stderr is not None
        errors = asyncio.create_task(self._process.stderr.read())
        while line := await self._process.stdout.readline():
            self.give(line.decode("utf-8", "replace").rstrip("\n"))
        said = (await errors).decode("utf-8", "replace").strip().splitlines()
        if not self._ending:
            text = said[-1].removeprefix("tierod: ") if said else "the process that follows the buses has ended"
            self.give(event("problem", {"text": f"{text}; end the server and start it again"}))


def live_endpoint(relay: Relay | None) -> APIRouter:
    router = APIRouter(prefix="/api", tags=["live"])

    @router.websocket("/live")
    async def live(socket: WebSocket) -> None:
        """Events and samples as they arrive, each as one JSON object."""
        if relay is None:
            await socket.close(1008, "no bus is followed; begin with 'tierod serve --live INTERFACE:CHANNEL'")
            return
        await socket.accept()
        listener = relay.listen()
        going = asyncio.create_task(_until_gone(socket))
        try:
            while not going.done():
                text = await _next(listener, going)
                if text is not None:
                    await socket.send_text(text)
        except (WebSocketDisconnect, RuntimeError):
            pass
        finally:
            relay.leave(listener)
            going.cancel()
            with suppress(Exception):
                await socket.close()

    return router


async def _until_gone(socket: WebSocket) -> None:
    with suppress(WebSocketDisconnect, RuntimeError):
        while True:
            await socket.receive_text()


async def _next(listener: asyncio.Queue[str], going: asyncio.Task[None]) -> str | None:
    """The next line; None if the client has disconnected."""
    getting = asyncio.create_task(listener.get())
    await asyncio.wait((getting, going), return_when=asyncio.FIRST_COMPLETED)
    if getting.done():
        return getting.result()
    getting.cancel()
    return None
