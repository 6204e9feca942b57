#include "tread/stereo/sad_matcher.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>
#include <vector>

#include "stereo_images.hpp"

namespace tread {
namespace {

using testing::Pair;
using testing::random_image;
using testing::textured_pair;

// The matcher as its definition says: every window summed anew, every check looked up in the full
// volume of costs. Slow, and no line shared with the matcher.
class Oracle {
 public:
  Oracle(const Image<std::uint8_t>& left, const Image<std::uint8_t>& right,
         const SadOptions& options)
      : left_(left), right_(right), o_(options) {}

  [[nodiscard]] Image<Disparity> match() const {
    Image<Disparity> out(left_.width, left_.height, kNoMatch);
    for (int y = 0; y < out.height; ++y) {
      for (int x = 0; x < out.width; ++x) out(x, y) = at(x, y);
    }
    return out;
  }

 private:
  [[nodiscard]] bool left_is_reference() const { return o_.reference == Reference::kLeft; }

  // Cost of matching reference pixel x at disparity d, or nothing where the match would lie
  // outside the other image.
  [[nodiscard]] std::optional<long> cost(int x, int y, int d) const {
    const int w = left_.width, h = left_.height;
    const int other = left_is_reference() ? x - d : x + d;
    if (other < 0 || other >= w) return std::nullopt;
    if (!o_.reduced_range_at_border) {
      const int last = o_.min_disparity_px + o_.num_disparities - 1;
      const int end = left_is_reference() ? x - last : x + last;
      if (end < 0 || end >= w) return std::nullopt;
    }
    const Image<std::uint8_t>& reference = left_is_reference() ? left_ : right_;
    const Image<std::uint8_t>& matched = left_is_reference() ? right_ : left_;
    long sum = 0;
    for (int j = -o_.window_height_px / 2; j <= o_.window_height_px / 2; ++j) {
      for (int i = -o_.window_width_px / 2; i <= o_.window_width_px / 2; ++i) {
        const int row = std::clamp(y + j, 0, h - 1);
        sum += std::abs(int{reference(std::clamp(x + i, 0, w - 1), row)} -
                        int{matched(std::clamp(other + i, 0, w - 1), row)});
      }
    }
    return sum;
  }

  [[nodiscard]] std::optional<int> winner(int x, int y) const {
    std::optional<int> best;
    long least = std::numeric_limits<long>::max();
    for (int d = o_.min_disparity_px; d < o_.min_disparity_px + o_.num_disparities; ++d) {
      const auto c = cost(x, y, d);
      if (c && *c < least) {
        least = *c;
        best = d;
      }
    }
    return best;
  }

  // The disparity of the cheapest of the pixels that chose the other image's pixel.
  [[nodiscard]] int owner_of(int other, int y) const {
    int best = -1000;
    long least = std::numeric_limits<long>::max();
    for (int d = o_.min_disparity_px; d < o_.min_disparity_px + o_.num_disparities; ++d) {
      const int x = left_is_reference() ? other + d : other - d;
      if (x < 0 || x >= left_.width || winner(x, y) != d) continue;
      const long c = *cost(x, y, d);
      if (c < least) {
        least = c;
        best = d;
      }
    }
    return best;
  }

  [[nodiscard]] Disparity at(int x, int y) const {
    const int rx = o_.window_width_px / 2, ry = o_.window_height_px / 2;
    if (o_.border == Border::kFullWindow &&
        (x < rx || y < ry || x + rx >= left_.width || y + ry >= left_.height)) {
      return kNoMatch;
    }
    const auto best = winner(x, y);
    if (!best) return kNoMatch;
    const int d0 = *best;
    const double c = static_cast<double>(*cost(x, y, d0));
    const double margin = std::floor(655.35 * o_.uniqueness_percent) / 65536.0;
    for (int d = o_.min_disparity_px; d < o_.min_disparity_px + o_.num_disparities; ++d) {
      const auto other = cost(x, y, d);
      if (o_.uniqueness_percent > 0 && std::abs(d - d0) > 1 && other &&
          static_cast<double>(*other) <= c + std::floor(c * margin)) {
        return kNoMatch;
      }
    }
    if (o_.min_texture > 0.0 && texture(x, y) < o_.min_texture) return kNoMatch;
    if (o_.left_right_tolerance_px >= 0) {
      const int back = owner_of(left_is_reference() ? x - d0 : x + d0, y);
      if (std::abs(back - d0) > o_.left_right_tolerance_px) return kNoMatch;
    }
    return refined(x, y, d0);
  }

  [[nodiscard]] double texture(int x, int y) const {
    const Image<std::uint8_t>& reference = left_is_reference() ? left_ : right_;
    double sum = 0.0;
    for (int j = -o_.window_height_px / 2; j <= o_.window_height_px / 2; ++j) {
      for (int i = -o_.window_width_px / 2; i <= o_.window_width_px / 2; ++i) {
        sum += std::abs(int{reference(std::clamp(x + i, 0, left_.width - 1),
                                      std::clamp(y + j, 0, left_.height - 1))} -
                        128);
      }
    }
    return sum / (o_.window_width_px * o_.window_height_px);
  }

  [[nodiscard]] Disparity refined(int x, int y, int d0) const {
    const int end = o_.min_disparity_px + o_.num_disparities - 1;
    const auto lower = d0 > o_.min_disparity_px ? cost(x, y, d0 - 1) : std::nullopt;
    const auto upper = d0 < end ? cost(x, y, d0 + 1) : std::nullopt;
    const auto whole = static_cast<Disparity>(d0 * kDisparityScale);
    if (!lower || !upper) return o_.strict_sub_pixel ? kNoMatch : whole;
    const double l = static_cast<double>(*lower), r = static_cast<double>(*upper);
    const double c = static_cast<double>(*cost(x, y, d0));
    if (o_.strict_sub_pixel && (l <= c || r <= c)) return kNoMatch;
    double delta = 0.0;
    if (o_.sub_pixel == SubPixel::kSymmetricV && std::max(l, r) > c) {
      delta = 0.5 * (l - r) / (std::max(l, r) - c);
    }
    if (o_.sub_pixel == SubPixel::kParabola && l - 2 * c + r > 0) {
      delta = 0.5 * (l - r) / (l - 2 * c + r);
    }
    const double steps = std::nearbyint(delta * o_.sub_pixel_steps);  // half to even
    return static_cast<Disparity>(whole +
                                  static_cast<int>(steps) * kDisparityScale / o_.sub_pixel_steps);
  }

  const Image<std::uint8_t>& left_;
  const Image<std::uint8_t>& right_;
  const SadOptions& o_;
};

SadOptions unchecked() {
  SadOptions options;
  options.uniqueness_percent = 0;
  options.left_right_tolerance_px = -1;
  options.strict_sub_pixel = false;
  return options;
}

Image<Disparity> match(const Image<std::uint8_t>& left, const Image<std::uint8_t>& right,
                       const SadOptions& options, int threads = 1) {
  SadMatcher matcher;
  Image<Disparity> disparity;
  Context context;
  context.threads = threads;
  matcher.match(left, right, options, 255, disparity, nullptr, context);
  return disparity;
}

TEST(SadMatcher, EqualsTheDefinitionForEveryOption) {
  // Half noise, half a shifted copy, so that checks pass and fail.
  const Pair shifted = textured_pair(71, 37, 3, [](int x, int) { return 5.0 + 0.05 * x; });
  Image<std::uint8_t> left = shifted.left, right = shifted.right;
  const Image<std::uint8_t> noise = random_image(71, 37, 9);
  for (int y = 20; y < 37; ++y) std::copy(noise.row(y), noise.row(y) + 40, left.row(y));

  std::vector<SadOptions> cases;
  for (Reference reference : {Reference::kLeft, Reference::kRight}) {
    for (int width : {1, 5, 13}) {
      for (int height : {3, 17}) {
        SadOptions options = unchecked();
        options.reference = reference;
        options.window_width_px = width;
        options.window_height_px = height;
        options.num_disparities = 17;
        cases.push_back(options);
        options.border = Border::kFullWindow;
        cases.push_back(options);
        options.border = Border::kReplicate;
        options.min_disparity_px = 3;
        options.num_disparities = 9;
        options.uniqueness_percent = 15;
        options.left_right_tolerance_px = 1;
        options.sub_pixel = SubPixel::kParabola;
        cases.push_back(options);
        options.strict_sub_pixel = true;
        options.reduced_range_at_border = false;
        options.border = Border::kFullWindow;
        options.min_texture = 30.0;
        options.sub_pixel_steps = 4;
        options.sub_pixel = SubPixel::kSymmetricV;
        cases.push_back(options);
        options.left_right_tolerance_px = 0;
        options.border = Border::kReplicate;
        options.min_texture = 0.0;
        cases.push_back(options);
      }
    }
  }
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const Image<Disparity> expected = Oracle(left, right, cases[i]).match();
    EXPECT_TRUE(match(left, right, cases[i]) == expected) << "case " << i;
    EXPECT_GT(disparity_density(expected), 0.02) << "case " << i << " tests nothing";
  }
}

TEST(SadMatcher, LargeWindowsDoNotOverflow) {
  // A pair of which half the pixels are black in one and white in the other image, for all
  // disparities but 5: sums to some 120 000 at a window of 31, more than 16 bits hold.
  const Image<std::uint8_t> noise = random_image(60, 40, 2);
  Image<std::uint8_t> left(40, 40), right(40, 40);
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 40; ++x) {
      left(x, y) = noise(x, y) < 128 ? 0 : 255;
      right(x, y) = noise(x + 5, y) < 128 ? 0 : 255;
    }
  }
  SadOptions options = unchecked();
  options.num_disparities = 8;
  for (int side : {15, 17, 31}) {
    options.window_width_px = options.window_height_px = side;
    const Image<Disparity> disparity = match(left, right, options);
    EXPECT_TRUE(disparity == Oracle(left, right, options).match()) << side;
    EXPECT_NEAR(disparity_px(disparity(20, 20)), 5.0, 0.05);
  }
}

TEST(SadMatcher, FindsAConstantShiftEverywhereItCanBeSeen) {
  const Pair pair = textured_pair(160, 60, 5, [](int, int) { return 12.0; });
  for (Reference reference : {Reference::kLeft, Reference::kRight}) {
    SadOptions options;
    options.reference = reference;
    options.num_disparities = 32;
    const Image<Disparity> disparity = match(pair.left, pair.right, options);
    int wrong = 0, known = 0;
    for (int y = 0; y < 60; ++y) {
      for (int x = 20; x < 140; ++x) {
        if (disparity(x, y) == kNoMatch) continue;
        ++known;
        wrong += std::abs(disparity_px(disparity(x, y)) - 12.0F) > 0.25F ? 1 : 0;
      }
    }
    EXPECT_EQ(wrong, 0);
    EXPECT_GT(known, 60 * 120 * 95 / 100);
  }
}

TEST(SadMatcher, QuarterPixelModeGivesQuarterPixels) {
  const Pair pair = textured_pair(200, 50, 8, [](int x, int) { return 10.0 + 0.04 * x; });
  SadOptions options = unchecked();
  options.num_disparities = 32;
  options.sub_pixel_steps = 4;
  const Image<Disparity> disparity = match(pair.left, pair.right, options);
  for (int y = 0; y < 50; ++y) {
    for (int x = 0; x < 200; ++x) EXPECT_EQ(disparity(x, y) % (kDisparityScale / 4), 0);
  }
}

// Sub-pixel locking: on a slanted plane the fractions should be spread evenly.
TEST(SadMatcher, SymmetricVIsLessBiasedThanNoneAndWithinATenthOfAPixel) {
  const auto truth = [](int x, int y) { return 10.0 + 0.03 * x + 0.01 * y; };
  const Pair pair = textured_pair(300, 80, 21, truth);
  const auto rms = [&](SubPixel sub_pixel) {
    SadOptions options = unchecked();
    options.num_disparities = 32;
    options.sub_pixel = sub_pixel;
    const Image<Disparity> disparity = match(pair.left, pair.right, options);
    double sum = 0.0;
    int count = 0;
    for (int y = 5; y < 75; ++y) {
      for (int x = 40; x < 290; ++x) {
        const double error = disparity_px(disparity(x, y)) - truth(x, y);
        sum += error * error;
        ++count;
      }
    }
    return std::sqrt(sum / count);
  };
  const double none = rms(SubPixel::kNone);
  EXPECT_NEAR(none, 1.0 / std::sqrt(12.0), 0.03);  // rounding to whole pixels
  EXPECT_LT(rms(SubPixel::kSymmetricV), 0.1);
  EXPECT_LT(rms(SubPixel::kParabola), 0.15);
}

TEST(SadMatcher, MatchesLeftOfTheRangeWhereTheReducedRangeFits) {
  const Pair pair = textured_pair(120, 40, 4, [](int, int) { return 6.0; });
  SadOptions options;
  options.num_disparities = 64;
  const auto known_in_band = [&] {
    const Image<Disparity> disparity = match(pair.left, pair.right, options);
    int known = 0;
    for (int y = 0; y < 40; ++y) {
      for (int x = 16; x < 63; ++x) known += disparity(x, y) != kNoMatch ? 1 : 0;
    }
    return known;
  };
  options.reduced_range_at_border = true;
  EXPECT_GT(known_in_band(), 40 * 47 * 9 / 10);
  options.reduced_range_at_border = false;
  EXPECT_EQ(known_in_band(), 0);
}

TEST(SadMatcher, SameForAnyThreadCount) {
  const Image<std::uint8_t> left = random_image(97, 301, 1), right = random_image(97, 301, 2);
  SadOptions options = unchecked();
  options.num_disparities = 33;
  EXPECT_TRUE(match(left, right, options, 1) == match(left, right, options, 2));
}

TEST(SadMatcher, OnePixelAndOneDisparity) {
  SadOptions options = unchecked();
  options.num_disparities = 1;
  const Image<std::uint8_t> one(1, 1, 9);
  EXPECT_EQ(match(one, one, options)(0, 0), 0);
  options.strict_sub_pixel = true;
  EXPECT_EQ(match(one, one, options)(0, 0), kNoMatch);
}

}  // namespace
}  // namespace tread
