// Limbs side by side, one a lane: each as if it were alone, where limb::solve finds it, and never wrong in silence.
#include <algorithm>
#include <cstring>

#include "allocations.hpp"
#include "check.hpp"
#include "examples.hpp"
#include "softlimb/limb/attempt.hpp"
#include "softlimb/limb/side_by_side.hpp"

using namespace softlimb;
using namespace softlimb::tests;
using limb::SideBySide;
using rod::lanes::LaneReport;
using rod::lanes::LaneStatus;

namespace {

/// A shape as the numbers that lanes take; the wrenches and nodes are those of its own mesh.
std::vector<double> numbers_of(const limb::Shape& shape) {
    std::vector<double> numbers;
    const auto put = [&](const auto& m) { numbers.insert(numbers.end(), m.data(), m.data() + m.size()); };
    for (const Pose& plate : shape.plates) put(plate.position), put(plate.rotation);
    for (const limb::RodShape& rod : shape.rods) {
        for (int e = 1; e < rod.elements(); ++e) put(rod.nodes[e].position), put(rod.nodes[e].rotation);
        for (const Vector6& wrench : rod.wrenches) put(wrench);
    }
    return numbers;
}

/// A scene, its answer by limb::solve to a hundredth of the tolerance, and a start some way off.
struct Case {
    limb::Scene scene;
    limb::Solution answer;
    std::vector<double> start;
};

constexpr double tolerance = 1e-6;
const limb::Mesh& fine_mesh() {
    static const limb::Mesh mesh{std::vector<int>(9, 4), std::vector<int>(9, 2)};
    return mesh;
}

/// The start is the posture of rods whose rest lengths differ by up to a share `away`.
Case case_of(const limb::Scene& scene, double away, unsigned seed) {
    const limb::Geometry& geometry = *reference().geometry;
    limb::SolveOptions exact;
    exact.tolerance = 1e-2 * tolerance;
    limb::Scene nearby = scene;
    Draw draw(seed);
    for (limb::RodAtPressure& rod : nearby.rods) rod.rest_length *= 1.0 + draw(-away, away);
    const limb::Solution start = limb::solve(geometry, nearby, {}, nullptr);
    CHECK(start.status == solve::SolveStatus::converged);
    return {scene, limb::solve(geometry, scene, exact, nullptr),
            numbers_of(limb::on_mesh(geometry, nearby, start.shape, fine_mesh()))};
}

/// Random pressures under loads that all of them share.
limb::Scene random_scene(Draw& draw) {
    std::vector<double> pressures(9);
    for (double& p : pressures) p = draw(0.0, 40 * kPa);
    limb::Scene scene = reference().scene(pressures);
    scene.gravity = hanging;
    scene.wrenches.back().head<3>() = Vector3(0.2, -0.1, 0.1);
    return scene;
}

/// Rounds until every lane has ended; each lane's report, and its numbers in `found`.
std::vector<LaneReport> run(SideBySide& limbs, int lanes, std::vector<std::vector<double>>& found) {
    const auto running = [&](int lane) { return limbs.report(lane).status == LaneStatus::running; };
    for (int round = 0; round < 30; ++round) {
        bool any = false;
        for (int lane = 0; lane < lanes; ++lane) any = any || running(lane);
        if (!any) break;
        limbs.round();
    }
    std::vector<LaneReport> reports;
    found.assign(lanes, std::vector<double>(limb::numbers_of(*reference().geometry, fine_mesh())));
    for (int lane = 0; lane < lanes; ++lane) {
        reports.push_back(limbs.report(lane));
        limbs.take(lane, found[lane].data());
    }
    return reports;
}

/// Solves cases side by side and compares those that converge; the number of them.
int compare_with_solve(const std::vector<Case>& cases) {
    const limb::Geometry& geometry = *reference().geometry;
    int converged = 0;
    SideBySide limbs(geometry, cases.front().scene, fine_mesh(), tolerance);
    for (std::size_t first = 0; first < cases.size(); first += limbs.width()) {
        const int here = std::min(limbs.width(), static_cast<int>(cases.size() - first));
        for (int lane = 0; lane < here; ++lane)
            limbs.fill(lane, cases[first + lane].scene, cases[first + lane].start.data());
        std::vector<std::vector<double>> found;
        const std::vector<LaneReport> reports = run(limbs, here, found);
        for (int lane = 0; lane < here; ++lane) {
            CHECK(reports[lane].status != LaneStatus::running && reports[lane].status != LaneStatus::empty);
            if (reports[lane].status != LaneStatus::converged) continue;
            limb::Shape shape;
            limb::numbers_to_shape(geometry, fine_mesh(), found[lane].data(), shape);
            const limb::Solution& answer = cases[first + lane].answer;
            CHECK(reports[lane].error <= tolerance);
            CHECK(!reports[lane].stable || answer.stable);
            if (limb::distance(geometry, shape, answer.shape) > 0.01) continue;  // another posture of the scene
            ++converged;
            // The tolerance of the lanes, and a hundredth of it for the answer that they are compared with.
            CHECK(limb::distance(geometry, shape, answer.shape) < 1.01 * tolerance);
        }
    }
    return converged;
}

}  // namespace

CLAIM(limbs_side_by_side_are_where_solve_finds_them) {
    std::vector<Case> cases;
    Draw draw(5);
    for (unsigned seed = 0; seed < 21; ++seed) cases.push_back(case_of(random_scene(draw), 0.01, seed));
    with_every_instruction_set([&] { CHECK(compare_with_solve(cases) >= 19); });
}

CLAIM(limbs_side_by_side_bear_every_kind_of_load) {
    enum class Load { none, plates, following, moments, distributed };
    for (const Load load : {Load::none, Load::plates, Load::following, Load::moments, Load::distributed}) {
        std::vector<Case> cases;
        Draw draw(static_cast<unsigned>(load) + 40);
        Vector6 wrench = Vector6::Zero();
        wrench.head<3>() = draw.matrix<Vector3>(0.2);
        if (load == Load::following || load == Load::moments) wrench.tail<3>() = draw.matrix<Vector3>(0.01);
        const Vector3 force = draw.matrix<Vector3>(0.5), moment = draw.matrix<Vector3>(0.01);
        for (unsigned seed = 0; seed < 5; ++seed) {
            limb::Scene scene = random_scene(draw);
            if (load == Load::none) scene.gravity.setZero();
            scene.following = load == Load::following;
            for (Vector6& w : scene.wrenches) w.setZero();
            if (load != Load::none) scene.wrenches[1] = 0.5 * wrench, scene.wrenches[2] = wrench;
            if (load == Load::distributed)
                for (limb::RodAtPressure& rod : scene.rods)
                    rod.line_load = {{force.x(), force.y(), force.z()}, {moment.x(), moment.y(), moment.z()}};
            cases.push_back(case_of(scene, 0.01, seed));
        }
        CHECK(compare_with_solve(cases) >= 4);
    }
}

CLAIM(a_limb_in_a_lane_does_not_know_of_the_others) {
    std::vector<Case> cases;
    Draw draw(9);
    for (unsigned seed = 0; seed < 8; ++seed) cases.push_back(case_of(random_scene(draw), 0.01, seed));
    // One that nobody can solve: rods turned inside out.
    std::vector<double> nonsense = cases[0].start;
    for (double& x : nonsense) x *= -50.0;
    with_every_instruction_set([&] {
        SideBySide limbs(*reference().geometry, cases.front().scene, fine_mesh(), tolerance);
        std::vector<std::vector<double>> alone, beside;
        limbs.fill(0, cases[1].scene, cases[1].start.data());
        const LaneReport first = run(limbs, 1, alone).front();
        const int last = limbs.width() - 1;
        for (int lane = 0; lane < last; ++lane)
            limbs.fill(lane, cases[lane].scene, lane % 2 ? nonsense.data() : cases[lane].start.data());
        limbs.round();  // so that this one comes later than the others
        limbs.fill(last, cases[1].scene, cases[1].start.data());
        const LaneReport second = run(limbs, limbs.width(), beside).back();
        CHECK(first.status == LaneStatus::converged && second.status == LaneStatus::converged);
        CHECK(first.iterations == second.iterations && first.error == second.error && first.stable == second.stable);
        CHECK(std::memcmp(alone[0].data(), beside[last].data(), sizeof(double) * alone[0].size()) == 0);
    });
}

CLAIM(nonsense_in_a_lane_fails) {
    Draw draw(3);
    const Case good = case_of(random_scene(draw), 0.0, 0);
    SideBySide limbs(*reference().geometry, good.scene, fine_mesh(), tolerance);
    for (const double factor : {-50.0, 1e200, std::numeric_limits<double>::quiet_NaN()}) {
        std::vector<double> start = good.start;
        for (double& x : start) x *= factor;
        limbs.fill(0, good.scene, start.data());
        std::vector<std::vector<double>> found;
        const LaneReport report = run(limbs, 1, found).front();
        CHECK(report.status == LaneStatus::failed);
    }
}

CLAIM(an_unstable_posture_in_a_lane_is_not_called_stable) {
    // A standing limb under a weight beyond its critical one: upright is an equilibrium, and no stable one.
    limb::Scene scene = reference().scene(std::vector<double>(9, 20 * kPa));
    limb::SolveOptions any;
    any.prefer_stable = false;
    for (const double weight : {0.0, 200.0}) {
        scene.wrenches.back()(2) = -weight;
        const limb::Solution upright = limb::solve(*reference().geometry, scene, any, nullptr);
        CHECK(upright.status == solve::SolveStatus::converged);
        CHECK(upright.stable == (weight == 0.0));
        const limb::Shape shape = limb::on_mesh(*reference().geometry, scene, upright.shape, fine_mesh());
        SideBySide limbs(*reference().geometry, scene, fine_mesh(), tolerance);
        limbs.fill(0, scene, numbers_of(shape).data());
        std::vector<std::vector<double>> found;
        const LaneReport report = run(limbs, 1, found).front();
        CHECK(report.status == LaneStatus::converged);
        CHECK(report.stable == upright.stable);
    }
}

CLAIM(limbs_side_by_side_take_no_memory_once_they_have_their_room) {
    Draw draw(2);
    const Case one = case_of(random_scene(draw), 0.01, 1);
    SideBySide limbs(*reference().geometry, one.scene, fine_mesh(), tolerance);
    std::vector<double> numbers(one.start.size());
    const long before = allocations();
    limbs.fill(0, one.scene, one.start.data());
    while (limbs.report(0).status == LaneStatus::running) limbs.round();
    limbs.take(0, numbers.data());
    CHECK(allocations() == before);
}
