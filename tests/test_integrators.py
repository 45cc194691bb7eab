"""Every integrator of the list has the order it claims, on a rod that bends, twists, stretches and carries a load."""

import numpy as np
import pytest

from softlimb import Section, _core

SECTION = Section(axial=80.0, shear=30.0, bending=0.004, torsion=0.003, rest_twist=0.4, extension_twist=0.02)
WRENCH = [0.1, -0.05, 0.15, 0.006, 0.008, -0.005]
LINE_FORCE = [0.1, -0.2, 0.3]


def end(order, steps, *, section=SECTION, length=0.2, wrench=WRENCH, line_force=LINE_FORCE):
    position, rotation, last = _core.rod_end(
        section, length=length, wrench=wrench, line_force=line_force, order=order, steps=steps
    )
    return np.concatenate([position, np.ravel(rotation), last])


EXACT = end(8, 200)


@pytest.mark.parametrize("order", _core.integrator_orders())
def test_halving_the_step_reduces_the_error_by_two_to_the_order(order):
    # Steps coarse enough to stay above rounding (1e-15) and fine enough to be in the asymptotic range.
    steps = {4: 32, 6: 8, 8: 4}[order]
    coarse, fine = (np.abs(end(order, n) - EXACT).max() for n in (steps, 2 * steps))
    # The next term of the error series changes the ratio by a share of order h: a quarter of an order is ample.
    assert np.log2(coarse / fine) == pytest.approx(order, abs=0.25 * order**0.5)


def test_the_list_has_the_classical_method_as_a_reference():
    assert 4 in _core.integrator_orders()


def test_one_step_of_order_eight_errs_as_the_mesh_rule_assumes():
    # The mesh rule counts on about 1e-7 z^8 of the length for a step of activity z = l (|m|/EI + sqrt(|n|/EI)), and
    # leaves the exceptions to the check that follows each solve.
    generator = np.random.default_rng(20261122)
    section = Section(axial=400.0, shear=130.0, bending=0.08, torsion=0.07)
    constants = []
    for _ in range(400):
        force, moment = generator.normal(size=(2, 3))
        scales = 10 ** generator.uniform([-2.0, -2.3], [1.5, -0.3])
        wrench = np.concatenate([scales[0] * force, scales[1] * moment])
        activity = np.linalg.norm(wrench[3:]) / 0.07 + np.sqrt(np.linalg.norm(wrench[:3]) / 0.08)
        length = generator.uniform(0.5, 1.5) / activity
        options = {"section": section, "length": length, "wrench": wrench.tolist(), "line_force": [0.0, 0.0, 0.0]}
        error = np.abs(end(8, 1, **options)[:3] - end(8, 16, **options)[:3]).max() / length
        constants.append(error / (length * activity) ** 8)
    assert 1e-8 < np.median(constants) < 1e-7
    assert max(constants) < 1e-5


def test_an_order_without_an_integrator_is_refused():
    with pytest.raises(ValueError, match="order must be"):
        end(5, 1)
    with pytest.raises(ValueError, match="steps must be at least 1"):
        end(4, 0)
