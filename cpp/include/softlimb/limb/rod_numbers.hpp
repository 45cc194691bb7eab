#pragma once
// The numbers that a rod is made of between its ends, in a row: what a posture's derivatives go through.
#include <Eigen/Core>

#include "softlimb/limb/derivatives.hpp"

namespace softlimb::limb {

/// Behind the coefficients of the axial law; `range` is the relative growth of the law's range. The last is the first
/// of three, the load per rest length, weight included.
struct RodNumber {
    enum { range, shear, bending, torsion, coupling, rest_twist, length, force };
    static constexpr int count = 10;
};

inline int number_count(const Section& section) { return section.axial_law.degree + 1 + RodNumber::count; }

/// How these change at a rate, where the load per rest length changes by `line_force` altogether.
inline Eigen::VectorXd rod_numbers(const Section& section, const RodRate& rate, const Vector3& line_force) {
    const int law = section.axial_law.degree + 1;
    Eigen::VectorXd x(number_count(section));
    for (int k = 0; k < law; ++k) x(k) = rate.section.axial_law.coefficient[k];
    x(law + RodNumber::range) = range_growth(section.axial_law, rate.section.axial_law);
    x(law + RodNumber::shear) = rate.section.shear, x(law + RodNumber::bending) = rate.section.bending;
    x(law + RodNumber::torsion) = rate.section.torsion, x(law + RodNumber::coupling) = rate.section.extension_twist;
    x(law + RodNumber::rest_twist) = rate.section.rest_twist, x(law + RodNumber::length) = rate.rest_length;
    x.tail<3>() = line_force;
    return x;
}

}  // namespace softlimb::limb
