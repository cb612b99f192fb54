"""Half-open requests: they end after some time, and the page is answered beside any number of them."""

import contextlib
import json
import socket
import threading
import time
import urllib.request

import pytest

pytest.importorskip("fastapi", reason="the extra 'web' is not installed")

from tierod.web.app import application
from tierod.web.guard import Trust
from tierod.web.server import listening, server_of
from tierod.web.site import Limits

TOKEN = "a-token-of-enough-length"
LIMITS = Limits(connections=20, header_time=0.5, body_pause=0.5)


@contextlib.contextmanager
def served(bench, limits=LIMITS, token=""):
    with listening("127.0.0.1", 0) as sockets:
        port = sockets.getsockname()[1]
        server = server_of(application(bench, Trust(port, token, not token)), limits)
        thread = threading.Thread(target=server.run, kwargs={"sockets": [sockets]})
        thread.start()
        try:
            while not server.started:
                time.sleep(0.01)
            yield port
        finally:
            server.should_exit = True
            thread.join(10.0)


def opened(port, begin):
    made = socket.create_connection(("127.0.0.1", port), timeout=5.0)
    made.sendall(begin.replace("PORT", str(port)).encode())
    return made


def ends_within(made, seconds):
    """Whether the server ends a connection within a time [s]; what it sends before is read."""
    until = time.monotonic() + seconds
    made.settimeout(0.1)
    while time.monotonic() < until:
        try:
            if not made.recv(1 << 16):
                return True
        except TimeoutError:
            continue
        except OSError:
            return True
    return False


def status(port):
    with urllib.request.urlopen(f"http://127.0.0.1:{port}/api/site", timeout=5.0) as answer:
        return answer.status


HALF = "GET / HTTP/1.1\r\nHost: 127"
BODY = "POST /api/analyses HTTP/1.1\r\nHost: 127.0.0.1:PORT\r\nContent-Length: 1000\r\n\r\n{"


@pytest.mark.parametrize("begin", ["", HALF, BODY])
def test_a_request_that_never_ends_is_closed(bench, begin):
    with served(bench) as port, opened(port, begin) as made:
        assert not ends_within(made, 0.2)
        assert ends_within(made, 3.0)


def test_a_header_that_comes_byte_by_byte_gets_no_more_time(bench):
    with served(bench) as port, opened(port, HALF) as made:
        until = time.monotonic() + 3.0
        ended = False
        while not ended and time.monotonic() < until:
            with contextlib.suppress(OSError):
                made.sendall(b"1")
            ended = ends_within(made, 0.1)
        assert ended


def test_the_second_request_of_a_connection_has_its_own_time(bench):
    whole = "GET /api/site HTTP/1.1\r\nHost: 127.0.0.1:PORT\r\n\r\n"
    with served(bench) as port, opened(port, whole) as made:
        assert not ends_within(made, 0.7), "a connection between requests is kept"
        for _ in range(2):
            made.sendall(whole.replace("PORT", str(port)).encode())
            made.settimeout(5.0)
            assert made.recv(1 << 16).startswith(b"HTTP/1.1 200")
            assert not ends_within(made, 0.7), "a connection between requests is kept"
        made.sendall(HALF.encode())
        assert ends_within(made, 3.0)


def test_the_page_is_answered_beside_many_half_open_requests(bench):
    patient = Limits(connections=20, header_time=60.0, body_pause=60.0)
    with served(bench, patient) as port, contextlib.ExitStack() as stack:
        begins = [HALF, BODY, ""]
        kept = [stack.enter_context(opened(port, begins[place % 3])) for place in range(60)]
        assert status(port) == 200
        assert ends_within(kept[0], 3.0)
        assert not ends_within(kept[-1], 0.2)


def test_a_body_without_the_token_is_not_waited_for(bench):
    with served(bench, Limits(), TOKEN) as port, opened(port, BODY) as made:
        answer = b""
        while part := made.recv(1 << 16):
            answer += part
        assert answer.startswith(b"HTTP/1.1 401")
        assert "token" in json.loads(answer.partition(b"\r\n\r\n")[2])["error"]
