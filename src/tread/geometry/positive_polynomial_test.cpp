#include "tread/geometry/positive_polynomial.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <random>

namespace tread::internal {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The smallest root in (0, 1] from the eigenvalues of the companion matrix; infinity if none.
template <std::size_t N>
double smallest_root(const Polynomial<N>& c) {
  constexpr auto n = static_cast<Eigen::Index>(N - 1);
  Eigen::MatrixXd companion = Eigen::MatrixXd::Zero(n, n);
  companion.bottomLeftCorner(n - 1, n - 1).setIdentity();
  for (Eigen::Index i = 0; i < n; ++i) {
    companion(i, n - 1) = -c[static_cast<std::size_t>(i)] / c[N - 1];
  }
  double smallest = kInfinity;
  for (const std::complex<double> root : companion.eigenvalues()) {
    if (std::abs(root.imag()) < 1e-9 && root.real() > 0.0 && root.real() <= 1.0) {
      smallest = std::min(smallest, root.real());
    }
  }
  return smallest;
}

TEST(PositivePolynomial, AgreesWithTheRootsOfTheCompanionMatrix) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(-5.0, 5.0);
  int with_root = 0, without = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    Polynomial<9> c;
    for (double& v : c) v = uniform(random);
    c[0] = 1.0;
    const double root = smallest_root(c);
    (std::isinf(root) ? without : with_root) += 1;
    EXPECT_EQ(positive_up_to(c, 1.0), std::isinf(root)) << "root " << root;
    const double found = first_sign_change(c, 1.0);
    if (std::isinf(root)) {
      EXPECT_EQ(found, kInfinity);
    } else {
      EXPECT_NEAR(found, root, 1e-7);
    }
  }
  EXPECT_GT(with_root, 500);
  EXPECT_GT(without, 500);
}

TEST(PositivePolynomial, SeesADipThatSamplingWouldMiss) {
  // (x - 1/3)^2 + e
  for (double e : {1e-4, 1e-9, 1e-12}) {
    EXPECT_TRUE(positive_up_to(Polynomial<3>{1.0 / 9.0 + e, -2.0 / 3.0, 1.0}, 1.0)) << e;
    EXPECT_FALSE(positive_up_to(Polynomial<3>{1.0 / 9.0 - e, -2.0 / 3.0, 1.0}, 1.0)) << e;
  }
}

TEST(PositivePolynomial, NothingThatIsNotFiniteIsPositive) {
  const double nan = std::nan("");
  EXPECT_FALSE(positive_up_to(Polynomial<3>{1.0, nan, 0.0}, 1.0));
  EXPECT_FALSE(positive_up_to(Polynomial<3>{1.0, 0.0, 0.0}, nan));
  EXPECT_FALSE(positive_up_to(Polynomial<3>{1.0, 1.0, kInfinity}, 1.0));
  EXPECT_FALSE(positive_up_to(Polynomial<3>{1.0, -1e200, 1e200}, 1e200));
  EXPECT_EQ(first_sign_change(Polynomial<2>{-1.0, 1.0}, 10.0), 0.0);
}

TEST(PositivePolynomial, FindsBordersOfAnyMagnitude) {
  for (double root : {1e-9, 1e-3, 1.0, 250.0, 1e9}) {
    EXPECT_NEAR(first_sign_change(Polynomial<2>{root, -1.0}, 1e12) / root, 1.0, 1e-14);
  }
  EXPECT_EQ(first_sign_change(Polynomial<2>{1e13, -1.0}, 1e12), kInfinity);
}

TEST(PositivePolynomial, EvaluatesValueAndDerivative) {
  const Polynomial<4> c = {2.0, -1.0, 3.0, 0.5};
  EXPECT_DOUBLE_EQ(evaluate(c, 2.0), 2.0 - 2.0 + 12.0 + 4.0);
  EXPECT_DOUBLE_EQ(evaluate_derivative(c, 2.0), -1.0 + 12.0 + 6.0);
}

}  // namespace
}  // namespace tread::internal
