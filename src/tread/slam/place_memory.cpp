#include "tread/slam/place_memory.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <opencv2/core/hal/hal.hpp>
#include <opencv2/features2d.hpp>
#include <tuple>
#include <utility>

namespace tread {
namespace {

constexpr int kColumns = 8, kRows = 6;
constexpr int kBorder = 20;  // px: descriptors look so far around
constexpr double kLeastCovarianceM = 0.005, kLeastCovarianceRad = 0.002;

int cell_of(const PlaceView& view, const PlaceView::Corner& corner) {
  const int x = static_cast<int>(corner.u) * kColumns / std::max(view.width, 1);
  const int y = static_cast<int>(corner.v) * kRows / std::max(view.height, 1);
  return std::clamp(y, 0, kRows - 1) * kColumns + std::clamp(x, 0, kColumns - 1);
}

// Strong ones first, but no more from one part of the image than three times its share.
void spread_out(std::vector<cv::KeyPoint>& points, int most, int width, int height) {
  std::sort(points.begin(), points.end(), [](const cv::KeyPoint& a, const cv::KeyPoint& b) {
    return std::tuple(-a.response, a.octave, a.pt.y, a.pt.x) <
           std::tuple(-b.response, b.octave, b.pt.y, b.pt.x);
  });
  const int share = std::max(4, 3 * most / (kColumns * kRows));
  std::array<int, kColumns * kRows> in_cell{};
  PlaceView size;
  size.width = width;
  size.height = height;
  int kept = 0;
  std::erase_if(points, [&](const cv::KeyPoint& point) {
    int& count = in_cell[static_cast<std::size_t>(cell_of(size, {point.pt.x, point.pt.y, 0.0F}))];
    if (kept >= most || count >= share) return true;
    ++count;
    ++kept;
    return false;
  });
}

// Of a pixel whose neighbours lie on the same surface; else not known well enough.
float depth_at(ImageView<const float> depth, float u, float v) {
  constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
  const int x = static_cast<int>(std::lround(u)), y = static_cast<int>(std::lround(v));
  if (x < 1 || y < 1 || x + 1 >= depth.width || y + 1 >= depth.height) return kUnknown;
  const float middle = depth(x, y);
  if (!(middle > 0.0F)) return kUnknown;
  float sum = 0.0F;
  for (int j = -1; j <= 1; ++j) {
    for (int i = -1; i <= 1; ++i) {
      const float z = depth(x + i, y + j);
      if (!(std::abs(z - middle) < 0.05F * middle)) return kUnknown;
      sum += z;
    }
  }
  return sum / 9.0F;
}

int bits_between(const PlaceView::Descriptor& a, const PlaceView::Descriptor& b) {
  return cv::hal::normHamming(reinterpret_cast<const uchar*>(a.data()),
                              reinterpret_cast<const uchar*>(b.data()), sizeof(a));
}

struct Nearest {
  int first = 1000, second = 1000;  // bits
  int at = -1;
  void see(int bits, int index) {
    if (bits < first) {
      second = first;
      first = bits;
      at = index;
    } else if (bits < second) {
      second = bits;
    }
  }
};

// Pairs (of place, of query) that are each other's best and clearly better than the second.
std::vector<std::pair<int, int>> match(const PlaceView& place, const PlaceView& query,
                                       const PlaceOptions& options) {
  std::vector<Nearest> of_place(place.corners.size()), of_query(query.corners.size());
  for (std::size_t i = 0; i < of_place.size(); ++i) {
    for (std::size_t j = 0; j < of_query.size(); ++j) {
      const int bits = bits_between(place.descriptors[i], query.descriptors[j]);
      of_place[i].see(bits, static_cast<int>(j));
      of_query[j].see(bits, static_cast<int>(i));
    }
  }
  const auto clear = [&](const Nearest& n) {
    return n.first <= options.most_bits && n.first < options.ratio * n.second;
  };
  std::vector<std::pair<int, int>> pairs;
  for (std::size_t i = 0; i < of_place.size(); ++i) {
    if (!clear(of_place[i])) continue;
    const Nearest& back = of_query[static_cast<std::size_t>(of_place[i].at)];
    if (back.at == static_cast<int>(i) && clear(back)) pairs.emplace_back(i, of_place[i].at);
  }
  return pairs;
}

// Groups of 18 bits; descriptors of one corner mostly have one in common, others hardly ever do.
constexpr int kGroup = 18, kGroups = 14;
std::size_t group_of(const PlaceView::Descriptor& d, int group) {
  const int first = kGroup * group, word = first / 64, shift = first % 64;
  std::uint64_t bits = d[static_cast<std::size_t>(word)] >> shift;
  if (shift + kGroup > 64) bits |= d[static_cast<std::size_t>(word) + 1] << (64 - shift);
  return static_cast<std::size_t>(bits & ((1U << kGroup) - 1)) +
         (static_cast<std::size_t>(group) << kGroup);
}

RectifiedRig one_eye(const PlaceView& view) {
  RectifiedRig rig;
  rig.size = {view.width, view.height};
  rig.fx_px = static_cast<double>(view.camera.fx);
  rig.fy_px = static_cast<double>(view.camera.fy);
  rig.cx_px = static_cast<double>(view.camera.cx);
  rig.cy_px = static_cast<double>(view.camera.cy);
  return rig;
}

// Points that `from` knows, as `to` sees them. `pairs` are (of `from`, of `to`).
struct Sights {
  std::vector<SeenPoint> points;
  std::vector<std::pair<int, int>> pairs;  // of these points
  double mean_depth_m = 0.0;
};
Sights sights_of(const PlaceView& from, const PlaceView& to,
                 const std::vector<std::pair<int, int>>& pairs) {
  Sights sights;
  const RectifiedRig rig = one_eye(from);
  for (const auto& pair : pairs) {
    const PlaceView::Corner& known = from.corners[static_cast<std::size_t>(pair.first)];
    const PlaceView::Corner& seen = to.corners[static_cast<std::size_t>(pair.second)];
    if (!(known.depth_m > 0.0F)) continue;
    SeenPoint point;
    const Eigen::Vector3d ray((static_cast<double>(known.u) - rig.cx_px) / rig.fx_px,
                              (static_cast<double>(known.v) - rig.cy_px) / rig.fy_px, 1.0);
    point.p_world = static_cast<double>(known.depth_m) * ray;
    point.sight.u = static_cast<double>(seen.u);
    point.sight.v = static_cast<double>(seen.v);
    sights.points.push_back(point);
    sights.pairs.push_back(pair);
    sights.mean_depth_m += static_cast<double>(known.depth_m);
  }
  if (!sights.points.empty()) sights.mean_depth_m /= static_cast<double>(sights.points.size());
  return sights;
}

// Whether enough of the matches agree, and not only in one corner of either image.
bool is_sound(const MotionFit& fit, const Sights& sights, const PlaceView& from,
              const PlaceView& to, const PlaceOptions& options) {
  if (!fit.found || fit.inliers < options.least_inliers ||
      fit.inliers < options.least_share * static_cast<double>(sights.points.size())) {
    return false;
  }
  std::array<bool, kColumns * kRows> in_from{}, in_to{};
  for (std::size_t i = 0; i < sights.pairs.size(); ++i) {
    if (fit.is_inlier[i] == 0) continue;
    const auto a = static_cast<std::size_t>(sights.pairs[i].first);
    const auto b = static_cast<std::size_t>(sights.pairs[i].second);
    in_from[static_cast<std::size_t>(cell_of(from, from.corners[a]))] = true;
    in_to[static_cast<std::size_t>(cell_of(to, to.corners[b]))] = true;
  }
  return std::count(in_from.begin(), in_from.end(), true) >= options.least_cells &&
         std::count(in_to.begin(), in_to.end(), true) >= options.least_cells;
}

// Sights do not tell a place from its picture, seen from where it was taken: depths do. Whether
// those of both views are of the same points.
bool depths_agree(const MotionFit& fit, const Sights& there, const PlaceView& query) {
  constexpr double kApart = 0.05, kLeastShare = 0.7;  // of the depth; of the points
  int known = 0, agree = 0;
  for (std::size_t i = 0; i < there.points.size(); ++i) {
    const auto j = static_cast<std::size_t>(there.pairs[i].second);
    const auto z = static_cast<double>(query.corners[j].depth_m);
    if (fit.is_inlier[i] == 0 || !(z > 0.0)) continue;
    const Eigen::Vector3d p = fit.T_world_camera.inverse() * there.points[i].p_world;
    ++known;
    agree += std::abs(p.z() - z) <= kApart * z ? 1 : 0;
  }
  return known > 0 && agree >= kLeastShare * known;
}

}  // namespace

OptionSet describe(PlaceOptions& options) {
  OptionSet set;
  set.add("corners", options.corners, "of a view, at most", 50, 5000);
  set.add("most_bits", options.most_bits, "that differ between descriptors of one corner", 1, 256);
  set.add("ratio", options.ratio, "of bits to the second best, above which it is no match", 0.1,
          1.0);
  set.add("least_inliers", options.least_inliers, "corners that agree in space, both ways", 6,
          5000);
  set.add("least_share", options.least_share, "of the matched corners that agree", 0.0, 1.0);
  set.add("least_cells", options.least_cells, "of 48 parts of the image that these are in", 1, 48);
  set.add("corner_px", options.corner_px, "how far off a corner may be, px", 0.1, 10.0);
  return set;
}

PlaceView view_place(ImageView<const std::uint8_t> grey, ImageView<const float> depth,
                     const Pinhole& camera, const PlaceOptions& options, const Context& context) {
  const ScopedTimer timer(context, "slam/view_place");
  PlaceView view;
  view.camera = camera;
  view.width = grey.width;
  view.height = grey.height;
  if (!same_size(grey, depth) || std::min(grey.width, grey.height) < 3 * kBorder) return view;
  // OpenCV has no view of constant pixels; it only reads these.
  const cv::Mat image(grey.height, grey.width, CV_8UC1, const_cast<std::uint8_t*>(grey.data),
                      static_cast<std::size_t>(grey.stride));
  constexpr float kScale = 1.2F;
  constexpr int kOctaves = 6, kFast = 8;
  const cv::Ptr<cv::ORB> orb = cv::ORB::create(3 * options.corners, kScale, kOctaves, kBorder, 0, 2,
                                               cv::ORB::HARRIS_SCORE, 31, kFast);
  std::vector<cv::KeyPoint> points;
  orb->detect(image, points);
  spread_out(points, options.corners, grey.width, grey.height);
  cv::Mat descriptors;
  orb->compute(image, points, descriptors);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const cv::Point2f at = points[i].pt;
    view.corners.push_back({at.x, at.y, depth_at(depth, at.x, at.y)});
    PlaceView::Descriptor& to = view.descriptors.emplace_back();
    std::memcpy(to.data(), descriptors.ptr(static_cast<int>(i)), sizeof(to));
  }
  return view;
}

bool PlaceMemory::add(std::int64_t id, PlaceView view) {
  if (view.corners.empty() || places_.size() >= kMost || places_.contains(id)) return false;
  view.corners.shrink_to_fit();
  view.descriptors.shrink_to_fit();
  places_[id] = std::move(view);
  return true;
}

std::size_t PlaceMemory::bytes() const {
  std::size_t sum = 0;
  for (const auto& [id, view] : places_) {
    sum += sizeof(PlaceView) + view.corners.capacity() * sizeof(PlaceView::Corner) +
           view.descriptors.capacity() * sizeof(PlaceView::Descriptor);
  }
  return sum;
}

std::vector<PlaceMemory::Candidate> PlaceMemory::find(
    const PlaceView& query, std::size_t most, const std::function<bool(std::int64_t)>& may_be,
    const Context& context) const {
  const ScopedTimer timer(context, "slam/find_place");
  constexpr int kLeastShared = 16;  // chance gives half of that
  std::vector<bool> known(static_cast<std::size_t>(kGroups) << kGroup);
  for (const PlaceView::Descriptor& d : query.descriptors) {
    for (int g = 0; g < kGroups; ++g) known[group_of(d, g)] = true;
  }
  std::vector<std::pair<int, std::int64_t>> order;
  for (const auto& [id, place] : places_) {
    if (!may_be(id)) continue;
    int shared = 0;
    for (const PlaceView::Descriptor& d : place.descriptors) {
      bool any = false;
      for (int g = 0; g < kGroups && !any; ++g) any = known[group_of(d, g)];
      shared += any ? 1 : 0;
    }
    if (shared >= kLeastShared) order.emplace_back(-shared, id);
  }
  std::sort(order.begin(), order.end());
  order.resize(std::min(order.size(), most + 1));
  std::vector<Candidate> found;
  for (const auto& [unlikeness, id] : order) {
    const int matched = static_cast<int>(match(places_.at(id), query, options_).size());
    if (matched >= options_.least_inliers) found.push_back({id, matched});
  }
  std::sort(found.begin(), found.end(), [](const Candidate& a, const Candidate& b) {
    return std::pair(-a.matched, a.id) < std::pair(-b.matched, b.id);
  });
  found.resize(std::min(found.size(), most));
  return found;
}

PlaceMatch PlaceMemory::verify(std::int64_t id, const PlaceView& query,
                               const Isometry3d& T_place_query, const Context& context) const {
  const ScopedTimer timer(context, "slam/verify_place");
  PlaceMatch found;
  found.id = id;
  const auto at = places_.find(id);
  if (at == places_.end()) return found;
  const PlaceView& place = at->second;
  std::vector<std::pair<int, int>> pairs = match(place, query, options_);
  found.matched = static_cast<int>(pairs.size());
  const Sights there = sights_of(place, query, pairs);
  for (auto& [of_place, of_query] : pairs) std::swap(of_place, of_query);
  const Sights back = sights_of(query, place, pairs);
  FitMotionOptions fitting;
  fitting.sigma_px = options_.corner_px;
  fitting.least_inliers = options_.least_inliers;
  constexpr std::uint64_t kSeed = 1;
  const MotionFit fit =
      fit_motion(one_eye(query), there.points, T_place_query, Matrix6d::Zero(), fitting, kSeed);
  found.inliers = fit.inliers;
  found.rms_px = fit.rms_px;
  if (!is_sound(fit, there, place, query, options_)) return found;
  const MotionFit fit_back = fit_motion(one_eye(place), back.points, fit.T_world_camera.inverse(),
                                        Matrix6d::Zero(), fitting, kSeed);
  if (!is_sound(fit_back, back, query, place, options_)) return found;
  // Each is fitted to the depths of one image alone, so they err apart.
  constexpr double kMostApart = 0.05;  // of the mean depth
  const Isometry3d apart = fit.T_world_camera * fit_back.T_world_camera;
  const double shift =
      apart.translation().norm() + so3_log(apart.linear()).norm() * there.mean_depth_m;
  if (!(shift <= kMostApart * there.mean_depth_m) || !depths_agree(fit, there, query)) return found;
  found.T_place_query = fit.T_world_camera;
  found.covariance = fit.covariance;
  found.covariance.diagonal().head<3>().array() += kLeastCovarianceM * kLeastCovarianceM;
  found.covariance.diagonal().tail<3>().array() += kLeastCovarianceRad * kLeastCovarianceRad;
  found.found = true;
  return found;
}

}  // namespace tread
