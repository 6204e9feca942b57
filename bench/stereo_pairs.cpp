#include "stereo_pairs.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "tread/io/image_file.hpp"

namespace tread::bench {
namespace {

namespace fs = std::filesystem;
constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

template <class T>
Image<float> scaled(const Image<T>& values, float scale) {
  Image<float> out(values.width, values.height);
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      out(x, y) = values(x, y) == 0 ? kUnknown : static_cast<float>(values(x, y)) * scale;
    }
  }
  return out;
}

Result<Image<float>> read_truth(const fs::path& path, float scale) {
  if (path.extension() == ".pfm") {
    auto truth = read_pfm(path);
    if (!truth) return truth;
    for (int y = 0; y < truth->height; ++y) {
      std::replace_if(
          truth->row(y), truth->row(y) + truth->width, [](float v) { return !std::isfinite(v); },
          kUnknown);
    }
    return truth;
  }
  if (scale < 0.01F) {
    const auto values = read_png16(path);
    if (!values) return forward(values);
    return scaled(*values, scale);
  }
  const auto values = read_grey(path);
  if (!values) return forward(values);
  return scaled(*values, scale);
}

Result<StereoPair> load(const std::string& name, const std::string& set, const fs::path& left,
                        const fs::path& right, const fs::path& truth, float scale,
                        int num_disparities) {
  auto l = read_grey(left);
  if (!l) return forward(l);
  auto r = read_grey(right);
  if (!r) return forward(r);
  auto t = read_truth(truth, scale);
  if (!t) return forward(t);
  return StereoPair{name, set, std::move(*l), std::move(*r), std::move(*t), num_disparities};
}

}  // namespace

fs::path data_folder() {
  const char* chosen = std::getenv("TREAD_DATA");
  for (const fs::path& folder :
       {fs::path(chosen != nullptr ? chosen : ""), fs::path(TREAD_SOURCE_DIR) / "../shared/data"}) {
    std::error_code ignored;
    if (!folder.empty() && fs::is_directory(folder, ignored)) return folder;
  }
  return {};
}

Result<std::vector<StereoPair>> load_stereo_pairs(const fs::path& data) {
  const fs::path root = data / "stereo";
  std::vector<Result<StereoPair>> loaded;
  loaded.push_back(load("cones", "cones", root / "cones/im2.png", root / "cones/im6.png",
                        root / "cones/disp2.png", 1.0F / 4, 64));
  loaded.push_back(load("Cloth3", "Cloth3", root / "Cloth3/view1.png", root / "Cloth3/view5.png",
                        root / "Cloth3/disp1.png", 1.0F / 2, 96));
  loaded.push_back(load("Motorcycle", "Motorcycle", root / "Motorcycle/motorcycle_left.png",
                        root / "Motorcycle/motorcycle_right.png", root / "Motorcycle/disp_gt.pfm",
                        1.0F, 64));
  std::vector<fs::path> truths;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(root / "kitti2012/disp_noc", error)) {
    truths.push_back(entry.path());
  }
  std::sort(truths.begin(), truths.end());
  for (const fs::path& truth : truths) {
    loaded.push_back(load("kitti2012/" + truth.stem().string().substr(0, 6), "kitti2012",
                          root / "kitti2012/image_0" / truth.filename(),
                          root / "kitti2012/image_1" / truth.filename(), truth, 1.0F / 256, 128));
  }
  std::vector<StereoPair> pairs;
  for (auto& pair : loaded) {
    if (!pair) return forward(pair);
    pairs.push_back(std::move(*pair));
  }
  return pairs;
}

}  // namespace tread::bench
