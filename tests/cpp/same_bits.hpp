#pragma once
// Equality of two solutions to the last bit: what one build on one machine owes.
#include <cstring>

#include "softlimb/limb/solver.hpp"

namespace softlimb::tests {

template <class Matrix>
bool same_numbers(const Matrix& a, const Matrix& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), sizeof(double) * a.size()) == 0;
}
inline bool same_poses(const std::vector<Pose>& a, const std::vector<Pose>& b) {
    if (a.size() != b.size()) return false;
    for (std::size_t i = 0; i < a.size(); ++i)
        if (!same_numbers(a[i].position, b[i].position) || !same_numbers(a[i].rotation, b[i].rotation)) return false;
    return true;
}
inline bool same_bits(const limb::Solution& a, const limb::Solution& b) {
    if (a.status != b.status || a.message != b.message || a.iterations != b.iterations) return false;
    if (a.stable != b.stable || !same_numbers(a.base_wrench, b.base_wrench)) return false;
    if (!same_poses(a.shape.plates, b.shape.plates) || a.shape.rods.size() != b.shape.rods.size()) return false;
    for (std::size_t i = 0; i < a.shape.rods.size(); ++i) {
        const limb::RodShape &x = a.shape.rods[i], &y = b.shape.rods[i];
        if (!same_poses(x.nodes, y.nodes) || x.wrenches.size() != y.wrenches.size()) return false;
        for (std::size_t e = 0; e < x.wrenches.size(); ++e)
            if (!same_numbers(x.wrenches[e], y.wrenches[e])) return false;
    }
    return true;
}

}  // namespace softlimb::tests
