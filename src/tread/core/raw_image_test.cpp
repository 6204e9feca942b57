#include "tread/core/raw_image.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <random>
#include <vector>

#include "instruction_sets.hpp"

namespace tread {
namespace {

using testing::on_every_target;

constexpr std::array<int, 9> kWidths = {1, 2, 3, 7, 16, 31, 64, 65, 133};

TEST(ToGrey, DeepPixelsKeepTheirHighestBits) {
  on_every_target([] {
    for (const int width : kWidths) {
      for (const int bits : {8, 10, 12, 16}) {
        std::mt19937 random(static_cast<unsigned>(width + bits));
        std::vector<std::uint16_t> pixels(static_cast<std::size_t>(3 * width));
        for (auto& p : pixels) p = static_cast<std::uint16_t>(random() % (1U << bits));
        pixels[0] = 0xFFFF;  // beyond 2^bits - 1 too
        Image<std::uint8_t> grey;
        ASSERT_TRUE(
            to_grey({pixels.data(), width, 3, 2 * width, PixelFormat::kGrey16, bits}, grey));
        for (int y = 0; y < 3; ++y) {
          for (int x = 0; x < width; ++x) {
            const int value = pixels[static_cast<std::size_t>(y * width + x)];
            ASSERT_EQ(grey(x, y), std::min(value >> (bits - 8), 255)) << x;
          }
        }
      }
    }
  });
}

TEST(ToGrey, ColoursBecomeTheirLuma) {
  on_every_target([] {
    for (const int width : kWidths) {
      std::mt19937 random(static_cast<unsigned>(width));
      const int row_bytes = 3 * width + 5;
      std::vector<std::uint8_t> pixels(static_cast<std::size_t>(row_bytes + 3 * width));
      for (auto& p : pixels) p = static_cast<std::uint8_t>(random());
      std::fill(pixels.begin(), pixels.begin() + 3, std::uint8_t{255});
      for (const auto format : {PixelFormat::kRgb8, PixelFormat::kBgr8}) {
        Image<std::uint8_t> grey;
        ASSERT_TRUE(to_grey({pixels.data(), width, 2, row_bytes, format}, grey));
        EXPECT_EQ(grey(0, 0), 255);
        for (int y = 0; y < 2; ++y) {
          for (int x = 0; x < width; ++x) {
            const std::uint8_t* p = &pixels[static_cast<std::size_t>(y * row_bytes + 3 * x)];
            const bool rgb = format == PixelFormat::kRgb8;
            const double luma = 0.299 * p[rgb ? 0 : 2] + 0.587 * p[1] + 0.114 * p[rgb ? 2 : 0];
            ASSERT_NEAR(grey(x, y), luma, 0.503);
          }
        }
      }
    }
  });
}

// A scene of one colour gives one grey, whichever phase the mosaic has: (R + 2 G + B) / 4.
TEST(ToGrey, AMosaicOfOneColourIsOneGreyInEveryPhase) {
  on_every_target([] {
    constexpr std::array<int, 4> kColours = {200, 80, 80, 40};  // R G / G B
    for (const int width : kWidths) {
      for (int phase = 0; phase < 4; ++phase) {
        const int height = 5;
        std::vector<std::uint16_t> deep;
        std::vector<std::uint8_t> flat;
        for (int y = 0; y < height; ++y) {
          for (int x = 0; x < width; ++x) {
            const int place = 2 * ((y + phase / 2) % 2) + (x + phase) % 2;
            const int colour = kColours[static_cast<std::size_t>(place)];
            flat.push_back(static_cast<std::uint8_t>(colour));
            deep.push_back(static_cast<std::uint16_t>(colour * 16 + 7));
          }
        }
        if (width == 1) continue;  // one column has two colours only
        Image<std::uint8_t> grey, from_deep;
        ASSERT_TRUE(to_grey({flat.data(), width, height, width, PixelFormat::kBayer8}, grey));
        ASSERT_TRUE(
            to_grey({deep.data(), width, height, 2 * width, PixelFormat::kBayer16, 12}, from_deep));
        for (int y = 0; y < height; ++y) {
          for (int x = 0; x < width; ++x) ASSERT_EQ(grey(x, y), 100) << x << " " << y;
        }
        EXPECT_TRUE(grey == from_deep);
      }
    }
  });
}

TEST(ToGrey, AMosaicIsSmoothedByItsDefinition) {
  on_every_target([] {
    for (const int width : kWidths) {
      constexpr int kHeight = 70;  // more than one chunk of rows
      std::mt19937 random(static_cast<unsigned>(width));
      std::vector<std::uint8_t> pixels(static_cast<std::size_t>(width * kHeight));
      for (auto& p : pixels) p = static_cast<std::uint8_t>(random());
      Image<std::uint8_t> grey;
      Context context;
      context.threads = 2;
      ASSERT_TRUE(
          to_grey({pixels.data(), width, kHeight, width, PixelFormat::kBayer8}, grey, context));
      const auto mirrored = [](int i, int size) {
        return size == 1 ? 0 : i < 0 ? -i : i >= size ? 2 * size - 2 - i : i;
      };
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < width; ++x) {
          int sum = 8;
          for (int v = -1; v <= 1; ++v) {
            for (int u = -1; u <= 1; ++u) {
              const int at = mirrored(y + v, kHeight) * width + mirrored(x + u, width);
              sum += (2 - std::abs(u)) * (2 - std::abs(v)) * pixels[static_cast<std::size_t>(at)];
            }
          }
          ASSERT_EQ(grey(x, y), sum / 16) << x << " " << y;
        }
      }
    }
  });
}

TEST(ToGrey, WrongImagesAreRefused) {
  alignas(2) std::array<std::uint8_t, 64> bytes{};
  Image<std::uint8_t> grey(3, 3, 9);
  const auto refused = [&](const RawImage& raw) { return !to_grey(raw, grey).has_value(); };
  EXPECT_FALSE(refused({bytes.data(), 4, 4, 8, PixelFormat::kGrey16, 12}));
  EXPECT_TRUE(refused({nullptr, 4, 4, 4, PixelFormat::kGrey8}));
  EXPECT_TRUE(refused({bytes.data(), 0, 4, 4, PixelFormat::kGrey8}));
  EXPECT_TRUE(refused({bytes.data(), 4, -1, 4, PixelFormat::kGrey8}));
  EXPECT_TRUE(refused({bytes.data(), 4, 4, 3, PixelFormat::kGrey8}));
  EXPECT_TRUE(refused({bytes.data(), 4, 4, 11, PixelFormat::kRgb8}));
  EXPECT_TRUE(refused({bytes.data(), 4, 4, 7, PixelFormat::kGrey16}));
  EXPECT_TRUE(refused({bytes.data(), 4, 4, 9, PixelFormat::kGrey16}));
  EXPECT_TRUE(refused({bytes.data() + 1, 4, 4, 8, PixelFormat::kBayer16}));
  EXPECT_TRUE(refused({bytes.data(), 4, 4, 8, PixelFormat::kGrey16, 7}));
  EXPECT_TRUE(refused({bytes.data(), 4, 4, 8, PixelFormat::kGrey16, 17}));
}

}  // namespace
}  // namespace tread
