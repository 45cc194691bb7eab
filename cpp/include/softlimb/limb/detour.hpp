#pragma once
// Ways round where descent and Newton alone do not lead to a scene: the same limb under part of what makes it hard, and
// a path from there. Source: cpp/MECHANICS.md, "Plan of a solve".
#include <optional>

#include "softlimb/limb/solver.hpp"

namespace softlimb::limb {

/// The scene with a share of those loads that have no potential: all of it but its weights, dead forces and holds.
Scene with_moments(const Scene& scene, double share);

/// Loads without a potential grown from nothing to all, through folds: the way where no descent leads, and for moments
/// that wind a rod up so far that no straight start reaches it. `unmoved` is a posture without them, `farthest` the
/// largest share that was carried.
std::optional<Shape> grow_moments(const Geometry& geometry, const Scene& scene, const SolveOptions& options,
                                  const Shape& unmoved, solve::Work& work, int& iterations, double& farthest);

/// Rods that hardly stretch and differ in length pull so hard that Newton does not bridge the way from the descent's
/// softened rods: their stiffness grows along a path. None where no rod was softened.
std::optional<Shape> stiffen(const Geometry& geometry, const Scene& scene, const SolveOptions& options,
                             const Shape& descended, solve::Work& work, int& iterations);

/// What buckles between held plates far past its critical load is small and stiff where rods hardly stretch: no push
/// from the unstable posture finds it. Their stiffness is taken back to just past where that posture loses its
/// stability, the posture left there along its mode, and the way followed back. None where that way does not lead
/// there.
std::optional<Shape> buckle(const Geometry& geometry, const Scene& scene, const SolveOptions& options,
                            const Shape& unstable, solve::Work& work, int& iterations);

}  // namespace softlimb::limb
