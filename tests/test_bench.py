"""`softlimb bench`: its unit of time is the agreed loop, its rows say what they should, it refuses wrong answers.

No test here says how fast anything is.
"""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from softlimb import _core

# --- the unit of time ----------------------------------------------------------------------------------------------


def test_the_yardstick_does_the_agreed_arithmetic() -> None:
    microseconds, checksum = _core.yardstick(repetitions=1)
    assert microseconds > 0.0
    assert f"{checksum:.6f}" == "0.159407"
    assert _core.yardstick(repetitions=2)[1] == checksum
    with pytest.raises(ValueError, match="repetitions must be at least 1, got 0"):
        _core.yardstick(repetitions=0)


def test_the_yardstick_agrees_with_the_program_that_defines_it(shared: Path, tmp_path: Path) -> None:
    compiler, source = shutil.which("g++"), shared / "yardstick.cpp"
    if compiler is None or not source.is_file():
        pytest.skip("no g++, or no yardstick.cpp in the shared folder")
    program = tmp_path / "yardstick"
    subprocess.run([compiler, "-O3", "-std=c++17", str(source), "-o", str(program)], check=True)
    printed = subprocess.run([str(program)], capture_output=True, text=True, check=True).stdout
    found = re.search(r"checksum (\S+)", printed)
    assert found, printed
    assert f"{_core.yardstick(repetitions=1)[1]:.6f}" == found.group(1)


def test_the_build_says_what_it_is() -> None:
    info = _core.build_info()
    assert set(info) == {"compiler", "flags", "standard", "target", "assertions"}
    assert all(info.values())
    assert info["flags"] != "unknown"
