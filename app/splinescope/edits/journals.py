"""Where journals of hand edits lie: beside the session's file, else in the user's data folder, one for each result."""

from __future__ import annotations

import hashlib
import json
import os
import time
from dataclasses import dataclass
from pathlib import Path

from bspline_slam.edits.journal import Journal, Origin
from bspline_slam.errors import EditError


@dataclass(frozen=True, slots=True)
class Journals:
    """A folder of journals, whose names begin with `prefix`. What lies beside a session's file belongs to that session
    and is gone on with at once; what lies in the data folder is offered first (`offered`)."""

    folder: Path
    prefix: str = ""
    offered: bool = False

    @classmethod
    def beside(cls, session: Path) -> Journals:
        """Those of a session's file."""
        return cls(session.parent, f"{session.stem}.")

    @classmethod
    def of_user(cls) -> Journals:
        """Those of the user: in the folder that the system has for data."""
        base = os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share"
        return cls(Path(base) / "splinescope" / "edits", offered=True)

    def path(self, origin: Origin) -> Path:
        """The journal of a result: named by the content of the log and by the configuration."""
        configuration = hashlib.sha256(json.dumps(origin.configuration, sort_keys=True).encode()).hexdigest()
        return self.folder / f"{self.prefix}{origin.content_hash[:12]}-{configuration[:4]}.edits"

    def open(self, origin: Origin) -> Journal:
        """The journal of a result, begun where there is none. Raises EditError."""
        return Journal(self.path(origin), origin)

    def set_aside(self, origin: Origin) -> Path:
        """Give the journal of a result another name; returns that. Raises EditError where that is impossible."""
        path = self.path(origin)
        try:
            return path.rename(path.with_suffix(f".{time.time_ns()}.edits"))
        except OSError as error:
            raise EditError(f"{path} cannot be set aside: {error.strerror}") from None
