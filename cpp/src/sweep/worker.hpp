#pragma once
// One thread of a sweep: takes rows, solves them, and writes what it found into the caller's arrays.
#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "softlimb/limb/posture.hpp"
#include "softlimb/limb/side_by_side.hpp"
#include "softlimb/sweep/sweep.hpp"
#include "softlimb/sweep/trail.hpp"

namespace softlimb::sweep {

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

/// Rows handed out together: an unordered sweep hands out few, so that the last worker is soon done.
constexpr std::int64_t block_of(const SweepOptions& options) { return options.ordered ? chunk_rows : 8; }

class Worker {
public:
    explicit Worker(Job& job);
    void run();

    std::vector<RowMessage> messages;

private:
    /// A row on its way in a lane.
    struct Lane {
        std::int64_t row = -1;  // none
        limb::Scene scene;
        std::vector<Pose> start;      // plates that it began with
        std::vector<double> numbers;  // of its shape: where it starts, then where it is
        rod::lanes::LaneReport report{};
    };
    /// A chunk of an ordered sweep on its way in a lane: its row, those to come, and what the others left.
    struct Chain {
        Lane lane;
        std::int64_t next = 0, end = 0;
        NumberTrail trail;
    };

    void run_row_by_row();
    void run_side_by_side(const Atlas& atlas);
    void run_chains(const Atlas& atlas);

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
    /// From the rows of its chunk that converged; else from what the sweep was given.
    void solve_by_itself(std::int64_t row);
    /// Puts the rods of a scene at a row's pressures. False where an actuator has no state there: the row is done then.
    bool put_at_pressures(std::int64_t row, limb::Scene& scene);

    /// Takes rows and finds their starts; those that an actuator refuses are done. False where there are no more.
    bool prepare(const Atlas& atlas, std::vector<Lane>& fresh, std::size_t& ready);
    /// The next row of a chain, or of the next chunk, that an actuator does not refuse, and its start.
    bool next_row(const Atlas& atlas, Chain& chain);
    /// Makes a limb that was taken out of its lane the posture. False where it is no answer that stands by itself.
    bool accept(const limb::Mesh& mesh, Lane& lane);
    /// Where a row of a chain starts: where the rows before it lead, or the atlas.
    void find_start(const Atlas& atlas, Chain& chain);
    /// A row of a chain that its lane has ended with.
    void settle(const limb::Mesh& mesh, Chain& chain);

    /// Says what there is to say of the posture, and hands it out.
    void finish(std::int64_t row);
    void write(std::int64_t row, const limb::Clearance& nearest) const;
    /// Nothing that a row meets may end the others.
    void fail(std::int64_t row, const char* what);

    Job& job_;
    limb::Posture posture_;
    limb::SolveOptions options_;
    ShapeTrail trail_;   // of an ordered sweep's chunk
    limb::Shape given_;  // the start of a row, as a shape; in lanes its plates alone
    Atlas::Room atlas_room_;
};

}  // namespace softlimb::sweep
