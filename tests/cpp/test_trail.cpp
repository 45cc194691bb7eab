// Where the solved rows of an ordered sweep lead the next one.
#include "check.hpp"
#include "examples.hpp"
#include "softlimb/limb/start.hpp"
#include "softlimb/sweep/trail.hpp"

using namespace softlimb;
using namespace softlimb::limb;
using namespace softlimb::tests;

namespace {

constexpr double length = 0.2;

std::shared_ptr<Geometry> one_segment() { return geometry_of({ring(1, 0.0, 0.0, 0.0)}, length); }

/// A rod whose plate has moved and turned, and whose wrench has grown, as parabolas of x.
Shape shape_at(const Geometry& geometry, double x, int elements = 1) {
    Scene scene = bare_scene(geometry, Section::make(60.0, 20.0, 0.003, 0.002, 0.1, 0.0, 0.0), length);
    const Pose plate{Vector3(0.01 * x, 0.002 * x * x, length), exp_so3(Vector3(0.0, 0.1 * x + 0.02 * x * x, 0.0))};
    Shape shape = geodesic_shape(geometry, scene, {plate}, elements);
    for (Vector6& wrench : shape.rods[0].wrenches) wrench.setConstant(1.0 + x - 3.0 * x * x);
    return shape;
}

void check_same(const Shape& found, const Shape& expected) {
    // Rounding of the poses, grown by weights of three.
    constexpr double rounding = 1e-14;
    CHECK_NEAR(found.plates[0].position, expected.plates[0].position, rounding);
    CHECK_NEAR(found.plates[0].rotation, expected.plates[0].rotation, rounding);
    CHECK_NEAR(found.rods[0].wrenches[0], expected.rods[0].wrenches[0], 100.0 * rounding);
}

}  // namespace

CLAIM(rows_along_a_line_lead_the_next_by_a_parabola) {
    const auto geometry = one_segment();
    sweep::ShapeTrail trail(2);
    // Rows of different distances, and not in their order.
    const std::vector<std::array<double, 2>> rows = {{1.0, 2.0}, {3.0, 2.0}, {2.2, 2.0}};
    for (const auto& row : rows) trail.add(row.data(), shape_at(*geometry, row[0]));
    const std::array<double, 2> next = {3.7, 2.0};
    check_same(*trail.start(*geometry, next.data()), shape_at(*geometry, 3.7));
}

CLAIM(a_row_without_others_behind_it_starts_where_the_nearest_is) {
    const auto geometry = one_segment();
    sweep::ShapeTrail trail(2);
    const std::array<double, 2> here = {1.0, 0.0}, there = {5.0, 0.0}, aside = {1.5, 1.0}, between = {2.0, 0.0};
    CHECK(trail.start(*geometry, here.data()) == nullptr);
    trail.add(here.data(), shape_at(*geometry, 1.0));
    trail.add(there.data(), shape_at(*geometry, 5.0));
    // Aside of the line; and between two rows, where none lies behind the nearest.
    check_same(*trail.start(*geometry, aside.data()), shape_at(*geometry, 1.0));
    check_same(*trail.start(*geometry, between.data()), shape_at(*geometry, 1.0));
    // Once more to where a row was: its own shape, not one that leads on from it.
    check_same(*trail.start(*geometry, there.data()), shape_at(*geometry, 5.0));
    trail.clear();
    CHECK(trail.start(*geometry, here.data()) == nullptr);
}

CLAIM(two_rows_lead_straight_on_and_other_meshes_do_not_lead) {
    const auto geometry = one_segment();
    const std::array<double, 2> first = {0.0, 0.0}, second = {1.0, 1.0}, next = {2.0, 2.0};
    sweep::ShapeTrail trail(2);
    trail.add(first.data(), shape_at(*geometry, 0.0));
    trail.add(second.data(), shape_at(*geometry, 1.0));
    const Shape straight = *trail.start(*geometry, next.data());
    const Pose last = shape_at(*geometry, 1.0).plates[0];
    CHECK_NEAR(straight.plates[0].position, Vector3(2.0 * last.position - Vector3(0.0, 0.0, length)), 1e-14);
    CHECK_NEAR(straight.plates[0].rotation, Matrix3(last.rotation * last.rotation), 1e-14);
    trail.clear();
    trail.add(first.data(), shape_at(*geometry, 0.0, 2));
    trail.add(second.data(), shape_at(*geometry, 1.0));
    check_same(*trail.start(*geometry, next.data()), shape_at(*geometry, 1.0));
}

CLAIM(a_rod_near_the_edge_of_a_piece_keeps_its_mesh_from_solve_to_solve) {
    // Along these pressures a rod's activity stays near what one piece may have: as one piece it asked for two, and as
    // two for one, so that no row had the mesh of the row before it.
    Shape before;
    int changes = 0;
    for (int k = 0; k < 12; ++k) {
        Scene scene = reference().scene({30e3, 20e3, 0.0, 0.0, 20e3, 0.0, 1.3e3 * k, 20e3, 0.0});
        scene.gravity = hanging;
        scene.wrenches.back().head<3>() = Vector3(0.2, 0.1, 0.0);
        const Posture posture = posture_of(reference().geometry, scene, {}, k > 0 ? &before : nullptr);
        CHECK(posture.solution.status == solve::SolveStatus::converged);
        const Shape& shape = posture.solution.shape;
        for (std::size_t i = 0; k > 1 && i < shape.rods.size(); ++i)
            changes += shape.rods[i].elements() != before.rods[i].elements();
        before = shape;
    }
    // A rod may pass the edge once on the way.
    CHECK(changes <= 3);
}
