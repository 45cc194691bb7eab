"""Instructions of a solve, counted by callgrind: a figure that no busy machine disturbs.

A child process makes the same calls of the core n times or 2n times; the difference is n times the calls, without
start-up, imports and what Python does around them once. Valgrind shows programs no AVX-512, so that a core that chooses
at run time may choose otherwise here.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from softlimb import _core

__all__ = ["WORKS", "available", "counted", "work"]

PASSES = 2000
"""Passes of the yardstick in one repetition."""

WORKS = ("warm", "cold")
"""Questions of the table of times that are counted beside the yardstick."""


def available() -> bool:
    """Whether valgrind is on PATH."""
    return shutil.which("valgrind") is not None


def work(name: str, times: int) -> int:
    """Run a work so many times; returns how many solves one time has.

    Raises
    ------
    ValueError
        No work has that name.
    """
    if name == "yardstick":
        _core.yardstick(repetitions=times)
        return PASSES
    if name not in WORKS:
        raise ValueError(f"work must be yardstick, {' or '.join(WORKS)}, got {name!r}")
    # Here, so that a child that counts the yardstick starts without numpy: each instruction takes fifty times as long.
    from softlimb.bench import speed
    from softlimb.bench.core_calls import CoreCalls

    question = {"warm": speed.warm(), "cold": speed.cold}[name](speed.Effort(steps=10, cold=5))
    fault = question.fault([walk() for walk in question.walks])
    if fault is not None:
        raise RuntimeError(f"the answers of {name} are wrong: {fault}")
    calls = [CoreCalls.of(walk) for walk in question.walks]
    for _ in range(times):
        for call in calls:
            call.again()
    return question.solves * len(question.walks)


def counted(name: str, times: int) -> float:
    """Instructions of one solve of a work: of one pass for ``yardstick``.

    Parameters
    ----------
    times : int
        n of the runs with n and 2n.

    Raises
    ------
    RuntimeError
        Valgrind or the process in it failed.
    """
    once, solves = _run(name, times)
    twice, _ = _run(name, 2 * times)
    return (twice - once) / (times * solves)


def _run(name: str, times: int) -> tuple[int, int]:
    code = f"from softlimb.bench.instructions import work; print(work({name!r}, {times}))"
    # One order of hashes and one thread: two runs then differ by the work alone.
    environment = {**os.environ, "PYTHONHASHSEED": "0", "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    with tempfile.TemporaryDirectory() as folder:
        counts = Path(folder) / "counts"
        command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={counts}", sys.executable, "-c", code]
        ended = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
        if ended.returncode != 0:
            raise RuntimeError(f"valgrind ended with {ended.returncode}: {ended.stderr.strip()[-300:]}")
        lines = counts.read_text(encoding="utf-8").splitlines()
    total = next((line.split()[1] for line in lines if line.startswith(("summary:", "totals:"))), None)
    if total is None:
        raise RuntimeError("callgrind wrote no total")
    return int(total), int(ended.stdout.split()[-1])
