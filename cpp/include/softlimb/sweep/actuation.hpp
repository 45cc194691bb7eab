#pragma once
// Members as a search over pressures sees them: rods at pressures, and how they change.
#include "softlimb/limb/driven.hpp"
#include "softlimb/sweep/members.hpp"

namespace softlimb::sweep {

/// Keeps a reference to the members. The rates of sections that are kept in tables are difference quotients, good to
/// some 1e-7: an eighth of the time of exact ones, for searches that they only steer.
limb::Actuation actuation_of(const Members& members, actuator::SectionModel model, actuator::Valve valve);

}  // namespace softlimb::sweep
