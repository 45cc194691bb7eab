#pragma once
// What a limb is made of between its plates, and how that becomes rods at given pressures.
#include <memory>
#include <string>
#include <vector>

#include "softlimb/actuator/tube.hpp"
#include "softlimb/limb/equilibrium.hpp"
#include "softlimb/limb/scene.hpp"
#include "softlimb/solve/status.hpp"

namespace softlimb::sweep {

/// One rod of a limb: an actuator, whose section follows its pressure, or a rod with a section of its own.
struct Member {
    std::shared_ptr<const actuator::Tube> tube;  // null for a rod
    Section section{};                           // of a rod
    double length = 0.0;                         // of a rod [m]
    double radius = 0.0;                         // outer radius, unpressurised; 0 where it is not known [m]
};

/// The rods of a limb in flat order, segment by segment. Constant after construction and shared between threads.
class Members {
public:
    explicit Members(std::vector<Member> members);

    int rods() const { return static_cast<int>(members_.size()); }
    int actuators() const { return static_cast<int>(actuators_.size()); }
    const std::vector<Member>& all() const { return members_; }
    /// Outer radii for clearance; 0 where not known [m].
    const std::vector<double>& radii() const { return radii_; }

    /// The last actuator without a stable state at its pressure, if there is one.
    struct Refusal {
        int actuator = -1;
        double pressure = 0.0;
        solve::SolveStatus status = solve::SolveStatus::converged;
        explicit operator bool() const { return actuator >= 0; }
    };
    /// Puts sections and rest lengths of all rods at the pressures of the actuators [Pa] into `rods`, which has the
    /// right size; line loads stay. An actuator without a state counts as unpressurised. Equal tubes at one pressure
    /// are solved once. Allocates nothing.
    Refusal at_pressures(const double* pressures, actuator::SectionModel model, actuator::Valve valve,
                         std::vector<limb::RodAtPressure>& rods) const;
    /// How sections and rest lengths change with their actuator's pressure, [.]/Pa; zero for rods. Equal tubes at one
    /// pressure are differentiated once.
    std::vector<limb::RodSlope> slopes_at(const double* pressures, actuator::SectionModel model,
                                          actuator::Valve valve) const;
    /// Rods that actuators are, in the actuators' order.
    const std::vector<int>& driven() const { return driven_; }
    /// What a refusal means, in words.
    std::string reason(const Refusal& refusal) const;

private:
    struct Actuator {
        int rod;
        int twin;  // the nearest actuator before it with an equal tube, or -1
        const actuator::Tube* tube;
    };
    std::vector<Member> members_;
    std::vector<Actuator> actuators_;
    std::vector<int> driven_;
    std::vector<double> radii_;
};

}  // namespace softlimb::sweep
