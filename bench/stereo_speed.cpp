// How fast a rectified pair becomes a disparity image: ours beside OpenCV's matchers, in one
// program, on the same frames, turn by turn, so that what else the machine does hits all alike. The
// least time of many turns counts.
//   ratio   the rival's time over ours
//   GDE/s   disparities tried a second, 1e9
//   cycles  of the time stamp counter for each pixel and disparity
// Usage: stereo_speed [--json] [--turns N] [--ours] [name=value ...]
//   --ours  without the rivals, 640x480x64, one thread; options of ours, as `tread depth --set`
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <opencv2/calib3d.hpp>
#include <string>
#include <vector>

#if defined(__x86_64__)
#include <x86intrin.h>
#endif

#include "arguments.hpp"
#include "stereo_pairs.hpp"
#include "tread/stereo/stereo_matcher.hpp"

namespace {

using namespace tread;

struct Frame {
  std::string name;
  Image<std::uint8_t> left;
  Image<std::uint8_t> right;
  int num_disparities = 64;
};

struct Method {
  std::string name;
  std::function<void()> run;
  double least_ms = std::numeric_limits<double>::infinity();
  double least_cycles = std::numeric_limits<double>::infinity();
};

double cycles_now() {
#if defined(__x86_64__)
  return static_cast<double>(__rdtsc());
#else
  return 0.0;
#endif
}

// The pair scaled to a size by the nearest pixel: content like the original's, any number of it.
Frame scaled(const bench::StereoPair& pair, int width, int height, int num_disparities) {
  Frame frame{fmt::format("{}x{}x{}", width, height, num_disparities),
              Image<std::uint8_t>(width, height), Image<std::uint8_t>(width, height),
              num_disparities};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int u = x * pair.left.width / width, v = y * pair.left.height / height;
      frame.left(x, y) = pair.left(u, v);
      frame.right(x, y) = pair.right(u, v);
    }
  }
  return frame;
}

cv::Mat wrap(const Image<std::uint8_t>& image) {
  return {image.height, image.width, CV_8U, const_cast<std::uint8_t*>(image.row(0)),
          static_cast<std::size_t>(image.stride)};
}

std::vector<Method> methods_of(const Frame& frame, int threads, const StereoOptions& chosen,
                               bool rivals) {
  std::vector<Method> methods;
  const auto add = [&](const std::string& name, std::function<void()> run) {
    methods.push_back({name, std::move(run)});
  };
  const auto add_ours = [&](const std::string& name, StereoMethod method) {
    StereoOptions options = chosen;
    options.method = method;
    options.sad.num_disparities = frame.num_disparities;
    add(name, [&frame, options, threads, matcher = std::make_shared<StereoMatcher>()] {
      const auto found = matcher->match(frame.left, frame.right, options, {threads, nullptr});
      if (!found) throw std::runtime_error(found.error().message());
    });
  };
  add_ours("tread sad", StereoMethod::kSad);
  add_ours("tread sgm", StereoMethod::kSgm);
  if (!rivals) return methods;
  const auto add_opencv = [&](const std::string& name, const cv::Ptr<cv::StereoMatcher>& matcher) {
    matcher->setSpeckleWindowSize(100);
    matcher->setSpeckleRange(2);
    matcher->setDisp12MaxDiff(1);
    add(name, [&frame, matcher, disparity = cv::Mat()]() mutable {
      matcher->compute(wrap(frame.left), wrap(frame.right), disparity);
    });
  };
  add_opencv("BM 11x11", cv::StereoBM::create(frame.num_disparities, 11));
  const auto sgbm = [&](int mode) {
    constexpr int kBlock = 3;
    return cv::StereoSGBM::create(0, frame.num_disparities, kBlock, 8 * kBlock * kBlock,
                                  32 * kBlock * kBlock, 1, 63, 10, 100, 2, mode);
  };
  add_opencv("SGBM", sgbm(cv::StereoSGBM::MODE_SGBM));
  add_opencv("SGBM 3-way", sgbm(cv::StereoSGBM::MODE_SGBM_3WAY));
  return methods;
}

void measure(std::vector<Method>& methods, int turns) {
  using Clock = std::chrono::steady_clock;
  for (int turn = 0; turn < turns; ++turn) {
    for (Method& method : methods) {
      const auto start = Clock::now();
      const double start_cycles = cycles_now();
      method.run();
      const double cycles = cycles_now() - start_cycles;
      const std::chrono::duration<double, std::milli> ms = Clock::now() - start;
      method.least_ms = std::min(method.least_ms, ms.count());
      method.least_cycles = std::min(method.least_cycles, cycles);
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  bool json = false, ours = false;
  int turns = 30;
  StereoOptions options;
  OptionSet described = describe(options);
  bench::Arguments arguments("stereo_speed");
  arguments.flag("--json", json)
      .flag("--ours", ours)
      .number("--turns", turns, 1)
      .options(described);
  if (const auto status = arguments.read(argc, argv)) return *status;
  const bool rivals = !ours;
  const auto pairs = bench::load_stereo_pairs(bench::data_folder());
  if (!pairs) {
    fmt::print(stderr, "{}\n", pairs.error().message());
    return 1;
  }
  const auto named = [&](const std::string& set) {
    return std::find_if(pairs->begin(), pairs->end(), [&](const auto& p) { return p.set == set; });
  };
  const auto motorcycle = named("Motorcycle"), kitti = named("kitti2012");
  if (motorcycle == pairs->end() || kitti == pairs->end()) {
    fmt::print(stderr, "no Motorcycle or kitti2012 pair in {}\n", bench::data_folder().string());
    return 1;
  }
  std::vector<Frame> frames = {
      scaled(*motorcycle, 320, 240, 32), scaled(*motorcycle, 640, 480, 64),
      scaled(*motorcycle, 1280, 720, 128),
      scaled(*kitti, kitti->left.width, kitti->left.height, kitti->num_disparities)};
  frames.back().name = "KITTI " + frames.back().name;

  if (!rivals) frames = {frames[1]};
  nlohmann::ordered_json result = {{"benchmark", "stereo_speed"}, {"turns", turns}};
  if (!json) {
    fmt::print("{:20} {:>7} {:12} {:>8} {:>7} {:>7} {:>7}\n", "pair", "threads", "method", "ms",
               "ratio", "GDE/s", "cycles");
  }
  for (const Frame& frame : frames) {
    for (const int threads : rivals ? std::vector{1, 2} : std::vector{1}) {
      cv::setNumThreads(threads);
      std::vector<Method> methods = methods_of(frame, threads, options, rivals);
      measure(methods, turns);
      const double tried =
          static_cast<double>(frame.left.width) * frame.left.height * frame.num_disparities;
      for (const Method& m : methods) {
        const double ratio = m.least_ms / methods.front().least_ms;
        const double gde = tried / m.least_ms * 1e-6, cycles = m.least_cycles / tried;
        result["frames"][frame.name][std::to_string(threads)][m.name] = {
            {"ms", m.least_ms}, {"ratio", ratio}, {"gde_per_s", gde}, {"cycles", cycles}};
        if (json) continue;
        fmt::print("{:20} {:7} {:12} {:8.2f} {:7.2f} {:7.2f} {:7.3f}\n", frame.name, threads,
                   m.name, m.least_ms, ratio, gde, cycles);
      }
    }
  }
  if (json) fmt::print("{}\n", result.dump(2));
  return 0;
}
