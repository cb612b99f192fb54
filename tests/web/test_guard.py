"""Only requests that mean this server, and come from its own page, get through."""

import pytest
from starlette.websockets import WebSocketDisconnect

from tierod.web.app import application
from tierod.web.guard import Trust
from tierod.web.relay import Relay
from web_client import TestClient

TOKEN = "a-token-of-enough-length"

LIVE = "ws://localhost:8765/api/live"


@pytest.fixture
def other(bench):
    """A server that others reach, on all addresses of the machine."""
    app = application(bench, Trust(8765, TOKEN, False, ("bench",)))
    with TestClient(app, base_url="http://192.168.1.5:8765") as made:
        yield made


@pytest.mark.parametrize("host", ["evil.com", "evil.com:8765", "localhost", "localhost:80", "192.168.1.5:8765", "",
                                  "localhost:8765@evil.com", "localhost.evil.com:8765", "[::1", "localhost:8765/x",
                                  "127.0.0.1:8765.evil.com", "localhost:99999"])  # fmt: skip
def test_other_hosts_are_refused(client, host):
    for path in ("/", "/api/site", "/static/main.js"):
        answer = client.get(path, headers={"host": host})
        assert answer.status_code == 403
        assert "error" in answer.json()


@pytest.mark.parametrize("headers", [
    {"origin": "http://evil.com"}, {"origin": "null"}, {"origin": "http://localhost:9999"}, {"origin": ""},
    {"origin": "http://["}, {"origin": "http://[::1"},
    {"sec-fetch-site": "cross-site"}, {"sec-fetch-site": "same-site"},
])  # fmt: skip
def test_other_sites_are_refused(client, headers):
    for method, path in (
        ("GET", "/api/site"),
        ("POST", "/api/analyses"),
        ("DELETE", "/api/jobs/x"),
        ("POST", "/api/uploads?name=a.csv"),
    ):
        answer = client.request(method, path, headers=headers)
        assert answer.status_code == 403
    assert client.get("/api/jobs").json() == []


def test_the_own_page_gets_through(client):
    own = {"origin": "http://localhost:8765", "sec-fetch-site": "same-origin"}
    assert client.get("/api/site", headers=own).status_code == 200
    assert client.get("/", headers={"sec-fetch-site": "cross-site"}).status_code == 200


def test_answers_carry_headers_that_shut_others_out(client):
    for path in ("/", "/api/site", "/static/main.js", "/api/nothing"):
        headers = client.get(path).headers
        assert "default-src 'none'" in headers["content-security-policy"]
        assert "unsafe" not in headers["content-security-policy"]
        assert headers["x-content-type-options"] == "nosniff"
        assert "access-control-allow-origin" not in headers


def test_without_a_token_others_see_the_page_alone(other):
    assert other.get("/").status_code == 200
    for path in ("/api/site", "/api/openapi.json", "/api/files"):
        answer = other.get(path)
        assert answer.status_code == 401
        assert "token" in answer.json()["error"]
    assert other.get("/api/site", headers={"authorization": f"Bearer {TOKEN}x"}).status_code == 401
    assert other.get("/api/site", headers={"cookie": "tierod="}).status_code == 401


def test_the_token_becomes_a_strict_cookie_and_leaves_the_address(other):
    answer = other.get(f"/fleet?token={TOKEN}", follow_redirects=False)
    assert answer.status_code == 303
    assert answer.headers["location"] == "/fleet"
    for word in ("HttpOnly", "SameSite=Strict"):
        assert word in answer.headers["set-cookie"]
    assert other.get("/api/site").status_code == 200
    assert other.get("/?token=wrong", follow_redirects=False).status_code == 200
    view = other.get(f"/recording?file=a%2Fb+c.csv&token={TOKEN}&from=1", follow_redirects=False)
    assert view.headers["location"] == "/recording?file=a%2Fb+c.csv&from=1"
    evil = other.get(f"/?token={TOKEN}&a=%0d%0ax:%20y", follow_redirects=False)
    assert evil.headers["location"] == "/?a=%0D%0Ax%3A+y"


def test_names_of_the_machine_are_known_and_no_others(other):
    own = {"authorization": f"Bearer {TOKEN}"}
    assert other.get("/api/site", headers={**own, "host": "bench:8765"}).status_code == 200
    assert other.get("/api/site", headers={**own, "host": "evil.com:8765"}).status_code == 403


def test_a_redirect_leads_nowhere_else(other):
    for path in ("//evil.com/", "/\\evil.com"):
        answer = other.get(f"{path}?token={TOKEN}", follow_redirects=False)
        assert not answer.headers.get("location", "/").startswith(("//", "/\\", "http"))


def test_a_socket_needs_the_own_origin(bench):
    app = application(
        bench, Trust(8765), Relay(["-c", 'import time; print(\'{"event": "x"}\', flush=True); time.sleep(9)'])
    )
    with TestClient(app, base_url="http://localhost:8765") as client:
        for origin in ({}, {"origin": "http://evil.com"}):
            with pytest.raises(WebSocketDisconnect), client.websocket_connect(LIVE, headers=origin):
                pass
        own = {"origin": "http://localhost:8765", "host": "localhost:8765"}
        with client.websocket_connect(LIVE, headers=own) as socket:
            assert socket.receive_json() == {"event": "x"}


def test_too_long_a_body_is_refused(client, bench):
    answer = client.post("/api/analyses", content=b"x" * (1 << 20), headers={"content-length": str(1 << 40)})
    assert answer.status_code == 413
    assert client.post("/api/analyses", content=b" " * ((1 << 20) + 9)).status_code == 413

    def parts():
        for _ in range(40):
            yield b"x" * (1 << 16)

    assert client.post("/api/uploads?name=big.csv", content=parts()).status_code == 413
    assert not list(bench.uploads.iterdir())
