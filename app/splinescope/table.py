"""Tables and sentences as HTML text; everything that goes in is escaped."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

from splinescope.typeset import typeset


class Html(str):
    """Text that is HTML already: everything in it is escaped."""

    __slots__ = ()


def escaped(text: str) -> str:
    """Text as HTML, typeset; what is HTML already stays as it is."""
    return text if isinstance(text, Html) else escape(typeset(text))


def block(*parts: str) -> str:
    """A piece of a panel made of HTML parts that are escaped already."""
    return f'<div class="ss">{"".join(parts)}</div>'


def paragraph(text: str, kind: str = "") -> str:
    """A sentence; `kind` is "", "dim" or "bad"."""
    return f'<p class="{kind}">{escaped(text)}</p>'


def heading(text: str) -> str:
    return f"<p><b>{escaped(text)}</b></p>"


def bullets(texts: Iterable[str]) -> str:
    """A list of sentences."""
    return "<ul>" + "".join(f"<li>{escaped(text)}</li>" for text in texts) + "</ul>"


def pairs(rows: Iterable[tuple[str, str]]) -> str:
    """Names and their values."""
    lines = (
        f'<tr><td class="dim">{escaped(name)}</td><td class="n">{escaped(value)}</td></tr>' for name, value in rows
    )
    return f'<table class="pairs">{"".join(lines)}</table>'


def explained(rows: Iterable[tuple[str, str, str]]) -> str:
    """Names and their values, each with a sentence below; a name may be missing, with its value."""
    lines = (
        (f'<tr class="open"><td>{escaped(name)}</td><td class="n">{escaped(value)}</td></tr>' if name else "")
        + f'<tr><td class="dim" colspan="2">{escaped(sentence)}</td></tr>'
        for name, value, sentence in rows
    )
    return f"<table>{''.join(lines)}</table>"


def leading(
    name: str, headers: Sequence[str], rows: Iterable[tuple[int, Sequence[str], str]], *, selected: int | None = None
) -> str:
    """A table whose rows lead somewhere: each has a number that a click on it tells with `name`, its cells, which may
    be HTML, and a sentence below them, which may be empty."""
    parts = []
    for number, cells, sentence in rows:
        lead = f'data-row="{escape(name)}" data-number="{number}"'
        state = " on" if number == selected else ""
        kind = f"lead{' open' if sentence else ''}{state}"
        first, *rest = map(escaped, cells)
        others = "".join(f'<td class="n">{cell}</td>' for cell in rest)
        parts.append(f'<tr class="{kind}" {lead}><td><button>{first}</button></td>{others}</tr>')
        if sentence:
            reason = f'<td class="dim wrap" colspan="{len(headers)}">{escaped(sentence)}</td>'
            parts.append(f'<tr class="lead{state}" {lead}>{reason}</tr>')
    head = "".join(f"<th{kind}>{escaped(text)}</th>" for kind, text in zip(_right(headers), headers, strict=True))
    return f'<table class="dense"><thead><tr>{head}</tr></thead><tbody>{"".join(parts)}</tbody></table>'


def lead(name: str, number: int, words: str) -> Html:
    """A button in a row that leads elsewhere than the row does."""
    return Html(f'<button data-row="{escape(name)}" data-number="{number}">{escape(words)}</button>')


def _right(headers: Sequence[str]) -> list[str]:
    return ["", *(' class="n"' for _ in headers[1:])]


def table(headers: Sequence[str], rows: Iterable[Sequence[str]], *, numbers: Iterable[int] = ()) -> str:
    """A table; columns `numbers` are set to the right."""
    right = set(numbers)
    classes = [' class="n"' if column in right else "" for column in range(len(headers))]
    head = "".join(f"<th{kind}>{escaped(text)}</th>" for kind, text in zip(classes, headers, strict=True))
    body = "".join(
        "<tr>" + "".join(f"<td{kind}>{escaped(text)}</td>" for kind, text in zip(classes, row, strict=True)) + "</tr>"
        for row in rows
    )
    return f'<table class="dense"><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>'
