"""The command ``softlimb``.

A subcommand is a module of this package with ``add_parser(subparsers)`` and ``run(arguments) -> int``, and one entry in
`SUBCOMMANDS`. What the user got wrong ends as one line on the error stream and exit code 2; a calculation that does not
succeed says its status and ends with exit code 1.
"""

from __future__ import annotations

import argparse
import os
import re
import sys
from collections.abc import Sequence
from typing import Any, NoReturn

from softlimb.cli import bench, compare, control, design, fit, posture, reach, report, sweep, validate, workspace

SUBCOMMANDS = (posture, reach, control, sweep, workspace, compare, fit, design, validate, bench, report)


_BROKEN_PIPE = 141  # what a shell reports of a command that SIGPIPE ended


class _UsageError(Exception):
    """A command line that cannot be read."""


class _Parser(argparse.ArgumentParser):
    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        # argparse knows -1 and -1.5 as numbers, but takes -1e5 for an option.
        self._negative_number_matcher = re.compile(r"^-(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?$|^-(?:inf|nan)$")

    def error(self, message: str) -> NoReturn:
        raise _UsageError(f"{message} (see `{self.prog} --help`)")


class _Version(argparse.Action):
    """Looks the version up only when it is asked for: that takes longer than everything else here."""

    def __call__(self, *_: object) -> NoReturn:
        from importlib.metadata import version

        print(f"softlimb {version('softlimb')}")
        raise SystemExit(0)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments without the program's name; default: those of the process.

    Returns
    -------
    int
        0 on success, 1 when a calculation did not succeed, 2 for a mistake in what was given, 130 after Ctrl-C, 141
        when the reader of the output closed it.
    """
    parser = _Parser(
        prog="softlimb", description="Statics of soft limbs built of fibre-reinforced pneumatic actuators."
    )
    parser.add_argument("--version", action=_Version, nargs=0, help="print the version and exit")
    subparsers = parser.add_subparsers(title="commands", dest="command", metavar="COMMAND", required=True)
    for subcommand in SUBCOMMANDS:
        subcommand.add_parser(subparsers)
    try:
        arguments = parser.parse_args(argv)
        run = next(s.run for s in SUBCOMMANDS if s.__name__.rpartition(".")[2] == arguments.command)
        code = int(run(arguments))
        sys.stdout.flush()  # here and not at the end of the process: who reads may be gone
        return code
    except SystemExit as end:  # --help and --version
        return int(end.code or 0)
    except BrokenPipeError:
        # What reads our output has seen enough (`| head`). The interpreter flushes once more when it ends.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return _BROKEN_PIPE
    except RecursionError:
        print("softlimb: error: what was given is nested too deeply", file=sys.stderr)
        return 2
    except MemoryError as error:
        print(f"softlimb: error: not enough memory: {' '.join(str(error).split()) or 'too large'}", file=sys.stderr)
        return 2
    except (_UsageError, ValueError, OSError, ModuleNotFoundError, OverflowError) as error:
        print(f"softlimb: error: {' '.join(str(error).split())}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("softlimb: interrupted", file=sys.stderr)
        return 130
