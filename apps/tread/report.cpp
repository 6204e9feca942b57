// The page is put together as text, part by part in the order of the calls. Values for the pointer
// travel as 16-bit numbers in base64: 0 unknown, 1 to 65535 from the smallest to the largest.
#include "report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "html.hpp"
#include "report_page.hpp"
#include "tread/io/atomic_file.hpp"
#include "tread/io/image_file.hpp"

namespace tread {
namespace {

constexpr int kMostValues = 120'000;  // a picture; more would make files of many megabytes

std::string tag(const std::string& name, const std::string& attributes, const std::string& inner) {
  const std::string gap = attributes.empty() ? "" : " ";
  return "<" + name + gap + attributes + ">" + inner + "</" + name + ">";
}

// The scale from left to right as the background of a bar.
std::string gradient(const ColourScale& scale) {
  constexpr int kStops = 16;
  std::string stops;
  for (int i = 0; i <= kStops; ++i) {
    stops += "," + hex_colour(colour_at(scale, static_cast<double>(i) / kStops));
  }
  return "linear-gradient(to right" + stops + ")";
}

std::string marks_html(const Figure& figure) {
  std::vector<LegendMark> marks = figure.marks;
  if (figure.scale) {
    const ColourScale& scale = *figure.scale;
    if (scale.lethal_from) {
      marks.push_back(
          {scale.lethal, "lethal, from " + number_text(*scale.lethal_from, scale.unit)});
    }
    if (!scale.unknown_label.empty()) marks.push_back({scale.unknown, scale.unknown_label});
  }
  std::string out;
  for (const LegendMark& mark : marks) {
    const std::string swatch = tag("i", "style=\"background:" + hex_colour(mark.colour) + "\"", "");
    out += tag("span", "", swatch + escape_html(mark.text));
  }
  return out.empty() ? "" : tag("div", "class=\"marks\"", out);
}

std::string legend_html(const Figure& figure) {
  std::string out;
  if (figure.scale) {
    const ColourScale& scale = *figure.scale;
    const std::string name =
        scale.unit.empty() ? scale.label : scale.label + " [" + scale.unit + "]";
    out += tag("div", "class=\"bar\" style=\"background:" + gradient(scale) + "\"",
               figure.values ? "<div class=\"tick\" hidden=\"hidden\"></div>" : "");
    out += tag("div", "class=\"ends\"",
               tag("span", "", number_text(scale.low)) +
                   tag("span", "class=\"name\"", escape_html(name)) +
                   tag("span", "", number_text(scale.high)));
  }
  out += marks_html(figure);
  return out.empty() ? "" : tag("div", "class=\"legend\"", out);
}

// The values, thinned to a bounded number, as attributes of the picture's frame.
std::string values_attributes(const PictureValues& under, const Figure& figure) {
  const Image<float>& values = under.values;
  int step = 1;
  const auto thinned = [&step](int size) { return (size + step - 1) / step; };
  while (thinned(values.width) * static_cast<long>(thinned(values.height)) > kMostValues) ++step;
  const ValueRange range = value_range(values, 0.0);
  const double span = static_cast<double>(range.high) - range.low;
  std::string bytes;
  for (int j = 0; j < thinned(values.height); ++j) {
    for (int i = 0; i < thinned(values.width); ++i) {
      const float value = values(std::min(i * step + step / 2, values.width - 1),
                                 std::min(j * step + step / 2, values.height - 1));
      const long code =
          std::isfinite(value) ? 1 + std::lround(65534.0 * (value - range.low) / span) : 0;
      bytes += static_cast<char>(code & 0xFF);
      bytes += static_cast<char>(code >> 8);
    }
  }
  const std::string unit = figure.scale ? figure.scale->unit : "";
  std::string out = fmt::format(
      " data-frame=\"{}\" data-axis=\"{}\" data-unit=\"{}\" data-corners=\"{} {} {} {}\""
      " data-size=\"{} {} {} {}\" data-range=\"{} {}\"",
      escape_html(under.frame), escape_html(under.axis_unit), escape_html(unit), under.top_left.x(),
      under.top_left.y(), under.bottom_right.x(), under.bottom_right.y(), values.width,
      values.height, step, thinned(values.width), range.low, range.high);
  if (figure.scale) {
    out += fmt::format(" data-scale=\"{} {}\"", figure.scale->low, figure.scale->high);
  }
  return out + " data-values=\"" + encode_base64(bytes) + "\"";
}

bool is_number(const std::string& text) {
  const std::size_t first = text.find_first_not_of("+-.");
  return first != std::string::npos && text[first] >= '0' && text[first] <= '9';
}

std::string cell_html(const std::string& name, const std::string& text, bool numeric) {
  return tag(name, numeric ? "class=\"num\"" : "", escape_html(text));
}

std::string card(const std::string& title, const std::string& inner) {
  const std::string heading = title.empty() ? "" : tag("h3", "", escape_html(title));
  return tag("div", "class=\"card\"", heading + inner) + "\n";
}

}  // namespace

PictureValues values_under(const Grid<float>& values, std::string frame) {
  const GridGeometry& g = values.geometry;
  PictureValues under;
  under.frame = std::move(frame);
  under.top_left = g.origin + g.resolution_m * Eigen::Vector2d(0.0, g.rows);
  under.bottom_right = g.origin + g.resolution_m * Eigen::Vector2d(g.columns, 0.0);
  under.values = Image<float>(g.columns, g.rows);
  for (int y = 0; y < g.rows; ++y) {
    for (int x = 0; x < g.columns; ++x) under.values(x, g.rows - 1 - y) = values[{x, y}];
  }
  return under;
}

PictureValues values_under(ImageView<const float> values, std::string frame) {
  PictureValues under;
  under.frame = std::move(frame);
  under.axis_unit = "px";
  under.top_left = {-0.5, -0.5};
  under.bottom_right = {values.width - 0.5, values.height - 0.5};
  under.values = Image<float>(values.width, values.height);
  for (int y = 0; y < values.height; ++y) {
    std::copy(values.row(y), values.row(y) + values.width, under.values.row(y));
  }
  return under;
}

Report::Report(std::string title, std::string subtitle)
    : title_(std::move(title)), subtitle_(std::move(subtitle)) {}

// Figures that follow each other share one grid of the page.
void Report::close_figures() {
  if (in_figures_) body_ += "</div>\n";
  in_figures_ = false;
}

void Report::add_section(const std::string& title, const std::string& text) {
  close_figures();
  if (in_section_) body_ += "</section>\n";
  in_section_ = true;
  sections_.push_back(title);
  body_ += fmt::format("<section id=\"s{}\">\n", sections_.size());
  body_ += tag("h2", "", escape_html(title)) + "\n";
  if (!text.empty()) body_ += tag("p", "class=\"lead\"", escape_html(text)) + "\n";
}

void Report::add_note(const std::string& text, NoteKind kind) {
  close_figures();
  const bool warning = kind == NoteKind::kWarning;
  body_ += tag("p", warning ? "class=\"note warning\" role=\"alert\"" : "class=\"note\"",
               escape_html(text)) +
           "\n";
}

void Report::add_key_numbers(const std::vector<KeyNumber>& numbers) {
  close_figures();
  std::string tiles;
  for (const KeyNumber& number : numbers) {
    const std::string unit = number.unit.empty() ? "" : tag("small", "", escape_html(number.unit));
    tiles += tag("div", "class=\"tile\"",
                 tag("b", "", escape_html(number.value) + unit) +
                     tag("span", "", escape_html(number.label)));
  }
  body_ += tag("div", "class=\"tiles\"", tiles) + "\n";
}

void Report::add_quantities(const std::string& title, const std::vector<Quantity>& quantities) {
  close_figures();
  std::string rows;
  for (const Quantity& quantity : quantities) {
    const std::string badge =
        quantity.assumed ? " " + tag("span", "class=\"badge\"", "assumed") : "";
    rows += tag("tr", "",
                tag("td", "", escape_html(quantity.name)) +
                    tag("td", "", escape_html(quantity.value) + badge) +
                    tag("td", "class=\"remark\"", escape_html(quantity.remark)));
  }
  body_ += card(title, tag("table", "", tag("tbody", "", rows)));
}

void Report::add_figure(ImageView<const Rgb> picture, const Figure& figure) {
  if (!in_figures_) body_ += "<div class=\"figures\">\n";
  in_figures_ = true;
  const Result<std::string> png = encode_png(picture);
  if (!png) {
    if (state_) state_ = forward(png);
    return;
  }
  const bool has_values = figure.values && !figure.values->values.empty();
  const std::string values = has_values ? values_attributes(*figure.values, figure) : "";
  const std::string image =
      fmt::format("<img alt=\"{}\" width=\"{}\" height=\"{}\" src=\"data:image/png;base64,{}\" />",
                  escape_html(figure.title), picture.width, picture.height, encode_base64(*png));
  const std::string frame =
      tag("div",
          fmt::format("class=\"frame\" style=\"--ratio:{:.5f}\"{}",
                      static_cast<double>(picture.width) / picture.height, values),
          image + (has_values ? "<div class=\"cross\" hidden=\"hidden\"></div>" : ""));
  body_ += tag("figure", figure.wide ? "class=\"wide\"" : "",
               tag("h3", "", escape_html(figure.title)) + frame + legend_html(figure) +
                   (has_values ? "<output class=\"readout\"></output>" : "") +
                   tag("figcaption", "", escape_html(figure.caption))) +
           "\n";
}

void Report::add_table(const Table& table) {
  close_figures();
  // A column is one of numbers, and set to the right, if every entry is.
  std::size_t columns = table.header.size();
  for (const auto& row : table.rows) columns = std::max(columns, row.size());
  std::vector<bool> numeric(columns, !table.rows.empty());
  const auto entry = [](const std::vector<std::string>& row, std::size_t i) {
    return i < row.size() ? row[i] : std::string();
  };
  for (const auto& row : table.rows) {
    for (std::size_t i = 0; i < columns; ++i) {
      if (!is_number(entry(row, i))) numeric[i] = false;
    }
  }
  const auto line = [&](const std::string& name, const std::vector<std::string>& row) {
    std::string cells;
    for (std::size_t i = 0; i < columns; ++i) cells += cell_html(name, entry(row, i), numeric[i]);
    return tag("tr", "", cells);
  };
  std::string rows;
  for (const auto& row : table.rows) rows += line("td", row);
  const std::string head = table.header.empty() ? "" : tag("thead", "", line("th", table.header));
  body_ += card(table.title, tag("table", "", head + tag("tbody", "", rows)));
}

void Report::add_timings(const Timings& timings) {
  close_figures();
  double longest = 0.0;
  for (const auto& [path, entry] : timings.entries()) longest = std::max(longest, entry.total_ms);
  std::string rows;
  for (const auto& [path, entry] : timings.entries()) {
    const double share = longest > 0.0 ? 100.0 * entry.total_ms / longest : 0.0;
    const std::string bar = tag("div", fmt::format("style=\"width:{:.1f}%\"", share), "");
    rows +=
        tag("tr", "",
            cell_html("td", path, false) + cell_html("td", fmt::format("{}", entry.calls), true) +
                cell_html("td", fmt::format("{:.2f}", entry.mean_ms()), true) +
                cell_html("td", fmt::format("{:.2f}", entry.max_ms), true) +
                cell_html("td", fmt::format("{:.1f}", entry.total_ms), true) +
                tag("td", "class=\"share\"", bar));
  }
  const std::string head =
      tag("thead", "",
          tag("tr", "",
              cell_html("th", "stage", false) + cell_html("th", "calls", true) +
                  cell_html("th", "mean [ms]", true) + cell_html("th", "longest [ms]", true) +
                  cell_html("th", "total [ms]", true) + tag("th", "", "")));
  body_ += card("", tag("table", "", head + tag("tbody", "", rows)));
}

Result<std::string> Report::html() const {
  if (!state_) return forward(state_);
  std::string links;
  for (std::size_t i = 0; i < sections_.size(); ++i) {
    links += tag("a", fmt::format("href=\"#s{}\"", i + 1), escape_html(sections_[i]));
  }
  const std::string nav = sections_.size() < 2 ? "" : tag("nav", "", tag("div", "", links)) + "\n";
  const std::string command =
      command_.empty() ? "" : tag("pre", "class=\"command\"", escape_html(command_));
  std::string page = "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\" />\n";
  page += "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\" />\n";
  page += tag("title", "", escape_html(title_)) + "\n";
  page += tag("style", "", std::string(kReportStyle)) + "\n</head>\n<body>\n";
  page += tag("header", "",
              tag("div", "class=\"mark\"", std::string(kReportMark) + tag("span", "", "tread")) +
                  tag("h1", "", escape_html(title_)) +
                  tag("p", "class=\"subtitle\"", escape_html(subtitle_)) + command) +
          "\n";
  page += nav + "<main>\n" + body_;
  if (in_figures_) page += "</div>\n";
  if (in_section_) page += "</section>\n";
  page += "</main>\n" + tag("footer", "", escape_html(footer_)) + "\n";
  page += tag("script", "", std::string(kReportScript)) + "\n</body>\n</html>\n";
  return page;
}

Status Report::write(const std::filesystem::path& path) const {
  const Result<std::string> page = html();
  if (!page) return forward(page);
  return write_file(path, *page);
}

}  // namespace tread
