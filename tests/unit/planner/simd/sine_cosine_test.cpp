// Against the C library's extended precision; and the two compilations against each other, bit by bit.

#include "planner/simd/sine_cosine.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "planner/simd/instruction_set.hpp"

namespace hecaton::planner {
namespace {

constexpr int kCount = 6;
using Padded = std::array<double, 8>;

TEST(SineCosine, MatchTheLibraryWithinTwoUlp) {
  std::mt19937_64 random(1);
  for (const double range : {1e-3, 1.0, 7.0, 1e3, 1e6}) {
    std::uniform_real_distribution<double> any(-range, range);
    double worst = 0.0;
    for (int round = 0; round < 20'000; ++round) {
      Padded angle{};
      for (int i = 0; i < kCount; ++i) angle[i] = any(random);
      Padded sine;
      Padded cosine;
      sine_cosine(angle.data(), kCount, sine.data(), cosine.data());
      for (int i = 0; i < kCount; ++i) {
        const auto exact = static_cast<long double>(angle[i]);
        worst = std::max(worst, static_cast<double>(std::fabs(sine[i] - std::sin(exact))));
        worst = std::max(worst, static_cast<double>(std::fabs(cosine[i] - std::cos(exact))));
      }
    }
    EXPECT_LT(worst, 2.0 * 0x1p-52) << "angles up to " << range;
  }
}

TEST(SineCosine, AreExactAtTheQuarters) {
  const Padded angle = {0.0, 0.5 * std::numbers::pi, std::numbers::pi, -0.5 * std::numbers::pi};
  Padded sine;
  Padded cosine;
  sine_cosine(angle.data(), 4, sine.data(), cosine.data());
  EXPECT_EQ(sine[0], 0.0);
  EXPECT_EQ(cosine[0], 1.0);
  EXPECT_EQ(sine[1], 1.0);
  EXPECT_EQ(cosine[2], -1.0);
  EXPECT_EQ(sine[3], -1.0);
  EXPECT_NEAR(cosine[1], 0.0, 1e-16);  // the double nearest to π/2 misses it by 6·10⁻¹⁷
}

TEST(SineCosine, AreBitIdenticalOnEveryInstructionSet) {
  if (!has_avx2()) GTEST_SKIP() << "this processor has no AVX2 to compare with";
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> any(-100.0, 100.0);
  for (int round = 0; round < 100'000; ++round) {
    Padded angle{};
    for (double& value : angle) value = any(random);
    std::array<Padded, 4> result;
    baseline::sine_cosine(angle.data(), 8, result[0].data(), result[1].data());
    avx2::sine_cosine(angle.data(), 8, result[2].data(), result[3].data());
    using Bits = std::array<std::uint64_t, std::tuple_size_v<Padded>>;
    ASSERT_EQ(std::bit_cast<Bits>(result[0]), std::bit_cast<Bits>(result[2]));
    ASSERT_EQ(std::bit_cast<Bits>(result[1]), std::bit_cast<Bits>(result[3]));
  }
}

}  // namespace
}  // namespace hecaton::planner
