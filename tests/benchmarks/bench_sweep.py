"""What does a sweep cost beside its solver?

    python tests/benchmarks/bench_sweep.py [--rows 1000000] [--folder DIR]

The solver is replaced by one that knows its answer at once, so that what remains is chunks, files and tables. Prints
the rate of the real solver on the reference limb; then the time, and the peak of the memory above the start, of a
sweep to a file (checked against the answer), of opening it again, and of a dataset made of it. Linux only: the peak
comes from /proc.
"""

from __future__ import annotations

import argparse
import platform
import re
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import softlimb as sl
from softlimb import presets, rows
from softlimb.rows import Rows


def known_rows(limb: Any, pressures: Any, *, threads: int, ordered: bool, tick: Any, **scene: Any) -> Rows:
    """The first pressure as the tip's x, and a remark in every second row."""
    found = Rows.not_run(len(pressures), len(limb.segments))
    found.plates[:], found.success[:], found.stable[:] = np.eye(4), True, True
    found.plates[:, -1, 0, 3] = 1e-6 * pressures[:, 0]
    found.tip[:] = found.plates[:, -1]
    found.status[:] = ["converged"] * len(pressures)
    remark = "converged; the law leaves its range in 1 rod: stretch 1.52, fitted to 1.5; pressure {:.6g} Pa"
    found.message.update({row: remark.format(pressures[row, 0]) for row in range(0, len(pressures), 2)})
    return found


def peak() -> float:
    """Largest memory that this process has had [MB]."""
    found = re.search(r"VmHWM:\s+(\d+) kB", Path("/proc/self/status").read_text(encoding="utf-8"))
    assert found is not None
    return int(found[1]) / 1024


def told(what: str, work: Callable[[], Any], start: float) -> Any:
    """Run, and print time and memory."""
    began = time.perf_counter()
    result = work()
    print(f"{what:40s} {time.perf_counter() - began:8.2f} s   peak {peak() - start:7.0f} MB above the start")
    return result


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rows", type=int, default=1_000_000)
    parser.add_argument("--folder", type=Path, default=Path(tempfile.gettempdir()))
    options = parser.parse_args()
    limb = presets.reference_limb()
    pressures = np.random.default_rng(1).uniform(0.0, 60e3, (options.rows, 9))
    gravity = (0.0, 0.0, 9.81)
    print(f"{platform.machine()}, Python {platform.python_version()}, {rows.build()}")
    began = time.perf_counter()
    few = limb.sweep(pressures[:500], gravity=gravity, progress=False)
    took = time.perf_counter() - began
    done = int(few.success.sum())
    print(f"real solver, all cores: {len(few) / took:.0f} rows a second, {done} of {len(few)} successful")
    rows.solve_rows = known_rows
    with tempfile.TemporaryDirectory(dir=options.folder) as folder:
        path, start = Path(folder) / "rows.sweep", peak()
        batch = told(f"{options.rows} rows to a file", lambda: limb.sweep(pressures, progress=False, file=path), start)
        assert batch.success.all() and np.array_equal(batch.tip[:, 0, 3], 1e-6 * pressures[:, 0])
        assert len(batch.remarks) == (options.rows + 1) // 2
        print(f"{'':40s} {path.stat().st_size / 1e6:8.0f} MB")
        loaded = told("opened", lambda: sl.Batch.load(path), start)
        told("the same sweep again", lambda: limb.sweep(pressures, progress=False, file=path), start)
        told("as a dataset", loaded.to_xarray, start)


if __name__ == "__main__":
    main()
