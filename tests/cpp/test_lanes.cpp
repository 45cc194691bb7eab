// The lanes against the plain element: same equations, same method, so the same numbers to rounding; and a piece that
// does not feel its neighbours.
#include "check.hpp"
#include "examples.hpp"
#include "same_bits.hpp"
#include "softlimb/rod/element.hpp"
#include "softlimb/rod/integrators.hpp"

using namespace softlimb;
using namespace softlimb::rod;
using namespace softlimb::tests;

namespace {

/// Pieces of all kinds, each with a second node that it misses by up to `miss` radians.
struct Pieces {
    std::vector<Section> sections;
    std::vector<RodPiece> pieces;
    std::vector<Pose> first, second;
    std::vector<Vector6> wrenches;

    Pieces(Draw& draw, int count, lanes::Loads loads, double miss) {
        sections = {soft_section(), odd_section(), soft_section()};
        sections[2].bending *= 3.0, sections[2].shear *= 0.5;
        for (int i = 0; i < count; ++i) {
            LineLoad<double> load;
            if (loads != lanes::Loads::none && i % 4 != 3) load.force = vec3(draw.matrix<Vector3>(3.0));
            if (loads == lanes::Loads::any && i % 2 == 0) load.moment = vec3(draw.matrix<Vector3>(0.05));
            pieces.push_back({&sections[i % 3], 0.1 + 0.02 * (i % 5), load});
            first.push_back(draw.pose(2.0));
            Vector6 w;
            w << draw.matrix<Vector3>(10.0), draw.matrix<Vector3>(0.8);
            wrenches.push_back(w);
            const Pose end = end_of(pieces.back(), first.back(), w, {8, 2}).pose;
            Vector6 gap;
            gap << draw.matrix<Vector3>(0.01), miss * draw.direction();
            second.push_back(moved(end, gap));
        }
    }
    int count() const { return static_cast<int>(pieces.size()); }
};

struct Linearised {
    std::vector<ExactElement> elements;
    std::vector<ElementStiffness> stiffness;
};

Linearised in_lanes(const Pieces& p, int steps, int from, int to) {
    Linearised out{std::vector<ExactElement>(to - from), std::vector<ElementStiffness>(to - from)};
    Batch batch;
    batch.reserve(to - from);
    for (int i = from; i < to; ++i)
        batch.add(p.pieces[i], p.first[i], p.wrenches[i],
                  out.elements[i - from].target(p.second[i], out.stiffness[i - from]));
    batch.run(steps);
    return out;
}

}  // namespace

CLAIM(lanes_linearise_as_the_plain_element_does) {
    for (const lanes::Loads loads : {lanes::Loads::none, lanes::Loads::force, lanes::Loads::any})
        for (const double miss : {1e-9, 0.05, 0.5, 2.5}) {
            Draw draw(70);
            const Pieces p(draw, 19, loads, miss);
            with_every_instruction_set([&] {
                const Linearised found = in_lanes(p, 3, 0, p.count());
                for (int i = 0; i < p.count(); ++i) {
                    ExactElement plain;
                    ElementStiffness expected;
                    CHECK(plain.linearise(p.pieces[i], p.first[i], p.second[i], p.wrenches[i], {8, 3}, expected));
                    const ExactElement& element = found.elements[i];
                    CHECK(element.regular());
                    // A few hundred operations and one inverse of a well-scaled matrix: rounding, times its condition.
                    const double size = expected.stiffness.norm();
                    CHECK_NEAR(found.stiffness[i].stiffness, expected.stiffness, 1e-11 * size);
                    CHECK_NEAR(found.stiffness[i].force, expected.force, 1e-11 * (size + expected.force.norm()));
                    CHECK_NEAR(element.gap(), plain.gap(), 1e-13);
                    CHECK_NEAR(element.end().pose.position, plain.end().pose.position, 1e-14);
                    CHECK_NEAR(element.end().pose.rotation, plain.end().pose.rotation, 1e-14);
                    CHECK_NEAR(element.end().wrench, plain.end().wrench, 1e-12);
                    const Vector6 x = 0.01 * draw.matrix<Vector6>(), y = 0.01 * draw.matrix<Vector6>();
                    const Vector6 change = plain.wrench_change(x, y, plain.gap());
                    CHECK_NEAR(element.wrench_change(x, y, element.gap()), change, 1e-11 * size);
                    CHECK_NEAR(element.end_wrench_by_base_wrench(), plain.end_wrench_by_base_wrench(), 1e-12);
                }
            });
        }
}

CLAIM(lanes_shoot_as_the_plain_integrator_does) {
    Draw draw(71);
    const Pieces p(draw, 11, lanes::Loads::any, 0.1);
    with_every_instruction_set([&] {
        std::vector<EndState> ends(p.count());
        Batch batch;
        for (int i = 0; i < p.count(); ++i) batch.add(p.pieces[i], p.first[i], p.wrenches[i], ends[i]);
        batch.run(2);
        for (int i = 0; i < p.count(); ++i) {
            const EndState expected = end_of(p.pieces[i], p.first[i], p.wrenches[i], {8, 2});
            CHECK_NEAR(ends[i].pose.position, expected.pose.position, 1e-14);
            CHECK_NEAR(ends[i].pose.rotation, expected.pose.rotation, 1e-14);
            CHECK_NEAR(ends[i].wrench, expected.wrench, 1e-12);
        }
    });
}

namespace {

/// The same as `shoot_alone` by the plain integrator.
template <class Method, int columns, template <class> class State>
void shoot_plainly(const lanes::RodAlone& rod, State<double> y, RodState<double>* node,
                   Variation<double> (*column)[2]) {
    const Compliances<double> k(*rod.section);
    Columns<double, columns> z;
    for (int c = 0; c < columns; ++c) z.column[c] = column[rod.pieces][c];
    Vec3<double> n = rod.tip_force;
    for (int i = rod.pieces; i-- > 0;) {
        advance<Method, columns>(k, rod.load, -rod.length / rod.pieces, rod.steps, n, y, z);
        node[i].position = y.position, node[i].tangent = y.tangent, node[i].moment = y.moment;
        if constexpr (requires { y.director; }) node[i].director = y.director;
        for (int c = 0; c < columns; ++c) column[i][c] = z.column[c];
    }
}

void shoot_plainly(const lanes::RodAlone& rod, RodState<double>* node, Variation<double> (*column)[2]) {
    const RodState<double> tip = node[rod.pieces];
    const AxisState<double> axis{tip.position, tip.tangent, tip.moment};
    if (rod.wanted == lanes::Wanted::slopes) return shoot_plainly<Rk4, 2>(rod, axis, node, column);
    if (rod.wanted == lanes::Wanted::axis) return shoot_plainly<Rk8, 0>(rod, axis, node, column);
    shoot_plainly<Rk8, 0>(rod, tip, node, column);
}

}  // namespace

CLAIM(a_rod_alone_is_shot_as_by_the_plain_integrator) {
    Draw draw(76);
    with_every_instruction_set([&] {
        for (const lanes::Wanted wanted : {lanes::Wanted::slopes, lanes::Wanted::axis, lanes::Wanted::directors})
            for (const Section& section : {soft_section(), odd_section()}) {
                constexpr int pieces = 3;
                const LineLoad<double> load{vec3(draw.matrix<Vector3>(3.0)), vec3(draw.matrix<Vector3>(0.05))};
                const Vec3<double> force = vec3(draw.matrix<Vector3>(10.0));
                const lanes::RodAlone rod{&section, 0.3, load, force, pieces, 2, wanted};
                const Matrix3 frame = draw.pose(2.0).rotation;
                RodState<double> node[pieces + 1]{}, expected[pieces + 1]{};
                Variation<double> column[pieces + 1][2]{}, expected_column[pieces + 1][2]{};
                node[pieces] = {{}, vec3(frame.col(2)), vec3(frame.col(0)), vec3(draw.matrix<Vector3>(0.1))};
                for (int c = 0; c < 2; ++c) column[pieces][c].rotation = vec3(frame.col(c));
                expected[pieces] = node[pieces];
                for (int c = 0; c < 2; ++c) expected_column[pieces][c] = column[pieces][c];
                lanes::kernel().shoot_alone(rod, node, column);
                shoot_plainly(rod, expected, expected_column);
                // Fused multiplications round otherwise: a few of the last digits of numbers of size one.
                const auto check = [](const Vec3<double>& a, const Vec3<double>& b) {
                    CHECK_NEAR(eigen(a), eigen(b), 1e-13 * (1.0 + eigen(b).norm()));
                };
                for (int i = 0; i <= pieces; ++i) {
                    check(node[i].position, expected[i].position), check(node[i].tangent, expected[i].tangent);
                    check(node[i].director, expected[i].director), check(node[i].moment, expected[i].moment);
                    for (int c = 0; c < 2; ++c) {
                        const Variation<double>&a = column[i][c], &b = expected_column[i][c];
                        check(a.position, b.position), check(a.rotation, b.rotation), check(a.moment, b.moment);
                    }
                }
                const bool moved = eigen(node[0].position).norm() > 0.01;
                CHECK(moved && (wanted != lanes::Wanted::slopes || eigen(column[0][0].moment).norm() > 1e-3));
            }
    });
}

CLAIM(a_piece_gives_the_same_bits_alone_and_in_any_lane) {
    Draw draw(72);
    const Pieces p(draw, 17, lanes::Loads::force, 0.02);
    with_every_instruction_set([&] {
        const Linearised all = in_lanes(p, 2, 0, p.count());
        for (int from = 0; from < p.count(); ++from) {
            const int to = std::min(p.count(), from + 1 + from % 4);
            // Alone, a loaded piece and one without load are the same kind only beside loaded ones.
            if (!p.pieces[from].loaded()) continue;
            const Linearised some = in_lanes(p, 2, from, to);
            CHECK(same_numbers(some.stiffness[0].stiffness, all.stiffness[from].stiffness));
            CHECK(same_numbers(some.stiffness[0].force, all.stiffness[from].force));
            CHECK(same_numbers(some.elements[0].end().wrench, all.elements[from].end().wrench));
        }
    });
}

CLAIM(a_lane_without_a_finite_shape_says_so_and_leaves_the_others_alone) {
    Draw draw(73);
    Pieces p(draw, 9, lanes::Loads::force, 0.02);
    with_every_instruction_set([&] {
        const Linearised before = in_lanes(p, 2, 0, p.count());
        Pieces sick = p;
        for (std::size_t i = 0; i < sick.pieces.size(); ++i) sick.pieces[i].section = &sick.sections[i % 3];
        sick.wrenches[4].setConstant(std::numeric_limits<double>::quiet_NaN());
        sick.wrenches[6].setConstant(1e200);
        const Linearised after = in_lanes(sick, 2, 0, sick.count());
        for (int i = 0; i < p.count(); ++i) {
            CHECK(after.elements[i].regular() == (i != 4 && i != 6));
            if (i == 4 || i == 6) continue;
            CHECK(same_numbers(after.stiffness[i].stiffness, before.stiffness[i].stiffness));
        }
    });
}

CLAIM(an_instruction_set_that_the_machine_has_not_is_refused_by_name) {
    CHECK_RAISES(std::invalid_argument, lanes::use("quantum"));
    CHECK(std::string(lanes::kernels().front()->instruction_set) == "baseline");
}

CLAIM(lanes_differentiate_as_dual_numbers_do) {
    for (const lanes::Loads loads : {lanes::Loads::none, lanes::Loads::any}) {
        Draw draw(74);
        const Pieces p(draw, 13, loads, 0.0);
        std::vector<Section> slopes;
        std::vector<double> lengths;
        std::vector<Vector3> forces;
        for (int i = 0; i < p.count(); ++i) {
            // Slopes of the size of the section itself; only a curved law has more than one coefficient.
            Section slope = p.sections[i % 3];
            slope.axial *= draw(), slope.shear *= draw(), slope.bending *= draw(), slope.torsion *= draw();
            slope.rest_twist = draw(), slope.extension_twist = 0.01 * draw();
            for (double& c : slope.axial_law.coefficient) c *= draw();
            slopes.push_back(slope), lengths.push_back(0.1 * draw()), forces.push_back(draw.matrix<Vector3>());
        }
        with_every_instruction_set([&] {
            std::vector<EndSlope> found(p.count());
            Batch batch;
            for (int i = 0; i < p.count(); ++i)
                batch.add(p.pieces[i], p.first[i], p.wrenches[i], slopes[i], lengths[i], forces[i], found[i]);
            constexpr int steps = 16;
            batch.run(steps);
            for (int i = 0; i < p.count(); ++i) {
                const EndSlope expected =
                    end_slope(p.pieces[i], slopes[i], lengths[i], forces[i], p.first[i], p.wrenches[i], {8, steps});
                // Dual numbers differentiate the directors, which leave orthonormality by the integration error; the
                // lanes integrate the turn itself. They agree to that error.
                CHECK_NEAR(found[i].pose, expected.pose, 1e-9 * (1.0 + expected.pose.norm()));
                CHECK_NEAR(found[i].wrench, expected.wrench, 1e-9 * (1.0 + expected.wrench.norm()));
            }
        });
    }
}

CLAIM(geodesic_elements_in_lanes_are_the_plain_ones_to_rounding_and_to_the_bit_in_any_lane) {
    Draw draw(75);
    Pieces p(draw, 17, lanes::Loads::any, 0.3);
    p.sections[1].extension_twist = 0.2 / std::sqrt(p.sections[1].axial * p.sections[1].torsion);
    for (std::size_t i = 0; i < p.pieces.size(); ++i) p.pieces[i].section = &p.sections[i % 3];
    const auto run = [&](int from, int to) {
        std::vector<ElementStiffness> out(to - from);
        std::vector<lanes::Geodesic> elements;
        std::vector<lanes::GeodesicEnd> ends;
        for (int i = from; i < to; ++i) {
            const Vector6 twist = log_se3(p.first[i].inverse() * p.second[i]);
            elements.push_back(geodesic_lane(p.pieces[i], twist, p.first[i].rotation, p.second[i].rotation));
            ends.push_back({out[i - from].force.data(), out[i - from].stiffness.data()});
        }
        lanes::kernel().geodesics(elements.data(), ends.data(), to - from);
        return out;
    };
    with_every_instruction_set([&] {
        const std::vector<ElementStiffness> all = run(0, p.count());
        for (int i = 0; i < p.count(); ++i) {
            ElementStiffness plain;
            geodesic_element(p.pieces[i], p.first[i], p.second[i], plain);
            // Sums of some tens of products of the largest entries' size.
            CHECK_NEAR(all[i].stiffness, plain.stiffness, 1e-14 * plain.stiffness.cwiseAbs().maxCoeff());
            CHECK_NEAR(all[i].force, plain.force, 1e-13 * plain.force.cwiseAbs().maxCoeff());
            const ElementStiffness alone = run(i, i + 1).front();
            CHECK(same_numbers(alone.stiffness, all[i].stiffness));
            CHECK(same_numbers(alone.force, all[i].force));
        }
    });
}

CLAIM(an_element_is_carried_to_its_plates_by_its_arms) {
    Draw draw(76);
    ElementStiffness ends{draw.matrix<Vector12>(), draw.matrix<Matrix12>()};
    const Vector3 base = draw.matrix<Vector3>(), end = draw.matrix<Vector3>();
    const auto arm = [](const Vector3& a) {  // moves at the arm by moves of the plate's origin
        Matrix6 l = Matrix6::Identity();
        l.topRightCorner<3, 3>() = -hat(a);
        return l;
    };
    Matrix12 both = Matrix12::Zero();
    both.topLeftCorner<6, 6>() = arm(base), both.bottomRightCorner<6, 6>() = arm(end);
    const Matrix12 expected = both.transpose() * ends.stiffness * both;
    const Matrix6 before = draw.matrix<Matrix6>();
    with_every_instruction_set([&] {
        Matrix6 at_base = before, upper = before, lower = before, at_end = before;
        lanes::kernel().carry(ends.force.data(), base.data(), end.data(), at_base.data(), upper.data(), lower.data(),
                              at_end.data());
        CHECK_NEAR(at_base, (before + expected.topLeftCorner<6, 6>()), 1e-14 * expected.norm());
        CHECK_NEAR(upper, (before + expected.topRightCorner<6, 6>()), 1e-14 * expected.norm());
        CHECK_NEAR(lower, (before + expected.bottomLeftCorner<6, 6>()), 1e-14 * expected.norm());
        CHECK_NEAR(at_end, (before + expected.bottomRightCorner<6, 6>()), 1e-14 * expected.norm());
        Matrix6 grounded = before;
        lanes::kernel().carry(ends.force.data(), base.data(), end.data(), nullptr, nullptr, nullptr, grounded.data());
        CHECK_NEAR(grounded, at_end, 0.0);
    });
}
