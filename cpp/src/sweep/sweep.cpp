#include "softlimb/sweep/sweep.hpp"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "worker.hpp"

namespace softlimb::sweep {

using solve::SolveStatus;

namespace {

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

/// Solves all rows of a job.
void run(Job& job, std::vector<RowMessage>& messages, const Tick& tick) {
    const std::int64_t block = block_of(job.options), useful = (job.rows + block - 1) / block;
    const int threads =
        static_cast<int>(std::clamp<std::int64_t>(job.options.threads, 1, std::max<std::int64_t>(useful, 1)));
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

}  // namespace

void sweep(const limb::Geometry& geometry, const Members& members, const limb::Scene& scene,
           const SweepOptions& options, const double* pressures, std::int64_t rows, const RowAnswers& answers,
           std::vector<RowMessage>& messages, const Tick& tick) {
    Job job{geometry, members, scene, options, pressures, rows, &answers};
    run(job, messages, tick);
}

std::optional<Atlas> survey(const limb::Geometry& geometry, const Members& members, const limb::Scene& scene,
                            const SweepOptions& options, const double* pressures, std::int64_t rows, const Tick& tick) {
    if (scene.holds_plates()) return std::nullopt;
    std::vector<Anchor> anchors;
    // Solves rows and adds them to the anchors; false where the survey must end.
    const auto add = [&](std::int64_t first, std::int64_t end, const Atlas* atlas) {
        const double* from = pressures + first * members.actuators();
        SweepOptions with = options;
        with.atlas = atlas;
        std::vector<limb::Solution> solutions(end - first);
        Job job{geometry, members, scene, with, from, end - first, nullptr};
        job.solutions = &solutions;
        std::vector<RowMessage> messages;
        run(job, messages, [&](std::int64_t done) { return tick(first + done); });
        if (job.stop) return false;
        for (std::int64_t row = 0; row < end - first; ++row) {
            limb::Solution& solution = solutions[row];
            if (solution.status != SolveStatus::converged || !solution.stable) continue;
            if (solution.second_posture) return false;
            Anchor anchor{scene, std::move(solution.shape)};
            members.at_pressures(from + row * members.actuators(), options.model, options.valve, anchor.scene.rods);
            anchors.push_back(std::move(anchor));
        }
        return true;
    };
    const std::int64_t from_nothing = std::min(rows, surveyed_from_nothing);
    if (!add(0, from_nothing, nullptr)) return std::nullopt;
    std::optional<Atlas> atlas = Atlas::fitted(geometry, anchors, options.tolerance);
    if (!atlas || from_nothing == rows) return atlas;
    if (!add(from_nothing, rows, &*atlas)) return std::nullopt;
    return Atlas::fitted(geometry, anchors, options.tolerance, &atlas->mesh());
}

}  // namespace softlimb::sweep
