"""The claims about the C++ core (tests/cpp), under AddressSanitizer and UndefinedBehaviorSanitizer.

Built without Python, with the assertions of Eigen and of the standard library on, halting at the first error. What is
built is kept in pytest's cache, so that only the first run takes minutes.

The same under ThreadSanitizer, which wants a build of its own and finds its work in three claims (from the root, in an
environment with the `test` extra)::

    cmake -S . -B build/thread -G Ninja -DSOFTLIMB_CPP_TESTS=ON -DSOFTLIMB_SANITIZE=thread \
        -DCMAKE_PREFIX_PATH=$(python -c "import sysconfig; print(sysconfig.get_path('platlib'))")
    cmake --build build/thread
    build/thread/softlimb_claims thread

Without ``SOFTLIMB_SANITIZE`` the same commands build the plain claims, to look at one by name or in a debugger.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sysconfig
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


def compiler() -> str:
    """The compiler that CMake would take."""
    found = next((path for name in (os.environ.get("CXX", ""), "c++") if name and (path := shutil.which(name))), None)
    if found is None:
        pytest.skip("no C++ compiler: neither $CXX nor c++")
    return found


def require_sanitizers(folder: Path) -> None:
    program = folder / "empty.cpp"
    program.write_text("int main() { return 0; }\n", encoding="utf-8")
    command = [compiler(), "-fsanitize=address,undefined", str(program), "-o", str(folder / "empty")]
    built = subprocess.run(command, capture_output=True, text=True, check=False)
    if built.returncode != 0:
        pytest.skip(f"the compiler has no runtime for -fsanitize=address,undefined: {built.stderr.strip()[-300:]}")
    started = subprocess.run([str(folder / "empty")], capture_output=True, text=True, check=False)
    if started.returncode != 0:
        pytest.skip(f"a sanitised program does not start here: {started.stderr.strip()[-300:]}")


def leaks_are_seen(folder: Path) -> bool:
    """Leaks are looked for by ptrace, which some containers forbid."""
    program = folder / "leak.cpp"
    program.write_text("int main() { new int[100]; return 0; }\n", encoding="utf-8")
    subprocess.run([compiler(), "-fsanitize=address", str(program), "-o", str(folder / "leak")], check=True)
    environment = {**os.environ, "ASAN_OPTIONS": "detect_leaks=1"}
    ended = subprocess.run([str(folder / "leak")], capture_output=True, text=True, check=False, env=environment)
    return "detected memory leaks" in ended.stderr


@pytest.mark.slow  # minutes of compilation the first time: Eigen's templates, instrumented
def test_the_claims_about_the_core_hold_under_address_and_undefined_behaviour_sanitizers(
    request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    if not request.config.getoption("--sanitizers"):
        pytest.skip("compiles for minutes: pytest --sanitizers tests/test_sanitizers.py")
    for tool in ("cmake", "ninja"):
        if shutil.which(tool, path=_search_path()) is None:
            pytest.skip(f"{tool} is not there: pip install '.[test]'")
    require_sanitizers(tmp_path)
    assert request.config.cache is not None
    build = request.config.cache.mkdir("softlimb-sanitizers")
    environment = {**os.environ, "PATH": _search_path()}
    configure = [
        "cmake", "-S", str(ROOT), "-B", str(build), "-G", "Ninja", "-DSOFTLIMB_CPP_TESTS=ON",
        "-DSOFTLIMB_SANITIZE=address,undefined", f"-DCMAKE_PREFIX_PATH={sysconfig.get_path('platlib')}",
    ]  # fmt: skip
    for command in (configure, ["cmake", "--build", str(build), "--parallel", "2"]):
        done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment, cwd=tmp_path)
        assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-2000:]
    environment["ASAN_OPTIONS"] = f"detect_leaks={int(leaks_are_seen(tmp_path))}:halt_on_error=1"
    environment["UBSAN_OPTIONS"] = "print_stacktrace=1:halt_on_error=1"
    program = str(build / "softlimb_claims")
    done = subprocess.run([program], capture_output=True, text=True, check=False, env=environment, cwd=tmp_path)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-6000:]
    assert "0 of them do not hold" in done.stdout


def _search_path() -> str:
    """With the environment's own programs first, also where it is not activated."""
    return os.pathsep.join([sysconfig.get_path("scripts"), os.environ.get("PATH", "")])
