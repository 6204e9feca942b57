// One self-contained HTML file that shows what a command did: pictures with captions, legends and
// numbers, tables, times. Nothing is loaded from elsewhere; it looks right on light and dark
// screens, on telephones and on paper. With values given, the pointer shows place and value, in
// all pictures of the same frame at once.
//
//   Report report("Ground map", "20 s of a drive, seen by a stereo camera");
//   report.set_command("tread map drive/ -o out");
//   report.add_key_numbers({{"known ground", "412", "m2"}, {"per frame", "31", "ms"}});
//   report.add_section("Terrain", "Heights above the first camera position.");
//   report.add_figure(map.image, {.title = "Height", .caption = "...", .scale = scale,
//                                 .values = values_under(height, "map")});
//   report.add_timings(timings);
//   const Status written = report.write("out/report.html");
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pictures.hpp"
#include "tread/core/result.hpp"
#include "tread/core/timer.hpp"

namespace tread {

// The values beneath a picture, for the pointer. The picture covers them exactly.
struct PictureValues {
  std::string frame;  // pictures of one frame show the same place together: "map", "left image"
  std::string axis_unit = "m";
  Eigen::Vector2d top_left = Eigen::Vector2d::Zero();  // coordinates of the picture's corners
  Eigen::Vector2d bottom_right = Eigen::Vector2d::Ones();
  Image<float> values;  // row 0 at the top; not finite where unknown
};
[[nodiscard]] PictureValues values_under(const Grid<float>& values, std::string frame = "map");
[[nodiscard]] PictureValues values_under(ImageView<const float> values,
                                         std::string frame = "left image");

// An entry of a legend: what a mark of this colour means.
struct LegendMark {
  Rgb colour;
  std::string text;
};

struct Figure {
  std::string title = {};
  std::string caption = {};
  std::optional<ColourScale> scale = std::nullopt;
  std::optional<PictureValues> values = std::nullopt;
  std::vector<LegendMark> marks = {};
  bool wide = false;  // takes the whole width of the page
};

struct KeyNumber {
  std::string label;
  std::string value;
  std::string unit;
};

// A quantity the result stands on, for the list of quantities. What was assumed rather than given
// or measured carries a badge.
struct Quantity {
  std::string name;
  std::string value;
  bool assumed = false;
  std::string remark = {};
};

struct Table {
  std::string title;
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;
};

enum class NoteKind { kInfo, kWarning };

class Report {
 public:
  Report(std::string title, std::string subtitle);
  // The command line that made it, shown below the title.
  void set_command(std::string command) { command_ = std::move(command); }
  // A small line at the end: version, host, date, as the caller likes.
  void set_footer(std::string footer) { footer_ = std::move(footer); }

  // What is added goes to the section begun last.
  void add_section(const std::string& title, const std::string& text = "");
  void add_note(const std::string& text, NoteKind kind = NoteKind::kInfo);
  void add_key_numbers(const std::vector<KeyNumber>& numbers);
  void add_quantities(const std::string& title, const std::vector<Quantity>& quantities);
  void add_figure(ImageView<const Rgb> picture, const Figure& figure);
  void add_table(const Table& table);
  void add_timings(const Timings& timings);

  // The page, and whether every picture could be encoded.
  [[nodiscard]] Result<std::string> html() const;
  [[nodiscard]] Status write(const std::filesystem::path& path) const;

 private:
  void close_figures();

  std::string title_, subtitle_, command_, footer_;
  std::string body_;
  std::vector<std::string> sections_;
  bool in_section_ = false;
  bool in_figures_ = false;
  Status state_;
};

}  // namespace tread
