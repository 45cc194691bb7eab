#pragma once
// A limb whose rods follow pressures: stable postures at pressures near each other, each from the one before it, and
// how the tip moves with the pressures. What searches over pressures is made of these.
// Source: cpp/MECHANICS.md, "Reach" and "Derivatives".
#include <functional>
#include <optional>
#include <vector>

#include "softlimb/limb/solver.hpp"

namespace softlimb::limb {

/// How pressures drive the rods. What stands between the two (tubes, their tables) is the caller's.
struct Actuation {
    std::vector<int> rods;  // the rod that each pressure drives
    /// Sections and rest lengths at pressures [Pa]; false where an actuator has no state.
    std::function<bool(const double*, std::vector<RodAtPressure>&)> rods_at;
    /// Their rates with each rod's own pressure.
    std::function<std::vector<RodSlope>(const double*)> slopes_at;

    Eigen::Index count() const { return static_cast<Eigen::Index>(rods.size()); }
};

/// A stable posture at its pressures.
struct DrivenPoint {
    Eigen::VectorXd pressures;  // [Pa]
    Shape shape;
    Eigen::Matrix<double, 6, Eigen::Dynamic> tip_by_pressure;  // (dp, dtheta), base axes at the tip's origin [./Pa]
    double doubt = 0.0;  // error of the shape, estimated: relative to the limb's length, or in radians
    double stale = 0.0;  // how far from the posture, in the same units, the derivatives were taken
    long number = -1;    // which posture of its limb this is
};

class DrivenLimb {
public:
    /// `scene` has the loads and holds; its sections and rest lengths do not count. Rods are integrated for
    /// `tolerance` throughout: postures of different meshes would differ by more than small steps move them.
    DrivenLimb(const Geometry& geometry, Scene scene, const Actuation& actuation, double tolerance, solve::Work& work);

    /// Newton from the point's shape at its pressures until its doubt is below `doubt`, then the tip's
    /// derivatives. False where no stable posture is near: the point is then of no use.
    bool settle(DrivenPoint& point, double doubt);
    /// Derivatives once more, at the posture itself and not where its last Newton step began.
    bool refresh(DrivenPoint& point);
    /// The same from nothing, by the whole plan of a solve.
    bool settle_from_nothing(DrivenPoint& point, const SolveOptions& options);
    /// Shape near the posture at changed pressures: the linear response to the change, cut where it bends too far.
    Shape predicted(const DrivenPoint& point, const Eigen::VectorXd& change);
    /// The whole solve at pressures; none where an actuator has no state.
    std::optional<Solution> solve(const Eigen::VectorXd& pressures, const SolveOptions& options, const Shape* start);
    /// Tip of the limb bent to constant curvature by its rest lengths alone; none as above.
    std::optional<Pose> constant_curvature_tip(const Eigen::VectorXd& pressures);

    const Geometry& geometry() const { return geometry_; }
    /// As it was last solved.
    const Scene& scene() const { return scene_; }
    int iterations() const { return iterations_; }

private:
    /// Where the shape is near enough one Newton step does, and the check with half the integration step waits for the
    /// answer. False where it does not; the shape has then taken it.
    bool step_once(Shape& shape, double allowed, double& doubt);
    bool linearise(DrivenPoint& point);
    void respond(DrivenPoint& point);

    const Geometry& geometry_;
    Scene scene_;
    const Actuation& actuation_;
    double tolerance_;
    solve::Work& work_;
    Equilibrium equilibrium_;
    std::vector<Vector6> tip_moves_;
    std::vector<double> amounts_;
    long last_ = -1, linearised_ = -1;  // number of the newest posture, and of the one that `equilibrium_` stands at
    int iterations_ = 0;
};

}  // namespace softlimb::limb
