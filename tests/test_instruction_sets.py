"""One answer on every instruction set, to rounding, and the same bits on one."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from frames import solved
from softlimb import Rod, Section, _core, presets, rows
from softlimb.units import kPa

PRESSURES = np.array([60.0, 40.0, 20.0, 40.0, 30.0, 10.0, 50.0, 50.0, 20.0]) * kPa
LOADS = {"gravity": (0.0, 0.0, 9.81), "tip_force": (0.2, 0.1, 0.0)}


@pytest.fixture(autouse=True)
def restored() -> Iterator[None]:
    before = _core.instruction_set()
    yield
    _core.use_instruction_set(before)


@pytest.mark.parametrize("section", ["tangent", "nonlinear"])
def test_every_instruction_set_gives_the_same_posture_to_rounding(section: str) -> None:
    limb = presets.reference_limb()
    found = {}
    for name in _core.instruction_sets():
        _core.use_instruction_set(name)
        found[name] = solved(limb, PRESSURES, **LOADS, section=section, tolerance=1e-9)
    plain = found["baseline"]
    for posture in found.values():
        # Newton stops within the tolerance; its steps on the way differ by rounding, so the ends differ by far less.
        assert_allclose(posture.plates, plain.plates, rtol=0.0, atol=1e-10)
        assert_allclose(posture.jacobian, plain.jacobian, rtol=0.0, atol=1e-8 * np.abs(plain.jacobian).max())


def test_every_instruction_set_gives_the_same_cantilever_to_rounding() -> None:
    rod = Rod(Section(axial=400.0, shear=130.0, bending=0.08, torsion=0.06, mass_per_length=0.4), 0.3)
    found = {}
    for name in _core.instruction_sets():
        _core.use_instruction_set(name)
        found[name] = rod.cantilever(tip_force=(1.0, 0.5, 2.0), gravity=(0.0, 0.0, 9.81), tolerance=1e-8).posture
    plain = found["baseline"]
    for posture in found.values():
        assert "shot from its tip" in posture.plan[0]
        # The last turn is as small on all of them; what rounding leaves of it is far below the tolerance.
        assert_allclose(posture.tip, plain.tip, rtol=0.0, atol=1e-12)
        assert posture.verify().success


def test_one_instruction_set_gives_the_same_bits_again() -> None:
    limb = presets.reference_limb()
    for name in _core.instruction_sets():
        _core.use_instruction_set(name)
        first, second = (solved(limb, PRESSURES, **LOADS) for _ in range(2))
        assert_array_equal(first.plates, second.plates)


def test_an_unknown_instruction_set_is_refused_with_the_list() -> None:
    with pytest.raises(ValueError, match=r"instruction_set must be one of baseline.*quantum"):
        _core.use_instruction_set("quantum")


def test_the_build_that_a_sweep_records_follows_the_instruction_set() -> None:
    for name in _core.instruction_sets():
        _core.use_instruction_set(name)
        assert rows.build().endswith(f"instruction set {name}")
