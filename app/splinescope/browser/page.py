"""The page: one viewer window with a locked top-down camera, its keys, clicks and timeline.

    page = open_page("127.0.0.1", 8080, title="SplineScope")
    page.send("actions", described())                # the table of actions: keys, buttons, palette, help sheet
    page.on_action(lambda name: ...)                 # "next-scan"
    page.on_click(lambda point, metres_per_pixel, client: ...)
    page.on_add(lambda point, metres_per_pixel, client: ...)   # a click with Shift
    page.on_box(lambda corners: ...)                 # a drag with Shift
    page.timeline(TimelineState(index=3, length=100, processed=40))
    page.on_timeline(lambda command, value: ...)     # ("seek", 17), ("speed", 2)
    page.on_row(lambda name, number: ...)            # ("closure", 17)
    page.on_view(lambda: ...)                        # somebody panned, zoomed, connected or left
    page.on_hello(lambda name, query, back, place: ...)  # a page has come, or come back to its place
    page.on_goodbye(lambda client: ...)              # a page has left
    page.on_tab(lambda name: ...)                    # somebody opened this tab

Callbacks run one after another on the server's own thread, in the order in which people acted: let them post a command
and return. While one runs, `asker()` tells the client whose person acted. Every page that looks on shares the scene and
the timeline; each has its own view.
"""

from __future__ import annotations

import logging
import secrets
from collections.abc import Callable
from typing import Any

import numpy as np
import viser
from jaxtyping import Float

from splinescope.browser.asker import asked_by
from splinescope.browser.channel import PageEvent, PageState
from splinescope.browser.log_view import place_from
from splinescope.browser.server import ANY_ADDRESS, LOOPBACK, start_server, stop_server
from splinescope.browser.values import Bounds, Mark, Place, TimelineState, Viewport

__all__ = ["Bounds", "Mark", "Page", "TimelineState", "Viewport", "open_page"]

logger = logging.getLogger(__name__)

MARKS = ("key", "loop", "lost", "new", "gated", "hand")
"""Kinds of marks on the timeline."""
FIELD_OF_VIEW = 0.002  # rad: so narrow that the view is parallel to a thousandth of what is seen
BRAND = (0, 114, 178)
SIDE_WIDTH = 352.0

ActionCallback = Callable[[str], None]
ClickCallback = Callable[[Float[np.ndarray, "2"], float, viser.ClientHandle], None]
BoxCallback = Callable[[Float[np.ndarray, "4 2"]], None]
TimelineCallback = Callable[[str, float], None]
RowCallback = Callable[[str, int], None]
HelloCallback = Callable[[str, str, bool, Place | None], None]


def open_page(host: str, port: int, *, title: str = "SplineScope") -> Page:
    """Serve the page at exactly this address; ConfigError, in a sentence, when that is impossible.

    Beyond the loopback address only those see it who know its `token`.
    """
    token = None if host in LOOPBACK else secrets.token_urlsafe(18)
    return Page(start_server(host, port, title, token), host, title, token)


class Page:
    """The window; `server` is the viser server that panels add their widgets to."""

    def __init__(self, server: viser.ViserServer, host: str, title: str, token: str | None = None) -> None:
        self.server = server
        self.title = title
        self.host, self.token = host, token
        self.url = f"http://{'localhost' if host in ANY_ADDRESS else host}:{server.get_port()}"
        self.address = self.url if token is None else f"{self.url}/?token={token}"
        self._viewports: dict[int, Viewport] = {}
        self._marks: tuple[Mark, ...] | None = None
        self._fits = self._performed = 0
        self._name = secrets.token_hex(4)
        self._actions: list[ActionCallback] = []
        self._clicks: list[ClickCallback] = []
        self._adds: list[ClickCallback] = []
        self._boxes: list[BoxCallback] = []
        self._timelines: list[TimelineCallback] = []
        self._rows: list[RowCallback] = []
        self._views: list[Callable[[], None]] = []
        self._hellos: list[HelloCallback] = []
        self._goodbyes: list[Callable[[int], None]] = []
        self._tabs: list[Callable[[str], None]] = []
        self._answers: list[Callable[[str, str], None]] = []
        self._set_camera()
        server.scene.world_axes.visible = False
        server.scene.configure_environment_map(None)
        server.scene.configure_default_lights(enabled=False)
        server.gui.set_panel_label(title)
        server.gui.main_panel.dock_right()
        server.gui.main_panel.set_width(SIDE_WIDTH)
        server._websock_server.register_handler(PageEvent, self._receive)
        server.on_client_disconnect(self._forget)
        self.set_dark(True)

    # -- looks ---------------------------------------------------------------------------------------------------
    def _set_camera(self) -> None:
        camera = self.server.initial_camera
        camera.fov = FIELD_OF_VIEW
        camera.near, camera.far = 1.0, 1e7
        camera.position = (0.0, 0.0, 20.0 / FIELD_OF_VIEW)
        camera.look_at = (0.0, 0.0, 0.0)
        camera.up = (0.0, 1.0, 0.0)

    def set_dark(self, dark: bool) -> None:
        """Dark or light, for every page."""
        self.server.gui.configure_theme(
            dark_mode=dark, show_logo=False, show_share_button=False, brand_color=BRAND, control_width="large"
        )
        self.send("dark", dark)

    def send(self, topic: str, value: Any, client: viser.ClientHandle | None = None) -> None:
        """Give a value to the script of one page, or of every page now and later."""
        connection = self.server._websock_server if client is None else client._websock_connection
        connection.queue_message(PageState.of(topic, value))

    # -- view ----------------------------------------------------------------------------------------------------
    def fit(self, bounds: Bounds, client: viser.ClientHandle | None = None) -> None:
        """Show this rectangle with a little air around it, in one page or in every page now and later."""
        if np.all(np.isfinite(bounds)):
            self._fits += 1
            self.send("fit", {"bounds": [float(b) for b in bounds], "number": f"{self._name}-{self._fits}"}, client)

    def look(self, place: Place, client: viser.ClientHandle | None = None, *, glide: bool = False) -> None:
        """Show exactly this place; `glide` there instead of jumping."""
        self._fits += 1
        x, y, scale = place
        told = {"x": x, "y": y, "metresPerPixel": scale, "glide": glide, "number": f"{self._name}-{self._fits}"}
        self.send("look", told, client)

    def viewport_of(self, client: viser.ClientHandle) -> Viewport | None:
        """What this page sees; None until it has told."""
        return self._viewports.get(client.client_id)

    def bounds_of(self, client: viser.ClientHandle) -> Bounds | None:
        """The rectangle of the world that this page sees."""
        viewport = self.viewport_of(client)
        return viewport.bounds if viewport else None

    def metres_per_pixel(self, client: viser.ClientHandle) -> float | None:
        """The scale of this page."""
        viewport = self.viewport_of(client)
        return viewport.metres_per_pixel if viewport else None

    @property
    def viewport(self) -> Viewport | None:
        """What the page that moved last sees."""
        return next(reversed(tuple(self._viewports.values())), None)

    # -- what people do ------------------------------------------------------------------------------------------
    def on_action(self, callback: ActionCallback) -> None:
        """Call back with the id of every action asked for by a key, by a button of ours, or from the palette."""
        self._actions.append(callback)

    def on_click(self, callback: ClickCallback) -> None:
        """Call back with the point of the world that was clicked, the scale, and the page's client."""
        self._clicks.append(callback)

    def on_add(self, callback: ClickCallback) -> None:
        """Call back with the same for a click with Shift, which adds to what is selected."""
        self._adds.append(callback)

    def on_box(self, callback: BoxCallback) -> None:
        """Call back with the corners, in order round it, of a rectangle that was drawn with Shift (world frame)."""
        self._boxes.append(callback)

    def on_timeline(self, callback: TimelineCallback) -> None:
        """Call back with what was asked of the timeline."""
        self._timelines.append(callback)

    def on_row(self, callback: RowCallback) -> None:
        """Call back with the name and the number of a row of a table that was clicked."""
        self._rows.append(callback)

    def on_view(self, callback: Callable[[], None]) -> None:
        """Call back when some page sees something else than before."""
        self._views.append(callback)

    def on_hello(self, callback: HelloCallback) -> None:
        """Call back with the name that a page has given itself when it has come, and the query of its address."""
        self._hellos.append(callback)

    def on_goodbye(self, callback: Callable[[int], None]) -> None:
        """Call back with the client of a page that has left."""
        self._goodbyes.append(callback)

    def on_answer(self, callback: Callable[[str, str], None]) -> None:
        """Call back with the id of an action that has asked a question, and with the answer."""
        self._answers.append(callback)

    def on_tab(self, callback: Callable[[str], None]) -> None:
        """Call back with the name of a tab that a person opened."""
        self._tabs.append(callback)

    def perform(self, action: str, client: viser.ClientHandle | None = None) -> None:
        """Let the script of one page, or of every page that is here now, do an action of its own."""
        self._performed += 1
        told = {"action": action, "number": f"{self._name}-{self._performed}"}
        for each in self.server.get_clients().values() if client is None else (client,):
            self.send("perform", told, each)

    def offer_link(self, query: str, client: viser.ClientHandle) -> None:
        """Give the person at one page the link with these words behind the address."""
        self._performed += 1
        self.send("copy", {"query": query, "number": f"{self._name}-{self._performed}"}, client)

    def timeline(self, state: TimelineState) -> None:
        """Show this on the timeline of every page."""
        if state.marks is not self._marks:
            self._marks = state.marks
            kinds = {kind: [m.position for m in state.marks if m.kind == kind] for kind in MARKS}
            self.send("marks", kinds)
        names = ("index", "length", "processed", "playing", "speed", "label")
        self.send("timeline", {name: getattr(state, name) for name in names})

    def stop(self) -> None:
        """Close the page for everybody."""
        stop_server(self.server)

    # -- events --------------------------------------------------------------------------------------------------
    def _receive(self, client_id: int, event: PageEvent) -> None:
        try:
            calls = self._calls(client_id, event.topic, event.parsed())
        except (ValueError, KeyError, TypeError):
            logger.warning("the page sent a %s event that makes no sense: %.200s", event.topic, event.value)
            return
        with asked_by(client_id):
            for callback, arguments in calls:
                callback(*arguments)

    def _calls(self, client_id: int, topic: str, value: Any) -> list[tuple[Callable[..., None], tuple[Any, ...]]]:
        """Who is to be called about an event, with what."""
        match topic:
            case "action":
                return [(callback, (str(value),)) for callback in self._actions]
            case "timeline":
                return [(callback, (str(value["command"]), float(value["value"]))) for callback in self._timelines]
            case "row":
                return [(callback, (str(value["name"]), int(value["number"]))) for callback in self._rows]
            case "click" | "add":
                point = np.array([float(value["x"]), float(value["y"])])
                client = self.server.get_clients().get(client_id)
                arguments = (point, float(value["metresPerPixel"]), client)
                callbacks = self._clicks if topic == "click" else self._adds
                return [(callback, arguments) for callback in callbacks if client is not None]
            case "box":
                corners = np.array(value, dtype=float)
                if corners.shape != (4, 2) or not np.isfinite(corners).all():
                    raise ValueError("a box has four corners")
                return [(callback, (corners,)) for callback in self._boxes]
            case "hello":
                told = (str(value["name"])[:80], str(value["query"])[:2000], bool(value["back"]))
                return [(callback, (*told, place_from(value["place"]))) for callback in self._hellos]
            case "answer":
                return [
                    (callback, (str(value["action"])[:80], str(value["text"])[:4000])) for callback in self._answers
                ]
            case "tab":
                return [(callback, (str(value)[:80],)) for callback in self._tabs]
            case "viewport":
                names = ("x", "y", "metresPerPixel", "width", "height", "turn")
                viewport = Viewport(*(float(value[name]) for name in names), fitted=bool(value["fitted"]))
                self._viewports = {**self._others(client_id), client_id: viewport}
                return [(callback, ()) for callback in self._views]
        raise ValueError(topic)

    async def _forget(self, client: viser.ClientHandle) -> None:
        self._viewports = self._others(client.client_id)
        for callback in self._views:
            callback()
        for goodbye in self._goodbyes:
            goodbye(client.client_id)

    def _others(self, client_id: int) -> dict[int, Viewport]:
        """A new dictionary each time, for other threads may be reading the old one."""
        return {other: viewport for other, viewport in self._viewports.items() if other != client_id}
