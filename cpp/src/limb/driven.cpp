#include "softlimb/limb/driven.hpp"

#include <algorithm>
#include <cmath>

#include "softlimb/limb/attempt.hpp"
#include "softlimb/limb/start.hpp"

namespace softlimb::limb {

using solve::SolveStatus;

DrivenLimb::DrivenLimb(const Geometry& geometry, Scene scene, const Actuation& actuation, double tolerance,
                       solve::Work& work)
    : geometry_(geometry),
      scene_(std::move(scene)),
      actuation_(actuation),
      tolerance_(tolerance),
      work_(work),
      equilibrium_(geometry_, scene_),
      amounts_(scene_.rods.size(), 0.0) {}

void DrivenLimb::respond(DrivenPoint& point) {
    equilibrium_.respond_to_rods(point.shape, actuation_.slopes_at(point.pressures.data()), tip_moves_);
    point.tip_by_pressure.resize(6, actuation_.count());
    for (Eigen::Index k = 0; k < actuation_.count(); ++k) point.tip_by_pressure.col(k) = tip_moves_[actuation_.rods[k]];
    linearised_ = point.number;
}

bool DrivenLimb::linearise(DrivenPoint& point) {
    if (!actuation_.rods_at(point.pressures.data(), scene_.rods)) return false;
    if (!equilibrium_.linearise_at(point.shape)) return false;
    respond(point);
    return true;
}

bool DrivenLimb::step_once(Shape& shape, double allowed, double& doubt) {
    choose_mesh(scene_, tolerance_, shape, warm_piece);
    work_.spend(static_cast<long>(shape.rods.size()));
    doubt = equilibrium_.step_to_balance(shape);
    ++iterations_;
    if (!(doubt < allowed) || !mesh_suffices(scene_, std::max(tolerance_, doubt), shape)) return false;
    NewtonReport report;
    equilibrium_.judge(shape, report, std::sqrt(doubt));
    return !scene_.conservative() || report.modes() == 0;
}

bool DrivenLimb::settle(DrivenPoint& point, double doubt) {
    if (!actuation_.rods_at(point.pressures.data(), scene_.rods)) return false;
    linearised_ = -1;
    Shape shape = point.shape;
    const bool once = step_once(shape, doubt, point.doubt);
    point.stale = std::sqrt(point.doubt);
    if (!once) {
        SolveOptions options;
        options.tolerance = tolerance_;
        options.max_iterations = 12;  // a step that takes more is too long
        Attempt attempt = refine(scene_, options, work_, equilibrium_, shape, iterations_, warm_piece);
        if (!attempt.converged() || (scene_.conservative() && !attempt.stable())) return false;
        shape = std::move(attempt.shape);
        point.doubt = attempt.report.error_estimate;
        point.stale = std::sqrt(tolerance_);  // Newton's last step is no longer
    }
    // Further than a radian or a limb's length from where it was meant to be, it is another posture.
    if (!(distance(geometry_, shape, point.shape) < 1.0)) return false;
    point.shape = std::move(shape);
    point.number = ++last_;
    respond(point);
    return point.tip_by_pressure.allFinite();
}

bool DrivenLimb::refresh(DrivenPoint& point) {
    point.stale = 0.0;
    return linearise(point);
}

bool DrivenLimb::settle_from_nothing(DrivenPoint& point, const SolveOptions& options) {
    std::optional<Solution> solution = solve(point.pressures, options, nullptr);
    if (!solution || solution->status != SolveStatus::converged || !solution->stable) return false;
    point.shape = std::move(solution->shape);
    point.doubt = solution->error_estimate;
    point.number = ++last_;
    return linearise(point) && point.tip_by_pressure.allFinite();
}

Shape DrivenLimb::predicted(const DrivenPoint& point, const Eigen::VectorXd& change) {
    if (linearised_ != point.number) {
        DrivenPoint again = point;
        if (!linearise(again)) return point.shape;
    }
    for (Eigen::Index k = 0; k < actuation_.count(); ++k) amounts_[actuation_.rods[k]] = change(k);
    const Moves& moves = equilibrium_.moves_with_rods(point.shape, amounts_);
    // Beyond half a radian the linear response is no better than none.
    constexpr double farthest = 0.5;
    const double bend = largest_deformation(point.shape, moves, geometry_.length);
    Shape shape = point.shape;
    if (std::isfinite(bend)) apply(geometry_, moves, bend > farthest ? farthest / bend : 1.0, shape);
    return shape;
}

std::optional<Solution> DrivenLimb::solve(const Eigen::VectorXd& pressures, const SolveOptions& options,
                                          const Shape* start) {
    if (!actuation_.rods_at(pressures.data(), scene_.rods)) return std::nullopt;
    Solution solution = limb::solve(geometry_, scene_, options, start);
    iterations_ += solution.iterations;
    return solution;
}

std::optional<Pose> DrivenLimb::constant_curvature_tip(const Eigen::VectorXd& pressures) {
    if (!actuation_.rods_at(pressures.data(), scene_.rods)) return std::nullopt;
    return constant_curvature_plates(geometry_, scene_).back();
}

}  // namespace softlimb::limb
