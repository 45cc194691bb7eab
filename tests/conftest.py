"""Where tests find the files that stand beside the checkout, and what a whole run builds beside its tests."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from sanitized_build import Ahead

AHEAD = pytest.StashKey[Ahead]()


@pytest.fixture(scope="session")
def shared() -> Path:
    """Folder with measured data: the variable SOFTLIMB_SHARED, or `shared` beside the checkout; skips without it."""
    path = Path(os.environ.get("SOFTLIMB_SHARED") or Path(__file__).parents[2] / "shared")
    if not path.is_dir():
        pytest.skip(f"no measured data at {path}: set SOFTLIMB_SHARED to the folder that has them")
    return path


def pytest_collection_finish(session: pytest.Session) -> None:
    # A run of more than the sanitizers' own file takes long enough to build them meanwhile.
    files = {item.path.name for item in session.items}
    cache = getattr(session.config, "cache", None)
    if cache and "test_sanitizers.py" in files and len(files) > 1 and not session.config.option.collectonly:
        session.config.stash[AHEAD] = Ahead(cache.mkdir("softlimb-sanitizers"))


def pytest_sessionfinish(session: pytest.Session) -> None:
    ahead = session.config.stash.get(AHEAD, None)
    if ahead is not None:
        ahead.stop()
