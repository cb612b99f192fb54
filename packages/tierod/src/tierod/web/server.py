"""`tierod.serve`: the server on a port, and the address that opens it."""

from __future__ import annotations

import contextlib
import errno
import os
import secrets
import socket
import sys
import threading
import webbrowser
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tierod.core.errors import InputError, MissingExtra, ParameterError
from tierod.core.files import expanded
from tierod.core.processes import stopped_by_sigterm

if TYPE_CHECKING:
    import uvicorn

    from tierod.web.guard import App
    from tierod.web.site import Limits, Site

LOOPBACK = "127.0.0.1"

EVERYWHERE = ("0.0.0.0", "::")  # Addresses that mean every address of this machine

LEAST_TOKEN = 16  # Smallest number of characters of a given token

TOKEN = "TIEROD_TOKEN"  # Environment variable that may hold the token


def serve(
    *paths: str | Path,
    vehicle: str | Path | None = None,
    dbc: Sequence[str | Path] = (),
    channel_map: str | Path | None = None,
    live: Sequence[str] = (),
    port: int = 8765,
    bind: str = LOOPBACK,
    cache: str | Path | None = None,
    workers: int | None = None,
    limits: Limits | None = None,
    browser: bool = False,
    say: Callable[[str], None] = lambda text: print(text, file=sys.stderr),
) -> None:
    """Serve the interactive page until it is stopped (Ctrl-C).

    Args:
        paths: folders of recordings or of results of `tierod fleet`, or single recordings; none: the demo
        vehicle: vehicle as which recordings are judged; if not given, the one named in each of them
        live: buses to follow, as INTERFACE:CHANNEL
        port: port of the server; 0 takes any free port
        bind: address of this machine to listen on; any but the loopback address requires a token, which is generated,
            or taken from the environment variable TIEROD_TOKEN
        browser: whether to open the page in a browser

    Raises:
        MissingExtra: the extra `web` is not installed
        InputError: a path does not exist, or the port is in use
        ParameterError: there is no such vehicle, or the token is too short
        OutputError: the cache cannot be written
    """
    require_web()
    from tierod.web.app import application
    from tierod.web.guard import Trust, own_names
    from tierod.web.jobs import workers_of
    from tierod.web.workbench import Workbench

    site = site_of(paths, vehicle, dbc, channel_map, live, cache, limits)
    loopback = bind in (LOOPBACK, "::1", "localhost")
    token, names = ("", ()) if loopback else (token_of(), own_names())
    with listening(bind, port) as sockets, Workbench(site, workers_of(workers)) as bench:
        taken = sockets.getsockname()[1]
        trust = Trust(taken, token, loopback, names, site.limits.upload, site.limits.body)
        shown = LOOPBACK if loopback else outward(bind) if bind in EVERYWHERE else bind
        address = f"http://{f'[{shown}]' if ':' in shown else shown}:{taken}/{f'?token={token}' if token else ''}"
        say(f"serving at {address} (Ctrl-C ends it)")
        if browser:
            threading.Timer(0.5, webbrowser.open, (address,)).start()
        # uvicorn raises the signal again after it has ended.
        with contextlib.suppress(KeyboardInterrupt), stopped_by_sigterm():
            server_of(application(bench, trust, _relay(site)), site.limits).run(sockets=[sockets])


def server_of(app: App, limits: Limits) -> uvicorn.Server:
    import uvicorn

    from tierod.web.connections import BoundedConfig

    return uvicorn.Server(BoundedConfig(app, limits, **_SERVER))


def outward(bind: str) -> str:
    """An address under which others reach this machine: that of the interface to the network, else its host name."""
    # Connecting a datagram socket selects its local address without sending anything.
    family, far = (socket.AF_INET6, "2001:db8::1") if ":" in bind else (socket.AF_INET, "192.0.2.1")
    with contextlib.suppress(OSError), socket.socket(family, socket.SOCK_DGRAM) as made:
        made.connect((far, 9))
        return str(made.getsockname()[0])
    return socket.gethostname()


_SERVER: dict[str, Any] = {
    "log_level": "error",
    "access_log": False,
    "lifespan": "on",
    "server_header": False,
    "ws_max_size": 1 << 16,
    "timeout_graceful_shutdown": 2,
    "h11_max_incomplete_event_size": 1 << 16,
    # So many connections are accepted before the first of them is looked at; the limit on connections allows for them.
    "backlog": 64,
}


def require_web() -> None:
    """Check that the libraries of the server are installed."""
    for library in ("fastapi", "uvicorn", "websockets"):
        try:
            __import__(library)
        except ImportError:
            raise MissingExtra(library, "web", "'tierod serve'") from None


def site_of(
    paths: Sequence[str | Path],
    vehicle: str | Path | None = None,
    dbc: Sequence[str | Path] = (),
    channel_map: str | Path | None = None,
    live: Sequence[str] = (),
    cache: str | Path | None = None,
    limits: Limits | None = None,
) -> Site:
    """The site to serve; arguments and errors as in `serve`."""
    from tierod.core import plugins as lab
    from tierod.vehicles import load
    from tierod.web.demo import folders
    from tierod.web.site import Limits, Root, Site, roots_of

    car = load(vehicle) if vehicle is not None else None
    place = Path(os.path.realpath(expanded(cache) if cache is not None else usual_cache()))
    recordings, results = roots_of(paths)
    demo = not paths and not live
    if demo:
        drives, fleet = folders(place / "demo")
        recordings, results = (Root("demo", drives),), (Root("demo-fleet", fleet),) if lab.installed() else ()
    given = str(vehicle) if vehicle is not None else "midsize-eps" if demo else ""
    known = tuple(str(expanded(each)) for each in dbc)
    used = str(expanded(channel_map)) if channel_map is not None else ""
    for each in live:
        interface, colon, channel = each.partition(":")
        if not (interface and colon and channel):
            raise ParameterError(f"--live is '{each}'; expected INTERFACE:CHANNEL, such as socketcan:can0")
    if live and not given:
        raise ParameterError("--live needs --vehicle: name the vehicle of the buses")
    if live and car is not None and not (known or car.database):
        raise ParameterError(f"--live: the vehicle '{car.name}' names no CAN database; give one with --dbc")
    made = Site(recordings, results, place, given, known, used, tuple(live), limits or Limits(), demo)
    return replace(made, vehicle=str(expanded(given).absolute()) if given.endswith(".toml") else given)


def usual_cache() -> Path:
    """Default cache folder of the user."""
    home = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    return expanded(home) / "tierod" / "web"


def token_of() -> str:
    """The token that requests from other computers must carry: from the environment, or a new one."""
    given = os.environ.get(TOKEN, "")
    if not given:
        return secrets.token_urlsafe(24)
    if len(given) < LEAST_TOKEN or not given.isascii() or not given.replace("-", "").replace("_", "").isalnum():
        raise ParameterError(
            f"{TOKEN} has {len(given)} characters; give {LEAST_TOKEN} or more letters, digits, - and _, or leave it out"
        )
    return given


@contextmanager
def listening(bind: str, port: int) -> Iterator[socket.socket]:
    family = socket.AF_INET6 if ":" in bind else socket.AF_INET
    with socket.socket(family, socket.SOCK_STREAM) as made:
        made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            made.bind((bind, port))
            made.listen(128)
        except (OSError, OverflowError) as error:
            raise InputError(_not_bound(bind, port, error)) from None
        yield made


def _not_bound(bind: str, port: int, error: Exception) -> str:
    number = error.errno if isinstance(error, OSError) else None
    if number == errno.EADDRINUSE:
        return f"the port {port} is in use; give another one with --port, or 0 for any that is free"
    if number in (errno.EACCES, errno.EPERM):
        return f"the port {port} may not be opened; give one above 1023 with --port"
    return f"{bind}:{port} cannot be opened ({error}); give an address of this machine with --bind, a port with --port"


def _relay(site: Site) -> Any:
    from tierod.web.relay import Relay

    if not site.live:
        return None
    words = ["-m", "tierod.web.following", "--vehicle", site.vehicle]
    words += [word for each in site.live for word in ("--live", each)]
    words += [word for each in site.dbc for word in ("--dbc", each)]
    return Relay([*words, *(["--map", site.channel_map] if site.channel_map else [])])
