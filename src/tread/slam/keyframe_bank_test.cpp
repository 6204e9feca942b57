#include "tread/slam/keyframe_bank.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace tread {
namespace {

// A picture of 20 x 15 pixels at the coarsest level, and the depth that goes with it.
struct View {
  AlignFrame frame;
  DepthLevel depth;

  View() {
    const Pinhole camera{18.0F, 18.0F, 9.5F, 7.0F};
    frame.grey[0].intensity = Image<float>(80, 60, 100.0F);
    Image<float> picture(20, 15);
    for (int y = 0; y < picture.height; ++y) {
      for (int x = 0; x < picture.width; ++x) {
        picture(x, y) = static_cast<float>(100.0 + 50.0 * std::sin(0.7 * x) * std::cos(0.5 * y));
      }
    }
    frame.grey[2] = with_slopes(picture);
    frame.depth[2].resize(camera, picture.width, picture.height);
    depth.resize(camera, picture.width, picture.height);
    depth.depth = Image<float>(picture.width, picture.height, 2.0F);
  }
};

Isometry3d at_metre(int x) {
  Isometry3d T = Isometry3d::Identity();
  T.translation().x() = x;
  return T;
}

// The places that are known, in the order in which they were added: they look alike.
std::vector<int> places_in(const KeyframeBank& bank, const View& view) {
  std::vector<int> places;
  for (const auto& candidate : bank.find(view.frame, 10 * KeyframeBank::kMost)) {
    places.push_back(static_cast<int>(std::lround(candidate.T_world_camera.translation().x())));
  }
  return places;
}

TEST(KeyframeBank, KeepsOneViewOfAPlace) {
  const View view;
  KeyframeBank bank;
  bank.add(view.frame, view.depth, at_metre(0));
  Isometry3d near = at_metre(0);
  near.translation().y() = 0.2;
  bank.add(view.frame, view.depth, near);
  EXPECT_EQ(bank.size(), 1U);
  near.linear() = so3_exp({0.0, 0.5, 0.0});
  bank.add(view.frame, view.depth, near);
  EXPECT_EQ(bank.size(), 2U) << "from there it looks elsewhere";
  bank.add(AlignFrame{}, view.depth, at_metre(5));
  EXPECT_EQ(bank.size(), 2U) << "without an image";
  EXPECT_TRUE(bank.find(AlignFrame{}, 3).empty());
  EXPECT_EQ(bank.find(view.frame, 1).size(), 1U);
}

TEST(KeyframeBank, ViewsGoAlongWithWhatTheyHangOn) {
  const View view;
  KeyframeBank bank;
  bank.add(view.frame, view.depth, at_metre(0), 4);
  bank.add(view.frame, view.depth, at_metre(1), 7);
  bank.move([](std::int64_t anchor) { return at_metre(anchor == 7 ? 10 : 0); });
  EXPECT_EQ(places_in(bank, view), (std::vector<int>{0, 11}));
  EXPECT_EQ(bank.find(view.frame, 2)[0].anchor, 4);
  EXPECT_EQ(bank.find(view.frame, 2)[1].anchor, 7);
}

TEST(KeyframeBank, OlderViewsAreThinnedOutWhenThereAreTooMany) {
  constexpr int kMost = static_cast<int>(KeyframeBank::kMost);
  const View view;
  KeyframeBank bank;
  std::vector<int> expected;
  const auto add = [&](int x) {
    bank.add(view.frame, view.depth, at_metre(x));
    expected.push_back(x);
  };
  for (int i = 0; i < kMost; ++i) add(i);
  EXPECT_EQ(places_in(bank, view), expected) << "all are kept so far";
  const auto thin_out = [&] {
    std::vector<int> kept;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      if (i >= expected.size() / 2 || i % 2 == 0) kept.push_back(expected[i]);
    }
    expected = kept;
  };
  thin_out();
  add(kMost);
  EXPECT_EQ(bank.size(), static_cast<std::size_t>(kMost - kMost / 4 + 1));
  EXPECT_EQ(places_in(bank, view), expected);
  EXPECT_EQ(expected[1], 2);
  EXPECT_EQ(expected[static_cast<std::size_t>(kMost) / 4 - 1], kMost / 2 - 2);
  EXPECT_EQ(expected[static_cast<std::size_t>(kMost) / 4], kMost / 2);
  // Once more, and the first place is still known, and the last ones all are.
  for (int i = kMost + 1; bank.size() < KeyframeBank::kMost; ++i) add(i);
  thin_out();
  add(3 * kMost);
  const std::vector<int> places = places_in(bank, view);
  EXPECT_EQ(places, expected);
  EXPECT_EQ(places.front(), 0);
  EXPECT_EQ(places[1], 4);
  EXPECT_EQ(places.back(), 3 * kMost);
  // A place that was dropped is taken again when the camera comes back.
  const std::size_t before = bank.size();
  bank.add(view.frame, view.depth, at_metre(1));
  EXPECT_EQ(bank.size(), before + 1);
}

}  // namespace
}  // namespace tread
