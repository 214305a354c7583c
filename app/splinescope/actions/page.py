"""Actions of the page itself: help, the palette, the tabs."""

from __future__ import annotations

from splinescope.actions.action import Action, PageRequest, with_log

TABS = ("Layers", "Log", "Scan", "Edit", "Estimate", "Compare", "Quality")
"""The tabs, from the left."""

PAGE = (
    Action("palette", "Find an action by its name", ("Ctrl+k", "/"), PageRequest.SCRIPT),
    Action("help", "Keys and help", ("?",), PageRequest.SCRIPT),
    Action("copy-link", "Copy a link to this moment", ("L",), PageRequest.LINK, with_log),
    Action("take-control", "Take control of the page", ("a",), PageRequest.TAKE_CONTROL),
    Action("legend", "Open or fold the legend", ("h",), PageRequest.SCRIPT),
    *(Action(f"tab-{name.lower()}", f"Tab: {name}", (), PageRequest.SCRIPT) for name in TABS),
)
