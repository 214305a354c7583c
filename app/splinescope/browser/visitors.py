"""One driver, many watchers: who looks at the page, and who of them may change what all see."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace


@dataclass(frozen=True, slots=True)
class Visitors:
    """The names that pages gave themselves, by client, and which client drives (None: nobody who is still here).

    `last` is the name of the driver; a page that is loaded again comes back under its old name and drives on.
    """

    names: Mapping[int, str] = field(default_factory=dict)
    driver: int | None = None
    last: str = ""

    @property
    def watchers(self) -> tuple[int, ...]:
        """All clients but the driver."""
        return tuple(client for client in self.names if client != self.driver)

    def came(self, client: int, name: str) -> Visitors:
        """One more page; it drives where nobody does, or where it did before it was loaded again."""
        more = replace(self, names={**self.names, client: name})
        free = self.driver is None or self.names.get(self.driver) == name  # its old connection may end after this
        drives = not self.names or self.driver == client or (free and name == self.last)
        return more.driven_by(client) if drives else more

    def left(self, client: int) -> Visitors:
        """One page fewer; nobody takes over until somebody acts."""
        names = {other: name for other, name in self.names.items() if other != client}
        return replace(self, names=names, driver=None if client == self.driver else self.driver)

    def driven_by(self, client: int) -> Visitors:
        """This client has control."""
        return replace(self, driver=client, last=self.names.get(client, ""))
