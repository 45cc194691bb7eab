#include "softlimb/limb/equilibrium.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "softlimb/largest.hpp"
#include "softlimb/limb/start.hpp"
#include "softlimb/solve/definite.hpp"

namespace softlimb::limb {
namespace {

double largest_force(const Shape& shape) {
    double square = 0.0;
    for (const RodShape& rod : shape.rods)
        for (const Vector6& w : rod.wrenches) square = std::max(square, w.head<3>().squaredNorm());
    return std::sqrt(square);
}

double largest_moment(const Shape& shape) {
    double square = 0.0;
    for (const RodShape& rod : shape.rods)
        for (const Vector6& w : rod.wrenches) square = std::max(square, w.tail<3>().squaredNorm());
    return std::sqrt(square);
}

// Share of the rods' bending stiffness that holds a neutral mode while Newton runs.
constexpr double pin_of_newton = 1e-7;

/// Share of the rods' bending stiffness below which a mode counts as neutral.
double pin_of_count(const Scene& scene) {
    // Above the noise of a neutral mode's eigenvalue, which grows with the stiffest direction, and below all but the
    // last few millionths on the way to a fold.
    double stiffest = 1.0;
    for (const RodAtPressure& rod : scene.rods)
        stiffest = std::max(stiffest, rod.section.axial * rod.rest_length * rod.rest_length / rod.section.bending);
    return std::clamp(1e-15 * stiffest, 1e-9, 1e-6);
}

double mean_bending(const Scene& scene) {
    double bending = 0.0;
    for (const RodAtPressure& rod : scene.rods) bending += rod.section.bending / static_cast<double>(scene.rods.size());
    return bending;
}

// Newton's step below which its stiffness serves for a few more.
constexpr double largest_chord = 0.03;
// What they and the last correction may change of the stiffness beside that step, relative to it: as the steps shrink
// tenfold and more, a count of modes with that much room is mostly the last.
constexpr double room_for_chords = 1.2;

/// Largest activity of the rod's pieces were they of this length; wrenches at every node, the last one's from the
/// balance of the last piece without its weight.
double rod_activity(const Section& section, const RodShape& rod, double length) {
    double z = 0.0;
    for (const Vector6& w : rod.wrenches) z = std::max(z, activity(section, w, length));
    const std::size_t last = rod.wrenches.size() - 1;
    Vector6 end = rod.wrenches[last];
    end.tail<3>() -= (rod.nodes[last + 1].position - rod.nodes[last].position).cross(Vector3(end.head<3>()));
    return std::max(z, activity(section, end, length));
}

}  // namespace

double activity(const Section& section, const Vector6& wrench, double length) {
    const double compliance = 1.0 / std::min(section.bending, section.torsion);
    return length * (wrench.tail<3>().norm() * compliance + std::sqrt(wrench.head<3>().norm() / section.bending) +
                     std::abs(section.rest_twist));
}

double rod_activity(const Scene& scene, const Shape& shape, std::size_t i) {
    return rod_activity(scene.rods[i].section, shape.rods[i], scene.rods[i].rest_length);
}

double allowed_step(double tolerance) {
    // One eighth-order step over an activity z errs by about 1e-7 z^8 of its length (median over random wrenches 4e-8,
    // worst 6e-6: tests/test_integrators.py); the check with half the step catches the rest.
    constexpr double error_of_unit_step = 1e-7, largest_step = 2.2;
    return std::clamp(std::pow(3.0 * tolerance / error_of_unit_step, 0.125), 0.1, largest_step);
}

namespace {

// Pieces that run beside each other in the widest lanes. The same on every machine, so that the mesh is.
constexpr int side_by_side = 8;

/// Pieces of equal numbers of steps run side by side. Those beyond the last full pack of a number take a pack for a
/// few; with the steps of the next larger number they cost nothing where a pack of that one has room for them.
void fill_packs(Shape& shape) {
    const auto pieces_of = [&](int steps) {
        int pieces = 0;
        for (const RodShape& rod : shape.rods)
            if (rod.integration.steps == steps) pieces += rod.elements();
        return pieces;
    };
    constexpr int none = std::numeric_limits<int>::max();
    const auto next_above = [&](int steps) {
        int next = none;
        for (const RodShape& rod : shape.rods)
            if (rod.integration.steps > steps) next = std::min(next, rod.integration.steps);
        return next;
    };
    for (int steps = next_above(0), more; (more = next_above(steps)) != none; steps = more) {
        int beyond = pieces_of(steps) % side_by_side;
        int room = (side_by_side - pieces_of(more) % side_by_side) % side_by_side;
        if (beyond > room) continue;
        // Rods with many pieces first: what is left then fits into what room is left.
        for (int pieces = room; pieces > 0 && beyond > 0; --pieces)
            for (RodShape& rod : shape.rods) {
                if (rod.integration.steps != steps || rod.elements() != pieces || pieces > room || beyond <= 0)
                    continue;
                rod.integration.steps = more;
                beyond -= pieces, room -= pieces;
            }
    }
}

}  // namespace

void choose_mesh(const Scene& scene, double tolerance, Shape& shape, double largest_piece, Joining joining) {
    // Wrenches of a shape far from balance ask for any number of pieces, and each call splits what it finds: a rod of
    // growth e^80 needs 54, one of forty turns 168.
    constexpr double largest_rod = 400.0;
    const double step = allowed_step(tolerance);
    for (std::size_t i = 0; i < shape.rods.size(); ++i) {
        RodShape& rod = shape.rods[i];
        const Section& section = scene.rods[i].section;
        const double whole = std::min(rod_activity(section, rod, scene.rods[i].rest_length),
                                      std::max(largest_piece * rod.elements(), largest_rod));
        const auto wanted = [&](double length) {
            return std::max(1, static_cast<int>(std::ceil(length / largest_piece)));
        };
        // Pieces are joined only where they would not be split at once: from solve to solve a rod near the edge keeps
        // its mesh, and a sweep may go on from the shapes before.
        constexpr double room = 1.2;
        if (wanted(whole) > rod.elements())
            split_elements(rod, (wanted(whole) + rod.elements() - 1) / rod.elements());
        else if (largest_piece > newton_piece && joining == Joining::allowed)
            merge_elements(rod, wanted(room * whole));
        rod.integration = {8, std::max(1, static_cast<int>(std::ceil(whole / (rod.elements() * step))))};
    }
    // Pieces beside each other cost less than steps after each other, where few of them leave lanes empty.
    int pieces = 0;
    for (const RodShape& rod : shape.rods) pieces += rod.elements() * rod.integration.steps;
    if (pieces > side_by_side) {
        fill_packs(shape);
        return;
    }
    for (RodShape& rod : shape.rods) {
        split_elements(rod, rod.integration.steps);
        rod.integration.steps = 1;
    }
}

double neutral_margin(const Geometry& geometry, const Scene& scene) {
    return pin_of_count(scene) * mean_bending(scene) / geometry.length;
}

bool mesh_suffices(const Scene& scene, double tolerance, const Shape& shape) {
    // Twice the error that the mesh was chosen for: what a solve may change without another one. Where a rod is
    // straight no check of the posture sees the error of its stiffness.
    const double step = 1.1 * allowed_step(tolerance);
    for (std::size_t i = 0; i < shape.rods.size(); ++i) {
        const RodShape& rod = shape.rods[i];
        const double piece = rod_activity(scene.rods[i].section, rod, scene.rods[i].rest_length / rod.elements());
        if (!(piece < largest_countable_piece && piece <= step * rod.integration.steps)) return false;
    }
    return true;
}

void Equilibrium::resize(const Shape& shape) {
    number_ = 0;
    const std::size_t rods = shape.rods.size();
    chains_.resize(rods), exact_.resize(rods), ends_.resize(rods), ends_after_.resize(rods);
    end_slopes_.resize(rods);
    loads_.resize(rods), gaps_.resize(rods), interior_.resize(rods), rod_forces_.resize(rods);
    double length = 0.0;
    for (std::size_t i = 0; i < rods; ++i) {
        const int elements = shape.rods[i].elements();
        chains_[i].resize(elements), exact_[i].resize(elements);
        ends_[i].resize(elements), ends_after_[i].resize(elements), end_slopes_[i].resize(elements);
        loads_[i].assign(elements, Vector12::Zero());
        gaps_[i].assign(elements, Vector6::Zero());
        interior_[i].assign(elements + 1, Vector6::Zero());
        length += scene_.rods[i].rest_length / static_cast<double>(rods);
    }
    batch_.reserve(shape.pieces());
    balance_.resize(geometry_.plates());
    symmetric_.resize(geometry_.plates());
    tip_by_plate_.resize(geometry_.plates());
    moves_.set_zero(geometry_, shape);
    plate_forces_.assign(geometry_.plates(), Vector6::Zero());
    carried_.assign(geometry_.plates(), Vector6::Zero());
    hold_rows_.assign(geometry_.plates(), Vector6::Zero());
    by_parameter_ = moves_;
    length_scale_ = 0.5 * length;
}

template <class Add>
void Equilibrium::integrate(const Scene& scene, const Shape& shape, int finer, Add&& add) {
    // Pieces with equal numbers of steps run side by side; a limb has one to three such numbers.
    for (int steps = 0, next; steps < std::numeric_limits<int>::max(); steps = next) {
        next = std::numeric_limits<int>::max();
        batch_.clear();
        for (std::size_t i = 0; i < shape.rods.size(); ++i) {
            const RodShape& rod = shape.rods[i];
            if (rod.integration.steps > steps) next = std::min(next, rod.integration.steps);
            if (rod.integration.steps != steps) continue;
            const rod::RodPiece part = piece_of(scene, static_cast<int>(i), shape);
            for (int e = 0; e < rod.elements(); ++e) add(part, i, e);
        }
        if (steps > 0) batch_.run(finer * steps);
    }
}

void Equilibrium::shoot(const Scene& scene, const Shape& shape, int finer,
                        std::vector<std::vector<rod::EndState>>& ends) {
    integrate(scene, shape, finer, [&](const rod::RodPiece& part, std::size_t i, int e) {
        batch_.add(part, shape.rods[i].nodes[e], shape.rods[i].wrenches[e], ends[i][e]);
    });
}

bool Equilibrium::linearise(const Scene& scene, const Shape& shape) {
    stable_beyond_ = -1.0;
    number_ = 0;
    integrate(scene, shape, 1, [&](const rod::RodPiece& part, std::size_t i, int e) {
        const RodShape& rod = shape.rods[i];
        batch_.add(part, rod.nodes[e], rod.wrenches[e], exact_[i][e].target(rod.nodes[e + 1], chains_[i].element(e)));
    });
    for (std::size_t i = 0; i < shape.rods.size(); ++i) {
        for (const rod::ExactElement& element : exact_[i])
            if (!element.regular()) return false;
        if (!chains_[i].condense(shift_, false, false)) return false;
    }
    balance_.assemble(geometry_, scene, shape.plates, chains_, false);
    for (int j = 0; j < geometry_.plates(); ++j) balance_.shift(j, shift_);
    return balance_.factor();
}

void Equilibrium::propose(const Shape& shape) {
    balance_.solve(balance_.residual(), moves_.plates);
    Balance::move_ends(geometry_, shape.plates, moves_.plates, moves_.nodes);
    for (std::size_t i = 0; i < chains_.size(); ++i) {
        auto& nodes = moves_.nodes[i];
        chains_[i].recover(nodes);
        for (int e = 0; e < chains_[i].elements(); ++e)
            moves_.wrenches[i][e] = exact_[i][e].wrench_change(nodes[e], nodes[e + 1], exact_[i][e].gap());
    }
}

void Equilibrium::propose_again(const Shape& shape, int finer) {
    shoot(scene_, shape, finer, ends_);
    for (std::size_t r = 0; r < shape.rods.size(); ++r) {
        const RodShape& rod = shape.rods[r];
        for (int e = 0; e < rod.elements(); ++e) {
            const rod::EndState& end = ends_[r][e];
            gaps_[r][e] = rod::pose_gap(end.pose, rod.nodes[e + 1]);
            const Vector6 change = exact_[r][e].wrench_for_gap(gaps_[r][e]);
            loads_[r][e] << -(rod.wrenches[e] + change), end.wrench + exact_[r][e].end_wrench_by_base_wrench() * change;
        }
    }
    for (int j = 0; j < geometry_.plates(); ++j) {
        plate_forces_[j] = -plate_load(geometry_, scene_, shape.plates[j], j, nullptr);
        hold_rows_[j].setZero();
        if (scene_.holds[j].any()) hold_rows_[j] = balance_.hold_map(j) * hold_gap(scene_.holds[j], shape.plates[j]);
    }
    respond_to_gaps(shape);
}

void Equilibrium::respond_to_gaps(const Shape& shape) {
    // Gaps and loads of the pieces, wrenches on the plates and rows of the holds in place of the residual's own.
    for (std::size_t r = 0; r < shape.rods.size(); ++r)
        rod_forces_[r] = chains_[r].condense_loads(loads_[r], interior_[r]);
    Balance::carry(geometry_, shape.plates, rod_forces_, carried_);
    for (int j = 0; j < geometry_.plates(); ++j)
        plate_forces_[j] = (balance_.projector(j) * (carried_[j] + plate_forces_[j])).eval() + hold_rows_[j];
    balance_.solve(plate_forces_, moves_.plates);
    Balance::move_ends(geometry_, shape.plates, moves_.plates, moves_.nodes);
    for (std::size_t i = 0; i < chains_.size(); ++i) {
        auto& nodes = moves_.nodes[i];
        chains_[i].recover_with(interior_[i], nodes);
        for (int e = 0; e < chains_[i].elements(); ++e)
            moves_.wrenches[i][e] = exact_[i][e].wrench_change(nodes[e], nodes[e + 1], gaps_[i][e]);
    }
}

bool Equilibrium::differ(const Shape& shape, const Border& border) {
    // Slope of the residual to the parameter by a central difference, everything that a scene may change included. The
    // slope only steers: an error of 1e-9 in it turns a tangent by as much and moves no answer.
    const double per_span = 1.0 / border.span;
    shoot(border.before, shape, 1, ends_);
    shoot(border.after, shape, 1, ends_after_);
    for (std::size_t r = 0; r < shape.rods.size(); ++r) {
        const RodShape& rod = shape.rods[r];
        for (int e = 0; e < rod.elements(); ++e) {
            const rod::EndState &a = ends_[r][e], &b = ends_after_[r][e];
            gaps_[r][e] = per_span * rod::pose_gap(b.pose, a.pose);
            if (!gaps_[r][e].allFinite() || !a.wrench.allFinite() || !b.wrench.allFinite()) return false;
            const Vector6 change = exact_[r][e].wrench_for_gap(gaps_[r][e]);
            loads_[r][e] << -change,
                per_span * (b.wrench - a.wrench) + exact_[r][e].end_wrench_by_base_wrench() * change;
        }
    }
    for (int j = 0; j < geometry_.plates(); ++j) {
        const Pose& plate = shape.plates[j];
        plate_forces_[j] = -per_span * (plate_load(geometry_, border.after, plate, j, nullptr) -
                                        plate_load(geometry_, border.before, plate, j, nullptr));
        hold_rows_[j] = balance_.hold_map(j) *
                        (per_span * (hold_gap(border.after.holds[j], plate) - hold_gap(border.before.holds[j], plate)));
    }
    respond_to_gaps(shape);
    return true;
}

double Equilibrium::stay_perpendicular(const Border& border) {
    // moves_ + step * by_parameter_, with the step that keeps the sum perpendicular to the tangent.
    if (border.tangent == nullptr) return 0.0;
    const double per_range = 1.0 / (border.range * border.range);
    const double length = geometry_.length;
    const double step = -inner_product(*border.tangent, moves_, length) /
                        (inner_product(*border.tangent, by_parameter_, length) + per_range * border.parameter_tangent);
    moves_.add(step, by_parameter_);
    return step;
}

Moves Equilibrium::response_to_parameter(const Shape& shape, const Border& border) {
    differ(shape, border);
    return moves_;
}

Equilibrium::Scales Equilibrium::scales_at(const Shape& shape) const {
    Scales scales;
    scales.largest_force = largest_force(shape);
    scales.force = scales.largest_force, scales.moment = largest_moment(shape);
    for (const RodAtPressure& rod : scene_.rods) {
        const double moment = rod.section.bending / rod.rest_length;
        scales.force = std::max(scales.force, moment / rod.rest_length);
        scales.moment = std::max(scales.moment, moment);
    }
    return scales;
}

double Equilibrium::largest_wrench_change(const Scales& scales) const {
    double force = 0.0, moment = 0.0;  // squares
    for (const auto& wrenches : moves_.wrenches)
        for (const Vector6& w : wrenches) {
            grow(force, w.head<3>().squaredNorm());
            grow(moment, w.tail<3>().squaredNorm());
        }
    double largest = std::sqrt(force) / scales.force;
    grow(largest, std::sqrt(moment) / scales.moment);
    return largest;
}

double Equilibrium::stiffness_change(const Step& step, const Scales& scales) const {
    // A bound with room. A move turns forces and arms; other forces inside a rod act over its own length.
    double largest = 0.0;
    for (std::size_t i = 0; i < moves_.wrenches.size(); ++i) {
        double force = 0.0, moment = 0.0;  // squares
        for (const Vector6& w : moves_.wrenches[i])
            grow(force, w.head<3>().squaredNorm()), grow(moment, w.tail<3>().squaredNorm());
        grow(largest, std::sqrt(force) * scene_.rods[i].rest_length + std::sqrt(moment));
    }
    return solve::stiffness_by_move * step.moved * scales.force * geometry_.length + largest;
}

bool Equilibrium::surely_stable(double changed) {
    if (changed <= stable_beyond_) return true;
    solve::DefiniteRows rows;
    for (int j = 0; j < geometry_.plates(); ++j) {
        if (!rows.add(symmetric_diagonal(j, changed))) return false;
        if (j + 1 < geometry_.plates()) rows.couple(symmetric_upper(j).transpose());
    }
    for (std::size_t i = 0; i < chains_.size(); ++i)
        if (!chains_[i].positive_beyond(rod_margin(i, changed))) return false;
    stable_beyond_ = changed;
    return true;
}

Equilibrium::Step Equilibrium::step_now(const Scales& scales) const {
    // Translations count relative to the limb, rotations in radians, wrenches far less.
    Step step;
    step.moved = step.size = largest_move(moves_, geometry_.length);
    step.wrench = largest_wrench_change(scales);
    grow(step.size, solve::wrench_in_tip * step.wrench);
    return step;
}

double Equilibrium::bounded_factor(const Shape& shape, double largest_turn) const {
    const double turn = largest_deformation(shape, moves_, length_scale_);
    return turn > largest_turn ? largest_turn / turn : 1.0;
}

double Equilibrium::relative_residual(const Shape& shape, const Scales& scales) const {
    double residual = 0.0;
    for (int j = 0; j < geometry_.plates(); ++j) {
        const Vector6 r = balance_.projector(j) * balance_.full_residual()[j];
        grow(residual, r.head<3>().norm() / scales.force);
        grow(residual, r.tail<3>().norm() / scales.moment);
        const Hold& hold = scene_.holds[j];
        if (!hold.any()) continue;
        const Vector6 gap = hold_gap(hold, shape.plates[j]);
        for (int k = 0; k < 6; ++k)
            if (hold.held[k]) grow(residual, std::abs(gap(k)) / (k < 3 ? geometry_.length : 1.0));
    }
    grow(residual, largest_gap());
    return residual;
}

double Equilibrium::largest_gap() const {
    double shift = 0.0, turn = 0.0;  // squares
    for (const auto& rod : exact_)
        for (const rod::ExactElement& element : rod) {
            grow(shift, element.gap().head<3>().squaredNorm());
            grow(turn, element.gap().tail<3>().squaredNorm());
        }
    double largest = std::sqrt(shift) / geometry_.length;
    grow(largest, std::sqrt(turn));
    return largest;
}

NewtonReport Equilibrium::solve(Shape& shape, const NewtonSettings& settings, solve::Work& work, Border* border) {
    using solve::SolveStatus;
    NewtonReport report;
    resize(shape);
    shift_.setZero();
    neutral_.clear();
    double previous = 1e300;
    int refinements = 0, stalls = 0;
    bool refined = false;
    const long elements = shape.pieces();
    // Of a plate that is held in some turns the free directions belong to its pose: a step with an older pose's would
    // balance the wrong ones.
    const bool same_freedoms =
        std::none_of(scene_.holds.begin(), scene_.holds.end(), [](const Hold& hold) { return hold.partly_turned(); });
    for (; report.iterations < settings.max_iterations; ++report.iterations) {
        if (!work.spend(elements * shape.rods.front().integration.steps)) return report;
        if (!linearise(shape)) {
            report.status = SolveStatus::singular_jacobian;
            return report;
        }
        Scales scales = scales_at(shape);
        report.residual = relative_residual(shape, scales);
        if (border) {
            if (!differ(shape, *border)) {
                report.status = SolveStatus::not_finite;
                return report;
            }
            std::swap(moves_, by_parameter_);
        }
        if (report.neutral_mode) find_neutral(shape);
        propose(shape);
        leave_out_neutral();
        const double parameter_step = border ? stay_perpendicular(*border) : 0.0;
        const Step newton = step_now(scales);
        const double size = border ? std::max(newton.size, std::abs(parameter_step) / border->range) : newton.size;
        const double factor = bounded_factor(shape, settings.largest_turn);
        if (!std::isfinite(size)) {
            report.status = SolveStatus::not_finite;
            return report;
        }
        // A step out of all proportion to what is left of the balance: some move costs nothing, as the turn of a
        // buckled round column about its axis. A ten-millionth of the rods' stiffness pins that move and hardly touches
        // the others; without it Newton wanders along the continuum of equal answers. What is left of it in a step is
        // rounding, and is taken out.
        constexpr std::size_t most_neutral = 12;
        if (report.residual < 1e-8 && size > settings.tolerance && size > 1e8 * report.residual &&
            neutral_.size() < most_neutral) {
            report.neutral_mode = true;
            neutral_.push_back(moves_);
            pin(pin_of_newton);
            continue;
        }
        apply(geometry_, moves_, factor, shape);
        if (border && !border->move_by(factor * parameter_step)) {
            report.status = SolveStatus::limit_point;
            return report;
        }
        scales = scales_at(shape);
        // Newton's error after a step is about its square. The pass below measures it, so this only avoids vain passes.
        const double leverage =
            std::max(1.0, solve::force_arm * scales.largest_force * geometry_.length / scales.moment);
        // Stiff rods may be far from balance where poses hardly move: what is out of balance must be small as well.
        const bool balanced = report.residual < 0.1;
        bool near = factor == 1.0 && ((balanced && size * size * leverage < 0.1 * settings.tolerance) || size < 1e-9);
        if (factor == 1.0 && size > 0.5 * previous && size < 1e-6) ++stalls;
        previous = size;
        // Steps with the stiffness at hand cost a third of one with its own, and each shrinks what is left by about
        // what has been moved since. They serve where the count of modes will not want that stiffness anyway.
        double shrink = solve::left_by_chord * size * leverage;
        double changed = stiffness_change(newton, scales);  // since the linearisation
        const bool close = factor == 1.0 && same_freedoms && balanced && !near && size * leverage < largest_chord &&
                           !border && !report.neutral_mode &&
                           surely_stable(std::max(neutral_margin(geometry_, scene_), room_for_chords * changed));
        double error = 0.0;
        bool failed = false;  // a check by what this linearisation left
        for (int chord = 0;;) {
            for (; close && !near && chord < 3; ++chord) {
                if (!work.spend(elements * shape.rods.front().integration.steps)) return report;
                propose_again(shape, 1);
                const Step step = step_now(scales);
                if (!(step.size < 0.3 * previous)) break;
                apply(geometry_, moves_, 1.0, shape);
                scales = scales_at(shape);
                shrink = std::max(shrink, step.size / previous);
                near = step.size * shrink < 0.5 * settings.tolerance || step.size < 1e-9;
                previous = step.size;
                changed += stiffness_change(step, scales);
            }
            if (!near) break;
            // The same balance with half the step: its residual, met by the stiffness at hand, is the error of the
            // answer.
            propose_again(shape, 2);
            leave_out_neutral();
            const double parameter_error = border ? stay_perpendicular(*border) : 0.0;
            const Step last = step_now(scales);
            error = border ? std::max(last.size, std::abs(parameter_error) / border->range) : last.size;
            report.error_estimate = error;
            if (!std::isfinite(error)) {
                report.status = SolveStatus::not_finite;
                return report;
            }
            // Rounding sets a floor: a Newton step below 1e-11 that no longer shrinks is as good as doubles get.
            changed += stiffness_change(last, scales);
            apply(geometry_, moves_, 1.0, shape);
            if (border && !border->move_by(parameter_error)) {
                report.status = SolveStatus::limit_point;
                return report;
            }
            // Balances are met to the tolerance as well: what the wrenches still miss.
            if (error <= settings.tolerance && last.wrench * std::min(shrink, 1.0) <= 5.0 * settings.tolerance) {
                ++report.iterations;
                report.status = SolveStatus::converged;
                if (report.neutral_mode) {
                    pin(pin_of_count(scene_));
                    if (!linearise(shape)) report.status = SolveStatus::singular_jacobian;
                }
                judge(shape, report, report.neutral_mode ? 0.0 : changed);
                return report;
            }
            if (!close || failed) break;
            // The steps with the stiffness at hand shrank less than they promised: one more, if it still shrinks, costs
            // less than a linearisation. By the coarse integration, so that the fine one still checks it.
            failed = true, near = false;
            shrink = std::max(shrink, error / previous);
            previous = error;
            scales = scales_at(shape);
        }
        if (!near) {
            refined = failed;
            continue;
        }
        if (stalls > 3 || refinements > 8) {
            report.status = SolveStatus::no_progress;
            return report;
        }
        if (size < 0.1 * error || refined) {
            // Not Newton's error but the integration's: finer steps.
            // A piece of activity 1.5 at the tightest tolerance takes 15 steps; more than this many is divergence.
            constexpr int most_steps = 48;
            const double ratio = std::pow(4.0 * error / settings.tolerance, 1.0 / 8.0);
            for (RodShape& rod : shape.rods) {
                const int steps = static_cast<int>(std::ceil(ratio * rod.integration.steps));
                rod.integration.steps = std::max(rod.integration.steps + 1, std::min(steps, 4 * rod.integration.steps));
                if (rod.integration.steps > most_steps) {
                    report.status = SolveStatus::no_progress;
                    return report;
                }
            }
            ++refinements;
        }
        refined = true;
    }
    return report;
}

void Equilibrium::judge(const Shape& shape, NewtonReport& report, double changed) {
    const double neutral = neutral_margin(geometry_, scene_);
    report.plate_modes = report.rod_modes = 0;
    if (surely_stable(std::max(neutral, changed))) return;
    NewtonReport doubtful = report;
    count_modes(doubtful, std::max(neutral, changed));
    report.plate_modes = doubtful.plate_modes, report.rod_modes = doubtful.rod_modes;
    if (changed > 0.0 && !linearise(shape)) return;
    count_modes(report);
    if (report.neutral_mode) return;
    if (report.modes() == 0) {
        count_modes(doubtful, neutral);
        report.neutral_mode = doubtful.modes() > 0;
        return;
    }
    pin(pin_of_count(scene_));
    NewtonReport pinned = report;
    if (!linearise(shape)) return;
    count_modes(pinned);
    if (pinned.modes() >= report.modes()) return;
    report = pinned;
    report.neutral_mode = true;
}

Matrix6 Equilibrium::symmetric_diagonal(int j, double margin) const {
    const Matrix6& k = balance_.system().diagonal[j];
    Matrix6 symmetric;
    if (scene_.holds[j].any()) {
        const Matrix6& p = balance_.projector(j);
        const Matrix6 free = p * k * p;
        const double weight = std::max(k.diagonal().cwiseAbs().maxCoeff(), 1e-300);
        symmetric = 0.5 * (free + free.transpose()) + weight * (Matrix6::Identity() - p);
    } else {
        symmetric = 0.5 * (k + k.transpose());
    }
    symmetric.diagonal().head<3>().array() -= margin / (geometry_.length * geometry_.length);
    symmetric.diagonal().tail<3>().array() -= margin;
    return symmetric;
}

Matrix6 Equilibrium::symmetric_upper(int j) const {
    const solve::BlockTridiagonal& k = balance_.system();
    Matrix6 symmetric = 0.5 * (k.upper[j] + k.lower[j + 1].transpose());
    if (scene_.holds[j].any()) symmetric = (balance_.projector(j) * symmetric).eval();
    if (scene_.holds[j + 1].any()) symmetric = (symmetric * balance_.projector(j + 1)).eval();
    return symmetric;
}

Vector6 Equilibrium::rod_margin(std::size_t i, double margin) const {
    // In units of its pieces: a force changes the stiffness of a rod's nodes by itself over their length.
    const double piece = scene_.rods[i].rest_length / chains_[i].elements();
    Vector6 shift = Vector6::Constant(margin);
    shift.head<3>() /= piece * piece;
    return shift;
}

void Equilibrium::count_modes(NewtonReport& report, double margin) {
    // Inertia of the symmetric part, confined to the free freedoms on both sides; Sylvester's law adds the pivots up.
    const int plates = geometry_.plates();
    for (int j = 0; j < plates; ++j) {
        symmetric_.diagonal[j] = symmetric_diagonal(j, margin);
        if (j + 1 == plates) continue;
        symmetric_.upper[j] = symmetric_upper(j);
        symmetric_.lower[j + 1] = symmetric_.upper[j].transpose();
    }
    report.rod_modes = report.plate_modes = 0;
    for (std::size_t i = 0; i < chains_.size(); ++i) {
        const rod::Chain& chain = chains_[i];
        if (margin > 0.0 && chain.elements() > 1) {
            if (chain.positive_beyond(rod_margin(i, margin))) continue;
            report.rod_modes += std::max(1, chain.negative_pivots());
            continue;
        }
        report.rod_modes += chain.negative_pivots();
    }
    if (!symmetric_.factor()) return;
    for (const Matrix6& pivot : symmetric_.pivots()) report.plate_modes += rod::negative_eigenvalues(pivot);
}

int Equilibrium::diverging_modes() const {
    const Eigen::EigenSolver<Eigen::MatrixXd> solver(dense_stiffness(), false);
    int modes = 0;
    for (const auto& value : solver.eigenvalues())
        modes += value.real() < 0.0 && std::abs(value.imag()) < 1e-12 * std::abs(value.real());
    return modes;
}

Eigen::MatrixXd Equilibrium::dense_stiffness() const {
    const solve::BlockTridiagonal& k = balance_.system();
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(6 * k.rows(), 6 * k.rows());
    for (int j = 0; j < k.rows(); ++j) {
        dense.block<6, 6>(6 * j, 6 * j) = k.diagonal[j];
        if (j > 0) dense.block<6, 6>(6 * j, 6 * j - 6) = k.lower[j];
        if (j + 1 < k.rows()) dense.block<6, 6>(6 * j, 6 * j + 6) = k.upper[j];
    }
    return dense;
}

void Equilibrium::find_neutral(const Shape& shape) {
    // Inverse iteration with the pinned stiffness: each move is dominated by neutral directions already, and one solve
    // divides what is not by the pin.
    for (std::size_t k = 0; k < neutral_.size(); ++k) {
        Moves& z = neutral_[k];
        for (std::size_t r = 0; r < shape.rods.size(); ++r)
            for (int e = 0; e < shape.rods[r].elements(); ++e) {
                gaps_[r][e].setZero();
                loads_[r][e].setZero();
                if (e > 0) loads_[r][e].head<6>() = shift_.cwiseProduct(z.nodes[r][e]);
            }
        for (int j = 0; j < geometry_.plates(); ++j) {
            plate_forces_[j] = shift_.cwiseProduct(z.plates[j]);
            hold_rows_[j].setZero();
        }
        respond_to_gaps(shape);
        z = moves_;
        for (std::size_t other = 0; other < k; ++other)
            z.add(-inner_product(z, neutral_[other], geometry_.length), neutral_[other]);
        z *= 1.0 / std::max(std::sqrt(inner_product(z, z, geometry_.length)), 1e-300);
    }
}

std::vector<Moves> Equilibrium::softest_moves(const Shape& shape, int count) {
    resize(shape);
    pin(pin_of_newton);
    std::vector<Moves> softest;
    if (!linearise(shape)) return softest;
    // Any start that no symmetry of a limb shares.
    double phase = 1.0;
    for (int k = 0; k < count; ++k) {
        Moves seed = moves_;
        for (Vector6& x : seed.plates) phase += 1.7, x.setConstant(std::sin(phase));
        for (auto& nodes : seed.nodes)
            for (Vector6& x : nodes) {
                phase += 1.7;
                x << std::sin(phase), std::cos(phase), 0.5, std::sin(2.0 * phase), 1.0, 0.3;
            }
        neutral_.push_back(std::move(seed));
    }
    constexpr int rounds = 8;
    for (int round = 0; round < rounds; ++round) find_neutral(shape);
    softest.swap(neutral_);
    return softest;
}

void Equilibrium::leave_out_neutral() {
    for (const Moves& z : neutral_) moves_.add(-inner_product(moves_, z, geometry_.length), z);
}

void Equilibrium::pin(double share) {
    // In units of what it takes to bend the whole limb: short rods are far stiffer, but no mode is softer for them.
    const double stiffness = share * mean_bending(scene_) / geometry_.length;
    shift_.head<3>().setConstant(stiffness / (geometry_.length * geometry_.length));
    shift_.tail<3>().setConstant(stiffness);
}

bool Equilibrium::linearise_at(const Shape& shape, bool pinned) {
    resize(shape);
    pin(pinned ? pin_of_count(scene_) : 0.0);
    return linearise(shape);
}

void Equilibrium::respond_to_rods(const Shape& shape, const std::vector<RodSlope>& slopes,
                                  std::vector<Vector6>& tip_moves) {
    if (slopes.size() != shape.rods.size()) throw std::invalid_argument("one slope a rod is needed");
    integrate(scene_, shape, 1, [&](const rod::RodPiece& part, std::size_t i, int e) {
        const RodShape& rod = shape.rods[i];
        batch_.add(part, rod.nodes[e], rod.wrenches[e], slopes[i].section, slopes[i].rest_length / rod.elements(),
                   slopes[i].section.mass_per_length * scene_.gravity, end_slopes_[i][e]);
    });
    // Only the two plates of a rod are loaded, and only the last one's move is asked for.
    balance_.system().last_of_inverse(tip_by_plate_);
    for (int j = 0; j < geometry_.plates(); ++j)
        if (scene_.holds[j].any()) tip_by_plate_[j] = (tip_by_plate_[j] * balance_.projector(j)).eval();
    tip_moves.resize(slopes.size());
    std::size_t i = 0;
    for (int j = 0; j < geometry_.plates(); ++j)
        for (const Placement& place : geometry_.segments[j].rods) {
            for (int e = 0; e < shape.rods[i].elements(); ++e) {
                const rod::EndSlope& slope = end_slopes_[i][e];
                const Vector6 change = exact_[i][e].wrench_for_gap(slope.pose);
                loads_[i][e] << -change, slope.wrench + exact_[i][e].end_wrench_by_base_wrench() * change;
            }
            for (int plate = std::max(0, j - 1); plate <= j; ++plate) plate_forces_[plate].setZero();
            Balance::add_carried(geometry_, shape.plates, j, place, chains_[i].condense_loads(loads_[i], interior_[i]),
                                 plate_forces_);
            tip_moves[i].noalias() = -(tip_by_plate_[j] * plate_forces_[j]);
            if (j > 0) tip_moves[i].noalias() -= tip_by_plate_[j - 1] * plate_forces_[j - 1];
            ++i;
        }
}

Vector6 Equilibrium::base_wrench(const Shape& shape) const {
    Vector6 wrench = Vector6::Zero();
    for (std::size_t k = 0; k < geometry_.segments[0].rods.size(); ++k) {
        const Vector6& w = shape.rods[k].wrenches.front();
        const Vector3 arm = geometry_.segments[0].rods[k].base.position;
        wrench -= w;
        wrench.tail<3>() -= arm.cross(Vector3(w.head<3>()));
    }
    return wrench;
}

std::vector<Vector6> Equilibrium::reactions(const Shape& shape) const {
    std::vector<Vector6> reactions(geometry_.plates(), Vector6::Zero());
    if (!scene_.holds_plates()) return reactions;
    // What the rods ask of a held plate beyond its loads, from the final wrenches by integration to the rods' ends.
    std::vector<Vector12> ends(shape.rods.size());
    for (std::size_t i = 0; i < shape.rods.size(); ++i) {
        const RodShape& rod = shape.rods[i];
        const int last = rod.elements() - 1;
        const rod::EndState end =
            rod::end_of(piece(static_cast<int>(i), shape), rod.nodes[last], rod.wrenches[last], rod.integration);
        ends[i] << -rod.wrenches.front(), end.wrench;
    }
    Balance::carry(geometry_, shape.plates, ends, reactions);
    for (int j = 0; j < geometry_.plates(); ++j) {
        reactions[j] -= plate_load(geometry_, scene_, shape.plates[j], j, nullptr);
        if (!scene_.holds[j].any())
            reactions[j].setZero();
        else
            reactions[j] = ((Matrix6::Identity() - balance_.projector(j)) * reactions[j]).eval();
    }
    return reactions;
}

}  // namespace softlimb::limb
