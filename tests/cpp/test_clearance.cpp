#include <algorithm>
#include <limits>
#include <numeric>

#include "check.hpp"
#include "examples.hpp"

namespace {

using namespace softlimb;
using namespace softlimb::limb;
using namespace softlimb::tests;

/// A rod shot from its base: an equilibrium of its own, whatever stands beside it.
RodShape shot(const RodAtPressure& made, const Pose& base, const Vector6& wrench, int elements) {
    RodShape rod;
    rod::EndState at{base, wrench};
    const rod::RodPiece piece{&made.section, made.rest_length / elements, made.line_load};
    rod.integration = {8, 2};
    for (int e = 0; e < elements; ++e) {
        rod.nodes.push_back(at.pose);
        rod.wrenches.push_back(at.wrench);
        at = rod::end_of(piece, at.pose, at.wrench, {8, 4});
    }
    rod.nodes.push_back(at.pose);
    return rod;
}

/// Tubes by themselves, in segments of the given numbers of rods; where the plates are is not asked.
struct Tubes {
    explicit Tubes(const std::vector<int>& rods) {
        auto geometry = std::make_shared<Geometry>();
        for (const int count : rods) geometry->segments.push_back(ring(count, 0.02, 0.01, 0.0));
        posture.geometry = geometry;
    }
    void add(const Pose& base, const Vector6& wrench, int elements, double radius) {
        RodAtPressure made{soft_section(), 0.2, {}};
        made.line_load.force = {0.3, -0.2, 0.5};
        posture.scene.rods.push_back(made);
        posture.solution.shape.rods.push_back(shot(made, base, wrench, elements));
        radii.push_back(radius);
    }
    Clearance found() const { return clearance(posture, radii, 25); }

    Posture posture;
    std::vector<double> radii;
};

/// The plain version: all points of one tube against all of another. Between the ends of tubes of different segments a
/// point counts where none around it is closer.
Clearance point_by_point(const Posture& posture, const std::vector<double>& radii, int points) {
    std::vector<double> fractions(points);
    for (int i = 0; i < points; ++i) fractions[i] = static_cast<double>(i) / (points - 1);
    std::vector<std::vector<RodPoint>> curves;
    std::vector<int> segment;
    for (std::size_t i = 0; i < radii.size(); ++i)
        curves.push_back(points_along(posture, static_cast<int>(i), fractions));
    for (int j = 0; j < posture.geometry->plates(); ++j)
        segment.insert(segment.end(), posture.geometry->segments[j].rods.size(), j);
    Clearance best;
    best.gap = std::numeric_limits<double>::infinity();
    const int rods = static_cast<int>(radii.size());
    std::vector<double> square(points * points);
    for (int a = 0; a < rods; ++a)
        for (int b = a + 1; b < rods; ++b) {
            if (radii[a] <= 0.0 || radii[b] <= 0.0) continue;
            for (int i = 0; i < points; ++i)
                for (int k = 0; k < points; ++k)
                    square[i * points + k] = (curves[a][i].pose.position - curves[b][k].pose.position).squaredNorm();
            const bool ends_count = segment[a] == segment[b];
            for (int i = 0; i < points; ++i)
                for (int k = 0; k < points; ++k) {
                    const double here = square[i * points + k];
                    const double gap = std::sqrt(here) - radii[a] - radii[b];
                    if (!(gap < best.gap)) continue;
                    if (!ends_count) {
                        if (i == 0 || k == 0 || i + 1 == points || k + 1 == points) continue;
                        bool lowest = true;
                        for (int di = -1; di <= 1; ++di)
                            for (int dk = -1; dk <= 1; ++dk) lowest &= square[(i + di) * points + k + dk] >= here;
                        if (!lowest) continue;
                    }
                    best = {gap, a, b, fractions[i], fractions[k]};
                }
        }
    return best;
}

// Points of two tubes 1/400 of a rod apart miss the nearest places by a quarter of a millimetre each at most, here
// where no rod is longer than 0.2 m and a tenth: along tubes at right angles that adds twice its square to the squared
// distance. Polynomials and Newton's steps err by less than 1e-5 of a rod in all that is drawn here.
void check_against_the_plain_version(const Tubes& tubes) {
    const Clearance found = clearance(tubes.posture, tubes.radii, 25);
    const Clearance plain = point_by_point(tubes.posture, tubes.radii, 401);
    CHECK((found.first < 0) == (plain.first < 0));
    if (found.first < 0 || plain.first < 0) return;
    constexpr double missed = 0.5 * 1.1 * 0.2 / 400.0, polynomial = 1e-5 * 0.2;
    const double apart = found.gap + tubes.radii[found.first] + tubes.radii[found.second];
    const double gap = plain.gap - found.gap;
    CHECK(gap > -polynomial && gap < polynomial + std::sqrt(apart * apart + 2.0 * missed * missed) - apart);
}

CLAIM(clearance_of_tubes_beside_each_other_is_that_of_all_their_points) {
    for (unsigned seed = 0; seed < 60; ++seed) {
        Draw draw(seed);
        Tubes tubes({3});
        // Bent by up to a radian and a half together, a little differently each, as between two plates.
        const Vector6 common = draw.matrix<Vector6>(0.3);
        for (int i = 0; i < 3; ++i) {
            const Placement at = tubes.posture.geometry->segments[0].rods[i];
            Vector6 wrench = common + draw.matrix<Vector6>(0.05);
            tubes.add(at.base, wrench, 1 + static_cast<int>(seed + i) % 4, 0.008);
        }
        check_against_the_plain_version(tubes);
    }
}

CLAIM(clearance_of_tubes_that_cross_or_wind_is_that_of_all_their_points) {
    for (unsigned seed = 0; seed < 60; ++seed) {
        Draw draw(seed);
        Tubes tubes({3});
        for (int i = 0; i < 3; ++i) {
            const Pose base{draw.matrix<Vector3>(0.08), exp_so3(2.0 * draw.direction())};
            Vector6 wrench = draw.matrix<Vector6>(1.0);
            wrench.head<3>() *= 3.0;
            tubes.add(base, wrench, 4, 0.004);
        }
        check_against_the_plain_version(tubes);
    }
}

CLAIM(ends_of_tubes_of_different_segments_do_not_count_and_crossings_do) {
    int crossings = 0;
    for (unsigned seed = 0; seed < 60; ++seed) {
        Draw draw(seed);
        Tubes tubes({1, 1});
        // The second across the first at any place of both, or past its ends, at 60 degrees or more and gently bent: so
        // steep that the plain version sees each nearest place among its points.
        const Vector6 bend = draw.matrix<Vector6>(0.1);
        tubes.add({}, bend, 2, 0.004);
        const Matrix3 across = exp_so3(draw(pi / 3.0, pi / 2.0) * Vector3(std::cos(seed), std::sin(seed), 0.0));
        const Vector3 middle(0.0, 0.0, draw(-0.02, 0.22));
        const Vector3 base = middle - across.col(2) * draw(-0.02, 0.22) + 0.03 * draw.direction();
        tubes.add({base, across}, draw.matrix<Vector6>(0.1), 2, 0.004);
        check_against_the_plain_version(tubes);
        const Clearance found = tubes.found();
        if (found.first < 0) continue;
        ++crossings;
        CHECK(found.first_fraction > 0.0 && found.first_fraction < 1.0);
        CHECK(found.second_fraction > 0.0 && found.second_fraction < 1.0);
    }
    CHECK(crossings > 20 && crossings < 55);
}

CLAIM(clearance_of_straight_tubes_is_that_of_their_lines) {
    Tubes tubes({2, 1, 1});
    const auto straight = [&](const Pose& base, double radius) {
        RodAtPressure made{soft_section(), 0.2, {}};
        tubes.posture.scene.rods.push_back(made);
        tubes.posture.solution.shape.rods.push_back(shot(made, base, Vector6::Zero(), 1));
        tubes.radii.push_back(radius);
    };
    // Two beside each other, of which one begins a quarter later; one across both; one farther on.
    straight({}, 0.01);
    straight({Vector3(0.05, 0.0, 0.05), Matrix3::Identity()}, 0.012);
    straight({Vector3(0.02, 0.1, 0.11), exp_so3(Vector3(pi / 2.0, 0.0, 0.0))}, 0.005);
    straight({Vector3(0.3, 0.0, 0.25), Matrix3::Identity()}, 0.01);
    const double rounding = 1e-14;
    CHECK_NEAR(tubes.found().gap, 0.02 - 0.01 - 0.005, rounding);
    tubes.radii[2] = 0.0;
    const Clearance beside = tubes.found();
    CHECK_NEAR(beside.gap, 0.05 - 0.01 - 0.012, rounding);
    CHECK(beside.first == 0 && beside.second == 1);
    CHECK_NEAR(beside.first_fraction - beside.second_fraction, 0.25, 1e-7);  // the nearest line, not the distance
    tubes.radii[1] = 0.0;
    CHECK(tubes.found().first == -1);  // nearest at ends, and of different segments
}

CLAIM(clearance_of_a_limb_is_that_of_all_its_points) {
    // A row of a workspace each; where segments meet no place counts, so the plain version's steps may not matter.
    for (unsigned seed = 0; seed < 12; ++seed) {
        Draw draw(seed);
        std::vector<double> pressures(9);
        for (double& pressure : pressures) pressure = draw(0.0, 60 * kPa);
        Scene scene = reference().scene(pressures);
        scene.gravity = hanging;
        Tubes tubes({});
        tubes.posture = posture_of(reference().geometry, scene);
        for (int i = 0; i < 9; ++i) tubes.radii.push_back(reference().tubes[i / 3].outer_radius());
        check_against_the_plain_version(tubes);
    }
}

}  // namespace
