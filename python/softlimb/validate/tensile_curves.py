"""Tensile tests of silicones: laws fitted up to a strain, tested beyond it, and what that does to a limb."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from softlimb.identify import tip_uncertainty
from softlimb.limb import Limb, Segment
from softlimb.materials import DRAGON_SKIN_30, Fit, Law, TensileTest, fit_uniaxial, read_tensile_csv
from softlimb.presets import reference_limb
from softlimb.tube import Layer, Tube
from softlimb.units import kPa, mm
from softlimb.validate.results import Panel, Series, Table, Validation, rms

Array = NDArray[np.float64]

_FIT, _BEYOND = 0.5, 1.0  # end of the fit, and of what is held out, as nominal strain
_LAW = "yeoh"
_PAPER = "DragonSkin30"  # the curve whose law the paper prints
_SHOWN = 6  # panels of a picture
# A posture in which stretches stay within the fit range: the fit's own errors count, not its extrapolation.
_PRESSURES = np.tile([40.0, 20.0, 0.0], 3) * kPa
_GRAVITY = (0.0, 0.0, 9.81)


def read(folder: Path) -> list[TensileTest]:
    """All tests of a folder, in the order of their names; errors as for `read_tensile_csv`, and where there is none."""
    paths = sorted(folder.glob("*.csv"))
    if not paths:
        raise FileNotFoundError(f"there are no tensile tests (*.csv) in {folder}")
    return [read_tensile_csv(path) for path in paths]


def _errors(law: Law, test: TensileTest, low: float, high: float) -> Array:
    """Law less measurement between two strains, over the largest stress up to there."""
    strain = test.stretch - 1.0
    inside = (strain > low) & (strain <= high)
    stress = test.nominal_stress
    found: Array = (law.uniaxial_stress(test.stretch[inside]) - stress[inside]) / stress[strain <= high].max()
    return found


def _limb(core: Law) -> Limb:
    """The reference limb with another core."""
    segments = []
    for segment in reference_limb().segments:
        tube = segment.actuators[0]
        first, second = tube.layers
        layers = [Layer(first.inner, first.outer, core), second]
        made = Tube(tube.length, layers, mass=tube.mass)
        segments.append(Segment([made] * 3, ring_radius=segment.ring_radius, plate=segment.plate))
    return Limb(segments)


def validate(folder: Path) -> Validation:
    """Two-term Yeoh laws up to 50 % strain, held against the next 50 %; the paper's law without any fit."""
    tests = read(folder)
    rows, fits = [], {}
    panels: list[Panel] = []
    success = True
    for test in tests:
        fit = fit_uniaxial(test.stretch, test.nominal_stress, _LAW, max_strain=_FIT)
        success = success and fit.success
        fits[test.name] = fit
        inside, outside = _errors(fit.law, test, 0.0, _FIT), _errors(fit.law, test, _FIT, _BEYOND)
        rows.append(
            (
                test.name,
                f"{fit.coefficients['c1'] / kPa:.2f} +- {fit.standard_errors['c1'] / kPa:.2f}",
                f"{fit.coefficients['c2'] / kPa:.2f} +- {fit.standard_errors['c2'] / kPa:.2f}",
                str(fit.points),
                f"{100 * rms(inside):.1f}",
                f"{100 * rms(outside):.1f}",
                f"{100 * outside[-1]:+.1f}" if outside.size else "-",
            )
        )
        if len(panels) < _SHOWN:
            panels.append(_panel(test, fit))
    findings, unexplained = _paper_findings(tests, fits)
    return Validation(
        "tensile_curves",
        f"One pull to failure of each of {len(tests)} silicones (Soft Robotics Materials Database, L. Marechal et al. "
        f"2021, ODbL). A two-term Yeoh law fitted up to {100 * _FIT:.0f} % nominal strain; {100 * _FIT:.0f} to "
        f"{100 * _BEYOND:.0f} % held out.",
        (
            Table(
                "errors of the stress, in per cent of the largest one up to the end of the range",
                ("silicone", "c1 [kPa]", "c2 [kPa]", "points", "fitted, rms [%]", "held out, rms [%]",
                 "at 100 % strain [%]"),
                tuple(rows),
            ),
        ),
        tuple(findings),
        (
            *unexplained,
            "loading only: the files hold no unloading branch, so hysteresis and the softening of the first cycles "
            "cannot be judged; a limb that is cycled is softer than this",
            "strain is that of the crosshead: slip and the grips count as strain of the silicone",
            "one curve a material, of points that are not independent: batches differ by more than the standard errors",
        ),
        tuple(panels),
        success,
    )


def _paper_findings(tests: Sequence[TensileTest], fits: dict[str, Fit]) -> tuple[list[str], list[str]]:
    test = next((one for one in tests if one.name.replace(" ", "") == _PAPER), None)
    if test is None:
        return [], [f"there is no curve of {_PAPER} here, whose law the paper prints"]
    fit = fits[test.name]
    error = rms(_errors(DRAGON_SKIN_30, test, 0.0, _FIT))
    limb = _limb(fit.law)
    posture = limb.solve(_PRESSURES, gravity=_GRAVITY)
    spread = tip_uncertainty(posture, {"layers[0]": fit})
    wider = fit_uniaxial(test.stretch, test.nominal_stress, _LAW)
    other = _limb(wider.law).solve(_PRESSURES, gravity=_GRAVITY)
    length = limb.length
    moved = float(np.linalg.norm(posture.tip[:3, 3] - other.tip[:3, 3]))
    return [
        f"{test.name}, nothing fitted: the paper's printed coefficients miss this curve by {100 * error:.1f} % of the "
        f"largest stress, up to {100 * _FIT:.0f} % strain",
        f"at the tip of the reference limb, hanging at 40, 20, 0 kPa in every segment: the standard errors of this "
        f"core are {spread.position / mm:.2f} mm = {spread.position_percent:.2f} % of {length / mm:.0f} mm",
        f"the choice of the fit range moves the same tip more: all of the curve instead of the first "
        f"{100 * _FIT:.0f} % moves it by {moved / mm:.1f} mm = {100 * moved / length:.1f} % of {length / mm:.0f} mm",
    ], []


def _panel(test: TensileTest, fit: Fit) -> Panel:
    strain = test.stretch - 1.0
    shown = strain <= _BEYOND
    grid = np.linspace(0.0, min(_BEYOND, float(strain.max())), 80)
    held = shown & (strain > _FIT)
    return Panel(
        test.name,
        "nominal strain [1]",
        "nominal stress [kPa]",
        (
            Series("measured", strain[shown], test.nominal_stress[shown] / kPa),
            Series("predicted", grid[grid <= _FIT], fit.law.uniaxial_stress(1.0 + grid[grid <= _FIT]) / kPa),
            Series("held out", strain[held], fit.law.uniaxial_stress(test.stretch[held]) / kPa),
        ),
    )
