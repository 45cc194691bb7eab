"""The tolerance is honoured: a sample of `benchmarks/bench_tolerance.py`."""

from __future__ import annotations

import pytest

from benchmarks import bench_derivatives
from benchmarks.bench_tolerance import measure, scene


def test_the_tip_is_within_the_tolerance_on_random_scenes_of_random_limbs():
    outcomes = [measure(number) for number in range(150)]
    judged = [o for o in outcomes if o.judged]
    # Scenes that no stable posture exists for, or that have one of many equal ones, are not judged.
    assert len(judged) >= 0.9 * len(outcomes)
    shares = {o.number: o.share for o in judged}
    assert max(shares.values()) <= 10.0, shares
    assert sum(share > 1.0 for share in shares.values()) <= 0.01 * len(judged), shares


@pytest.mark.parametrize("number", [255, 529])
def test_rods_that_pull_too_hard_for_newton_are_stiffened_step_by_step(number: int):
    # Five or six rods a segment, up to ten per cent apart in length, EA l^2/EI up to 1e9: Newton alone fails here.
    limb, options, tolerance = scene(number)
    found = limb.solve(**options, tolerance=tolerance)
    assert found.success and found.stable and found.verify().success
    assert any("stiffness grown" in line for line in found.plan)


def test_a_tip_held_in_some_turns_is_where_a_second_solve_puts_it():
    # Free directions of such a plate turn with it: steps that balance those of an older pose end
    # elsewhere, by 1e-6 here.
    limb, options, _ = bench_derivatives.scene(6)
    assert any(options["tip_held"][3:]) and not all(options["tip_held"][3:])
    found = limb.solve(**options)
    again = limb.solve(**options, start=found)
    assert found.success and again.success
    # The tolerance of 1e-12 of the length, once for each of the two.
    assert abs(found.tip - again.tip).max() < 2.0 * options["tolerance"]
