// Whole solves: cold and warm, with and without a potential, held, hopeless, out of budget and interrupted.
#include <algorithm>
#include <functional>
#include <map>
#include <numeric>

#include "allocations.hpp"
#include "check.hpp"
#include "examples.hpp"
#include "same_bits.hpp"
#include "softlimb/limb/descent.hpp"
#include "softlimb/limb/equilibrium.hpp"
#include "softlimb/limb/start.hpp"

using namespace softlimb;
using namespace softlimb::limb;
using namespace softlimb::tests;
using solve::SolveStatus;

namespace {

/// Equilibrium, by the solver's own word and by the independent check.
void check_solved(const Posture& posture, double tolerance = 1e-6) {
    const Solution& solution = posture.solution;
    if (solution.status != SolveStatus::converged) std::fprintf(stderr, "%s\n", solution.message.c_str());
    CHECK(solution.status == SolveStatus::converged);
    const Verification found = verify(posture);
    // The tolerance bounds the tip's error; a residual may be ten times that, as `Verification.success` has it.
    CHECK_NEAR(found.position_error, 0.0, 10.0 * tolerance);
    CHECK_NEAR(found.rotation_error, 0.0, 10.0 * tolerance);
    CHECK_NEAR(found.force_error, 0.0, 10.0 * tolerance);
    CHECK_NEAR(found.moment_error, 0.0, 10.0 * tolerance);
    CHECK_NEAR(found.hold_error, 0.0, 10.0 * tolerance);
}

bool finite(const Shape& shape) {
    return std::all_of(shape.plates.begin(), shape.plates.end(), [](const Pose& pose) { return pose.finite(); });
}

std::shared_ptr<Geometry> thin_rod() { return geometry_of({ring(1, 0.0, 0.0, 0.0)}, 0.2); }
/// A thin rod that a moment winds up: thousands of evaluations for a few turns, the whole budget for hundreds.
Scene wound_up(const Geometry& geometry, double moment) {
    Scene scene = bare_scene(geometry, Section::make(60.0, 20.0, 0.003, 0.002, 0.1, 0.0, 0.0), 0.2);
    scene.wrenches.back()(3) = moment;
    return scene;
}

}  // namespace

CLAIM(the_hanging_reference_limb_is_solved_cold_for_every_section_model) {
    using enum actuator::SectionModel;
    for (const auto model : {tangent, nonlinear, paper}) {
        Scene scene = reference().scene(complex_pressures, model);
        scene.gravity = hanging;
        scene.wrenches.back() << 0.3, -0.2, 0.1, 0.0, 0.0, 0.0;
        const Posture posture = posture_of(reference().geometry, scene);
        check_solved(posture);
        CHECK(posture.solution.stable && posture.solution.unstable_modes == 0);
        // The ground carries plates, rods and the tip force.
        double weight = 0.0;
        for (const Segment& segment : reference().geometry->segments) weight += segment.plate_mass;
        for (const RodAtPressure& rod : scene.rods) weight += rod.section.mass_per_length * rod.rest_length;
        const Vector3 carried = weight * scene.gravity + scene.wrenches.back().head<3>();
        CHECK_NEAR(posture.solution.base_wrench.head<3>(), -carried, 1e-5 * carried.norm());
    }
}

CLAIM(a_warm_solve_finds_the_cold_answer_in_fewer_iterations) {
    const Scene scene = complex_posture();
    const Posture cold = posture_of(reference().geometry, scene);
    Scene near =
        reference().scene({85 * kPa, 60 * kPa, 30 * kPa, 60 * kPa, 45 * kPa, 20 * kPa, 50 * kPa, 50 * kPa, 45 * kPa});
    near.gravity = hanging;
    const Posture before = posture_of(reference().geometry, near);
    const Posture warm = posture_of(reference().geometry, scene, {}, &before.solution.shape);
    check_solved(warm);
    CHECK(warm.solution.descent_iterations == 0 && warm.solution.iterations <= cold.solution.iterations);
    const Pose &a = cold.solution.shape.plates.back(), &b = warm.solution.shape.plates.back();
    // Each within 1e-6 of the limb's length.
    CHECK_NEAR(a.position, b.position, 2e-6 * reference().geometry->length);
    const Shape from_plates = start_from_plates(*reference().geometry, scene, cold.solution.shape.plates);
    check_solved(posture_of(reference().geometry, scene, {}, &from_plates));
}

CLAIM(a_count_of_modes_before_the_last_steps_is_that_of_the_answer) {
    // Standing limbs near where they fall over, each from the posture before it: a warm solve counts with the stiffness
    // that its last steps reuse.
    const Geometry& geometry = *reference().geometry;
    Draw draw(63);
    int stable = 0, unstable = 0;
    for (int trial = 0; trial < 40; ++trial) {
        Scene scene = reference().scene(std::vector<double>(9, draw(0, 20 * kPa)));
        scene.gravity = standing;
        scene.wrenches.back().head<3>() = Vector3(0.01 * draw(), 0.01 * draw(), draw(-2.0, 2.0));
        const Solution before = posture_of(reference().geometry, scene, {.prefer_stable = false}).solution;
        scene.wrenches.back()(2) += 0.05 * draw();
        const Solution warm = posture_of(reference().geometry, scene, {.prefer_stable = false}, &before.shape).solution;
        if (before.status != SolveStatus::converged || warm.status != SolveStatus::converged) continue;
        Equilibrium fresh(geometry, scene);
        CHECK(fresh.linearise_at(warm.shape));
        NewtonReport report;
        fresh.judge(warm.shape, report, 0.0);
        CHECK(warm.unstable_modes == report.modes());
        (report.modes() == 0 ? stable : unstable) += 1;
    }
    CHECK(stable > 5 && unstable > 5);
}

CLAIM(a_mesh_that_is_chosen_anew_is_solved_on_before_it_is_an_answer) {
    // Rods under heavy loads of their own: pieces of a start far away are joined and found too long in turn.
    Draw draw(343);
    int solved = 0;
    for (int trial = 0; trial < 150; ++trial) {
        const auto geometry = geometry_of({ring(5, 0.03, 0.0, 0.0)}, 0.17);
        Scene scene = bare_scene(*geometry, Section::make(400.0, 130.0, 0.02, 0.015, 0.4, 0.0, 0.0), 0.17);
        const SolveOptions options{.tolerance = std::pow(10.0, draw(-8.0, -4.0)), .interrupted = {}};
        Posture at = posture_of(geometry, scene, options);
        for (int step = 0; step < 4 && at.solution.status == SolveStatus::converged; ++step) {
            for (RodAtPressure& rod : scene.rods) {
                const Vector3 force = draw.matrix<Vector3>(8.0);
                rod.line_load.force = {force.x(), force.y(), force.z()};
                rod.rest_length = 0.17 * (1.0 + 0.05 * draw());
            }
            scene.wrenches.back().head<3>() = draw.matrix<Vector3>(1.0);
            const Shape start = at.solution.shape;
            at = posture_of(geometry, scene, options, &start);
            if (at.solution.status != SolveStatus::converged) break;
            check_solved(at, options.tolerance);
            ++solved;
        }
    }
    CHECK(solved > 300);
}

CLAIM(a_mesh_leaves_no_pack_for_pieces_that_others_have_room_for) {
    Draw draw(64);
    for (int trial = 0; trial < 20; ++trial) {
        std::vector<double> pressures(9);
        for (double& p : pressures) p = draw(0, 80 * kPa);
        Scene scene = reference().scene(pressures);
        scene.gravity = hanging;
        for (const double tolerance : {1e-4, 1e-6, 1e-10}) {
            Shape shape = posture_of(reference().geometry, scene).solution.shape;
            choose_mesh(scene, tolerance, shape, warm_piece);
            CHECK(mesh_suffices(scene, tolerance, shape));
            std::map<int, std::vector<int>> pieces;  // of each rod, by its steps
            for (const RodShape& rod : shape.rods) pieces[rod.integration.steps].push_back(rod.elements());
            const auto sum = [](const std::vector<int>& v) { return std::accumulate(v.begin(), v.end(), 0); };
            // Any choice of rods that would empty a pack of eight and fit beside those of the next larger number.
            for (auto at = pieces.begin(), next = std::next(at); next != pieces.end(); at = next++)
                for (unsigned chosen = 0; chosen < 1u << at->second.size(); ++chosen) {
                    int moved = 0;
                    for (std::size_t i = 0; i < at->second.size(); ++i) moved += chosen >> i & 1u ? at->second[i] : 0;
                    const int beyond = sum(at->second) % 8, room = (8 - sum(next->second) % 8) % 8;
                    CHECK(beyond == 0 || moved < beyond || moved > room);
                }
        }
    }
}

CLAIM(once_warm_newton_and_the_descent_take_no_memory) {
    const Geometry& geometry = *reference().geometry;
    const Scene scene = complex_posture();
    const Shape coarse = geodesic_shape(geometry, scene, constant_curvature_plates(geometry, scene), 2);
    for (const double tolerance : {1e-3, 1e-6, 1e-9}) {
        // The first round finds out how much room there is to be, the second must find it there.
        for (const bool warm : {false, true}) {
            Shape shape = coarse;
            solve::Work work(1'000'000L, {});
            long before = allocations();
            const DescentReport descent = Descent(geometry, scene, work).run(shape, {});
            // The point that a descent tries is a shape of its own: plates, and nodes and wrenches of every rod.
            const long of_a_shape = 2 + 2 * static_cast<long>(shape.rods.size());
            if (warm) CHECK(allocations() - before <= of_a_shape);
            CHECK(descent.status == SolveStatus::converged && descent.iterations > 3);
            set_geodesic_wrenches(scene, shape, Stiffness::softened);
            choose_mesh(scene, tolerance, shape, warm_piece);
            Equilibrium equilibrium(geometry, scene);
            before = allocations();
            const NewtonReport newton = equilibrium.solve(shape, {.tolerance = tolerance}, work);
            if (warm) CHECK(allocations() == before);
            CHECK(newton.status == SolveStatus::converged && newton.iterations > 1);
        }
    }
}

CLAIM(the_standing_limb_leaves_its_unstable_posture_and_any_equilibrium_may_be_asked_for) {
    Scene scene = reference().scene(std::vector<double>(9, 20 * kPa));
    scene.gravity = standing;
    const Posture stable = posture_of(reference().geometry, scene);
    check_solved(stable);
    CHECK(stable.solution.stable);
    const Posture any = posture_of(reference().geometry, scene, {.prefer_stable = false});
    check_solved(any);
    CHECK(!any.solution.stable && any.solution.unstable_modes > 0);
}

CLAIM(tight_and_loose_tolerances_are_met) {
    for (const double tolerance : {1e-2, 1e-4, 1e-9, 1e-12}) {
        const Posture posture = posture_of(reference().geometry, complex_posture(), {.tolerance = tolerance});
        check_solved(posture, std::max(tolerance, 1e-11));  // rounding of the check itself
        CHECK(posture.solution.error_estimate <= tolerance);
    }
}

CLAIM(loads_without_a_potential_are_solved_and_said_to_have_none) {
    Scene dead_moment = complex_posture();
    dead_moment.wrenches.back()(4) = 0.1;
    Scene following = complex_posture(Vector3::Zero());
    following.following = true;
    following.wrenches[1] << 0.2, 0.0, 0.1, 0.0, 0.0, 0.02;
    following.wrenches[2] << 0.3, -0.1, 0.2, 0.01, 0.0, 0.0;
    Scene line_moment = complex_posture();
    line_moment.rods[4].line_load = {{0.5, 0.0, 0.0}, {0.0, 0.1, 0.05}};
    for (const Scene& scene : {dead_moment, following, line_moment}) {
        const Posture posture = posture_of(reference().geometry, scene);
        check_solved(posture);
        CHECK(!posture.solution.conservative && !posture.solution.unstable_modes.has_value());
    }
}

CLAIM(a_moment_winds_a_rod_into_turns_along_growing_loads) {
    const auto geometry = geometry_of({ring(1, 0.0, 0.0, 0.0)}, 0.2);
    Scene scene = bare_scene(*geometry, Section::make(60.0, 20.0, 0.003, 0.002, 0.1, 0.0, 0.0), 0.2);
    scene.wrenches.back()(3) = 2.0 * 2.0 * pi * 0.003 / 0.2;  // two turns: m l / EI = 4 pi
    const Posture posture = posture_of(geometry, scene);
    check_solved(posture);
    CHECK_NEAR(posture.solution.shape.plates.back().position, Vector3::Zero(), 1e-5 * 0.2);
}

CLAIM(held_plates_have_reactions_that_as_loads_give_the_same_posture) {
    const Posture free = posture_of(reference().geometry, complex_posture());
    const std::vector<std::array<bool, 6>> holds = {{true, true, true, true, true, true},
                                                    {true, true, true, false, false, false},
                                                    {false, false, false, true, false, false},
                                                    {true, false, false, false, true, true}};
    for (const auto& held : holds) {
        Scene scene = complex_posture();
        Hold& hold = scene.holds.back();
        hold.held = held;
        hold.pose = free.solution.shape.plates.back();
        hold.pose.position += Vector3(0.01, -0.02, 0.01);
        hold.pose.rotation = exp_so3(Vector3(0.1, 0.05, -0.1)) * hold.pose.rotation;
        const Posture posture = posture_of(reference().geometry, scene);
        check_solved(posture);
        Scene loaded = complex_posture();
        loaded.wrenches.back() = posture.solution.reactions.back();
        const Posture same =
            posture_of(reference().geometry, loaded, {.prefer_stable = false}, &posture.solution.shape);
        check_solved(same);
        // Compliance of a tip of about 0.1 m/N at most: a reaction to 1e-6 of ten newtons.
        CHECK_NEAR(same.solution.shape.plates.back().position, posture.solution.shape.plates.back().position, 1e-5);
    }
    Scene everywhere = complex_posture();
    for (int j = 0; j < 3; ++j)
        everywhere.holds[j] = {{true, true, true, true, true, true}, free.solution.shape.plates[j]};
    check_solved(posture_of(reference().geometry, everywhere));
}

CLAIM(six_rods_of_unequal_length_and_stiffness_are_solved) {
    Draw draw(30);
    auto geometry = geometry_of({ring(6, 0.03, 0.02, 0.1), ring(6, 0.02, 0.0, 0.0)}, 0.2);
    for (Segment& segment : geometry->segments)
        for (Placement& place : segment.rods) place.end.rotation = exp_so3(0.1 * draw.direction());
    Scene scene = bare_scene(*geometry, odd_section(), 0.2);
    for (RodAtPressure& rod : scene.rods) rod.rest_length *= draw(0.9, 1.1), rod.section.bending *= draw(0.5, 50.0);
    scene.gravity = Vector3(3.0, 2.0, 8.0);
    check_solved(posture_of(geometry, scene));
}

CLAIM(scenes_without_an_answer_end_with_a_status_and_a_point_to_look_at) {
    const auto geometry = thin_rod();
    const double nan = std::numeric_limits<double>::quiet_NaN(), infinite = std::numeric_limits<double>::infinity();
    std::vector<Scene> scenes;
    // Not one that uses up the whole budget: that takes half a minute here. Budgets have claims of their own below.
    const auto add = [&](const auto& change) {
        scenes.push_back(wound_up(*geometry, 0.0));
        change(scenes.back());
    };
    add([](Scene& scene) { scene.wrenches.back()(3) = 1e300; });
    add([](Scene& scene) { scene.wrenches.back()(0) = 1e4; });
    for (const double bad : {nan, infinite}) {
        add([&](Scene& scene) { scene.wrenches.back()(0) = bad; });
        add([&](Scene& scene) { scene.gravity.setConstant(bad); });
        add([&](Scene& scene) { scene.rods.front().line_load.force.x = bad; });
        add([&](Scene& scene) { scene.rods.front().section.bending = bad; });
    }
    add([](Scene& scene) {
        scene.holds.back() = {{true, true, true, true, true, true}, {Vector3(100.0, 0.0, 0.0), Matrix3::Identity()}};
    });
    for (const Scene& scene : scenes) {
        const Posture posture = posture_of(geometry, scene);
        CHECK(posture.solution.shape.plates.size() == 1 && posture.solution.reactions.size() == 1);
        CHECK(!posture.solution.message.empty());
        // Far beyond its section's range a rod still has a shape on paper: success may be claimed only if it is one.
        if (posture.solution.status == SolveStatus::converged)
            check_solved(posture);
        else
            static_cast<void>(verify(posture));
    }
}

CLAIM(a_budget_that_runs_out_ends_each_stage_with_a_finite_shape) {
    const Geometry& geometry = *reference().geometry;
    const Scene scene = complex_posture();
    for (const long budget : {0L, 1L, 20L, 60L, 200L}) {
        solve::Work work(budget);
        Shape shape = geodesic_shape(geometry, scene, constant_curvature_plates(geometry, scene), 4);
        Descent descent(geometry, scene, work);
        const DescentReport down = descent.run(shape, {});
        CHECK(down.status == SolveStatus::max_iterations && work.exhausted() && finite(shape));
        set_geodesic_wrenches(scene, shape, Stiffness::softened);
        choose_mesh(scene, 1e-6, shape);
        Equilibrium equilibrium(geometry, scene);
        solve::Work rest(budget);
        const NewtonReport newton = equilibrium.solve(shape, {}, rest);
        CHECK(newton.status == SolveStatus::max_iterations && finite(shape));
    }
    for (const int iterations : {0, 1, 2}) {
        const Posture posture = posture_of(reference().geometry, scene, {.max_iterations = iterations});
        CHECK(finite(posture.solution.shape));
        if (posture.solution.status == SolveStatus::converged) check_solved(posture);
        CHECK(iterations > 0 || posture.solution.status == SolveStatus::max_iterations);
    }
}

CLAIM(an_interrupted_solve_raises_and_the_next_one_knows_nothing_of_it) {
    const auto geometry = thin_rod();
    const Scene scene = wound_up(*geometry, 2.0 * 3.0 * pi * 0.003 / 0.2);  // three turns: m l / EI = 6 pi
    const Solution whole = limb::solve(*geometry, scene, {}, nullptr);
    int questions = 0;
    SolveOptions options;
    options.interrupted = [&] { return ++questions < 0; };
    CHECK(same_bits(limb::solve(*geometry, scene, options, nullptr), whole));
    const int all = questions;
    CHECK(all > 2);
    for (const int last : {1, 2, all / 2, all}) {
        questions = 0;
        options.interrupted = [&] { return ++questions == last; };
        CHECK_RAISES(solve::Interrupted, limb::solve(*geometry, scene, options, nullptr));
        CHECK(questions == last);
    }
    CHECK(same_bits(limb::solve(*geometry, scene, {}, nullptr), whole));
}

CLAIM(work_is_counted_and_the_caller_is_asked_after_some_thousand_evaluations) {
    int asked = 0;
    solve::Work work(10000, [&] { return ++asked == 2; });
    CHECK(work.spend(3000) && asked == 0);
    CHECK(work.spend(1) && asked == 1);
    CHECK_RAISES(solve::Interrupted, work.spend(3001));
    CHECK(!work.exhausted() && !work.spend(4000) && work.exhausted());
}

CLAIM(curves_clearance_and_stretch_of_a_posture_are_finite_and_meet_its_plates) {
    const Posture posture = posture_of(reference().geometry, complex_posture());
    for (int i = 0; i < 9; ++i) {
        const auto points = points_along(posture, i, {0.0, 0.5, 1.0});
        const Pose end = posture.solution.shape.plates[i / 3] * reference().geometry->segments[i / 3].rods[i % 3].end;
        CHECK_NEAR(points.back().pose.position, end.position, 1e-6);
        CHECK(largest_stretch(posture, i) > 1.0 && !leaves_axial_law(posture, i));
    }
    std::vector<double> radii;
    for (int i = 0; i < 9; ++i) radii.push_back(reference().tubes[i / 3].outer_radius());
    const Clearance found = clearance(posture, radii, 33);
    CHECK(found.first >= 0 && found.second > found.first && std::isfinite(found.gap));
    CHECK(clearance(posture, std::vector<double>(9, 0.0), 5).first == -1);
}
