#include "softlimb/limb/path.hpp"

#include <algorithm>
#include <cmath>

#include "softlimb/limb/start.hpp"

namespace softlimb::limb {
namespace {

using solve::SolveStatus;

/// Direction of the path at a point: moves of the shape and of the parameter per arclength.
struct Tangent {
    Moves moves;
    double parameter = 1.0;
};

/// The same moves on a mesh whose pieces were split: linear between the nodes, wrenches as they are.
void split_moves(Moves& moves, std::size_t rod, int parts) {
    if (parts <= 1) return;
    const std::vector<Vector6>&nodes = moves.nodes[rod], &wrenches = moves.wrenches[rod];
    std::vector<Vector6> fine_nodes, fine_wrenches;
    for (std::size_t e = 0; e < wrenches.size(); ++e)
        for (int k = 0; k < parts; ++k) {
            const double share = static_cast<double>(k) / parts;
            fine_nodes.push_back((1.0 - share) * nodes[e] + share * nodes[e + 1]);
            fine_wrenches.push_back(wrenches[e]);
        }
    fine_nodes.push_back(nodes.back());
    moves.nodes[rod] = std::move(fine_nodes);
    moves.wrenches[rod] = std::move(fine_wrenches);
}

class Follower {
public:
    Follower(const Geometry& geometry, const SceneAt& scene_at, const Scene& first, const PathSettings& settings,
             solve::Work& work)
        : scene_at_(scene_at),
          settings_(settings),
          work_(work),
          range_(std::abs(settings.stop - settings.start)),
          scene_(first),
          equilibrium_(geometry, scene_) {}

    /// Equilibrium near a shape: in the plane across the tangent, or at the parameter itself without one. The tangent
    /// is brought onto the mesh of the answer.
    std::optional<PathPoint> correct(Shape shape, double parameter, Tangent* tangent, double tolerance) {
        Border border = border_at(parameter);
        if (!border.adjust(parameter)) return std::nullopt;
        std::vector<int> elements;
        for (const RodShape& rod : shape.rods) elements.push_back(rod.elements());
        choose_mesh(scene_, tolerance, shape);
        attach_rods(equilibrium_.geometry(), shape);
        if (tangent) {
            for (std::size_t i = 0; i < elements.size(); ++i)
                split_moves(tangent->moves, i, shape.rods[i].elements() / elements[i]);
            border.tangent = &tangent->moves;
            border.parameter_tangent = tangent->parameter;
        }
        NewtonSettings newton;
        newton.tolerance = tolerance;
        newton.max_iterations = 12;  // a step that takes more is too long
        PathPoint point;
        point.report = equilibrium_.solve(shape, newton, work_, &border);
        if (point.report.status != SolveStatus::converged) return std::nullopt;
        point.parameter = border.parameter;
        point.shape = std::move(shape);
        return point;
    }

    /// Direction of the path at a point, its unstable modes counted and the slope of its parameter filled in. Turned
    /// the way `previous` goes, or towards growing parameter without one. False where the stiffness is singular.
    bool look_along(PathPoint& point, const Tangent* previous, Tangent& tangent) {
        Border border = border_at(point.parameter);
        if (!border.adjust(point.parameter)) return false;
        if (!equilibrium_.linearise_at(point.shape, point.report.neutral_mode)) return false;
        equilibrium_.judge(point.shape, point.report, 0.0);
        // Without a potential the symmetric part says nothing of what diverges; a definite one only that nothing does.
        if (!scene_.conservative() && point.report.plate_modes > 0)
            point.report.plate_modes = equilibrium_.diverging_modes();
        tangent.moves = equilibrium_.response_to_parameter(point.shape, border);
        tangent.parameter = 1.0;
        const double norm = std::sqrt(product(tangent, tangent));
        const double sign = previous && product(*previous, tangent) < 0.0 ? -1.0 : 1.0;
        if (!std::isfinite(norm)) return false;
        tangent.moves *= sign / norm;
        point.slope = tangent.parameter = sign / norm;
        return true;
    }

    double product(const Tangent& a, const Tangent& b) const {
        return inner_product(a.moves, b.moves, equilibrium_.geometry().length) +
               a.parameter * b.parameter / (range_ * range_);
    }

    Shape predicted(const PathPoint& point, const Tangent& tangent, double step) const {
        Shape shape = point.shape;
        apply(equilibrium_.geometry(), tangent.moves, step, shape);
        return shape;
    }

    /// Point and direction a step along from a point; false when Newton or the mesh does not get there.
    bool step_from(const PathPoint& point, const Tangent& tangent, double step, double tolerance, PathPoint& next,
                   Tangent& ahead) {
        Tangent plane = tangent;
        std::optional<PathPoint> found =
            correct(predicted(point, tangent, step), point.parameter + step * tangent.parameter, &plane, tolerance);
        if (!found || !look_along(*found, &plane, ahead)) return false;
        next = std::move(*found);
        next.arclength = point.arclength + step;
        turn_ = product(plane, ahead);
        return true;
    }

    /// The same to 1e-9, for events; where rounding does not allow that, to the tolerance of the path.
    bool step_sharply(const PathPoint& point, const Tangent& tangent, double step, PathPoint& next, Tangent& ahead) {
        const double sharp = std::min(settings_.tolerance, 1e-9);
        return step_from(point, tangent, step, sharp, next, ahead) ||
               step_from(point, tangent, step, settings_.tolerance, next, ahead);
    }

    /// Cosine of the angle that the path turned through in the last step.
    double turn() const { return turn_; }

    std::optional<PathPoint> fold(const PathPoint& point, const Tangent& tangent, const PathPoint& beyond);
    std::optional<PathPoint> bifurcation(const PathPoint& point, const Tangent& tangent, const PathPoint& beyond);
    /// The point at a value of the parameter between those of two neighbours.
    std::optional<PathPoint> between(const PathPoint& point, const Tangent& tangent, const PathPoint& beyond,
                                     double parameter);
    /// Adds the event between the path's last point and the next one, if there is one.
    void locate(Path& path, const Tangent& tangent, const PathPoint& next);

private:
    Border border_at(double parameter) {
        // A ten-thousandth of the range: scenes are smooth on it, and its difference keeps eleven digits.
        const double span = 1e-4 * range_;
        Border border;
        border.range = range_;
        border.parameter = parameter;
        border.adjust = [this](double value) {
            std::optional<Scene> scene = scene_at_(value);
            if (!scene) return false;
            scene_ = std::move(*scene);
            return true;
        };
        std::optional<Scene> before = scene_at_(parameter - 0.5 * span), after = scene_at_(parameter + 0.5 * span);
        border.span = before && after ? span : 0.5 * span;
        // At the edge of where the scene exists one side does.
        if (!before) before = scene_at_(parameter);
        if (!after) after = scene_at_(parameter);
        if (before && after) border.before = std::move(*before), border.after = std::move(*after);
        return border;
    }

    const SceneAt& scene_at_;
    const PathSettings& settings_;
    solve::Work& work_;
    const double range_;
    Scene scene_;
    Equilibrium equilibrium_;
    double turn_ = 1.0;
};

std::optional<PathPoint> Follower::fold(const PathPoint& point, const Tangent& tangent, const PathPoint& beyond) {
    // Root of the slope by false position (Illinois): the parameter's own error is the slope times the bracket, so the
    // last digits come for nothing.
    double low = 0.0, low_slope = point.slope;
    double high = beyond.arclength - point.arclength, high_slope = beyond.slope;
    std::optional<PathPoint> best;
    int last_side = 0;
    for (int round = 0; round < 40; ++round) {
        const double middle = (low * high_slope - high * low_slope) / (high_slope - low_slope);
        PathPoint at;
        Tangent ahead;
        if (!step_sharply(point, tangent, middle, at, ahead)) return std::nullopt;
        if (!best || std::abs(at.slope) < std::abs(best->slope)) best = at;
        if (std::abs(at.slope) * (high - low) < 1e-11 * range_) return best;
        // The end that stays twice in a row counts for half: without it false position creeps.
        if (at.slope * low_slope > 0.0) {
            low = middle, low_slope = at.slope;
            if (last_side < 0) high_slope *= 0.5;
            last_side = -1;
        } else {
            high = middle, high_slope = at.slope;
            if (last_side > 0) low_slope *= 0.5;
            last_side = 1;
        }
    }
    return best;
}

std::optional<PathPoint> Follower::between(const PathPoint& point, const Tangent& tangent, const PathPoint& beyond,
                                           double parameter) {
    // False position along the arclength until Newton at the parameter itself is a small step.
    constexpr double near = 1e-2;
    double low = 0.0, low_gap = point.parameter - parameter;
    double high = beyond.arclength - point.arclength, high_gap = beyond.parameter - parameter;
    if (low_gap * high_gap > 0.0) return std::nullopt;
    for (int round = 0; round < 40; ++round) {
        const double middle = high_gap == low_gap ? 0.0 : (low * high_gap - high * low_gap) / (high_gap - low_gap);
        PathPoint at;
        Tangent ahead;
        if (!step_from(point, tangent, middle, settings_.tolerance, at, ahead)) return std::nullopt;
        const double gap = at.parameter - parameter;
        // Beside a fold the two branches are as far apart as the square of the slope.
        const double slope = std::min(1.0, std::abs(at.slope) / range_);
        if (std::abs(gap) < near * range_ * slope * slope) {
            std::optional<PathPoint> found = correct(at.shape, parameter, nullptr, settings_.tolerance);
            Tangent there;
            if (!found || !look_along(*found, &ahead, there)) return std::nullopt;
            found->arclength = at.arclength - gap / at.slope;
            return found;
        }
        (gap * low_gap > 0.0 ? low : high) = middle;
        (gap * low_gap > 0.0 ? low_gap : high_gap) = gap;
    }
    return std::nullopt;
}

void Follower::locate(Path& path, const Tangent& tangent, const PathPoint& next) {
    const PathPoint& here = path.points.back();
    const int after = static_cast<int>(path.points.size()) - 1;
    const bool turned = next.slope * here.slope < 0.0, changed = next.modes() != here.modes();
    if (!turned && !changed) return;
    // The parameter turns at a pitchfork as well, met on its bent branch; but there both sides are alike.
    std::optional<PathPoint> at = turned ? fold(here, tangent, next) : bifurcation(here, tangent, next);
    if (!at) return;
    // At the event itself one eigenvalue is zero, and rounding would choose its sign: it counts as unstable.
    at->report.plate_modes = std::max({1, here.modes(), next.modes()});
    at->report.rod_modes = 0;
    path.events.push_back({turned && changed ? EventKind::fold : EventKind::bifurcation, after, std::move(*at)});
}

std::optional<PathPoint> Follower::bifurcation(const PathPoint& point, const Tangent& tangent,
                                               const PathPoint& beyond) {
    double low = 0.0, high = beyond.arclength - point.arclength;
    std::optional<PathPoint> best;
    while (high - low > 1e-9) {
        const double middle = 0.5 * (low + high);
        PathPoint at;
        Tangent ahead;
        if (!step_sharply(point, tangent, middle, at, ahead)) return std::nullopt;
        (at.modes() == point.modes() ? low : high) = middle;
        best = std::move(at);
    }
    return best;
}

}  // namespace

Path follow(const Geometry& geometry, const SceneAt& scene_at, const Shape& first, const PathSettings& settings,
            solve::Work& work) {
    constexpr double smallest_step = 1e-7;
    constexpr double sharpest_turn = 0.9;  // cosine: 26 degrees between two tangents
    Path path;
    const std::optional<Scene> first_scene = scene_at(settings.start);
    if (!first_scene) {
        path.end = PathEnd::no_scene;
        return path;
    }
    Follower follower(geometry, scene_at, *first_scene, settings, work);
    std::optional<PathPoint> found = follower.correct(first, settings.start, nullptr, settings.tolerance);
    Tangent tangent;
    if (!found || !follower.look_along(*found, nullptr, tangent)) return path;
    if (settings.stop < settings.start) {
        tangent.moves *= -1.0;
        found->slope = tangent.parameter = -tangent.parameter;
    }
    path.points.push_back(std::move(*found));

    const double low = std::min(settings.start, settings.stop), high = std::max(settings.start, settings.stop);
    double step = settings.first_step;
    while (static_cast<int>(path.points.size()) < settings.max_points && !work.exhausted()) {
        const PathPoint& here = path.points.back();
        PathPoint next;
        Tangent ahead;
        std::optional<PathEnd> arrived;
        bool done =
            follower.step_from(here, tangent, step, settings.tolerance, next, ahead) && follower.turn() > sharpest_turn;
        if (done && (next.parameter > high || next.parameter < low)) {
            const double end = next.parameter > high ? high : low;
            std::optional<PathPoint> last = follower.between(here, tangent, next, end);
            done = last.has_value();
            if (done) next = std::move(*last);
            arrived = end == settings.stop ? PathEnd::stop : PathEnd::start;
        }
        if (!done) {
            step *= 0.4;
            if (step > smallest_step) continue;
            // Where the scene itself ends, as at a tube's limit point, its slope has no bound just before.
            const double ahead_of_end = here.parameter + std::copysign(1e-3 * (high - low), tangent.parameter);
            path.end = scene_at(ahead_of_end) ? PathEnd::lost : PathEnd::no_scene;
            return path;
        }
        if (settings.locate) follower.locate(path, tangent, next);
        const int iterations = next.report.iterations;
        path.points.push_back(std::move(next));
        if (!settings.through_events && !path.events.empty()) {
            path.end = PathEnd::event;
            return path;
        }
        if (arrived) {
            path.end = *arrived;
            return path;
        }
        tangent = std::move(ahead);
        // Next step: longer where Newton was quick, and so that the path turns by about half of what is allowed.
        const double angle = std::acos(std::min(1.0, follower.turn())), aim = 0.5 * std::acos(sharpest_turn);
        double change = std::clamp(aim / std::max(angle, 1e-3), 0.5, iterations <= 3 ? 1.6 : 1.0);
        if (iterations >= 6) change = std::min(change, 0.6);
        step = std::min(change * step, settings.largest_step);
    }
    path.end = PathEnd::max_points;
    return path;
}

std::optional<PathPoint> point_between(const Geometry& geometry, const SceneAt& scene_at, const PathPoint& before,
                                       const PathPoint& after, double parameter, const PathSettings& settings,
                                       solve::Work& work) {
    const std::optional<Scene> scene = scene_at(before.parameter);
    if (!scene) return std::nullopt;
    Follower follower(geometry, scene_at, *scene, settings, work);
    PathPoint here = before;
    Tangent tangent;
    if (!follower.look_along(here, nullptr, tangent)) return std::nullopt;
    if (before.slope < 0.0) {
        tangent.moves *= -1.0;
        here.slope = tangent.parameter = -tangent.parameter;
    }
    return follower.between(here, tangent, after, parameter);
}

}  // namespace softlimb::limb
