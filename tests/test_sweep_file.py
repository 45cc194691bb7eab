"""A sweep in a file: the same bits whatever the way there, nothing lost when the process dies, nothing mistaken."""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import softlimb as sl
from softlimb import presets, rows
from softlimb.scenes import load_scene
from softlimb.sweep import run, sweep_file
from softlimb.sweep.record import SweepRecord
from softlimb.sweep.sweep_file import SweepFile
from sweep_examples import KnownRows, same_bits, small_limb, some_pressures

PRESSURES = some_pressures(200)
SCENE = {"gravity": (0.0, 0.0, 9.81), "tolerance": 1e-5}


@pytest.fixture
def known_rows(monkeypatch):
    solver = KnownRows()
    monkeypatch.setattr(rows, "solve_rows", solver)
    return solver


@pytest.fixture
def fresh(known_rows, tmp_path):
    """The file of a sweep that nothing interrupted, and its batch in memory."""
    path = tmp_path / "fresh.sweep"
    small_limb().sweep(PRESSURES, progress=False, file=path, **SCENE)
    batch = small_limb().sweep(PRESSURES, progress=False, **SCENE)
    known_rows.solved = []
    return path, batch


def files_in(folder):
    return sorted(path.name for path in folder.iterdir())


# --- the same bits -----------------------------------------------------------------------------------------------


def test_a_sweep_to_a_file_has_the_bits_of_one_in_memory(fresh, tmp_path) -> None:
    path, batch = fresh
    loaded = sl.Batch.load(path)
    assert same_bits(loaded, batch)
    assert loaded.limb == batch.limb and loaded.builds == batch.builds and loaded.file == path
    assert loaded.scene["tolerance"] == 1e-5 and loaded.scene["gravity"].tolist() == [0.0, 0.0, 9.81]
    assert {*loaded.status} == {"converged", "max_iterations", "invalid"}
    assert loaded.remarks.size and "mm² and °" in loaded.message[int(loaded.remarks[0])]
    assert files_in(tmp_path) == ["fresh.sweep"]


def test_saved_batches_and_finished_sweeps_are_the_same_file(fresh, tmp_path) -> None:
    path, batch = fresh
    batch.save(tmp_path / "saved.sweep")
    assert (tmp_path / "saved.sweep").read_bytes() == path.read_bytes()
    sl.Batch.load(path).save(tmp_path / "saved.sweep")  # over the other
    assert (tmp_path / "saved.sweep").read_bytes() == path.read_bytes()
    sl.Batch.load(path).save(path)  # over itself
    assert (tmp_path / "saved.sweep").read_bytes() == path.read_bytes()


@pytest.mark.parametrize(
    "options",
    [
        {"tip_pose": np.diag([1.0, 1.0, 1.0, 1.0]) + np.eye(4, k=3) * 0.01, "tip_held": [True, False] * 3},
        {"rod_forces": np.ones((3, 3)), "rod_moments": [np.zeros((3, 3))], "frame": "plate"},
        {"plate_held": np.ones((1, 6), dtype=bool), "prefer_stable": False, "start": np.eye(4)[None]},
        {"plate_wrenches": [[1, 2, 3, 4, 5, 6]], "section": "nonlinear", "valve": "locked", "tip_force": (0, 1, 2)},
    ],
)
def test_every_option_of_a_scene_comes_back_from_its_file(known_rows, tmp_path, options) -> None:
    limb = small_limb()
    limb.sweep(PRESSURES[:3], progress=False, file=tmp_path / "a", **options)
    loaded = sl.Batch.load(tmp_path / "a")
    assert sorted(loaded.scene) == sorted(options)
    for name, value in options.items():
        found = loaded.scene[name]
        assert np.array_equal(np.reshape(found, -1), np.reshape(value, -1)), name
    known_rows.solved = []
    limb.sweep(PRESSURES[:3], progress=False, file=tmp_path / "a", **loaded.scene)  # the same sweep: nothing to do
    assert not known_rows.solved
    # and `Limb.solve` takes them in the form in which they come back
    there, here = limb.solve(PRESSURES[0], **loaded.scene), limb.solve(PRESSURES[0], **options)
    assert there.plates.tobytes() == here.plates.tobytes()


def test_a_limb_of_several_segments_and_a_scene_of_the_package_come_back(tmp_path) -> None:
    scene = load_scene("bend-1")
    batch = scene.sweep(progress=False, file=tmp_path / "bend", threads=2)
    loaded = sl.Batch.load(tmp_path / "bend")
    assert loaded.limb == scene.limb
    assert same_bits(loaded, batch) and same_bits(loaded, scene.sweep(progress=False))
    assert loaded.plates.shape == (13, len(scene.limb), 4, 4)


def test_a_batch_from_a_file_can_be_pickled_and_tabled(fresh, tmp_path) -> None:
    path, batch = fresh
    loaded = sl.Batch.load(path)
    assert same_bits(pickle.loads(pickle.dumps(loaded)), batch)
    loaded.to_csv(tmp_path / "a.csv")
    batch.to_csv(tmp_path / "b.csv")
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()


def test_a_dataset_of_a_file_is_that_of_memory(fresh) -> None:
    pytest.importorskip("xarray")
    path, batch = fresh
    assert sl.Batch.load(path).to_xarray().identical(batch.to_xarray())


def test_a_sweep_of_no_rows_has_a_file_too(tmp_path) -> None:
    batch = small_limb().sweep(np.zeros((0, 3)), progress=False, file=tmp_path / "a")
    assert len(batch) == 0 and len(sl.Batch.load(tmp_path / "a")) == 0


# --- going on ----------------------------------------------------------------------------------------------------


def test_a_finished_file_is_not_touched(fresh, known_rows) -> None:
    path, batch = fresh
    before = path.stat().st_mtime_ns, path.read_bytes()
    assert same_bits(small_limb().sweep(PRESSURES, progress=False, file=path, **SCENE), batch)
    assert same_bits(sl.Batch.load(path).resume(progress=False), batch)
    assert (path.stat().st_mtime_ns, path.read_bytes()) == before
    assert not known_rows.solved


@pytest.mark.parametrize("ordered", [False, True])
def test_after_ctrl_c_a_file_goes_on_with_what_is_missing(known_rows, tmp_path, ordered: bool) -> None:
    path, options = tmp_path / "a", {"progress": False, "ordered": ordered, **SCENE}
    known_rows.stop_at = float(PRESSURES[100, 0])
    batch = small_limb().sweep(PRESSURES, file=path, **options)
    assert batch.interrupted and batch.status.count("not_run") == 100
    assert files_in(tmp_path) == ["a"]  # one file, whole in itself
    assert np.isnan(batch.tip[100:]).all() and batch.message[150] == "the sweep was interrupted before this row"
    assert same_bits(batch, small_limb().sweep(PRESSURES, **options))  # interrupted at the same row
    known_rows.stop_at, known_rows.solved = None, []
    finished = sl.Batch.load(path).resume(progress=False)
    assert not finished.interrupted
    assert len(known_rows.solved) == (104 if ordered else 100)  # from row 96 on, where its group starts
    known_rows.solved = []
    small_limb().sweep(PRESSURES, file=tmp_path / "b", **options)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_a_batch_that_somebody_has_gone_on_with_says_so(known_rows, tmp_path) -> None:
    known_rows.stop_at = float(PRESSURES[100, 0])
    batch = small_limb().sweep(PRESSURES, progress=False, file=tmp_path / "a", **SCENE)
    known_rows.stop_at = None
    batch.resume(progress=False)
    with pytest.raises(RuntimeError, match="a has changed since it was loaded: load the sweep again"):
        list(batch.message)


def test_an_interrupted_batch_that_was_saved_goes_on_too(known_rows, tmp_path) -> None:
    known_rows.stop_at = float(PRESSURES[100, 0])
    small_limb().sweep(PRESSURES, progress=False, **SCENE).save(tmp_path / "a")
    known_rows.stop_at = None
    sl.Batch.load(tmp_path / "a").resume(progress=False)
    small_limb().sweep(PRESSURES, progress=False, file=tmp_path / "b", **SCENE)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


CHILD = """
import sys
import numpy as np
sys.path.insert(0, {tests!r})
from sweep_examples import small_limb, some_pressures, use_known_rows
from softlimb.sweep import run, sweep_file
from softlimb.sweep.record import SweepRecord
from softlimb.sweep.sweep_file import SweepFile
use_known_rows(seconds=0.01)
run._BLOCK_SECONDS, sweep_file._COMMIT = 0.05, 0.02  # [s], so that a second holds many blocks
small_limb().sweep(some_pressures(200), progress=False, threads=1, ordered={ordered}, file={path!r}, {scene})
"""


@pytest.mark.parametrize("ordered", [False, True])
def test_a_killed_sweep_goes_on_and_ends_with_the_bits_of_one_that_was_not(known_rows, tmp_path, ordered) -> None:
    path, options = tmp_path / "killed", {"progress": False, "ordered": ordered, **SCENE}
    scene = ", ".join(f"{name}={value!r}" for name, value in SCENE.items())
    code = CHILD.format(tests=str(Path(__file__).parent), ordered=ordered, path=str(path), scene=scene)
    done = 0
    for _ in range(2):
        process = subprocess.Popen([sys.executable, "-c", code])
        try:
            while process.poll() is None and not (path.exists() and _solved(path) > done):
                time.sleep(0.02)
            # While it works: whoever else wants to is refused, and whoever looks sees whole rows.
            with pytest.raises(OSError, match="killed is being filled by another process"):
                small_limb().sweep(PRESSURES, file=path, **options)
        finally:
            process.kill()  # SIGKILL
        assert process.wait() == -signal.SIGKILL
        found = sl.Batch.load(path)
        done = len(found) - found.status.count("not_run")
        assert found.interrupted and done > 0
        assert np.isnan(found.tip[found.having("not_run")]).all()
        assert files_in(tmp_path) == ["killed", "killed.journal"]
    assert not known_rows.solved
    finished = small_limb().sweep(PRESSURES, file=path, **options)
    assert len(known_rows.solved) == 200 - (done // 32 * 32 if ordered else done)
    small_limb().sweep(PRESSURES, file=tmp_path / "b", **options)
    assert path.read_bytes() == (tmp_path / "b").read_bytes()
    assert same_bits(finished, small_limb().sweep(PRESSURES, **options))
    assert files_in(tmp_path) == ["b", "killed"]


def _solved(path):
    batch = sl.Batch.load(path)
    return len(batch) - batch.status.count("not_run")


DYING = """
import os, sys
sys.path.insert(0, {tests!r})
import numpy as np
from sweep_examples import small_limb, some_pressures, use_known_rows
import softlimb as sl
from softlimb import rows
from softlimb.sweep import file_layout, run, sweep_file

use_known_rows()
run._BLOCK_SECONDS, sweep_file._COMMIT = 1e-9, 0.0
write, writes, folder = file_layout.write_at, [10**9], {folder!r}
limb, pressures = small_limb(), some_pressures(100)
whole = os.path.join(folder, "whole")
limb.sweep(pressures, progress=False, threads=1, file=whole)
whole = open(whole, "rb").read()

def dying(file, at, data):
    # The last write is cut in the middle, as by a power cut.
    data = data if isinstance(data, bytes) else np.ascontiguousarray(data).tobytes()
    writes[0] -= 1
    if writes[0] < 0:
        write(file, at, data[: len(data) // 2])
        os._exit(9)
    write(file, at, data)

sweep_file.write_at = dying
rows.solve_rows.stop_at = float(pressures[70, 0])
half = limb.sweep(pressures, progress=False, threads=1)
rows.solve_rows.stop_at = None
number, deaths = 0, 0
while True:
    path = os.path.join(folder, f"a{{number}}")
    if {begun}:  # somebody was here before, and left in order
        half.save(path)
    for attempt in range(2):  # a second death on the way of the first
        writes[0] = number
        child = os.fork()
        if child == 0:
            limb.sweep(pressures, progress=False, threads=1, file=path)
            os._exit(0)
        end = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        deaths += end == 9
        if os.path.exists(path):
            seen = sl.Batch.load(path)
            assert np.isfinite(seen.tip[seen.success]).all() and np.isfinite(seen.plates[seen.success]).all(), number
            assert np.isnan(seen.tip[~seen.success]).all() and np.isnan(seen.plates[~seen.success]).all(), number
            assert len(list(seen.message)) == 100
    writes[0] = 10**9
    limb.sweep(pressures, progress=False, threads=1, file=path)
    assert open(path, "rb").read() == whole, number
    assert sorted(os.listdir(folder)) == sorted([f"a{{number}}", "whole"]), os.listdir(folder)
    os.unlink(path)
    if end == 0:
        break
    number += 1
print(number, deaths)
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="dies in forked processes")
@pytest.mark.parametrize("begun", [False, True])
def test_a_death_at_any_write_leaves_a_file_that_goes_on(tmp_path, begun: bool) -> None:
    code = DYING.format(tests=str(Path(__file__).parent), folder=str(tmp_path), begun=begun)
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stderr
    number, deaths = map(int, ended.stdout.split())
    # Some ten writes for each of four blocks (the last one of 30 rows that are missing) and twelve for a new file, of
    # which two processes do half each in the end.
    assert number > (10 if begun else 25) and deaths > number


def test_rows_that_a_death_cut_in_two_are_not_run_when_the_sweep_is_interrupted_after(
    known_rows, tmp_path, monkeypatch
) -> None:
    path, limb = tmp_path / "torn", small_limb()
    record = SweepRecord.of(limb, SCENE, False, len(PRESSURES))
    later = known_rows(limb, PRESSURES[150:], threads=1, ordered=False, tick=lambda _: True)
    write = SweepFile._write_column

    def cut(self, name, first, values):
        if name == "stable":
            raise KeyboardInterrupt
        write(self, name, first, values)

    monkeypatch.setattr(SweepFile, "_write_column", cut)
    with pytest.raises(KeyboardInterrupt), SweepFile.create(path, record, PRESSURES) as table:
        table.put(150, later)
    monkeypatch.setattr(SweepFile, "_write_column", write)
    assert sl.Batch.load(path).status.count("not_run") == 200 and np.isnan(sl.Batch.load(path).plates).all()
    known_rows.stop_at = float(PRESSURES[100, 0])
    limb.sweep(PRESSURES, progress=False, file=path, **SCENE)
    limb.sweep(PRESSURES, progress=False, file=tmp_path / "b", **SCENE)
    assert path.read_bytes() == (tmp_path / "b").read_bytes()


def test_a_row_whose_message_is_lost_is_solved_again(known_rows, tmp_path, monkeypatch) -> None:
    path = tmp_path / "a"
    monkeypatch.setattr(sweep_file.SweepFile, "seal", lambda self: None)
    small_limb().sweep(PRESSURES, progress=False, file=path, **SCENE)
    monkeypatch.undo()
    monkeypatch.setattr(rows, "solve_rows", known_rows)
    told = len(sl.Batch.load(path).as_messages().rows)
    assert told > 20
    sweep_file.journal_of(path).unlink()
    known_rows.solved = []
    small_limb().sweep(PRESSURES, progress=False, file=path, **SCENE)
    assert len(known_rows.solved) == told
    small_limb().sweep(PRESSURES, progress=False, file=tmp_path / "b", **SCENE)
    assert path.read_bytes() == (tmp_path / "b").read_bytes()


def test_rows_of_two_builds_are_both_named(known_rows, tmp_path, monkeypatch) -> None:
    known_rows.stop_at = float(PRESSURES[100, 0])
    batch = small_limb().sweep(PRESSURES, progress=False, file=tmp_path / "a", **SCENE)
    known_rows.stop_at = None
    monkeypatch.setattr(rows, "build", lambda: "another build")
    with pytest.warns(RuntimeWarning, match="solved by different builds"):
        finished = batch.resume(progress=False)
    assert set(finished.builds) == {"another build", *batch.builds} and "another build" in finished.build


# --- memory ------------------------------------------------------------------------------------------------------

MEMORY = """
import re, sys
sys.path.insert(0, {tests!r})
import numpy as np
from softlimb import presets, rows
from softlimb.rows import Rows

def solve_rows(limb, pressures, *, threads, ordered, tick, **scene):
    count = len(pressures)
    found = Rows.not_run(count, len(limb.segments))
    found.tip[:], found.plates[:], found.success[:] = np.eye(4), np.eye(4), True
    found.status[:] = ["converged"] * count
    found.message.update({{row: f"converged; a remark in row {{row}}" for row in range(0, count, 2)}})
    return found

def peak():  # not getrusage, which counts what the process was before it became this one
    return int(re.search(r"VmHWM:\\s+(\\d+) kB", open("/proc/self/status").read()).group(1))

limb, pressures = presets.reference_limb(), np.zeros(({count}, 9))
pressures[:] = 1.0
limb.sweep(pressures[:1000], progress=False, file={path!r} + "-small")  # what a sweep loads
rows.solve_rows, before = solve_rows, peak()
batch = limb.sweep(pressures, progress=False, file={path!r})
assert batch.success.all() and "a remark in row" in batch.message[{count} - 2]
print((peak() - before) / 1024)
"""


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="asks Linux for the peak of the memory")
def test_a_long_sweep_to_a_file_takes_little_memory(tmp_path) -> None:
    code = MEMORY.format(tests=str(Path(__file__).parent), count=120_000, path=str(tmp_path / "a"))
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stderr
    assert (tmp_path / "a").stat().st_size > 75e6  # 638 bytes a row
    # A block of 32768 rows twice (20 MB each) and the pressures as the file has them (9 MB); in memory 100 MB.
    assert float(ended.stdout) < 75.0  # [MB]


# --- what is refused ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"limb": presets.reference_limb(["middle"])}, "fresh.sweep holds the sweep of another limb"),
        ({"gravity": (0.0, 0.0, -9.81)}, r"holds a sweep with gravity \[0.0, 0.0, 9.81\], not \[0.0, 0.0, -9.81\]"),
        ({"tip_force": (0.0, 0.0, 1.0)}, r"holds a sweep with tip_force \[0.0, 0.0, 0.0\], not \[0.0, 0.0, 1.0\]"),
        ({"tolerance": 1e-6}, "holds a sweep with tolerance 1e-05, not 1e-06"),
        ({"section": "paper"}, "holds a sweep with section 'tangent', not 'paper'"),
        ({"ordered": True}, "holds a sweep with ordered False, not True"),
        ({"pressures": PRESSURES[:-1]}, "holds other pressures: 200 rows, not 199"),
        ({"pressures": np.where(np.arange(200)[:, None] == 7, 1.0, PRESSURES)}, "holds other pressures: row 7 is"),
    ],
)
def test_the_file_of_another_sweep_is_refused_by_name(fresh, known_rows, changes, message: str) -> None:
    path, _ = fresh
    before = path.read_bytes()
    arguments = {"limb": small_limb(), "pressures": PRESSURES, "progress": False, "file": path, **SCENE} | changes
    with pytest.raises(ValueError, match=message):
        arguments.pop("limb").sweep(arguments.pop("pressures"), **arguments)
    assert path.read_bytes() == before and not known_rows.solved


def test_the_same_scene_in_other_words_is_the_same_sweep(fresh, known_rows) -> None:
    path, _ = fresh
    options = {"gravity": np.array([0, 0, 9.81]), "tolerance": np.float64(1e-5), "tip_force": [0, 0, 0]}
    small_limb().sweep(PRESSURES.tolist(), progress=False, file=str(path), section="tangent", **options)
    assert not known_rows.solved


@pytest.mark.parametrize("name", ["", "nul\0", "."])
def test_a_file_has_the_name_of_a_file(name: str, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ValueError, match="file "):
        small_limb().sweep(PRESSURES, progress=False, file=name)
    with pytest.raises(ValueError, match="path "):
        sl.Batch.load(name)
    assert not files_in(tmp_path)


@pytest.mark.parametrize("name", [3, True, b"bytes", ["a"], 1.0])
def test_a_file_is_a_path(name) -> None:
    with pytest.raises(TypeError, match="file must be a path, got"):
        small_limb().sweep(PRESSURES, progress=False, file=name)
    with pytest.raises(TypeError, match="path must be a path, got"):
        sl.Batch.load(name)


def test_a_file_that_cannot_be_written_is_an_error_before_the_work(known_rows, tmp_path) -> None:
    blocked = tmp_path / "blocked"
    blocked.write_text("a file, and no folder", encoding="utf-8")
    for path in (tmp_path / "nowhere" / "a", blocked / "a"):
        with pytest.raises(OSError, match=f"file {path} cannot be"):
            small_limb().sweep(PRESSURES, progress=False, file=path)
        with pytest.raises(OSError, match=f"file {path} cannot be"):
            small_limb().sweep(PRESSURES[:1], progress=False).save(path)
    if os.name == "posix" and os.geteuid() != 0:  # root writes where it likes
        tmp_path.chmod(0o500)
        with pytest.raises(OSError, match="cannot be written"):
            small_limb().sweep(PRESSURES, progress=False, file=tmp_path / "a")
        tmp_path.chmod(0o700)
    assert len(known_rows.solved) == 2


def test_a_disk_that_is_too_small_says_so_before_the_work(known_rows, tmp_path) -> None:
    resource = pytest.importorskip("resource")
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, limits[1]))
    try:
        with pytest.raises(OSError, match="a cannot be written"):
            small_limb().sweep(PRESSURES, progress=False, file=tmp_path / "a")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert not known_rows.solved and not files_in(tmp_path)


def test_a_disk_that_is_full_in_the_middle_keeps_what_is_marked(known_rows, tmp_path, monkeypatch) -> None:
    resource, path = pytest.importorskip("resource"), tmp_path / "a"
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    monkeypatch.setattr(run, "_BLOCK_SECONDS", 1e-9)
    monkeypatch.setattr(sweep_file, "_COMMIT", 0.0)
    solve = rows.solve_rows

    def filling(limb, pressures, **options):
        if len(known_rows.solved) > 100:  # no file may grow any more
            resource.setrlimit(resource.RLIMIT_FSIZE, (100, limits[1]))
        return solve(limb, pressures, **options)

    monkeypatch.setattr(rows, "solve_rows", filling)
    try:
        with pytest.raises(OSError, match=f"file {path} cannot be written: File too large"):
            small_limb().sweep(PRESSURES, progress=False, file=path, threads=1, **SCENE)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    monkeypatch.setattr(rows, "solve_rows", solve)
    kept = sl.Batch.load(path)
    missing = kept.status.count("not_run")
    assert 0 < missing < 110
    known_rows.solved = []
    kept.resume(progress=False)
    assert len(known_rows.solved) == missing
    small_limb().sweep(PRESSURES, progress=False, file=tmp_path / "b", **SCENE)
    assert path.read_bytes() == (tmp_path / "b").read_bytes()


def test_a_refused_scene_leaves_no_file_behind(known_rows, tmp_path) -> None:
    for pressures, options, error in (
        (PRESSURES, {"gravity": "up"}, ValueError),
        (np.zeros((3, 3)), {}, ValueError),
        (PRESSURES, {"gravitas": 1.0}, TypeError),
        (PRESSURES, {"start": small_limb().solve([0.0] * 3)}, ValueError),
    ):
        with pytest.raises(error, match=r"gravit|pressures|start is a posture"):
            small_limb().sweep(pressures, progress=False, file=tmp_path / "a", **options)
        assert not files_in(tmp_path)


@pytest.mark.parametrize("content", [b"", b"x", b"pressure_kPa\n1\n", bytes(10_000), b"softlimb-sweep-2" * 9])
def test_a_file_that_is_no_sweep_is_refused_and_kept(known_rows, tmp_path, content: bytes) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(content)
    for call in (sl.Batch.load, lambda path: small_limb().sweep(PRESSURES, progress=False, file=path)):
        with pytest.raises(ValueError, match=r"a\.csv (is no sweep|was written by another version)"):
            call(path)
    assert path.read_bytes() == content
    with pytest.raises(FileNotFoundError, match="there is no file"):
        sl.Batch.load(tmp_path / "b")


def test_a_damaged_file_is_refused_by_name(fresh, tmp_path) -> None:
    path, batch = fresh
    whole, rng = path.read_bytes(), np.random.default_rng(5)
    damaged = tmp_path / "damaged"
    start = whole.index(b"{")
    cuts = [whole[: int(at)] for at in rng.integers(16, len(whole), 40)]
    flips = []
    for at in [*rng.integers(16, 32, 10), *rng.integers(start, start + 3000, 150)]:
        flip = bytearray(whole)
        flip[at] ^= 1 << int(rng.integers(0, 8))
        flips.append(bytes(flip))
    refused = 0
    for content in [*cuts, *flips]:
        damaged.write_bytes(content)
        try:
            found = sl.Batch.load(damaged)
            list(found.message)
        except ValueError as error:
            assert "damaged" in str(error)
            refused += 1
        else:
            assert len(found) == len(batch)  # a number of the limb or of the scene is another
    assert refused > 100


def test_a_relative_name_stays_that_of_the_folder_in_which_it_was_given(fresh, tmp_path, monkeypatch) -> None:
    path, batch = fresh
    monkeypatch.chdir(tmp_path)
    loaded = sl.Batch.load(path.name)
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    assert same_bits(loaded, batch) and loaded.file == path
