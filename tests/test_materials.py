"""Material laws: every claim of the shared part holds for each law of the list."""

from __future__ import annotations

import copy
import math
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

import softlimb as sl
from softlimb import _core
from softlimb.materials import LAWS, Law

# One law of each class, more where a class has kinds that differ; all legal and smooth over the stretches used below.
EXAMPLES: list[Law] = [
    sl.NeoHookean(c1=340e3, density=1240.0),
    sl.Yeoh(c1=86.1e3, c2=13.6e3, max_strain=0.5),
    sl.Yeoh(c1=86.1e3, c2=-1.2e3, c3=300.0),
    sl.MooneyRivlin(c10=120e3, c01=30e3),
    sl.Ogden(mu=[110e3], alpha=[3.06]),
    sl.Ogden(mu=[630e3, 1.2e3, -10e3], alpha=[1.3, 5.0, -2.0]),
    sl.Gent(mu=180e3, jm=60.0),
]
every_law = pytest.mark.parametrize("law", EXAMPLES, ids=repr)
TESTS = ["uniaxial", "planar", "equibiaxial"]


def in_test(test: str, stretch: float) -> tuple[float, float]:
    """(a, t) of a homogeneous test; the known direction is the axis, the held one, the thickness."""
    return {
        "uniaxial": (stretch**2, 2.0 / stretch),
        "planar": (1.0, stretch**2 + stretch**-2),
        "equibiaxial": (stretch**-4, 2.0 * stretch**2),
    }[test]


# --- the list -------------------------------------------------------------------------------------------------------


def test_python_lists_the_laws_of_the_core() -> None:
    assert [law.__name__ for law in LAWS] == _core.law_class_names()
    assert {type(law) for law in EXAMPLES} == set(LAWS)


@every_law
def test_a_law_survives_pickle_copy_and_its_own_repr(law: Law) -> None:
    for again in (pickle.loads(pickle.dumps(law)), copy.deepcopy(law), eval(repr(law), vars(sl))):
        assert again == law
        assert hash(again) == hash(law)
        assert type(again) is type(law)
    assert law != EXAMPLES[EXAMPLES.index(law) - 1]
    assert law != 1


@every_law
def test_parameters_rebuild_the_law(law: Law) -> None:
    assert type(law)(**law.parameters, density=law.density, max_strain=law.max_strain) == law


# --- energy, stress, tangent ----------------------------------------------------------------------------------------


def differences(function, x: float, step: float) -> float:
    """Fourth-order central difference."""
    return (8 * (function(x + step) - function(x - step)) - function(x + 2 * step) + function(x - 2 * step)) / (
        12 * step
    )


@every_law
@pytest.mark.parametrize(("a", "t"), [(1.0, 2.3), (0.6, 3.1), (1.9, 1.7), (0.35, 6.0)])
def test_derivatives_are_those_of_the_energy(law: Law, a: float, t: float) -> None:
    _, w_a, w_t, w_aa, w_at, w_tt = law.energy_derivatives(a, t)
    third = law.energy_third_derivatives(a, t)
    h = 1e-3
    # Truncation h^4/30 of a fifth derivative (the laws here: below 1e3 mu) is 3e-11, rounding eps/h = 2e-13.
    near = {"rtol": 1e-9, "atol": 1e-9 * law.shear_modulus}
    assert_allclose([w_a, w_t], [d_da(law, 0, a, t, h), d_dt(law, 0, a, t, h)], **near)
    assert_allclose([w_aa, w_at], [d_da(law, 1, a, t, h), d_dt(law, 1, a, t, h)], **near)
    assert_allclose([w_at, w_tt], [d_da(law, 2, a, t, h), d_dt(law, 2, a, t, h)], **near)
    # These come from the same source with dual numbers as scalar.
    expected = [d_da(law, 3, a, t, h), d_dt(law, 3, a, t, h), d_da(law, 5, a, t, h), d_dt(law, 5, a, t, h)]
    assert_allclose(third, expected, rtol=1e-8, atol=1e-8 * law.shear_modulus)


def d_da(law: Law, item: int, a: float, t: float, h: float) -> float:
    return differences(lambda x: law.energy_derivatives(x, t)[item], a, h)


def d_dt(law: Law, item: int, a: float, t: float, h: float) -> float:
    return differences(lambda x: law.energy_derivatives(a, x)[item], t, h)


@every_law
def test_the_undeformed_state_has_no_energy_no_stress_and_the_stated_shear_modulus(law: Law) -> None:
    mu = law.shear_modulus
    # Sums of a few terms of size mu: some units in the last place.
    assert_allclose(law.energy_derivatives(1.0, 2.0)[0], 0.0, atol=1e-14 * mu)
    for test, modulus in zip(TESTS, [3.0, 4.0, 6.0], strict=True):
        assert_allclose(getattr(law, f"{test}_stress")(1.0), 0.0, atol=1e-14 * mu)
        assert_allclose(getattr(law, f"{test}_tangent")(1.0), modulus * mu, rtol=1e-13)


@every_law
@pytest.mark.parametrize("test", TESTS)
@pytest.mark.parametrize("stretch", [0.7, 0.95, 1.2, 1.8])
def test_stress_and_tangent_are_slopes_of_energy_and_stress(law: Law, test: str, stretch: float) -> None:
    loaded = 2.0 if test == "equibiaxial" else 1.0
    stress, tangent = (getattr(law, f"{test}_{what}") for what in ("stress", "tangent"))
    slope = differences(lambda x: law.energy_derivatives(*in_test(test, x))[0], stretch, 1e-3) / loaded
    # Truncation h^4/30 times (n/l)^4: the energy goes with up to the n = 12th power of 1/l, so at most 3e-9.
    assert_allclose(stress(stretch), slope, rtol=3e-9, atol=1e-9 * law.shear_modulus)
    assert_allclose(tangent(stretch), differences(stress, stretch, 1e-3), rtol=3e-9)


@every_law
@given(l1=st.floats(0.5, 2.0), l2=st.floats(0.5, 2.0))
def test_the_energy_does_not_depend_on_which_direction_is_called_the_known_one(law: Law, l1: float, l2: float) -> None:
    squares = [l1**2, l2**2, (l1 * l2) ** -2]
    energies = [law.energy_derivatives(s, sum(squares) - s)[0] for s in squares if s > 0]
    # The trace of the other two loses eps * 16 / s by the subtraction; energies here are up to 100 mu.
    assert_allclose(energies, energies[0], rtol=1e-11, atol=1e-12 * law.shear_modulus)


# --- closed forms ---------------------------------------------------------------------------------------------------


STRETCH = np.array([0.5, 0.8, 1.0, 1.1, 1.5, 2.0, 3.0])
I1 = STRETCH**2 + 2 / STRETCH
CLOSED_FORMS = [
    (sl.NeoHookean(c1=2.0), 4.0 * (STRETCH - STRETCH**-2)),
    (sl.Yeoh(c1=2.0, c2=0.3, c3=0.1), 2 * (STRETCH - STRETCH**-2) * (2 + 0.6 * (I1 - 3) + 0.3 * (I1 - 3) ** 2)),
    (sl.MooneyRivlin(c10=2.0, c01=0.5), 2 * (1 - STRETCH**-3) * (2 * STRETCH + 0.5)),
    (
        sl.Ogden(mu=[2.0, -0.5], alpha=[1.3, -2.0]),
        2.0 * (STRETCH**0.3 - STRETCH**-1.65) - 0.5 * (STRETCH**-3.0 - STRETCH**0.0),
    ),
    (sl.Gent(mu=2.0, jm=20.0), 2.0 * 20.0 / (20.0 - I1 + 3) * (STRETCH - STRETCH**-2)),
]


@pytest.mark.parametrize(("law", "expected"), CLOSED_FORMS, ids=[law.name for law, _ in CLOSED_FORMS])
def test_uniaxial_stress_has_its_closed_form(law: Law, expected: np.ndarray) -> None:
    # Twenty or so operations on numbers of order ten.
    assert_allclose(law.uniaxial_stress(STRETCH), expected, rtol=1e-13, atol=1e-13)


def test_laws_agree_where_one_contains_the_other() -> None:
    neo = sl.NeoHookean(c1=2.0)
    same = [sl.Yeoh(c1=2.0, c2=0.0), sl.MooneyRivlin(c10=2.0, c01=0.0), sl.Ogden(mu=[4.0], alpha=[2.0])]
    for law in same:
        for test in TESTS:
            for what in ("stress", "tangent"):
                name = f"{test}_{what}"
                # Rounding; the Chebyshev sums of Ogden's law take some twenty operations.
                assert_allclose(getattr(law, name)(STRETCH), getattr(neo, name)(STRETCH), rtol=1e-13, atol=1e-13)
    # Second invariant: exponent -2 with a negative coefficient.
    rivlin, ogden = sl.MooneyRivlin(c10=0.0, c01=2.0), sl.Ogden(mu=[-4.0], alpha=[-2.0])
    assert_allclose(ogden.planar_stress(STRETCH), rivlin.planar_stress(STRETCH), rtol=1e-13, atol=1e-13)
    # Gent with a limit far away differs by (I1 - 3)/jm < 1e-8.
    assert_allclose(
        sl.Gent(mu=4.0, jm=1e9).uniaxial_stress(STRETCH), neo.uniaxial_stress(STRETCH), rtol=2e-8, atol=1e-15
    )


# --- Ogden where stretches coincide ---------------------------------------------------------------------------------


def block_of_even_exponent(q: int, a: float, t: float) -> float:
    """l1^(2q) + l2^(2q) by Newton's identity for power sums, with l1^2 + l2^2 = t and l1 l2 = a^(-1/2)."""
    previous, current = 2.0, t
    for _ in range(q - 1):
        previous, current = current, t * current - previous / a
    return current


@pytest.mark.parametrize("q", [1, 2, 3, 5, 8])
@pytest.mark.parametrize("apart", [0.0, 1e-12, 1e-8, 1e-4, 0.03, 0.5, 0.7, 1.2])
def test_ogden_with_an_even_exponent_is_a_polynomial_also_where_stretches_coincide(q: int, apart: float) -> None:
    a = 1.1
    t = 2.0 / math.sqrt(a) * math.cosh(apart)
    law = sl.Ogden(mu=[1.0], alpha=[2.0 * q])
    expected = (a**q + block_of_even_exponent(q, a, t) - 3.0) / (2 * q)
    assert_allclose(law.energy_derivatives(a, t)[0], expected, rtol=1e-13, atol=1e-14)
    # dW/dt by the same recurrence, differentiated: T_q' = q U_(q-1).
    first = [0.0, 1.0]
    sums = [2.0, t]
    for _ in range(q - 1):
        first.append(sums[-1] + t * first[-1] - first[-2] / a)
        sums.append(t * sums[-1] - sums[-2] / a)
    assert_allclose(law.energy_derivatives(a, t)[2], first[q] / (2 * q), rtol=1e-13)


@pytest.mark.parametrize("alpha", [-12.0, -2.0, -0.7, 0.3, 1.3, 3.06, 7.5, 11.0, 25.0])
def test_ogden_derivatives_are_exact_at_coincident_stretches(alpha: float) -> None:
    # With q = alpha/2: T_q(1) = 1, T_q' = q^2, T_q'' = q^2 (q^2 - 1)/3, T_q''' = q^2 (q^2 - 1)(q^2 - 4)/15.
    q = 0.5 * alpha
    law = sl.Ogden(mu=[math.copysign(1.0, alpha)], alpha=[alpha])
    _, _, w_t, _, _, w_tt = law.energy_derivatives(1.0, 2.0)
    w_ttt = law.energy_third_derivatives(1.0, 2.0)[3]
    weight = 1.0 / abs(alpha)
    # Each is one product: rounding of a dozen operations.
    assert_allclose(w_t, weight * q**2, rtol=1e-14)
    assert_allclose(w_tt, weight * q**2 * (q**2 - 1.0) / 6.0, rtol=1e-14, atol=1e-16)
    assert_allclose(w_ttt, weight * q**2 * (q**2 - 1.0) * (q**2 - 4.0) / 60.0, rtol=1e-13, atol=1e-16)


@pytest.mark.parametrize("alpha", [-7.0, 0.3, 1.3, 5.7, 20.0])
def test_ogden_is_continuous_where_series_and_closed_form_meet(alpha: float) -> None:
    law = sl.Ogden(mu=[math.copysign(1.0, alpha)], alpha=[alpha])
    below, above = (
        np.array(law.energy_derivatives(1.0, 2.5 * (1 + side)) + law.energy_third_derivatives(1.0, 2.5 * (1 + side)))
        for side in (-1e-15, 1e-15)
    )
    # The closed form divides twice by c^2 - 1 = 0.56 and, through the dual number, once more: 1e-13 where q is small.
    assert_allclose(below, above, rtol=1e-12)


# --- Gent past its limit, Drucker -----------------------------------------------------------------------------------


def test_gent_has_no_stress_at_and_past_its_limit() -> None:
    law = sl.Gent(mu=1.0, jm=3.0)
    limit = 2.0**2 + 2 / 2.0 - 3.0  # I1 - 3 = 2 at stretch 2
    assert np.isfinite(law.uniaxial_stress(2.0))
    assert np.isnan(sl.Gent(mu=1.0, jm=limit).uniaxial_stress(2.0))
    assert np.all(np.isnan(law.energy_derivatives(9.0, 1.0)))
    assert np.all(np.isnan(law.energy_third_derivatives(9.0, 1.0)))
    assert np.isnan(law.uniaxial_stress(np.array([1.0, 5.0]))[1])


def test_drucker_holds_for_convex_laws_over_any_range() -> None:
    for law in (sl.NeoHookean(c1=1.0), sl.MooneyRivlin(c10=1.0, c01=0.2), sl.Ogden(mu=[1.0, -0.1], alpha=[1.3, -2.0])):
        check = law.check_drucker(5.0)
        assert check and check.stable and check.test is None and np.isnan(check.strain)
        assert 0.0 < check.margin <= 1.0 + 1e-12


def test_drucker_finds_where_a_softening_law_is_lost_in_equibiaxial_tension() -> None:
    # Equibiaxially, W(e) along the direction of stretching has the second derivative 4 d2W/d(log l)^2 / 6; the law is
    # lost where that vanishes: f'(x) x' with x = I1 - 3 = 2 l^2 + l^-4 - 3 and W = c1 x + c2 x^2.
    c1, c2 = 1.0, -0.05
    law = sl.Yeoh(c1=c1, c2=c2)

    def second(stretch: float) -> float:
        square, fourth = stretch**2, stretch**-4
        x, x1, x2 = 2 * square + fourth - 3, 4 * square - 4 * fourth, 8 * square + 16 * fourth
        return (c1 + 2 * c2 * x) * x2 + 2 * c2 * x1**2

    low, high = 1.0, 3.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if second(middle) > 0 else (low, middle)
    check = law.check_drucker(2.0)
    assert not check
    assert check.test == "equibiaxial"
    assert_allclose(check.strain, low - 1.0, rtol=1e-9)  # bisection to 1e-10
    assert "equibiaxial" in check.message
    assert law.check_drucker(0.99 * (low - 1.0))


def test_drucker_counts_a_law_without_value_as_lost() -> None:
    check = sl.Gent(mu=1.0, jm=2.0).check_drucker(3.0)
    assert not check and np.isnan(check.margin)
    # In equibiaxial tension I1 - 3 = 2 first: 2 l^2 + l^-4 = 5.
    stretch = 1.0 + check.strain
    assert_allclose(2 * stretch**2 + stretch**-4, 5.0, rtol=1e-8)


# --- arguments ------------------------------------------------------------------------------------------------------


def test_a_number_gives_a_number_and_an_array_an_array_of_its_shape() -> None:
    law = sl.materials.DRAGON_SKIN_30
    for scalar in (1.5, 2, np.float64(1.5), np.float32(1.5), np.int64(2), np.array(1.5)):
        assert isinstance(law.uniaxial_stress(scalar), float)
    for array in ([1.5], np.array([2]), np.ones((2, 3)), np.full((4, 6), 1.2)[:, ::2], np.empty((0, 2))):
        stress = law.uniaxial_stress(array)
        assert isinstance(stress, np.ndarray) and stress.shape == np.shape(array)
    many = np.linspace(0.5, 2.0, 12).reshape(3, 4).T  # not in C order
    assert_allclose(law.uniaxial_stress(many), [[law.uniaxial_stress(x) for x in row] for row in many.tolist()], rtol=0)


BAD_ARGUMENTS = {
    "negative c1": (lambda: sl.NeoHookean(c1=-1.0), r"c1 must be .*positive, got -1"),
    "zero c1": (lambda: sl.Yeoh(c1=0.0, c2=1.0), r"c1 must be .*positive, got 0"),
    "nan c2": (lambda: sl.Yeoh(c1=1.0, c2=math.nan), r"c2 must be finite, got nan"),
    "infinite c01": (lambda: sl.MooneyRivlin(c10=1.0, c01=math.inf), r"c01 must be finite, got inf"),
    "negative modulus": (
        lambda: sl.MooneyRivlin(c10=1.0, c01=-1.5),
        r"shear modulus 2 \(c10 \+ c01\) must be .*got -1",
    ),
    "negative Ogden modulus": (
        lambda: sl.Ogden(mu=[1.0], alpha=[-2.0]),
        r"shear modulus sum\(mu alpha\)/2 must be .*got -1",
    ),
    "no terms": (lambda: sl.Ogden(mu=[], alpha=[]), r"number of terms in mu must be from 1 to 4, got 0"),
    "five terms": (lambda: sl.Ogden(mu=[1.0] * 5, alpha=[1.0] * 5), r"number of terms in mu .* got 5"),
    "unequal terms": (lambda: sl.Ogden(mu=[1.0], alpha=[1.0, 2.0]), r"terms in alpha must be that of mu, 1, got 2"),
    "zero exponent": (lambda: sl.Ogden(mu=[1.0], alpha=[0.0]), r"alpha\[0\] must be different from zero"),
    "huge exponent": (lambda: sl.Ogden(mu=[1.0], alpha=[51.0]), r"alpha\[0\] must be within \[-50, 50\], got 51"),
    "zero limit": (lambda: sl.Gent(mu=1.0, jm=0.0), r"jm must be .*positive, got 0"),
    "zero density": (lambda: sl.NeoHookean(c1=1.0, density=0.0), r"density must be .*positive, got 0"),
    "negative range": (lambda: sl.NeoHookean(c1=1.0, max_strain=-0.1), r"max_strain must be .*not negative, got -0.1"),
    "zero stretch": (lambda: sl.NeoHookean(c1=1.0).planar_stress(0.0), r"stretch must be .*positive, got 0"),
    "no c1": (lambda: sl.NeoHookean(c1=None), r"^c1 must be a number or an array of numbers, got None"),
    "a true density": (lambda: sl.NeoHookean(c1=1.0, density=True), r"^density must be a number .*got True"),
    "None terms": (lambda: sl.Ogden(mu=None, alpha=[1.0]), r"^mu must be a number or an array of numbers, got None"),
    "one term": (lambda: sl.Ogden(mu=1.0, alpha=[1.0]), r"^mu must be a list of numbers, got shape \(\)"),
    "a text as stretch": (lambda: sl.NeoHookean(c1=1.0).uniaxial_stress("x"), r"^stretch must be a number .*got 'x'"),
    "a text as range": (lambda: sl.NeoHookean(c1=1.0).check_drucker("x"), r"^max_strain must be a number .*got 'x'"),
    "nan stretch": (lambda: sl.NeoHookean(c1=1.0).uniaxial_stress([1.0, math.nan]), r"stretch \(item 1 .*got nan"),
    "impossible block": (lambda: sl.NeoHookean(c1=1.0).energy_derivatives(1.0, 1.9), r"t must be at least .*got 1.9"),
    "unknown range": (lambda: sl.NeoHookean(c1=1.0).check_drucker(), r"max_strain must be given"),
    "empty range": (lambda: sl.NeoHookean(c1=1.0).check_drucker(0.0), r"max_strain must be .*positive, got 0"),
    "unknown preset": (
        lambda: sl.materials.get("dragonskin-30"),
        r"no material named 'dragonskin-30'.*'dragon-skin-30'",
    ),
}


@pytest.mark.parametrize("case", BAD_ARGUMENTS)
def test_a_bad_argument_raises_with_its_name_value_and_rule(case: str) -> None:
    call, message = BAD_ARGUMENTS[case]
    with pytest.raises(ValueError, match=message):
        call()


def test_coefficients_are_keyword_only() -> None:
    with pytest.raises(TypeError):
        sl.NeoHookean(1.0)  # type: ignore[misc]


# --- presets --------------------------------------------------------------------------------------------------------


def test_presets_are_found_by_name_and_state_their_source() -> None:
    assert sl.materials.get("dragon-skin-30") is sl.materials.DRAGON_SKIN_30
    assert sl.materials.get("Dragon Skin 30") is sl.materials.DRAGON_SKIN_30
    assert sl.materials.names() == tuple(sorted(sl.materials.names()))
    for name in sl.materials.names():
        law = sl.materials.get(name)
        assert "Zhang" in sl.materials.source(name) or "10.1089/soro.2019.0115" in sl.materials.source(name)
        if law.max_strain > 0.0:
            assert law.check_drucker(), f"{name} is not stable in its own range"


def test_the_published_coefficients_are_kept_as_published() -> None:
    skin = sl.materials.DRAGON_SKIN_30
    assert isinstance(skin, sl.Yeoh)
    # Zhang et al. print MPa with four and five digits; the products with 1e6 round.
    assert_allclose([skin.c1, skin.c2, skin.c3, skin.max_strain], [86.1e3, 13.6e3, 0.0, 0.5], rtol=1e-15)
    assert_allclose(sl.materials.SMOOTHSIL_950.shear_modulus, 680e3, rtol=1e-15)
