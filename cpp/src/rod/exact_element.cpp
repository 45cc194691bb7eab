#include "softlimb/arguments.hpp"
#include "softlimb/rod/element.hpp"

namespace softlimb::rod {
namespace {

template <class S>
RodState<S> state_at(const Pose& base, const Vector6& wrench) {
    const auto constant = [](const auto& v) { return Vec3<S>{S(v(0)), S(v(1)), S(v(2))}; };
    return {Vec3<S>{}, constant(base.rotation.col(2)), constant(base.rotation.col(0)), constant(wrench.tail<3>())};
}

Pose pose_of(const RodState<double>& y, const Vector3& origin) {
    const Vector3 t = eigen(y.tangent), d = eigen(y.director);
    Pose pose;
    pose.position = origin + eigen(y.position);
    pose.rotation << d, t.cross(d), t;
    return pose;
}

/// Calls `run.operator()<Method>()` for the method of the order asked for.
template <class Run>
void with_method(int order, Run&& run) {
    bool found = false;
    Integrators::for_each([&]<class Method>() {
        if (Method::order == order) {
            run.template operator()<Method>();
            found = true;
        }
    });
    if (!found) reject("order", order, "that of an integrator in the list");
}

}  // namespace

Vector6 pose_gap(const Pose& a, const Pose& b) {
    Vector6 gap;
    gap << a.position - b.position, log_so3(a.rotation * b.rotation.transpose());
    return gap;
}

EndState end_of(const RodPiece& piece, const Pose& base, const Vector6& base_wrench, Integration integration) {
    RodState<double> y = state_at<double>(base, base_wrench);
    Vec3<double> n = vec3(Vector3(base_wrench.head<3>()));
    Columns<double, 0> none;
    const Compliances<double> k(*piece.section);
    with_method(integration.order, [&]<class Method>() {
        advance<Method, 0>(k, piece.load, piece.length, integration.steps, n, y, none);
    });
    EndState end{pose_of(y, base.position), {}};
    end.wrench << eigen(n), eigen(y.moment);
    return end;
}

void states_along(const RodPiece& piece, const Pose& base, const Vector6& base_wrench, Integration integration,
                  const double* fractions, int count, EndState* out) {
    RodPiece part = piece;
    EndState at{base, base_wrench};
    double reached = 0.0;
    for (int i = 0; i < count; ++i) {
        const double ahead = fractions[i] - reached;
        if (ahead > 0.0) {
            part.length = ahead * piece.length;
            // Points between two steps cost one shorter step each: never coarser than the solution itself.
            const int steps = std::max(1, static_cast<int>(std::ceil(ahead * integration.steps - 1e-9)));
            at = end_of(part, at.pose, at.wrench, {integration.order, steps});
            reached = fractions[i];
        }
        out[i] = at;
    }
}

EndSlope end_slope(const RodPiece& piece, const Section& section_slope, double length_slope,
                   const Vector3& line_force_slope, const Pose& base, const Vector6& base_wrench,
                   Integration integration) {
    using S = Dual<1>;
    RodState<S> y = state_at<S>(base, base_wrench);
    Vec3<S> n{S(base_wrench(0)), S(base_wrench(1)), S(base_wrench(2))};
    const auto& [f, l] = piece.load;
    const Vector3& df = line_force_slope;
    const LineLoad<S> load{{S(f.x, {df.x()}), S(f.y, {df.y()}), S(f.z, {df.z()})}, {S(l.x), S(l.y), S(l.z)}};
    Columns<S, 0> none;
    const Compliances<S> k(*piece.section, section_slope);
    with_method(integration.order, [&]<class Method>() {
        advance<Method, 0>(k, load, S(piece.length, {length_slope}), integration.steps, n, y, none);
    });
    const auto slope = [](const Vec3<S>& v) { return Vector3(v.x.slope[0], v.y.slope[0], v.z.slope[0]); };
    const auto value = [](const Vec3<S>& v) { return Vector3(v.x.value, v.y.value, v.z.value); };
    const Vector3 t = value(y.tangent), d = value(y.director), dt = slope(y.tangent), dd = slope(y.director);
    const Vector3 e = t.cross(d);
    // dR = hat(dtheta) R:  dtheta = (t x dt + d x dd + e x de) / 2.
    const Vector3 de = dt.cross(d) + t.cross(dd);
    EndSlope out;
    out.pose << slope(y.position), 0.5 * (t.cross(dt) + d.cross(dd) + e.cross(de));
    out.wrench << slope(n), slope(y.moment);
    return out;
}

Eigen::Matrix<double, 6, 12> end_columns(const RodPiece& piece, const Pose& base, const Vector6& base_wrench,
                                         Integration integration) {
    RodState<double> y = state_at<double>(base, base_wrench);
    Vec3<double> n = vec3(Vector3(base_wrench.head<3>()));
    const Compliances<double> k(*piece.section);
    Columns<double, 9> z;
    for (int i = 0; i < 3; ++i) {
        const Vec3<double> unit = vec3(Vector3::Unit(i));
        z.column[i].rotation = unit, z.force[3 + i] = unit, z.column[6 + i].moment = unit;
    }
    with_method(integration.order,
                [&]<class Method>() { advance<Method, 9>(k, piece.load, piece.length, integration.steps, n, y, z); });
    Eigen::Matrix<double, 6, 12> columns = Eigen::Matrix<double, 6, 12>::Identity();
    for (int i = 0; i < 9; ++i) columns.col(3 + i) << eigen(z.column[i].position), eigen(z.column[i].rotation);
    return columns;
}

bool ExactElement::linearise(const RodPiece& piece, const Pose& first, const Pose& second, const Vector6& base_wrench,
                             Integration integration, ElementStiffness& out) {
    RodState<double> y = state_at<double>(first, base_wrench);
    const Vector3 force = base_wrench.head<3>(), moment = base_wrench.tail<3>();
    Vec3<double> n = vec3(force);
    const Compliances<double> k(*piece.section);
    Matrix6 end_by_wrench, wrench_by_pose;

    const auto read_wrench_columns = [&](const auto& z) {
        wrench_by_wrench_.setZero();
        for (int i = 0; i < 6; ++i) {
            end_by_wrench.col(i) << eigen(z.column[i].position), eigen(z.column[i].rotation);
            if (i < 3) wrench_by_wrench_(i, i) = 1.0;
            wrench_by_wrench_.col(i).tail<3>() = eigen(z.column[i].moment);
        }
    };
    const auto start_wrench_columns = [](auto& z) {
        for (int i = 0; i < 3; ++i)
            z.force[i] = vec3(Vector3::Unit(i)), z.column[3 + i].moment = vec3(Vector3::Unit(i));
    };
    end_by_pose_.setIdentity();
    wrench_by_pose.setZero();
    if (!piece.loaded()) {
        // Autonomous: turning base and wrench together turns the whole piece, so the three columns of the base rotation
        // follow from the six of the wrench.
        Columns<double, 6> z;
        start_wrench_columns(z);
        with_method(integration.order, [&]<class Method>() {
            advance<Method, 6>(k, piece.load, piece.length, integration.steps, n, y, z);
        });
        read_wrench_columns(z);
        Matrix6 turned = Matrix6::Zero();  // of the base wrench by the base rotation, when it turns along
        turned.block<3, 3>(0, 3) = -hat(force);
        turned.block<3, 3>(3, 3) = -hat(moment);
        end_by_pose_.block<3, 3>(0, 3) = -hat(eigen(y.position));
        end_by_pose_.rightCols<3>() -= end_by_wrench * turned.rightCols<3>();
        wrench_by_pose.block<3, 3>(0, 3) = -hat(eigen(n));
        wrench_by_pose.block<3, 3>(3, 3) = -hat(eigen(y.moment));
        wrench_by_pose.rightCols<3>() -= wrench_by_wrench_ * turned.rightCols<3>();
    } else {
        Columns<double, 9> z;
        start_wrench_columns(z);
        for (int i = 0; i < 3; ++i) z.column[6 + i].rotation = vec3(Vector3::Unit(i));
        with_method(integration.order, [&]<class Method>() {
            advance<Method, 9>(k, piece.load, piece.length, integration.steps, n, y, z);
        });
        read_wrench_columns(z);
        for (int i = 0; i < 3; ++i) {
            const Variation<double>& turned = z.column[6 + i];
            end_by_pose_.col(3 + i) << eigen(turned.position), eigen(turned.rotation);
            wrench_by_pose.col(3 + i).tail<3>() = eigen(turned.moment);
        }
    }

    end_.pose = pose_of(y, first.position);
    end_.wrench << eigen(n), eigen(y.moment);
    gap_ = pose_gap(end_.pose, second);
    if (!end_.pose.finite() || !end_.wrench.allFinite() || !end_by_wrench.allFinite()) return false;

    // The columns of forces and moments differ by the square of a length: scale them before the inversion.
    const double scale = piece.length;
    Matrix6 scaled = end_by_wrench;
    scaled.leftCols<3>() *= 1.0 / scale;
    scaled.bottomRows<3>() *= scale;
    end_by_wrench_inverse_ = scaled.partialPivLu().inverse();
    end_by_wrench_inverse_.topRows<3>() *= 1.0 / scale;
    end_by_wrench_inverse_.rightCols<3>() *= scale;
    if (!end_by_wrench_inverse_.allFinite()) return false;

    // w = w0 + B^-1 (x2 - A x1 - gap),  w_end = w_end0 + D x1 + E (w - w0)
    const Matrix6& inverse = end_by_wrench_inverse_;
    const Matrix6 by_first = inverse * end_by_pose_;
    const Matrix6 by_second = wrench_by_wrench_ * inverse;
    out.stiffness.topLeftCorner<6, 6>() = by_first;
    out.stiffness.topRightCorner<6, 6>() = -inverse;
    out.stiffness.bottomLeftCorner<6, 6>() = wrench_by_pose - wrench_by_wrench_ * by_first;
    out.stiffness.bottomRightCorner<6, 6>() = by_second;
    out.force << -(base_wrench - inverse * gap_), end_.wrench - by_second * gap_;
    return true;
}

lanes::Linear ExactElement::target(const Pose& second, ElementStiffness& out) {
    return {second.position.data(),
            second.rotation.data(),
            end_.target(),
            gap_.data(),
            end_by_pose_.data(),
            end_by_wrench_inverse_.data(),
            wrench_by_wrench_.data(),
            out.force.data(),
            out.stiffness.data(),
            &regular_};
}

void Batch::reserve(int pieces) {
    starts_.reserve(pieces);
    linear_.reserve(pieces);
    ends_.reserve(pieces);
    slopes_.reserve(pieces);
    end_slopes_.reserve(pieces);
}

void Batch::clear() {
    starts_.clear();
    linear_.clear();
    ends_.clear();
    slopes_.clear();
    end_slopes_.clear();
    loads_ = lanes::Loads::none;
}

void Batch::add(const RodPiece& piece, const Pose& base, const Vector6& base_wrench, const Section& section_slope,
                double length_slope, const Vector3& line_force_slope, EndSlope& end) {
    add(piece, base, base_wrench);
    slopes_.push_back(
        {&section_slope, length_slope, {line_force_slope.x(), line_force_slope.y(), line_force_slope.z()}});
    end_slopes_.push_back({end.pose.data(), end.wrench.data()});
}

void Batch::add(const RodPiece& piece, const Pose& base, const Vector6& base_wrench) {
    const auto& [f, l] = piece.load;
    starts_.push_back({piece.section,
                       base.position.data(),
                       base.rotation.data(),
                       base_wrench.data(),
                       piece.length,
                       {f.x, f.y, f.z},
                       {l.x, l.y, l.z}});
    if (!is_zero(l))
        loads_ = lanes::Loads::any;
    else if (loads_ == lanes::Loads::none && piece.loaded())
        loads_ = lanes::Loads::force;
}

void Batch::run(int steps) const {
    const int count = static_cast<int>(starts_.size());
    if (!linear_.empty())
        lanes::kernel().linearise(starts_.data(), linear_.data(), count, steps, loads_);
    else if (!slopes_.empty())
        lanes::kernel().differentiate(starts_.data(), slopes_.data(), end_slopes_.data(), count, steps);
    else
        lanes::kernel().shoot(starts_.data(), ends_.data(), count, steps);
}

Vector6 ExactElement::wrench_change(const Vector6& first, const Vector6& second, const Vector6& gap) const {
    Vector6 missing = second - gap - end_by_pose_.rightCols<3>() * first.tail<3>();
    missing.head<3>() -= first.head<3>();  // a shift of the base shifts the end
    return end_by_wrench_inverse_ * missing;
}

}  // namespace softlimb::rod
