#pragma once
// A shape to start from: each segment bent to the constant curvature that its rest lengths ask for.
#include "softlimb/limb/scene.hpp"

namespace softlimb::limb {

/// Plates of the unloaded limb under constant curvature; held plates at their holds.
std::vector<Pose> constant_curvature_plates(const Geometry& geometry, const Scene& scene);

/// Rods along the SE(3) geodesics between given plates, `elements` each.
Shape geodesic_shape(const Geometry& geometry, const Scene& scene, const std::vector<Pose>& plates, int elements);

/// Shape on given plates with the wrenches of the geodesics, ready for Newton.
Shape start_from_plates(const Geometry& geometry, const Scene& scene, const std::vector<Pose>& plates);

/// Section of a rod as the descent sees it: extension and shear no stiffer than 1e5 EI/l^2. A stiffer rod changes the
/// posture by less than a hundred-thousandth of its load over EI/l^2, but turns the energy into a narrow curved valley.
Section softened(const RodAtPressure& rod);
/// The same for a geodesic that stands for one of `elements` of the rod: shear softer by h^2/(12 EI), the bow of a
/// beam of that length h between its ends, without which a geodesic knows no sideways move but shear.
Section softened(const RodAtPressure& rod, int elements);

/// Base wrenches of all pieces from the strains of their geodesics, with the rods' own stiffness or as the descent that
/// found the shape saw it.
enum class Stiffness { exact, softened };
void set_geodesic_wrenches(const Scene& scene, Shape& shape, Stiffness stiffness);

/// Splits every element of rod i into `parts` along its geodesic.
void split_elements(RodShape& rod, int parts);

/// Joins neighbouring elements of equal number, so that at least `wanted` are left: interior nodes are dropped.
void merge_elements(RodShape& rod, int wanted);

/// Moves a plate onto its hold.
void meet_hold(const Hold& hold, Pose& plate);

}  // namespace softlimb::limb
