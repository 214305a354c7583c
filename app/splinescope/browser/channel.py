"""The two-way channel between our script in the page and Python, carried by the viewer's own websocket.

Towards Python a `PageEvent` travels like any message of the viewer, so it arrives in order and names its client.
Towards the page a `PageState` hands a value to `splinescope.receive(topic, value)`; the latest value of each topic is
kept for pages that connect later. This leans on private parts of viser, which is why its version is pinned and a
browser test drives every topic.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

from typing_extensions import override
from viser._messages import Message, RunJavascriptMessage


@dataclass
class PageEvent(Message, include_in_scene_serialization=False):
    """Something a person did in one page: its `topic` and its `value` as JSON text."""

    topic: str
    value: str

    def parsed(self) -> Any:
        """The value, decoded; ValueError when it is not JSON."""
        return json.loads(self.value)


@dataclass
class PageState(RunJavascriptMessage, include_in_scene_serialization=False):
    """A value for the script in the page, as the statement that hands it over under its `topic`."""

    topic: str = ""

    @classmethod
    def of(cls, topic: str, value: Any) -> PageState:
        """The message that gives `value` (anything JSON can say) to the page."""
        text = json.dumps(value, allow_nan=False)
        return cls(f"window.splinescope.receive({json.dumps(topic)}, {text});", topic)

    @override
    def redundancy_key(self) -> str:
        return f"PageState_{self.topic}"

    @override
    def as_serializable_dict(self, binary_buffers: list[memoryview] | None = None) -> dict[str, Any]:
        return {"type": RunJavascriptMessage.__name__, "source": self.source}
