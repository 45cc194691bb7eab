#include "softlimb/limb/descent.hpp"

#include <algorithm>
#include <random>

#include "softlimb/largest.hpp"
#include "softlimb/limb/start.hpp"

namespace softlimb::limb {
namespace {

// Multipliers of the trust region, in units of the rods' bending stiffness. Far from the answer one to a hundred are
// needed, so the ladder starts there; from step to step it comes down tenfold, and a column a thousandth past buckling
// needs 1e-3 and less. Below `neutral` a curvature is none.
constexpr double neutral = 1e-9, lowest_rung = 1e-5, first_rung = 1.0;

double next_rung(double multiplier) {
    if (multiplier == 0.0) return first_rung;
    return multiplier < 1e-3 ? std::max(lowest_rung, 10.0 * multiplier) : 4.0 * multiplier;
}

rod::RodPiece piece_of(const Scene& scene, const Section& section, const Shape& shape, int i) {
    return {&section, scene.rods[i].rest_length / shape.rods[i].elements(), scene.line_load(i)};
}

/// Largest bend of an element [rad].
double largest_angle(const std::vector<Vector6>& twists) {
    double largest = 0.0;
    for (const Vector6& xi : twists) grow(largest, xi.tail<3>().norm());
    return largest;
}

}  // namespace

void Descent::resize(const Shape& shape) {
    const int rods = static_cast<int>(shape.rods.size());
    chains_.resize(rods), sections_.resize(rods);
    elements_ = shape.pieces();
    double length = 0.0;
    for (int i = 0; i < rods; ++i) {
        chains_[i].resize(shape.rods[i].elements());
        sections_[i] = softened(scene_.rods[i], shape.rods[i].elements());
        length += scene_.rods[i].rest_length / rods;
    }
    balance_.resize(geometry_.plates());
    moves_.set_zero(geometry_, shape);
    length_scale_ = 0.5 * length;
    // Each rod in units of its own stiffness: a thin rod beside a stiff one would not be seen in those of both.
    node_metric_.resize(rods);
    plate_metric_.assign(geometry_.plates(), Vector6::Zero());
    int i = 0;
    for (int j = 0; j < geometry_.plates(); ++j) {
        const auto count = static_cast<double>(geometry_.segments[j].rods.size());
        for (std::size_t k = 0; k < geometry_.segments[j].rods.size(); ++k, ++i) {
            const double bending = scene_.rods[i].section.bending / scene_.rods[i].rest_length;
            node_metric_[i] << Vector3::Constant(bending / (length_scale_ * length_scale_)), Vector3::Constant(bending);
            plate_metric_[j] += node_metric_[i] / count;
        }
    }
}

bool Descent::linearise(const Shape& shape, const std::vector<Vector6>& twists) {
    lanes_.clear(), lane_ends_.clear();
    assembled_ = false;
    for (std::size_t i = 0; i < shape.rods.size(); ++i) {
        const rod::RodPiece piece = piece_of(scene_, sections_[i], shape, static_cast<int>(i));
        const RodShape& rod = shape.rods[i];
        for (int e = 0; e < rod.elements(); ++e) {
            rod::ElementStiffness& element = chains_[i].element(e);
            const Vector6& twist = twists[lanes_.size()];
            lanes_.push_back(rod::geodesic_lane(piece, twist, rod.nodes[e].rotation, rod.nodes[e + 1].rotation));
            lane_ends_.push_back({element.force.data(), element.stiffness.data()});
        }
    }
    rod::lanes::kernel().geodesics(lanes_.data(), lane_ends_.data(), static_cast<int>(lanes_.size()));
    for (const rod::Chain& chain : chains_)
        for (int e = 0; e < chain.elements(); ++e)
            if (!chain.element(e).force.allFinite() || !chain.element(e).stiffness.allFinite()) return false;
    return true;
}

bool Descent::factor(const Shape& shape, double multiplier) {
    // Rods without interior nodes bring the same to the balance whatever the multiplier.
    const bool unshifted = elements_ == static_cast<int>(chains_.size());
    if (!unshifted || !assembled_) {
        for (std::size_t i = 0; i < chains_.size(); ++i)
            if (!chains_[i].condense(multiplier * node_metric_[i], true, true)) return false;
        balance_.assemble(geometry_, scene_, shape.plates, chains_, true);
        assembled_ = true;
    }
    for (int j = 0; j < geometry_.plates(); ++j) balance_.shift(j, multiplier * plate_metric_[j]);
    return balance_.factor_positive();
}

void Descent::solve_for_step(const Shape& shape) {
    balance_.solve(balance_.residual(), moves_.plates);
    Balance::move_ends(geometry_, shape.plates, moves_.plates, moves_.nodes);
    for (std::size_t i = 0; i < chains_.size(); ++i) {
        auto& nodes = moves_.nodes[i];
        chains_[i].recover(nodes);
    }
}

void Descent::solve_for_unstable_mode(const Shape& shape) {
    // Inverse iteration with the shifted Hessian, which is barely positive definite: the direction turns into the
    // lowest mode within a few solves. The start is random but seeded: the same scene gives the same answer.
    std::mt19937 generator(20261122u);
    std::normal_distribution<double> normal;
    const auto draw = [&](const Vector6& metric) {
        Vector6 v;
        for (int k = 0; k < 6; ++k) v(k) = normal(generator) * metric(k);
        return v;
    };
    std::vector<Vector6> plate_rhs(geometry_.plates());
    std::vector<std::vector<Vector12>> loads(chains_.size());
    std::vector<std::vector<Vector6>> interior(chains_.size());
    std::vector<Vector12> rod_ends(chains_.size());
    for (std::size_t j = 0; j < plate_rhs.size(); ++j) plate_rhs[j] = draw(plate_metric_[j]);
    for (std::size_t i = 0; i < chains_.size(); ++i) {
        loads[i].assign(chains_[i].elements(), Vector12::Zero());
        interior[i].assign(chains_[i].elements() + 1, Vector6::Zero());
        for (int e = 1; e < chains_[i].elements(); ++e) loads[i][e].head<6>() = draw(node_metric_[i]);
    }
    for (int round = 0; round < 8; ++round) {
        for (std::size_t i = 0; i < chains_.size(); ++i) rod_ends[i] = chains_[i].condense_loads(loads[i], interior[i]);
        std::vector<Vector6> rhs(geometry_.plates());
        Balance::carry(geometry_, shape.plates, rod_ends, rhs);
        for (int j = 0; j < geometry_.plates(); ++j) rhs[j] = balance_.projector(j) * (rhs[j] + plate_rhs[j]);
        balance_.solve(rhs, moves_.plates);
        Balance::move_ends(geometry_, shape.plates, moves_.plates, moves_.nodes);
        for (std::size_t i = 0; i < chains_.size(); ++i) {
            auto& nodes = moves_.nodes[i];
            chains_[i].recover_with(interior[i], nodes);
        }
        moves_ *= 1.0 / std::max(step_size(shape), 1e-300);
        for (int j = 0; j < geometry_.plates(); ++j) plate_rhs[j] = plate_metric_[j].cwiseProduct(moves_.plates[j]);
        for (std::size_t r = 0; r < chains_.size(); ++r)
            for (int e = 1; e < chains_[r].elements(); ++e)
                loads[r][e].head<6>() = node_metric_[r].cwiseProduct(moves_.nodes[r][e]);
    }
}

double Descent::step_size(const Shape& shape) const { return largest_deformation(shape, moves_, length_scale_); }

double Descent::slope_along_step(const Shape& shape) const {
    double slope = 0.0;
    for (std::size_t i = 0; i < chains_.size(); ++i)
        for (int e = 0; e < chains_[i].elements(); ++e) {
            const Vector12& force = chains_[i].element(e).force;
            slope += force.head<6>().dot(moves_.nodes[i][e]) + force.tail<6>().dot(moves_.nodes[i][e + 1]);
        }
    for (int j = 0; j < geometry_.plates(); ++j)
        slope -= plate_load(geometry_, scene_, shape.plates[j], j, nullptr).dot(moves_.plates[j]);
    return slope;
}

double Descent::metric_norm_squared() const {
    double norm = 0.0;
    for (std::size_t j = 0; j < moves_.plates.size(); ++j)
        norm += moves_.plates[j].dot(plate_metric_[j].cwiseProduct(moves_.plates[j]));
    for (std::size_t i = 0; i < moves_.nodes.size(); ++i)
        for (std::size_t e = 1; e + 1 < moves_.nodes[i].size(); ++e)
            norm += moves_.nodes[i][e].dot(node_metric_[i].cwiseProduct(moves_.nodes[i][e]));
    return norm;
}

void Descent::take_step(const Shape& from, Shape& to) const {
    to.plates = from.plates;
    for (std::size_t i = 0; i < to.rods.size(); ++i) to.rods[i].nodes = from.rods[i].nodes;
    apply(geometry_, moves_, 1.0, to);
    for (int j = 0; j < geometry_.plates(); ++j) meet_hold(scene_.holds[j], to.plates[j]);
    attach_rods(geometry_, to);
}

double Descent::measure(const Shape& shape, std::vector<Vector6>& twists) const {
    twists.clear();
    double sum = 0.0;
    for (std::size_t i = 0; i < shape.rods.size(); ++i) {
        const rod::RodPiece piece = piece_of(scene_, sections_[i], shape, static_cast<int>(i));
        const RodShape& rod = shape.rods[i];
        for (int e = 0; e < rod.elements(); ++e) {
            const Pose &first = rod.nodes[e], &second = rod.nodes[e + 1];
            twists.push_back(log_se3(first.inverse() * second));
            sum += rod::geodesic_energy(piece, twists.back(), first.position + second.position);
        }
    }
    for (int j = 0; j < geometry_.plates(); ++j) {
        const Segment& segment = geometry_.segments[j];
        const Pose& plate = shape.plates[j];
        const Vector3 centre = plate.position + 0.5 * segment.plate_thickness * plate.rotation.col(2);
        sum -= segment.plate_mass * scene_.gravity.dot(centre);
        if (!scene_.following) sum -= scene_.wrenches[j].head<3>().dot(plate.position);
    }
    return sum;
}

double Descent::work_on_step(const Shape& from, const Shape& to) const {
    double work = 0.0;
    for (int j = 0; j < geometry_.plates(); ++j) {
        const Vector6& w = scene_.wrenches[j];
        if (w.isZero(0.0)) continue;
        const Vector3 turn = log_so3(to.plates[j].rotation * from.plates[j].rotation.transpose());
        if (!scene_.following) {
            work += w.tail<3>().dot(turn);
            continue;
        }
        const Matrix3 mean = 0.5 * (from.plates[j].rotation + to.plates[j].rotation);
        work += (mean * w.head<3>()).dot(to.plates[j].position - from.plates[j].position);
        work += (mean * w.tail<3>()).dot(turn);
    }
    for (std::size_t i = 0; i < from.rods.size(); ++i) {
        const Vector3 l = eigen(scene_.rods[i].line_load.moment);
        if (l.isZero(0.0)) continue;
        const RodShape &a = from.rods[i], &b = to.rods[i];
        const double h = scene_.rods[i].rest_length / a.elements();
        for (int k = 0; k <= a.elements(); ++k) {
            const double share = (k == 0 || k == a.elements()) ? 0.5 * h : h;
            work += share * l.dot(log_so3(b.nodes[k].rotation * a.nodes[k].rotation.transpose()));
        }
    }
    return work;
}

Ridge Descent::leave_along_mode(const Shape& top, double top_energy, double multiplier) {
    // A straight step along a mode stretches a stiff rod by the square of its turn: with EA l^2/EI = 1e6 it gains
    // height beyond a turn of a thousandth, however unstable the saddle. A few Newton steps, convex by the multiplier
    // that the saddle needed, take the stretch out again before the heights are compared.
    constexpr int relaxations = 6;
    const Moves mode = moves_;
    Ridge ridge{top, {}, {}};
    Shape trial = top, next = top;
    for (const double amplitude : {0.3, 0.03, 0.003}) {
        double lowest = 0.0;
        for (const double factor : {amplitude, -amplitude}) {
            moves_ = mode;
            moves_ *= factor;
            take_step(top, trial);
            std::optional<Shape> lower;
            double best = 0.0;
            for (int round = 0; round <= relaxations; ++round) {
                const double change = measure(trial, twists_) - top_energy - work_on_step(top, trial);
                if (!std::isfinite(change) || largest_angle(twists_) >= 2.0) break;
                if (change < best) best = change, lower = trial;
                if (round == relaxations || !step_within(trial, multiplier, amplitude)) break;
                take_step(trial, next);
                std::swap(trial, next);
            }
            if (!lower) continue;
            if (best < lowest) {
                lowest = best;
                ridge.other = std::move(ridge.taken);
                ridge.taken = std::move(lower);
            } else {
                ridge.other = std::move(lower);
            }
        }
        if (ridge.taken) break;
    }
    return ridge;
}

Ridge Descent::sides_of(const Shape& top) {
    resize(top);
    Ridge ridge{top, {}, {}};
    const double energy = measure(top, twists_);
    if (!linearise(top, twists_)) return ridge;
    double multiplier = 1e-4;
    for (int rung = 0; rung < 30 && !factor(top, multiplier); ++rung) multiplier *= 4.0;
    if (!factor(top, multiplier)) return ridge;
    solve_for_unstable_mode(top);
    return leave_along_mode(top, energy, multiplier);
}

bool Descent::step_within(const Shape& shape, double multiplier, double radius) {
    if (!work_.spend(2 * elements_)) return false;
    if (!linearise(shape, twists_)) return false;
    for (int rung = 0; rung < 20; ++rung, multiplier *= 4.0) {
        work_.pass_time(elements_);
        if (!factor(shape, multiplier)) continue;
        solve_for_step(shape);
        if (step_size(shape) <= radius) return true;
    }
    return false;
}

DescentReport Descent::run(Shape& shape, const DescentSettings& settings) {
    using solve::SolveStatus;
    DescentReport report;
    resize(shape);
    double radius = settings.radius, multiplier = 0.0;
    report.energy = measure(shape, twists_);
    Shape trial = shape;
    int saddles = 0;
    bool fresh = true;  // the elements at hand belong to the shape
    if (!std::isfinite(report.energy) || !linearise(shape, twists_)) {
        report.status = SolveStatus::not_finite;
        return report;
    }
    for (; report.iterations < settings.max_iterations; ++report.iterations) {
        if (!work_.spend(2 * elements_)) return report;
        if (!fresh && !linearise(shape, twists_)) {
            report.status = SolveStatus::not_finite;
            return report;
        }
        fresh = true;
        // The smallest multiplier of a ladder that makes the model convex and keeps its step inside the radius.
        multiplier = multiplier > 4.0 * lowest_rung ? 0.1 * multiplier : 0.0;
        double size = 0.0;
        bool convex = false;
        for (int rung = 0; rung < 60; ++rung) {
            ++report.factorisations;
            work_.pass_time(elements_);
            convex = factor(shape, multiplier);
            if (convex) {
                solve_for_step(shape);
                size = step_size(shape);
                if (size <= 1.25 * radius) break;
            }
            multiplier = next_rung(multiplier);
        }
        if (!convex || !std::isfinite(size)) {
            report.status = SolveStatus::not_finite;
            return report;
        }
        if (multiplier > 0.0 && size < settings.hand_over) {
            // Near: the multiplier may be no more than what is left of the way here.
            ++report.factorisations;
            bool near = factor(shape, 0.0);
            if (near) {
                solve_for_step(shape);
                near = step_size(shape) < settings.hand_over;
            }
            if (near) {
                multiplier = 0.0;
            } else {
                factor(shape, multiplier);
                solve_for_step(shape);
            }
        }
        if (multiplier == 0.0 && size < settings.hand_over) {
            take_step(shape, trial);
            measure(trial, trial_twists_);
            if (largest_angle(trial_twists_) < 2.0) shape = trial;
            report.status = SolveStatus::converged;
            return report;
        }
        if (multiplier > 0.0 && size < settings.small_step && radius > 2.0 * settings.small_step) {
            ++report.factorisations;
            if (factor(shape, neutral)) {
                // Convex by now, up to a move that costs nothing: only the ladder had not come down yet.
                solve_for_step(shape);
                if (step_size(shape) < settings.small_step) take_step(shape, trial), shape = trial;
                report.status = SolveStatus::converged;
                return report;
            }
            factor(shape, multiplier);
            // The slope has vanished but the Hessian is indefinite: an unstable equilibrium. Leave it downhill.
            if (++saddles > 20) {
                report.status = SolveStatus::no_progress;
                return report;
            }
            solve_for_unstable_mode(shape);
            Ridge ridge = leave_along_mode(shape, report.energy, multiplier);
            if (!ridge.taken) {
                report.status = SolveStatus::no_progress;
                return report;
            }
            shape = *ridge.taken;
            if (!report.ridge) report.ridge = std::move(ridge);
            report.energy = measure(shape, twists_);
            fresh = false;
            multiplier = 0.0;
            continue;
        }
        const double slope = slope_along_step(shape);
        const double predicted = 0.5 * slope - 0.5 * multiplier * metric_norm_squared();
        const double noise = 1e-13 * std::abs(report.energy) + 1e-300;
        take_step(shape, trial);
        const double trial_energy = measure(trial, trial_twists_);
        const double angle = largest_angle(trial_twists_);
        const double change = trial_energy - report.energy - work_on_step(shape, trial);
        const bool acceptable = std::isfinite(trial_energy) && angle < 2.5 && change < 0.1 * predicted + noise;
        if (!acceptable) {
            radius = 0.3 * std::min(size, radius);
            if (radius < 1e-10) {
                report.status = SolveStatus::no_progress;
                return report;
            }
            multiplier = next_rung(multiplier) / 0.1;  // the ladder starts from a tenth of it
            continue;
        }
        if (change < 0.75 * predicted && size > 0.5 * radius) radius = std::min(2.0 * radius, settings.largest_radius);
        if (change > 0.25 * predicted) radius = 0.5 * size;
        std::swap(shape, trial);
        std::swap(twists_, trial_twists_);
        report.energy = trial_energy;
        fresh = false;
        if (angle > settings.largest_angle) {
            report.needs_refinement = true;
            report.status = SolveStatus::no_progress;
            ++report.iterations;
            return report;
        }
    }
    return report;
}

}  // namespace softlimb::limb
