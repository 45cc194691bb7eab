"""Evaluations of designs, kept as they are made: in memory, and in a file that only grows.

The file has one JSON text a line: first what it is of, then one evaluation a line. A line that a killed run left half
written is dropped. Numbers are written so that the same bits come back.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from softlimb.design.problem import Evaluation, Problem

__all__ = ["History"]

_KIND = "softlimb design evaluations"


class History:
    """All evaluations of a problem, in the order in which they were made; each looked up by its values.

    Parameters
    ----------
    problem : Problem
    file : str or path, optional
        Where they are kept as well; evaluations that it has already are taken over.

    Raises
    ------
    ValueError
        The file is none of evaluations, or of another problem, or damaged.
    OSError
        It cannot be read or written.
    """

    def __init__(self, problem: Problem, file: str | os.PathLike[str] | None = None) -> None:
        self._problem = problem
        self._all: list[Evaluation] = []
        self._by_values: dict[tuple[float, ...], Evaluation] = {}
        self._path = None if file is None else Path(file)
        self.recalled = 0
        """How many evaluations the file had."""
        if self._path is not None:
            self._open(self._path)

    def _open(self, path: Path) -> None:
        head = json.dumps({"kind": _KIND, **self._problem.description()})
        text = path.read_bytes() if path.exists() else b""
        whole = text[: text.rfind(b"\n") + 1]
        if not whole:
            if text and not head.encode().startswith(text):
                raise ValueError(f"file {path} is no history of designs")
            path.write_text(head + "\n", encoding="utf-8")
            return
        lines = whole.decode("utf-8", errors="replace").splitlines()
        try:
            found = json.loads(lines[0])
        except json.JSONDecodeError:
            raise ValueError(f"file {path} is no history of designs") from None
        if not isinstance(found, dict) or found.get("kind") != _KIND:
            raise ValueError(f"file {path} is no history of designs")
        for name, own in json.loads(head).items():
            if found.get(name) != own:
                raise ValueError(f"file {path} is the history of another problem: its {name} differs")
        for number, line in enumerate(lines[1:], start=2):
            try:
                self._keep(_read(json.loads(line), len(self._problem.parameters)))
            except (ValueError, TypeError, KeyError) as error:
                raise ValueError(f"file {path} is damaged in line {number}: {error}") from None
        self.recalled = len(self._all)
        if len(whole) < len(text):
            with path.open("r+b") as file:
                file.truncate(len(whole))

    def _keep(self, evaluation: Evaluation) -> None:
        self._all.append(evaluation)
        self._by_values[evaluation.values] = evaluation

    def find(self, values: tuple[float, ...], gradients: bool) -> Evaluation | None:
        """The evaluation of these values, with gradients where they are asked for; None where there is none."""
        found = self._by_values.get(values)
        if found is None or (gradients and found.success and found.gradients is None):
            return None
        return found

    def add(self, evaluation: Evaluation) -> None:
        """Keep an evaluation; on the disk before this returns."""
        self._keep(evaluation)
        if self._path is not None:
            with self._path.open("a", encoding="utf-8") as file:
                file.write(json.dumps(_written(evaluation)) + "\n")

    @property
    def failures(self) -> dict[tuple[float, ...], str]:
        """Values of the designs that failed, to the reason."""
        return {each.values: each.failure for each in self._all if not each.success}

    def __len__(self) -> int:
        return len(self._all)

    def __iter__(self) -> Iterator[Evaluation]:
        return iter(self._all)

    def __getitem__(self, number: int) -> Evaluation:
        return self._all[number]

    def __repr__(self) -> str:
        return f"History({len(self)} evaluations, {len(self.failures)} failed)"


def _written(evaluation: Evaluation) -> dict[str, Any]:
    if not evaluation.success:
        return {"values": evaluation.values, "failure": evaluation.failure}
    found: dict[str, Any] = {
        "values": evaluation.values,
        "objective": evaluation.objective,
        "constraints": evaluation.constraints,
        "also": evaluation.also,
    }
    if evaluation.gradients is not None:
        found |= {"gradients": evaluation.gradients, "by_differences": evaluation.by_differences}
    return found


def _read(line: dict[str, Any], parameters: int) -> Evaluation:
    values = tuple(float(value) for value in line["values"])
    if len(values) != parameters:
        raise ValueError(f"{len(values)} values for {parameters} parameters")
    if "failure" in line:
        return Evaluation(values, float("nan"), failure=str(line["failure"]))
    gradients = line.get("gradients")
    return Evaluation(
        values,
        float(line["objective"]),
        tuple(float(value) for value in line["constraints"]),
        tuple(float(value) for value in line["also"]),
        None if gradients is None else tuple(tuple(float(slope) for slope in row) for row in gradients),
        tuple(line.get("by_differences", ())),
    )
