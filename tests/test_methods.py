"""The methods that softlimb is compared with are what they claim: each is right where its own assumptions hold."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import softlimb as sl
from benchmarks.methods import modes
from benchmarks.methods.scenes import scenes
from softlimb import presets
from softlimb.bench import limbs
from softlimb.bench.methods import (
    collocation,
    constant_curvature,
    elastica,
    least_squares,
    multiple_shooting,
    single_shooting,
    wall,
)
from softlimb.bench.methods.judging import equilibrated, pose_error
from softlimb.paper import algorithm
from softlimb.paper.problem import Problem, condition
from softlimb.paper.rods import end_of, extrapolated
from softlimb.units import kPa
from tube_examples import plain, proximal, unequal

SECTION = sl.Section(axial=400.0, shear=130.0, bending=0.08, torsion=0.06, mass_per_length=0.4)
COUPLED = sl.Section(axial=400.0, shear=130.0, bending=0.08, torsion=0.06, rest_twist=0.7, extension_twist=0.05)


def ring(lengths, section=SECTION, **plate):
    rods = [sl.Rod(section, length) for length in lengths]
    return sl.Segment(rods=rods, ring_radius=0.03, plate=sl.Plate(**plate))


def solved(limb, **options):
    found = limb.solve(**options, tolerance=1e-10)
    assert found.success and found.verify().success, found.message
    return found


def test_a_pure_moment_bends_the_shot_rod_into_an_arc():
    limb = sl.Limb([sl.Segment(rods=[sl.Rod(SECTION, 0.5)], ring_radius=0.0)])
    problem = Problem.of(solved(limb, tip_moment=(0.0, 0.2, 0.0)))
    angle = 0.2 * 0.5 / SECTION.bending
    answer = single_shooting.solve(problem)
    assert answer.converged
    expected = 0.5 / angle * np.array([1.0 - np.cos(angle), 0.0, np.sin(angle)])
    # RK4 of 40 steps on an arc: (angle/40)^4/120 of the length.
    assert_allclose(answer.plates[0, :3, 3], expected, rtol=0.0, atol=1e-8)


@pytest.mark.parametrize("section", [SECTION, COUPLED])
def test_rk4_gains_sixteenfold_by_halving_the_step(section):
    limb = sl.Limb([sl.Segment(rods=[sl.Rod(section, 0.3)], ring_radius=0.0)])
    posture = solved(limb, tip_force=(0.8, 0.3, -0.2), rod_forces=[[0.5, 0.0, 1.0]], rod_moments=[[0.0, 0.02, 0.01]])
    problem, rod = Problem.of(posture), posture.rods[0][0]
    base = np.zeros((1, 3)), np.eye(3)[None]
    errors = []
    for steps in (4, 8, 16):
        position, _, _ = end_of(problem, [0], base, rod.base_wrench[None], problem.lengths, steps)
        errors.append(np.linalg.norm(position[0] - posture.tip[:3, 3]))
    assert 10.0 < errors[0] / errors[1] < 25.0
    assert 10.0 < errors[1] / errors[2] < 25.0


def test_single_shooting_finds_a_loaded_limb():
    limb = sl.Limb(
        [ring((0.2, 0.21, 0.2), thickness=0.02, mass=0.02), ring((0.2, 0.2, 0.19), thickness=0.02, mass=0.02)]
    )
    wrenches = np.array([[0.1, 0.0, 0.0, 0.0, 0.01, 0.0], [0.0, 0.1, 0.0, 0.01, 0.0, 0.005]])
    posture = solved(limb, gravity=(1.0, 2.0, 9.0), plate_wrenches=wrenches)
    answer = single_shooting.solve(Problem.of(posture))
    assert answer.converged
    assert answer.iterations < 20  # the derivatives are exact
    for found, true in zip(answer.plates, posture.plates, strict=True):
        assert pose_error(found, true, limb.length) < 1e-6


def test_the_derivatives_of_shooting_are_exact():
    limb = sl.Limb([ring((0.2, 0.21), thickness=0.02, mass=0.1), ring((0.2, 0.19, 0.2), thickness=0.02, mass=0.1)])
    posture = solved(limb, gravity=(1.0, 2.0, 9.0), tip_force=(0.2, 0.0, 0.0))
    problem = Problem.of(posture)
    generator = np.random.default_rng(1)
    plates = posture.plates.copy()
    wrenches = generator.normal(size=(5, 6)) * [1.0, 1.0, 1.0, 0.05, 0.05, 0.05]
    jacobian = single_shooting.residual_and_jacobian(problem, plates, wrenches)[1]
    move = generator.normal(size=jacobian.shape[1])

    def moved(h):
        changed = plates.copy()
        for j, x in enumerate(h * move[30:].reshape(-1, 6)):
            changed[j, :3, 3] += x[:3]
            changed[j, :3, :3] = single_shooting._turn(x[3:]) @ plates[j, :3, :3]
        return single_shooting.residual_and_jacobian(problem, changed, wrenches + h * move[:30].reshape(-1, 6))[0]

    slope = (moved(1e-5) - moved(-1e-5)) / 2e-5
    assert_allclose(jacobian @ move, slope, rtol=0.0, atol=1e-7 * np.abs(slope).max())


def test_single_shooting_fails_under_strong_tension():
    scene = next(scene for scene in scenes() if scene.name.startswith("growth e^80, one"))
    truth = solved(scene.limb(), **scene.options)
    assert_allclose(truth.tip[:3, 3], scene.exact, rtol=0.0, atol=1e-8)
    answer = single_shooting.solve(Problem.of(truth), limit=3.0, most_iterations=15)
    assert not answer.converged or pose_error(answer.plates[0], truth.tip, 1.0) > 1e-3


def loaded_segment():
    """Two coupled rods and a soft one under everything that the compared methods know."""
    rods = [sl.Rod(COUPLED, 0.2), sl.Rod(COUPLED, 0.21), sl.Rod(SECTION, 0.2)]
    limb = sl.Limb([sl.Segment(rods=rods, ring_radius=0.03, plate=sl.Plate(thickness=0.02, mass=0.05))])
    lines = {"rod_forces": np.full((3, 3), 0.2), "rod_moments": [[0.0, 0.02, 0.01]] * 3}
    return solved(limb, gravity=(1.0, 2.0, 9.0), tip_force=(0.2, 0.0, 0.1), tip_moment=(0.01, 0.0, 0.01), **lines)


def two_segments():
    limb = sl.Limb([ring((0.2, 0.205, 0.2), thickness=0.02, mass=0.02), ring((0.2, 0.2), thickness=0.02, mass=0.02)])
    return solved(limb, gravity=(0.0, 1.0, 9.0), tip_force=(0.1, 0.0, 0.0))


@pytest.mark.parametrize("scene", [loaded_segment, two_segments])
@pytest.mark.parametrize("method", [collocation, least_squares])
def test_scipy_finds_the_same_posture(method, scene):
    pytest.importorskip("scipy")
    posture = scene()
    answer = method.solve(Problem.of(posture), limit=60.0)
    assert answer.converged, answer.outcome
    for found, true in zip(answer.plates, posture.plates, strict=True):
        # RK4 of 40 steps, and a collocation residual of 1e-6.
        assert pose_error(found, true, posture.limb.length) < 1e-6
    wrenches = np.array([rod.base_wrench for row in posture.rods for rod in row])
    assert_allclose(answer.wrenches, wrenches, rtol=0.0, atol=1e-5 * np.abs(wrenches).max())


@pytest.mark.parametrize("method", [collocation, least_squares])
def test_scipy_gives_up_in_time(method):
    pytest.importorskip("scipy")
    answer = method.solve(Problem.of(two_segments()), limit=0.0)
    assert not answer.converged
    assert answer.outcome == "gave up"


def test_quaternions_of_rotations_turn_back_into_them():
    generator = np.random.default_rng(3)
    q = generator.normal(size=(40, 4))
    q /= np.linalg.norm(q, axis=-1, keepdims=True)
    q[:4] = np.eye(4)  # each half turn
    rotation = collocation._rotation_of(q)
    assert_allclose(rotation @ np.swapaxes(rotation, -1, -2), np.tile(np.eye(3), (40, 1, 1)), rtol=0.0, atol=1e-14)
    found = collocation._quaternion_of(rotation)
    assert_allclose(found * np.sign((found * q).sum(axis=-1, keepdims=True)), q, rtol=0.0, atol=1e-14)


def coarse(posture):
    """The posture once more, to a tolerance of a tenth: off by what a second opinion should notice."""
    names = ("gravity", "tip_force", "tip_moment", "rod_forces", "rod_moments")
    found = posture.limb.solve(**{name: posture.loads[name] for name in names}, tolerance=0.1)
    assert found.success
    return found


@pytest.mark.parametrize("scene", [loaded_segment, two_segments])
def test_multiple_shooting_finds_the_equilibrium_next_to_a_coarse_posture(scene):
    posture = scene()
    start = coarse(posture)
    length = posture.limb.length
    assert np.linalg.norm(start.tip[:3, 3] - posture.tip[:3, 3]) > 1e-8 * length
    found = multiple_shooting.refine(start, pieces=3, levels=3)
    assert found.converged and found.steps == 3 * 40
    # 120 steps a rod, extrapolated twice; and the posture's own tolerance of 1e-10.
    assert np.linalg.norm(found.tip - posture.tip[:3, 3]) < 2e-10 * length
    assert found.spread < 1e-8


def test_the_derivatives_of_multiple_shooting_are_exact():
    system = multiple_shooting._System(two_segments(), 3)
    generator = np.random.default_rng(2)
    move = generator.normal(size=system.size)

    def gaps(h):
        states = system.states(h * move)
        return system.gaps(states, system.ends(states, 10))

    slope = (gaps(1e-6) - gaps(-1e-6)) / 2e-6
    assert_allclose(system.slope(10) @ move, slope, rtol=0.0, atol=1e-6 * np.abs(slope).max())


def test_extrapolation_takes_the_fourth_and_the_fifth_order_out():
    steps = 0.5 ** np.arange(4)
    value, change = extrapolated([np.array([2.0 + 3.0 * h**4 - 5.0 * h**5]) for h in steps])
    assert_allclose(value, 2.0, rtol=1e-13)
    assert change < 1e-13


@pytest.mark.parametrize(("tube", "pressure"), [(proximal, 30.0), (unequal, 300.0), (plain, 90.0)])
def test_the_stresses_of_the_wall_balance_at_the_stretch_of_least_energy(tube, pressure):
    made, pascals = tube(), pressure * kPa
    stretch = made.inflate(pascals).stretch
    errors = [wall.by_shooting(made, pascals, steps).stretch - stretch for steps in (5, 10)]
    assert 12.0 < errors[0] / errors[1] < 20.0  # of fourth order
    fine = wall.by_shooting(made, pascals, 40)
    assert fine.converged
    # 5 steps a layer leave up to 3e-8 (0.7 % below ballooning), 40 steps 4096 times less.
    assert_allclose(fine.stretch, stretch, rtol=0.0, atol=1e-10)
    pytest.importorskip("scipy")
    assert_allclose(wall.by_least_squares(made, pascals).stretch, fine.stretch, rtol=0.0, atol=1e-9)
    found = wall.by_collocation(made, pascals, tolerance=1e-6)
    assert found.converged
    assert_allclose(found.stretch, stretch, rtol=0.0, atol=1e-6)


def test_walls_that_are_not_written_down_are_refused():
    for options, what in ((dict(tension_only=True), "tension-only"), (dict(ends="bonded"), "bonded")):
        with pytest.raises(ValueError, match=what):
            wall.by_shooting(proximal(**options), 1.0)
    with pytest.raises(ValueError, match="Yeoh and NeoHookean, got Gent"):
        wall.by_shooting(plain(sl.Gent(mu=1e5, jm=20.0)), 1.0)


def test_walls_past_ballooning_are_no_answer():
    found = wall.by_shooting(plain(), 95.0 * kPa)
    assert not found.converged
    pytest.importorskip("scipy")
    assert not wall.by_least_squares(plain(), 95.0 * kPa).converged
    assert wall.by_least_squares(plain(), 90.0 * kPa, limit=0.0).outcome == "gave up"
    assert wall.by_collocation(plain(), 90.0 * kPa, limit=0.0).outcome == "gave up"


@pytest.mark.slow  # PyElastica compiles itself first
@pytest.mark.filterwarnings("default")  # what it warns of is its own
def test_a_simulated_rod_comes_to_rest_where_ours_stands():
    pytest.importorskip("elastica")
    rod = limbs.soft_rod()
    true = rod.cantilever(tip_force=(0.03, 0.02, 0.0), gravity=limbs.HANGING)
    assert true.success
    answer = elastica.solve(rod, (0.03, 0.02, 0.0), limbs.HANGING, limit=300.0)
    assert answer.converged, answer.outcome
    # Its clamp holds half an element too much: a share 1.5/40 of the deflection of 18 mm, of a length of 300 mm.
    assert np.linalg.norm(answer.plates[0, :3, 3] - true.tip[:3, 3]) < 1.5 / 40 * 0.018 * 1.2


def test_a_simulated_rod_needs_a_mass():
    with pytest.raises(ValueError, match="needs a radius and a mass"):
        elastica.solve(sl.Rod(SECTION, 0.2), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


def test_constant_curvature_is_exact_for_equal_rods_and_close_for_nearly_equal_ones():
    limb = sl.Limb([ring((0.2, 0.2, 0.2), thickness=0.02), ring((0.3, 0.3, 0.3))])
    posture = solved(limb)
    answer = constant_curvature.solve(Problem.of(posture))
    assert_allclose(answer.plates, posture.plates, rtol=0.0, atol=1e-12)
    # Lengths of parallel arcs, in rods that rather bend than stretch. What bends them are forces at the plate's ring,
    # which do not bend evenly: that costs a share of the angle squared, 1 % at 0.3 rad.
    places = 0.03 * np.cos(2.0 * np.pi * np.arange(3) / 3)
    stiff = sl.Section(axial=4e7, shear=1.5e7, bending=0.08, torsion=0.06)
    for angle, share in ((0.3, 0.02), (0.03, 2e-4)):
        posture = solved(sl.Limb([ring(0.2 - angle * places, stiff)]))
        answer = constant_curvature.solve(Problem.of(posture))
        assert_allclose(answer.plates[0], constant_curvature.arc(0.2, angle / 0.2, 0.0), rtol=0.0, atol=1e-14)
        assert pose_error(answer.plates[0], posture.tip, 0.2) < share * angle


def test_constant_curvature_says_where_it_does_not_apply():
    scene = next(scene for scene in scenes() if scene.name == "Stewart-Gough robot")
    answer = constant_curvature.solve(Problem.of(solved(scene.limb(), **scene.options)))
    assert not answer.converged
    assert answer.outcome == "does not apply"


def test_the_papers_algorithm_recovers_the_lengths_of_one_segment():
    posture = solved(sl.Limb([ring((0.2, 0.21, 0.205))]))
    problem = Problem.of(posture)
    answer = algorithm.solve(problem, posture.tip, np.full(3, 0.2))
    assert answer.converged
    # Its tolerance, 1e-6 in SI units, over the stiffness of the rods in extension.
    assert_allclose(answer.lengths, problem.lengths, rtol=0.0, atol=1e-6)
    assert answer.iterations < 10


def test_the_papers_algorithm_has_63_unknowns_72_residuals_and_rank_60():
    limb = sl.Limb([ring((0.2, 0.21, 0.205), thickness=0.02), ring((0.2, 0.2, 0.19)), ring((0.2, 0.2, 0.2))])
    posture = solved(limb, tip_force=(0.05, 0.0, 0.0))
    problem = Problem.of(posture)
    wrenches = np.array([rod.base_wrench for row in posture.rods for rod in row])
    true = np.concatenate([problem.lengths, wrenches.ravel()])
    residuals, plates = algorithm.residual(problem, posture.tip, true)
    assert residuals.shape == (72,)
    assert_allclose(residuals, 0.0, rtol=0.0, atol=1e-6)  # the true posture is an answer: RK4 of 40 steps
    assert_allclose(plates[1][0], posture.plates[1, :3, 3], rtol=0.0, atol=1e-7)
    jacobian = algorithm.scaled_jacobian(problem, posture.tip, true)
    assert jacobian.shape == (72, 63)
    assert condition(jacobian)[1] == 60


def test_an_equilibrated_matrix_does_not_depend_on_units():
    matrix = np.array([[2.0, 1.0], [1.0, 3.0]])
    units = np.diag([1e6, 1e-3])
    assert_allclose(equilibrated(units @ matrix @ units), equilibrated(matrix), rtol=1e-6)
    assert_allclose(condition(matrix)[0], np.linalg.cond(matrix), rtol=1e-12)
    assert condition(np.ones((3, 2)))[1] == 1


def test_every_scene_has_its_own_name():
    names = [scene.name for scene in scenes()]
    assert len(set(names)) == len(names)


@pytest.mark.parametrize("pressure", [0.0, 40e3])
@pytest.mark.parametrize("gravity", [(0.0, 0.0, -9.81), (0.0, 0.0, 9.81), (0.0, 0.0, -40.0)])
def test_unstable_modes_counted_without_condensing_agree(pressure, gravity):
    limb = presets.reference_limb()
    posture = solved(limb, pressures=np.full(9, pressure), gravity=gravity, prefer_stable=False)
    wrenches = np.array([rod.base_wrench for row in posture.rods for rod in row])
    assert modes.unstable_modes(Problem.of(posture), posture.plates, wrenches) == posture.unstable_modes


def test_a_column_past_its_load_has_two_unstable_modes():
    scene = next(scene for scene in scenes() if scene.name.startswith("column at 3"))
    problem = Problem.of(scene.limb().solve(**scene.options))
    answer = single_shooting.solve(problem)
    assert answer.converged
    assert_allclose(answer.plates[0, :2, 3], 0.0, atol=1e-12)
    assert modes.unstable_modes(problem, answer.plates, answer.wrenches) == 2
