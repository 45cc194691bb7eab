#include <functional>

#include "check.hpp"
#include "examples.hpp"
#include "softlimb/dual.hpp"
#include "softlimb/section.hpp"

using namespace softlimb;
using namespace softlimb::tests;

namespace {

using D = Dual<2>;

D mixture(const D& x, const D& y) {
    D z = sqrt(x * x + y) + exp(-x) * log(y) - sin(x) / cos(y) + pow(y, 1.7) * (2.0 - x) + (+x) / 3.0;
    z += x, z -= y * y, z *= y, z /= 1.0 + x;
    return z;
}
double mixture(double x, double y) { return mixture(D(x), D(y)).value; }

}  // namespace

CLAIM(a_dual_number_carries_the_slopes_of_every_operation) {
    constexpr double x = 0.7, y = 0.4, h = 1e-5;
    const D z = mixture(D::variable(x, 0), D::variable(y, 1));
    // Central differences of functions of order one: truncation 1e-10, some third derivatives are ten times larger.
    CHECK_NEAR(z.slope[0], (mixture(x + h, y) - mixture(x - h, y)) / (2.0 * h), 1e-8);
    CHECK_NEAR(z.slope[1], (mixture(x, y + h) - mixture(x, y - h)) / (2.0 * h), 1e-8);
}

CLAIM(a_constant_has_no_slope_and_comparisons_look_at_the_value_alone) {
    const D x = D::variable(2.0, 0), two(2.0);
    CHECK((x * 0.0 + two).slope[0] == 0.0);
    CHECK(x <= two && x >= two && !(x < two) && !(x > two));
    CHECK(value_of(x) == 2.0 && value_of(2.0) == 2.0);
}

CLAIM(an_axial_law_has_the_slope_that_it_says_and_no_jump_at_the_end_of_its_range) {
    const AxialLaw law = odd_section().axial_law;
    const auto at = [&](double force) {
        double strain, compliance;
        axial_strain(law, force, strain, compliance);
        return std::pair{strain, compliance};
    };
    const double upper = law.centre + law.half_range, lower = law.centre - law.half_range;
    for (const double force : {0.0, 1.0, -20.0, 25.0, 40.0, -60.0, 1e3}) {
        constexpr double h = 1e-3;  // strain is a cubic in force/30: truncation 1e-9 of its slope
        const double slope = (at(force + h).first - at(force - h).first) / (2.0 * h);
        CHECK_NEAR(at(force).second, slope, 1e-8 * (std::abs(slope) + 1e-3));
        D strain, compliance;
        axial_strain(law, D::variable(force, 0), strain, compliance);
        CHECK_NEAR(strain.slope[0], at(force).second, 1e-15 * (1.0 + std::abs(at(force).second)));
    }
    for (const double end : {upper, lower}) {
        CHECK_NEAR(at(end * (1.0 - 1e-12)).first, at(end * (1.0 + 1e-12)).first, 1e-12);
        CHECK_NEAR(at(end * (1.0 - 1e-12)).second, at(end * (1.0 + 1e-12)).second, 1e-14);
    }
    CHECK(at(0.0).first == 0.0);
}

CLAIM(a_section_that_does_not_resist_every_load_is_refused) {
    const double nan = std::numeric_limits<double>::quiet_NaN(), infinite = std::numeric_limits<double>::infinity();
    for (const double bad : {0.0, -1.0, nan, infinite}) {
        CHECK_RAISES(std::invalid_argument, Section::make(bad, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0));
        CHECK_RAISES(std::invalid_argument, Section::make(1.0, bad, 1.0, 1.0, 0.0, 0.0, 0.0));
        CHECK_RAISES(std::invalid_argument, Section::make(1.0, 1.0, bad, 1.0, 0.0, 0.0, 0.0));
        CHECK_RAISES(std::invalid_argument, Section::make(1.0, 1.0, 1.0, bad, 0.0, 0.0, 0.0));
    }
    CHECK_RAISES(std::invalid_argument, Section::make(1.0, 1.0, 1.0, 1.0, -1.0, 0.0, 0.0));
    CHECK_RAISES(std::invalid_argument, Section::make(1.0, 1.0, 1.0, 1.0, 0.0, nan, 0.0));
    CHECK_RAISES(std::invalid_argument, Section::make(4.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.5));  // c12^2 EA GJ = 1
}
