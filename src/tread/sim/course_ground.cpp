// The ground of a course: a height map or level, then relief in the order of the file, then patches
// of other materials.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tread/io/image_file.hpp"
#include "tread/io/raster_file.hpp"
#include "tread/sim/course_builder.hpp"
#include "tread/sim/relief.hpp"

namespace tread::internal {
namespace {

namespace fs = std::filesystem;

// 16-bit pictures, or 8-bit ones, as heights from low to high. North is up in a picture.
Result<Grid<float>> read_picture(const fs::path& path, CourseFields& fields) {
  const double low = fields.number("low_m", 0.0, -1e4, 1e4),
               high = fields.number("high_m", 1.0, -1e4, 1e4),
               resolution = fields.number("resolution_m", 0.1, 1e-3, 1e3);
  Image<std::uint16_t> image;
  if (auto deep = read_png16(path)) {
    image = std::move(*deep);
  } else {
    const auto grey = read_grey(path);
    if (!grey) return forward(grey);
    image.resize(grey->width, grey->height);
    for (int y = 0; y < grey->height; ++y) {
      for (int x = 0; x < grey->width; ++x) {
        image(x, y) = static_cast<std::uint16_t>(257 * (*grey)(x, y));
      }
    }
  }
  Grid<float> heights({resolution, Eigen::Vector2d::Zero(), image.width, image.height});
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      heights[{x, image.height - 1 - y}] =
          static_cast<float>(low + (high - low) * image(x, y) / 65535.0);
    }
  }
  return heights;
}

// Between the centres of a map's cells, and on from its border.
double sample(const Grid<float>& map, const Eigen::Vector2d& place) {
  const GridGeometry& g = map.geometry;
  const Eigen::Vector2d p = (place - g.centre({0, 0})) / g.resolution_m;
  const double u = std::clamp(p.x(), 0.0, g.columns - 1.0),
               v = std::clamp(p.y(), 0.0, g.rows - 1.0);
  const int x = std::min(static_cast<int>(u), std::max(g.columns - 2, 0)),
            y = std::min(static_cast<int>(v), std::max(g.rows - 2, 0));
  const int x1 = std::min(x + 1, g.columns - 1), y1 = std::min(y + 1, g.rows - 1);
  const double a = u - x, b = v - y;
  return (1 - b) * ((1 - a) * map[{x, y}] + a * map[{x1, y}]) +
         b * ((1 - a) * map[{x, y1}] + a * map[{x1, y1}]);
}

Status read_height_map(const Field& field, CourseBuilder& builder) {
  CourseFields fields(field);
  const std::string name = fields.text("file", "");
  if (name.empty()) {
    fields.refuse("file", ErrorCode::kNotFound, "'file' is missing",
                  "Name a GeoTIFF (.tif) or a PNG");
  }
  fs::path path = name;
  if (path.is_relative()) path = fs::path(field.file()).parent_path() / path;
  const bool picture = path.extension() == ".png" || path.extension() == ".PNG";
  const double scale = fields.number("scale", 1.0, -1e3, 1e3);
  const GridGeometry& area = builder.world.ground.geometry;
  // The lower corner of the map goes there.
  const Eigen::Vector2d at =
      fields.place("at_m", area.origin + Eigen::Vector2d::Constant(0.5 * area.resolution_m));
  if (!fields.good()) return fields.done();
  auto map = picture ? read_picture(path, fields) : read_geotiff(path);
  if (!map) {
    // The file that is wrong, and the line that asked for it.
    Error error = map.error();
    error.where = fmt::format("{}: {}", field.where(), error.where);
    return tl::unexpected<Error>(error);
  }
  if (Status s = fields.done(); !s) return s;
  const auto unknown = std::count_if(map->values.begin(), map->values.end(),
                                     [](float h) { return !(std::abs(h) <= 1e4F); });
  if (unknown > 0) {
    return field.error(ErrorCode::kBadValue,
                       fmt::format("{} of {} heights in {} are unknown or beyond 10 km", unknown,
                                   map->values.size(), path.string()),
                       "Fill the holes first (gdal_fillnodata.py)");
  }
  map->geometry.origin = at;
  Grid<float>& ground = builder.world.ground;
  for (int y = 0; y < area.rows; ++y) {
    for (int x = 0; x < area.columns; ++x) {
      ground[{x, y}] = static_cast<float>(scale * sample(*map, area.centre({x, y})));
    }
  }
  return {};
}

BandOptions read_band(CourseFields& fields) {
  BandOptions band;
  band.from_m = fields.place("from_m");
  band.to_m = fields.place("to_m");
  band.width_m = fields.number("width_m", 1.0, 0.0, 1e4);
  band.bank_m = fields.number("bank_m", 0.2, 1e-3, 1e4);
  if (fields.good() && (band.to_m - band.from_m).norm() < 1e-6) {
    fields.refuse("to_m", ErrorCode::kBadValue, "it is where the line starts",
                  "Write another place");
  }
  return band;
}

void add_all(Grid<float>& heights, const Grid<float>& more) {
  for (std::size_t i = 0; i < heights.values.size(); ++i) heights.values[i] += more.values[i];
}

NoiseOptions read_noise(CourseFields& fields, const GridGeometry& geometry) {
  NoiseOptions noise;
  noise.rms_m = fields.number("rms_m", 0.05, 0.0, 1e3);
  noise.longest_m = fields.number("longest_m", 5.0, 1e-2, 1e5);
  const double finest = 2.0 * geometry.resolution_m;
  noise.shortest_m =
      fields.number("shortest_m", std::clamp(0.2, finest, noise.longest_m), finest, 1e5);
  noise.exponent = fields.number("exponent", noise.exponent, 0.0, 6.0);
  if (fields.good() && noise.shortest_m >= noise.longest_m) {
    fields.refuse("shortest_m", ErrorCode::kBadValue, "not shorter than longest_m",
                  "Write a shorter wavelength");
  }
  return noise;
}

Status read_relief(const Field& item, CourseBuilder& builder) {
  const auto entries = item.entries();
  if (!entries) return forward(entries);
  Grid<float>& heights = builder.world.ground;
  for (const auto& [kind, field] : *entries) {
    CourseFields fields(field);
    if (kind == "noise") {
      const NoiseOptions noise = read_noise(fields, heights.geometry);
      const auto seed = builder.random.stream(field.path()).bits();
      if (Status s = fields.done(); !s) return s;
      add_all(heights, noise_relief(heights.geometry, noise, seed));
    } else if (kind == "ramp") {
      const BandOptions band = read_band(fields);
      const double rise = fields.required_number("rise_m", -100.0, 100.0),
                   plateau = fields.number("plateau_m", 1.0, 0.0, 1e4);
      if (Status s = fields.done(); !s) return s;
      add_ramp(heights, band, rise, plateau);
    } else if (kind == "ditch" || kind == "dam") {
      const BandOptions band = read_band(fields);
      const char* key = kind == "ditch" ? "depth_m" : "height_m";
      const double size = fields.required_number(key, 0.0, 100.0);
      if (Status s = fields.done(); !s) return s;
      add_band(heights, band, kind == "ditch" ? -size : size);
    } else if (kind == "mound") {
      const Eigen::Vector2d at = fields.place("at_m");
      const double radius = fields.required_number("radius_m", 1e-3, 1e4),
                   height = fields.required_number("height_m", -100.0, 100.0);
      if (Status s = fields.done(); !s) return s;
      add_mound(heights, at, radius, height);
    } else if (kind == "road") {
      const auto line = fields.places("line_m", 2);
      const double width = fields.number("width_m", 2.0, 0.0, 1e4),
                   bank = fields.number("bank_m", 1.0, 1e-3, 1e4),
                   smooth = fields.number("smooth_m", 3.0, 0.0, 1e4);
      if (Status s = fields.done(); !s) return s;
      level_road(heights, line, width, bank, smooth);
    } else if (kind == "level") {
      const Eigen::Vector2d at = fields.place("at_m", builder.world.start.position_m);
      const double radius = fields.number("radius_m", 1.0, 0.0, 1e4),
                   blend = fields.number("blend_m", 1.0, 1e-3, 1e4);
      if (Status s = fields.done(); !s) return s;
      level_disc(heights, at, radius, blend);
    } else {
      return item.allow_only({"noise", "ramp", "ditch", "dam", "mound", "road", "level"});
    }
  }
  return {};
}

bool inside(const std::vector<Eigen::Vector2d>& polygon, const Eigen::Vector2d& p) {
  bool odd = false;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const Eigen::Vector2d &a = polygon[i], &b = polygon[j];
    if ((a.y() > p.y()) != (b.y() > p.y()) &&
        p.x() < a.x() + (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y())) {
      odd = !odd;
    }
  }
  return odd;
}

// A material within a polygon, along a line, or in blots that cover a share of the ground.
Status read_patch(const Field& item, CourseBuilder& builder) {
  CourseFields fields(item);
  World& world = builder.world;
  if (world.ground_materials.size() >= 255) {
    return item.error(ErrorCode::kTooLarge, "too many patches", "At most 254");
  }
  Random stream = builder.random.stream(item.path());
  const Surface surface = fields.surface("surface", Surface::kGravel);
  Material material = builder.material(surface, stream);
  material.contrast = static_cast<float>(fields.number("contrast", material.contrast, 0.0, 2.0));
  const auto polygon =
      fields.has("polygon_m") ? fields.places("polygon_m", 3) : std::vector<Eigen::Vector2d>{};
  const auto line =
      fields.has("line_m") ? fields.places("line_m", 2) : std::vector<Eigen::Vector2d>{};
  const double width = fields.number("width_m", 1.0, 0.0, 1e4);
  const double share = fields.number("share", 0.0, 0.0, 1.0),
               blot = fields.number("blot_m", 1.0, 4.0 * world.ground.geometry.resolution_m, 1e4);
  if (fields.good() && polygon.empty() && line.empty() && share == 0.0) {
    fields.refuse("surface", ErrorCode::kNotFound, "the patch has no place",
                  "Add polygon_m: [[x, y], ...], line_m with width_m, or share: 0.2 with blot_m");
  }
  if (Status s = fields.done(); !s) return s;
  Grid<std::uint8_t>& surfaces = world.ground_surface;
  Grid<float> field;
  float threshold = 0.0F;
  if (share > 0.0) {
    field = noise_relief(surfaces.geometry, {1.0, 2.0 * blot, 0.5 * blot, 2.0}, stream.bits());
    std::vector<float> sorted = field.values;
    const auto nth = sorted.begin() +
                     static_cast<std::ptrdiff_t>(share * static_cast<double>(sorted.size() - 1));
    std::nth_element(sorted.begin(), nth, sorted.end());
    threshold = *nth;
  }
  const auto number = static_cast<std::uint8_t>(world.ground_materials.size());
  world.ground_materials.push_back(material);
  for (int y = 0; y < surfaces.geometry.rows; ++y) {
    for (int x = 0; x < surfaces.geometry.columns; ++x) {
      const Eigen::Vector2d p = surfaces.geometry.centre({x, y});
      if (!polygon.empty() && !inside(polygon, p)) continue;
      if (!line.empty() && nearest_on_line(line, p).distance_m > 0.5 * width) continue;
      if (share > 0.0 && field[{x, y}] > threshold) continue;
      surfaces[{x, y}] = number;
    }
  }
  return {};
}

template <class Read>
Status read_list(const std::optional<Field>& field, const Read& read) {
  if (!field) return {};
  const auto items = field->items();
  if (!items) return forward(items);
  for (const Field& item : *items) {
    if (Status s = read(item); !s) return s;
  }
  return {};
}

}  // namespace

Status read_ground(const Field& field, CourseBuilder& builder) {
  CourseFields fields(field);
  World& world = builder.world;
  const GridGeometry geometry = world.ground.geometry;
  world.ground = Grid<float>(geometry);
  world.ground_surface = Grid<std::uint8_t>(geometry);
  Random stream = builder.random.stream("ground");
  Material material = builder.material(fields.surface("surface", Surface::kSoil), stream);
  material.contrast = static_cast<float>(fields.number("contrast", material.contrast, 0.0, 2.0));
  world.ground_materials = {material};
  const auto map = fields.find("height_map"), relief = fields.find("relief"),
             patches = fields.find("patches");
  if (Status s = fields.done(); !s) return s;
  if (map) {
    if (Status s = read_height_map(*map, builder); !s) return s;
  }
  if (Status s = read_list(relief, [&](const Field& f) { return read_relief(f, builder); }); !s) {
    return s;
  }
  return read_list(patches, [&](const Field& f) { return read_patch(f, builder); });
}

}  // namespace tread::internal
