#include "softlimb/sweep/members.hpp"

#include <cstdio>
#include <stdexcept>

namespace softlimb::sweep {

using solve::SolveStatus;

Members::Members(std::vector<Member> members) : members_(std::move(members)) {
    for (int rod = 0; rod < rods(); ++rod) {
        const Member& member = members_[rod];
        radii_.push_back(member.radius);
        if (!member.tube) continue;
        int twin = actuators() - 1;
        while (twin >= 0 && actuators_[twin].tube != member.tube.get() && !(*actuators_[twin].tube == *member.tube))
            --twin;
        actuators_.push_back({rod, twin, member.tube.get()});
        driven_.push_back(rod);
    }
}

Members::Refusal Members::at_pressures(const double* pressures, actuator::SectionModel model, actuator::Valve valve,
                                       std::vector<limb::RodAtPressure>& rods) const {
    if (rods.size() != members_.size()) throw std::invalid_argument("there must be room for every rod of the limb");
    for (std::size_t i = 0; i < members_.size(); ++i)
        if (!members_[i].tube) rods[i].section = members_[i].section, rods[i].rest_length = members_[i].length;
    Refusal refusal;
    for (int i = 0; i < actuators(); ++i) {
        const Actuator& actuator = actuators_[i];
        limb::RodAtPressure& rod = rods[actuator.rod];
        // A few steps back: in a segment of many equal tubes a longer search costs more than it saves. Behind a refusal
        // none: what a twin got may be a refused actuator's.
        constexpr int farthest = 8;
        int twin = refusal ? -1 : actuator.twin;
        for (int step = 1; twin >= 0 && pressures[twin] != pressures[i]; ++step)
            twin = step < farthest ? actuators_[twin].twin : -1;
        if (twin >= 0) {
            rod.section = rods[actuators_[twin].rod].section;
            rod.rest_length = rods[actuators_[twin].rod].rest_length;
            continue;
        }
        const SolveStatus status = actuator.tube->section(pressures[i], model, valve, rod.section, rod.rest_length);
        if (status == SolveStatus::converged) continue;
        refusal = {i, pressures[i], status};
        actuator.tube->section(0.0, model, valve, rod.section, rod.rest_length);
    }
    return refusal;
}

std::vector<limb::RodSlope> Members::slopes_at(const double* pressures, actuator::SectionModel model,
                                               actuator::Valve valve) const {
    std::vector<limb::RodSlope> slopes(members_.size());
    for (int i = 0; i < actuators(); ++i) {
        const Actuator& actuator = actuators_[i];
        if (actuator.twin >= 0 && pressures[actuator.twin] == pressures[i]) {
            slopes[actuator.rod] = slopes[actuators_[actuator.twin].rod];
            continue;
        }
        const actuator::SectionSlope slope = actuator.tube->section_slope(pressures[i], model, valve);
        slopes[actuator.rod] = {slope.section, slope.rest_length};
    }
    return slopes;
}

std::string Members::reason(const Refusal& refusal) const {
    if (!refusal) return "";
    const actuator::Tube& tube = *actuators_[refusal.actuator].tube;
    char text[96];
    std::snprintf(text, sizeof text, "actuator %d has no stable state at %.6g kPa: ", refusal.actuator,
                  refusal.pressure / 1e3);
    return text + tube.message(tube.inflate(refusal.pressure));
}

}  // namespace softlimb::sweep
