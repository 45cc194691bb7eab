#pragma once
// Paths of equilibria: a posture followed while one parameter of its scene changes, through folds, by pseudo-arclength
// steps. Folds and bifurcations on the way are located. Source: cpp/MECHANICS.md, "Paths".
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "softlimb/limb/equilibrium.hpp"

namespace softlimb::limb {

/// The scene at a value of the parameter; none where it has none (a pressure at which a tube has no stable state).
using SceneAt = std::function<std::optional<Scene>(double)>;

struct PathSettings {
    double start = 0.0, stop = 1.0;  // of the parameter
    double tolerance = 1e-6;         // of every posture, relative to the limb's length
    // Arclength: root of the mean square moves of plates and nodes (limb lengths, radians) plus the square of the
    // parameter in units of |stop - start|.
    double first_step = 0.02, largest_step = 0.1;
    int max_points = 500;
    bool locate = true;          // events; without it the path is only a way to its end
    bool through_events = true;  // without it the path ends at its first fold or bifurcation
};

struct PathPoint {
    double parameter = 0.0, arclength = 0.0;
    double slope = 0.0;  // d parameter / d arclength: zero at a fold
    Shape shape;
    NewtonReport report;
    int modes() const { return report.plate_modes + report.rod_modes; }
};

enum class EventKind { fold, bifurcation };

struct PathEvent {
    EventKind kind;
    int after;  // it lies between points `after` and `after` + 1
    PathPoint point;
};

enum class PathEnd {
    stop,       // the parameter reached `stop`
    start,      // it came back to `start`: another posture of the first scene
    event,      // at its first fold or bifurcation, because it was not to go on
    no_scene,   // the scene does not exist beyond
    lost,       // no step is small enough
    max_points  // or the budget of work ran out
};

struct Path {
    std::vector<PathPoint> points;
    std::vector<PathEvent> events;
    PathEnd end = PathEnd::lost;
};

/// Follows the equilibrium `first` of the scene at `settings.start`, first towards `settings.stop`. Raises what
/// `scene_at` raises, and solve::Interrupted.
Path follow(const Geometry& geometry, const SceneAt& scene_at, const Shape& first, const PathSettings& settings,
            solve::Work& work);

/// Equilibrium on the path's segment after point `after` at a value of the parameter between its ends, or none.
std::optional<PathPoint> point_between(const Geometry& geometry, const SceneAt& scene_at, const PathPoint& before,
                                       const PathPoint& after, double parameter, const PathSettings& settings,
                                       solve::Work& work);

}  // namespace softlimb::limb
