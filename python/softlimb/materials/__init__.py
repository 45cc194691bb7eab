"""Material laws, presets with their sources, and the way from a tensile test to a law.

Every law is incompressible and isotropic; stresses are nominal (force over undeformed area) in Pa.
Source of the mechanics: MECHANICS, "Material".
"""

from typing import TYPE_CHECKING

from softlimb._core import DruckerCheck, Gent, MooneyRivlin, NeoHookean, Ogden, Yeoh
from softlimb.materials.law import LAWS, Law
from softlimb.materials.presets import (
    DRAGON_SKIN_10,
    DRAGON_SKIN_20,
    DRAGON_SKIN_30,
    ECOFLEX_00_30,
    ECOFLEX_00_50,
    SMOOTHSIL_950,
    get,
    names,
    source,
)

if TYPE_CHECKING:
    from softlimb.materials.fit import FIT_LAWS, Fit, fit_csv, fit_uniaxial
    from softlimb.materials.tensile_csv import TensileTest, read_tensile_csv

__all__ = [
    "DRAGON_SKIN_10",
    "DRAGON_SKIN_20",
    "DRAGON_SKIN_30",
    "ECOFLEX_00_30",
    "ECOFLEX_00_50",
    "FIT_LAWS",
    "LAWS",
    "SMOOTHSIL_950",
    "DruckerCheck",
    "Fit",
    "Gent",
    "Law",
    "MooneyRivlin",
    "NeoHookean",
    "Ogden",
    "TensileTest",
    "Yeoh",
    "fit_csv",
    "fit_uniaxial",
    "get",
    "names",
    "read_tensile_csv",
    "source",
]

# Loaded when first asked for: they cost 30 ms and numpy, and a limb with a preset needs neither.
_LATER = {
    "FIT_LAWS": "fit",
    "Fit": "fit",
    "fit_csv": "fit",
    "fit_uniaxial": "fit",
    "TensileTest": "tensile_csv",
    "read_tensile_csv": "tensile_csv",
}


def __getattr__(name: str) -> object:
    if name not in _LATER:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(f"{__name__}.{_LATER[name]}"), name)
