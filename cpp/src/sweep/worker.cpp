#include "worker.hpp"

#include <algorithm>
#include <limits>
#include <memory>

#include "softlimb/limb/start.hpp"

namespace softlimb::sweep {

using solve::SolveStatus;

Worker::Worker(Job& job) : job_(job), trail_(job.members.actuators()) {
    // The posture only looks at the geometry, which outlives it.
    posture_.geometry = std::shared_ptr<const limb::Geometry>(std::shared_ptr<void>(), &job.geometry);
    posture_.scene = job.scene;
    options_.tolerance = job.options.tolerance;
    options_.prefer_stable = job.options.prefer_stable;
    options_.interrupted = [&stop = job.stop] { return stop.load(std::memory_order_relaxed); };
}

void Worker::run() {
    const Atlas* atlas = job_.options.atlas;
    if (!atlas)
        run_row_by_row();
    else if (job_.options.ordered)
        run_chains(*atlas);
    else
        run_side_by_side(*atlas);
}

void Worker::run_row_by_row() {
    const std::int64_t block = block_of(job_.options);
    while (!job_.stop) {
        const std::int64_t first = job_.next.fetch_add(block);
        if (first >= job_.rows) return;
        trail_.clear();
        for (std::int64_t row = first; row < std::min(first + block, job_.rows); ++row) {
            const auto solve = [&] {
                solve_by_itself(row);
                return true;
            };
            if (job_.stop || !guarded(row, solve)) return;
        }
    }
}

void Worker::solve_by_itself(std::int64_t row) {
    const double* pressures = pressures_of(row);
    if (!put_at_pressures(row, posture_.scene)) return;
    const limb::Shape* led = trail_.start(job_.geometry, pressures);
    if (!led && job_.options.start_plates) {
        given_ = limb::start_from_plates(job_.geometry, posture_.scene, *job_.options.start_plates);
        led = &given_;
    }
    posture_.solution = !led && job_.options.start
                            ? limb::solve(job_.geometry, posture_.scene, options_, job_.options.start->solved())
                            : limb::solve(job_.geometry, posture_.scene, options_, led);
    finish(row);
    if (job_.options.ordered && posture_.solution.status == SolveStatus::converged)
        trail_.add(pressures, std::move(posture_.solution.shape));
}

bool Worker::put_at_pressures(std::int64_t row, limb::Scene& scene) {
    const SweepOptions& options = job_.options;
    const Members::Refusal refusal =
        job_.members.at_pressures(pressures_of(row), options.model, options.valve, scene.rods);
    if (!refusal) return true;
    if (!job_.answers) return false;
    limb::Solution& solution = posture_.solution;
    solution = {};
    solution.status = refusal.status;
    solution.residual = std::numeric_limits<double>::infinity();
    messages.push_back({row, job_.members.reason(refusal)});
    write(row, {});
    return false;
}

void Worker::finish(std::int64_t row) {
    if (job_.solutions) {
        (*job_.solutions)[row] = posture_.solution;
        return;
    }
    constexpr int clearance_points = 25;  // as for a posture: good to a thousandth of a rod
    std::string message = posture_.solution.message;
    limb::Clearance nearest;
    if (posture_.solution.status == SolveStatus::converged) {
        nearest = limb::clearance(posture_, job_.members.radii(), clearance_points);
        for (const std::string& remark : limb::remarks(posture_, nearest)) message += "; " + remark;
    }
    if (message != "converged") messages.push_back({row, std::move(message)});
    write(row, nearest);
}

void Worker::write(std::int64_t row, const limb::Clearance& nearest) const {
    const limb::Solution& solution = posture_.solution;
    const RowAnswers& to = *job_.answers;
    to.iterations[row] = solution.iterations;
    to.residual[row] = solution.residual;
    if (solution.status == SolveStatus::converged) {
        const std::vector<Pose>& plates = solution.shape.plates;
        for (std::size_t j = 0; j < plates.size(); ++j)
            write_matrix(plates[j], to.plates + 16 * (static_cast<std::size_t>(row) * plates.size() + j));
        write_matrix(plates.back(), to.tip + 16 * row);
        to.stable[row] = solution.stable;
        to.unstable_modes[row] = solution.unstable_modes.value_or(-1);
        to.clearance[row] = nearest.first < 0 ? std::numeric_limits<double>::quiet_NaN() : nearest.gap;
        to.success[row] = true;
    }
    to.status[row] = static_cast<std::int8_t>(solution.status);
}

void Worker::fail(std::int64_t row, const char* what) {
    if (!job_.answers) return;
    job_.answers->success[row] = false;
    job_.answers->status[row] = static_cast<std::int8_t>(SolveStatus::no_progress);
    try {
        messages.push_back({row, std::string("the solver gave up: ") + what});
    } catch (const std::exception&) {  // no memory even for this
    }
}

}  // namespace softlimb::sweep
