// The walker's way from a camera's buffers to a point cloud, on one core: unpack, rectify, match,
// filter, depth, cloud; stage by stage. The images are a real pair (Middlebury Motorcycle, cut to
// 640x480) as cameras with lens distortion and a 12-bit sensor would have delivered it, so that
// unpacking and rectifying give it back.
// Usage: walker_chain [--json]
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "stereo_pairs.hpp"
#include "times.hpp"
#include "tread/core/raw_image.hpp"
#include "tread/geometry/rectification.hpp"
#include "tread/stereo/depth.hpp"
#include "tread/stereo/stereo_matcher.hpp"

namespace {

using namespace tread;

constexpr int kWidth = 640, kHeight = 480;
constexpr int kBits = 12;

StereoRig distorted_rig() {
  StereoRig rig = bumblebee2(kWidth);
  for (CameraModel* camera : {&rig.left, &rig.right}) {
    BrownCamera lens;
    lens.pinhole = pinhole_of(*camera);
    lens.K = {-0.25, 0.05, 0.0, 0.0, 0.0};
    *camera = lens;
  }
  rig.rectified = false;
  return rig;
}

// What a camera behind this lens sees of a rectified image: 12 bits in 16.
Image<std::uint16_t> as_delivered(const Image<std::uint8_t>& rectified, const CameraModel& camera,
                                  const RectifiedRig& rig) {
  Image<std::uint16_t> raw(kWidth, kHeight);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const Eigen::Vector3d ray = unproject(camera, Eigen::Vector2d(u, v)).bearing;
      const double x = rig.fx_px * ray.x() / ray.z() + rig.cx_px;
      const double y = rig.fy_px * ray.y() / ray.z() + rig.cy_px;
      const double x0 = std::clamp(x, 0.0, kWidth - 1.001),
                   y0 = std::clamp(y, 0.0, kHeight - 1.001);
      const int i = static_cast<int>(x0), j = static_cast<int>(y0);
      const double a = x0 - i, b = y0 - j;
      const double grey = (1 - b) * ((1 - a) * rectified(i, j) + a * rectified(i + 1, j)) +
                          b * ((1 - a) * rectified(i, j + 1) + a * rectified(i + 1, j + 1));
      raw(u, v) = static_cast<std::uint16_t>(std::lround(16.0 * grey));
    }
  }
  return raw;
}

}  // namespace

int main(int argc, char** argv) {
  const bool json = argc > 1 && std::string(argv[1]) == "--json";
  const auto pairs = bench::load_stereo_pairs(bench::data_folder());
  if (!pairs) {
    fmt::print(stderr, "walker_chain: {}\n", pairs.error().message());
    return 1;
  }
  const auto pair = std::find_if(pairs->begin(), pairs->end(),
                                 [](const auto& p) { return p.set == "Motorcycle"; });
  if (pair == pairs->end()) {
    fmt::print(stderr, "walker_chain: there is no pair Motorcycle in the data\n");
    return 1;
  }
  const StereoRig rig = distorted_rig();
  const Rectification rectification = make_rectification(rig).value();
  const auto raw_of = [&](const Image<std::uint8_t>& image, const CameraModel& camera) {
    Image<std::uint8_t> cut(kWidth, kHeight);
    for (int y = 0; y < kHeight; ++y) std::copy_n(image.row(y), kWidth, cut.row(y));
    return as_delivered(cut, camera, rectification.rig);
  };
  const Image<std::uint16_t> raw_left = raw_of(pair->left, rig.left);
  const Image<std::uint16_t> raw_right = raw_of(pair->right, rig.right);

  StereoMatcher matcher;
  const StereoOptions options;
  Image<std::uint8_t> grey_left, grey_right, left(kWidth, kHeight), right(kWidth, kHeight);
  Image<float> depth;
  PointCloud cloud;
  std::map<std::string, std::vector<double>> stages;
  std::vector<double> totals;
  double density = 0.0;
  constexpr int kFrames = 300;
  for (int frame = 0; frame < kFrames; ++frame) {
    Timings timings;
    const Context context{1, &timings};
    const double start_ms = bench::cpu_ms();
    for (const auto& [raw, grey] : {std::pair{&raw_left, &grey_left}, {&raw_right, &grey_right}}) {
      const RawImage delivered{raw->row(0),          kWidth, kHeight, 2 * raw->stride,
                               PixelFormat::kGrey16, kBits};
      if (!to_grey(delivered, *grey, context)) return 1;
    }
    remap(grey_left, rectification.left, left, context);
    remap(grey_right, rectification.right, right, context);
    const auto disparity = matcher.match(left, right, options, context);
    if (!disparity) return 1;
    depth_image(*disparity, rectification.rig, {0.0, 100.0}, depth, context);
    depth_cloud(depth, rectification.rig, Reference::kLeft, {}, cloud, context);
    totals.push_back(bench::cpu_ms() - start_ms);
    density = disparity_density(*disparity);
    for (const auto& [name, entry] : timings.entries()) stages[name].push_back(entry.total_ms);
  }
  nlohmann::ordered_json result{{"benchmark", "walker_chain"}};
  if (!json)
    fmt::print("640x480x64, {:.1f} % matched, {} points\n", 100 * density, cloud.points.size());
  for (const auto& [name, values] : stages) {
    result["stages_ms"][name] = bench::median(values);
    if (!json) fmt::print("{:22} {:8.3f} ms\n", name, bench::median(values));
  }
  result["total_ms"] = bench::median(totals);
  result["density"] = density;
  result["points"] = cloud.points.size();
  if (json) {
    fmt::print("{}\n", result.dump(2));
  } else {
    fmt::print("{:22} {:8.3f} ms\n", "total", bench::median(totals));
  }
  return 0;
}
