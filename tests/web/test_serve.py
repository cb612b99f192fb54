"""`tierod serve`: what it refuses in a sentence, and how it ends."""

import contextlib
import signal
import socket
import subprocess
import sys
import threading
import time
import urllib.request
from pathlib import Path

import pytest

import tierod
from tierod.cli import main
from tierod.core.errors import MissingExtra, ParameterError
from tierod.web import server
from tierod.web.app import application
from tierod.web.guard import Trust, own_names
from tierod.web.server import listening, outward, require_web, server_of, site_of, token_of
from tierod.web.site import Limits

pytest.importorskip("fastapi", reason="the extra 'web' is not installed")


def refused(words, capsys):
    assert main(["serve", "--no-browser", *words]) == 3
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.count("\n") == 1
    return printed.err


def test_a_port_in_use_is_a_sentence(capsys, tmp_path):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        said = refused([str(tmp_path), "--port", str(port), "--cache", str(tmp_path / "c")], capsys)
    assert f"the port {port} is in use" in said


@pytest.mark.parametrize(("words", "sentence"), [
    (["/nowhere-at-all"], "there is no /nowhere-at-all"),
    (["--port", "70000"], "give 0 to 65535"),
    (["--bind", "203.0.113.9"], "give an address of this machine"),
    (["--live", "can0", "--vehicle", "rav4"], "INTERFACE:CHANNEL"),
    (["--live", "udp_multicast:239.1.1.1"], "name the vehicle of the buses"),
    (["--live", "udp_multicast:239.1.1.1", "--vehicle", "midsize-eps"], "no CAN database"),
    (["--vehicle", "no-such-car"], "no-such-car"),
    (["--upload", "0"], "--upload needs a positive"),
    (["--workers", "0"], "at least one process"),
])  # fmt: skip
def test_what_cannot_be_served_is_a_sentence(words, sentence, capsys, tmp_path):
    port = [] if "--port" in words else ["--port", "0"]
    assert sentence in refused([*words, "--cache", str(tmp_path), *port], capsys)


def test_without_the_extra_the_command_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "fastapi", None)
    with pytest.raises(MissingExtra, match=r"pip install 'tierod\[web\]'"):
        require_web()


def test_a_token_is_long_enough_or_made(monkeypatch):
    monkeypatch.delenv(server.TOKEN, raising=False)
    assert len(token_of()) >= 32
    assert token_of() != token_of()
    monkeypatch.setenv(server.TOKEN, "short")
    with pytest.raises(ParameterError, match="16 or more"):
        token_of()
    monkeypatch.setenv(server.TOKEN, "long-enough-for-a-token")
    assert token_of() == "long-enough-for-a-token"


def test_without_paths_the_demo_is_served(tmp_path):
    made = site_of((), cache=tmp_path)
    assert made.demo
    assert (made.vehicle, made.roots[0].name, made.results[0].name) == ("midsize-eps", "demo", "demo-fleet")
    assert not site_of([tmp_path], cache=tmp_path).demo


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_the_server_ends_with_a_signal_and_takes_its_processes_along(number, tmp_path):
    words = ["serve", str(tmp_path), "--no-browser", "--port", "0", "--cache", str(tmp_path / "cache")]
    with subprocess.Popen([sys.executable, "-m", "tierod", *words], stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        address = process.stderr.readline().split("serving at ")[1].split(" ")[0]
        with urllib.request.urlopen(f"{address}api/site", timeout=20) as answer:
            assert tierod.__version__ in answer.read().decode()
        children = subprocess.run(["ps", "-o", "pid=", "--ppid", str(process.pid)], capture_output=True, text=True)
        process.send_signal(number)
        assert process.wait(timeout=20) == 0
        assert "Traceback" not in process.stderr.read()
    until = time.monotonic() + 10.0
    while any(map(alive, children.stdout.split())) and time.monotonic() < until:
        time.sleep(0.05)
    assert not any(map(alive, children.stdout.split()))


def alive(process):
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def test_every_address_is_shown_as_one_that_others_reach():
    shown = outward("0.0.0.0")
    assert shown not in ("0.0.0.0", "127.0.0.1")
    assert Trust(8765, "t" * 16, False, own_names()).host(f"{shown}:8765")


pytest.importorskip("fastapi", reason="the extra 'web' is not installed")


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


def test_the_page_is_answered_beside_many_half_open_requests(bench):
    patient = Limits(connections=20, header_time=60.0, body_pause=60.0)
    with served(bench, patient) as port, contextlib.ExitStack() as stack:
        begins = [HALF, BODY, ""]
        kept = [stack.enter_context(opened(port, begins[place % 3])) for place in range(60)]
        assert status(port) == 200
        assert ends_within(kept[0], 3.0)
        assert not ends_within(kept[-1], 0.2)


def test_a_header_that_comes_byte_by_byte_gets_no_more_time(bench):
    with served(bench) as port, opened(port, HALF) as made:
        until = time.monotonic() + 3.0
        ended = False
        while not ended and time.monotonic() < until:
            with contextlib.suppress(OSError):
                made.sendall(b"1")
            ended = ends_within(made, 0.1)
        assert ended
