"""A journal of hand edits played again without a display: `splinescope run LOG --edits JOURNAL`."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from bspline_slam.backends.protocol import Cancelling
from bspline_slam.config import config_from_dict
from bspline_slam.edits.amend import amended
from bspline_slam.edits.edit import in_words
from bspline_slam.edits.journal import Recorded, read_journal
from bspline_slam.errors import ConfigError, EditError
from bspline_slam.scan import ScanLog
from bspline_slam.slam import SlamConfig, SlamResult, StageProgress, check_names


def journal_of(path: Path, *others: Any) -> tuple[Recorded, SlamConfig]:
    """A journal and the configuration of the run that its edits belong to.

    Raises ConfigError where another configuration is asked for beside it, EditError for a journal that cannot be read.
    """
    if any(other is not None for other in others):
        raise ConfigError("--edits brings the configuration of its run: leave out --config, --backend and --model")
    recorded = read_journal(path)
    config = config_from_dict(SlamConfig, recorded.origin.configuration)
    check_names(config)
    return recorded, config


def replayed(
    log: ScanLog,
    config: SlamConfig,
    result: SlamResult,
    recorded: Recorded,
    progress: StageProgress,
    cancelled: Cancelling,
) -> tuple[SlamResult, dict[str, Any]]:
    """The result with the edits in force, and what the report says of them."""
    edits = recorded.history.active
    made = amended(result.snapshot, edits, config, progress, cancelled)
    told = [
        {"edit": in_words(edit), "skipped": reason} if reason else {"edit": in_words(edit)}
        for edit, reason in zip(edits, made.skipped, strict=True)
    ]
    return replace(result, snapshot=made.snapshot), {"edits": told, "edits_hash": recorded.history.state_hash}


def check_log(log: ScanLog, recorded: Recorded) -> None:
    """Raises EditError where the edits were made on another log."""
    if log.content_hash != recorded.origin.content_hash:
        raise EditError(f"the edits belong to another log: {Path(recorded.origin.log).name}, not {log.name}")
