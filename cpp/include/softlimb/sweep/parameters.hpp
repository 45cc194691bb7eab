#pragma once
// The numbers that users name (a pressure, a radius, a law's coefficient, a plate's mass), as rates of the scene of a
// limb. Source: cpp/MECHANICS.md, "Derivatives".
#include <vector>

#include "softlimb/actuator/tube_parameter.hpp"
#include "softlimb/limb/derivatives.hpp"
#include "softlimb/sweep/members.hpp"

namespace softlimb::sweep {

/// One number of a limb or of its loads, and the column of derivatives that it is part of: numbers of one column change
/// together, each at the rate `factor`.
struct Parameter {
    enum class Kind {
        tube,             // `tube` of the member `place`
        rod_section,      // field `component` of the member's section, where it is a rod: in the order of Section
        rod_length,       // of such a member [m]
        placement,        // of the member: base and end (dp, dtheta) as `direction`
        line_force,       // on the member, `component` 0 to 2 [N/m]
        plate_thickness,  // of the plate `place` [m]
        plate_mass,       // [kg]
        wrench,           // on the plate, `component` 0 to 5 [N, N m]
        gravity,          // `component` 0 to 2 [m/s^2]
    };
    Kind kind = Kind::tube;
    int place = 0, component = 0;
    actuator::TubeParameter tube{};
    Vector12 direction = Vector12::Zero();
    int column = 0;
    double factor = 1.0;
};

struct Parameters {
    std::vector<Parameter> list;
    int columns = 0;
};

/// Raises std::invalid_argument where a parameter names what the members or the geometry do not have.
void check(const Parameters& parameters, const Members& members, const limb::Geometry& geometry);

/// Rates of the scene, a column each, at the pressures of the actuators. Equal tubes at one pressure are differentiated
/// once.
std::vector<limb::SceneRate> rates_of(const Parameters& parameters, const Members& members, const limb::Scene& scene,
                                      const double* pressures, actuator::SectionModel model, actuator::Valve valve);

}  // namespace softlimb::sweep
