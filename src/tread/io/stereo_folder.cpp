#include "tread/io/stereo_folder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <system_error>

#include "tread/io/text.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;

struct Layout {
  StereoFolder::Kind kind;
  const char* left;
  const char* right;
};
// The first that is there is taken: grey before colour.
constexpr std::array<Layout, 7> kLayouts = {{
    {StereoFolder::Kind::kKitti, "image_0", "image_1"},
    {StereoFolder::Kind::kKitti, "image_2", "image_3"},
    {StereoFolder::Kind::kKitti, "image_l", "image_r"},
    {StereoFolder::Kind::kLeftRight, "left", "right"},
    {StereoFolder::Kind::kLeftRight, "image_left", "image_right"},
    {StereoFolder::Kind::kLeftRight, "cam0/data", "cam1/data"},
    {StereoFolder::Kind::kLeftRight, "mav0/cam0/data", "mav0/cam1/data"},
}};

constexpr std::string_view kUnderstood =
    "Give a KITTI odometry sequence (image_0 and image_1, or image_2 and image_3, or image_l and "
    "image_r, with calib.txt), or a folder with left and right (or image_left and image_right, "
    "cam0/data and cam1/data), or with NAME_left.png beside NAME_right.png, and a rig.yaml";

bool is_image(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  constexpr std::array<std::string_view, 5> kKnown = {".png", ".jpg", ".jpeg", ".pgm", ".ppm"};
  const bool hidden = path.filename().string().starts_with('.');
  return !hidden && std::find(kKnown.begin(), kKnown.end(), extension) != kKnown.end();
}

using ImagesByName = std::map<std::string, fs::path>;

// The images of a folder by their stems less `suffix`; those without it are left out.
Result<ImagesByName> images_in(const fs::path& folder, std::string_view suffix = "") {
  ImagesByName images;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    std::string name = at->path().stem().string();
    if (!is_image(at->path()) || !name.ends_with(suffix)) continue;
    name.resize(name.size() - suffix.size());
    const auto [place, is_new] = images.emplace(name, at->path());
    if (is_new) continue;
    return fail(ErrorCode::kBadFormat,
                fmt::format("{} and {} are images of one name", place->second.filename().string(),
                            at->path().filename().string()),
                folder.string(), "Move one away");
  }
  if (!error) return images;
  return fail(ErrorCode::kUnreadable, fmt::format("cannot be listed: {}", error.message()),
              folder.string(), "Check its permissions");
}

std::vector<StereoFolder::Frame> pair_by_name(const ImagesByName& left, const ImagesByName& right) {
  std::map<std::string, StereoFolder::Frame> frames;
  for (const auto& [name, path] : left) frames[name].left = path;
  for (const auto& [name, path] : right) frames[name].right = path;
  std::vector<StereoFolder::Frame> list;
  for (auto& [name, frame] : frames) {
    frame.name = name;
    list.push_back(std::move(frame));
  }
  return list;
}

// The names as numbers if all are whole numbers and all differ.
std::optional<std::vector<std::int64_t>> numbers_of(
    const std::vector<StereoFolder::Frame>& frames) {
  std::vector<std::int64_t> numbers;
  for (const StereoFolder::Frame& frame : frames) {
    const bool digits = frame.name.find_first_not_of("0123456789") == std::string::npos;
    const auto number = parse_number<std::int64_t>(frame.name);
    if (!digits || !number) return std::nullopt;
    numbers.push_back(*number);
  }
  std::vector<std::int64_t> sorted = numbers;
  std::sort(sorted.begin(), sorted.end());
  if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end()) return std::nullopt;
  return numbers;
}

// Orders the frames and gives them their numbers and times.
void number_frames(std::vector<StereoFolder::Frame>& frames) {
  constexpr std::int64_t kPeriod_ns = 100'000'000;
  constexpr std::size_t kStampDigits = 16;
  const auto numbers = numbers_of(frames);
  const bool stamps = numbers && std::all_of(frames.begin(), frames.end(), [](const auto& frame) {
                        return frame.name.size() >= kStampDigits;
                      });
  // Numbers that are neither all stamps nor all small are names.
  const bool small = numbers && std::all_of(frames.begin(), frames.end(), [](const auto& frame) {
                       return frame.name.size() < kStampDigits - 6;
                     });
  if (stamps || small) {
    for (std::size_t i = 0; i < frames.size(); ++i) frames[i].number = (*numbers)[i];
    std::sort(frames.begin(), frames.end(),
              [](const auto& a, const auto& b) { return a.number < b.number; });
  }
  for (std::size_t i = 0; i < frames.size(); ++i) {
    StereoFolder::Frame& frame = frames[i];
    if (stamps) frame.stamp_ns = frame.number;
    if (!small) frame.number = static_cast<std::int64_t>(i);
    if (!stamps) frame.stamp_ns = frame.number * kPeriod_ns;
  }
}

Result<StereoFolder> with_frames(StereoFolder folder, const fs::path& path,
                                 const Result<ImagesByName>& left,
                                 const Result<ImagesByName>& right) {
  if (!left) return forward(left);
  if (!right) return forward(right);
  folder.frames = pair_by_name(*left, *right);
  number_frames(folder.frames);
  if (!folder.frames.empty()) return folder;
  return fail(ErrorCode::kNotFound, "no images in it", path.string(),
              "Images are PNG, JPEG, PGM or PPM files");
}

}  // namespace

Result<StereoFolder> find_stereo_folder(const fs::path& path) {
  std::error_code ignored;
  if (!fs::exists(path, ignored)) {
    return fail(ErrorCode::kNotFound, "no such folder", path.string(), "Check the name");
  }
  if (!fs::is_directory(path, ignored)) {
    return fail(ErrorCode::kUnsupported, "this is not a folder of stereo images", path.string(),
                std::string(kUnderstood));
  }
  for (const Layout& layout : kLayouts) {
    if (!fs::is_directory(path / layout.left, ignored) ||
        !fs::is_directory(path / layout.right, ignored)) {
      continue;
    }
    return with_frames({layout.kind, layout.left, {}}, path / layout.left,
                       images_in(path / layout.left), images_in(path / layout.right));
  }
  const auto left = images_in(path, "_left"), right = images_in(path, "_right");
  if ((left && !left->empty()) || (right && !right->empty()) || !left || !right) {
    return with_frames({StereoFolder::Kind::kLeftRight, "", {}}, path, left, right);
  }
  return fail(ErrorCode::kNotFound, "no stereo images are found in it", path.string(),
              std::string(kUnderstood));
}

}  // namespace tread
