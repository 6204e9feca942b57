// Where disparities are wrong: beside depth edges and elsewhere, at the left border, which a range
// of disparities cannot reach whole, and by the fraction of the pixel (sub-pixel locking).
//   edge     within 7 px of a change of the true disparity by more than 2 px
//   border   the first num_disparities columns
//   bias     mean error by eighths of a pixel of the truth, of the sets whose truth has them all
// Means over the sets of pairs, each counting once, per cent. Usage: stereo_errors [--json]
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "stereo_pairs.hpp"
#include "tread/stereo/stereo_matcher.hpp"

namespace {

using namespace tread;

constexpr int kEdgeReach_px = 7;
constexpr int kFractions = 8;

struct Tally {
  double truth = 0.0, matched = 0.0, bad2 = 0.0;
  [[nodiscard]] double density() const { return truth > 0.0 ? 100.0 * matched / truth : 0.0; }
  [[nodiscard]] double bad() const { return matched > 0.0 ? 100.0 * bad2 / matched : 0.0; }
};

struct Errors {
  Tally all, edge, flat, border;
  std::array<double, kFractions> bias_sum{}, bias_count{};
};

// Whether a depth edge is near, for each pixel: along its row and column of known truth.
Image<std::uint8_t> near_edges(const Image<float>& truth) {
  Image<std::uint8_t> near(truth.width, truth.height, 0);
  const auto mark = [&](int x, int y) {
    for (int v = std::max(0, y - kEdgeReach_px); v <= std::min(truth.height - 1, y + kEdgeReach_px);
         ++v) {
      for (int u = std::max(0, x - kEdgeReach_px);
           u <= std::min(truth.width - 1, x + kEdgeReach_px); ++u) {
        near(u, v) = 1;
      }
    }
  };
  for (int y = 0; y < truth.height; ++y) {
    float before = NAN;
    for (int x = 0; x < truth.width; ++x) {
      if (!std::isfinite(truth(x, y))) continue;
      if (std::isfinite(before) && std::fabs(truth(x, y) - before) > 2.0F) mark(x, y);
      before = truth(x, y);
    }
  }
  return near;
}

void count(const bench::StereoPair& pair, ImageView<const Disparity> disparity, Errors& errors) {
  const Image<std::uint8_t> near = near_edges(pair.truth);
  for (int y = 0; y < pair.truth.height; ++y) {
    for (int x = 0; x < pair.truth.width; ++x) {
      const float truth = pair.truth(x, y);
      if (!std::isfinite(truth)) continue;
      const bool matched = disparity(x, y) != kNoMatch;
      const float error = matched ? disparity_px(disparity(x, y)) - truth : 0.0F;
      const auto add = [&](Tally& tally) {
        tally.truth += 1.0;
        tally.matched += matched ? 1.0 : 0.0;
        tally.bad2 += std::fabs(error) > 2.0F ? 1.0 : 0.0;
      };
      add(errors.all);
      add(near(x, y) != 0 ? errors.edge : errors.flat);
      if (x < pair.num_disparities) add(errors.border);
      if (!matched || std::fabs(error) > 1.0F) continue;
      const auto fraction =
          static_cast<std::size_t>(kFractions * (truth - std::floor(truth))) % kFractions;
      errors.bias_sum[fraction] += error;
      errors.bias_count[fraction] += 1.0;
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  const bool json = argc > 1 && std::string(argv[1]) == "--json";
  const auto pairs = bench::load_stereo_pairs(bench::data_folder());
  if (!pairs) {
    fmt::print(stderr, "stereo_errors: {}\n", pairs.error().message());
    return 1;
  }
  const std::vector<std::vector<std::pair<std::string, std::string>>> choices = {
      {},
      {{"sad.window_width_px", "9"}},
      {{"holes.max_spread_px", "0"}},
      {{"holes.spatial", "false"}},
      {{"sad.reduced_range_at_border", "false"}},
      {{"sad.sub_pixel", "parabola"}},
      {{"method", "sgm"}},
      {{"method", "sgm"}, {"sgm.sub_pixel", "parabola"}},
      {{"method", "sgm"}, {"sgm.holes.max_spread_px", "0.75"}},
  };
  nlohmann::ordered_json result{{"benchmark", "stereo_errors"}};
  if (!json) {
    fmt::print("{:38} {:>7} {:>6} {:>7} {:>6} {:>7} {:>7} {:>6}  bias by eighths of a pixel, px\n",
               "", "edge %", "bad-2", "else %", "bad-2", "share", "border", "bad-2");
  }
  for (const auto& choice : choices) {
    std::map<std::string, Errors> sets;
    StereoMatcher matcher;
    std::string name;
    for (const bench::StereoPair& pair : *pairs) {
      StereoOptions options;
      OptionSet described = describe(options);
      name.clear();
      for (const auto& [option, value] : choice) {
        if (!described.set(option, value)) return 1;
        name += (name.empty() ? "" : " ") + option + "=" + value;
      }
      options.sad.num_disparities = pair.num_disparities;
      const auto disparity = matcher.match(pair.left, pair.right, options);
      if (!disparity) return 1;
      count(pair, *disparity, sets[pair.set]);
    }
    if (name.empty()) name = "default";
    std::array<double, 7> mean{};
    std::array<double, kFractions> bias{};
    double fine_sets = 0.0;
    for (const auto& [set, e] : sets) {
      const std::array<double, 7> values = {e.edge.density(),
                                            e.edge.bad(),
                                            e.flat.density(),
                                            e.flat.bad(),
                                            100.0 * e.edge.bad2 / e.all.bad2,
                                            e.border.density(),
                                            e.border.bad()};
      for (std::size_t i = 0; i < values.size(); ++i) {
        mean[i] += values[i] / static_cast<double>(sets.size());
      }
      if (std::find(e.bias_count.begin(), e.bias_count.end(), 0.0) != e.bias_count.end()) continue;
      fine_sets += 1.0;
      for (std::size_t i = 0; i < bias.size(); ++i) bias[i] += e.bias_sum[i] / e.bias_count[i];
    }
    for (double& b : bias) b /= fine_sets;
    result["choices"][name] = {{"edge", {{"density", mean[0]}, {"bad2", mean[1]}}},
                               {"elsewhere", {{"density", mean[2]}, {"bad2", mean[3]}}},
                               {"share_of_errors_at_edges", mean[4]},
                               {"border", {{"density", mean[5]}, {"bad2", mean[6]}}},
                               {"bias_px", bias}};
    if (json) continue;
    fmt::print("{:38} {:7.1f} {:6.2f} {:7.1f} {:6.2f} {:7.1f} {:7.1f} {:6.2f} ", name, mean[0],
               mean[1], mean[2], mean[3], mean[4], mean[5], mean[6]);
    for (const double b : bias) fmt::print(" {:+.3f}", b);
    fmt::print("\n");
  }
  if (json) fmt::print("{}\n", result.dump(2));
  return 0;
}
