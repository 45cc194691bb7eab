#pragma once
// Potential energy of a posture. Source: cpp/MECHANICS.md, "Derivatives".
#include <vector>

#include "softlimb/limb/derivatives.hpp"

namespace softlimb::limb {

/// Strain energy of the rods against their rest at their pressures, less the work of dead forces and weights on the way
/// from the base origin [J]. Raises std::runtime_error where the loads have no potential.
double potential_energy(const Posture& posture);

/// Its derivatives to rates. The equilibrium makes it stationary: they are those of the energy at the shape as it is.
/// Raises std::runtime_error where the loads, or a load that a rate brings, have no potential.
std::vector<double> potential_energy_slopes(const Posture& posture, const std::vector<SceneRate>& rates);

}  // namespace softlimb::limb
