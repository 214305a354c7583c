"""Links to a moment: what they say comes back, and nonsense in them is named."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from splinescope.browser.link import Link
from splinescope.view import Colouring, Layer

links = st.builds(
    Link,
    st.none() | st.integers(0, 99999),
    st.none() | st.frozensets(st.sampled_from(Layer)),
    st.none()
    | st.tuples(st.integers(-99, 99), st.integers(-99, 99), st.integers(1, 9)).map(lambda p: (*p[:2], p[2] / 64)),
    st.none() | st.sampled_from(Colouring),
)


@given(link=links)
def test_a_link_says_what_it_was_made_of(link: Link) -> None:
    assert Link.parse(link.query) == link
    assert Link.parse(f"?fixedDpr=1&{link.query}") == link
    assert link.empty == (link.query == "")


@given(query=st.text())
def test_no_words_behind_an_address_are_too_strange(query: str) -> None:
    Link.parse(query)
    Link.parse(f"scan={query}&camera={query}&layers={query}&colour={query}")


def test_nonsense_is_named_and_the_rest_is_followed() -> None:
    link = Link.parse("scan=12&camera=1,2&layers=beams,smell&colour=warm")
    assert link.scan == 12
    assert link.layers == {Layer.BEAMS}
    assert link.place is None and link.colouring is None
    assert link.nonsense == ("camera=1,2", "colour=warm", "layer smell")
    assert Link.parse("scan=-3").nonsense == ("scan=-3",)
