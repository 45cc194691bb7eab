#include "check.hpp"
#include "examples.hpp"
#include "softlimb/rod/chain.hpp"
#include "softlimb/solve/block_tridiagonal.hpp"

using namespace softlimb;
using namespace softlimb::rod;
using namespace softlimb::tests;

namespace {

/// A chain of random elements; symmetric ones if asked for, each with `floor` on its diagonal.
Chain random_chain(Draw& draw, int elements, bool symmetric, double floor) {
    Chain chain;
    chain.resize(elements);
    for (int e = 0; e < elements; ++e) {
        Matrix12 k = draw.matrix<Matrix12>();
        if (symmetric) k = (0.5 * (k + k.transpose())).eval();
        k.diagonal().array() += floor;
        chain.element(e) = {draw.matrix<Vector12>(), k};
    }
    return chain;
}

std::vector<Vector12> own_loads(const Chain& chain) {
    std::vector<Vector12> loads;
    for (int e = 0; e < chain.elements(); ++e) loads.push_back(chain.element(e).force);
    return loads;
}

/// What the assembled chain, nothing condensed, leaves at each node when the nodes move.
std::vector<Vector6> assembled(const Chain& chain, const std::vector<Vector12>& loads,
                               const std::vector<Vector6>& nodes) {
    std::vector<Vector6> rest(nodes.size(), Vector6::Zero());
    for (int e = 0; e < chain.elements(); ++e) {
        Vector12 moves;
        moves << nodes[e], nodes[e + 1];
        const Vector12 force = chain.element(e).stiffness * moves + loads[e];
        rest[e] += force.head<6>(), rest[e + 1] += force.tail<6>();
    }
    return rest;
}

/// Negative eigenvalues of the assembled stiffness of the interior nodes plus `lift`, by elimination row by row.
int dense_negative_eigenvalues(const Chain& chain, double lift) {
    const int n = 6 * (chain.elements() - 1);
    std::vector<std::vector<double>> k(n, std::vector<double>(n, 0.0));
    for (int e = 0; e < chain.elements(); ++e)
        for (int i = 0; i < 12; ++i)
            for (int j = 0; j < 12; ++j) {
                const int row = 6 * (e - 1) + i, column = 6 * (e - 1) + j;
                if (row >= 0 && row < n && column >= 0 && column < n)
                    k[row][column] += chain.element(e).stiffness(i, j);
            }
    int negative = 0;
    for (int p = 0; p < n; ++p) k[p][p] += lift;
    for (int p = 0; p < n; ++p) {
        negative += k[p][p] < 0.0;
        for (int row = p + 1; row < n; ++row)
            for (int column = p + 1; column < n; ++column) k[row][column] -= k[row][p] * k[p][column] / k[p][p];
    }
    return negative;
}

}  // namespace

CLAIM(a_condensed_chain_answers_as_the_assembled_one_does) {
    with_every_instruction_set([] {
        Draw draw(20);
        for (const int elements : {1, 2, 3, 8})
            for (const bool symmetric : {true, false}) {
                Chain chain = random_chain(draw, elements, symmetric, 4.0);
                CHECK(chain.condense(Vector6::Zero(), false, false));
                std::vector<Vector12> other(elements);
                std::vector<Vector6> interior(elements + 1, Vector6::Zero()), nodes(elements + 1);
                for (Vector12& load : other) load = draw.matrix<Vector12>();
                for (const bool own : {true, false}) {
                    nodes.front() = draw.matrix<Vector6>(), nodes.back() = draw.matrix<Vector6>();
                    Vector12 ends_move, ends_force = chain.ends().force;
                    ends_move << nodes.front(), nodes.back();
                    if (own) {
                        chain.recover(nodes);
                    } else {
                        ends_force = chain.condense_loads(other, interior);
                        chain.recover_with(interior, nodes);
                    }
                    const std::vector<Vector6> rest = assembled(chain, own ? own_loads(chain) : other, nodes);
                    const Vector12 ends = chain.ends().stiffness * ends_move + ends_force;
                    // The floor keeps pivots away from zero: a few hundred roundings of numbers up to ten.
                    for (int e = 1; e < elements; ++e) CHECK_NEAR(rest[e], Vector6::Zero(), 1e-11);
                    CHECK_NEAR(rest.front(), ends.head<6>(), 1e-11);
                    CHECK_NEAR(rest.back(), ends.tail<6>(), 1e-11);
                }
            }
    });
}

CLAIM(negative_pivots_count_the_unstable_modes_between_held_ends) {
    with_every_instruction_set([] {
        Draw draw(21);
        for (int trial = 0; trial < 20; ++trial) {
            Chain chain = random_chain(draw, 5, true, 0.0);
            for (const double lift : {0.0, 1.0, 2.0, 3.0, 30.0}) {
                const int negative = dense_negative_eigenvalues(chain, lift);
                CHECK(chain.condense(Vector6::Constant(lift), true, false));
                CHECK(chain.negative_pivots() == negative);
                CHECK(chain.positive_beyond(Vector6::Constant(-lift)) == (negative == 0));
                CHECK(chain.condense(Vector6::Constant(lift), true, true) == (negative == 0));
            }
        }
    });
}

CLAIM(a_chain_that_cannot_be_eliminated_says_so) {
    with_every_instruction_set([] {
        Chain chain;
        chain.resize(3);
        for (int e = 0; e < 3; ++e) chain.element(e) = {Vector12::Zero(), Matrix12::Zero()};
        CHECK(!chain.condense(Vector6::Zero(), false, false));
        for (int e = 0; e < 3; ++e) chain.element(e).stiffness.setConstant(std::numeric_limits<double>::quiet_NaN());
        CHECK(!chain.condense(Vector6::Zero(), false, false));
        CHECK(!chain.condense(Vector6::Zero(), true, true));
    });
}

CLAIM(block_tridiagonal_systems_are_solved) {
    Draw draw(22);
    for (const int rows : {1, 2, 3, 7})
        for (const bool symmetric : {true, false}) {
            solve::BlockTridiagonal system;
            system.resize(rows);
            system.set_zero();
            std::vector<Vector6> right(rows);
            for (int k = 0; k < rows; ++k) {
                const Matrix6 random = draw.matrix<Matrix6>();
                // A diagonal that outweighs its neighbours, whose rows sum to twelve at most.
                system.diagonal[k] = symmetric ? Matrix6(0.5 * (random + random.transpose())) : random;
                system.diagonal[k].diagonal().array() += 20.0;
                right[k] = draw.matrix<Vector6>();
                if (k == 0) continue;
                system.lower[k] = draw.matrix<Matrix6>();
                system.upper[k - 1] = symmetric ? Matrix6(system.lower[k].transpose()) : draw.matrix<Matrix6>();
            }
            std::vector<Vector6> x = right;
            CHECK(symmetric ? system.factor_positive() : system.factor());
            system.solve(x);
            for (int k = 0; k < rows; ++k) {
                Vector6 row = system.diagonal[k] * x[k];
                if (k > 0) row += system.lower[k] * x[k - 1];
                if (k + 1 < rows) row += system.upper[k] * x[k + 1];
                CHECK_NEAR(row, right[k], 1e-13);
            }
        }
}

CLAIM(a_system_that_is_singular_or_not_positive_is_refused) {
    solve::BlockTridiagonal system;
    system.resize(2);
    system.set_zero();
    CHECK(!system.factor());
    system.diagonal[0].setIdentity(), system.diagonal[1] = -Matrix6::Identity();
    CHECK(system.factor());
    CHECK(!system.factor_positive());
    system.diagonal[1].setConstant(std::numeric_limits<double>::quiet_NaN());
    CHECK(!system.factor() && !system.factor_positive());
}
