#include "softlimb/limb/derivatives.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "softlimb/limb/rod_numbers.hpp"

namespace softlimb::limb {
namespace {

[[noreturn]] void throw_singular() {
    throw std::runtime_error("the stiffness is singular here, at a fold: no derivatives");
}

using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Direction {
    Section section{};
    double length;
    Vector3 force;

    Direction(const Section& base, const VectorXd& x) {
        const int law = base.axial_law.degree + 1;
        section.axial_law = base.axial_law;
        for (int k = 0; k < law; ++k) section.axial_law.coefficient[k] = x(k);
        const double growth = x(law + RodNumber::range);
        section.axial_law.centre *= growth, section.axial_law.half_range *= growth;
        section.shear = x(law + RodNumber::shear), section.bending = x(law + RodNumber::bending);
        section.torsion = x(law + RodNumber::torsion), section.extension_twist = x(law + RodNumber::coupling);
        section.rest_twist = x(law + RodNumber::rest_twist), length = x(law + RodNumber::length);
        force = x.tail<3>();
    }
};

/// Where a point stands: in piece e, a share of the piece from its base.
struct Place {
    int piece;
    double share;
};

Place place_of(const RodShape& rod, double fraction) {
    const double along = rod.elements() * fraction;
    const int piece = std::clamp(static_cast<int>(along), 0, rod.elements() - 1);
    return {piece, along - piece};
}

Vector6 turned(const Matrix3& rotation, const Vector6& local) {
    Vector6 move;
    move << rotation * local.head<3>(), rotation * local.tail<3>();
    return move;
}

/// Block `k` of six of a stacked vector.
auto six(VectorXd& x, int k) { return x.segment<6>(6 * k); }

}  // namespace

void RodRate::add(double factor, const RodRate& other) {
    const Section& from = other.section;
    section.axial += factor * from.axial, section.shear += factor * from.shear;
    section.bending += factor * from.bending, section.torsion += factor * from.torsion;
    section.mass_per_length += factor * from.mass_per_length, section.rest_twist += factor * from.rest_twist;
    section.extension_twist += factor * from.extension_twist;
    for (std::size_t k = 0; k < section.axial_law.coefficient.size(); ++k)
        section.axial_law.coefficient[k] += factor * from.axial_law.coefficient[k];
    section.axial_law.centre += factor * from.axial_law.centre;
    section.axial_law.half_range += factor * from.axial_law.half_range;
    rest_length += factor * other.rest_length;
    line_force += factor * other.line_force, base += factor * other.base, end += factor * other.end;
}

RodRate& SceneRate::rod(int i) {
    for (auto& [number, rate] : rods)
        if (number == i) return rate;
    return rods.emplace_back(i, RodRate{}).second;
}

Vector3 SceneRate::line_force(const Scene& scene, int i, const RodRate& own) const {
    return own.line_force + own.section.mass_per_length * scene.gravity +
           scene.rods[i].section.mass_per_length * gravity;
}

PlateRate& SceneRate::plate(int j) {
    for (auto& [number, rate] : plates)
        if (number == j) return rate;
    return plates.emplace_back(j, PlateRate{}).second;
}

/// Rates of the ends of a rod's pieces (pose and wrench, 12 numbers each) and of the points on it (3 each), in a few
/// directions; and which share of each direction a rate has.
struct Derivatives::PieceRates {
    std::vector<MatrixXd> ends, share;
};

/// How a point follows the first node of its piece and the wrench there.
struct Derivatives::PointRows {
    int rod, piece, row;  // row among the points of its rod
    Eigen::Matrix<double, 3, 6> by_node, by_wrench;
};

/// What a rate does to a limb whose plates and nodes stay: loads on the nodes, by piece, on the plates, and moves of
/// the rods' ends with their placements.
struct Derivatives::Load {
    std::vector<std::vector<Vector12>> pieces;
    std::vector<Vector6> plates;
    std::vector<Vector12> ends;
};

/// What an answer loses by a unit of each load on plates and nodes, what it takes from the base wrenches, and what it
/// gains by a move of the two ends of each rod on plates that stay.
struct Derivatives::Multipliers {
    VectorXd plates;
    std::vector<VectorXd> nodes, wrenches;
    std::vector<Vector12> ends;
};

Derivatives::Derivatives(std::shared_ptr<const Posture> posture, double tolerance)
    : posture_(std::move(posture)),
      shape_(posture_->solution.shape),
      equilibrium_(*posture_->geometry, posture_->scene) {
    for (int j = 0; j < posture_->geometry->plates(); ++j)
        segment_of_.insert(segment_of_.end(), posture_->geometry->segments[j].rods.size(), j);
    const auto linearise = [&](double largest_gap) {
        return equilibrium_.linearise_at(shape_) && equilibrium_.largest_gap() <= largest_gap;
    };
    // Pieces that the steps of a joined mesh miss by more than the posture's own error were short for a reason.
    choose_mesh(posture_->scene, tolerance, shape_, warm_piece);
    constexpr double rounding = 1e-11;
    if (!linearise(std::max(tolerance, rounding))) {
        shape_ = posture_->solution.shape;
        if (!linearise(std::numeric_limits<double>::infinity())) throw_singular();
    }
}

const std::vector<solve::BlockTridiagonal>& Derivatives::transposed() const {
    std::call_once(transpose_, [&] {
        const auto& chains = equilibrium_.chains_;
        std::vector<solve::BlockTridiagonal> systems(chains.size() + 1);
        bool regular = true;
        for (std::size_t i = 0; i < chains.size(); ++i) {
            const int interior = chains[i].elements() - 1;
            solve::BlockTridiagonal& system = systems[i];
            system.resize(interior);
            for (int k = 0; k < interior; ++k) {
                const Matrix12 &before = chains[i].element(k).stiffness, &after = chains[i].element(k + 1).stiffness;
                system.diagonal[k] = (before.bottomRightCorner<6, 6>() + after.topLeftCorner<6, 6>()).transpose();
                system.lower[k] = before.topRightCorner<6, 6>().transpose();
                system.upper[k] = after.bottomLeftCorner<6, 6>().transpose();
            }
            regular = regular && system.factor();
        }
        const solve::BlockTridiagonal& k = equilibrium_.balance().system();
        solve::BlockTridiagonal& plates = systems.back();
        plates.resize(k.rows());
        for (int j = 0; j < k.rows(); ++j) {
            plates.diagonal[j] = k.diagonal[j].transpose();
            if (j > 0) plates.lower[j] = k.upper[j - 1].transpose();
            if (j + 1 < k.rows()) plates.upper[j] = k.lower[j + 1].transpose();
        }
        if (!regular || !plates.factor()) throw_singular();
        transposed_ = std::move(systems);
    });
    return transposed_;
}

Matrix6 Derivatives::compliance() const {
    const Balance& balance = equilibrium_.balance();
    std::vector<Vector6> loads(posture_->geometry->plates(), Vector6::Zero()), moves(loads.size());
    Matrix6 compliance;
    for (int k = 0; k < 6; ++k) {
        loads.back() = -balance.projector(static_cast<int>(loads.size()) - 1).col(k);
        balance.solve(loads, moves);
        compliance.col(k) = moves.back();
    }
    return compliance;
}

MatrixXd Derivatives::plate_stiffness() const {
    MatrixXd dense = equilibrium_.dense_stiffness();
    for (int j = 0; j < posture_->geometry->plates(); ++j) {
        const Matrix6& free = equilibrium_.balance().projector(j);
        dense.middleRows<6>(6 * j) = free * dense.middleRows<6>(6 * j).eval();
        dense.middleCols<6>(6 * j) = dense.middleCols<6>(6 * j).eval() * free;
    }
    return dense;
}

std::vector<Vector6> Derivatives::tip_by_rods(const std::vector<RodSlope>& slopes) {
    std::vector<Vector6> moves;
    equilibrium_.respond_to_rods(shape_, slopes, moves);
    return moves;
}

Derivatives::PieceRates Derivatives::piece_rates(const std::vector<SceneRate>& rates,
                                                 const std::vector<MaterialPoint>& points) const {
    const Scene& scene = posture_->scene;
    const int rods = static_cast<int>(scene.rods.size()), count = static_cast<int>(rates.size());
    std::vector<MatrixXd> numbers(rods);
    for (int i = 0; i < rods; ++i) numbers[i] = MatrixXd::Zero(number_count(scene.rods[i].section), count);
    for (int n = 0; n < count; ++n) {
        if (!rates[n].gravity.isZero(0.0))
            for (int i = 0; i < rods; ++i) numbers[i].col(n).tail<3>() = rates[n].line_force(scene, i, {});
        for (const auto& [i, rate] : rates[n].rods)
            numbers[i].col(n) = rod_numbers(scene.rods[i].section, rate, rates[n].line_force(scene, i, rate));
    }
    // One direction a rate, or where rates are many one a number of the rod.
    std::vector<std::vector<Direction>> directions(rods);
    PieceRates out;
    out.ends.resize(rods), out.share.resize(rods);
    for (int i = 0; i < rods; ++i) {
        const MatrixXd& x = numbers[i];
        std::vector<int> changed, changing;
        for (int f = 0; f < x.rows(); ++f)
            if (!x.row(f).isZero(0.0)) changed.push_back(f);
        for (int n = 0; n < count; ++n)
            if (!x.col(n).isZero(0.0)) changing.push_back(n);
        const bool by_rate = changing.size() <= changed.size();
        const std::vector<int>& chosen = by_rate ? changing : changed;
        out.share[i] = MatrixXd::Zero(static_cast<Eigen::Index>(chosen.size()), count);
        for (std::size_t d = 0; d < chosen.size(); ++d) {
            const Section& section = scene.rods[i].section;
            directions[i].emplace_back(
                section, by_rate ? VectorXd(x.col(chosen[d])) : VectorXd(VectorXd::Unit(x.rows(), chosen[d])));
            const auto row = static_cast<Eigen::Index>(d);
            if (by_rate)
                out.share[i](row, chosen[d]) = 1.0;
            else
                out.share[i].row(row) = x.row(chosen[d]);
        }
    }

    std::vector<std::vector<Place>> places(rods);
    for (const MaterialPoint& point : points)
        places[point.rod].push_back(place_of(shape_.rods[point.rod], point.fraction));
    std::vector<std::vector<rod::EndSlope>> slopes(rods);  // of a direction: its pieces, then its points
    std::size_t all = 0;
    for (int i = 0; i < rods; ++i) {
        slopes[i].resize(directions[i].size() * (shape_.rods[i].elements() + places[i].size()));
        all += slopes[i].size();
    }
    rod::Batch batch;
    batch.reserve(static_cast<int>(all));
    std::vector<int> steps;
    for (const RodShape& rod : shape_.rods)
        if (std::find(steps.begin(), steps.end(), rod.integration.steps) == steps.end())
            steps.push_back(rod.integration.steps);
    for (const int number : steps) {
        batch.clear();
        for (int i = 0; i < rods; ++i) {
            const RodShape& rod = shape_.rods[i];
            if (rod.integration.steps != number) continue;
            const double share = 1.0 / rod.elements();
            rod::EndSlope* out_of = slopes[i].data();
            for (const Direction& d : directions[i]) {
                const auto add = [&](const Place& place) {
                    rod::RodPiece piece = equilibrium_.piece(i, shape_);
                    piece.length *= place.share;
                    batch.add(piece, rod.nodes[place.piece], rod.wrenches[place.piece], d.section,
                              place.share * share * d.length, d.force, *out_of++);
                };
                for (int e = 0; e < rod.elements(); ++e) add({e, 1.0});
                for (const Place& place : places[i])
                    if (place.share > 0.0)
                        add(place);
                    else
                        *out_of++ = {Vector6::Zero(), Vector6::Zero()};
            }
        }
        batch.run(number);
    }
    for (int i = 0; i < rods; ++i) {
        const int pieces = shape_.rods[i].elements(), here = static_cast<int>(places[i].size());
        out.ends[i].resize(12 * pieces + 3 * here, static_cast<Eigen::Index>(directions[i].size()));
        const rod::EndSlope* slope = slopes[i].data();
        for (Eigen::Index d = 0; d < out.ends[i].cols(); ++d) {
            for (int e = 0; e < pieces; ++e, ++slope)
                out.ends[i].col(d).segment<12>(12 * e) << slope->pose, slope->wrench;
            for (int p = 0; p < here; ++p, ++slope)
                out.ends[i].col(d).segment<3>(12 * pieces + 3 * p) = slope->pose.head<3>();
        }
    }
    return out;
}

std::vector<Derivatives::PointRows> Derivatives::point_rows(const std::vector<MaterialPoint>& points) const {
    std::vector<PointRows> rows;
    std::vector<int> on_rod(shape_.rods.size(), 0);
    for (const MaterialPoint& point : points) {
        const RodShape& rod = shape_.rods[point.rod];
        const Place place = place_of(rod, point.fraction);
        PointRows row{point.rod, place.piece, on_rod[point.rod]++, {}, {}};
        row.by_node << Matrix3::Identity(), Matrix3::Zero();
        row.by_wrench.setZero();
        if (place.share > 0.0) {
            rod::RodPiece piece = equilibrium_.piece(point.rod, shape_);
            piece.length *= place.share;
            const auto columns =
                rod::end_columns(piece, rod.nodes[place.piece], rod.wrenches[place.piece], rod.integration);
            row.by_node = columns.topLeftCorner<3, 6>(), row.by_wrench = columns.topRightCorner<3, 6>();
        }
        rows.push_back(row);
    }
    return rows;
}

template <class Use>
void Derivatives::for_each_plate_load(const SceneRate& rate, Use&& use) const {
    const Geometry& geometry = *posture_->geometry;
    const Scene& scene = posture_->scene;
    for (int j = 0; j < geometry.plates() && !rate.gravity.isZero(0.0); ++j) {
        const Segment& segment = geometry.segments[j];
        const Vector3 weight = segment.plate_mass * rate.gravity;
        Vector6 load;
        load << weight, (0.5 * segment.plate_thickness * shape_.plates[j].rotation.col(2)).cross(weight);
        use(j, Vector6(-load));
    }
    for (const auto& [j, change] : rate.plates) {
        const Segment& segment = geometry.segments[j];
        const Matrix3& rotation = shape_.plates[j].rotation;
        Vector6 load = scene.following ? turned(rotation, change.wrench) : change.wrench;
        load.head<3>() += change.mass * scene.gravity;
        const double arm = change.mass * segment.plate_thickness + change.thickness * segment.plate_mass;
        load.tail<3>() += (0.5 * arm * rotation.col(2)).cross(scene.gravity);
        use(j, Vector6(-load));
    }
}

void Derivatives::put_load(const SceneRate& rate, Load& load) const {
    const Geometry& geometry = *posture_->geometry;
    load.pieces.resize(shape_.rods.size());
    for (std::size_t i = 0; i < shape_.rods.size(); ++i)
        load.pieces[i].assign(shape_.rods[i].elements(), Vector12::Zero());
    load.plates.assign(geometry.plates(), Vector6::Zero());
    load.ends.assign(shape_.rods.size(), Vector12::Zero());
    for_each_end_move(geometry, shape_, rate, [&](int i, const Vector12& move) {
        const rod::Chain& chain = equilibrium_.chains_[i];
        load.ends[i] += move;
        load.pieces[i].front() += chain.element(0).stiffness.leftCols<6>() * move.head<6>();
        load.pieces[i].back() += chain.element(chain.elements() - 1).stiffness.rightCols<6>() * move.tail<6>();
        // The arms grow.
        const Vector12& at_ends = chain.ends().force;
        const auto three = [](const Vector12& x, int at) { return Vector3(x.segment<3>(at)); };
        const int j = segment_of_[i];
        load.plates[j].tail<3>() += three(move, 6).cross(three(at_ends, 6));
        if (j > 0) load.plates[j - 1].tail<3>() += three(move, 0).cross(three(at_ends, 0));
    });
    for_each_plate_load(rate, [&](int j, const Vector6& change) { load.plates[j] += change; });
}

MatrixXd Derivatives::forward(const std::vector<SceneRate>& rates, const std::vector<MaterialPoint>& points) const {
    const Geometry& geometry = *posture_->geometry;
    const int plates = geometry.plates(), rods = static_cast<int>(shape_.rods.size());
    const PieceRates pieces = piece_rates(rates, points);
    const std::vector<PointRows> rows = point_rows(points);
    MatrixXd answers(6 * plates + 3 * static_cast<Eigen::Index>(points.size()),
                     static_cast<Eigen::Index>(rates.size()));
    Moves moves;
    moves.set_zero(geometry, shape_);
    Load load;
    std::vector<Vector12> at_ends(rods);
    std::vector<Vector6> carried(plates);
    std::vector<std::vector<Vector6>> interior(rods);
    std::vector<VectorXd> slopes(rods);
    for (int i = 0; i < rods; ++i) slopes[i].resize(pieces.ends[i].rows());
    for (Eigen::Index n = 0; n < answers.cols(); ++n) {
        put_load(rates[n], load);
        for (int i = 0; i < rods; ++i) {
            const rod::Chain& chain = equilibrium_.chains_[i];
            if (pieces.share[i].col(n).isZero(0.0) && load.ends[i].isZero(0.0)) {
                at_ends[i].setZero(), slopes[i].setZero();
                interior[i].assign(chain.elements() + 1, Vector6::Zero());
                continue;
            }
            slopes[i].noalias() = pieces.ends[i] * pieces.share[i].col(n);
            for (int e = 0; e < chain.elements(); ++e) {
                // At fixed nodes a slope of the end's pose is taken back by the base wrench.
                const auto slope = slopes[i].segment<12>(12 * e);
                load.pieces[i][e] -= chain.element(e).stiffness.rightCols<6>() * slope.head<6>();
                load.pieces[i][e].tail<6>() += slope.tail<6>();
            }
            interior[i].resize(chain.elements() + 1);
            at_ends[i] = chain.condense_loads(load.pieces[i], interior[i]);
        }
        Balance::carry(geometry, shape_.plates, at_ends, carried);
        for (int j = 0; j < plates; ++j)
            carried[j] = equilibrium_.balance().projector(j) * (carried[j] + load.plates[j]).eval();
        equilibrium_.balance().solve(carried, moves.plates);
        for (int j = 0; j < plates; ++j) answers.col(n).segment<6>(6 * j) = moves.plates[j];
        if (points.empty()) continue;
        Balance::move_ends(geometry, shape_.plates, moves.plates, moves.nodes);
        for (int i = 0; i < rods; ++i) {
            const rod::Chain& chain = equilibrium_.chains_[i];
            auto& nodes = moves.nodes[i];
            chain.recover_with(interior[i], nodes);
            nodes.front() += load.ends[i].head<6>(), nodes.back() += load.ends[i].tail<6>();
            for (int e = 0; e < chain.elements(); ++e) {
                const Matrix12& k = chain.element(e).stiffness;
                moves.wrenches[i][e] = k.topRightCorner<6, 6>() * (slopes[i].segment<6>(12 * e) - nodes[e + 1]) -
                                       k.topLeftCorner<6, 6>() * nodes[e];
            }
        }
        for (std::size_t p = 0; p < rows.size(); ++p) {
            const PointRows& row = rows[p];
            const int from = 12 * shape_.rods[row.rod].elements() + 3 * row.row;
            answers.col(n).segment<3>(6 * plates + 3 * static_cast<Eigen::Index>(p)) =
                row.by_node * moves.nodes[row.rod][row.piece] + row.by_wrench * moves.wrenches[row.rod][row.piece] +
                slopes[row.rod].segment<3>(from);
        }
    }
    return answers;
}

Derivatives::Multipliers Derivatives::multipliers(const VectorXd& weights, const std::vector<PointRows>& points) const {
    const Geometry& geometry = *posture_->geometry;
    const int plates = geometry.plates(), rods = static_cast<int>(shape_.rods.size());
    const std::vector<solve::BlockTridiagonal>& systems = transposed();
    Multipliers out;
    out.nodes.resize(rods), out.wrenches.resize(rods), out.ends.resize(rods);
    std::vector<VectorXd>& nodes = out.nodes;  // first what the answer takes from each node, then the multipliers
    for (int i = 0; i < rods; ++i) {
        nodes[i] = VectorXd::Zero(6 * (shape_.rods[i].elements() + 1));
        out.wrenches[i] = VectorXd::Zero(6 * shape_.rods[i].elements());
    }
    for (std::size_t p = 0; p < points.size(); ++p) {
        const PointRows& row = points[p];
        const Vector3 weight = weights.segment<3>(6 * plates + 3 * static_cast<Eigen::Index>(p));
        six(nodes[row.rod], row.piece) += row.by_node.transpose() * weight;
        six(out.wrenches[row.rod], row.piece) += row.by_wrench.transpose() * weight;
    }
    std::vector<Vector12> at_ends(rods);
    std::vector<std::vector<Vector6>> interior(rods);
    for (int i = 0; i < rods; ++i) {
        const rod::Chain& chain = equilibrium_.chains_[i];
        const int last = chain.elements();
        VectorXd& x = nodes[i];
        // Base wrenches follow the nodes.
        for (int e = 0; e < last && !points.empty(); ++e) {
            const Matrix12& k = chain.element(e).stiffness;
            const Vector6 wrench = six(out.wrenches[i], e);
            six(x, e) -= k.topLeftCorner<6, 6>().transpose() * wrench;
            six(x, e + 1) -= k.topRightCorner<6, 6>().transpose() * wrench;
        }
        out.ends[i] << six(x, 0), six(x, last);
        for (int k = 1; k < last; ++k) interior[i].push_back(six(x, k));
        if (last > 1) {
            systems[i].solve(interior[i]);
            six(x, 0) -= chain.element(0).stiffness.bottomLeftCorner<6, 6>().transpose() * interior[i].front();
            six(x, last) -= chain.element(last - 1).stiffness.topRightCorner<6, 6>().transpose() * interior[i].back();
        }
        at_ends[i] << six(x, 0), six(x, last);
    }
    std::vector<Vector6> by_plate(plates);
    Balance::carry(geometry, shape_.plates, at_ends, by_plate);
    for (int j = 0; j < plates; ++j) by_plate[j] += weights.segment<6>(6 * j);
    systems.back().solve(by_plate);
    out.plates.resize(6 * plates);
    for (int j = 0; j < plates; ++j) {
        by_plate[j] = (equilibrium_.balance().projector(j).transpose() * by_plate[j]).eval();
        six(out.plates, j) = by_plate[j];
    }
    std::vector<std::vector<Vector6>> moves(rods);
    for (int i = 0; i < rods; ++i) moves[i].resize(2);
    Balance::move_ends(geometry, shape_.plates, by_plate, moves);
    for (int i = 0; i < rods; ++i) {
        const rod::Chain& chain = equilibrium_.chains_[i];
        const int last = chain.elements();
        VectorXd& x = nodes[i];
        six(x, 0) = moves[i].front(), six(x, last) = moves[i].back();
        if (last == 1) continue;
        std::vector<Vector6> back(last - 1, Vector6::Zero());
        back.front() += chain.element(0).stiffness.topRightCorner<6, 6>().transpose() * moves[i].front();
        back.back() += chain.element(last - 1).stiffness.bottomLeftCorner<6, 6>().transpose() * moves[i].back();
        systems[i].solve(back);
        for (int k = 1; k < last; ++k) six(x, k) = interior[i][k - 1] - back[k - 1];
    }
    for (int i = 0; i < rods; ++i) {
        // A move of an end loads its piece, and lengthens an arm.
        const rod::Chain& chain = equilibrium_.chains_[i];
        const int last = chain.elements() - 1, j = segment_of_[i];
        const VectorXd& x = nodes[i];
        out.ends[i].head<6>() -= chain.element(0).stiffness.leftCols<6>().transpose() * x.head<12>();
        out.ends[i].tail<6>() -= chain.element(last).stiffness.rightCols<6>().transpose() * x.tail<12>();
        const auto turn = [&](int plate) { return Vector3(out.plates.segment<3>(6 * plate + 3)); };
        const auto force = [&](int at) { return Vector3(chain.ends().force.segment<3>(at)); };
        out.ends[i].segment<3>(6) -= force(6).cross(turn(j));
        if (j > 0) out.ends[i].head<3>() -= force(0).cross(turn(j - 1));
    }
    return out;
}

MatrixXd Derivatives::adjoint(const MatrixXd& weights, const std::vector<SceneRate>& rates,
                              const std::vector<MaterialPoint>& points) const {
    const Geometry& geometry = *posture_->geometry;
    const int rods = static_cast<int>(shape_.rods.size());
    const Eigen::Index stacked = 6 * geometry.plates() + 3 * static_cast<Eigen::Index>(points.size());
    if (weights.cols() != stacked) throw std::invalid_argument("weights must have a column for each answer");
    const PieceRates pieces = piece_rates(rates, points);
    const std::vector<PointRows> rows = point_rows(points);
    MatrixXd found = MatrixXd::Zero(weights.rows(), static_cast<Eigen::Index>(rates.size()));
    for (Eigen::Index r = 0; r < weights.rows(); ++r) {
        Multipliers m = multipliers(weights.row(r).transpose(), rows);
        for (int i = 0; i < rods; ++i) {
            if (pieces.ends[i].cols() == 0) continue;
            const rod::Chain& chain = equilibrium_.chains_[i];
            VectorXd by_ends = VectorXd::Zero(pieces.ends[i].rows());
            for (int e = 0; e < chain.elements(); ++e) {
                const Matrix12& k = chain.element(e).stiffness;
                Vector12 both;
                both << six(m.nodes[i], e) + six(m.wrenches[i], e), six(m.nodes[i], e + 1);
                by_ends.segment<6>(12 * e) = k.rightCols<6>().transpose() * both;
                by_ends.segment<6>(12 * e + 6) = -six(m.nodes[i], e + 1);
            }
            for (std::size_t p = 0; p < rows.size(); ++p)
                if (rows[p].rod == i)
                    by_ends.segment<3>(12 * chain.elements() + 3 * rows[p].row) =
                        weights.row(r).segment<3>(stacked - 3 * static_cast<Eigen::Index>(rows.size() - p)).transpose();
            found.row(r) += (by_ends.transpose() * pieces.ends[i]) * pieces.share[i];
        }
        for (std::size_t n = 0; n < rates.size(); ++n) {
            double& sum = found(r, static_cast<Eigen::Index>(n));
            for_each_end_move(geometry, shape_, rates[n],
                              [&](int i, const Vector12& move) { sum += m.ends[i].dot(move); });
            for_each_plate_load(rates[n], [&](int j, const Vector6& load) { sum -= six(m.plates, j).dot(load); });
        }
    }
    return found;
}

std::vector<Vector6> tip_by_rods(const Posture& followed, const std::vector<RodSlope>& slopes) {
    const Solution& solution = followed.solution;
    Equilibrium equilibrium(*followed.geometry, followed.scene, solution.linearisation);
    if (!equilibrium.at_hand(solution.linearisation) && !equilibrium.linearise_at(solution.shape)) throw_singular();
    std::vector<Vector6> moves;
    equilibrium.respond_to_rods(solution.shape, slopes, moves);
    return moves;
}

}  // namespace softlimb::limb
