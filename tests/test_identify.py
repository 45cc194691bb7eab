from __future__ import annotations

import pickle
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy import optimize, stats

import softlimb as sl
from softlimb.identify import (
    ActuatorCurve,
    DrivenLimb,
    DrivenSegment,
    EmpiricalActuator,
    LimbCurve,
    Points,
    ScaledTube,
    TipPoses,
    identify,
    least_squares,
    tip_uncertainty,
)
from softlimb.identify.actuators import changed_actuator, rod_slopes, values_of
from softlimb.identify.identify import _Explained
from softlimb.identify.statistics import robust_scale, student_quantile
from softlimb.units import kPa, mm
from tube_examples import proximal, unequal

sys.path.insert(0, str(Path(__file__).parent / "benchmarks"))
import bench_coverage

HANGING = {"gravity": (0, 0, 9.81), "tip_force": (0.2, 0.0, 0.0)}
X = np.linspace(0.0, 1.0, 25)


def line(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    slopes = np.stack([np.ones_like(X), X], axis=1)
    return slopes @ values, slopes


def empirical() -> EmpiricalActuator:
    return EmpiricalActuator(length=(0.1, 0.05, -0.01), axial=(200.0, 100.0), bending=(0.02, 0.01), mass=0.02)


def saturating() -> EmpiricalActuator:
    return replace(empirical(), length_denominator=(0.3, 0.1))


def pillows() -> DrivenLimb:
    places = ((0.05, 0.0), (-0.05, 0.0), (0.0, 0.02), (0.0, -0.02))
    return DrivenLimb([DrivenSegment([saturating()] * 4, places=places, plate=sl.Plate(0.02, 0.2))] * 2)


# Statistics


@pytest.mark.parametrize("freedom", [1, 2, 3, 7, 30, 500])
@pytest.mark.parametrize("confidence", [0.5, 0.95, 0.999])
def test_students_quantile(freedom: int, confidence: float) -> None:
    # the series is exact and bisection goes to the last bits of an angle
    assert_allclose(student_quantile(confidence, freedom), stats.t.ppf(0.5 + 0.5 * confidence, freedom), rtol=1e-9)


def test_the_robust_scale_does_not_see_a_fifth_of_outliers() -> None:
    rng = np.random.default_rng(3)
    noise = rng.standard_normal(5000)
    noise[:1000] *= 1000.0
    # A fifth of the points beyond everything moves the median of sizes to the quantile 0.625 of the others.
    assert_allclose(robust_scale(noise, 1), stats.norm.ppf(0.8125) / stats.norm.ppf(0.75), rtol=0.05)


def test_a_linear_model_has_the_estimates_errors_and_correlation_of_linear_regression() -> None:
    rng = np.random.default_rng(5)
    y = line(np.array([2.0, -1.0]))[0] + 0.1 * rng.standard_normal(X.size)
    found = least_squares(line, y, {"a": 1.0, "b": 1.0})
    other = stats.linregress(X, y)
    assert found.success and found.identifiable
    # one Gauss-Newton step is exact; the rest is rounding
    assert_allclose(found.estimates, [other.intercept, other.slope], rtol=1e-12)
    assert_allclose(list(found.standard_errors.values()), [other.intercept_stderr, other.stderr], rtol=1e-10)
    assert_allclose(found.correlation[0, 1], -np.mean(X) / np.sqrt(np.mean(X**2)), rtol=1e-10)
    half = stats.t.ppf(0.975, X.size - 2) * other.stderr
    assert_allclose(found.intervals["b"], (other.slope - half, other.slope + half), rtol=1e-9)
    # of a linear model the profile is the same interval, found to a ten-thousandth of its half width
    profile = found.profile("b")
    assert_allclose(profile.interval, found.intervals["b"], atol=3e-4 * half)
    assert_allclose(profile.distance, (profile.values - other.slope) / other.stderr, atol=1e-6)


def test_another_search_finds_the_same_nonlinear_fit() -> None:
    rng = np.random.default_rng(11)
    exact, _ = bench_coverage.decay((2.0, 1.5))
    y = exact + 0.05 * rng.standard_normal(exact.size)
    places = bench_coverage.PLACES
    values, covariance = optimize.curve_fit(lambda x, a, b: a * np.exp(-b * x), places, y, p0=(1, 1), xtol=1e-12)
    found = least_squares(bench_coverage.decay, y, {"a": 1.0, "b": 1.0})
    assert_allclose(found.estimates, values, rtol=1e-6)  # the other takes its slopes by differences
    assert_allclose(found.covariance, covariance, rtol=1e-4)


def test_intervals_hold_the_truth_as_often_as_they_say() -> None:
    trials = 400
    rng = np.random.default_rng(17)
    # Four standard deviations of the binomial law: one seed in 16 000 would fail a method that keeps its word.
    bound = 4.0 * np.sqrt(0.95 * 0.05 / trials)
    assert np.all(np.abs(bench_coverage.decay_trials(trials, rng, "square") - 0.95) <= bound)


def test_intervals_of_a_tube_hold_the_truth_as_often_as_they_say() -> None:
    trials = 100
    bound = 4.0 * np.sqrt(0.95 * 0.05 / trials)  # as above
    assert np.all(np.abs(bench_coverage.tube_trials(trials, np.random.default_rng(19)) - 0.95) <= bound)


@pytest.mark.parametrize("loss", ["huber", "cauchy"])
def test_a_robust_loss_finds_the_line_through_outliers(loss: Any) -> None:
    rng = np.random.default_rng(7)
    truth = np.array([2.0, -1.0])
    y = line(truth)[0] + 0.01 * rng.standard_normal(X.size)
    y[[3, 11, 18]] += 5.0  # 500 standard deviations
    square = least_squares(line, y, {"a": 1.0, "b": 1.0})
    robust = least_squares(line, y, {"a": 1.0, "b": 1.0}, loss=loss)
    assert np.abs(square.estimates - truth).max() > 0.2
    # three outliers pull Huber's estimate by 3 * 1.345 standard deviations over 25 points, four of its errors at most
    assert np.all(np.abs(robust.estimates - truth) < 4.0 * np.array(list(robust.standard_errors.values())))
    assert np.all(robust.weights[[3, 11, 18]] < 0.01) and "3 of 25" in " ".join(robust.notes)
    assert 0.005 < robust.noise < 0.03
    assert all(low < value < high for (low, high), value in zip([robust.profile("b").interval], truth[1:], strict=True))


def test_parameters_that_act_alike_are_named_as_not_identifiable() -> None:
    def same(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return (values[0] + values[1]) * X + values[2], np.stack([X, X, np.ones_like(X)], axis=1)

    rng = np.random.default_rng(2)
    y = 3.0 * X + 1.0 + 0.05 * rng.standard_normal(X.size)
    found = least_squares(same, y, {"a": 1.0, "b": 1.0, "c": 0.5})
    assert found.success and not found.identifiable
    assert found.unidentifiable == ("+0.71 a -0.71 b",) or found.unidentifiable == ("-0.71 a +0.71 b",)
    assert np.isinf(found.standard_errors["a"]) and np.isfinite(found.standard_errors["c"])
    assert_allclose(found["a"] + found["b"], np.polyfit(X, y, 1)[0], rtol=1e-9)  # the sum is known
    assert found.profile("a").interval == (-np.inf, np.inf)
    assert found.singular_values[-1] < 1e-6


def test_what_the_data_cannot_see_stays_where_it_began_and_the_report_says_why() -> None:
    def nearly_same(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        slopes = np.stack([X, X + 1e-6 * X**2, np.ones_like(X)], axis=1)
        return slopes @ values, slopes

    y = 3.0 * X + 1.0 + 0.05 * np.random.default_rng(2).standard_normal(X.size)
    found = least_squares(nearly_same, y, {"a": 1.0, "b": 1.0, "c": 0.5})
    assert found.success and len(found.unidentifiable) == 1
    # The sum is known, the difference was zero and is not stepped along: about half of the slope each.
    assert_allclose([found["a"], found["b"]], 0.5 * np.polyfit(X, y, 1)[0], rtol=1e-4)
    assert "standard deviations of the noise" in found.report()
    # Without noise the same direction shows, and is found to what 1e-6 of rounding leaves.
    exact = least_squares(nearly_same, nearly_same(np.array([2.0, 1.5, 1.0]))[0], {"a": 1.0, "b": 1.0, "c": 0.5})
    assert_allclose(exact.estimates, [2.0, 1.5, 1.0], rtol=1e-6)
    stuck = replace(found, status="max_iterations", unidentifiable=())
    assert not stuck.identifiable and "the search did not converge (max_iterations)" in stuck.report()


def test_a_parameter_below_the_noise_is_not_identifiable_and_above_it_is() -> None:
    rng = np.random.default_rng(4)
    y = 1.0 + 0.01 * X + 0.5 * rng.standard_normal(X.size)
    assert not least_squares(line, y, {"a": 1.0, "b": 0.01}).identifiable
    y = 1.0 + 0.01 * X + 1e-4 * rng.standard_normal(X.size)
    assert least_squares(line, y, {"a": 1.0, "b": 0.01}).identifiable


def test_held_out_rows_do_not_touch_the_fit() -> None:
    rng = np.random.default_rng(6)
    y = line(np.array([1.0, 2.0]))[0] + 0.1 * rng.standard_normal(X.size)
    mask = X > 0.7
    wrong = y + 100.0 * mask
    a, b = (least_squares(line, data, {"a": 1.0, "b": 1.0}, hold_out=mask) for data in (y, wrong))
    assert_allclose(a.estimates, b.estimates, rtol=0, atol=0)
    assert_allclose(b.rms(held_out=True), 100.0, rtol=0.01)  # noise of 0.1 in a hundred
    alone = least_squares(lambda v: tuple(part[~mask] for part in line(v)), y[~mask], {"a": 1.0, "b": 1.0})
    assert_allclose(a.estimates, alone.estimates, rtol=1e-12)


def test_what_a_given_noise_does_not_explain_is_noted() -> None:
    y = line(np.array([1.0, 2.0]))[0] + 0.3 * np.sin(12.0 * X)
    found = least_squares(line, y, {"a": 1.0, "b": 1.0}, sigma=0.01, noise="given")
    assert "times the noise that was given" in found.notes[0] and "correlated" in found.notes[1]
    assert_allclose(found.quantile, stats.norm.ppf(0.975), rtol=1e-9)


def test_an_estimate_at_its_bound_is_named() -> None:
    found = least_squares(line, 1.0 + 2.0 * X, {"a": 1.0, "b": 0.5}, bounds={"b": (0.0, 1.0)})
    assert found.at_bound == ("b",) and found["b"] == 1.0


def test_a_model_without_an_answer_is_a_result() -> None:
    found = least_squares(lambda v: (np.full(25, np.nan), np.zeros((25, 1))), X, {"a": 1.0})
    assert not found.success and found.status == "not_finite" and np.isnan(found.estimates).all()
    with pytest.raises(RuntimeError, match="ended with 'not_finite'"):
        found.profile("a")


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"measured": [1.0, np.nan]}, "measured must be finite, got nan at index 1"),
        ({"measured": [1.0, 2.0]}, "too few for 2 parameters and an estimate of the noise"),
        ({"sigma": np.ones(3)}, r"sigma has shape \(3,\)"),
        ({"sigma": 0.0}, "sigma must be positive"),
        ({"loss": "tukey"}, 'loss must be one of "square", "huber", "cauchy"'),
        ({"noise": "none"}, "noise must be one of"),
        ({"confidence": 95.0}, r"confidence must be within \(0, 1\), got 95"),
        ({"bounds": {"b": (2.0, 1.0)}}, "bounds of b must be ascending"),
        ({"bounds": {"c": (0.0, 1.0)}}, "bounds name 'c', which is no parameter"),
        ({"bounds": {"a": (3.0, 4.0)}}, "start of a must be within its bounds"),
        ({"scale": {"b": 0.0}}, "scale of b must be positive"),
        ({"start": {"a": 0.0, "b": 1.0}}, "a parameter that starts at zero needs one"),
        ({"start": {}}, "at least one parameter"),
        ({"hold_out": slice(20, 10)}, "is it the wrong way round"),
        ({"hold_out": np.ones(25, dtype=bool)}, "nothing is left to fit"),
        ({"hold_out": np.ones(3, dtype=bool)}, "hold_out must be 25 truth values"),
        ({"hold_out": [40]}, "places below 25"),
        ({"hold_out": [0.5]}, "hold_out must be"),
        ({"hold_out": slice(0, 23)}, "2 measured numbers are too few"),
    ],
)
def test_bad_input_of_a_fit_is_refused(change: dict[str, Any], match: str) -> None:
    given = {"measured": 1.0 + X, "start": {"a": 1.0, "b": 1.0}, **change}
    with pytest.raises(ValueError, match=match):
        least_squares(line, **given)


# Models of the package


def differences(explained: _Explained, at: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """Central differences, extrapolated once."""

    def quotient(k: int, h: float) -> np.ndarray:
        ends = []
        for side in (h, -h):
            moved = at.copy()
            moved[k] += side
            ends.append(explained(moved)[0])
        return (ends[0] - ends[1]) / (2.0 * h)

    columns = [(4.0 * quotient(k, 0.5 * h) - quotient(k, h)) / 3.0 for k, h in enumerate(steps)]
    return np.stack(columns, axis=1)


def require_exact_slopes(model: Any, data: Any, own: tuple[str, ...], zeros: tuple[str, ...]) -> None:
    explained = _Explained(model, data, own, zeros)
    value = model.value if isinstance(model, DrivenLimb) else values_of(model).__getitem__
    at = np.array([value(name) for name in own] + [0.0] * len(zeros))
    steps = np.array([1e-3 * abs(x) for x in at[: len(own)]] + [50.0 if "pressure" in z else 1e-3 for z in zeros])
    expected = differences(explained, at, steps)
    size = np.abs(expected).max(axis=0)
    # Postures to 1e-9 of the length over a change of 1e-3 leave 1e-6 of an effect of order one; fourth-order
    # truncation is 1e-10 of it, where fibres a thousand times stiffer than silicone move a face a few parts in 1e6.
    assert np.all(np.abs(explained(at)[1] - expected).max(axis=0) <= 1e-5 * size)


def test_slopes_of_tubes_are_those_of_differences() -> None:
    pressures = np.linspace(2, 50, 5) * kPa
    data = (ActuatorCurve(pressures, elongation=pressures * 0 + 1e-3, twist=pressures * 0 + 0.1),)
    own = ("length", "layers[0].c1", "layers[0].c2", "layers[1].fibre_angle[0]", "layers[1].fibre_stiffness[1]")
    require_exact_slopes(unequal(), data, own, ("pressure_zero", "elongation_zero", "twist_zero"))


def test_slopes_of_limbs_of_tubes_are_those_of_differences() -> None:
    limb = DrivenLimb.of(sl.presets.reference_limb(["proximal", "distal"]), factors=True)
    pressures = np.array([[30, 10, 0, 20, 0, 5]]) * kPa
    data = (
        Points(pressures, measured=np.zeros((1, 2, 3)), plates=(0, -1), offsets=[[0.01, 0, 0.02], [0, 0.02, 0.01]],
               scene=HANGING),
        Points(pressures, measured=np.zeros((1, 2, 3)), at=[0.3, 1.0], scene=HANGING),
        LimbCurve(pressures, measured=[0.1], kind="bending", scene=HANGING),
        LimbCurve(pressures, measured=[0.1], kind="height", scene=HANGING),
        TipPoses(pressures, measured=np.eye(4)[None], scene=HANGING),
    )
    own = ("segments[0].bending_factor", "axial_factor", "segments[1].actuators[2].torsion_factor", "shear_factor",
           "layers[0].c1", "segments[1].ring_radius", "plate_mass", "segments[0].length", "plate_thickness")
    require_exact_slopes(limb, data, own, ("pressure_zero", "offset.x"))


def test_slopes_of_limbs_of_empirical_actuators_are_those_of_differences() -> None:
    pressures = np.array([[30, 10, 0, 20, 0, 5, 20, 4]]) * kPa
    data = (Points(pressures, measured=np.zeros((1, 2, 3)), plates=(0, 1), scene=HANGING),)
    own = ("length[0]", "length[1]", "length_denominator[1]", "axial[1]", "segments[1].bending[0]", "shear_ratio",
           "torsion_ratio", "mass")
    require_exact_slopes(pillows(), data, own, ("pressure_zero",))


def test_a_driven_limb_of_tubes_has_the_postures_of_the_limb() -> None:
    limb = sl.presets.reference_limb(["proximal", "distal"])
    pressures = np.array([30, 10, 0, 20, 0, 5]) * kPa
    driven = DrivenLimb.of(limb)
    assert driven.length == pytest.approx(limb.length, rel=1e-15)
    # both solved to a billionth
    found, expected = (x.solve(pressures, tolerance=1e-9, **HANGING).tip for x in (driven, limb))
    assert_allclose(found, expected, rtol=0, atol=1e-8)


def test_a_law_and_a_pressure_zero_come_back_from_an_elongation_curve() -> None:
    pressures = np.linspace(2, 55, 30) * kPa
    rng = np.random.default_rng(23)
    truth = proximal()
    elongation = 0.2 * (truth.inflate(pressures - 1.5 * kPa).stretch - 1) + 0.1 * mm * rng.standard_normal(30)
    start = changed_actuator(truth, {"layers[0].c1": 60e3})
    curve = ActuatorCurve(pressures, elongation=elongation)
    found = identify(start, curve, ["layers[0].c1", "pressure_zero"], hold_out=slice(20, 25))
    errors = found.standard_errors
    assert found.success and found.identifiable
    for name, value in {"layers[0].c1": 86.1e3, "pressure_zero": 1.5 * kPa}.items():
        assert abs(found[name] - value) < 4.0 * errors[name]
    assert values_of(found.model)["layers[0].c1"] == found["layers[0].c1"]
    assert found.rms(held_out=True) < 0.3 * mm  # noise of 0.1
    again = pickle.loads(pickle.dumps(found))
    assert again.values == found.values
    assert again.profile("pressure_zero").interval == found.profile("pressure_zero").interval


def noisy_elongation() -> ActuatorCurve:
    pressures = np.linspace(2, 55, 20) * kPa
    noise = 0.1 * mm * np.random.default_rng(29).standard_normal(20)
    return ActuatorCurve(pressures, elongation=0.2 * (proximal().inflate(pressures).stretch - 1) + noise)


def test_only_the_product_of_fraction_and_modulus_of_fibres_shows() -> None:
    names = ["layers[0].c1", "layers[1].fibre_modulus", "layers[1].fibre_fraction"]
    found = identify(proximal(), noisy_elongation(), names)
    assert not found.identifiable
    assert "fibre_" in found.unidentifiable[0] and "c1" not in found.unidentifiable[0]
    assert "not identifiable from these data" in found.report()


def test_the_profile_of_stiff_hoop_fibres_is_open_where_stiffer_ones_change_nothing() -> None:
    name = "layers[1].fibre_modulus"
    found = identify(proximal(), noisy_elongation(), ["layers[0].c1", name])
    assert found.success
    profile = found.profile(name)
    # Beyond some stiffness a fibre is as good as inextensible; the line through the estimate knows nothing of it.
    assert np.isinf(profile.interval[1]) and profile.interval[0] < 31.067e9
    assert np.isfinite(found.intervals[name][1])
    assert name in found.curved and f"within the interval of {', '.join(found.curved)}" in found.report()


def test_stiffness_factors_and_lengths_come_back_from_a_hanging_limb() -> None:
    limb = DrivenLimb.of(sl.presets.reference_limb(["proximal", "distal"]), factors=True)
    rng = np.random.default_rng(31)
    truth = limb.changed({"segments[0].bending_factor": 1.2, "segments[1].bending_factor": 0.9, "axial_factor": 1.1})
    pressures = rng.uniform(0, 50, (8, 6)) * kPa
    tips = np.array([truth.solve(row, **HANGING).plates[:, :3, 3] for row in pressures])
    data = Points(pressures, measured=tips + 0.5 * mm * rng.standard_normal(tips.shape), plates=(0, 1), scene=HANGING)
    names = {"segments[0].bending_factor": 1.2, "segments[1].bending_factor": 0.9, "axial_factor": 1.1}
    found = identify(limb, data, list(names))
    assert found.success and not found.curved
    assert 0.3 * mm < found.noise < 0.7 * mm  # 45 degrees of freedom: 0.5 -+ 4 * 10 %
    for name, value in names.items():
        assert abs(found[name] - value) < 4.0 * found.standard_errors[name]


def test_an_empirical_actuator_comes_back_from_poses_of_the_tip() -> None:
    truth = pillows()
    rng = np.random.default_rng(37)
    pressures = rng.uniform(0, 80, (10, 8)) * kPa
    poses = np.array([truth.solve(row, tolerance=1e-9, **HANGING).tip for row in pressures])
    names = {"length[1]": 0.05, "axial[0]": 200.0, "bending[0]": 0.02}
    start = truth.changed({"length[1]": 0.04, "axial[0]": 150.0, "bending[0]": 0.03})
    found = identify(start, TipPoses(pressures, measured=poses, scene=HANGING), list(names))
    assert found.success
    for name, value in names.items():
        assert found[name] == pytest.approx(value, rel=1e-4)  # no noise: postures to 1e-9, a weakest direction of 1e-4


# Actuators


def test_an_empirical_actuator_is_a_rod_at_a_pressure() -> None:
    actuator = empirical()
    rod = actuator.rod(100 * kPa)  # one unit: the coefficients add up
    assert (rod.length, rod.section.axial, rod.section.bending) == pytest.approx((0.14, 300.0, 0.03), rel=1e-14)
    assert rod.section.mass_per_length * rod.length == pytest.approx(0.02, rel=1e-14)
    assert pickle.loads(pickle.dumps(actuator)) == actuator and "length=(0.1, 0.05, -0.01)" in repr(actuator)
    assert saturating().rod(100 * kPa).length == pytest.approx(0.14 / 1.4, rel=1e-14)
    assert pickle.loads(pickle.dumps(pillows())) == pillows()
    assert rod_slopes(ScaledTube(proximal(), bending_factor=2.0), 3e4, ()).rod.section.bending == pytest.approx(
        2.0 * proximal().section(3e4).bending, rel=1e-14
    )


@pytest.mark.parametrize(
    ("make", "match"),
    [
        (lambda: EmpiricalActuator(length=(), axial=(1.0,), bending=(1.0,)), "length must be a list of coefficients"),
        (lambda: EmpiricalActuator(length=(-1.0,), axial=(1.0,), bending=(1.0,)), "length must be positive at zero"),
        (lambda: EmpiricalActuator(length=(np.nan,), axial=(1.0,), bending=(1.0,)), "length must be finite"),
        (lambda: EmpiricalActuator((0.1, -0.1), (1.0,), (1.0,)).rod(2e5), r"length of the actuator is -0\.1 at 2"),
        (lambda: EmpiricalActuator((0.1,), (1.0,), (1.0,), max_pressure=1e5).rod(2e5), "at most max_pressure"),
        (lambda: ScaledTube(proximal(), axial_factor=0.0), "axial_factor must be finite and positive"),
        (lambda: DrivenSegment([]), "at least one"),
        (lambda: DrivenSegment([empirical()]), "either ring_radius or places"),
        (lambda: DrivenLimb([]), "at least one"),
        (lambda: pillows().solve([0.0] * 3), r"pressures has shape \(3,\)"),
        (lambda: pillows().value("lenght[0]"), "no part of the limb has a number 'lenght"),
        (lambda: pillows().value("segments[4].mass"), "has 2 segments"),
        (lambda: pillows().value("actuators[1].plate_mass"), "belongs to a segment"),
        (lambda: pillows().value("ring_radius"), "no segment is placed by a ring radius"),
        (lambda: DrivenLimb.of(sl.presets.reference_limb()).value("length_of"), "no part of the limb"),
        (lambda: DrivenLimb.of(sl.presets.reference_limb()).value("ring_radius"), "numbers that differ"),
        (lambda: ActuatorCurve([1.0, np.nan], twist=[0.0, 0.0]), "pressures must be finite"),
        (lambda: ActuatorCurve([1.0, 2.0], twist=[0.0]), r"twist has shape \(1,\)"),
        (lambda: ActuatorCurve([1.0, 2.0]), "needs elongation, twist, or both"),
        (lambda: Points([[0.0]], measured=np.zeros((1, 1, 3))), "exactly one of plates and at"),
        (lambda: Points([[0.0]], measured=np.zeros((1, 1, 2)), plates=[0]), "measured has shape"),
        (lambda: Points([0.0], measured=np.zeros((1, 1, 3)), plates=[0]), "one row a posture"),
        *(
            (lambda plate=plate: Points([[0.0]], measured=np.zeros((1, 1, 3)), plates=[plate]), "plates must be a")
            for plate in (0.5, True, "0", -2)
        ),
        (lambda: TipPoses([[0.0]], measured=np.ones((1, 4, 4))), "must be a rotation matrix"),
        (lambda: LimbCurve([[0.0]], measured=[0.0], kind="length"), 'kind must be one of "height", "bending"'),
        (lambda: identify(proximal(), ActuatorCurve([1e4] * 9, twist=[0.0] * 9), ["c1"]), "no number 'c1' to identify"),
        (lambda: identify(proximal(), [], ["length"]), "at least one measurement"),
        (
            lambda: identify(proximal(), LimbCurve([[0.0]], measured=[0.0], kind="height"), ["length"]),
            "does not belong",
        ),
        (
            lambda: identify(pillows(), LimbCurve([[0.0]], measured=[0.0], kind="height"), ["mass"]),
            "1 columns but the limb has 8 actuators",
        ),
    ],
)
def test_bad_input_is_refused(make: Any, match: str) -> None:
    with pytest.raises(ValueError, match=match):
        make()


def test_what_is_of_another_type_is_refused_by_name() -> None:
    curve = ActuatorCurve([1e4] * 9, twist=[0.0] * 9)
    with pytest.raises(TypeError, match="bounds must be a mapping"):
        identify(proximal(), curve, ["length"], bounds=[(0.0, 1.0)])  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="data must be a measurement or a sequence of them, got NoneType"):
        identify(proximal(), None, ["length"])  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="limb must be a Limb, got str"):
        DrivenLimb.of("a")  # type: ignore[arg-type]


# Carried to the tip


def tensile_fit(c1: float, c2: float, seed: int) -> Any:
    stretch = np.linspace(1.02, 1.5, 25)
    rng = np.random.default_rng(seed)
    stress = sl.Yeoh(c1=c1, c2=c2).uniaxial_stress(stretch) + 3e3 * rng.standard_normal(25)
    return sl.fit_uniaxial(stretch, stress, "yeoh")


def test_the_laws_errors_at_the_tip_are_those_of_many_drawn_laws() -> None:
    fit = tensile_fit(86.1e3, 13.6e3, 41)

    def limb(coefficients: np.ndarray) -> sl.Limb:
        law = sl.Yeoh(c1=coefficients[0], c2=coefficients[1])
        fibres = sl.Fibres.pair(angle=0.03, modulus=31e9, fraction=0.0083)
        tube = sl.Tube(0.2, [sl.Layer(0.018, 0.0205, law), sl.Layer(0.0205, 0.0215, law, fibres=fibres)])
        return sl.Limb([sl.Segment([tube] * 3, ring_radius=0.028)])

    values = np.array(list(fit.coefficients.values()))
    pressures, hanging = [30 * kPa, 10 * kPa, 0.0], {"gravity": (0, 0, 9.81)}
    posture = limb(values).solve(pressures, **hanging)
    found = tip_uncertainty(posture, {"layers[0]": fit, "layers[1]": fit})
    assert list(found.by_fit) == ["layers[0]"]
    rng = np.random.default_rng(43)
    # A tenth of the errors keeps the map linear to a thousandth.
    draws = rng.multivariate_normal(values, 0.01 * fit.covariance, size=300)
    tips = np.array([limb(draw).solve(pressures, **hanging).tip[:3, 3] for draw in draws])
    # 300 draws know a standard deviation to 4 %: four of these
    spread = 10.0 * tips.std(axis=0)
    moved = spread > 1e-3 * spread.max()
    assert_allclose(found.standard_deviations[:3][moved], spread[moved], rtol=0.17)
    assert found.position_percent == pytest.approx(100 * found.position / posture.limb.length)
    other = tensile_fit(86.1e3, 13.6e3, 47)
    apart = tip_uncertainty(posture, {"layers[0]": fit, "layers[1]": other})
    assert_allclose(apart.covariance, sum(apart.by_fit.values()), rtol=1e-14)
    with pytest.raises(ValueError, match=r"fits names 'layers\[7\]'"):
        tip_uncertainty(posture, {"layers[7]": fit})
    for names in (("layers[0]", "segments[0].layers[0]"), ("segments[0].layers[0]", "layers[0]")):
        with pytest.raises(ValueError, match=r"'layers\[0\]' holds 'segments\[0\]\.layers\[0\]' already"):
            tip_uncertainty(posture, dict.fromkeys(names, fit))
    with pytest.raises(TypeError, match="posture must be a Posture, got int"):
        tip_uncertainty(3, {"layers[0]": fit})
    with pytest.raises(TypeError, match="fits must be a mapping"):
        tip_uncertainty(posture, [fit])
