"""What the terminal is told: addresses that work as they stand."""

from __future__ import annotations

from splinescope.browser.addresses import told_addresses

WHO = ("lab", "ada")


def test_a_page_of_this_machine_alone_needs_no_more() -> None:
    assert told_addresses("127.0.0.1", 8080, None, *WHO, {}) == [
        "SplineScope is at http://127.0.0.1:8080   (Ctrl+C ends it)"
    ]


def test_who_sits_behind_ssh_gets_the_command() -> None:
    lines = told_addresses("127.0.0.1", 8080, None, *WHO, {"SSH_CONNECTION": "10.0.0.9 5022 10.0.0.2 22"})
    assert lines[1:] == [
        "Through ssh: ssh -N -L 8080:localhost:8080 ada@10.0.0.2",
        "       then: http://localhost:8080",
    ]


def test_a_page_for_others_carries_its_token() -> None:
    lines = told_addresses("0.0.0.0", 9000, "s3cret", *WHO, {})
    assert lines[0].startswith("SplineScope is at http://lab:9000/?token=s3cret ")
    assert lines[1:] == [
        "Through ssh: ssh -N -L 9000:localhost:9000 ada@lab",
        "       then: http://localhost:9000/?token=s3cret",
    ]
    assert "9000:10.0.0.5:9000" in told_addresses("10.0.0.5", 9000, "s3cret", *WHO, {})[1]
