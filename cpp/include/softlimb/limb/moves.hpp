#pragma once
// Small moves of a whole limb: what Newton, descent and continuation propose, measure and apply.
#include "softlimb/limb/scene.hpp"

namespace softlimb::limb {

/// Moves (dp, dtheta) of plates and of the nodes of every rod, and changes of the wrenches of its pieces (none in a
/// descent, which knows poses only).
struct Moves {
    std::vector<Vector6> plates;
    std::vector<std::vector<Vector6>> nodes, wrenches;

    void set_zero(const Geometry& geometry, const Shape& shape);
    Moves& operator*=(double factor);
    Moves& add(double factor, const Moves& other);
};

/// Largest move: rotations in radians, translations by `length`.
double largest_move(const Moves& moves, double length);

/// Largest deformation in a move: rotations in radians, and translations of each element's second node as the first
/// one's frame sees them, by `length`. A long limb that swings as a whole moves far and deforms little.
double largest_deformation(const Shape& shape, const Moves& moves, double length);

/// Mean of the products of two moves over plates and over interior nodes: translations by `length`, rotations in
/// radians.
double inner_product(const Moves& a, const Moves& b, double length);

/// Moves plates, interior nodes and wrenches of `shape` by `factor` times the moves; rods stay on their plates.
void apply(const Geometry& geometry, const Moves& moves, double factor, Shape& shape);

/// A shape and how much of the way to it is gone.
struct Share {
    const Shape* shape;
    double weight;
};
/// From `last` by shares of the ways from it to other shapes: poses along the turns and the shifts, wrenches in
/// proportion. A negative share leads away. False where meshes differ; `to` is then untouched.
bool extrapolate(const Geometry& geometry, const Shape& last, std::initializer_list<Share> shares, Shape& to);

}  // namespace softlimb::limb
