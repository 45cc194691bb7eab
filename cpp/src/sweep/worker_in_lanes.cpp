// Rows that start near their answers, a limb a lane: those of an unordered sweep from an atlas, those of an ordered one
// from the rows of their chunk.
#include <algorithm>

#include "softlimb/limb/attempt.hpp"
#include "worker.hpp"

namespace softlimb::sweep {

using rod::lanes::LaneStatus;
using solve::SolveStatus;

/// Rounds of limbs that have as many behind them, none or some: all want the same passes then.
void Worker::run_side_by_side(const Atlas& atlas) {
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
            if (lane.report.status == LaneStatus::running) {
                std::swap(lane, begun[waiting++]);
                continue;
            }
            const auto settle = [&] {
                if (!accept(atlas.mesh(), lane))
                    posture_.solution = limb::solve(job_.geometry, posture_.scene, options_, nullptr);
                finish(lane.row);
                return true;
            };
            if (!guarded(lane.row, settle)) return;
        }
    }
}

bool Worker::prepare(const Atlas& atlas, std::vector<Lane>& fresh, std::size_t& ready) {
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

/// Chunks side by side, a chunk a lane, each row when the one before it is done.
void Worker::run_chains(const Atlas& atlas) {
    constexpr int corrections = 0;
    limb::SideBySide limbs(job_.geometry, job_.scene, atlas.mesh(), job_.options.tolerance, corrections);
    std::vector<Chain> chains(limbs.width());
    for (Chain& chain : chains) chain.lane.scene = job_.scene;
    while (!job_.stop) {
        bool working = false;
        for (int i = 0; i < limbs.width(); ++i) {
            Lane& lane = chains[i].lane;
            if (lane.row < 0 && next_row(atlas, chains[i])) limbs.fill(i, lane.scene, lane.numbers.data());
            working = working || lane.row >= 0;
        }
        if (!working) return;
        limbs.round();
        for (int i = 0; i < limbs.width(); ++i) {
            Lane& lane = chains[i].lane;
            if (lane.row < 0) continue;
            lane.report = limbs.report(i);
            if (lane.report.status == LaneStatus::running) continue;
            limbs.take(i, lane.numbers.data());
            const auto end = [&] {
                settle(atlas.mesh(), chains[i]);
                return true;
            };
            if (!guarded(lane.row, end)) return;
            lane.row = -1;
        }
    }
}

bool Worker::next_row(const Atlas& atlas, Chain& chain) {
    Lane& lane = chain.lane;
    while (!job_.stop) {
        if (chain.next == chain.end) {
            chain.next = job_.next.fetch_add(chunk_rows);
            if (chain.next >= job_.rows) {
                chain.next = chain.end = job_.rows;
                return false;
            }
            chain.end = std::min(chain.next + chunk_rows, job_.rows);
            chain.trail.clear(job_.members.actuators());
        }
        const std::int64_t row = chain.next++;
        bool found = false;
        const auto put = [&] {
            if (!put_at_pressures(row, lane.scene)) return true;
            found = true;
            return false;
        };
        if (!guarded(row, put)) return false;
        if (!found) continue;
        lane.row = row;
        find_start(atlas, chain);
        limb::numbers_to_plates(job_.geometry, lane.numbers.data(), lane.start);
        return true;
    }
    return false;
}

void Worker::find_start(const Atlas& atlas, Chain& chain) {
    Lane& lane = chain.lane;
    const NumberTrail::Led led = chain.trail.start(job_.geometry, atlas.mesh(), pressures_of(lane.row), lane.numbers);
    if (led == NumberTrail::Led::on) return;
    const std::vector<limb::RodAtPressure>* rods[] = {&lane.scene.rods};
    atlas.starts(job_.geometry, rods, 1, atlas_room_);
    const std::vector<double>& found = atlas_room_.numbers[0];
    if (led == NumberTrail::Led::nearest) {
        // The atlas errs by some hundredths; where a grid begins a new line, the nearest row is farther away.
        constexpr double far = 0.1;
        limb::numbers_to_plates(job_.geometry, lane.numbers.data(), lane.start);
        limb::numbers_to_plates(job_.geometry, found.data(), given_.plates);
        if (limb::distance(job_.geometry, {lane.start, {}}, given_) < far) return;
    }
    lane.numbers = found;
}

void Worker::settle(const limb::Mesh& mesh, Chain& chain) {
    Lane& lane = chain.lane;
    limb::Solution& solution = posture_.solution;
    if (!accept(mesh, lane)) {
        // By itself, from where the rows before it lead.
        const double* pressures = pressures_of(lane.row);
        const bool led = chain.trail.start(job_.geometry, mesh, pressures, lane.numbers) != NumberTrail::Led::none;
        if (led) limb::numbers_to_shape(job_.geometry, mesh, lane.numbers.data(), given_);
        solution = limb::solve(job_.geometry, posture_.scene, options_, led ? &given_ : nullptr);
        if (solution.status == SolveStatus::converged)
            limb::shape_to_numbers(limb::on_mesh(job_.geometry, posture_.scene, solution.shape, mesh), lane.numbers);
    }
    finish(lane.row);
    if (solution.status == SolveStatus::converged) chain.trail.add(pressures_of(lane.row), lane.numbers);
}

bool Worker::accept(const limb::Mesh& mesh, Lane& lane) {
    const rod::lanes::LaneReport& report = lane.report;
    std::swap(posture_.scene.rods, lane.scene.rods);
    limb::Solution& solution = posture_.solution;
    solution = {};
    limb::numbers_to_shape(job_.geometry, mesh, lane.numbers.data(), solution.shape);
    given_.plates = lane.start;
    // What is farther away may be another posture than the one that the row leads to.
    constexpr double farthest = 0.5;
    if (report.status != LaneStatus::converged || !report.stable ||
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

}  // namespace softlimb::sweep
