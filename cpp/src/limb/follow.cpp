// From a posture near by: first steps with its stiffness, one linearisation, at the answer, which is kept for the next.
// Source: cpp/MECHANICS.md, "Newton".
#include <algorithm>
#include <atomic>
#include <cmath>

#include "softlimb/largest.hpp"
#include "softlimb/limb/equilibrium.hpp"

namespace softlimb::limb {
namespace {

/// How fast steps with one stiffness shrink: each leaves about the same share of what the one before it left. Before
/// there were two, a share is foretold by the size of the first.
struct Shrinking {
    double foretold;  // over the size
    double share = 0.0, last = 0.0;
    bool measured = false;

    /// `brought_in` of the size is nothing that the step before left.
    void add(double size, double brought_in) {
        if (last > 0.0 && brought_in < size) grow(share, (size - brought_in) / last), measured = true;
        last = size;
    }
    /// What is left after some more steps.
    double left(int more) const { return std::pow(measured ? share : std::min(foretold * last, 1.0), more + 1) * last; }
};

}  // namespace

Equilibrium::Equilibrium(const Geometry& geometry, const Scene& scene, LinearisationNumber number)
    : Room([number](const EquilibriumRoom& room) {
          if (room.number_ == 0) return 1;
          return room.number_ == number ? 2 : 0;
      }),
      geometry_(geometry),
      scene_(scene) {}

LinearisationNumber Equilibrium::keep_linearisation() {
    static std::atomic<LinearisationNumber> last{0};
    return number_ = ++last;
}

NewtonReport Equilibrium::follow(const Scene& scene_before, const Shape& before, LinearisationNumber number,
                                 Shape& shape, const NewtonSettings& settings, solve::Work& work) {
    using solve::SolveStatus;
    NewtonReport report;
    report.status = SolveStatus::no_progress;
    const bool linearised = at_hand(number);
    resize(shape);
    shift_.setZero();
    neutral_.clear();
    if (!linearised && !linearise(scene_before, before)) return report;
    const int pieces = shape.pieces();
    // The first step that is integrated with half the step brings in what the coarse ones err by as well: of poses no
    // more than the tolerance, or the last word below is no; of wrenches much where rods are stiff.
    constexpr int most_steps = 6;
    constexpr double largest_share = 0.3;
    const double pose_target = 0.25 * settings.tolerance, wrench_target = 5.0 * settings.tolerance;
    Scales scales = scales_at(shape);
    Shrinking pose{3.0}, wrench{1.0};
    for (int step = 0, fine = 0;; ++step) {
        if (step == most_steps || !work.spend(pieces)) return report;
        propose_again(shape, fine > 0 ? 2 : 1);
        const Step now = step_now(scales);
        if (!std::isfinite(now.size) || bounded_factor(shape, settings.largest_turn) != 1.0) return report;
        pose.add(now.size, fine == 1 ? settings.tolerance : 0.01 * settings.tolerance);
        wrench.add(now.wrench, fine == 1 ? now.wrench : 0.01 * wrench_target);
        if (pose.share > largest_share || wrench.share > largest_share) return report;
        apply(geometry_, moves_, 1.0, shape);
        report.nearer = true;
        scales = scales_at(shape);
        if (fine > 0 && pose.left(0) < pose_target && wrench.left(0) < wrench_target) break;
        const int more = most_steps - 1 - step;
        if (pose.left(more) > pose_target || wrench.left(more) > wrench_target) return report;
        if (fine > 0 || pose.left(1) < pose_target) ++fine;
    }
    // The coarse steps' answer by the stiffness here, against this one: what half the step changes, which is the error.
    if (!linearise(shape)) return report;
    report.residual = relative_residual(shape, scales);
    // A soft rod beside stiff ones may gape where its wrenches count for nothing. Half of what a verification allows.
    if (!(largest_gap() <= 5.0 * settings.tolerance)) return report;
    propose(shape);
    const Step last = step_now(scales);
    report.error_estimate = last.size + pose.left(0);
    if (!(report.error_estimate <= settings.tolerance)) return report;
    if (!(last.wrench <= wrench_target)) {
        propose_again(shape, 2);
        if (!(step_now(scales).wrench <= wrench_target)) return report;
    }
    report.iterations = 1;
    report.status = SolveStatus::converged;
    judge(shape, report, 0.0);
    return report;
}

}  // namespace softlimb::limb
