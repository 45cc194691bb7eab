#include "softlimb/sweep/sweep.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <limits>
#include <memory>
#include <mutex>
#include <thread>

#include "softlimb/limb/attempt.hpp"
#include "softlimb/limb/posture.hpp"
#include "softlimb/limb/side_by_side.hpp"
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
    const RowAnswers* answers;                   // null: the solutions are wanted instead
    std::atomic<std::int64_t> next{0}, done{0};  // first row that nobody has taken; rows solved
    std::atomic<bool> stop{false};
    std::vector<limb::Solution>* solutions = nullptr;  // where they are to be kept
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
        if (job_.options.atlas)
            run_side_by_side(*job_.options.atlas);
        else
            run_row_by_row();
    }

    std::vector<RowMessage> messages;

private:
    void run_row_by_row() {
        const std::int64_t block = block_of(job_.options);
        while (!job_.stop) {
            const std::int64_t first = job_.next.fetch_add(block);
            if (first >= job_.rows) return;
            trail_.clear();
            for (std::int64_t row = first; row < std::min(first + block, job_.rows); ++row) {
                const auto solve = [&] {
                    take(row);
                    return true;
                };
                if (job_.stop || !guarded(row, solve)) return;
            }
        }
    }

    /// Does a task of a row, which says whether the row is done with it; nothing that it meets may end the others.
    /// False after a stop.
    template <class Task>
    bool guarded(std::int64_t row, Task&& task) {
        bool done = true;
        try {
            done = task();
        } catch (const solve::Interrupted&) {
            return false;
        } catch (const std::exception& error) {
            fail(row, error.what());
        }
        if (done) job_.done.fetch_add(1, std::memory_order_relaxed);
        return true;
    }

    const double* pressures_of(std::int64_t row) const { return job_.pressures + row * job_.members.actuators(); }

    void take(std::int64_t row) {
        const double* pressures = pressures_of(row);
        if (!put_at_pressures(row, posture_.scene)) return;
        posture_.solution = solve_row(job_.geometry, posture_.scene, options_, start_of_row(pressures));
        finish(row);
        if (job_.options.ordered && posture_.solution.status == SolveStatus::converged)
            trail_.add(pressures, std::move(posture_.solution.shape));
    }

    /// Puts the rods of a scene at a row's pressures. False where an actuator has no state there: the row is done then.
    bool put_at_pressures(std::int64_t row, limb::Scene& scene) {
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

    /// Says what there is to say of the posture, and hands it out.
    void finish(std::int64_t row) {
        if (job_.solutions) {
            (*job_.solutions)[row] = posture_.solution;
            return;
        }
        std::string message = posture_.solution.message;
        limb::Clearance nearest;
        if (posture_.solution.status == SolveStatus::converged) {
            nearest = limb::clearance(posture_, job_.members.radii(), clearance_points);
            for (const std::string& remark : limb::remarks(posture_, nearest)) message += "; " + remark;
        }
        if (message != "converged") messages.push_back({row, std::move(message)});
        write(row, nearest);
    }

    // --- side by side ---

    /// A row on its way.
    struct Lane {
        std::int64_t row = -1;
        limb::Scene scene;
        std::vector<Pose> start;     // plates that it began with
        std::vector<double> numbers;  // of its shape now
        rod::lanes::LaneReport report{};
    };

    /// Rounds of limbs that have as many behind them, none or some: all want the same passes then.
    void run_side_by_side(const Atlas& atlas) {
        limb::SideBySide limbs(job_.geometry, job_.scene, atlas.mesh(), job_.options.tolerance);
        const std::size_t width = limbs.width();
        std::vector<Lane> lanes(width), fresh(Atlas::together), begun(2 * width);
        for (std::vector<Lane>* all : {&lanes, &fresh, &begun})
            for (Lane& lane : *all) lane.scene = job_.scene;
        std::size_t ready = 0, waiting = 0;  // of the fresh ones, and of those begun
        while (!job_.stop) {
            const bool go_on = waiting >= width || !(ready > 0 || prepare(atlas, fresh, ready));
            std::size_t here = 0;
            for (; here < width && (go_on ? waiting > 0 : ready > 0 || prepare(atlas, fresh, ready)); ++here) {
                Lane& lane = lanes[here];
                std::swap(lane, go_on ? begun[--waiting] : fresh[--ready]);
                limbs.fill(static_cast<int>(here), lane.scene, lane.numbers.data(), go_on ? &lane.report : nullptr);
            }
            if (here == 0) return;
            limbs.round();
            for (std::size_t i = 0; i < here; ++i) {
                Lane& lane = lanes[i];
                lane.report = limbs.report(static_cast<int>(i));
                limbs.take(static_cast<int>(i), lane.numbers.data());
                if (lane.report.status == rod::lanes::LaneStatus::running) {
                    std::swap(lane, begun[waiting++]);
                    continue;
                }
                const auto settle = [&] {
                    if (!accept(atlas.mesh(), lane))
                        posture_.solution = solve_row(job_.geometry, posture_.scene, options_, nullptr);
                    finish(lane.row);
                    return true;
                };
                if (!guarded(lane.row, settle)) return;
            }
        }
    }

    /// Takes rows and finds their starts; those that an actuator refuses are done. False where there are no more.
    bool prepare(const Atlas& atlas, std::vector<Lane>& fresh, std::size_t& ready) {
        while (ready == 0) {
            const std::int64_t first = job_.next.fetch_add(Atlas::together);
            if (first >= job_.rows) return false;
            for (std::int64_t row = first; row < std::min<std::int64_t>(first + Atlas::together, job_.rows); ++row) {
                fresh[ready].row = row;
                const auto put = [&] {
                    if (!put_at_pressures(row, fresh[ready].scene)) return true;
                    ++ready;
                    return false;
                };
                if (!guarded(row, put)) return false;
            }
        }
        const std::vector<limb::RodAtPressure>* rods[Atlas::together];
        for (std::size_t i = 0; i < ready; ++i) rods[i] = &fresh[i].scene.rods;
        atlas.starts(job_.geometry, rods, static_cast<int>(ready), atlas_room_);
        for (std::size_t i = 0; i < ready; ++i) {
            std::swap(fresh[i].numbers, atlas_room_.numbers[i]);
            limb::numbers_to_plates(job_.geometry, fresh[i].numbers.data(), fresh[i].start);
        }
        return true;
    }

    /// Makes a limb that was taken out of its lane the posture. False where it is no answer that stands by itself.
    bool accept(const limb::Mesh& mesh, Lane& lane) {
        const rod::lanes::LaneReport& report = lane.report;
        std::swap(posture_.scene.rods, lane.scene.rods);
        limb::Solution& solution = posture_.solution;
        solution = {};
        limb::numbers_to_shape(job_.geometry, mesh, lane.numbers.data(), solution.shape);
        given_.plates = lane.start;
        // What is farther away may be another posture than the one that the row leads to.
        constexpr double farthest = 0.5;
        if (report.status != rod::lanes::LaneStatus::converged || !report.stable ||
            !limb::mesh_suffices(posture_.scene, job_.options.tolerance, solution.shape) ||
            !(limb::distance(job_.geometry, given_, solution.shape) < farthest))
            return false;
        solution.status = SolveStatus::converged, solution.message = "converged";
        solution.iterations = report.iterations;
        solution.residual = report.residual, solution.error_estimate = report.error;
        solution.conservative = posture_.scene.conservative(), solution.stable = true;
        if (solution.conservative) solution.unstable_modes = 0;
        return true;
    }

    // ---

    /// From the rows of its chunk that converged; else what the sweep was given.
    const limb::Shape* start_of_row(const double* pressures) {
        if (const limb::Shape* shape = trail_.start(job_.geometry, pressures)) return shape;
        if (!job_.options.start_plates) return job_.options.start;
        given_ = limb::start_from_plates(job_.geometry, posture_.scene, *job_.options.start_plates);
        return &given_;
    }

    void write(std::int64_t row, const limb::Clearance& nearest) const {
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

    /// Nothing that a row meets may end the others.
    void fail(std::int64_t row, const char* what) {
        if (!job_.answers) return;
        job_.answers->success[row] = false;
        job_.answers->status[row] = static_cast<std::int8_t>(SolveStatus::no_progress);
        try {
            messages.push_back({row, std::string("the solver gave up: ") + what});
        } catch (const std::exception&) {  // no memory even for this
        }
    }

    Job& job_;
    limb::Posture posture_;
    limb::SolveOptions options_;
    Trail trail_;        // of an ordered sweep's chunk
    limb::Shape given_;  // the start of a row, as a shape; side by side its plates alone
    Atlas::Room atlas_room_;
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
    for (const limb::Hold& hold : scene.holds)
        if (hold.any()) return std::nullopt;
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
