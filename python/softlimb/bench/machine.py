"""Where a run takes place: machine, compiler and flags of the core, versions."""

from __future__ import annotations

import os
import platform
from importlib.metadata import PackageNotFoundError, version

from softlimb import _core

__all__ = ["instruction_set", "machine"]


def machine() -> dict[str, str]:
    """Facts that times belong to, by name."""
    build = _core.build_info()
    return {
        "processor": _processor(),
        "cores": _cores(),
        "system": f"{platform.system()} {platform.release()}, {platform.machine()}",
        "compiler": f"{build['compiler']}, __cplusplus {build['standard']}, assertions {build['assertions']}",
        "target": build["target"],
        "flags": build["flags"],
        "instruction set": instruction_set(),
        "Python": f"{platform.python_version()} ({platform.python_implementation()})",
        **{name: _version(name) for name in ("softlimb", "numpy", "scipy", "pyelastica")},
    }


def instruction_set() -> str:
    """What the core chose at run time; "baseline" where it has no choice."""
    ask = getattr(_core, "instruction_set", None)
    return "baseline" if ask is None else str(ask())


def _processor() -> str:
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as file:
            for line in file:
                name, _, value = line.partition(":")
                if name.strip() == "model name":
                    return value.strip()
    except OSError:
        pass  # not Linux
    return platform.processor() or platform.machine() or "unknown"


def _cores() -> str:
    count = os.cpu_count() or 1
    allowed = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else count
    return str(count) if allowed == count else f"{count}, {allowed} of them for this process"


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"
