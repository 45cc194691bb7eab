"""Silicones by name. Each law carries the strain range of its fit; `source` says where its numbers come from.

Coefficients whose source is the database are fits (`fit_csv(file, "yeoh", max_strain=1.0)`, four digits) to single
tensile curves of the Soft Robotics Materials Database, L. Marechal et al., Soft Robotics 2021, doi
10.1089/soro.2019.0115, which is made available under the Open Database License. Its strains come from the crosshead, so
slip and the compliance of the grips count as strain. Cured silicone differs from batch to batch: fit your own where
that matters.
"""

from __future__ import annotations

from dataclasses import dataclass
from difflib import get_close_matches

from softlimb._core import NeoHookean, Yeoh
from softlimb.materials.law import Law
from softlimb.units import MPa

# Densities: nominal values for these silicones, not looked up in a data sheet; give your own where the weight matters.
DRAGON_SKIN_30 = Yeoh(c1=0.0861 * MPa, c2=0.0136 * MPa, density=1080.0, max_strain=0.5)
SMOOTHSIL_950 = NeoHookean(c1=0.34 * MPa, density=1240.0)
DRAGON_SKIN_10 = Yeoh(c1=0.02185 * MPa, c2=0.002753 * MPa, density=1070.0, max_strain=1.0)
DRAGON_SKIN_20 = Yeoh(c1=0.06117 * MPa, c2=0.007956 * MPa, density=1080.0, max_strain=1.0)
ECOFLEX_00_30 = Yeoh(c1=0.007504 * MPa, c2=0.000238 * MPa, density=1070.0, max_strain=1.0)
ECOFLEX_00_50 = Yeoh(c1=0.01029 * MPa, c2=0.0003825 * MPa, density=1070.0, max_strain=1.0)

_PAPER = (
    "coefficients published in Zhang et al., Design and Control of a Soft Supernumerary Robotic Limb Based on "
    "Fiber-Reinforced Actuator"
)
_DATABASE = (
    "computed from the Soft Robotics Materials Database (L. Marechal et al., Soft Robotics 2021, "
    "doi 10.1089/soro.2019.0115, ODbL 1.0), `{}`: two-term Yeoh law, nominal strain up to 100 %, one pull to failure"
)


@dataclass(frozen=True)
class _Preset:
    law: Law
    source: str


_PRESETS = {
    "dragon-skin-10": _Preset(DRAGON_SKIN_10, _DATABASE.format("Dragon Skin 10 MEDIUM.csv")),
    "dragon-skin-20": _Preset(DRAGON_SKIN_20, _DATABASE.format("Dragon Skin 20.csv")),
    "dragon-skin-30": _Preset(
        DRAGON_SKIN_30,
        _PAPER + "; the database's curve gives the same ones (0.0860, 0.0137 MPa) for nominal strains up to 50 %, "
        "which is therefore their range",
    ),
    "ecoflex-00-30": _Preset(ECOFLEX_00_30, _DATABASE.format("Ecoflex 00-30.csv")),
    "ecoflex-00-50": _Preset(ECOFLEX_00_50, _DATABASE.format("Ecoflex 00-50.csv")),
    "smoothsil-950": _Preset(SMOOTHSIL_950, _PAPER + "; no public curve is known to us, so neither is the range"),
}


def names() -> tuple[str, ...]:
    """Names that `get` knows, in alphabetical order."""
    return tuple(_PRESETS)


def get(name: str) -> Law:
    """A material law by name.

    Parameters
    ----------
    name : str
        One of `names()`, such as "dragon-skin-30"; case, spaces and underscores do not matter.

    Returns
    -------
    Law
        Immutable, so it can be shared.

    Raises
    ------
    ValueError
        The name is not known; the nearest known ones are suggested.
    """
    return _preset(name).law


def source(name: str) -> str:
    """Where the numbers of a preset come from, with the attribution that its data ask for.

    Raises
    ------
    ValueError
        The name is not known.
    """
    return _preset(name).source


def _preset(name: str) -> _Preset:
    key = "-".join(str(name).lower().replace("_", " ").replace("-", " ").split())
    if key not in _PRESETS:
        near = get_close_matches(key, _PRESETS, n=2)
        hint = f"did you mean {' or '.join(repr(n) for n in near)}?" if near else f"known are {', '.join(_PRESETS)}"
        raise ValueError(f"there is no material named {name!r}: {hint}")
    return _PRESETS[key]
