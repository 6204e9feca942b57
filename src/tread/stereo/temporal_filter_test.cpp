#include "tread/stereo/temporal_filter.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <random>
#include <vector>

#include "instruction_sets.hpp"

namespace tread {
namespace {

constexpr Disparity X = kNoMatch;

Image<Disparity> row(const std::vector<Disparity>& values) {
  Image<Disparity> image(static_cast<int>(values.size()), 1);
  std::copy(values.begin(), values.end(), image.row(0));
  return image;
}

// The definition, pixel by pixel.
Disparity steady(Disparity now, Disparity seen, Disparity old, const TemporalOptions& o) {
  const int most = static_cast<int>(o.max_change_px * kDisparityScale + 0.5);
  if (now == X) return X;
  if (o.confirm && (seen == X || std::abs(now - seen) > most)) return X;
  if (old == X || std::abs(now - old) > most) return now;
  const int step = (old - now) * o.memory + 8;
  return static_cast<Disparity>(now + (step >= 0 ? step / 16 : -((15 - step) / 16)));
}

TEST(TemporalFilter, EqualsItsDefinitionOnEveryInstructionSet) {
  testing::on_every_target([] {
    for (const int width : {1, 7, 8, 31, 64, 65, 200}) {
      for (const bool confirm : {false, true}) {
        for (const int memory : {0, 5, 8, 15}) {
          for (const double change : {0.0, 0.5, 8.0}) {
            const TemporalOptions options{true, change, confirm, memory};
            std::mt19937 random(static_cast<unsigned>(width + memory));
            TemporalFilter filter;
            std::vector<Disparity> seen, old;
            for (int frame = 0; frame < 5; ++frame) {
              std::vector<Disparity> now(static_cast<std::size_t>(width));
              for (Disparity& d : now) {
                d = random() % 5 == 0 ? X : static_cast<Disparity>(65000 + random() % 400);
              }
              Image<Disparity> image = row(now);
              filter.apply(image, options);
              for (int x = 0; x < width; ++x) {
                const auto i = static_cast<std::size_t>(x);
                const Disparity expected =
                    frame == 0 ? now[i] : steady(now[i], seen[i], old[i], options);
                ASSERT_EQ(image(x, 0), expected) << x << " " << frame;
              }
              seen = now;
              old.assign(image.row(0), image.row(0) + width);
            }
          }
        }
      }
    }
  });
}

TEST(TemporalFilter, JumpsWaitAFrameAndNoiseIsSmoothed) {
  TemporalFilter filter;
  const TemporalOptions options{true, 1.0, true, 8};
  Image<Disparity> frame = row({640, 640});
  filter.apply(frame, options);
  frame = row({640, 1920});  // the second pixel jumps
  filter.apply(frame, options);
  EXPECT_EQ(frame(0, 0), 640);
  EXPECT_EQ(frame(1, 0), X);
  frame = row({660, 1920});
  filter.apply(frame, options);
  EXPECT_EQ(frame(0, 0), 650);
  EXPECT_EQ(frame(1, 0), 1920);
}

TEST(TemporalFilter, OffOrAnewAfterAChangeOfSizeOrAReset) {
  TemporalFilter filter;
  Image<Disparity> frame = row({640});
  filter.apply(frame, {});
  frame = row({1920});
  filter.apply(frame, {});
  EXPECT_EQ(frame(0, 0), 1920);
  const TemporalOptions options{true, 1.0, true, 8};
  filter.apply(frame, options);
  frame = row({640, 640});
  filter.apply(frame, options);
  EXPECT_EQ(frame(1, 0), 640);
  filter.reset();
  frame = row({64, 64});
  filter.apply(frame, options);
  EXPECT_EQ(frame(1, 0), 64);
}

}  // namespace
}  // namespace tread
