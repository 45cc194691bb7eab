#include "softlimb/limb/moves.hpp"

#include <algorithm>
#include <cmath>

#include "softlimb/largest.hpp"

namespace softlimb::limb {
namespace {

/// Calls `use` for every vector of `a`, with its fellow in `b`.
template <class A, class B, class Use>
void for_pairs(A& a, B& b, Use&& use) {
    for (std::size_t j = 0; j < a.plates.size(); ++j) use(a.plates[j], b.plates[j]);
    for (std::size_t i = 0; i < a.nodes.size(); ++i)
        for (std::size_t e = 0; e < a.nodes[i].size(); ++e) use(a.nodes[i][e], b.nodes[i][e]);
    for (std::size_t i = 0; i < a.wrenches.size(); ++i)
        for (std::size_t e = 0; e < a.wrenches[i].size(); ++e) use(a.wrenches[i][e], b.wrenches[i][e]);
}

}  // namespace

void Moves::set_zero(const Geometry& geometry, const Shape& shape) {
    plates.assign(geometry.plates(), Vector6::Zero());
    nodes.resize(shape.rods.size()), wrenches.resize(shape.rods.size());
    for (std::size_t i = 0; i < shape.rods.size(); ++i) {
        nodes[i].assign(shape.rods[i].elements() + 1, Vector6::Zero());
        wrenches[i].assign(shape.rods[i].elements(), Vector6::Zero());
    }
}

Moves& Moves::operator*=(double factor) {
    for_pairs(*this, *this, [factor](Vector6& x, const Vector6&) { x *= factor; });
    return *this;
}

Moves& Moves::add(double factor, const Moves& other) {
    for_pairs(*this, other, [factor](Vector6& x, const Vector6& y) { x += factor * y; });
    return *this;
}

double largest_move(const Moves& moves, double length) {
    double shift = 0.0, turn = 0.0;  // squares
    const auto include = [&](const Vector6& x) {
        grow(shift, x.head<3>().squaredNorm());
        grow(turn, x.tail<3>().squaredNorm());
    };
    for (const Vector6& x : moves.plates) include(x);
    for (const auto& nodes : moves.nodes)
        for (const Vector6& x : nodes) include(x);
    double largest = std::sqrt(shift) / length;
    grow(largest, std::sqrt(turn));
    return largest;
}

double largest_deformation(const Shape& shape, const Moves& moves, double length) {
    double shift = 0.0, largest_turn = 0.0;  // squares
    for (const Vector6& x : moves.plates) grow(largest_turn, x.tail<3>().squaredNorm());
    for (std::size_t i = 0; i < moves.nodes.size(); ++i) {
        const auto& nodes = moves.nodes[i];
        const auto& poses = shape.rods[i].nodes;
        for (std::size_t e = 0; e + 1 < nodes.size(); ++e) {
            const Vector3 turn = nodes[e].tail<3>(), arm = poses[e + 1].position - poses[e].position;
            const Vector3 carried = nodes[e].head<3>() + turn.cross(arm);
            grow(shift, (nodes[e + 1].head<3>() - carried).squaredNorm());
            grow(largest_turn, nodes[e + 1].tail<3>().squaredNorm());
        }
    }
    double largest = std::sqrt(shift) / length;
    grow(largest, std::sqrt(largest_turn));
    return largest;
}

double inner_product(const Moves& a, const Moves& b, double length) {
    const double per_area = 1.0 / (length * length);
    const auto product = [per_area](const Vector6& x, const Vector6& y) {
        return per_area * x.head<3>().dot(y.head<3>()) + x.tail<3>().dot(y.tail<3>());
    };
    double plates = 0.0, nodes = 0.0;
    std::size_t count = 0;
    for (std::size_t j = 0; j < a.plates.size(); ++j) plates += product(a.plates[j], b.plates[j]);
    for (std::size_t i = 0; i < a.nodes.size(); ++i)
        for (std::size_t e = 1; e + 1 < a.nodes[i].size(); ++e, ++count) nodes += product(a.nodes[i][e], b.nodes[i][e]);
    return plates / static_cast<double>(a.plates.size()) + nodes / static_cast<double>(std::max<std::size_t>(1, count));
}

void apply(const Geometry& geometry, const Moves& moves, double factor, Shape& shape) {
    const auto move = [factor](Pose& pose, const Vector6& x) {
        pose.position += factor * x.head<3>();
        pose.rotation = orthonormalised(exp_so3(factor * x.tail<3>()) * pose.rotation);
    };
    for (int j = 0; j < geometry.plates(); ++j) move(shape.plates[j], moves.plates[j]);
    for (std::size_t i = 0; i < shape.rods.size(); ++i) {
        RodShape& rod = shape.rods[i];
        for (int e = 0; e < rod.elements(); ++e) {
            if (e > 0) move(rod.nodes[e], moves.nodes[i][e]);
            rod.wrenches[e] += factor * moves.wrenches[i][e];
        }
    }
    attach_rods(geometry, shape);
}

bool extrapolate(const Geometry& geometry, const Shape& last, std::initializer_list<Share> shares, Shape& to) {
    for (const Share& share : shares)
        for (std::size_t i = 0; i < last.rods.size(); ++i)
            if (share.shape->rods[i].elements() != last.rods[i].elements()) return false;
    to = last;
    // `pose_of` finds in any of the shapes what becomes `moved`.
    const auto move = [&](Pose& moved, auto&& pose_of) {
        const Pose from = moved;
        Vector3 shift = Vector3::Zero(), turn = Vector3::Zero();
        for (const Share& share : shares) {
            const Pose& there = pose_of(*share.shape);
            shift += share.weight * (there.position - from.position);
            turn += share.weight * log_so3(there.rotation * from.rotation.transpose());
        }
        moved = {from.position + shift, orthonormalised(exp_so3(turn) * from.rotation)};
    };
    for (std::size_t j = 0; j < to.plates.size(); ++j)
        move(to.plates[j], [j](const Shape& shape) -> const Pose& { return shape.plates[j]; });
    for (std::size_t i = 0; i < to.rods.size(); ++i) {
        RodShape& rod = to.rods[i];
        for (int e = 1; e < rod.elements(); ++e)
            move(rod.nodes[e], [i, e](const Shape& shape) -> const Pose& { return shape.rods[i].nodes[e]; });
        for (int e = 0; e < rod.elements(); ++e) {
            const Vector6 from = rod.wrenches[e];
            for (const Share& share : shares)
                rod.wrenches[e] += share.weight * (share.shape->rods[i].wrenches[e] - from);
        }
    }
    attach_rods(geometry, to);
    return true;
}

}  // namespace softlimb::limb
