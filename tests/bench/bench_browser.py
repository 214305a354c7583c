"""How soon a hand edit is seen in a browser on the largest recording: `make bench ARGS=browser`.

The whole application and a headless Chromium, which draws without a graphics card on the same cores. Edits of every
kind all over the log, one after another: from the key that accepts one to the page holding another picture, to that
picture drawn, and to the exact map. Pictures are of those edits whose preview moves something that can be seen. Wall
time, so the machine should have nothing else to do.
"""

from __future__ import annotations

import json
import pickle
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import astuple, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from playwright.sync_api import sync_playwright

import chromium
from app.chromium import Window, opened, until
from app.running import COMPILING, running_viewer
from bench.bench_edits import KINDS, edit_on
from bench.recordings import largest_recording
from bspline_slam.edits.edit import FIRST_MADE_BY_HAND, Edit
from bspline_slam.slam import Snapshot
from splinescope import commands as ask
from splinescope.viewer import Viewer

EDITS = 44
SECONDS = 120.0
READING = 1.0
"""How long (s) a person looks at a preview, at the least."""
WATCH = """
() => {
  const drawn = () => Object.entries(__viserSceneTree.getState())
    .filter(([name]) => name.startsWith("/splinescope/"))
    .map(([, node]) => node.visibility && node.message?.props?.points);
  let last = drawn();
  window.bench = {};
  __viserSceneTree.subscribe(() => {
    const now = drawn();
    if (window.bench.accepted && !window.bench.held && now.some((points, i) => points !== last[i])) {
      window.bench.held = performance.now();
      requestAnimationFrame(() => requestAnimationFrame(() => (window.bench.drawn = performance.now())));
    }
    last = now;
  });
  const accepted = (event) => event.key === "Enter" && (window.bench = { accepted: performance.now() });
  window.addEventListener("keydown", accepted, { capture: true });
}
"""


@dataclass(frozen=True, slots=True)
class Times:
    """Milliseconds from the key to the browser holding another picture, to that drawn (NaN where nothing moves that can
    be seen), and to the exact map."""

    held: float
    drawn: float
    settled: float


def main(argv: list[str]) -> list[dict[str, object]]:
    """Rows for bench.json: one for each kind of edit, and one for all of them."""
    path = Path(argv[0]) if argv else largest_recording()
    times: dict[str, list[Times]] = {kind: [] for kind in KINDS}
    with TemporaryDirectory() as folder, at_work(path, Path(folder)) as (viewer, window):
        result = viewer.session.result
        assert result is not None
        base = pickle.loads(result.kept)
        window.page.evaluate(WATCH)
        for number in np.random.default_rng(5).permutation(len(base.key_scans)).tolist():
            done = sum(map(len, times.values()))
            if done == EDITS:
                break
            kind = KINDS[done % len(KINDS)]
            found = measured(viewer, window, base, number, kind, FIRST_MADE_BY_HAND + done)
            times[kind] += [found] if found is not None else []
    rows = [row(kind, of_kind) for kind, of_kind in times.items() if of_kind]
    rows.append(row("all", [one for of_kind in times.values() for one in of_kind]) | {"log": path.name})
    for one in rows:
        print(json.dumps(one), flush=True)
    return rows


@contextmanager
def at_work(path: Path, folder: Path) -> Iterator[tuple[Viewer, Window]]:
    """The application with the log processed and ready for edits, and a page of it."""
    program = chromium.find()
    with (
        running_viewer(path, folder / "session.json") as viewer,
        sync_playwright() as playwright,
        playwright.chromium.launch(executable_path=program, args=chromium.launch_arguments()) as browser,
    ):
        session = viewer.session
        until(lambda: session.editing.base is not None and session.editing.doubts.queue, "the map", COMPILING)
        with opened(browser, viewer.address) as window:
            yield viewer, window


def measured(viewer: Viewer, window: Window, base: Snapshot, number: int, kind: str, made: int) -> Times | None:
    """One edit, looked at and accepted by its key; None where it cannot be made."""
    editing, edit = viewer.session.editing, edit_on(base, number, kind, made)
    if edit is None or not previewed(viewer, base.steps[number].scan, edit):
        return None
    time.sleep(READING)
    moves = (window.node("/splinescope/ghost") or {}).get("visible", False)
    start, before = time.perf_counter(), len(editing.history.active)
    window.page.keyboard.press("Enter")
    until(lambda: len(editing.history.active) > before, "the edit", SECONDS)
    until(lambda: viewer.caught_up() and not editing.making, "the map", SECONDS)
    settled = time.perf_counter() - start
    if not moves:
        return Times(np.nan, np.nan, 1000 * settled)
    window.page.wait_for_function("window.bench.drawn", timeout=1000 * SECONDS)
    seen = window.page.evaluate("window.bench")
    return Times(seen["held"] - seen["accepted"], seen["drawn"] - seen["accepted"], 1000 * settled)


def previewed(viewer: Viewer, scan: int, edit: Edit) -> bool:
    """Whether the edit can be made, once the page shows what it would do."""
    viewer.post(ask.Seek(scan))
    viewer.post(ask.ProposeEdits((edit,)))

    def final() -> bool:
        proposal = viewer.session.editing.proposal
        return proposal is not None and proposal.preview is not None and proposal.preview.final

    until(lambda: viewer.caught_up() and final(), "the preview", SECONDS)
    proposal = viewer.session.editing.proposal
    assert proposal is not None
    assert proposal.preview is not None
    if proposal.preview.refusal is None:
        return True
    viewer.post(ask.DropProposal())
    return False


def row(kind: str, times: list[Times]) -> dict[str, object]:
    """Medians, and what 95 % stay below (ms)."""
    found: dict[str, object] = {"edit": kind, "count": len(times)}
    for name, values in zip(("held", "drawn", "settled"), np.array([astuple(one) for one in times]).T, strict=True):
        known = values[np.isfinite(values)]
        if len(known):
            found |= {f"{name}_count": len(known), f"{name}_ms": round(float(np.median(known)))}
            found[f"{name}_ms_95"] = round(float(np.percentile(known, 95)))
    return found


if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parents[1]))
    main(sys.argv[1:])
