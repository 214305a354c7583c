"""The page comes from a server of ours, and strangers stay out."""

from __future__ import annotations

import gzip
import socket
from urllib.error import HTTPError
from urllib.request import urlopen

import pytest
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect
from websockets.typing import Origin

from app.chromium import Opener
from bspline_slam.errors import ConfigError
from splinescope.actions import described
from splinescope.browser.page import Page, open_page


def test_the_page_is_ours() -> None:
    page = open_page("127.0.0.1", 0, title="A title of ours")
    try:
        with urlopen(page.url, timeout=10) as answer:
            text = gzip.decompress(answer.read()).decode()
    finally:
        page.stop()
    assert "<title>A title of ours</title>" in text
    assert text.count("static/page.js") == 1
    assert 'href="static/icon.svg"' in text


@pytest.mark.parametrize("path", ["static/none.js", "static/../page.py", "static/%2e%2e/pyproject.toml", "static/"])
def test_only_files_of_the_page_are_served(page: Page, path: str) -> None:
    with pytest.raises(HTTPError, match="404"):
        urlopen(f"{page.url}/{path}", timeout=10)


def test_a_taken_port_is_refused_with_a_sentence() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        with pytest.raises(ConfigError, match="is taken by another program: choose another with --port"):
            open_page("127.0.0.1", taken.getsockname()[1])


@pytest.mark.parametrize(
    ("host", "port", "sentence"),
    [
        ("no-such-host.invalid", 0, "is not known on this machine"),
        ("203.0.113.7", 0, "cannot listen on 203.0.113.7"),
        ("127.0.0.1", 70000, "between 0 and 65535"),
    ],
)
def test_an_impossible_address_is_refused_with_a_sentence(host: str, port: int, sentence: str) -> None:
    with pytest.raises(ConfigError, match=sentence):
        open_page(host, port)


@pytest.mark.parametrize("origin", ["http://evil.example", "http://127.0.0.1:1", None])
def test_other_sites_cannot_connect(page: Page, origin: str | None) -> None:
    with pytest.raises(InvalidStatus, match="403"), connect(page.url.replace("http", "ws"), origin=origin):  # pyright: ignore[reportArgumentType]
        pass


def test_a_name_pointed_at_this_machine_cannot_connect(page: Page) -> None:
    port = page.server.get_port()
    name = f"evil.example:{port}"
    with socket.create_connection(("127.0.0.1", port), timeout=10) as line:
        lines = [f"GET / HTTP/1.1\r\nHost: {name}\r\nOrigin: http://{name}\r\n"]
        lines.append("Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n")
        lines.append("Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n")
        line.sendall("".join(lines).encode())
        assert b"403" in line.recv(64)


def test_beyond_this_machine_only_who_knows_the_token_gets_in(open_window: Opener) -> None:
    page = open_page("0.0.0.0", 0)
    try:
        assert page.token is not None
        page.send("actions", described())
        for path in ("", "/static/page.js", "/?token=", "/?token=wrong"):
            with pytest.raises(HTTPError, match="403"):
                urlopen(f"{page.url}{path}", timeout=10)
        with (
            pytest.raises(InvalidStatus, match="403"),
            connect(page.url.replace("http", "ws"), origin=Origin(page.url)),
        ):
            pass
        with urlopen(page.address, timeout=10) as answer:
            cookie = answer.headers["Set-Cookie"]
        assert page.token in cookie and "HttpOnly" in cookie and "SameSite=Strict" in cookie
        window = open_window(page.address)
        assert page.token not in window.page.url
        assert len(page.server.get_clients()) == 1
    finally:
        page.stop()
