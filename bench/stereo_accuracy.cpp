// How many pixels get a disparity, and how many of those are wrong: ours beside OpenCV's block and
// semi-global matchers, in one harness, on Middlebury and KITTI pairs with ground truth.
//   density  share of the pixels of known truth that are estimated
//   bad-1/2  share of those estimated that are off by more than 1 or 2 px
//   error    mean absolute error of those estimated, px
//   missed-2 share of all pixels of known truth that are not estimated or off by more than 2 px
// Usage: stereo_accuracy [--json] [--ours] [name=value ...]
//   --ours  without the rivals; options of ours, as `tread depth --set`
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/calib3d.hpp>
#include <string>
#include <vector>

#include "arguments.hpp"
#include "stereo_pairs.hpp"
#include "stereo_score.hpp"
#include "tread/stereo/stereo_matcher.hpp"

namespace {

using namespace tread;
using bench::mean_of;
using bench::Score;
using bench::StereoPair;

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

using Method = std::function<Image<float>(const StereoPair&)>;

Image<float> match_ours(const StereoPair& pair, StereoOptions options, StereoMethod method) {
  options.method = method;
  options.sad.num_disparities = pair.num_disparities;
  StereoMatcher matcher;
  const auto disparity = matcher.match(pair.left, pair.right, options);
  if (!disparity) {
    fmt::print(stderr, "{}\n", disparity.error().message());
    std::exit(1);
  }
  Image<float> out(pair.left.width, pair.left.height, kUnknown);
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      const Disparity d = (*disparity)(x, y);
      if (d != kNoMatch) out(x, y) = disparity_px(d);
    }
  }
  return out;
}

cv::Mat wrap(const Image<std::uint8_t>& image) {
  return {image.height, image.width, CV_8U, const_cast<std::uint8_t*>(image.row(0)),
          static_cast<std::size_t>(image.stride)};
}

Image<float> from_opencv(const cv::Mat& disparity) {
  Image<float> out(disparity.cols, disparity.rows, kUnknown);
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      const auto d = disparity.at<std::int16_t>(y, x);
      if (d > 0) out(x, y) = static_cast<float>(d) / 16.0F;
    }
  }
  return out;
}

// OpenCV's block matcher with its speckle filter, its other settings as they come.
Image<float> match_opencv(const StereoPair& pair, int window) {
  const auto matcher = cv::StereoBM::create(pair.num_disparities, window);
  matcher->setSpeckleWindowSize(100);
  matcher->setSpeckleRange(2);
  cv::Mat disparity;
  matcher->compute(wrap(pair.left), wrap(pair.right), disparity);
  return from_opencv(disparity);
}

// OpenCV's semi-global matcher with settings of its documentation for block size 3.
Image<float> match_opencv_sgbm(const StereoPair& pair, int mode) {
  constexpr int kBlock = 3;
  const auto matcher = cv::StereoSGBM::create(0, pair.num_disparities, kBlock, 8 * kBlock * kBlock,
                                              32 * kBlock * kBlock, 1, 63, 10, 100, 2, mode);
  cv::Mat disparity;
  matcher->compute(wrap(pair.left), wrap(pair.right), disparity);
  return from_opencv(disparity);
}

nlohmann::ordered_json json_of(const Score& s) {
  return {{"density", s.density}, {"bad1", s.bad1},       {"bad2", s.bad2},
          {"error_px", s.error},  {"missed2", s.missed2}, {"ms", s.ms}};
}

void print_row(const std::string& name, const std::string& method, const Score& s) {
  fmt::print("{:18} {:14} {:7.1f} {:6.2f} {:6.2f} {:6.3f} {:9.2f} {:7.1f}\n", name, method,
             s.density, s.bad1, s.bad2, s.error, s.missed2, s.ms);
}

}  // namespace

int main(int argc, char** argv) {
  bool json = false, ours = false;
  StereoOptions options;
  OptionSet described = describe(options);
  bench::Arguments arguments("stereo_accuracy");
  arguments.flag("--json", json).flag("--ours", ours).options(described);
  if (const auto status = arguments.read(argc, argv)) return *status;
  const auto pairs = bench::load_stereo_pairs(bench::data_folder());
  if (!pairs) {
    fmt::print(stderr, "{}\n", pairs.error().message());
    return 1;
  }
  cv::setNumThreads(1);
  std::vector<std::pair<std::string, Method>> methods = {
      {"tread sad",
       [&](const StereoPair& p) { return match_ours(p, options, StereoMethod::kSad); }},
      {"tread sgm",
       [&](const StereoPair& p) { return match_ours(p, options, StereoMethod::kSgm); }},
      {"BM9+speckle", [](const StereoPair& p) { return match_opencv(p, 9); }},
      {"BM15+speckle", [](const StereoPair& p) { return match_opencv(p, 15); }},
      {"SGBM 3-way",
       [](const StereoPair& p) { return match_opencv_sgbm(p, cv::StereoSGBM::MODE_SGBM_3WAY); }},
      {"SGBM",
       [](const StereoPair& p) { return match_opencv_sgbm(p, cv::StereoSGBM::MODE_SGBM); }}};

  if (ours) methods.resize(2);
  nlohmann::ordered_json result = {{"benchmark", "stereo_accuracy"}};
  std::map<std::string, std::map<std::string, std::vector<Score>>> by_set;
  std::vector<std::string> sets;
  if (!json) {
    fmt::print("{:18} {:14} {:>7} {:>6} {:>6} {:>6} {:>9} {:>7}\n", "pair", "method", "density",
               "bad-1", "bad-2", "error", "missed-2", "ms");
  }
  for (const StereoPair& pair : *pairs) {
    if (sets.empty() || sets.back() != pair.set) sets.push_back(pair.set);
    for (const auto& [name, method] : methods) {
      const auto start = std::chrono::steady_clock::now();
      const Image<float> estimate = method(pair);
      const std::chrono::duration<double, std::milli> ms = std::chrono::steady_clock::now() - start;
      Score s = bench::score(estimate, pair.truth);
      s.ms = ms.count();
      by_set[pair.set][name].push_back(s);
      result["pairs"][pair.name][name] = json_of(s);
      if (!json) print_row(pair.name, name, s);
    }
  }
  if (!json) fmt::print("\nmeans\n");
  std::map<std::string, std::vector<Score>> all;
  for (const std::string& set : sets) {
    for (const auto& [name, method] : methods) {
      const Score mean = mean_of(by_set[set][name]);
      all[name].push_back(mean);
      result["sets"][set][name] = json_of(mean);
      if (!json) print_row(set, name, mean);
    }
  }
  for (const auto& [name, method] : methods) {
    const Score mean = mean_of(all[name]);
    result["mean"][name] = json_of(mean);
    if (!json) print_row("mean of the sets", name, mean);
  }
  if (json) fmt::print("{}\n", result.dump(2));
  return 0;
}
