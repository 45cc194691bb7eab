#pragma once
// Rows of pressures in, rows of postures out, on as many threads as one likes.
//
//   blocks of rows, handed out one by one -> a worker: members at the row's pressures -> limb::solve -> the caller's
//   arrays
//
// In a long sweep some rows are solved first and an atlas is fitted to them; with it the rows start near their answers
// and are solved side by side (limb/side_by_side.hpp). Those that do not arrive there are solved as without it.
//
// A row depends on itself, and on the atlas, alone (in an ordered sweep: on its chunk, whose size is fixed), and
// workers share nothing that changes: the bits are the same for any number of threads and any order of the rows.
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "softlimb/limb/posture.hpp"
#include "softlimb/sweep/atlas.hpp"
#include "softlimb/sweep/members.hpp"

namespace softlimb::sweep {

struct SweepOptions {
    actuator::SectionModel model = actuator::SectionModel::tangent;
    actuator::Valve valve = actuator::Valve::open;
    double tolerance = 1e-6;
    bool prefer_stable = true;
    bool ordered = false;  // each row starts from those before it in its chunk, see trail.hpp
    int threads = 1;
    const limb::Posture* start = nullptr;             // of rows that start by themselves: a posture,
    const std::vector<Pose>* start_plates = nullptr;  // or plates; neither: by limb::solve's own rule
    const Atlas* atlas = nullptr;                     // of rows that are solved side by side; not with a start
};

/// Rows that an ordered sweep chains; the first of each chunk starts by itself.
constexpr std::int64_t chunk_rows = 32;

/// A row that nobody came to.
constexpr std::int8_t not_run = -1;

/// Where the answers go: arrays of the caller, one entry a row. A row writes `status` last; poses, stability and
/// clearance only where it converged, so what stands there before is what rows without an answer have.
struct RowAnswers {
    double* tip;                   // 4 x 4 each, row by row
    double* plates;                // 4 x 4 a plate
    std::int8_t* status;           // number of a solve::SolveStatus, or not_run
    bool* success;                 // status converged
    bool* stable;                  // false as well where it is not known
    std::int64_t* unstable_modes;  // -1: not known
    double* clearance;             // [m]; NaN without two radii
    std::int64_t* iterations;
    double* residual;
};

/// What a row says beyond its status.
struct RowMessage {
    std::int64_t row;
    std::string text;
};

/// Called with the number of rows done; false stops the sweep.
using Tick = std::function<bool(std::int64_t)>;

/// Solves the rows of `pressures`, one number an actuator [Pa], under the loads and holds of `scene`, whose sections
/// and rest lengths do not count. `tick` is asked from the calling thread about ten times a second. Rows done before a
/// stop stay done; `messages` are in the order of the rows. Raises what `tick` raises, once every worker has stopped;
/// what a worker meets is its row's failure.
void sweep(const limb::Geometry& geometry, const Members& members, const limb::Scene& scene,
           const SweepOptions& options, const double* pressures, std::int64_t rows, const RowAnswers& answers,
           std::vector<RowMessage>& messages, const Tick& tick);

/// Rows of a survey that are solved from nothing; what they lead to serves as start for the others.
constexpr std::int64_t surveyed_from_nothing = 384;

/// Solves `rows` rows of pressures and fits an atlas to them. None where an atlas does not serve: too few
/// of them have an answer, the limb is held, or another stable posture was seen, because then a row should say so.
/// `tick` as above; none after a stop.
std::optional<Atlas> survey(const limb::Geometry& geometry, const Members& members, const limb::Scene& scene,
                            const SweepOptions& options, const double* pressures, std::int64_t rows, const Tick& tick);

}  // namespace softlimb::sweep
