"""The endpoint of the live buses."""

from __future__ import annotations

import asyncio
from contextlib import suppress

from fastapi import APIRouter, WebSocket
from starlette.websockets import WebSocketDisconnect

from tierod.web.relay import Relay


def live_endpoint(relay: Relay | None) -> APIRouter:
    """Endpoint of the live buses.

    Args:
        relay: relay of the buses; None for none
    """
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
