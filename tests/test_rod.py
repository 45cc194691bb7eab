"""One rod: closed forms, balance along the curve, work and energy, and rods that break naive solvers.

`tolerance` is the tip error asked for relative to the length, so a closed form is held against it without any margin;
the other tolerances carry their reasons. A section with equal axial and shear stiffness S stretches by n/S in the
direction of the force whatever its tangent, so that closed forms of the inextensible elastica hold exactly after adding
F l / S.
"""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import cumulative_simpson, solve_bvp
from scipy.optimize import brentq
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc

import softlimb as sl
from frames import turn
from softlimb import presets
from softlimb.units import deg, kPa

SOFT = sl.Section(axial=400.0, shear=130.0, bending=0.08, torsion=0.06, mass_per_length=0.4)
LENGTH = 0.25
# A round column may buckle in any direction: its postures form a ring, along which nothing holds Newton's steps. They
# are as long as rounding over rounding there, so a tolerance near 1e-9 is met by luck only.
ROUND = 1e-6


def random_turn(generator: np.random.Generator) -> np.ndarray:
    axis = generator.normal(size=3)
    return turn(axis / np.linalg.norm(axis) * generator.uniform(0.0, np.pi))


def solved(rod: sl.Rod, *loads: Any, **options: Any) -> Any:
    found = rod.cantilever(*loads, **options)
    assert found.success, found.message
    check = found.verify()
    assert check.success, check
    return found


# --- closed forms ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9])
@pytest.mark.parametrize("degrees", [1e-3, 90.0, 180.0, 270.0, 360.0, 1000.0, 1800.0])
def test_pure_moment_bends_the_rod_into_a_circular_arc(degrees: float, tolerance: float) -> None:
    angle = degrees * deg
    curvature = angle / LENGTH
    found = solved(sl.Rod(SOFT, LENGTH), tip_moment=(0.0, SOFT.bending * curvature, 0.0), tolerance=tolerance)
    s = np.linspace(0.0, LENGTH, 101)
    arc = np.stack([(1.0 - np.cos(curvature * s)) / curvature, 0.0 * s, np.sin(curvature * s) / curvature], axis=1)
    assert np.abs(found.tip[:3, 3] - arc[-1]).max() <= tolerance * LENGTH
    # Inside a rod nothing is promised tighter than at its tip, and nothing is much worse.
    assert np.abs(found.centreline() - arc).max() <= 10.0 * tolerance * LENGTH
    assert_allclose(found.tip[:3, :3], turn([0.0, angle, 0.0]), rtol=0.0, atol=10.0 * tolerance)
    uniform = np.tile([0.0, curvature, 0.0], (101, 1))
    assert_allclose(found.curvature, uniform, rtol=0.0, atol=10.0 * tolerance * curvature)


@pytest.mark.parametrize("seed", range(6))
def test_a_dead_moment_bends_any_rod_into_a_helix_about_it(seed: int) -> None:
    # Without force m is constant, so t' = (m/EI) x t turns about m whatever GJ; only the spin about t knows of torsion,
    # rest twist and coupling, and the stretch of the coupling.
    generator = np.random.default_rng(seed)
    section = sl.Section(
        axial=400.0, shear=130.0, bending=0.08, torsion=0.06,
        rest_twist=generator.uniform(-8.0, 8.0),
        extension_twist=generator.uniform(-0.15, 0.15),  # of a largest 1/sqrt(EA GJ) = 0.204
    )
    moment = generator.normal(size=3) * 0.6
    found = solved(sl.Rod(section, LENGTH), tip_moment=moment, tolerance=1e-10)
    bend, m3 = moment / section.bending, moment[2]
    spin = section.rest_twist + m3 / section.torsion - m3 / section.bending
    rate = float(np.linalg.norm(bend))
    axis = bend / rate
    along = axis * axis[2]
    across = np.array([0.0, 0.0, 1.0]) - along
    place = (
        along * LENGTH
        + across * np.sin(rate * LENGTH) / rate
        + np.cross(axis, across) * (1.0 - np.cos(rate * LENGTH)) / rate
    ) * (1.0 + section.extension_twist * m3)
    assert np.linalg.norm(found.tip[:3, 3] - place) <= 1e-10 * LENGTH
    expected = turn(bend * LENGTH) @ turn([0.0, 0.0, spin * LENGTH])
    assert_allclose(found.tip[:3, :3], expected, rtol=0.0, atol=1e-9)  # ten times the tip's tolerance


def test_tension_and_torque_stretch_and_twist_by_the_coupled_compliance() -> None:
    section = sl.Section(
        axial=400.0, shear=130.0, bending=0.08, torsion=0.06, rest_twist=3.0, extension_twist=0.57 / np.sqrt(24.0)
    )
    tension, torque = 12.0, 0.03
    found = solved(sl.Rod(section, LENGTH), (0.0, 0.0, tension), (0.0, 0.0, torque), tolerance=1e-9)
    stretch = 1.0 + tension / section.axial + section.extension_twist * torque
    twist = section.rest_twist + section.extension_twist * tension + torque / section.torsion
    # Uniform along the rod: nothing to integrate, only rounding.
    assert_allclose(found.strain, np.tile([0.0, 0.0, stretch], (101, 1)), rtol=0.0, atol=1e-13)
    assert_allclose(found.curvature, np.tile([0.0, 0.0, twist], (101, 1)), rtol=0.0, atol=1e-12)
    assert_allclose(found.tip[:3, 3], [0.0, 0.0, stretch * LENGTH], rtol=0.0, atol=1e-9 * LENGTH)
    assert_allclose(found.tip[:3, :3], turn([0.0, 0.0, twist * LENGTH]), rtol=0.0, atol=1e-8)


def test_a_rod_that_cannot_bend_shears() -> None:
    section = sl.Section(axial=400.0, shear=100.0, bending=1e7, torsion=1e7)
    found = solved(sl.Rod(section, LENGTH), (10.0, 0.0, 0.0), tolerance=1e-9)
    # Bending adds F l^2 / (3 EI) = 2e-8 rad and 1e-9 of the length.
    assert_allclose(found.strain[:, 0], 0.1, rtol=0.0, atol=1e-7)
    assert_allclose(found.tip[:3, 3], [0.1 * LENGTH, 0.0, LENGTH], rtol=0.0, atol=1e-7 * LENGTH)


def test_a_rod_without_load_keeps_its_rest_twist_and_length() -> None:
    section = sl.Section(axial=400.0, shear=100.0, bending=0.1, torsion=0.1, rest_twist=20.0)
    found = solved(sl.Rod(section, 1.0), tolerance=1e-9)
    assert_allclose(found.tip[:3, 3], [0.0, 0.0, 1.0], rtol=0.0, atol=1e-9)
    assert_allclose(found.tip[:3, :3], turn([0.0, 0.0, 20.0]), rtol=0.0, atol=1e-8)
    assert_allclose(found.base_wrench, np.zeros(6), rtol=0.0, atol=1e-12)  # rounding of a start off by nothing


def elastica_tip(load: float) -> tuple[float, float, float]:
    """Tip (x, z) over the length and tip angle under a transverse dead force F, load = F l^2/EI: Bisshopp, Drucker."""

    def phi0(k: float) -> float:
        return float(np.arcsin(1.0 / (k * np.sqrt(2.0))))

    alpha = np.sqrt(load)
    k = brentq(
        lambda k: ellipk(k * k) - ellipkinc(phi0(k), k * k) - alpha, np.sqrt(0.5) + 1e-15, 1.0 - 1e-14, xtol=1e-15
    )
    tip_angle = float(np.arcsin(2.0 * k * k - 1.0))
    z = np.sqrt(2.0 * np.sin(tip_angle)) / alpha
    x = 1.0 - 2.0 / alpha * (ellipe(k * k) - ellipeinc(phi0(k), k * k))
    return float(x), float(z), tip_angle


@pytest.mark.parametrize("load", [0.1, 1.0, 5.0, 20.0, 100.0])
def test_transverse_force_gives_the_elastica_of_elliptic_integrals(load: float) -> None:
    stiff = 250.0
    section = sl.Section(axial=stiff, shear=stiff, bending=0.1, torsion=0.1)
    force = load * section.bending / LENGTH**2
    found = solved(sl.Rod(section, LENGTH), (force, 0.0, 0.0), tolerance=1e-10)
    x, z, angle = elastica_tip(load)
    expected = np.array([x * LENGTH + force * LENGTH / stiff, 0.0, z * LENGTH])
    # k enters as 1 - k at large loads and the root is good to 1e-15: the closed form itself has 1e-9 at load 100.
    assert_allclose(found.tip[:3, 3], expected, rtol=0.0, atol=2e-9 * LENGTH)
    assert_allclose(found.tip[:3, 2], [np.sin(angle), 0.0, np.cos(angle)], rtol=0.0, atol=2e-8)


def test_an_extensible_shearable_rod_with_weight_agrees_with_scipy_collocation() -> None:
    # A planar boundary value problem written anew: angle, moment, x, z; force known from the load.
    section = sl.Section(axial=150.0, shear=40.0, bending=0.02, torsion=0.01, mass_per_length=0.5)
    weight = np.array([0.6, -1.1]) * section.mass_per_length * 9.81  # x and z
    tip = np.array([0.4, 0.9])

    def rates(s: np.ndarray, y: np.ndarray) -> np.ndarray:
        angle, moment = y[0], y[1]
        n = tip[:, None] + weight[:, None] * (LENGTH - s)
        tangent = np.array([np.sin(angle), np.cos(angle)])
        normal = np.array([np.cos(angle), -np.sin(angle)])
        stretch = 1.0 + (n * tangent).sum(axis=0) / section.axial
        shear = (n * normal).sum(axis=0) / section.shear
        dx, dz = stretch * tangent + shear * normal
        return np.array([moment / section.bending, -(dz * n[0] - dx * n[1]), dx, dz])

    mesh = np.linspace(0.0, LENGTH, 101)
    start = np.zeros((4, 101))
    start[3] = mesh
    reference = solve_bvp(
        rates, lambda a, b: np.array([a[0], a[2], a[3], b[1]]), mesh, start, tol=1e-10, max_nodes=20000
    )
    assert reference.success
    found = solved(
        sl.Rod(section, LENGTH), (tip[0], 0.0, tip[1]), gravity=(0.6 * 9.81, 0.0, -1.1 * 9.81), tolerance=1e-9
    )
    # Collocation's relative residual of 1e-10 over a quarter of a metre; the rest is ours.
    assert_allclose(found.centreline()[:, 0], reference.sol(found.fractions * LENGTH)[2], rtol=0.0, atol=1e-9)
    assert_allclose(found.centreline()[:, 2], reference.sol(found.fractions * LENGTH)[3], rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("degrees", [1.0, 30.0, 90.0, 150.0])
@pytest.mark.parametrize("growth", [20.0, 40.0, 80.0])
def test_strong_tension_gives_the_soliton_of_the_elastica(growth: float, degrees: float) -> None:
    # A long rod pulled by P at an angle psi0 to its base: psi = 4 atan(tan(psi0/4) e^(-k s)), k = sqrt(P/EI). Its end
    # is bent by e^(-growth) <= 2e-9 of psi0, which moves the tip by its square over k.
    stiff = 1e6
    section = sl.Section(axial=stiff, shear=stiff, bending=0.01, torsion=0.01)
    angle, k = degrees * deg, growth / LENGTH
    pull = section.bending * k**2
    direction, across = np.array([np.sin(angle), 0.0, np.cos(angle)]), np.array([-np.cos(angle), 0.0, np.sin(angle)])
    found = solved(sl.Rod(section, LENGTH), pull * direction, tolerance=1e-9)
    expected = (
        direction * (LENGTH - 2.0 / k * (1.0 - np.cos(0.5 * angle)) + pull * LENGTH / stiff)
        + across * 2.0 / k * np.sin(0.5 * angle)
    )
    assert np.linalg.norm(found.tip[:3, 3] - expected) <= 1e-9 * LENGTH + 2e-16 * LENGTH
    base = np.array([0.0, -np.sqrt(section.bending * pull) * 2.0 * np.sin(0.5 * angle), 0.0])
    assert_allclose(found.moment[0], -base, rtol=0.0, atol=1e-6 * np.abs(base).max())


@pytest.mark.parametrize("tip_degrees", [20.0, 60.0, 120.0, 176.0])
def test_a_column_past_its_critical_load_buckles_into_the_elastica(tip_degrees: float) -> None:
    # F l^2/EI = K(k)^2 with k = sin(tip angle / 2), above Euler's (pi/2)^2; z = 2 E/K - 1, sway = 2 k/K.
    stiff = 1e5
    section = sl.Section(axial=stiff, shear=stiff, bending=0.05, torsion=0.04)
    angle = tip_degrees * deg
    k = np.sin(0.5 * angle)
    quarter = float(ellipk(k * k))
    force = section.bending * (quarter / LENGTH) ** 2
    found = solved(sl.Rod(section, LENGTH), (0.0, 0.0, -force), tolerance=ROUND)
    assert found.stable
    sway = np.linalg.norm(found.tip[:2, 3])  # in any direction: the column is round
    z = LENGTH * (2.0 * float(ellipe(k * k)) / quarter - 1.0) - force * LENGTH / stiff
    assert_allclose(found.tip[2, 3], z, rtol=0.0, atol=ROUND * LENGTH)
    assert_allclose(sway, 2.0 * k / quarter * LENGTH, rtol=0.0, atol=ROUND * LENGTH)
    assert_allclose(np.arccos(found.tip[2, 2]), angle, rtol=0.0, atol=10.0 * ROUND)


CLAMPED_PINNED = brentq(lambda x: np.tan(x) - x, 4.4, 4.6, xtol=1e-14)


def pinned_wave(stiff: float) -> float:
    # The pin's side force shears the rod: tan x = x (1 - x^2 EI / (S l^2)), with EI = l = 1.
    return float(brentq(lambda x: np.tan(x) - x * (1.0 - x * x / stiff), 4.4, 4.6, xtol=1e-14))


# Held freedoms of the tip, and the first critical wave number times length: F (1 - F/EA + F/GA) = EI k^2, where the
# bracket is 1 for equal axial and shear stiffness. Two modes each, one a plane.
COLUMNS = {
    "free": ([0, 0, 0, 0, 0, 0], lambda stiff: 0.5 * np.pi),
    "guided": ([0, 0, 0, 1, 1, 1], lambda stiff: np.pi),
    "pinned on the axis": ([1, 1, 0, 0, 0, 0], pinned_wave),
    "clamped on the axis": ([1, 1, 0, 1, 1, 1], lambda stiff: 2.0 * np.pi),
}


@pytest.mark.parametrize("slenderness", [20.0, 2000.0])
@pytest.mark.parametrize("column", COLUMNS)
def test_a_column_becomes_unstable_at_eulers_load(column: str, slenderness: float) -> None:
    held, wave_of = COLUMNS[column]
    # A round rod: EA l^2/EI = 4 (l/r)^2 = 16 (l/d)^2.
    stiff = 16.0 * slenderness**2
    wave = wave_of(stiff)
    rod = sl.Rod(sl.Section(axial=stiff, shear=stiff, bending=1.0, torsion=1.0), 1.0)
    limb = sl.Limb([sl.Segment(rods=[rod], ring_radius=0.0)])
    # A millionth from the critical load: the smallest stiffness is 1e-6 of the others, counted well above rounding.
    for share, modes in ((1.0 - 1e-6, 0), (1.0 + 1e-6, 2)):
        force = share * wave**2
        pose = np.eye(4)
        pose[2, 3] = 1.0 - force / stiff
        options: dict[str, Any] = {"tip_force": (0.0, 0.0, -force), "start": pose[None], "prefer_stable": False}
        if any(held):
            options |= {"tip_pose": pose, "tip_held": [bool(h) for h in held]}
        found = limb.solve(**options, tolerance=1e-9)
        assert found.success, found.message
        assert found.unstable_modes == modes, share
        assert found.stable == (modes == 0)


@pytest.mark.parametrize("share, modes", [(0.999, 0), (1.001, 2)])
def test_a_heavy_column_becomes_unstable_at_its_known_weight(share: float, modes: int) -> None:
    # q l^3/EI = 7.837347 for a rod that neither stretches nor shears; here EI/(GA l^2) = 1e-7.
    rod = sl.Rod(sl.Section(axial=1e7, shear=1e7, bending=1.0, torsion=1.0), 1.0)
    found = solved(
        rod, distributed_force=(0.0, 0.0, -share * 7.83734744), prefer_stable=False, tolerance=1e-9
    )
    assert found.unstable_modes == modes


@pytest.mark.parametrize("share, modes", [(0.999, 0), (1.001, 2)])
def test_greenhills_clamped_rod_becomes_unstable_at_its_torque(share: float, modes: int) -> None:
    # Both ends held: tan(x) = x at half the total bend rate, M l/EI = 8.9868; shear negligible at EI/(GA l^2) = 1e-7.
    section = sl.Section(axial=1e7, shear=1e7, bending=1.0, torsion=0.8)
    limb = sl.Limb([sl.Segment(rods=[sl.Rod(section, 1.0)], ring_radius=0.0)])
    twist = share * 2.0 * CLAMPED_PINNED / section.torsion
    # Several turns: the hold knows its rotation only up to whole turns, so the rod's rest twist carries the end's.
    turned = sl.Section(axial=1e7, shear=1e7, bending=1.0, torsion=0.8, rest_twist=-twist)
    limb = sl.Limb([sl.Segment(rods=[sl.Rod(turned, 1.0)], ring_radius=0.0)])
    pose = np.eye(4)
    pose[2, 3] = 1.0
    found = limb.solve(tip_pose=pose, start=pose[None], prefer_stable=False, tolerance=1e-9)
    assert found.success, found.message
    assert found.unstable_modes == modes
    assert_allclose(found.rods[0][0].moment[:, 2], share * 2.0 * CLAMPED_PINNED, rtol=1e-9)  # GJ times the twist


# --- laws --------------------------------------------------------------------------------------------------------


def random_cantilever(generator: np.random.Generator) -> tuple[sl.Rod, dict[str, Any]]:
    section = sl.Section(
        axial=400.0, shear=130.0, bending=0.08, torsion=0.06, mass_per_length=0.4,
        rest_twist=generator.uniform(-5.0, 5.0), extension_twist=generator.uniform(-0.1, 0.1),
    )
    loads = {
        "tip_force": generator.normal(size=3) * 2.0,
        "tip_moment": generator.normal(size=3) * 0.2,
        "distributed_force": generator.normal(size=3) * 4.0,
        "distributed_moment": generator.normal(size=3) * 0.2,
        "gravity": generator.normal(size=3) * 5.0,
    }
    return sl.Rod(section, LENGTH), loads


@pytest.mark.parametrize("seed", range(8))
def test_force_and_moment_balance_between_any_two_points(seed: int) -> None:
    rod, loads = random_cantilever(np.random.default_rng(seed))
    found = solved(rod, **loads, tolerance=1e-10)
    line_force = loads["distributed_force"] + rod.section.mass_per_length * loads["gravity"]
    poses, force, moment, _, _ = found.along(401)
    left = (LENGTH * (1.0 - np.linspace(0.0, 1.0, 401)))[:, None]
    assert_allclose(force, loads["tip_force"] + line_force * left, rtol=0.0, atol=1e-9 * np.abs(force).max())
    places = poses[:, :3, 3]
    # Moment of the line force about each point: Simpson's rule, error (h/l)^4 / 180 = 2e-13 of it.
    first = cumulative_simpson(places, dx=LENGTH / 400, axis=0, initial=0.0)
    carried = np.cross(first[-1] - first - left * places, line_force)
    arm = np.cross(places[-1] - places, loads["tip_force"])
    expected = loads["tip_moment"] + loads["distributed_moment"] * left + arm + carried
    assert_allclose(moment, expected, rtol=0.0, atol=1e-8 * np.abs(moment).max())


@pytest.mark.parametrize("seed", range(4))
def test_strain_and_curvature_are_the_slopes_of_the_poses_and_follow_the_section(seed: int) -> None:
    rod, loads = random_cantilever(np.random.default_rng(100 + seed))
    section = rod.section
    found = solved(rod, **loads, tolerance=1e-11)
    count = 801
    poses, force, moment, strain, curvature = found.along(count)
    h = LENGTH / (count - 1)

    def slope(y: np.ndarray) -> np.ndarray:
        # Five-point central difference: error h^4 y5/30, with y5 about 40^5/m^4 (bends to 40 rad/m) 3e-8 relative.
        return np.asarray((y[:-4] - 8.0 * y[1:-3] + 8.0 * y[3:-1] - y[4:]) / (12.0 * h))

    inside = slice(2, -2)
    rotations = poses[:, :3, :3]
    v = np.einsum("kji,kj->ki", rotations[inside], slope(poses[:, :3, 3]))
    spin = np.einsum("kji,kjl->kil", rotations[inside], slope(rotations))
    u = np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=1)
    assert_allclose(v, strain[inside], rtol=0.0, atol=1e-7)
    assert_allclose(u, curvature[inside], rtol=0.0, atol=1e-7 * max(1.0, np.abs(u).max()))
    n, m = np.einsum("kji,kj->ki", rotations, force), np.einsum("kji,kj->ki", rotations, moment)
    c12 = section.extension_twist
    assert_allclose(strain[:, :2], n[:, :2] / section.shear, rtol=0.0, atol=1e-12)
    assert_allclose(strain[:, 2], 1.0 + n[:, 2] / section.axial + c12 * m[:, 2], rtol=0.0, atol=1e-12)
    assert_allclose(curvature[:, :2], m[:, :2] / section.bending, rtol=0.0, atol=1e-10)
    twist = section.rest_twist + c12 * n[:, 2] + m[:, 2] / section.torsion
    assert_allclose(curvature[:, 2], twist, rtol=0.0, atol=1e-10)


@pytest.mark.parametrize("seed", range(6))
def test_rotating_the_base_rotates_the_shape(seed: int) -> None:
    generator = np.random.default_rng(200 + seed)
    rod, loads = random_cantilever(generator)
    rotation, shift = random_turn(generator), generator.normal(size=3)
    base = np.eye(4)
    base[:3, :3], base[:3, 3] = rotation, shift
    straight = solved(rod, **loads, tolerance=1e-10)
    limb = sl.Limb([sl.Segment(rods=[rod], base_frames=base[None], end_frames=np.eye(4)[None])])
    turned = limb.solve(
        gravity=rotation @ loads["gravity"],
        tip_force=rotation @ loads["tip_force"],
        tip_moment=rotation @ loads["tip_moment"],
        rod_forces=[rotation @ loads["distributed_force"]],
        rod_moments=[rotation @ loads["distributed_moment"]],
        tolerance=1e-10,
    )
    assert turned.success, turned.message
    # Two solves, each within its tolerance of 1e-10; a start elsewhere takes other steps.
    assert_allclose(turned.tip, base @ straight.tip, rtol=0.0, atol=2e-9)
    assert_allclose(turned.centreline(51), straight.centreline(51) @ rotation.T + shift, rtol=0.0, atol=2e-9)


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("tolerance", [1e-3, 1e-5, 1e-7, 1e-9, 1e-11])
def test_the_tip_is_within_the_tolerance_of_a_far_finer_answer(tolerance: float, seed: int) -> None:
    rod, loads = random_cantilever(np.random.default_rng(300 + seed))
    exact = solved(rod, **loads, tolerance=1e-12)
    found = solved(rod, **loads, tolerance=tolerance)
    error = np.linalg.norm(found.tip[:3, 3] - exact.tip[:3, 3]) / LENGTH
    assert error <= tolerance + 1e-13  # rounding of both
    assert found.posture.error_estimate <= tolerance


def test_a_scaled_rod_has_the_scaled_shape() -> None:
    # Lengths by a, forces by b: EI scales with b a^2, loads per length with b/a. Powers of two: the same bits.
    rod, loads = random_cantilever(np.random.default_rng(7))
    s = rod.section
    small = solved(rod, **loads, tolerance=1e-9)
    for a, b in ((2.0**-8, 2.0**-20), (2.0**6, 2.0**10)):
        section = sl.Section(
            axial=b * s.axial, shear=b * s.shear, bending=b * a**2 * s.bending, torsion=b * a**2 * s.torsion,
            mass_per_length=b / a * s.mass_per_length, rest_twist=s.rest_twist / a,
            extension_twist=s.extension_twist / (a * b),
        )
        scaled = solved(
            sl.Rod(section, a * LENGTH),
            tip_force=b * loads["tip_force"],
            tip_moment=a * b * loads["tip_moment"],
            distributed_force=b / a * loads["distributed_force"],
            distributed_moment=b * loads["distributed_moment"],
            gravity=loads["gravity"],
            tolerance=1e-9,
        )
        assert scaled.iterations == small.iterations
        assert_allclose(scaled.tip[:3, 3] / a, small.tip[:3, 3], rtol=0.0, atol=1e-12)


# --- nonlinear axial law -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("segment", ["proximal", "distal"])
def test_a_hanging_rod_with_the_nonlinear_law_stretches_as_its_tube_does(segment: str) -> None:
    (ring,) = presets.reference_limb([segment])
    tube, pressure = ring.actuators[0], 55.0 * kPa
    rod = sl.Rod(tube.section(pressure, "nonlinear"), tube.rest_length(pressure))
    found = solved(rod, (0.0, 0.0, 8.0), gravity=(0.0, 0.0, 9.81), tolerance=1e-9)
    force = found.force[::20, 2]
    assert force.max() - force.min() > 0.1  # the weight makes the strain vary
    expected = np.array([tube.inflate(pressure, axial_force=n).stretch for n in force]) / tube.inflate(pressure).stretch
    # The law is a polynomial through the tube's own states: its fit misses by 3e-8 at a strain of 0.12.
    assert_allclose(found.strain[::20, 2], expected, rtol=1e-7)
    tangent = 1.0 + force / tube.section(pressure).axial
    assert np.abs(found.strain[::20, 2] - tangent).max() > 1e-4  # the two laws do differ here


@pytest.mark.parametrize("model", ["tangent", "nonlinear"])
def test_no_work_is_done_around_a_closed_path_of_loads(model: Any) -> None:
    (ring,) = presets.reference_limb(["distal"])
    tube, pressure = ring.actuators[0], 50.0 * kPa
    rod = sl.Rod(tube.section(pressure, model), tube.rest_length(pressure))
    count = 72
    angles = 2.0 * np.pi * np.arange(count) / count
    forces = np.stack([0.4 * np.cos(angles), 0.3 * np.sin(2.0 * angles), 4.0 + 3.0 * np.sin(angles)], axis=1)
    slopes = np.stack([-0.4 * np.sin(angles), 0.6 * np.cos(2.0 * angles), 3.0 * np.cos(angles)], axis=1)
    tips = np.array([solved(rod, f, gravity=(0.0, 3.0, 9.81), tolerance=1e-10).tip[:3, 3] for f in forces])
    # The integral of p . dF around the loop vanishes where the compliance is symmetric everywhere. The trapezoidal rule
    # on a smooth periodic function errs by less than its last Fourier coefficient.
    powers = (tips - tips.mean(axis=0)) * slopes
    spectrum = np.abs(np.fft.rfft(powers.sum(axis=1))) / count
    work, scale = powers.sum() * 2.0 * np.pi / count, np.abs(powers).sum() * 2.0 * np.pi / count
    assert spectrum[-1] < 1e-9 * scale
    assert abs(work) < 1e-8 * scale


# --- extreme rods ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("ratio", [10.0, 1e3, 1e5, 1e7, 1e9])
def test_axial_stiffness_from_soft_to_rigid_is_solved(ratio: float) -> None:
    stiff = ratio  # EA l^2/EI with l = EI = 1, up to slenderness 8000
    section = sl.Section(axial=stiff, shear=stiff, bending=1.0, torsion=0.8)
    found = solved(sl.Rod(section, 1.0), (2.0, 0.0, 0.0), tolerance=1e-9)
    x, z, _ = elastica_tip(2.0)
    assert_allclose(found.tip[:3, 3], [x + 2.0 / stiff, 0.0, z], rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("slenderness", [20.0, 200.0, 2000.0])
@pytest.mark.parametrize("share", [1.01, 1.5, 3.0, 8.0])
def test_a_slender_column_beyond_buckling_is_found_stable(share: float, slenderness: float) -> None:
    stiff = 16.0 * slenderness**2
    section = sl.Section(axial=stiff, shear=stiff, bending=1.0, torsion=1.0)
    found = solved(sl.Rod(section, 1.0), (0.0, 0.0, -share * 0.25 * np.pi**2), tolerance=ROUND)
    assert found.stable, found.message
    assert found.unstable_modes == 0
    assert "unstable" in found.message  # the straight column was met first


@pytest.mark.parametrize("slenderness", [20.0, 200.0, 2000.0])
@pytest.mark.parametrize("share", [1.02, 2.0, 8.0])
def test_a_heavy_slender_column_is_found_stable(share: float, slenderness: float) -> None:
    stiff = 16.0 * slenderness**2
    section = sl.Section(axial=stiff, shear=stiff, bending=1.0, torsion=1.0)
    found = solved(sl.Rod(section, 1.0), distributed_force=(0.0, 0.0, -share * 7.83734744), tolerance=ROUND)
    assert found.stable, found.message


# --- what a rod and its posture are ------------------------------------------------------------------------------


def test_rods_and_their_postures_pickle() -> None:
    rod, loads = random_cantilever(np.random.default_rng(1))
    found = solved(rod, **loads)
    assert pickle.loads(pickle.dumps(rod)) == rod
    again = pickle.loads(pickle.dumps(found))
    assert np.array_equal(again.tip, found.tip)
    assert np.array_equal(again.moment, found.moment)
    assert again.message == found.message


def test_reprs_say_what_a_reader_wants_to_know() -> None:
    rod = sl.Rod(SOFT, LENGTH, radius=0.01)
    assert "0.25" in repr(rod) and "400" in repr(rod)
    text = repr(rod.cantilever((0.0, 0.0, 1.0)))
    assert "converged" in text and "0.25" in text


def test_curves_have_the_points_asked_for_and_end_at_the_poses() -> None:
    found = solved(sl.Rod(SOFT, LENGTH), (1.0, 0.5, 0.0))
    for n in (2, 3, 57):
        assert found.centreline(n).shape == (n, 3)
    assert np.array_equal(found.centreline(2)[0], [0.0, 0.0, 0.0])
    # The curve is drawn by its own integration with half the step: within the tolerance of the plate it ends on.
    assert_allclose(found.tip, found.posture.tip, rtol=0.0, atol=1e-6)
    assert found.force.shape == found.strain.shape == (101, 3)


def test_a_posture_as_start_gives_the_same_answer() -> None:
    rod, loads = random_cantilever(np.random.default_rng(2))
    first = solved(rod, **loads, tolerance=1e-10)
    loads["tip_force"] = loads["tip_force"] * 1.05
    warm, cold = solved(rod, **loads, tolerance=1e-10, start=first), solved(rod, **loads, tolerance=1e-10)
    assert_allclose(warm.tip, cold.tip, rtol=0.0, atol=2e-9)
    assert warm.posture.descent_iterations == 0


BAD_RODS = [
    (lambda: sl.Rod(SOFT, 0.0), "length"),
    (lambda: sl.Rod(SOFT, -1.0), "length"),
    (lambda: sl.Rod(SOFT, float("nan")), "length"),
    (lambda: sl.Rod(SOFT, float("inf")), "length"),
    (lambda: sl.Rod(SOFT, "long"), "length"),  # type: ignore[arg-type]
    (lambda: sl.Rod(SOFT, None), "length"),  # type: ignore[arg-type]
    (lambda: sl.Rod(SOFT, 1j), "length"),  # type: ignore[arg-type]
    (lambda: sl.Rod(SOFT, True), "length"),
    (lambda: sl.Rod(SOFT, [0.2]), "length"),  # type: ignore[arg-type]
    (lambda: sl.Rod(None, 0.2), "section"),  # type: ignore[arg-type]
    (lambda: sl.Rod(SOFT, 0.2, radius=0.0), "radius"),
    (lambda: sl.Rod(SOFT, 0.2, radius=-0.1), "radius"),
    (lambda: sl.Rod(SOFT, 0.2, radius="thin"), "radius"),  # type: ignore[arg-type]
]
BAD_LOADS: list[tuple[dict[str, Any], str]] = [
    ({name: value}, name)
    for name in ("tip_force", "tip_moment", "distributed_force", "distributed_moment", "gravity")
    for value in (
        (1.0, 2.0), np.zeros((1, 3)), 1.0, (float("nan"), 0.0, 0.0), (0.0, float("inf"), 0.0), "x", None,
        (1j, 0.0, 0.0), np.array([True, False, False]), {"x": 1.0}, ("a", "b", "c"),
    )
] + [
    ({"tolerance": value}, "tolerance")
    for value in (0.0, -1e-6, float("nan"), 1.0, 1e-15, "fine", None, 1j, [1e-6], True)
] + [
    ({"start": value}, "start") for value in ("x", 3.0, np.eye(4), np.zeros((1, 4, 4)), np.full((1, 4, 4), np.nan))
]  # fmt: skip


@pytest.mark.parametrize("make, name", BAD_RODS)
def test_a_bad_rod_is_refused_by_name(make: Any, name: str) -> None:
    with pytest.raises((ValueError, TypeError), match=name):
        make()


@pytest.mark.parametrize("arguments, name", BAD_LOADS, ids=lambda value: str(value)[:50])
def test_a_bad_argument_of_cantilever_is_refused_by_name(arguments: dict[str, Any], name: str) -> None:
    with pytest.raises((ValueError, TypeError), match=name):
        sl.Rod(SOFT, LENGTH).cantilever(**arguments)


@pytest.mark.parametrize("n", [1, 0, -3, 2.5, 10**9, 2**70, float("nan"), "many", None])
def test_a_curve_needs_a_whole_number_of_points(n: Any) -> None:
    found = sl.Rod(SOFT, LENGTH).cantilever()
    with pytest.raises((ValueError, TypeError), match="points"):
        found.centreline(n)


@pytest.mark.parametrize("turns", [1, 3, 5])
@pytest.mark.parametrize("slender", [1e3, 1e5])
def test_a_tip_moment_winds_the_rod_up_into_circles(turns, slender):
    rod = sl.Rod(sl.Section(axial=slender, shear=slender / 3, bending=1.0, torsion=0.8), 1.0)
    tip = rod.cantilever(tip_moment=(0.0, 2.0 * np.pi * turns, 0.0))
    assert tip.success and tip.verify().success
    # A whole number of turns ends where it began; the tolerance asked for is 1e-6 of the length.
    np.testing.assert_allclose(tip.tip, np.eye(4), rtol=0.0, atol=1e-6)
    np.testing.assert_allclose(tip.curvature[:, 1], 2.0 * np.pi * turns, rtol=1e-6)


@pytest.mark.parametrize(("axial", "load"), [(1e6, 400.0), (1e4, 22.0), (900.0, 3.0)])
def test_a_round_column_buckles_into_one_of_a_ring_of_equal_postures(axial, load):
    # Nothing resists the turn of the buckled column about its axis: the stiffness has a zero eigenvalue.
    rod = sl.Rod(sl.Section(axial=axial, shear=axial / 3, bending=1.0, torsion=0.8), 1.0)
    found = rod.cantilever((0.0, 0.0, -load), tolerance=1e-9)
    assert found.success and found.stable and found.verify().success
    assert "one of many equal ones" in found.message
