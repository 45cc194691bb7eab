"""The model against measurements made elsewhere, which stay out of the package: `validate(name, folder)`."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from os import PathLike
from pathlib import Path
from typing import NamedTuple

from softlimb.arguments import one_of
from softlimb.validate.results import Panel, Series, Table, Validation

__all__ = ["DATASETS", "Panel", "Series", "Table", "Validation", "validate"]


class _Dataset(NamedTuple):
    place: str  # below the folder of shared data
    module: str


DATASETS = {
    "fibre_tubes": _Dataset("measured/fibre_tubes", "fibre_tubes"),
    "tensile_curves": _Dataset("materials/raw", "tensile_curves"),
    "two_segment_arm": _Dataset("measured/two_segment_arm", "two_segment_arm"),
    "tendon_tentacle": _Dataset("measured/tendon_tentacle", "tendon_tentacle"),
}
"""Names that `validate` knows."""


def validate(name: str, folder: str | PathLike[str]) -> Validation:
    """Hold the model against a data set.

    Parameters
    ----------
    name : str
        One of `DATASETS`.
    folder : str or path
        Where its files are.

    Returns
    -------
    Validation

    Raises
    ------
    FileNotFoundError
        A file is missing.
    ValueError
        The name is unknown, or a file has a missing column, a cell that is no finite number, or too few rows.
    """
    one_of("name", name, tuple(DATASETS))
    if not isinstance(folder, str | PathLike):
        raise TypeError(f"folder must be a path, got {type(folder).__name__}")
    run: Callable[[Path], Validation] = import_module(f"softlimb.validate.{DATASETS[name].module}").validate
    return run(Path(folder))
