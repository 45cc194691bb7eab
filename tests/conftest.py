"""Where tests find the files that stand beside the checkout, and what a run may ask for."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--sanitizers", action="store_true", help="also build the C++ claims with sanitizers: minutes")


@pytest.fixture(scope="session", autouse=True)
def _interrupts_arrive() -> None:
    # A job in the background of a shell starts with Ctrl-C ignored: nothing that waits for it would ever see one.
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session")
def shared() -> Path:
    """Folder with measured data: the variable SOFTLIMB_SHARED, or `shared` beside the checkout; skips without it."""
    path = Path(os.environ.get("SOFTLIMB_SHARED") or Path(__file__).parents[2] / "shared")
    if not path.is_dir():
        pytest.skip(f"no measured data at {path}: set SOFTLIMB_SHARED to the folder that has them")
    return path
