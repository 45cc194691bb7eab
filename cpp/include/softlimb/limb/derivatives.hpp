#pragma once
// Derivatives of a posture to everything that its scene is made of, by implicit differentiation of the balance.
//
//   rate of the scene (sections, lengths, placements, plates, loads)          SceneRate
//     -> rate of every piece's end at fixed base pose and wrench              one column a piece in the lanes
//     -> forces on nodes and plates, condensed, solved: moves of everything   forward: a column a parameter
//   row of an answer -> multipliers of nodes and plates (the transpose)       adjoint: a row an answer
//     -> times the rates of the pieces' ends, the loads, the arms             one number a parameter
//
// One linearisation serves all. Source: cpp/MECHANICS.md, "Derivatives".
#include <Eigen/Core>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "softlimb/limb/posture.hpp"

namespace softlimb::limb {

/// How fast what belongs to one rod changes. A placement's rate is (dp, dtheta) in the frame that it is given in.
struct RodRate {
    Section section{};  // field by field; of the axial law the coefficients and the range
    double rest_length = 0.0;
    Vector3 line_force = Vector3::Zero();  // weight not included
    Vector6 base = Vector6::Zero(), end = Vector6::Zero();

    void add(double factor, const RodRate& other);
};

struct PlateRate {
    double thickness = 0.0, mass = 0.0;
    Vector6 wrench = Vector6::Zero();  // as the scene has it: base axes, or plate axes of following ones
};

/// How fast everything in a scene changes with one parameter; what is not named stays. Each rod and plate once.
struct SceneRate {
    std::vector<std::pair<int, RodRate>> rods;
    std::vector<std::pair<int, PlateRate>> plates;
    Vector3 gravity = Vector3::Zero();

    RodRate& rod(int i);
    PlateRate& plate(int j);
    /// What a rod's load per rest length changes by, weight included.
    Vector3 line_force(const Scene& scene, int i, const RodRate& own) const;
};

/// Calls `use(rod, move)` for every rod whose ends move on plates that stay, (dp, dtheta) of base and end in base axes:
/// by its placement, or by the thickness of the plate below. A rod may be named twice, its moves add up.
template <class Use>
void for_each_end_move(const Geometry& geometry, const Shape& shape, const SceneRate& rate, Use&& use) {
    const auto rods = [&](int j) { return static_cast<int>(geometry.segments[j].rods.size()); };
    for (const std::pair<int, RodRate>& rod : rate.rods) {
        const int i = rod.first;
        const RodRate& change = rod.second;
        if (change.base.isZero(0.0) && change.end.isZero(0.0)) continue;
        int j = 0;
        for (int first = 0; first + rods(j) <= i; ++j) first += rods(j);
        const Matrix3 foot = j > 0 ? shape.plates[j - 1].rotation : Matrix3(Matrix3::Identity());
        const Matrix3& end = shape.plates[j].rotation;
        Vector12 move;
        move << foot * change.base.head<3>(), foot * change.base.tail<3>(), end * change.end.head<3>(),
            end * change.end.tail<3>();
        use(i, move);
    }
    for (const auto& [plate, change] : rate.plates) {
        if (change.thickness == 0.0 || plate + 1 == geometry.plates()) continue;
        Vector12 move = Vector12::Zero();
        move.head<3>() = change.thickness * shape.plates[plate].rotation.col(2);
        int i = 0;
        for (int j = 0; j <= plate; ++j) i += rods(j);
        for (const int end = i + rods(plate + 1); i < end; ++i) use(i, move);
    }
}

/// A point that stays at its fraction, 0 to 1, of a rod's rest length.
struct MaterialPoint {
    int rod = 0;
    double fraction = 0.0;
};

/// The posture, linearised. Answers are stacked: (dp, dtheta) of every plate, then the positions of material points.
class Derivatives {
public:
    /// `tolerance` of the posture: its pieces are joined where a finer mesh than that asks for is left of a cold start.
    /// Raises std::runtime_error at a fold.
    Derivatives(std::shared_ptr<const Posture> posture, double tolerance);

    const Posture& posture() const { return *posture_; }

    /// Tip (dp, dtheta) by tip wrench, base axes.
    Matrix6 compliance() const;
    /// Condensed stiffness of the plates, (dp, dtheta) of every plate in base axes about its origin; rows and columns
    /// of held freedoms are zero.
    Eigen::MatrixXd plate_stiffness() const;

    /// As the function of that name.
    std::vector<Vector6> tip_by_rods(const std::vector<RodSlope>& slopes);

    /// Answers by parameters, (6 plates + 3 points) x rates.
    Eigen::MatrixXd forward(const std::vector<SceneRate>& rates, const std::vector<MaterialPoint>& points) const;
    /// Combinations of the answers, the rows of `weights`, by parameters: weights times `forward`.
    Eigen::MatrixXd adjoint(const Eigen::MatrixXd& weights, const std::vector<SceneRate>& rates,
                            const std::vector<MaterialPoint>& points) const;

private:
    struct PieceRates;
    struct PointRows;
    struct Multipliers;
    struct Load;

    PieceRates piece_rates(const std::vector<SceneRate>& rates, const std::vector<MaterialPoint>& points) const;
    std::vector<PointRows> point_rows(const std::vector<MaterialPoint>& points) const;
    void put_load(const SceneRate& rate, Load& load) const;
    template <class Use>
    void for_each_plate_load(const SceneRate& rate, Use&& use) const;
    Multipliers multipliers(const Eigen::VectorXd& weights, const std::vector<PointRows>& points) const;
    const std::vector<solve::BlockTridiagonal>& transposed() const;

    std::shared_ptr<const Posture> posture_;
    Shape shape_;
    Equilibrium equilibrium_;
    std::vector<int> segment_of_;  // by rod
    // The transposed system, made when first asked for: interior nodes of each rod, and last the plates.
    mutable std::vector<solve::BlockTridiagonal> transposed_;
    mutable std::once_flag transpose_;
};

/// Tip (dp, dtheta) by a parameter of each rod in turn: what `forward` gives, one column a piece and no more. Of a
/// posture that was followed, by the linearisation that its solve ended with: at hand, or taken again to the same bits.
std::vector<Vector6> tip_by_rods(const Posture& followed, const std::vector<RodSlope>& slopes);

}  // namespace softlimb::limb
