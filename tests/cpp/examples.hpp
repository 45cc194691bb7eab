#pragma once
// Tubes, limbs and random numbers that several files use.
#include <memory>
#include <numbers>
#include <random>
#include <vector>

#include "softlimb/actuator/tube.hpp"
#include "softlimb/limb/posture.hpp"
#include "softlimb/limb/solver.hpp"

namespace softlimb::tests {

constexpr double kPa = 1e3, deg = std::numbers::pi / 180.0, pi = std::numbers::pi;

/// Seeded: every run draws the same numbers.
class Draw {
public:
    explicit Draw(unsigned seed) : generator_(seed) {}
    double operator()(double low = -1.0, double high = 1.0) { return low + (high - low) * uniform_(generator_); }
    template <class Matrix>
    Matrix matrix(double size = 1.0) {
        return Matrix::NullaryExpr([&] { return (*this)(-size, size); });
    }
    Vector3 direction() {
        Vector3 v;
        do v = matrix<Vector3>();
        while (v.norm() < 0.1);
        return v.normalized();
    }
    Pose pose(double angle) { return {matrix<Vector3>(), exp_so3(angle * direction())}; }

private:
    std::mt19937 generator_;
    std::uniform_real_distribution<double> uniform_{0.0, 1.0};
};

inline materials::AnyLaw dragon_skin() { return materials::Yeoh{.c1 = 86.1e3, .c2 = 13.6e3}; }
inline materials::AnyLaw smoothsil() { return materials::NeoHookean{.c1 = 340e3}; }

/// An actuator of the reference limb: core, and a skin with thread in two families.
inline actuator::Tube wound(double inner, double middle, double outer, double angle, double fraction,
                            const materials::AnyLaw& skin, const actuator::TubeOptions& options = {}) {
    using actuator::Fibres, actuator::Layer;
    constexpr double kevlar = 31.067e9;
    const std::vector<Fibres> pair = {Fibres::with_fraction(angle, kevlar, fraction),
                                      Fibres::with_fraction(-angle, kevlar, fraction)};
    return {0.2, {Layer::make(inner, middle, dragon_skin(), {}), Layer::make(middle, outer, skin, pair)}, options};
}
inline actuator::Tube proximal(const actuator::TubeOptions& options = {}) {
    return wound(0.018, 0.0205, 0.0215, 1.33 * deg, 0.0083, smoothsil(), options);
}
inline actuator::Tube middle_tube() { return wound(0.0135, 0.0154, 0.0161, 1.78 * deg, 0.0119, dragon_skin()); }
inline actuator::Tube distal() { return wound(0.009, 0.01025, 0.01075, 2.67 * deg, 0.0166, dragon_skin()); }
/// Silicone without fibres: balloons at 90.6 kPa.
inline actuator::Tube plain_tube() { return {0.2, {actuator::Layer::make(0.018, 0.0215, smoothsil(), {})}}; }
/// Two families that do not mirror each other: it twists.
inline actuator::Tube unequal(bool tension_only = false) {
    using actuator::Fibres, actuator::Layer;
    actuator::TubeOptions options;
    options.tension_only = tension_only;
    return {0.2,
            {Layer::make(0.018, 0.0205, dragon_skin(), {}),
             Layer::make(0.0205, 0.0215, smoothsil(),
                         {Fibres::with_stiffness(20 * deg, 2.5e8), Fibres::with_stiffness(-35 * deg, 1e8)})},
            options};
}

/// Rods on a ring, all along z.
inline limb::Segment ring(int count, double radius, double thickness, double mass) {
    limb::Segment segment;
    segment.plate_thickness = thickness, segment.plate_mass = mass;
    for (int i = 0; i < count; ++i) {
        const double angle = 2.0 * pi * i / count;
        const Pose at{Vector3(radius * std::cos(angle), radius * std::sin(angle), 0.0), Matrix3::Identity()};
        segment.rods.push_back({at, at});
    }
    return segment;
}

inline std::shared_ptr<limb::Geometry> geometry_of(std::vector<limb::Segment> segments, double rod_length) {
    auto geometry = std::make_shared<limb::Geometry>();
    geometry->segments = std::move(segments);
    geometry->length = rod_length * geometry->plates();
    for (int j = 0; j + 1 < geometry->plates(); ++j) geometry->length += geometry->segments[j].plate_thickness;
    return geometry;
}

/// A scene without loads and holds of rods that are all alike.
inline limb::Scene bare_scene(const limb::Geometry& geometry, const Section& section, double rest_length) {
    limb::Scene scene;
    scene.rods.assign(geometry.rods(), {section, rest_length, {}});
    scene.wrenches.assign(geometry.plates(), Vector6::Zero());
    scene.holds.assign(geometry.plates(), {});
    return scene;
}

/// The reference limb: three segments of three tubes.
struct Reference {
    std::vector<actuator::Tube> tubes = {proximal(), middle_tube(), distal()};
    std::shared_ptr<limb::Geometry> geometry =
        geometry_of({ring(3, 0.028, 0.025, 0.14), ring(3, 0.021, 0.025, 0.14), ring(3, 0.014, 0.025, 0.14)}, 0.2);

    limb::Scene scene(const std::vector<double>& pressures,
                      actuator::SectionModel model = actuator::SectionModel::tangent) const {
        limb::Scene made = bare_scene(*geometry, {}, 0.2);
        for (int i = 0; i < geometry->rods(); ++i) {
            const actuator::SectionAtPressure at = tubes[i / 3].section(pressures[i], model);
            made.rods[i].section = at.section, made.rods[i].rest_length = at.rest_length;
        }
        return made;
    }
};

inline const std::vector<double> complex_pressures = {90 * kPa, 60 * kPa, 30 * kPa, 60 * kPa, 40 * kPa,
                                                      20 * kPa, 50 * kPa, 50 * kPa, 50 * kPa};
inline const Vector3 hanging(0.0, 0.0, 9.81), standing(0.0, 0.0, -9.81);

inline const Reference& reference() {
    static const Reference limb;
    return limb;
}

inline limb::Scene complex_posture(const Vector3& gravity = hanging) {
    limb::Scene scene = reference().scene(complex_pressures);
    scene.gravity = gravity;
    return scene;
}

inline limb::Posture posture_of(const std::shared_ptr<limb::Geometry>& geometry, const limb::Scene& scene,
                                const limb::SolveOptions& options = {}, const limb::Shape* start = nullptr) {
    return {geometry, scene, limb::solve(*geometry, scene, options, start)};
}

inline Section soft_section() { return Section::make(400.0, 130.0, 0.08, 0.06, 0.4, 0.0, 0.0); }
/// With rest twist, coupling of extension and twist, and a curved axial law.
inline Section odd_section() {
    Section section = Section::make(400.0, 130.0, 0.08, 0.06, 0.4, 2.0, 0.05);
    section.axial_law.degree = 3;
    section.axial_law.centre = 1.0, section.axial_law.half_range = 30.0;
    section.axial_law.coefficient = {1.0 / 400.0, 2e-4, -1e-4, 5e-5};
    return section;
}

/// A pose after a small change (dp, dtheta) in base axes.
inline Pose moved(const Pose& pose, const Vector6& x) {
    return {pose.position + x.head<3>(), exp_so3(x.tail<3>()) * pose.rotation};
}

/// Runs once with each kernel that this machine can run.
template <class Run>
void with_every_instruction_set(Run&& run) {
    const std::string before = rod::lanes::kernel().instruction_set;
    for (const rod::lanes::Kernel* kernel : rod::lanes::kernels()) {
        rod::lanes::use(kernel->instruction_set);
        run();
    }
    rod::lanes::use(before);
}

}  // namespace softlimb::tests
