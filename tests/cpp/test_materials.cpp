#include "check.hpp"
#include "examples.hpp"
#include "softlimb/materials/laws.hpp"
#include "softlimb/materials/response.hpp"

using namespace softlimb;
using namespace softlimb::tests;
using namespace softlimb::materials;

namespace {

/// An example of every law in the list; a law without one does not compile.
template <class L>
L example();
template <>
NeoHookean example() {
    return {.c1 = 340e3};
}
template <>
Yeoh example() {
    return {.c1 = 86.1e3, .c2 = 13.6e3, .c3 = -200.0};
}
template <>
MooneyRivlin example() {
    return {.c10 = 60e3, .c01 = 20e3};
}
template <>
Ogden example() {
    return {.mu = Terms::from("mu", std::vector{6.3e5, 1.2e3, -1e4}),
            .alpha = Terms::from("alpha", std::vector{1.3, 5.0, -2.0})};
}
template <>
Gent example() {
    return {.mu = 160e3, .jm = 30.0};
}

struct State {
    double a, t;
};
// Undeformed (where Ogden's stretches coincide), the three tests at moderate and large stretch, compression, and both
// sides of the change of formula of the Chebyshev function (c = 1.25).
std::vector<State> states() {
    std::vector<State> all = {{1.0, 2.0}, {1.0, 2.49}, {1.0, 2.51}};
    for (const double l : {0.6, 1.01, 1.5, 2.5})
        for (const Test test : {Test::uniaxial, Test::planar, Test::equibiaxial}) {
            const Path s = path_of(test, l);
            all.push_back({s.a, s.t});
        }
    return all;
}

}  // namespace

CLAIM(every_law_has_the_derivatives_of_its_energy) {
    Laws::for_each([]<class L>() {
        const L law = example<L>();
        check(law);
        const double scale = law.shear_modulus();
        for (const auto& [a, t] : states()) {
            const double h = 1e-5 * a;  // relative to the known stretch: W has poles at a = 0
            const auto e = law.derivatives(a, t);
            const auto a_up = law.derivatives(a + h, t), a_down = law.derivatives(a - h, t);
            const auto t_up = law.derivatives(a, t + h), t_down = law.derivatives(a, t - h);
            const auto slope = [&](double up, double down) { return (up - down) / (2.0 * h); };
            // Truncation 1e-10 times third derivatives, which grow as 1/a^3, and rounding 1e-16/h.
            const double tolerance = 1e-6 * scale * (1.0 + std::pow(a, -4.0));
            CHECK_NEAR(e.w_a, slope(a_up.w, a_down.w), tolerance);
            CHECK_NEAR(e.w_t, slope(t_up.w, t_down.w), tolerance);
            CHECK_NEAR(e.w_aa, slope(a_up.w_a, a_down.w_a), tolerance);
            CHECK_NEAR(e.w_at, slope(t_up.w_a, t_down.w_a), tolerance);
            CHECK_NEAR(e.w_at, slope(a_up.w_t, a_down.w_t), tolerance);
            CHECK_NEAR(e.w_tt, slope(t_up.w_t, t_down.w_t), tolerance);
            const auto d = law.derivatives(Dual<2>::variable(a, 0), Dual<2>::variable(t, 1));
            CHECK_NEAR(d.w_aa.slope[0], slope(a_up.w_aa, a_down.w_aa), 10.0 * tolerance * (1.0 + 1.0 / a));
            CHECK_NEAR(d.w_tt.slope[1], slope(t_up.w_tt, t_down.w_tt), 10.0 * tolerance);
        }
    });
}

CLAIM(every_law_is_at_rest_with_three_four_and_six_times_its_shear_modulus) {
    Laws::for_each([]<class L>() {
        const L law = example<L>();
        const double mu = law.shear_modulus();
        for (const auto& [test, factor] :
             {std::pair{Test::uniaxial, 3.0}, std::pair{Test::planar, 4.0}, std::pair{Test::equibiaxial, 6.0}}) {
            const Response r = response(law, test, 1.0);
            CHECK_NEAR(r.stress, 0.0, 1e-13 * mu);
            CHECK_NEAR(r.tangent, factor * mu, 1e-12 * mu);
        }
        CHECK_NEAR(drucker_margin(law, Test::uniaxial, 1.0), 1.0, 1e-12);
    });
}

CLAIM(gents_law_is_nan_at_and_beyond_its_limit_and_finite_just_below) {
    const Gent law = example<Gent>();
    const double t = law.jm + 2.0;  // a = 1: I1 - 3 = jm
    CHECK(std::isfinite(law.derivatives(1.0, t * (1.0 - 1e-12)).w_tt));
    for (const double past : {t, t * 1.5, 1e300}) {
        const auto e = law.derivatives(1.0, past);
        CHECK(std::isnan(e.w) && std::isnan(e.w_a) && std::isnan(e.w_tt));
        const auto d = law.derivatives(Dual<1>::variable(1.0, 0), Dual<1>(past));
        CHECK(std::isnan(d.w.slope[0]));
    }
}

CLAIM(coefficients_that_are_no_material_are_refused) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    CHECK_RAISES(std::invalid_argument, check(NeoHookean{.c1 = -1.0}));
    CHECK_RAISES(std::invalid_argument, check(Yeoh{.c1 = nan}));
    CHECK_RAISES(std::invalid_argument, check(MooneyRivlin{.c10 = 1.0, .c01 = -1.0}));
    CHECK_RAISES(std::invalid_argument, check(Gent{.mu = 1.0, .jm = 0.0}));
    CHECK_RAISES(std::invalid_argument, Terms::from("mu", std::vector<double>{}));
    CHECK_RAISES(std::invalid_argument, Terms::from("mu", std::vector<double>(5, 1.0)));
    Ogden steep = example<Ogden>();
    steep.alpha.value[1] = 51.0;
    CHECK_RAISES(std::invalid_argument, check(steep));
    Ogden uneven = example<Ogden>();
    uneven.alpha.count = 2;
    CHECK_RAISES(std::invalid_argument, check(uneven));
}

CLAIM(a_law_that_softens_loses_stability_where_the_check_says) {
    // Yeoh with a negative second coefficient: the tangent of the uniaxial test vanishes at the strain found.
    const Yeoh law{.c1 = 100e3, .c2 = -20e3};
    const DruckerCheck check = check_drucker(law, 2.0);
    CHECK(!check.stable);
    const double margin = drucker_margin(law, check.test, 1.0 + check.strain);
    CHECK_NEAR(margin, 0.0, 1e-8);  // the bisection ends at 1e-10 of strain, and the slope is of order ten
    CHECK(check_drucker(example<Yeoh>(), 0.5).stable);
}
