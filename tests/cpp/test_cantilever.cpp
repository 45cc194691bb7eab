#include "check.hpp"
#include "examples.hpp"
#include "softlimb/limb/attempt.hpp"
#include "softlimb/limb/cantilever.hpp"
#include "softlimb/limb/start.hpp"

namespace {

using namespace softlimb;
using namespace softlimb::limb;
using namespace softlimb::tests;

constexpr double length = 0.3;

/// One rod, clamped anyhow, of the soft rod that the benchmark bends (EI 7.9e-3 N m^2), in units of whose EI/l^2 the
/// loads come.
struct Rod {
    explicit Rod(const Pose& base = {}) {
        Segment segment;
        segment.rods.push_back({base, {}});
        geometry = geometry_of({segment}, length);
        scene = bare_scene(*geometry, Section::make(314.0, 101.0, 7.85e-3, 5.2e-3, 0.31, 0.0, 0.0), length);
    }
    std::optional<Solution> shot(double tolerance) const {
        SolveOptions options;
        options.tolerance = tolerance;
        return solve_cantilever(*geometry, scene, options);
    }

    std::shared_ptr<Geometry> geometry;
    Scene scene;
    const double unit = 7.85e-3 / (length * length);
};

/// The plain version: descent from constant curvature on a mesh, then Newton on exact pieces.
Attempt descended(const Rod& rod) {
    SolveOptions options;
    options.tolerance = 1e-11;
    solve::Work work(1'000'000, {});
    Equilibrium equilibrium(*rod.geometry, rod.scene);
    Shape shape = geodesic_shape(*rod.geometry, rod.scene, constant_curvature_plates(*rod.geometry, rod.scene), 1);
    int ignored = 0;
    return attempt_on_mesh(rod.scene, options, work, equilibrium, 8, shape, ignored, ignored).attempt;
}

CLAIM(a_cantilever_shot_from_its_tip_is_where_the_descent_ends) {
    int shots = 0;
    for (unsigned seed = 0; seed < 60; ++seed) {
        Draw draw(seed);
        Rod rod(draw.pose(2.0));
        const Matrix3& base = rod.geometry->segments[0].rods[0].base.rotation;
        Vector3 force = draw.matrix<Vector3>(4.0);
        force.z() = draw(-0.5, 12.0);  // most pull
        rod.scene.wrenches[0].head<3>() = base * (rod.unit * force);
        rod.scene.gravity = draw(0.0, 9.81) * (base * Vector3(0.3, 0.0, 1.0));
        for (const double tolerance : {1e-4, 1e-6, 1e-8, 1e-10}) {
            const std::optional<Solution> found = rod.shot(tolerance);
            if (!found) continue;
            ++shots;
            const Attempt plain = descended(rod);
            CHECK(plain.stable() && found->stable && found->unstable_modes == 0);
            const Pose &tip = found->shape.plates[0], &expected = plain.shape.plates[0];
            CHECK_NEAR(tip.position, expected.position, tolerance * length);
            CHECK_NEAR(tip.rotation, expected.rotation, tolerance);
            CHECK(found->error_estimate <= tolerance && mesh_suffices(rod.scene, tolerance, found->shape));
            const Verification errors = verify({rod.geometry, rod.scene, *found});
            CHECK(errors.position_error <= tolerance && errors.rotation_error <= tolerance);
            CHECK(errors.force_error <= tolerance && errors.moment_error <= 5.0 * tolerance);  // as Newton's balances
        }
    }
    CHECK(shots > 120);
}

CLAIM(a_cantilever_that_is_pushed_or_turned_or_held_is_left_to_the_descent) {
    Rod pulled;
    pulled.scene.wrenches[0].head<3>() = pulled.unit * Vector3(1.0, 0.0, 2.0);
    CHECK(pulled.shot(1e-6).has_value());
    const auto refused = [&](auto&& change) {
        Rod rod = pulled;
        change(rod);
        CHECK(!rod.shot(1e-6).has_value());
    };
    refused([](Rod& rod) { rod.scene.wrenches[0].z() *= -1.0; });
    refused([](Rod& rod) { rod.scene.gravity = Vector3(0.0, 0.0, -30.0); });
    refused([](Rod& rod) { rod.scene.wrenches[0].tail<3>() = Vector3(0.0, 1e-3, 0.0); });
    refused([](Rod& rod) { rod.scene.following = true; });
    refused([](Rod& rod) { rod.scene.holds[0].held[0] = true; });
    refused([](Rod& rod) { rod.scene.rods[0].line_load.moment = {0.0, 1e-3, 0.0}; });
    refused([](Rod& rod) { rod.scene.rods[0].section.rest_twist = 1.0; });
    refused([](Rod& rod) { rod.scene.wrenches[0].x() = 0.0; });                   // straight, in closed form
    refused([](Rod& rod) { rod.scene.wrenches[0].head<3>() *= 1e4; });            // growth e^150
    refused([](Rod& rod) { rod.scene.rods[0].section.shear = 0.5 * rod.unit; });  // sheared by more than its length
    refused([](Rod& rod) { rod.scene.rods[0].section.axial_law.coefficient = {1.0 / rod.unit}; });
    refused([](Rod& rod) {  // the force leaves what the axial law is known for
        AxialLaw& law = rod.scene.rods[0].section.axial_law;
        law.degree = 1, law.half_range = rod.unit;
    });
    refused([](Rod& rod) {
        auto geometry = std::make_shared<Geometry>(*rod.geometry);
        geometry->segments[0].plate_mass = 0.1;
        rod.geometry = geometry, rod.scene.gravity = hanging;
    });
    refused([](Rod& rod) {
        auto geometry = std::make_shared<Geometry>(*rod.geometry);
        geometry->segments[0].rods[0].end.position.x() = 0.01;
        rod.geometry = geometry;
    });
}

}  // namespace
