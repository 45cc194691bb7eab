// Inverses of 6 x 6 blocks against Eigen's own.
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "check.hpp"
#include "examples.hpp"
#include "softlimb/solve/block6.hpp"
#include "softlimb/solve/definite.hpp"

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

CLAIM(block_rows_are_definite_where_all_eigenvalues_of_the_whole_matrix_are_positive) {
    Draw draw(62);
    for (const int rows : {1, 2, 3, 5})
        for (int trial = 0; trial < 20; ++trial) {
            Eigen::MatrixXd whole = Eigen::MatrixXd::Zero(6 * rows, 6 * rows);
            for (int k = 0; k < rows; ++k) {
                const Matrix6 block = draw.matrix<Matrix6>();
                whole.block<6, 6>(6 * k, 6 * k) = 0.5 * (block + block.transpose());
                if (k == 0) continue;
                whole.block<6, 6>(6 * k, 6 * k - 6) = draw.matrix<Matrix6>();
                whole.block<6, 6>(6 * k - 6, 6 * k) = whole.block<6, 6>(6 * k, 6 * k - 6).transpose();
            }
            const double smallest = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(whole).eigenvalues()(0);
            // Just above and just below zero: rounding moves an eigenvalue of numbers up to ten by 1e-14.
            for (const double lift : {1e-9, 0.1, -1e-9, -0.1}) {
                solve::DefiniteRows told;
                bool definite = true;
                for (int k = 0; k < rows && definite; ++k) {
                    Matrix6 diagonal = whole.block<6, 6>(6 * k, 6 * k);
                    diagonal.diagonal().array() += lift - smallest;
                    diagonal.triangularView<Eigen::StrictlyUpper>().setConstant(7.0);  // is not read
                    definite = told.add(diagonal);
                    if (definite && k + 1 < rows) told.couple(whole.block<6, 6>(6 * k + 6, 6 * k));
                }
                CHECK(definite == (lift > 0.0));
            }
        }
    Matrix6 a = Matrix6::Identity();
    a(3, 1) = std::numeric_limits<double>::quiet_NaN();
    CHECK(!solve::DefiniteRows().add(a));
}
