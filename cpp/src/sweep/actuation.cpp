#include "softlimb/sweep/actuation.hpp"

#include <algorithm>

namespace softlimb::sweep {
namespace {

/// Change from a to b over a change of the pressure.
limb::RodSlope quotient(const limb::RodAtPressure& a, const limb::RodAtPressure& b, double change) {
    limb::RodSlope slope;
    Section& s = slope.section;
    for (double Section::* field : {&Section::axial, &Section::shear, &Section::bending, &Section::torsion,
                                    &Section::mass_per_length, &Section::rest_twist, &Section::extension_twist})
        s.*field = (b.section.*field - a.section.*field) / change;
    s.axial_law.coefficient[0] = (b.section.axial_law.coefficient[0] - a.section.axial_law.coefficient[0]) / change;
    slope.rest_length = (b.rest_length - a.rest_length) / change;
    return slope;
}

}  // namespace

limb::Actuation actuation_of(const Members& members, actuator::SectionModel model, actuator::Valve valve) {
    limb::Actuation actuation;
    actuation.rods = members.driven();
    actuation.rods_at = [&members, model, valve](const double* pressures, std::vector<limb::RodAtPressure>& rods) {
        return !members.at_pressures(pressures, model, valve, rods);
    };
    actuation.slopes_at = [&members, model, valve](const double* pressures) {
        // The range of a nonlinear axial law moves with the pressure, and its coefficients are those of a range: a
        // quotient would need both.
        if (model == actuator::SectionModel::nonlinear) return members.slopes_at(pressures, model, valve);
        std::vector<double> below(pressures, pressures + members.actuators()), above = below;
        for (double& pressure : above) pressure += 1e-4 * std::max(std::abs(pressure), 1e3);
        for (double& pressure : below) {
            // A tension-only tube has a corner at rest: from there upwards only.
            const double lower = pressure - 1e-4 * std::max(std::abs(pressure), 1e3);
            pressure = pressure >= 0.0 ? std::max(lower, 0.0) : lower;
        }
        std::vector<limb::RodAtPressure> first(members.rods()), last(members.rods());
        if (members.at_pressures(below.data(), model, valve, first) ||
            members.at_pressures(above.data(), model, valve, last))
            return members.slopes_at(pressures, model, valve);
        std::vector<limb::RodSlope> slopes(members.rods());
        std::size_t actuator = 0;
        for (const int rod : members.driven()) {
            slopes[rod] = quotient(first[rod], last[rod], above[actuator] - below[actuator]);
            ++actuator;
        }
        return slopes;
    };
    return actuation;
}

}  // namespace softlimb::sweep
