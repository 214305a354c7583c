"""What was done by hand in one run: its history, and the journal that keeps it."""

from __future__ import annotations

from pathlib import Path

from bspline_slam.edits.history import History, Operation
from bspline_slam.edits.journal import Journal, Origin
from bspline_slam.errors import EditError, as_sentence
from splinescope.edits.journals import Journals
from splinescope.notice import Notice


class Chronicle:
    """State: the run (None: none), its journal, which is begun with the first edit, and the history in force. `offer`
    are edits from before that nobody has taken up yet."""

    def __init__(self, journals: Journals) -> None:
        self._journals = journals
        self._origin: Origin | None = None
        self._journal: Journal | None = None
        self.history = History()
        self.offer: History | None = None

    def open(self, origin: Origin) -> tuple[Notice, ...]:
        """Look at another run: go on with its edits from before, or offer them; returns what there is to say."""
        self.close()
        self._origin = origin
        if not self._journals.path(origin).exists():
            return ()
        try:
            journal = self._journal = self._journals.open(origin)
        except EditError as error:
            return (Notice("Edits from before cannot be taken up", as_sentence(str(error)), bad=True),)
        if self._journals.offered and journal.history.active:
            self.offer = journal.history
        else:
            self.history = journal.history
        return tuple(Notice("The journal of edits", note) for note in journal.notes)

    def close(self) -> None:
        """Leave the run; its journal is free for others."""
        if self._journal is not None:
            self._journal.close()
        self._journal, self._origin, self.history, self.offer = None, None, History(), None

    def append(self, operation: Operation) -> None:
        """Do something, once it is in the journal. Raises EditError where it cannot be kept."""
        if self._origin is None:
            raise EditError("no run is open for edits")
        if self._journal is None:
            self._journal = self._journals.open(self._origin)
        self.history = self._journal.append(operation)

    def take_up(self) -> None:
        """Go on with the edits from before."""
        if self.offer is not None:
            self.history, self.offer = self.offer, None

    def set_aside(self) -> Path | None:
        """Begin anew; returns where the edits from before are kept now, None where there are none. Raises EditError
        where they have to stay where they are."""
        if self._journal is None or self._origin is None:
            return None
        kept = self._journals.set_aside(self._origin)
        self._journal.close()
        self._journal, self.offer = None, None
        return kept
