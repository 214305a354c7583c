"""Tables and sentences as HTML text; everything that goes in is escaped."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

MARKED_ROW = '<tr class="on">'


def block(*parts: str) -> str:
    """A piece of a panel made of HTML parts that are escaped already."""
    return f'<div class="ss">{"".join(parts)}</div>'


def paragraph(text: str, kind: str = "") -> str:
    """A sentence; `kind` is "", "dim" or "bad"."""
    return f'<p class="{kind}">{escape(text)}</p>'


def heading(text: str) -> str:
    return f"<p><b>{escape(text)}</b></p>"


def bullets(texts: Iterable[str]) -> str:
    """A list of sentences."""
    return "<ul>" + "".join(f"<li>{escape(text)}</li>" for text in texts) + "</ul>"


def pairs(rows: Iterable[tuple[str, str]]) -> str:
    """Names and their values."""
    lines = (f'<tr><td class="dim">{escape(name)}</td><td class="n">{escape(value)}</td></tr>' for name, value in rows)
    return f"<table>{''.join(lines)}</table>"


def explained(rows: Iterable[tuple[str, str, str]]) -> str:
    """Names and their values, each with a sentence below; a name may be missing, with its value."""
    lines = (
        (f'<tr class="open"><td>{escape(name)}</td><td class="n">{escape(value)}</td></tr>' if name else "")
        + f'<tr><td class="dim" colspan="2">{escape(sentence)}</td></tr>'
        for name, value, sentence in rows
    )
    return f"<table>{''.join(lines)}</table>"


def table(
    headers: Sequence[str], rows: Iterable[Sequence[str]], *, numbers: Iterable[int] = (), marked: Iterable[int] = ()
) -> str:
    """A table; columns `numbers` are set to the right, rows `marked` are highlighted."""
    right, highlighted = set(numbers), set(marked)
    classes = [' class="n"' if column in right else "" for column in range(len(headers))]
    head = "".join(f"<th{kind}>{escape(text)}</th>" for kind, text in zip(classes, headers, strict=True))
    body = "".join(
        (MARKED_ROW if number in highlighted else "<tr>")
        + "".join(f"<td{kind}>{escape(text)}</td>" for kind, text in zip(classes, row, strict=True))
        + "</tr>"
        for number, row in enumerate(rows)
    )
    return f'<table class="dense"><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>'
