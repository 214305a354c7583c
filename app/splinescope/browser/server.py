"""The web server under the page: viser's own, serving our page root, refusing foreign origins and taken ports."""

from __future__ import annotations

import contextlib
import errno
import gzip
import hashlib
import hmac
import http
import io
import mimetypes
import socket
from collections.abc import Callable, Iterator
from functools import cache
from http.cookies import CookieError, SimpleCookie
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, unquote, urlsplit

import viser
import websockets.asyncio.server
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from bspline_slam.errors import ConfigError
from splinescope.paths import static_folder

LOOPBACK = ("127.0.0.1", "localhost", "::1")
ANY_ADDRESS = ("0.0.0.0", "::", "")
NO_TOKEN = (
    b"This page is open to those who know its token: use the whole address that SplineScope printed when it began.\n"
)
SCRIPT = """<link rel="stylesheet" href="static/style.css">
<script>window.splinescope = { waiting: [], receive(topic, value) { this.waiting.push([topic, value]); } };</script>
<script type="module" src="static/page.js"></script>
</head>"""


def page_html(title: str) -> str:
    """Viser's page with our title, icon, style sheet and script."""
    page = (Path(viser.__file__).parent / "client" / "build" / "index.html").read_text(encoding="utf-8")
    start = page.index("<link", page.index("<head>"))
    end = page.index("/>", start) + 2
    icon = '<link rel="icon" type="image/svg+xml" href="static/icon.svg">'
    page = page[:start] + icon + page[end:]
    page = page.replace("<title>Viser</title>", f"<title>{title}</title>", 1)
    page = page.replace('content="Viser client"', 'content="B-spline SLAM on laser logs, step by step"', 1)
    head, _, rest = page.rpartition("</head>")
    return head + SCRIPT + rest


def start_server(host: str, port: int, title: str, token: str | None = None) -> viser.ViserServer:
    """A running viewer on exactly this address (port 0: any free one), open to those who know the token where there is
    one; ConfigError when it cannot be had."""
    check_address(host, port)
    with _serving(page_html(title).encode(), host, token), contextlib.redirect_stdout(io.StringIO()):
        server = viser.ViserServer(host=host, port=port, verbose=False)
    if port not in (0, server.get_port()):
        stop_server(server)
        raise ConfigError(_taken(host, port))
    return server


def stop_server(server: viser.ViserServer) -> None:
    """End the server without its farewell on the terminal."""
    with contextlib.redirect_stdout(io.StringIO()):
        server.stop()


def check_address(host: str, port: int) -> None:
    """Raise ConfigError, with a sentence, when nothing can listen at this address."""
    if not 0 <= port <= 65535:
        raise ConfigError(f"a port lies between 0 and 65535, not {port}")
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(host or None, port, type=socket.SOCK_STREAM)[0]
        with socket.socket(family, kind, protocol) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind(address)
    except socket.gaierror as error:
        raise ConfigError(f"the address {host!r} is not known on this machine") from error
    except PermissionError as error:
        raise ConfigError(f"this user may not listen on port {port}: choose one above 1023") from error
    except OSError as error:
        if error.errno == errno.EADDRINUSE:
            raise ConfigError(_taken(host, port)) from error
        raise ConfigError(f"this machine cannot listen on {host}:{port}: {error.strerror}") from error


def _taken(host: str, port: int) -> str:
    return (
        f"port {port} of {host} is taken by another program: choose another with --port, or --port 0 for any free one"
    )


def same_origin(request: Request, host: str) -> bool:
    """Whether a websocket request comes from a page that this server itself has served.

    A page of another site names its own Origin. A name that was pointed at this machine to get round that is not a
    loopback name, so a server on the loopback address takes no other.
    """
    target = request.headers.get("Host", "")
    if request.headers.get("Origin") not in (f"http://{target}", f"https://{target}"):
        return False
    return host not in LOOPBACK or urlsplit(f"//{target}").hostname in LOOPBACK


def knows(request: Request, token: str) -> bool:
    """Whether a request carries the token: behind the address, or in the cookie that it was given for that."""
    told = parse_qs(urlsplit(request.path).query).get("token", [])
    cookies = SimpleCookie()
    with contextlib.suppress(CookieError):
        cookies.load(request.headers.get("Cookie", ""))
    kept = cookies.get(cookie_name(token))
    return any(hmac.compare_digest(each.encode(), token.encode()) for each in [*told, *([kept.value] if kept else [])])


def cookie_name(token: str) -> str:
    """One name per server, for cookies do not tell ports apart."""
    return "splinescope-" + hashlib.sha256(token.encode()).hexdigest()[:8]


def page_response(path: str, index: bytes) -> Response | None:
    """Our answer to a GET: the page, a file of static/, or None for what is viser's."""
    path = unquote(path.partition("?")[0])
    if path in ("/", "/index.html"):
        return _response(http.HTTPStatus.OK, index, "text/html; charset=utf-8")
    if not path.startswith("/static/"):
        return None
    root = static_folder().resolve()
    file = (root / path.removeprefix("/static/")).resolve()
    if not (file.is_file() and file.is_relative_to(root)):
        return _response(http.HTTPStatus.NOT_FOUND, b"not found", "text/plain")
    kind = "text/javascript" if file.suffix == ".js" else mimetypes.guess_type(file.name)[0]
    return _response(http.HTTPStatus.OK, file.read_bytes(), kind or "application/octet-stream")


@cache
def _compressed(body: bytes) -> bytes:
    return gzip.compress(body, 6)


def _admitting(response: Response, token: str) -> Response:
    """The same answer, with the token as a cookie that no script can read."""
    response.headers["Set-Cookie"] = f"{cookie_name(token)}={token}; Path=/; HttpOnly; SameSite=Strict"
    return response


def _response(status: http.HTTPStatus, body: bytes, kind: str) -> Response:
    body = _compressed(body)
    headers = Headers(
        {
            "Content-Type": kind,
            "Content-Encoding": "gzip",
            "Content-Length": str(len(body)),
            "Cache-Control": "no-cache",
            "X-Content-Type-Options": "nosniff",
            "X-Frame-Options": "SAMEORIGIN",
            "Referrer-Policy": "no-referrer",
        }
    )
    return Response(status.value, status.phrase, headers, body)


@contextlib.contextmanager
def _serving(index: bytes, host: str, token: str | None) -> Iterator[None]:
    """While it lasts, a websocket server that is started asks us first about every request.

    viser offers no hook for this, so the one function that it starts its server with is wrapped for that moment.
    """
    module = websockets.asyncio.server
    serve = module.serve

    def wrapped(*args: Any, process_request: Callable[..., Any], **rest: Any) -> Any:
        def ask_us_first(connection: Any, request: Request) -> Any:
            if token is not None and not knows(request, token):
                return _response(http.HTTPStatus.FORBIDDEN, NO_TOKEN, "text/plain; charset=utf-8")
            if request.headers.get("Upgrade", "").lower() == "websocket":
                if not same_origin(request, host):
                    return _response(http.HTTPStatus.FORBIDDEN, b"only the page itself may connect", "text/plain")
                return process_request(connection, request)
            ours = page_response(request.path, index)
            if ours is None:
                return process_request(connection, request)
            return ours if token is None else _admitting(ours, token)

        return serve(*args, process_request=ask_us_first, **rest)

    module.serve = wrapped
    try:
        yield
    finally:
        module.serve = serve
