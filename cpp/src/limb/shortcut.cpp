#include "softlimb/limb/shortcut.hpp"

#include <algorithm>

namespace softlimb::limb {
namespace {

bool has_loads_at_plates(const Scene& scene) {
    return std::any_of(scene.wrenches.begin(), scene.wrenches.end(), [](const Vector6& w) { return !w.isZero(0.0); }) ||
           scene.holds_plates();
}

/// A segment as a limb of its own, at its pressures.
struct Part {
    Geometry geometry;
    Scene scene;
};

Part part_of(const Geometry& geometry, const Scene& scene, int j, int first) {
    Part part;
    const auto count = static_cast<std::ptrdiff_t>(geometry.segments[j].rods.size());
    part.geometry.segments = {geometry.segments[j]};
    part.scene.rods.assign(scene.rods.begin() + first, scene.rods.begin() + first + count);
    for (const RodAtPressure& rod : part.scene.rods)
        part.geometry.length = std::max(part.geometry.length, rod.rest_length);
    part.scene.wrenches.assign(1, Vector6::Zero());
    part.scene.holds.resize(1);
    return part;
}

bool same(const Part& a, const Part& b) {
    return a.geometry.segments[0].rods == b.geometry.segments[0].rods &&
           std::equal(a.scene.rods.begin(), a.scene.rods.end(), b.scene.rods.begin(), b.scene.rods.end(),
                      [](const RodAtPressure& x, const RodAtPressure& y) {
                          return x.section == y.section && x.rest_length == y.rest_length;
                      });
}

/// Stretched length of a rod under an axial force that falls linearly along it.
double stretched(const RodAtPressure& rod, double base_force, double line_force) {
    // Five Gauss points: exact for a strain that is a polynomial of degree nine in the force.
    constexpr double at[] = {0.0, 0.5384693101056831, 0.9061798459386640};
    constexpr double weight[] = {0.5688888888888889, 0.4786286704993665, 0.2369268850561891};
    double sum = 0.0;
    for (int i = 0; i < 3; ++i)
        for (const double x : {at[i], -at[i]}) {
            double strain, compliance;
            axial_strain(rod.section.axial_law, base_force - 0.5 * (1.0 + x) * rod.rest_length * line_force, strain,
                         compliance);
            sum += (i == 0 ? 0.25 : 0.5) * weight[i] * (1.0 + strain);
        }
    return rod.rest_length * sum;
}

bool along_z(const Vector3& v) { return v.x() == 0.0 && v.y() == 0.0; }

/// Equal rods along z, centred on the axis: what keeps a segment straight under a load along it.
bool straight_when_pulled(const Segment& segment, const RodAtPressure* rods) {
    Vector3 sum = Vector3::Zero();
    double reach = 0.0;
    for (std::size_t k = 0; k < segment.rods.size(); ++k) {
        const Placement& place = segment.rods[k];
        const RodAtPressure& rod = rods[k];
        if (!place.base.rotation.isIdentity(0.0) || !(place.base == place.end) || place.base.position.z() != 0.0)
            return false;
        if (!(rod.section == rods[0].section) || rod.rest_length != rods[0].rest_length || !is_zero(rod.line_load))
            return false;
        sum += place.base.position;
        reach = std::max(reach, place.base.position.norm());
    }
    return rods[0].section.rest_twist == 0.0 && rods[0].section.extension_twist == 0.0 && sum.norm() <= 1e-12 * reach;
}

}  // namespace

bool unloaded(const Geometry& geometry, const Scene& scene) {
    const bool heavy_plates =
        !scene.gravity.isZero(0.0) && std::any_of(geometry.segments.begin(), geometry.segments.end(),
                                                  [](const Segment& segment) { return segment.plate_mass > 0.0; });
    return !heavy_plates && !has_loads_at_plates(scene) && !scene.loads_rods();
}

std::optional<Solution> solve_apart(
    const Geometry& geometry, const Scene& scene, const SolveOptions& options,
    const std::function<Solution(const Geometry&, const Scene&, const SolveOptions&)>& solve_segment) {
    const int plates = geometry.plates();
    SolveOptions each = options;
    each.tolerance = options.tolerance / plates;  // the errors of the segments add up at the tip
    Solution whole;
    whole.status = solve::SolveStatus::converged;
    whole.message = "converged";
    whole.stable = true;
    whole.unstable_modes = 0;
    whole.reactions.assign(plates, Vector6::Zero());
    Part before;
    Solution segment;
    bool solved_once = false;
    int first = 0;
    for (int j = 0; j < plates; ++j) {
        Part part = part_of(geometry, scene, j, first);
        if (j > 0 && same(part, before)) {
            solved_once = true;
        } else {
            segment = solve_segment(part.geometry, part.scene, each);
            whole.iterations += segment.iterations;
            whole.descent_iterations += segment.descent_iterations;
        }
        if (segment.status != solve::SolveStatus::converged || !segment.unstable_modes) return std::nullopt;
        whole.residual = std::max(whole.residual, segment.residual);
        whole.error_estimate += segment.error_estimate;
        whole.stable = whole.stable && segment.stable;
        *whole.unstable_modes += *segment.unstable_modes;
        if (segment.message != "converged") whole.message = segment.message;
        if (j == 0) whole.base_wrench = segment.base_wrench;
        const Pose footing = geometry.footing(j, whole.shape.plates);
        whole.shape.plates.push_back(footing * segment.shape.plates[0]);
        for (RodShape rod : segment.shape.rods) {
            for (Pose& node : rod.nodes) node = footing * node;
            for (Vector6& w : rod.wrenches)
                w << footing.rotation * w.head<3>().eval(), footing.rotation * w.tail<3>().eval();
            whole.shape.rods.push_back(std::move(rod));
        }
        first += static_cast<int>(part.scene.rods.size());
        before = std::move(part);
    }
    whole.plan = std::move(segment.plan);
    whole.plan.push_back("no loads: the segments were solved one by one");
    if (solved_once) whole.plan.push_back("equal segments at equal pressures were solved once");
    return whole;
}

std::optional<Shape> straight_shape(const Geometry& geometry, const Scene& scene) {
    if (!along_z(scene.gravity) || scene.following) return std::nullopt;
    for (const Vector6& w : scene.wrenches)
        if (!along_z(w.head<3>()) || !w.tail<3>().isZero(0.0)) return std::nullopt;
    if (scene.holds_plates()) return std::nullopt;
    int first = 0;
    for (const Segment& segment : geometry.segments) {
        if (!straight_when_pulled(segment, scene.rods.data() + first)) return std::nullopt;
        first += static_cast<int>(segment.rods.size());
    }
    // From the tip down: what each segment's rods carry at their base.
    const int plates = geometry.plates();
    std::vector<double> base_force(plates);
    double above = 0.0;
    for (int j = plates; j-- > 0;) {
        const Segment& segment = geometry.segments[j];
        const auto count = static_cast<int>(segment.rods.size());
        first -= count;
        const double weight = scene.line_load(first).force.z * scene.rods[first].rest_length;
        above += scene.wrenches[j].z() + segment.plate_mass * scene.gravity.z() + count * weight;
        base_force[j] = above / count;
    }
    Shape shape;
    for (int j = 0; j < plates; ++j) {
        const Pose footing = geometry.footing(j, shape.plates);
        const std::vector<Placement>& rods = geometry.segments[j].rods;
        const double length = stretched(scene.rods[first], base_force[j], scene.line_load(first).force.z);
        shape.plates.push_back({footing.position + Vector3(0.0, 0.0, length), Matrix3::Identity()});
        Vector6 wrench = Vector6::Zero();
        wrench(2) = base_force[j];
        for (const Placement& place : rods) {
            RodShape rod;
            rod.nodes = {footing * place.base, shape.plates.back() * place.end};
            rod.wrenches = {wrench};
            shape.rods.push_back(std::move(rod));
        }
        first += static_cast<int>(rods.size());
    }
    return shape;
}

}  // namespace softlimb::limb
