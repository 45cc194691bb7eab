// Rows on threads: the same bits as one thread, no race (ThreadSanitizer runs this), and no row that ends the others.
#include <cstring>
#include <limits>
#include <memory>

#include "check.hpp"
#include "examples.hpp"
#include "softlimb/sweep/sweep.hpp"

using namespace softlimb;
using namespace softlimb::tests;
using sweep::Member;
using sweep::Members;

namespace {

constexpr double no_number = std::numeric_limits<double>::quiet_NaN();

struct Answers {
    explicit Answers(std::int64_t rows, int plate_count)
        : tip(16 * rows, no_number),
          plates(16 * rows * plate_count, no_number),
          clearance(rows, no_number),
          residual(rows, no_number),
          status(rows, sweep::not_run),
          modes(rows, -1),
          iterations(rows, 0),
          success(new bool[rows]()),
          stable(new bool[rows]()) {}
    sweep::RowAnswers arrays() {
        return {tip.data(),   plates.data(),    status.data(),     success.get(),  stable.get(),
                modes.data(), clearance.data(), iterations.data(), residual.data()};
    }
    bool operator==(const Answers& other) const {
        const auto same = [](const auto& a, const auto& b) {
            return std::memcmp(a.data(), b.data(), sizeof(a[0]) * a.size()) == 0;  // NaN included
        };
        return same(tip, other.tip) && same(plates, other.plates) && same(clearance, other.clearance) &&
               same(residual, other.residual) && status == other.status && modes == other.modes &&
               iterations == other.iterations;
    }

    std::vector<double> tip, plates, clearance, residual;
    std::vector<std::int8_t> status;
    std::vector<std::int64_t> modes, iterations;
    std::unique_ptr<bool[]> success, stable;
    std::vector<sweep::RowMessage> messages;
};

/// One segment of the reference limb, and random pressures.
struct Rows {
    std::shared_ptr<limb::Geometry> geometry = geometry_of({ring(3, 0.014, 0.025, 0.14)}, 0.2);
    Members members;
    limb::Scene scene = bare_scene(*geometry, {}, 0.2);
    std::vector<double> pressures;

    explicit Rows(std::int64_t rows) : members(tubes()) {
        scene.gravity = hanging;
        Draw draw(21);
        for (std::int64_t i = 0; i < 3 * rows; ++i) pressures.push_back(draw(0.0, 60 * kPa));
    }
    static std::vector<Member> tubes() {
        const auto tube = std::make_shared<const actuator::Tube>(distal());
        return std::vector<Member>(3, Member{tube, {}, 0.0, tube->outer_radius()});
    }
    std::int64_t count() const { return static_cast<std::int64_t>(pressures.size()) / 3; }
    Answers solve(
        const sweep::SweepOptions& options, const sweep::Tick& tick = [](std::int64_t) { return true; }) const {
        Answers answers(count(), 1);
        sweep::sweep(*geometry, members, scene, options, pressures.data(), count(), answers.arrays(), answers.messages,
                     tick);
        return answers;
    }
};

}  // namespace

CLAIM(no_bit_of_a_sweep_depends_on_the_number_of_threads) {
    const Rows rows(40);
    for (const bool ordered : {false, true}) {
        sweep::SweepOptions options;
        options.ordered = ordered;
        const Answers one = rows.solve(options);
        for (const std::int8_t status : one.status) CHECK(status == static_cast<int>(solve::SolveStatus::converged));
        for (const int threads : {2, 100}) {
            options.threads = threads;
            const Answers many = rows.solve(options);
            CHECK(one == many && one.messages.size() == many.messages.size());
        }
    }
}

CLAIM(what_a_row_meets_is_its_own_failure) {
    Rows rows(20);
    rows.pressures[3 * 7] = no_number;
    sweep::SweepOptions options;
    options.threads = 3;
    for (const bool ordered : {false, true}) {
        options.ordered = ordered;
        const Answers answers = rows.solve(options);
        for (std::int64_t row = 0; row < 20; ++row) CHECK(answers.success[row] == (row != 7));
        CHECK(answers.status[7] == static_cast<int>(solve::SolveStatus::no_progress));
        bool told = false;
        for (const sweep::RowMessage& message : answers.messages)
            told |= message.row == 7 && message.text.starts_with("the solver gave up: pressure must be finite");
        CHECK(told && std::isnan(answers.tip[16 * 7]));
    }
}

CLAIM(a_tick_stops_a_sweep_and_what_is_done_stays) {
    const Rows rows(100'000);
    sweep::SweepOptions options;
    options.threads = 2;
    std::int64_t told = -1;
    const Answers answers = rows.solve(options, [&](std::int64_t done) {
        told = done;
        return false;
    });
    std::int64_t done = 0;
    for (std::int64_t row = 0; row < rows.count(); ++row) {
        const bool came = answers.status[row] != sweep::not_run;
        CHECK(came == std::isfinite(answers.tip[16 * row]) && came == answers.success[row]);
        done += came;
    }
    CHECK(told >= 0 && done >= told && done < rows.count());

    struct Enough {};
    bool raised = false;
    try {
        rows.solve(options, [](std::int64_t) -> bool { throw Enough(); });
    } catch (const Enough&) {
        raised = true;
    }
    CHECK(raised);
}
