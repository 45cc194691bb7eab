// A solve from a posture near by: first steps with that posture's stiffness, one linearisation, at the answer.
#include <thread>

#include "allocations.hpp"
#include "check.hpp"
#include "examples.hpp"
#include "same_bits.hpp"
#include "softlimb/limb/derivatives.hpp"
#include "softlimb/limb/equilibrium.hpp"
#include "softlimb/limb/start.hpp"

using namespace softlimb;
using namespace softlimb::limb;
using namespace softlimb::tests;
using solve::SolveStatus;

namespace {

/// With the mesh of a solve that has a start.
Posture first(const Scene& scene, const SolveOptions& options = {}) {
    const Posture cold = posture_of(reference().geometry, scene, options);
    return posture_of(reference().geometry, scene, options, &cold.solution.shape);
}

Posture follow(const Posture& before, const Scene& scene, const SolveOptions& options = {}) {
    return {before.geometry, scene, limb::solve(*before.geometry, scene, options, before.solved())};
}

/// As it is where its thread has forgotten the linearisation, or where it was read from a file.
Posture forgotten(Posture posture) {
    posture.solution.linearisation = 0;
    return posture;
}

/// The reference limb at random pressures under a random load, hanging or standing.
struct Walk {
    explicit Walk(unsigned seed) : draw(seed) {
        for (double& p : pressures) p = draw(5 * kPa, 60 * kPa);
        force << 0.3 * draw(), 0.3 * draw(), 0.2 * draw();
        gravity = draw() < 0.0 ? hanging : standing;
    }
    Scene scene() const {
        Scene made = reference().scene(pressures);
        made.gravity = gravity;
        made.wrenches.back().head<3>() = force;
        return made;
    }
    void step(double size) {
        for (double& p : pressures) p *= 1.0 + size * draw();
        force += 0.3 * size * draw.matrix<Vector3>();
    }

    Draw draw;
    std::vector<double> pressures = std::vector<double>(9);
    Vector3 force, gravity;
};

}  // namespace

CLAIM(a_posture_that_is_followed_is_the_one_that_a_tight_solve_finds) {
    int followed = 0, solved = 0;
    for (unsigned seed = 0; seed < 12; ++seed)
        for (const double tolerance : {1e-4, 1e-6, 1e-8}) {
            Walk walk(seed);
            const SolveOptions options{.tolerance = tolerance, .interrupted = {}};
            Posture at = first(walk.scene(), options);
            for (const double size : {0.003, 0.01, 0.03, 0.1, 0.3}) {
                walk.step(size);
                const Posture next = follow(at, walk.scene(), options);
                CHECK(next.solution.status == SolveStatus::converged && next.solution.stable);
                const Posture tight = posture_of(reference().geometry, walk.scene(),
                                                 {.tolerance = 1e-11, .interrupted = {}}, &next.solution.shape);
                const Pose &a = next.solution.shape.plates.back(), &b = tight.solution.shape.plates.back();
                CHECK_NEAR(a.position, b.position, tolerance * reference().geometry->length);
                CHECK_NEAR(a.rotation, b.rotation, tolerance);
                CHECK_NEAR(next.solution.base_wrench, tight.solution.base_wrench, 10.0 * tolerance);
                followed += next.solution.followed, solved += 1;
                at = next;
            }
        }
    CHECK(2 * followed > solved && followed < solved);  // what is too far is solved as from any shape
}

CLAIM(soft_rods_beside_stiff_ones_close_where_they_are_followed) {
    // Wrenches of the soft ones count for nothing beside those of the others, and so do steps of the poses.
    Draw draw(17);
    int followed = 0;
    for (int trial = 0; trial < 20; ++trial) {
        const auto geometry = geometry_of({ring(6, 0.03, 0.01, 0.1)}, 0.2);
        Scene scene = bare_scene(*geometry, soft_section(), 0.2);
        const double ratio = std::pow(10.0, draw(3.0, 6.0)), tolerance = std::pow(10.0, draw(-7.0, -4.0));
        for (int i = 0; i < 6; i += 2) {
            scene.rods[i].section =
                Section::make(400.0 * ratio, 130.0 * ratio, 0.08 * ratio, 0.06 * ratio, 0.4, 0.0, 0.0);
            scene.rods[i].rest_length = 0.2 + draw(-0.01, 0.01);
        }
        const SolveOptions options{.tolerance = tolerance, .interrupted = {}};
        const Posture cold = posture_of(geometry, scene, options);
        Posture at = posture_of(geometry, scene, options, &cold.solution.shape);
        for (int step = 0; step < 5; ++step) {
            for (int i = 1; i < 6; i += 2) scene.rods[i].rest_length *= 1.0 + 4e-3 * draw();
            const Posture next = follow(at, scene, options);
            if (next.solution.status != SolveStatus::converged) break;
            const Verification found = verify(next);
            CHECK_NEAR(found.position_error, 0.0, 10.0 * tolerance);
            CHECK_NEAR(found.rotation_error, 0.0, 10.0 * tolerance);
            CHECK_NEAR(found.force_error, 0.0, 10.0 * tolerance);
            CHECK_NEAR(found.moment_error, 0.0, 10.0 * tolerance);
            followed += next.solution.followed;
            at = next;
        }
    }
    CHECK(followed > 20);
}

CLAIM(a_stiffness_at_hand_and_one_that_is_taken_again_give_the_same_bits) {
    Walk walk(7);
    Posture at = first(walk.scene());
    const std::vector<RodSlope> slopes(9, {soft_section(), 1e-6});
    for (int n = 0; n < 6; ++n) {
        walk.step(0.01);
        const Posture again = follow(forgotten(at), walk.scene());
        const Posture next = follow(at, walk.scene());
        CHECK(next.solution.followed && again.solution.followed);
        CHECK(next.solution.linearisation != 0 && next.solution.linearisation != again.solution.linearisation);
        CHECK(same_bits(next.solution, again.solution));
        Posture elsewhere = next;  // another thread has none at hand
        std::thread([&] { elsewhere = follow(at, walk.scene()); }).join();
        CHECK(same_bits(next.solution, elsewhere.solution));
        const std::vector<Vector6> here = tip_by_rods(next, slopes), anew = tip_by_rods(forgotten(next), slopes);
        for (std::size_t i = 0; i < here.size(); ++i) CHECK(same_numbers(here[i], anew[i]));
        at = next;
    }
}

CLAIM(slopes_of_a_followed_posture_are_those_of_its_derivatives) {
    Walk walk(11);
    const Posture before = first(walk.scene());
    walk.step(0.01);
    const auto posture = std::make_shared<const Posture>(follow(before, walk.scene()));
    CHECK(posture->solution.followed);
    std::vector<RodSlope> slopes;
    for (int i = 0; i < 9; ++i) {
        const auto at = reference().tubes[i / 3].section(walk.pressures[i], actuator::SectionModel::tangent,
                                                         actuator::Valve::open, true);
        slopes.push_back({at.d_section, at.d_rest_length});
    }
    const std::vector<Vector6> moves = tip_by_rods(*posture, slopes);
    Derivatives exact(posture, 1e-11);
    const std::vector<Vector6> expected = exact.tip_by_rods(slopes);
    // Each by a mesh for its own tolerance.
    for (int i = 0; i < 9; ++i) CHECK_NEAR(moves[i], expected[i], 1e-6 * expected[i].cwiseAbs().maxCoeff());
}

CLAIM(what_is_not_near_enough_is_solved_as_from_a_shape) {
    Walk walk(3);
    const Posture before = first(walk.scene());
    const auto same_as_from_its_shape = [&](const Posture& start, const std::shared_ptr<Geometry>& geometry,
                                            const Scene& scene) {
        const Solution found = limb::solve(*geometry, scene, {}, start.solved());
        CHECK(!found.followed && found.linearisation == 0);
        CHECK(same_bits(found, limb::solve(*geometry, scene, {}, &start.solution.shape)));
    };
    // Another limb, alike but for a plate.
    auto other = std::make_shared<Geometry>(*reference().geometry);
    other->segments[1].plate_thickness *= 1.01;
    same_as_from_its_shape(before, other, walk.scene());
    // A held plate.
    Scene held = walk.scene();
    held.holds.back().held = {true, true, true, false, false, false};
    held.holds.back().pose = before.solution.shape.plates.back();
    same_as_from_its_shape(before, reference().geometry, held);
    const Posture kept = posture_of(reference().geometry, held, {}, &before.solution.shape);
    same_as_from_its_shape(kept, reference().geometry, held);
    same_as_from_its_shape(kept, reference().geometry, walk.scene());
    // Pieces shorter than they need be.
    Posture fine = before;
    split_elements(fine.solution.shape.rods[8], 3);
    same_as_from_its_shape(fine, reference().geometry, walk.scene());
    // No posture at all.
    Posture failed = before;
    failed.solution.status = SolveStatus::max_iterations;
    same_as_from_its_shape(failed, reference().geometry, walk.scene());
    Posture unstable = before;
    unstable.solution.stable = false;
    same_as_from_its_shape(unstable, reference().geometry, walk.scene());
    // Far away.
    for (double& p : walk.pressures) p = 65 * kPa - p;
    same_as_from_its_shape(before, reference().geometry, walk.scene());
}

CLAIM(a_posture_is_not_followed_past_the_loss_of_its_stability) {
    // A standing limb under a growing weight, upright but for a little: it falls over, and never counts as stable where
    // its own stiffness says otherwise.
    const Geometry& geometry = *reference().geometry;
    for (const double sideways : {0.0, 1e-6, 1e-3}) {
        Scene scene = reference().scene(std::vector<double>(9, 20 * kPa));
        scene.gravity = standing;
        scene.wrenches.back()(0) = sideways;
        Posture at = first(scene);
        int followed = 0;
        for (int n = 0; n < 60; ++n) {
            scene.wrenches.back()(2) -= 0.1;
            const Posture next = follow(at, scene);
            CHECK(next.solution.status == SolveStatus::converged && next.solution.stable);
            Equilibrium fresh(geometry, scene);
            CHECK(fresh.linearise_at(next.solution.shape));
            NewtonReport report;
            fresh.judge(next.solution.shape, report, 0.0);
            CHECK(report.modes() == 0);
            followed += next.solution.followed;
            at = next;
        }
        CHECK(followed > 30);
        CHECK(at.solution.shape.plates.back().position.head<2>().norm() > 0.1);
    }
}

CLAIM(once_warm_following_takes_no_memory) {
    Walk walk(5);
    const Posture before = first(walk.scene());
    walk.step(0.01);
    const Scene scene = walk.scene();
    for (const bool at_hand : {false, true})
        for (const bool warm : {false, true}) {
            const Posture start = follow(before, scene);  // the last linearisation on this thread
            CHECK(start.solution.followed);
            const LinearisationNumber number = at_hand ? start.solution.linearisation : 0;
            Shape shape = start.solution.shape;
            solve::Work work(1'000'000L, {});
            const long taken = allocations();
            Equilibrium equilibrium(*reference().geometry, scene, number);
            CHECK(equilibrium.at_hand(number) == at_hand);
            const NewtonReport report = equilibrium.follow(scene, start.solution.shape, number, shape, {}, work);
            equilibrium.keep_linearisation();
            if (warm) CHECK(allocations() == taken);
            CHECK(report.status == SolveStatus::converged);
        }
}
