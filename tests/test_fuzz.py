"""Some seconds of the fuzzing that tests/fuzz/fuzz_files.py runs for as long as one likes."""

from __future__ import annotations

import importlib.util
import signal
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parent / "fuzz" / "fuzz_files.py"


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="the limit of time of a case needs POSIX's timers")
def test_damaged_files_and_arguments_work_or_are_refused_by_name(tmp_path: Path) -> None:
    spec = importlib.util.spec_from_file_location("fuzz_files", SCRIPT)
    assert spec is not None and spec.loader is not None
    fuzz_files = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = fuzz_files  # dataclasses look their module up
    spec.loader.exec_module(fuzz_files)
    # A number of cases, so that every machine runs the same ones; the time only ends a run on a very slow one.
    tally = fuzz_files.fuzz(seconds=60.0, seed=2026, folder=tmp_path, most=400)
    assert not tally.findings, "\n\n".join(tally.findings)
    assert tally.outcomes["works"] > 50
    assert tally.outcomes["refused"] > 100
