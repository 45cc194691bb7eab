#pragma once
// A limb of one clamped rod whose dead loads pull it: its internal force is known beforehand, and one shot from the tip
// with the tip's rotation as the only unknown takes the place of descent, chain and plates.
// Source: cpp/MECHANICS.md, "A cantilever under pull".
#include <optional>

#include "softlimb/limb/solver.hpp"

namespace softlimb::limb {

/// The stable equilibrium of such a limb, unique among those that stay where its forces pull; none for any other limb,
/// nor where it cannot be told that cheaply.
std::optional<Solution> solve_cantilever(const Geometry& geometry, const Scene& scene, const SolveOptions& options);

}  // namespace softlimb::limb
