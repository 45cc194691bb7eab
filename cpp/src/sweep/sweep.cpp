#include "softlimb/sweep/sweep.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <limits>
#include <memory>
#include <mutex>
#include <thread>

#include "softlimb/limb/posture.hpp"
#include "softlimb/limb/start.hpp"
#include "softlimb/sweep/trail.hpp"

namespace softlimb::sweep {

using solve::SolveStatus;

namespace {

constexpr int clearance_points = 25;  // as for a posture: good to a thousandth of a rod

/// Rows handed out together: an unordered sweep hands out few, so that the last worker is soon done.
constexpr std::int64_t block_of(const SweepOptions& options) { return options.ordered ? chunk_rows : 8; }

/// What all workers read, and the little that they share.
struct Job {
    const limb::Geometry& geometry;
    const Members& members;
    const limb::Scene& scene;
    const SweepOptions& options;
    const double* pressures;
    std::int64_t rows;
    const RowAnswers& answers;
    std::atomic<std::int64_t> next{0}, done{0};  // first row that nobody has taken; rows solved
    std::atomic<bool> stop{false};
};

/// One posture of the sweep, from a start or from nothing.
limb::Solution solve_row(const limb::Geometry& geometry, const limb::Scene& scene, const limb::SolveOptions& options,
                         const limb::Shape* start) {
    return limb::solve(geometry, scene, options, start);
}

class Worker {
public:
    explicit Worker(Job& job) : job_(job), trail_(job.members.actuators()) {
        // The posture only looks at the geometry, which outlives it.
        posture_.geometry = std::shared_ptr<const limb::Geometry>(std::shared_ptr<void>(), &job.geometry);
        posture_.scene = job.scene;
        options_.tolerance = job.options.tolerance;
        options_.prefer_stable = job.options.prefer_stable;
        options_.interrupted = [&stop = job.stop] { return stop.load(std::memory_order_relaxed); };
    }

    void run() {
        const std::int64_t block = block_of(job_.options);
        while (!job_.stop) {
            const std::int64_t first = job_.next.fetch_add(block);
            if (first >= job_.rows) return;
            trail_.clear();
            for (std::int64_t row = first; row < std::min(first + block, job_.rows); ++row) {
                if (job_.stop) return;
                try {
                    take(row);
                } catch (const solve::Interrupted&) {
                    return;
                } catch (const std::exception& error) {
                    fail(row, error.what());
                }
                job_.done.fetch_add(1, std::memory_order_relaxed);
            }
        }
    }

    std::vector<RowMessage> messages;

private:
    void take(std::int64_t row) {
        const SweepOptions& options = job_.options;
        limb::Solution& solution = posture_.solution;
        const double* pressures = job_.pressures + row * job_.members.actuators();
        const Members::Refusal refusal =
            job_.members.at_pressures(pressures, options.model, options.valve, posture_.scene.rods);
        std::string message;
        if (refusal) {
            solution = {};
            solution.status = refusal.status;
            solution.residual = std::numeric_limits<double>::infinity();
            message = job_.members.reason(refusal);
        } else {
            solution = solve_row(job_.geometry, posture_.scene, options_, start_of_row(pressures));
            message = solution.message;
        }
        limb::Clearance nearest;
        if (solution.status == SolveStatus::converged) {
            nearest = limb::clearance(posture_, job_.members.radii(), clearance_points);
            for (const std::string& remark : limb::remarks(posture_, nearest)) message += "; " + remark;
        }
        if (message != "converged") messages.push_back({row, std::move(message)});
        write(row, nearest);
        if (options.ordered && solution.status == SolveStatus::converged)
            trail_.add(pressures, std::move(solution.shape));
    }

    /// From the rows of its chunk that converged; else what the sweep was given.
    const limb::Shape* start_of_row(const double* pressures) {
        if (const limb::Shape* shape = trail_.start(job_.geometry, pressures)) return shape;
        if (!job_.options.start_plates) return job_.options.start;
        given_ = limb::start_from_plates(job_.geometry, posture_.scene, *job_.options.start_plates);
        return &given_;
    }

    void write(std::int64_t row, const limb::Clearance& nearest) const {
        const limb::Solution& solution = posture_.solution;
        const RowAnswers& to = job_.answers;
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

    /// Nothing that a row meets may end the others.
    void fail(std::int64_t row, const char* what) {
        job_.answers.success[row] = false;
        job_.answers.status[row] = static_cast<std::int8_t>(SolveStatus::no_progress);
        try {
            messages.push_back({row, std::string("the solver gave up: ") + what});
        } catch (const std::exception&) {  // no memory even for this
        }
    }

    Job& job_;
    limb::Posture posture_;
    limb::SolveOptions options_;
    Trail trail_;        // of an ordered sweep's chunk
    limb::Shape given_;  // the start that the sweep was given, as a shape
};

/// Waits until everybody is done, and looks up ten times a second.
class Watch {
public:
    explicit Watch(int workers) : working_(workers) {}

    void worker_is_done() {
        const std::lock_guard lock(mutex_);
        --working_;
        changed_.notify_one();
    }
    /// True when all are done.
    bool wait() {
        std::unique_lock lock(mutex_);
        return changed_.wait_for(lock, std::chrono::milliseconds(100), [this] { return working_ == 0; });
    }

private:
    std::mutex mutex_;
    std::condition_variable changed_;
    int working_;
};

}  // namespace

void sweep(const limb::Geometry& geometry, const Members& members, const limb::Scene& scene,
           const SweepOptions& options, const double* pressures, std::int64_t rows, const RowAnswers& answers,
           std::vector<RowMessage>& messages, const Tick& tick) {
    Job job{geometry, members, scene, options, pressures, rows, answers};
    const std::int64_t useful = (rows + block_of(options) - 1) / block_of(options);
    const int threads =
        static_cast<int>(std::clamp<std::int64_t>(options.threads, 1, std::max<std::int64_t>(useful, 1)));
    std::vector<Worker> workers;
    workers.reserve(threads);
    for (int i = 0; i < threads; ++i) workers.emplace_back(job);
    Watch watch(threads);
    std::vector<std::thread> pool;
    pool.reserve(threads);
    std::exception_ptr raised;
    try {
        for (Worker& worker : workers)
            pool.emplace_back([&worker, &watch] {
                worker.run();
                watch.worker_is_done();
            });
    } catch (const std::exception&) {
        // The system has no more threads, or no memory for them: those that there are take all the rows, or this one
        // does without a watch.
        for (std::size_t i = pool.size(); i < workers.size(); ++i) watch.worker_is_done();
        if (pool.empty()) workers.front().run();
    }
    try {
        while (!watch.wait())
            if (!job.stop && !tick(job.done)) job.stop = true;
    } catch (...) {
        raised = std::current_exception();
        job.stop = true;
    }
    for (std::thread& thread : pool) thread.join();
    for (Worker& worker : workers)
        messages.insert(messages.end(), std::make_move_iterator(worker.messages.begin()),
                        std::make_move_iterator(worker.messages.end()));
    std::sort(messages.begin(), messages.end(), [](const RowMessage& a, const RowMessage& b) { return a.row < b.row; });
    if (raised) std::rethrow_exception(raised);
}

}  // namespace softlimb::sweep
