#pragma once
// From a far start to the neighbourhood of a stable equilibrium: a trust-region descent of the potential energy of the
// limb discretised by geodesic elements, with the exact Hessian. Where no potential exists (dead moments, following
// wrenches) the work of the loads along each step takes its place. Source: cpp/MECHANICS.md, "Descent".
#include <optional>

#include "softlimb/limb/balance.hpp"
#include "softlimb/limb/moves.hpp"
#include "softlimb/limb/scene.hpp"
#include "softlimb/solve/room.hpp"
#include "softlimb/solve/status.hpp"
#include "softlimb/solve/work.hpp"

namespace softlimb::limb {

struct DescentSettings {
    int max_iterations = 300;
    double radius = 0.5;  // first bound on a step: rotation [rad], translation in units of half a rod
    double largest_radius = 2.0;
    double hand_over = 1e-3;     // a full Newton step below this ends the descent: the exact solver takes over
    double small_step = 1e-3;    // a step below this that needs a multiplier is one around an unstable equilibrium
    double largest_angle = 1.2;  // [rad] an element that bends further asks for a finer mesh
};

/// An unstable equilibrium of the mesh and the valleys on its two sides: where a descent starts that goes down to each.
struct Ridge {
    Shape top;
    std::optional<Shape> taken, other;
};

struct DescentReport {
    solve::SolveStatus status = solve::SolveStatus::max_iterations;
    bool needs_refinement = false;  // stopped because an element bent too far
    std::optional<Ridge> ridge;     // the first unstable equilibrium of the mesh that was left downhill, if one was
    int iterations = 0, factorisations = 0;
    double energy = 0.0;
};

/// What a descent works in, handed from one to the next on a thread.
struct DescentRoom {
    std::vector<Section> sections_;  // as the descent sees them, see `softened`
    std::vector<rod::Chain> chains_;
    std::vector<rod::lanes::Geodesic> lanes_;
    std::vector<rod::lanes::GeodesicEnd> lane_ends_;
    std::vector<Vector6> twists_, trial_twists_;  // of the elements of the shape at hand and of the one tried
    Balance balance_;
    Moves moves_;
    std::vector<Vector6> node_metric_, plate_metric_;  // by rod and by plate
};

class Descent : private solve::Room<DescentRoom> {
public:
    Descent(const Geometry& geometry, const Scene& scene, solve::Work& work)
        : geometry_(geometry), scene_(scene), work_(work) {}
    /// Moves `shape` downhill. Element counts stay as they are.
    DescentReport run(Shape& shape, const DescentSettings& settings);
    /// Both sides of an unstable equilibrium that is known from elsewhere, for instance that of the exact rods.
    Ridge sides_of(const Shape& top);

private:
    void resize(const Shape& shape);
    /// Twists of all elements of the shape, and from them its energy.
    double measure(const Shape& shape, std::vector<Vector6>& twists) const;
    /// Forces and stiffness of all elements of a shape with these twists; false when not finite.
    bool linearise(const Shape& shape, const std::vector<Vector6>& twists);
    bool factor(const Shape& shape, double multiplier);  // false when the shifted Hessian is not positive definite
    void solve_for_step(const Shape& shape);
    void solve_for_unstable_mode(const Shape& shape);
    /// Goes down from an unstable equilibrium along the mode at hand, on both sides where both lead lower.
    Ridge leave_along_mode(const Shape& top, double top_energy, double multiplier);
    /// Newton step at a shape, shifted by at least `multiplier` and as much more as makes it convex and short enough.
    bool step_within(const Shape& shape, double multiplier, double radius);
    double step_size(const Shape& shape) const;
    double slope_along_step(const Shape& shape) const;
    double metric_norm_squared() const;
    void take_step(const Shape& from, Shape& to) const;
    double work_on_step(const Shape& from, const Shape& to) const;

    const Geometry& geometry_;
    const Scene& scene_;
    solve::Work& work_;
    long elements_ = 0;
    bool assembled_ = false;  // the balance belongs to the elements at hand
    double length_scale_ = 1.0;
};

}  // namespace softlimb::limb
