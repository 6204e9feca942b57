// The stereo stages allocate nothing after the first frame. In a program of its own, because it
// counts every allocation of the process.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "stereo_images.hpp"
#include "tread/stereo/stereo_matcher.hpp"

namespace {
std::atomic<long> allocations{0};

void* counted(std::size_t size, std::size_t alignment) {
  ++allocations;
  void* memory = std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
}  // namespace

void* operator new(std::size_t size) {
  return counted(size, alignof(std::max_align_t));
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  return counted(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}

namespace tread {
namespace {

// Frames of growing unrest: the later ones have more patches than the first.
testing::Pair frame(int index) {
  testing::Pair pair = testing::textured_pair(
      320, 240, 5, [](int x, int y) { return 8.0 + 6.0 * ((x / 40 + y / 30) % 3); });
  const Image<std::uint8_t> noise = testing::random_image(320, 240, static_cast<unsigned>(index));
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      if (noise(x, y) < 4 * index * index) pair.left(x, y) = noise(319 - x, y);
    }
  }
  return pair;
}

class StereoAllocations : public ::testing::TestWithParam<StereoMethod> {};

TEST_P(StereoAllocations, NoneAfterTheFirstFrame) {
  StereoOptions options;
  options.method = GetParam();
  options.sad.num_disparities = 48;
  options.holes.temporal = true;
  options.temporal.enabled = true;
  options.rate = true;
  StereoMatcher matcher;
  for (int i = 0; i < 5; ++i) {
    const testing::Pair pair = frame(i);
    const long before = allocations;
    const auto disparity = matcher.match(pair.left, pair.right, options);
    const long counted_here = allocations - before;
    ASSERT_TRUE(disparity);
    if (i == 0) {
      EXPECT_GT(counted_here, 0);  // the counter counts
      EXPECT_GT(disparity_density(*disparity), 0.5);
    } else if (i > 1) {  // the second frame is the first with a previous one
      EXPECT_EQ(counted_here, 0) << "frame " << i;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, StereoAllocations,
                         ::testing::Values(StereoMethod::kSad, StereoMethod::kSgm),
                         [](const auto& method) {
                           return method.param == StereoMethod::kSad ? "Sad" : "Sgm";
                         });

}  // namespace
}  // namespace tread
