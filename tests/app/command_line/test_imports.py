"""What is imported for good is out of the collector's sight."""

import gc

import pytest

from splinescope.command_line.imports import lasting


def test_the_collector_rests_inside_and_leaves_alone_what_was_made() -> None:
    before = gc.get_freeze_count()
    with lasting():
        assert not gc.isenabled()
        made = [[k] for k in range(100)]
    assert gc.isenabled()
    assert gc.get_freeze_count() >= before + len(made)
    gc.unfreeze()


def test_the_collector_works_again_after_an_import_that_failed() -> None:
    with pytest.raises(ImportError), lasting():
        raise ImportError("no such module")
    assert gc.isenabled()
    gc.unfreeze()
