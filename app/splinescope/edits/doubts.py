"""The queue of doubtful decisions: which one is looked at, and which a person has found right."""

from __future__ import annotations

from dataclasses import dataclass, replace

from bspline_slam.edits.doubts import Doubt


@dataclass(frozen=True, eq=False, slots=True)
class Doubts:
    """Doubts, the worst first; `at` is the number of the one looked at (None: of none), `right` are the subjects that
    a person has found right, which stay out of the queue."""

    queue: tuple[Doubt, ...] = ()
    at: int | None = None
    right: frozenset[tuple[object, ...]] = frozenset()

    def of(self, doubts: tuple[Doubt, ...]) -> Doubts:
        """Other doubts; what was looked at still is, if it is among them."""
        queue = tuple(doubt for doubt in doubts if doubt.subject not in self.right)
        now = self.current
        places = [k for k, doubt in enumerate(queue) if now is not None and doubt.subject == now.subject]
        return replace(self, queue=queue, at=places[0] if places else None)

    @property
    def current(self) -> Doubt | None:
        """The doubt looked at."""
        return self.queue[self.at] if self.at is not None and self.at < len(self.queue) else None

    def stepped(self, by: int) -> Doubts:
        """Look at the one `by` further on; at the first (or last) from nowhere."""
        if not self.queue:
            return self
        return self.looking_at((0 if by > 0 else -1) if self.at is None else self.at + by)

    def looking_at(self, number: int) -> Doubts:
        """Look at this one; the queue is a ring."""
        return replace(self, at=number % len(self.queue)) if self.queue else self

    def settled(self) -> Doubts:
        """The doubt looked at is none any more; the next one takes its place."""
        now = self.current
        if now is None:
            return self
        queue = tuple(doubt for doubt in self.queue if doubt is not now)
        at = self.at % len(queue) if queue and self.at is not None else None
        return replace(self, queue=queue, right=self.right | {now.subject}, at=at)
