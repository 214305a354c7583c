"""Where the page is, in lines for the terminal: an address that works as it stands, and the ssh command for it."""

from __future__ import annotations

from collections.abc import Mapping

from splinescope.browser.server import ANY_ADDRESS, LOOPBACK


def told_addresses(
    host: str, port: int, token: str | None, name: str, user: str, environment: Mapping[str, str]
) -> list[str]:
    """Lines to print; `name` is that of this machine, `user` the person's on it.

    A page beyond the loopback address carries its token. Somebody who sits at the other end of ssh, as `environment`
    tells, gets the command that brings a page on the loopback address there.
    """
    secret = f"/?token={token}" if token else ""
    seen = host if host not in ANY_ADDRESS else name
    lines = [f"SplineScope is at http://{seen}:{port}{secret}   (Ctrl+C ends it)"]
    if token is None and "SSH_CONNECTION" not in environment:
        return lines
    inner = host if host not in (*ANY_ADDRESS, *LOOPBACK) else "localhost"
    reached = environment.get("SSH_CONNECTION", "").split()
    machine = reached[2] if len(reached) == 4 else name
    lines.append(f"Through ssh: ssh -N -L {port}:{inner}:{port} {user}@{machine}")
    lines.append(f"       then: http://localhost:{port}{secret}")
    return lines
