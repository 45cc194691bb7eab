#include "softlimb/actuator/layer.hpp"

#include <cmath>
#include <numbers>
#include <utility>

#include "softlimb/arguments.hpp"

namespace softlimb::actuator {
namespace {

void require_angle(double angle) {
    require_finite("fibre angle", angle);
    constexpr double right_angle = 0.5 * std::numbers::pi;
    // 90 degrees times pi/180 may round to one ulp more than pi/2.
    if (std::abs(angle) > right_angle * (1.0 + 1e-12)) {
        std::ostringstream text;
        text.precision(10);
        text << "fibre angle must be within [-pi/2, pi/2], got " << angle
             << " (was it given in degrees? multiply by units.deg)";
        throw std::invalid_argument(text.str());
    }
}

}  // namespace

Fibres Fibres::with_stiffness(double angle, double stiffness) {
    require_angle(angle);
    require_not_negative("fibre stiffness", stiffness);
    return {angle, stiffness, 0.0, 0.0};
}

Fibres Fibres::with_fraction(double angle, double modulus, double fraction) {
    require_angle(angle);
    require_positive("fibre modulus", modulus);
    if (!(fraction >= 0.0 && fraction <= 1.0)) reject("fibre fraction", fraction, "within [0, 1]");
    return {angle, modulus * fraction, modulus, fraction};
}

Layer Layer::make(double inner, double outer, const materials::AnyLaw& law, std::vector<Fibres> fibres) {
    require_positive("inner radius of a layer", inner);
    require_positive("outer radius of a layer", outer);
    if (!(outer > inner)) reject("outer radius of a layer", outer, "larger than its inner radius");
    Layer layer{inner, outer, law, std::move(fibres)};
    const double silicone = layer.silicone_fraction();
    // Without silicone nothing resists shear between the fibres.
    if (!(silicone > 0.0)) reject("sum of the fibre fractions of a layer", 1.0 - silicone, "below 1");
    require_positive("initial shear modulus of the law", layer.shear_modulus());
    return layer;
}

double Layer::silicone_fraction() const {
    double fraction = 1.0;
    for (const Fibres& family : fibres) fraction -= family.fraction;
    return fraction;
}

double Layer::shear_modulus() const {
    return std::visit([](const auto& l) { return l.shear_modulus(); }, law);
}

double Layer::area() const { return std::numbers::pi * (outer * outer - inner * inner); }

double Layer::second_moment() const { return 0.25 * std::numbers::pi * (std::pow(outer, 4) - std::pow(inner, 4)); }

double Layer::density() const {
    return std::visit([](const auto& l) { return l.density; }, law);
}

}  // namespace softlimb::actuator
