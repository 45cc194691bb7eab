#include "softlimb/limb/reach.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "softlimb/limb/attempt.hpp"
#include "softlimb/limb/start.hpp"
#include "softlimb/solve/bounded_least_squares.hpp"

namespace softlimb::limb {
namespace {

using Eigen::Index, Eigen::MatrixXd, Eigen::VectorXd;
using solve::bounded_least_squares, solve::SolveStatus;

constexpr double infinity = std::numeric_limits<double>::infinity();

/// How much more a row of the target weighs than one of the preference. Its square times the error that is left at the
/// target is the target's price, which is of order ten: so the preference costs a part in 1e11.
constexpr double target_weight = 1e6;

/// A posture and its errors, weighted and without units; pressures in units of the widest bounds, so that one is a
/// large change and the effort of order one.
struct Point {
    DrivenPoint at;
    VectorXd place;     // pressures
    Vector6 gap;        // of the tip: [m], [rad]
    VectorXd error;     // rows with a weight
    MatrixXd by_place;  // their derivatives
    double miss = 0.0;  // norm of the error
};

enum class Ending {
    near,     // as near to the target as asked
    nearest,  // no change of the pressures within bounds comes nearer
    stuck,    // no step leads to a stable posture that is nearer
    spent     // out of iterations
};

double largest_of(const VectorXd& x) { return x.size() > 0 ? x.cwiseAbs().maxCoeff() : 0.0; }

/// Minimises x^T curvature x / 2 + slope^T x, and |rows x - right| weighing far more, between bounds. An indefinite
/// curvature is shifted until it is positive definite.
VectorXd bounded_quadratic(MatrixXd curvature, const VectorXd& slope, const MatrixXd& rows, const VectorXd& right,
                           const VectorXd& lower, const VectorXd& upper) {
    const Index n = slope.size(), m = right.size();
    Eigen::LLT<MatrixXd> factor(curvature);
    double shift = 1e-3 * std::max(curvature.cwiseAbs().maxCoeff(), 1e-300);
    while (factor.info() != Eigen::Success) {
        curvature.diagonal().array() += shift;
        shift *= 4.0;
        factor.compute(curvature);
    }
    MatrixXd matrix(m + n, n);
    VectorXd wanted(m + n);
    matrix.topRows(m) = target_weight * rows, wanted.head(m) = target_weight * right;
    matrix.bottomRows(n) = factor.matrixU(), wanted.tail(n) = -factor.matrixL().solve(slope);
    return bounded_least_squares(matrix, wanted, lower, upper);
}

class Search {
public:
    Search(const Geometry& geometry, const Scene& scene, const Actuation& actuation, const ReachTarget& target,
           const ReachSettings& settings)
        : geometry_(geometry),
          target_(target),
          settings_(settings),
          // A start looks at some thirty postures, each a few evaluations a rod; a solve's own budget for each is
          // ample.
          work_(40'000L * (1 + static_cast<long>(scene.rods.size())) * (2 + settings.starts), settings.interrupted),
          limb_(geometry, scene, actuation, settings.tolerance, work_),
          count_(actuation.count()) {
        unit_ = largest_of(settings.upper - settings.lower);
        if (unit_ == 0.0) unit_ = 1.0;  // nothing may move
        lower_ = settings.lower / unit_, upper_ = settings.upper / unit_;
        preferred_ = settings.preferred / unit_;
        for (int k = 0; k < 6; ++k)
            if (target.weights(k) != 0.0) rows_.push_back(k);
    }

    ReachSolution run(const ReachStart* start) {
        if (!start || !from_given(*start)) from_nothing();
        if (best_.posture.shape.plates.empty()) without_posture();
        best_.iterations = looks_;
        best_.starts = starts_;
        return std::move(best_);
    }

private:
    struct Found {
        Point point;  // where its last step has not been looked at, with the shape that the linear response has there
        Ending ending = Ending::spent;
        bool least = false;
        MatrixXd curvature;
        std::optional<Point> before;  // the search for the preference
    };

    static constexpr double loose = 1e-5, loosest = 1e-4;  // tolerances of starts, and of postures on the way
    static constexpr double close = 1e-3;  // miss from which the target is met and the preference sought together

    // ---- starts -------------------------------------------------------------------------------------------------

    bool from_given(const ReachStart& start) {
        Point point;
        point.place = inside(start.pressures / unit_);
        point.at.shape = *start.shape;
        if (!look(point, loose)) return false;
        anchor_ = point.place;
        // On a path neither the preference nor the postures on the way need be as exact: the next target goes on.
        last_step_ = 1e-3, careful_ = false;
        memory_.pressures = point.at.pressures, memory_.tip_by_pressure = point.at.tip_by_pressure;
        MatrixXd curvature = MatrixXd::Identity(count_, count_);
        if (start.memory && start.memory->curvature.rows() == count_) curvature = start.memory->curvature;
        if (start.memory && start.memory->tip_by_pressure.cols() == count_) {
            before_.emplace();
            before_->place = start.memory->pressures / unit_;
            before_->at.tip_by_pressure = start.memory->tip_by_pressure;
        }
        keep(search_from(std::move(point), std::move(curvature), true));
        return best_.reached;
    }

    void from_nothing() {
        last_step_ = 1e-4, careful_ = true;
        before_.reset();
        std::mt19937_64 draw(20260417);
        int alike = 0;
        for (int k = 0; k < settings_.starts; ++k) {
            ++starts_;
            Point point;
            point.place = inside(preferred_);
            // The first start is the preference itself, the others are spread between the bounds, half of them as they
            // are: far targets bend all to one posture. The draw is spelt out, because the standard's distributions
            // differ between libraries.
            if (k > 0)
                for (Index i = 0; i < count_; ++i)
                    point.place(i) =
                        lower_(i) + (upper_(i) - lower_(i)) * (static_cast<double>(draw() >> 11) * 0x1p-53);
            anchor_ = point.place;
            if (k % 2 == 0) bend_towards_target(point);
            if (!look_from_nothing(point)) continue;
            const double before = best_.posture.shape.plates.empty() ? infinity : best_.miss;
            Found found = search_from(std::move(point), MatrixXd::Identity(count_, count_), false);
            // A fold in the way: beyond it the limb snaps to another posture, from which the target may be in reach.
            constexpr int leaps = 2;
            for (int leap = 0; leap < leaps && found.ending == Ending::stuck; ++leap) {
                Point beyond;
                beyond.place = inside(found.point.place + gauss_newton(found.point, first_radius));
                if (!look_from_nothing(beyond)) break;
                Found other = search_from(std::move(beyond), MatrixXd::Identity(count_, count_), false);
                if (other.ending != Ending::near) keep(found);
                found = std::move(other);
            }
            keep(found);
            if (best_.reached) {
                if (!best_.another_from_nothing) return;
                continue;
            }
            // Several starts that end as far from the target have found the edge of the reach. Where little is missing,
            // all may try.
            constexpr int enough = 5;
            constexpr double little = 0.15;
            if (found.ending != Ending::nearest || best_.miss < little) continue;
            if (std::abs(found.point.miss - before) <= 1e-3 * before)
                ++alike;
            else if (found.point.miss < before)
                alike = 1;
            if (alike >= enough) return;
        }
    }

    /// Nothing between the bounds has a stable posture that was found: what the preferred pressures have, then.
    void without_posture() {
        best_.pressures = pressures_of(inside(preferred_));
        std::optional<Solution> solution = limb_.solve(best_.pressures, options(settings_.tolerance), nullptr);
        best_.scene = limb_.scene();
        if (solution) {
            best_.posture = *std::move(solution);
            best_.status =
                best_.posture.status == SolveStatus::converged ? SolveStatus::no_progress : best_.posture.status;
        } else {
            best_.posture.shape =
                start_from_plates(geometry_, best_.scene, constant_curvature_plates(geometry_, best_.scene));
            best_.posture.reactions.assign(geometry_.plates(), Vector6::Zero());
            best_.posture.residual = infinity;
            best_.posture.status = best_.status = SolveStatus::limit_point;
        }
        best_.gap = gap_of(best_.posture.shape.plates.back());
        best_.miss = weighted(best_.gap).norm();
    }

    /// `nearby`: the target may be met from here without an approach.
    Found search_from(Point point, MatrixXd curvature, bool nearby) {
        Found found;
        found.curvature = std::move(curvature);
        if (nearby) {
            found.before = point;
            found.least = economise(point, found.curvature);
        }
        const bool came_near = nearby && point.miss <= close;
        found.ending = came_near ? Ending::near : approach_postures(point, close);
        if (found.ending == Ending::near && !came_near) {
            found.before = point;
            found.least = economise(point, found.curvature);
        }
        // Where that was left before its end, the target still comes first.
        if (found.ending == Ending::near && !found.least)
            found.ending = approach_postures(point, 0.1 * settings_.tolerance);
        found.point = std::move(point);
        return found;
    }

    /// The whole solve at the pressures found decides what was reached; the better answer stays.
    void keep(const Found& found) {
        ReachSolution answer;
        Point point = found.point;
        const SolveOptions strict = options(std::max(0.1 * settings_.tolerance, 1e-12));
        // The last step of a search rests on the linear response; a correction or two make up for what it leaves.
        for (int round = 0;; ++round) {
            answer.pressures = pressures_of(point.place);
            std::optional<Solution> solution = limb_.solve(answer.pressures, strict, &point.at.shape);
            if (!solution) return;
            answer.posture = *std::move(solution);
            answer.gap = gap_of(answer.posture.shape.plates.back());
            answer.reached = answer.posture.status == SolveStatus::converged && answer.posture.stable &&
                             within_tolerance(answer.gap);
            constexpr int most = 3;
            if (answer.reached || found.ending != Ending::near || round == most) break;
            point.at.shape = answer.posture.shape;
            if (!look(point, strict.tolerance)) break;
            // A look integrates the rods to the tolerance of a search; the gap to be closed is that of the answer.
            judge(point, answer.posture.shape.plates.back());
            const VectorXd step = back_to_target(point);
            point.at.shape = limb_.predicted(point.at, unit_ * step);
            point.place = inside(point.place + step);
        }
        if (!answer.reached && found.ending == Ending::near && found.before) {
            // The preference led to where postures end. From before that straight to the target.
            Found straight;
            straight.point = *found.before;
            straight.curvature = MatrixXd::Identity(count_, count_);
            straight.ending = approach_postures(straight.point, 0.1 * settings_.tolerance);
            return keep(straight);
        }
        if (answer.posture.status != SolveStatus::converged || !answer.posture.stable) return;
        answer.miss = weighted(answer.gap).norm();
        answer.least = answer.reached && found.least;
        answer.scene = limb_.scene();
        answer.status = answer.reached                    ? SolveStatus::converged
                        : found.ending == Ending::nearest ? SolveStatus::no_progress
                        : found.ending == Ending::stuck   ? SolveStatus::singular_jacobian
                                                          : SolveStatus::max_iterations;
        answer.memory = memory_;
        answer.memory.curvature = found.curvature;
        if (answer.reached && starts_ > 0) {
            // The posture was come to by a path. Who has the pressures alone should come to it as well.
            const std::optional<Solution> alone = limb_.solve(answer.pressures, options(loose), nullptr);
            answer.another_from_nothing = !alone || alone->status != SolveStatus::converged ||
                                          distance(geometry_, alone->shape, answer.posture.shape) > 1e-3;
        }
        const bool first = best_.posture.shape.plates.empty();
        const bool better = answer.reached != best_.reached
                                ? answer.reached
                                : (answer.reached ? best_.another_from_nothing && !answer.another_from_nothing
                                                  : answer.miss < best_.miss);
        if (first || better) best_ = std::move(answer);
    }

    // ---- what a point is judged by --------------------------------------------------------------------------------

    VectorXd inside(const VectorXd& place) const { return place.cwiseMax(lower_).cwiseMin(upper_); }

    VectorXd pressures_of(const VectorXd& place) const {
        VectorXd pressures = place * unit_;
        for (Index i = 0; i < count_; ++i) {  // a bound is met exactly, whatever the units have rounded
            if (place(i) <= lower_(i)) pressures(i) = settings_.lower(i);
            if (place(i) >= upper_(i)) pressures(i) = settings_.upper(i);
        }
        return pressures;
    }

    Vector6 gap_of(const Pose& tip) const { return rod::pose_gap(tip, target_.pose); }

    Vector6 weighted(Vector6 gap) const {
        gap.head<3>() /= geometry_.length;
        return gap.cwiseProduct(target_.weights);
    }

    bool within_tolerance(const Vector6& gap) const {
        Vector6 counted = gap;
        counted.head<3>() /= geometry_.length;
        for (int k = 0; k < 6; ++k)
            if (target_.weights(k) == 0.0) counted(k) = 0.0;
        return counted.head<3>().norm() <= settings_.tolerance && counted.tail<3>().norm() <= settings_.tolerance;
    }

    SolveOptions options(double tolerance) const {
        SolveOptions options;
        options.tolerance = tolerance;
        options.interrupted = settings_.interrupted;
        return options;
    }

    void judge(Point& point, const Pose& tip) const {
        point.gap = gap_of(tip);
        const Vector6 all = weighted(point.gap);
        point.error.resize(static_cast<Index>(rows_.size()));
        for (std::size_t r = 0; r < rows_.size(); ++r) point.error(static_cast<Index>(r)) = all(rows_[r]);
        point.miss = point.error.norm();
    }

    void describe(Point& point) const {
        judge(point, point.at.shape.plates.back());
        differentiate(point);
    }

    /// The rows' derivatives from those of the tip.
    void differentiate(Point& point) const {
        const Matrix3 turn = left_jacobian_inverse(Vector3(point.gap.tail<3>()));
        point.by_place.resize(static_cast<Index>(rows_.size()), count_);
        for (Index i = 0; i < count_; ++i) {
            Vector6 move = unit_ * point.at.tip_by_pressure.col(i);
            move.tail<3>() = (turn * move.tail<3>()).eval();
            move = weighted(move);
            for (std::size_t r = 0; r < rows_.size(); ++r) point.by_place(static_cast<Index>(r), i) = move(rows_[r]);
        }
    }

    bool look(Point& point, double doubt) {
        ++looks_;
        point.at.pressures = pressures_of(point.place);
        if (!limb_.settle(point.at, doubt)) return false;
        describe(point);
        return true;
    }

    bool look_from_nothing(Point& point) {
        ++looks_;
        point.at.pressures = pressures_of(point.place);
        if (!limb_.settle_from_nothing(point.at, options(loose))) return false;
        describe(point);
        return true;
    }

    /// The posture a step away; none where there is no stable one.
    std::optional<Point> stepped(const Point& from, const VectorXd& step) {
        Point to;
        to.place = inside(from.place + step);
        to.at.shape = limb_.predicted(from.at, unit_ * (to.place - from.place));
        // The step leaves about its square at the target: a posture on the way need not be much better than that.
        const double size = largest_of(step);
        if (!look(to, std::clamp(0.1 * size * size, 0.1 * settings_.tolerance, loosest))) return std::nullopt;
        return to;
    }

    VectorXd lower_step(const Point& point, double radius) const {
        return (lower_ - point.place).cwiseMax(-radius).cwiseMin(0.0);
    }
    VectorXd upper_step(const Point& point, double radius) const {
        return (upper_ - point.place).cwiseMin(radius).cwiseMax(0.0);
    }

    // ---- approach -------------------------------------------------------------------------------------------------

    /// The step that the linear model likes best, and of several the one nearest to the anchor: so starts that lie
    /// apart come to the target apart.
    VectorXd gauss_newton(const Point& point, double radius) const {
        return bounded_quadratic(MatrixXd::Identity(count_, count_), point.place - anchor_, point.by_place,
                                 -point.error, lower_step(point, radius), upper_step(point, radius));
    }

    /// The smallest step that the linear model likes as much.
    VectorXd back_to_target(const Point& point) const {
        return bounded_quadratic(MatrixXd::Identity(count_, count_), VectorXd::Zero(count_), point.by_place,
                                 -point.error, lower_step(point, infinity), upper_step(point, infinity));
    }

    /// Nears the target by steps within a radius; `step_to(point, step)` gives the point there or none.
    template <class StepTo>
    Ending approach(Point& point, double near, StepTo&& step_to) {
        // To the target it takes some ten steps; to the edge of the reach, along folds, many more.
        constexpr int most = 120;
        constexpr double negligible = 1e-8;  // part of a squared miss that is no more worth a step
        double radius = first_radius;
        MatrixXd own = MatrixXd::Zero(count_, count_);  // error times its second derivative, as far as it was met
        for (int iteration = 0; iteration < most; ++iteration) {
            if (point.miss <= near) return Ending::near;
            VectorXd step = gauss_newton(point, infinity);
            const double square = point.miss * point.miss;
            double left = (point.error + point.by_place * step).squaredNorm();
            if (square - left <= negligible * square) return Ending::nearest;
            double promised;
            if (left < 0.25 * square) {
                if (largest_of(step) > radius) {
                    step = gauss_newton(point, radius);
                    left = (point.error + point.by_place * step).squaredNorm();
                }
                promised = 0.5 * (square - left);
            } else {
                // Most of the error stays. Near the edge of the reach the error's own curvature decides.
                MatrixXd curvature = point.by_place.transpose() * point.by_place + own;
                const VectorXd slope = point.by_place.transpose() * point.error;
                step = bounded_quadratic(curvature, slope, MatrixXd(0, count_), VectorXd(0), lower_step(point, radius),
                                         upper_step(point, radius));
                promised = -slope.dot(step) - 0.5 * step.dot(curvature * step);
                if (2.0 * promised <= negligible * square && largest_of(step) < 0.9 * radius) return Ending::nearest;
            }
            std::optional<Point> next = step_to(point, step);
            double gained = -1.0;
            if (next) {
                gained = 0.5 * (square - next->miss * next->miss);
                // Symmetric rank one: what of the slope's change the Gauss-Newton curvature does not have.
                const VectorXd moved = next->place - point.place;
                const VectorXd rest = (next->by_place - point.by_place).transpose() * next->error - own * moved;
                const double along = rest.dot(moved);
                if (std::abs(along) > 1e-8 * rest.norm() * moved.norm()) own += rest * rest.transpose() / along;
            }
            const double size = largest_of(step);
            if (!(gained > 1e-3 * promised)) {
                radius = 0.3 * size;
                if (radius < smallest_radius) return Ending::stuck;
                continue;
            }
            if (gained > 0.75 * promised && size > 0.9 * radius) radius = std::min(2.0 * radius, 1.0);
            if (gained < 0.25 * promised) radius = 0.5 * size;
            point = *std::move(next);
        }
        return point.miss <= near ? Ending::near : Ending::spent;
    }

    /// The same through postures.
    Ending approach_postures(Point& point, double near) {
        return approach(point, near, [this](const Point& from, const VectorXd& step) { return stepped(from, step); });
    }

    /// Moves the pressures to where the segments, bent to constant curvature, come near the target.
    void bend_towards_target(Point& point) {
        const auto judged = [this](const VectorXd& place) {
            std::optional<Point> there;
            const std::optional<Pose> tip = limb_.constant_curvature_tip(pressures_of(place));
            if (!tip) return there;
            there.emplace();
            there->place = place;
            judge(*there, *tip);
            return there;
        };
        const auto differentiated = [&](const VectorXd& place) {
            std::optional<Point> there = judged(place);
            if (!there) return there;
            there->by_place.resize(there->error.size(), count_);
            for (Index i = 0; i < count_; ++i) {
                constexpr double change = 1e-6;  // a start needs no exact slope; towards the inside
                VectorXd beside = place;
                beside(i) += beside(i) + change > upper_(i) ? -change : change;
                const std::optional<Point> other = judged(beside);
                if (!other) return std::optional<Point>();
                there->by_place.col(i) = (other->error - there->error) / (beside(i) - place(i));
            }
            return there;
        };
        std::optional<Point> start = differentiated(point.place);
        if (!start) return;
        approach(*start, close,
                 [&](const Point& from, const VectorXd& step) { return differentiated(inside(from.place + step)); });
        point.place = start->place;
    }

    // ---- economise ------------------------------------------------------------------------------------------------

    /// Sequential quadratic programming: least squares of the pressures about the preferred ones, the tip on the
    /// target. `curvature` is that of the Lagrangian, learned on the way. True where the last step is small enough; the
    /// point has then taken it without another look.
    bool economise(Point& point, MatrixXd& curvature) {
        // On a path where it takes many steps, towards a fold, the next target may go on with it.
        const int most = careful_ ? 60 : 8;
        double bend = 1.0;  // miss after a step over the step's square
        double radius = first_radius, price = 0.0;
        for (int iteration = 0; iteration < most; ++iteration) {
            const VectorXd slope = point.place - preferred_;
            if (careful_ && point.at.stale > 0.0 && limb_.refresh(point.at)) describe(point);
            const auto quadratic_step = [&] {
                return bounded_quadratic(curvature, slope, point.by_place, -point.error, lower_step(point, radius),
                                         upper_step(point, radius));
            };
            VectorXd step = quadratic_step();
            VectorXd left = point.error + point.by_place * step;
            if (before_) {
                // From target to target: both ends are exact postures, and the multipliers hardly change.
                before_->gap = point.gap;
                differentiate(*before_);
                learn(point, *before_, target_weight * target_weight * left, curvature);
                before_.reset();
                step = quadratic_step();
                left = point.error + point.by_place * step;
            }
            const double size = largest_of(step);
            const bool closes = left.norm() <= 1e-2 * point.miss + 1e-9;
            if (!closes && size < 0.9 * radius) return false;  // the bounds keep it from the target
            if (closes && size <= last_step_ && bend * size * size + point.at.doubt <= 0.5 * settings_.tolerance) {
                point.at.shape = limb_.predicted(point.at, unit_ * step);
                point.place = inside(point.place + step);
                return true;
            }
            const VectorXd multipliers = target_weight * target_weight * left;
            if (closes) price = std::max(price, 2.0 * multipliers.norm());
            const double promised =
                -slope.dot(step) - 0.5 * step.dot(curvature * step) + price * (point.miss - left.norm());
            std::optional<Point> next = stepped(point, step);
            if (next) bend = next->miss / (size * size);
            // Towards a fold postures change as a square root: what is least there is least where the limb snaps.
            constexpr double of_a_fold = 20.0;
            if (next && bend > of_a_fold && size < 0.1 &&
                next->miss > 0.05 * size + 10.0 * (next->at.doubt + point.at.doubt))
                return false;
            // What a doubt may hide is no loss.
            const auto gained = [&](const Point& to) {
                return effort(point) - effort(to) + price * (point.miss - to.miss + to.at.doubt + point.at.doubt);
            };
            if (next && !(gained(*next) > 0.1 * promised)) {
                // Along a curved set of pressures a straight step misses the target by its square: back to it first.
                std::optional<Point> back = stepped(*next, back_to_target(*next));
                if (back) next = std::move(back);
            }
            if (!next || !(gained(*next) > 0.1 * promised)) {
                radius = 0.3 * size;
                if (radius < smallest_radius) return false;
                continue;
            }
            if (careful_ && next->at.stale > 0.0 && limb_.refresh(next->at)) describe(*next);
            if (closes) learn(*next, point, multipliers, curvature);
            if (gained(*next) > 0.75 * promised && size > 0.9 * radius) radius = std::min(2.0 * radius, 1.0);
            point = *std::move(next);
        }
        return false;
    }

    double effort(const Point& point) const { return 0.5 * (point.place - preferred_).squaredNorm(); }

    /// Powell's damped update of the Lagrangian's curvature.
    static void learn(const Point& to, const Point& from, const VectorXd& multipliers, MatrixXd& curvature) {
        const VectorXd moved = to.place - from.place;
        // Derivatives taken far from their postures, beside the step between these, teach noise.
        if (std::max(to.at.stale, from.at.stale) > 0.02 * largest_of(moved)) return;
        VectorXd change = moved + (to.by_place - from.by_place).transpose() * multipliers;
        const VectorXd known = curvature * moved;
        const double square = moved.dot(known), along = moved.dot(change);
        if (!(square > 0.0)) return;
        if (along < 0.2 * square) {
            const double share = 0.8 * square / (square - along);
            change = share * change + (1.0 - share) * known;
        }
        curvature += change * change.transpose() / moved.dot(change) - known * known.transpose() / square;
    }

    static constexpr double first_radius = 0.3, smallest_radius = 1e-5;

    const Geometry& geometry_;
    const ReachTarget& target_;
    const ReachSettings& settings_;
    solve::Work work_;
    DrivenLimb limb_;
    Index count_;
    double unit_;
    VectorXd lower_, upper_, preferred_;
    VectorXd anchor_;         // where the start was
    double last_step_ = 0.0;  // of the preference: what is left after it is a part of it. On a path it may be larger
    std::vector<int> rows_;   // of the errors that count
    bool careful_ = true;     // about derivatives, in the search for the preference
    std::optional<Point> before_;  // where the search before this one started
    ReachMemory memory_;
    ReachSolution best_;
    int looks_ = 0, starts_ = 0;
};

}  // namespace

ReachSolution reach(const Geometry& geometry, const Scene& scene, const Actuation& actuation, const ReachTarget& target,
                    const ReachSettings& settings, const ReachStart* start) {
    return Search(geometry, scene, actuation, target, settings).run(start);
}

}  // namespace softlimb::limb
