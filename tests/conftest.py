"""Where tests find the files that stand beside the checkout: measured data and reference answers."""

from __future__ import annotations

import os
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def shared() -> Path:
    """Folder with measured data: the variable SOFTLIMB_SHARED, or `shared` beside the checkout; skips without it."""
    path = Path(os.environ.get("SOFTLIMB_SHARED") or Path(__file__).parents[2] / "shared")
    if not path.is_dir():
        pytest.skip(f"no measured data at {path}: set SOFTLIMB_SHARED to the folder that has them")
    return path
