#pragma once
// What a scene does not need: segments that do not feel each other, and limbs that stay straight.
// Source: cpp/MECHANICS.md, "What a scene does not need".
#include <functional>
#include <optional>

#include "softlimb/limb/solver.hpp"

namespace softlimb::limb {

/// Nothing pulls on the limb: no weight, no wrench, no distributed load, no hold. Then the net wrench on every plate is
/// zero and each segment has the shape that it has alone.
bool unloaded(const Geometry& geometry, const Scene& scene);

/// The posture of an unloaded limb, segment by segment, each by `solve_segment`; a segment like the one before it is
/// not solved again. None where a segment fails: then the limb as a whole may tell more.
std::optional<Solution> solve_apart(
    const Geometry& geometry, const Scene& scene, const SolveOptions& options,
    const std::function<Solution(const Geometry&, const Scene&, const SolveOptions&)>& solve_segment);

/// The straight posture where symmetry has one: in every segment equal rods without rest twist, parallel to the axis
/// and centred on it, and loads along the axis only. Each rod carries its share of what is above it; its length is the
/// integral of its axial law. None for any other scene.
std::optional<Shape> straight_shape(const Geometry& geometry, const Scene& scene);

}  // namespace softlimb::limb
