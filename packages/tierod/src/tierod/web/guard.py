"""Checks of every request: host, origin, token and length of the body; and security headers of every answer.

A page of another site may send requests from the user's browser, and a name of another site may be made to resolve to
this machine (DNS rebinding). Only requests that name this server as host and come from its own page are passed on, and
only this page can read the answers.
"""

from __future__ import annotations

import hmac
import ipaddress
import json
import socket
from collections.abc import Awaitable, Callable, Mapping, MutableMapping
from dataclasses import dataclass
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import parse_qs, parse_qsl, urlencode, urlsplit

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

COOKIE = "tierod"

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; connect-src 'self'; "
    "frame-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)

REPORT_POLICY = (
    "sandbox allow-scripts allow-downloads allow-popups; default-src 'none'; script-src 'unsafe-inline'; "
    "style-src 'unsafe-inline'; img-src data: blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'self'"
)
"""Content security policy of a report, one file with inline scripts: it runs in a sandbox without any access."""

HEADERS = {
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "permissions-policy": "camera=(), microphone=(), geolocation=()",
    "content-security-policy": POLICY,
    "cache-control": "no-store",
}

SAFE = ("GET", "HEAD")


@dataclass(frozen=True)
class Trust:
    """Hosts, token and limits that the server trusts."""

    port: int
    token: str = ""  # token required of a request; "" if only this computer can reach the server
    loopback: bool = True  # whether only this computer can reach the server
    names: tuple[str, ...] = ()  # further names of this machine
    upload: int = 2 << 30  # upload, body: largest body of an upload, and of any other request [bytes]
    body: int = 1 << 20

    def host(self, given: str) -> bool:
        """Whether the host that a request names is this server."""
        try:
            parts = urlsplit(f"//{given}")
            name, port = (parts.hostname or "").rstrip("."), parts.port or 80
        except ValueError:
            return False
        if port != self.port or parts.username or parts.path or parts.query:
            return False
        if name in ("localhost", "127.0.0.1", "::1"):
            return True
        if self.loopback:
            return False
        try:
            # An address, unlike a name, cannot be redirected here by another site.
            ipaddress.ip_address(name)
        except ValueError:
            return name.lower() in self.names
        return True

    def let_in(self, given: str) -> bool:
        """Whether a token is correct; always true if none is required."""
        return not self.token or hmac.compare_digest(given.encode(), self.token.encode())


def own_names() -> tuple[str, ...]:
    """Host names under which others can reach this machine."""
    name = socket.gethostname().lower()
    return tuple(dict.fromkeys((name, name.partition(".")[0])))


class Guard:
    """ASGI middleware that passes trusted requests on to an application.

    Args:
        open_to_all: prefixes of paths without user data: the files of the page
    """

    def __init__(self, app: App, trust: Trust, open_to_all: tuple[str, ...] = ("/static/",)):
        self.app, self.trust, self.open = app, trust, open_to_all

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        headers = {name.decode("latin-1"): value.decode("latin-1") for name, value in scope["headers"]}
        status, sentence = self._refusal(scope, headers)
        if status:
            await _refused(scope, receive, send, status, sentence)
            return
        if scope["type"] == "http" and (token := self._brought(scope)) and self.trust.token:
            await _into_cookie(scope, send, token, self.trust)
            return
        # Partial answers are not supported: every answer is complete.
        scope["headers"] = [each for each in scope["headers"] if each[0] not in (b"range", b"if-range")]
        counted = _counted(receive, self._limit(scope))
        await self.app(scope, counted, _secured(send) if scope["type"] == "http" else send)

    def _refusal(self, scope: Scope, headers: Mapping[str, str]) -> tuple[int, str]:
        """(status, sentence) of a refusal; (0, "") if the request may pass."""
        hosts = [value for name, value in scope["headers"] if name == b"host"]
        if len(hosts) != 1 or not self.trust.host(headers.get("host", "")):
            return 403, "the request names another host; open the address that 'tierod serve' prints"
        page = scope["type"] == "http" and scope["method"] in SAFE and not scope["path"].startswith("/api/")
        if not page:
            origin = headers.get("origin")
            if origin is not None and _place(origin) != headers["host"]:
                return 403, "the request comes from another site; open the page of this server itself"
            if headers.get("sec-fetch-site", "same-origin") not in ("same-origin", "none"):
                return 403, "the request comes from another site; open the page of this server itself"
            if scope["type"] == "websocket" and origin is None:
                return 403, "a connection without origin is refused; open the page of this server"
        bearer = headers.get("authorization", "").removeprefix("Bearer ")
        if page or self.trust.let_in(_cookie(headers.get("cookie", "")) or bearer):
            return self._length(scope, headers)
        return 401, "the token is missing; open the whole address that 'tierod serve' has printed, with its token"

    def _limit(self, scope: Scope) -> int:
        return self.trust.upload if scope["path"] == "/api/uploads" else self.trust.body

    def _length(self, scope: Scope, headers: Mapping[str, str]) -> tuple[int, str]:
        limit = self._limit(scope)
        length = headers.get("content-length", "0")
        if not length.isdecimal() or len(length) > 18:
            return 400, "the length of the request is not a number"
        if int(length) > limit:
            return 413, f"the request is longer than {limit >> 20} MiB; give a smaller file, or its path"
        return 0, ""

    def _brought(self, scope: Scope) -> str:
        """The correct token in the address of the page; "" if there is none."""
        given = parse_qs(scope.get("query_string", b"").decode("latin-1")).get("token", [""])[0]
        page = scope["method"] in SAFE and not scope["path"].startswith(("/api/", *self.open))
        return given if given and page and self.trust.let_in(given) else ""


def _place(origin: str) -> str:
    """Host and port of an origin; "" if it is malformed."""
    try:
        return urlsplit(origin).netloc
    except ValueError:
        return ""


def _cookie(header: str) -> str:
    try:
        found = SimpleCookie(header).get(COOKIE)
    except CookieError:
        return ""
    return found.value if found else ""


async def _refused(scope: Scope, receive: Receive, send: Send, status: int, sentence: str) -> None:
    if scope["type"] == "websocket":
        # ASGI: the connect event comes before a connection can be refused.
        await receive()
        await send({"type": "websocket.close", "code": 1008, "reason": sentence})
        return
    headers = {"content-type": "application/json"}
    if status in (401, 403):
        # The body of a request that is not trusted is not waited for.
        headers["connection"] = "close"
    await _answer(send, status, headers, json.dumps({"error": sentence}).encode())


async def _into_cookie(scope: Scope, send: Send, token: str, trust: Trust) -> None:
    cookie = f"{COOKIE}={token}; HttpOnly; SameSite=Strict; Path=/; Max-Age=2592000"
    # Leading slashes are reduced to one, since "//host" would lead to another site.
    place = "/" + scope["path"].lstrip("/\\")
    target = place if place.isascii() and place.isprintable() and "\\" not in place else "/"
    given = parse_qsl(scope.get("query_string", b"").decode("latin-1"))
    if rest := urlencode([each for each in given if each[0] != "token"]):
        target += f"?{rest}"
    await _answer(send, 303, {"location": target, "set-cookie": cookie}, b"")


async def _answer(send: Send, status: int, headers: Mapping[str, str], body: bytes) -> None:
    every = {**HEADERS, **headers, "content-length": str(len(body))}
    lines = [(name.encode(), value.encode()) for name, value in every.items()]
    await send({"type": "http.response.start", "status": status, "headers": lines})
    await send({"type": "http.response.body", "body": body})


class BodyTooLong(Exception):
    """A body without stated length that exceeds the limit."""


def _counted(receive: Receive, limit: int) -> Receive:
    taken = 0

    async def counted() -> MutableMapping[str, Any]:
        nonlocal taken
        message = await receive()
        if message["type"] == "http.request":
            taken += len(message.get("body", b""))
            if taken > limit:
                raise BodyTooLong
        return message

    return counted


def _secured(send: Send) -> Send:
    async def secured(message: MutableMapping[str, Any]) -> None:
        if message["type"] == "http.response.start":
            own = {name.lower() for name, _ in message["headers"]}
            message["headers"] = [
                *message["headers"],
                *((name.encode(), value.encode()) for name, value in HEADERS.items() if name.encode() not in own),
            ]
        await send(message)

    return secured
