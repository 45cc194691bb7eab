// Where the rows of a long sweep start: near their answers, as the plain sum of the terms says, on every machine.
#include <algorithm>

#include "check.hpp"
#include "examples.hpp"
#include "softlimb/limb/attempt.hpp"
#include "softlimb/sweep/sweep.hpp"

using namespace softlimb;
using namespace softlimb::tests;
using sweep::Atlas;

namespace {

sweep::Members segment_members() {
    const auto tube = std::make_shared<const actuator::Tube>(distal());
    return sweep::Members(std::vector<sweep::Member>(3, {tube, {}, 0.0, tube->outer_radius()}));
}

struct Surveyed {
    std::shared_ptr<limb::Geometry> geometry = geometry_of({ring(3, 0.014, 0.025, 0.14)}, 0.2);
    sweep::Members members = segment_members();
    limb::Scene scene = bare_scene(*geometry, {}, 0.2);
    sweep::SweepOptions options;

    Surveyed() { scene.gravity = hanging; }
    std::vector<double> pressures(int rows, unsigned seed) const {
        Draw draw(seed);
        std::vector<double> p(3 * rows);
        for (double& x : p) x = draw(0.0, 60 * kPa);
        return p;
    }
    std::optional<Atlas> survey(int rows) const {
        const std::vector<double> p = pressures(rows, 4);
        return sweep::survey(*geometry, members, scene, options, p.data(), rows, [](std::int64_t) { return true; });
    }
    limb::Scene at(const double* p) const {
        limb::Scene there = scene;
        members.at_pressures(p, options.model, options.valve, there.rods);
        return there;
    }
};

}  // namespace

CLAIM(an_atlas_leads_near_the_answers) {
    const Surveyed limb;
    const std::optional<Atlas> atlas = limb.survey(128);
    CHECK(atlas.has_value());
    if (!atlas) return;
    const std::vector<double> p = limb.pressures(20, 99);
    Atlas::Room room;
    std::vector<double> distances;
    for (int row = 0; row < 20; ++row) {
        const limb::Scene scene = limb.at(p.data() + 3 * row);
        const std::vector<limb::RodAtPressure>* rods[] = {&scene.rods};
        atlas->starts(*limb.geometry, rods, 1, room);
        limb::Shape start;
        limb::numbers_to_shape(*limb.geometry, atlas->mesh(), room.numbers[0].data(), start);
        const limb::Solution answer = limb::solve(*limb.geometry, scene, {}, nullptr);
        distances.push_back(limb::distance(*limb.geometry, start, answer.shape));
    }
    std::sort(distances.begin(), distances.end());
    // The median, of the limb's length or in radians: postures of such rows are half a radian and more apart.
    CHECK(distances[10] < 0.05);
}

CLAIM(starts_found_together_are_those_found_one_by_one) {
    const Surveyed limb;
    const std::optional<Atlas> atlas = limb.survey(128);
    CHECK(atlas.has_value());
    if (!atlas) return;
    const std::vector<double> p = limb.pressures(Atlas::together, 7);
    std::vector<limb::Scene> scenes;
    for (int i = 0; i < Atlas::together; ++i) scenes.push_back(limb.at(p.data() + 3 * i));
    with_every_instruction_set([&] {
        const std::vector<limb::RodAtPressure>* rods[Atlas::together];
        for (int i = 0; i < Atlas::together; ++i) rods[i] = &scenes[i].rods;
        Atlas::Room all, one;
        atlas->starts(*limb.geometry, rods, Atlas::together, all);
        for (int i = 0; i < Atlas::together; ++i) {
            atlas->starts(*limb.geometry, rods + i, 1, one);
            CHECK(one.numbers[0] == all.numbers[i]);
        }
    });
}

CLAIM(kernels_combine_rows_as_the_plain_sum_does) {
    constexpr int count = 37, panels = 3, columns = rod::lanes::combined;
    Draw draw(1);
    std::vector<double> rows(count * panels * columns), weights(count * columns), sums(panels * columns * columns);
    for (double& x : rows) x = draw();
    for (double& x : weights) x = draw();
    with_every_instruction_set([&] {
        rod::lanes::kernel().combine(rows.data(), count, panels, weights.data(), sums.data());
        for (int i = 0; i < columns; ++i)
            for (int number = 0; number < panels * columns; ++number) {
                double sum = 0.0;
                for (int k = 0; k < count; ++k)
                    sum += weights[columns * k + i] * rows[(number / columns * count + k) * columns + number % columns];
                // Rounding of a sum of 37 products below one.
                CHECK_NEAR(sum, sums[panels * columns * i + number], 1e-14);
            }
    });
}

CLAIM(no_atlas_where_it_does_not_serve) {
    Surveyed limb;
    CHECK(!limb.survey(4).has_value());  // too few for any polynomial
    limb.scene.holds[0].held.fill(true);
    CHECK(!limb.survey(64).has_value());
    limb.scene.holds[0] = {};
    // A survey that is stopped, which the first look after a tenth of a second does.
    constexpr int many = 20'000;
    const std::vector<double> p = limb.pressures(many, 4);
    CHECK(!sweep::survey(*limb.geometry, limb.members, limb.scene, limb.options, p.data(), many, [](std::int64_t) {
               return false;
           }).has_value());
}
