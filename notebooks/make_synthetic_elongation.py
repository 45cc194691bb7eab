"""Writes elongation-proximal.synthetic.csv: numbers in the form of a measurement, for examples. They measure nothing.

The prediction of the scene `elongation-proximal` with 4 % stiffer silicones, at thirteen pressures that the
"gauge" reads with 0.3 kPa and the "ruler" with 0.2 mm of Gaussian noise (numpy, default_rng(20)).
"""

from pathlib import Path

import numpy as np

import softlimb as sl
from softlimb.measured import response_of
from softlimb.scenes import limb_from_dict, limb_to_dict
from softlimb.units import kPa, mm

HEADER = """\
# SYNTHETIC: made by notebooks/make_synthetic_elongation.py, not measured.
# Prediction of the scene elongation-proximal with 4 % stiffer silicones; Gaussian noise of 0.3 kPa on the pressure and
# 0.2 mm on the elongation, numpy default_rng(20).
pressure_kPa,elongation_mm
"""


def stiffer(scene: sl.Scene, factor: float) -> sl.Scene:
    """The scene with every coefficient of its silicones times a factor."""
    tables = limb_to_dict(scene.limb)
    for law in tables["materials"].values():
        for name in [name for name in law if name.endswith("Pa")]:
            law[name] *= factor
    return scene.replaced(limb=limb_from_dict(tables))


def text() -> str:
    """The file's content."""
    rng = np.random.default_rng(20)
    response = response_of(stiffer(sl.load_scene("elongation-proximal"), 1.04), "elongation")
    lines = []
    for pressure in np.linspace(0.0, 55.0, 13) * kPa:
        # Two draws a row whether used or not, so that a changed range leaves the other rows alone.
        gauge, ruler = rng.normal(0.0, 0.3 * kPa), rng.normal(0.0, 0.2 * mm)
        lines.append(f"{max(0.0, pressure + gauge) / kPa:.2f},{(response(pressure) + ruler) / mm:.2f}\n")
    return HEADER + "".join(lines)


if __name__ == "__main__":
    Path(__file__).with_name("elongation-proximal.synthetic.csv").write_text(text(), encoding="utf-8")
