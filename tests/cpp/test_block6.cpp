// Inverses of 6 x 6 blocks against Eigen's own.
#include <Eigen/LU>

#include "check.hpp"
#include "examples.hpp"
#include "softlimb/solve/block6.hpp"

using namespace softlimb;
using namespace softlimb::tests;

CLAIM(a_block_times_its_inverse_is_one) {
    Draw draw(60);
    for (int trial = 0; trial < 50; ++trial) {
        Matrix6 a = draw.matrix<Matrix6>(), inverse;
        if (trial % 3 == 0) a.topLeftCorner<3, 3>().setZero();  // pivots have to be looked for
        CHECK(solve::invert(a, inverse));
        const Matrix6 reference = a.partialPivLu().inverse();
        CHECK_NEAR(inverse, reference, 1e-11 * reference.norm() * reference.norm() * a.norm());
        CHECK_NEAR(a * inverse, Matrix6::Identity(), 1e-13 * a.norm() * reference.norm());
    }
}

CLAIM(a_block_without_inverse_is_refused) {
    Matrix6 inverse;
    CHECK(!solve::invert(Matrix6::Zero(), inverse));
    Matrix6 a = Matrix6::Identity();
    a(3, 3) = std::numeric_limits<double>::quiet_NaN();
    CHECK(!solve::invert(a, inverse));
    a(3, 3) = std::numeric_limits<double>::infinity();
    CHECK(!solve::invert(a, inverse));
}

CLAIM(only_positive_blocks_are_inverted_as_positive) {
    Draw draw(61);
    for (int trial = 0; trial < 20; ++trial) {
        const Matrix6 root = draw.matrix<Matrix6>();
        const Matrix6 a = root * root.transpose() + 0.1 * Matrix6::Identity();
        Matrix6 inverse;
        CHECK(solve::invert_positive(a, inverse));
        CHECK_NEAR(a * inverse, Matrix6::Identity(), 1e-12 * a.norm() * inverse.norm());
        Matrix6 b = a;
        b(5, 5) -= 1.001 / inverse(5, 5);  // takes the determinant through zero
        CHECK(!solve::invert_positive(b, inverse));
        b(2, 2) = std::numeric_limits<double>::quiet_NaN();
        CHECK(!solve::invert_positive(b, inverse));
    }
}
