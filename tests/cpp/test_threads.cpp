// One limb and its tubes shared by many threads: the same bits as one thread, and no race (ThreadSanitizer runs this).
#include <thread>

#include "check.hpp"
#include "examples.hpp"
#include "same_bits.hpp"

using namespace softlimb;
using namespace softlimb::tests;

namespace {

limb::Scene scene_number(const Reference& limb, int number) {
    Draw draw(100 + number);
    std::vector<double> pressures(9);
    for (double& pressure : pressures) pressure = draw(0.0, 70 * kPa);
    limb::Scene scene =
        limb.scene(pressures, number % 2 ? actuator::SectionModel::nonlinear : actuator::SectionModel::tangent);
    scene.gravity = 9.81 * draw.direction();
    scene.wrenches.back().head<3>() = 0.3 * draw.matrix<Vector3>();
    return scene;
}

}  // namespace

CLAIM(many_threads_that_share_one_limb_get_the_bits_that_one_thread_gets) {
    const Reference limb;
    constexpr int scenes = 8, threads = 4;
    std::vector<limb::Solution> alone(scenes), together(scenes);
    const auto solve_one = [&](int number) {
        // Tubes, geometry and the solver: everything that a sweep shares.
        return limb::solve(*limb.geometry, scene_number(limb, number), {.interrupted = [] { return false; }}, nullptr);
    };
    for (int number = 0; number < scenes; ++number) alone[number] = solve_one(number);
    std::vector<std::thread> pool;
    for (int worker = 0; worker < threads; ++worker)
        pool.emplace_back([&, worker] {
            for (int number = worker; number < scenes; number += threads) together[number] = solve_one(number);
        });
    for (std::thread& thread : pool) thread.join();
    for (int number = 0; number < scenes; ++number) {
        CHECK(alone[number].status == solve::SolveStatus::converged);
        CHECK(same_bits(alone[number], together[number]));
    }
}

CLAIM(an_interruption_of_one_thread_leaves_the_others_alone) {
    const Reference limb;
    const limb::Solution alone = limb::solve(*limb.geometry, scene_number(limb, 0), {}, nullptr);
    limb::Solution beside;
    bool interrupted = false;
    std::thread stopped([&] {
        limb::SolveOptions options;
        options.interrupted = [] { return true; };
        try {
            for (int k = 0; k < 100; ++k) {
                limb::Scene scene = scene_number(limb, 1);
                scene.wrenches.back()(3) = 1e3;  // no answer: evaluations until the budget ends
                limb::solve(*limb.geometry, scene, options, nullptr);
            }
        } catch (const solve::Interrupted&) {
            interrupted = true;
        }
    });
    std::thread goes_on([&] { beside = limb::solve(*limb.geometry, scene_number(limb, 0), {}, nullptr); });
    stopped.join(), goes_on.join();
    CHECK(interrupted && same_bits(alone, beside));
}
