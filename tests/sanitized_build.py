"""The build of the C++ claims under sanitizers. It takes minutes, so a whole run starts it beside the other tests."""

from __future__ import annotations

import os
import subprocess
import sysconfig
from pathlib import Path

ROOT = Path(__file__).parents[1]


def search_path() -> str:
    """With the environment's own programs first, also where it is not activated."""
    return os.pathsep.join([sysconfig.get_path("scripts"), os.environ.get("PATH", "")])


def environment() -> dict[str, str]:
    return {**os.environ, "PATH": search_path()}


def commands(build: Path, jobs: int) -> tuple[list[str], list[str]]:
    """Configure, and build."""
    configure = [
        "cmake", "-S", str(ROOT), "-B", str(build), "-G", "Ninja", "-DSOFTLIMB_CPP_TESTS=ON",
        "-DSOFTLIMB_SANITIZE=address,undefined", f"-DCMAKE_PREFIX_PATH={sysconfig.get_path('platlib')}",
    ]  # fmt: skip
    return configure, ["cmake", "--build", str(build), "--parallel", str(jobs)]


class Ahead:
    """One job in the background; where it fails, the test builds by itself and says why."""

    def __init__(self, build: Path) -> None:
        configure, make = commands(build, jobs=1)
        self._process: subprocess.Popen[bytes] | None = None
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "env": environment(), "cwd": build}
        try:
            if subprocess.run(configure, check=False, **quiet).returncode == 0:  # type: ignore[call-overload]
                self._process = subprocess.Popen(make, **quiet)  # type: ignore[call-overload]
        except OSError:  # no cmake: the test says so
            pass

    def wait(self) -> None:
        if self._process is not None:
            self._process.wait()

    def stop(self) -> None:
        """Ninja ends what it has started when it is asked to end."""
        if self._process is not None and self._process.poll() is None:
            self._process.terminate()
            self._process.wait()
