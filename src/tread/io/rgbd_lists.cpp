// Lists of RGB-D images: those of TUM RGB-D, and seq.txt.
//
// TUM (Sturm, Engelhard, Endres, Burgard, Cremers 2012) records the two images of a frame some
// milliseconds apart and lists them by their own times. Each depth image is a frame, with the
// colour image nearest in time; one colour image may serve two of them.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string_view>
#include <system_error>

#include "tread/io/atomic_file.hpp"
#include "tread/io/rgbd_folder.hpp"
#include "tread/io/text.hpp"
#include "tread/io/trajectory_file.hpp"

namespace tread::internal {
namespace {

namespace fs = std::filesystem;
using Frame = RgbdFolder::Frame;

constexpr std::size_t kLargestList = std::size_t{1} << 26;
constexpr std::uint64_t kNearest_ns = 20'000'000;   // as TUM's own associate.py
constexpr std::int64_t kTruthGap_ns = 100'000'000;  // ten poses of the tracking system

// An image or a frame and the line that it was on.
struct Listed {
  int line = 0;
  Frame frame;
};

// A path as a list names it, from the folder of the list.
Result<fs::path> parse_image_path(std::string_view text, const fs::path& folder,
                                  const std::string& place) {
  const bool printable = std::none_of(text.begin(), text.end(), [](char c) {
    return static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
  });
  if (printable) return folder / text;
  return fail(ErrorCode::kBadFormat, in_quotes(text) + " is not the name of a file", place,
              "Correct or remove this line");
}

// Orders by time; of several of one time the first in the file stays.
void order_by_time(std::vector<Listed>& items, const fs::path& file, std::vector<Error>& problems) {
  std::stable_sort(items.begin(), items.end(), [](const Listed& a, const Listed& b) {
    return a.frame.stamp_ns < b.frame.stamp_ns;
  });
  std::vector<Listed> kept;
  for (Listed& item : items) {
    if (kept.empty() || kept.back().frame.stamp_ns != item.frame.stamp_ns) {
      kept.push_back(std::move(item));
      continue;
    }
    problems.push_back({ErrorCode::kBadValue,
                        fmt::format("line {} has the same time", kept.back().line),
                        line_place(file.string(), item.line), "Correct or remove one of the two"});
  }
  items = std::move(kept);
}

// Calls parse(line, place), a Result<Listed>, for each line from `first` on. A line that cannot be
// read is among the problems and costs only itself.
template <class Parse>
std::vector<Listed> parse_lines(const std::vector<TextLine>& lines, std::size_t first,
                                const fs::path& file, std::vector<Error>& problems,
                                const Parse& parse) {
  std::vector<Listed> items;
  for (std::size_t i = first; i < lines.size(); ++i) {
    Result<Listed> item = parse(lines[i].text, line_place(file.string(), lines[i].number));
    if (!item) {
      problems.push_back(item.error());
      continue;
    }
    item->line = lines[i].number;
    items.push_back(std::move(*item));
  }
  order_by_time(items, file, problems);
  return items;
}

Result<RgbdFolder> with_frames(RgbdFolder folder, std::vector<Listed> items, const fs::path& file) {
  for (Listed& item : items) {
    item.frame.name = rgbd_frame_name(item.frame.depth);
    folder.frames.push_back(std::move(item.frame));
  }
  if (!folder.frames.empty()) return folder;
  const auto problem = std::find_if(
      folder.problems.begin(), folder.problems.end(),
      [&](const Error& error) { return error.where.starts_with(file.string() + ":"); });
  if (problem != folder.problems.end()) return tl::unexpected<Error>(*problem);
  return fail(ErrorCode::kBadFormat, "no depth image is listed", file.string(),
              "Check that this is the right file");
}

// ---- TUM

// depth.txt or rgb.txt, "time file" a line; the file is put into frame.*image.
Result<std::vector<Listed>> read_image_list(const fs::path& file, fs::path Frame::*image,
                                            std::vector<Error>& problems) {
  const auto text = read_file(file, kLargestList);
  if (!text) return forward(text);
  const fs::path folder = file.parent_path();
  const auto parse = [&](std::string_view line, const std::string& place) -> Result<Listed> {
    const auto fields = split_fields(line);
    if (fields.size() != 2) {
      return fail(ErrorCode::kBadFormat, fmt::format("{} fields instead of 2", fields.size()),
                  place, "A line of a list of images is: time file");
    }
    const auto stamp_ns = parse_stamp(fields[0], place);
    if (!stamp_ns) return forward(stamp_ns);
    const auto path = parse_image_path(fields[1], folder, place);
    if (!path) return forward(path);
    Listed item;
    item.frame.stamp_ns = *stamp_ns;
    item.frame.*image = *path;
    return item;
  };
  return parse_lines(lines_with_content(*text), 0, file, problems, parse);
}

// Unsigned: the distance of two stamps of opposite sign may not fit into a signed number.
std::uint64_t apart_ns(std::int64_t a, std::int64_t b) {
  return static_cast<std::uint64_t>(std::max(a, b)) - static_cast<std::uint64_t>(std::min(a, b));
}

// Both ordered by time. Of two colour images equally far the earlier is taken.
void add_nearest_colour(std::vector<Listed>& depths, const std::vector<Listed>& colours) {
  for (Listed& depth : depths) {
    const std::int64_t stamp_ns = depth.frame.stamp_ns;
    const auto after =
        std::lower_bound(colours.begin(), colours.end(), stamp_ns,
                         [](const Listed& a, std::int64_t b) { return a.frame.stamp_ns < b; });
    std::uint64_t nearest_ns = kNearest_ns + 1;
    for (auto at = after == colours.begin() ? after : after - 1; at != colours.end() && at <= after;
         ++at) {
      const std::uint64_t distance_ns = apart_ns(at->frame.stamp_ns, stamp_ns);
      if (distance_ns >= nearest_ns) continue;
      nearest_ns = distance_ns;
      depth.frame.colour = at->frame.colour;
    }
  }
}

Result<std::vector<Listed>> associate_by_time(const fs::path& path, std::vector<Error>& problems) {
  auto depths = read_image_list(path / "depth.txt", &Frame::depth, problems);
  if (!depths) return depths;
  std::error_code ignored;
  if (!fs::exists(path / "rgb.txt", ignored)) return depths;
  const auto colours = read_image_list(path / "rgb.txt", &Frame::colour, problems);
  if (colours) {
    add_nearest_colour(*depths, *colours);
  } else {
    problems.push_back(colours.error());
  }
  return depths;
}

// "time file time file", depth first or colour first. Which it is, the names say: depth images are
// in a folder depth, or have it in their name.
Result<std::vector<Listed>> read_associations(const fs::path& file, std::vector<Error>& problems) {
  const auto text = read_file(file, kLargestList);
  if (!text) return forward(text);
  const fs::path folder = file.parent_path();
  const auto parse = [&](std::string_view line, const std::string& place) -> Result<Listed> {
    const auto fields = split_fields(line);
    if (fields.size() != 4) {
      return fail(ErrorCode::kBadFormat, fmt::format("{} fields instead of 4", fields.size()),
                  place, "A line of associations is: time depth_file time colour_file");
    }
    const auto is_depth = [&](std::size_t i) {
      return fields[i].find("depth") != std::string_view::npos;
    };
    if (is_depth(1) == is_depth(3)) {
      return fail(ErrorCode::kBadFormat, "it is not clear which of the two images is depth", place,
                  "Name the one depth/... and the other rgb/...");
    }
    const std::size_t depth = is_depth(1) ? 0 : 2, colour = 2 - depth;
    const auto stamp_ns = parse_stamp(fields[depth], place);
    if (!stamp_ns) return forward(stamp_ns);
    const auto depth_path = parse_image_path(fields[depth + 1], folder, place);
    if (!depth_path) return forward(depth_path);
    const auto colour_path = parse_image_path(fields[colour + 1], folder, place);
    if (!colour_path) return forward(colour_path);
    Listed item;
    item.frame.stamp_ns = *stamp_ns;
    item.frame.depth = *depth_path;
    item.frame.colour = *colour_path;
    return item;
  };
  return parse_lines(lines_with_content(*text), 0, file, problems, parse);
}

// ---- seq.txt

struct ListHead {
  RgbdCamera camera;
  double depth_per_metre = 0.0;
};

Result<ListHead> parse_list_head(std::string_view line, const std::string& place) {
  constexpr const char* kRemedy = "Write: K fx fy cx cy depth_scale width height";
  const auto fields = split_fields(line);
  if (fields.size() != 8 || fields[0] != "K") {
    return fail(ErrorCode::kBadFormat, "this is not the first line of a list of RGB-D images",
                place, kRemedy);
  }
  std::array<double, 5> values{};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto value = parse_number<double>(fields[i + 1]);
    if (!value || !std::isfinite(*value)) {
      return fail(ErrorCode::kBadFormat, in_quotes(fields[i + 1]) + " is not a number", place,
                  kRemedy);
    }
    values[i] = *value;
  }
  const auto width = parse_number<int>(fields[6]), height = parse_number<int>(fields[7]);
  if (!width || !height || *width < 1 || *height < 1) {
    return fail(ErrorCode::kBadValue, "the size of the images is not two whole numbers above 0",
                place, kRemedy);
  }
  if (!(values[4] > 0.0)) {
    return fail(ErrorCode::kBadValue, "depth_scale is not above 0", place,
                "Write how many units of the depth images are a metre, as 1000");
  }
  ListHead head;
  head.camera = {{values[0], values[1], values[2], values[3], 0.0}, {*width, *height}};
  head.depth_per_metre = values[4];
  const Status checked = check_camera(head.camera.pinhole, place + ": K");
  if (!checked) return forward(checked);
  return head;
}

// A pose that cannot be read costs the pose, not the frame.
Result<Listed> parse_list_line(std::string_view line, const fs::path& folder,
                               const std::string& place, std::vector<Error>& problems) {
  const auto fields = split_fields(line);
  if (fields.size() != 3 && fields.size() != 10) {
    return fail(ErrorCode::kBadFormat, fmt::format("{} fields instead of 10", fields.size()), place,
                "A line is: time depth_file colour_file tx ty tz qx qy qz qw");
  }
  Listed item;
  const auto stamp_ns = parse_stamp(fields[0], place);
  if (!stamp_ns) return forward(stamp_ns);
  item.frame.stamp_ns = *stamp_ns;
  const auto depth = parse_image_path(fields[1], folder, place);
  if (!depth) return forward(depth);
  item.frame.depth = *depth;
  if (fields[2] != "-") {
    const auto colour = parse_image_path(fields[2], folder, place);
    if (!colour) return forward(colour);
    item.frame.colour = *colour;
  }
  if (fields.size() == 10) {
    const auto pose = parse_tum_pose(std::span(fields).subspan(3), place);
    if (pose) {
      item.frame.T_world_camera = *pose;
    } else {
      problems.push_back(pose.error());
    }
  }
  return item;
}

}  // namespace

Result<RgbdFolder> read_tum_folder(const fs::path& path, const fs::path& associations) {
  RgbdFolder folder;
  folder.kind = RgbdFolder::Kind::kTum;
  folder.path = path;
  folder.depth_per_metre = 5000.0;
  auto items = associations.empty() ? associate_by_time(path, folder.problems)
                                    : read_associations(associations, folder.problems);
  if (!items) return forward(items);
  const fs::path list = associations.empty() ? path / "depth.txt" : associations;
  auto found = with_frames(std::move(folder), std::move(*items), list);
  const fs::path truth = path / "groundtruth.txt";
  std::error_code ignored;
  if (!found || !fs::exists(truth, ignored)) return found;
  auto read = read_tum_trajectory(truth, &found->problems);
  if (!read) {
    found->problems.push_back(read.error());
    return found;
  }
  found->truth = std::move(*read);
  for (Frame& frame : found->frames) {
    frame.T_world_camera = pose_at(found->truth, frame.stamp_ns, kTruthGap_ns);
  }
  return found;
}

Result<RgbdFolder> read_rgbd_list(const fs::path& file) {
  const auto text = read_file(file, kLargestList);
  if (!text) return forward(text);
  const auto lines = lines_with_content(*text);
  if (lines.empty()) {
    return fail(ErrorCode::kBadFormat, "the file is empty", file.string(),
                "Check that this is the right file");
  }
  const auto head =
      parse_list_head(lines.front().text, line_place(file.string(), lines.front().number));
  if (!head) return forward(head);
  RgbdFolder folder;
  folder.kind = RgbdFolder::Kind::kList;
  folder.path = file.parent_path();
  folder.depth_per_metre = head->depth_per_metre;
  folder.full_depth_is_unknown = true;
  folder.camera = head->camera;
  auto items = parse_lines(lines, 1, file, folder.problems,
                           [&](std::string_view line, const std::string& place) {
                             return parse_list_line(line, folder.path, place, folder.problems);
                           });
  for (const Listed& item : items) {
    if (item.frame.T_world_camera) {
      folder.truth.push_back({item.frame.stamp_ns, *item.frame.T_world_camera});
    }
  }
  return with_frames(std::move(folder), std::move(items), file);
}

}  // namespace tread::internal
