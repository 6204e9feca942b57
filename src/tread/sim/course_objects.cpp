// Things that people put there: stairs, pallets, kerbs, walls, stepping stones.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "tread/sim/course_builder.hpp"

namespace tread::internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// The euro pallet's deck and height (EN 13698-1: 1.2 x 0.8 x 0.144 m), as the paper rounds them.
const Vector3d kPallet_m(1.2, 0.8, 0.15);

struct Item {
  CourseFields& fields;
  const std::string& name;
  Random& stream;
  CourseBuilder& builder;

  [[nodiscard]] Material material(Surface otherwise) const {
    return builder.material(fields.surface("surface", otherwise), stream);
  }
};

struct Stand {
  Vector2d at;
  double yaw;
  [[nodiscard]] Vector2d place(double forward, double left) const {
    return at + Eigen::Rotation2Dd(yaw) * Vector2d(forward, left);
  }
};

Stand read_stand(CourseFields& fields) {
  return {fields.place("at_m"), fields.angle("yaw_deg", 0.0, -360.0, 360.0)};
}

void read_box(const Item& item) {
  const Stand stand = read_stand(item.fields);
  BoxSpec box{item.name, stand.at,         stand.yaw, 0.0,
              0.0,       Vector3d::Ones(), 0.0,       item.material(Surface::kConcrete)};
  box.pitch_rad = item.fields.angle("pitch_deg", 0.0, -90.0, 90.0);
  box.roll_rad = item.fields.angle("roll_deg", 0.0, -90.0, 90.0);
  box.size_m = item.fields.sizes("size_m", Vector3d::Constant(0.5), 1e-3, 1e3);
  box.lift_m = item.fields.number("lift_m", 0.0, 0.0, 100.0);
  if (item.fields.good()) add_box(item.builder, box);
}

// Up along x: each step a box from its riser to the end, so that there is nothing to see below.
void read_stairs(const Item& item) {
  CourseFields& f = item.fields;
  const Stand stand = read_stand(f);
  const int steps = f.whole("steps", 5, 1, 200);
  const double rise = f.number("rise_m", 0.15, 0.005, 2.0),
               tread = f.number("tread_m", 0.30, 0.02, 5.0),
               width = f.number("width_m", 1.5, 0.05, 100.0),
               landing = f.number("landing_m", 1.0, 0.0, 100.0);
  const bool down = f.choice("down", {"no", "yes"}, 0) == 1;
  const Material material = item.material(Surface::kConcrete);
  if (!f.good()) return;
  const double end = (steps - 1) * tread + std::max(landing, tread);
  const double all = down ? end + (steps - 1) * tread : end;
  const double base = item.builder.height(stand.at);
  for (int i = 0; i < steps; ++i) {
    const double from = i * tread, to = down ? all - i * tread : all;
    BoxSpec box{fmt::format("{} step {}", item.name, i + 1),
                stand.place(0.5 * (from + to), 0.0),
                stand.yaw,
                0.0,
                0.0,
                Vector3d(to - from, width, (i + 1) * rise),
                0.0,
                material};
    // All steps count from where the stairs stand, whatever the ground under them does.
    box.size_m.z() += base - item.builder.height(box.at_m);
    if (box.size_m.z() > 0.0) add_box(item.builder, box);
  }
}

void read_pallet(const Item& item) {
  CourseFields& f = item.fields;
  const Stand stand = read_stand(f);
  const int stack = f.whole("stack", 1, 1, 20);
  const double offset = f.number("offset_m", 0.0, -1.2, 1.2);
  const double tilt = f.angle("pitch_deg", 0.0, -45.0, 45.0);
  const Material material = item.material(Surface::kPlanks);
  if (!f.good()) return;
  const double base = item.builder.height(stand.at);
  // Each on the one below, shifted forward.
  for (int i = 0; i < stack; ++i) {
    const Vector2d at = stand.place(i * offset, 0.0);
    const double lift = i == 0 ? 0.0 : i * kPallet_m.z() + base - item.builder.height(at);
    add_box(item.builder, {stack > 1 ? fmt::format("{} ({})", item.name, i + 1) : item.name, at,
                           stand.yaw, tilt, 0.0, kPallet_m, lift, material});
  }
}

// Two pallets and stones between them whose tops are lower (paper Q, Fig. 8).
void read_stepping_stones(const Item& item) {
  CourseFields& f = item.fields;
  const Stand stand = read_stand(f);
  const double gap = f.number("gap_m", 1.2, 0.05, 20.0), drop = f.number("drop_m", 0.08, -1.0, 1.0),
               side = f.number("stone_m", 0.25, 0.02, 2.0),
               height = f.number("height_m", kPallet_m.z(), 0.02, 2.0);
  const int stones = f.whole("stones", 4, 1, 100);
  const double sway = f.number("sway_m", 0.2, 0.0, 5.0);
  const Material wood = item.builder.material(Surface::kPlanks, item.stream),
                 stone = item.material(Surface::kRock);
  if (!f.good()) return;
  if (drop >= height) {
    f.refuse("drop_m", ErrorCode::kBadValue, "the stones would be below the ground",
             "Write less than height_m");
    return;
  }
  for (const double side_of : {0.0, kPallet_m.x() + gap}) {
    add_box(item.builder, {item.name + (side_of > 0.0 ? " far pallet" : " near pallet"),
                           stand.place(0.5 * kPallet_m.x() + side_of, 0.0), stand.yaw, 0.0, 0.0,
                           Vector3d(kPallet_m.x(), kPallet_m.y(), height), 0.0, wood});
  }
  for (int i = 0; i < stones; ++i) {
    const double forward = kPallet_m.x() + gap * (i + 0.5) / stones;
    const double left = (i % 2 == 0 ? 0.5 : -0.5) * sway;
    add_box(item.builder, {fmt::format("{} stone {}", item.name, i + 1), stand.place(forward, left),
                           stand.yaw + 0.4 * (item.stream.uniform() - 0.5), 0.0, 0.0,
                           Vector3d(side, side, height - drop), 0.0, stone});
  }
}

// A wall or a kerb along a line.
void read_wall(const Item& item, double height, double thickness, Surface surface) {
  CourseFields& f = item.fields;
  const auto line = f.places("line_m", 2);
  height = f.number("height_m", height, 1e-3, 100.0);
  thickness = f.number("thickness_m", thickness, 1e-3, 100.0);
  const Material material = item.material(surface);
  if (!f.good()) return;
  for (std::size_t i = 1; i < line.size(); ++i) {
    const Vector2d step = line[i] - line[i - 1];
    if (step.norm() < 1e-6) continue;
    add_box(item.builder,
            {line.size() > 2 ? fmt::format("{} part {}", item.name, i) : item.name,
             0.5 * (line[i] + line[i - 1]), std::atan2(step.y(), step.x()), 0.0, 0.0,
             Vector3d(step.norm() + (line.size() > 2 ? thickness : 0.0), thickness, height), 0.0,
             material});
  }
}

// Three walls around a dead end, open towards -x.
void read_cul_de_sac(const Item& item) {
  CourseFields& f = item.fields;
  const Stand stand = read_stand(f);
  const double width = f.number("width_m", 3.0, 0.1, 1e3),
               depth = f.number("depth_m", 4.0, 0.1, 1e3),
               height = f.number("height_m", 1.0, 0.01, 100.0),
               thickness = f.number("thickness_m", 0.25, 0.01, 10.0);
  const Material material = item.material(Surface::kConcrete);
  if (!f.good()) return;
  const auto wall = [&](const char* part, double forward, double left, double along,
                        double across) {
    add_box(item.builder, {item.name + part, stand.place(forward, left), stand.yaw, 0.0, 0.0,
                           Vector3d(along, across, height), 0.0, material});
  };
  wall(" left", 0.5 * depth, 0.5 * (width + thickness), depth + thickness, thickness);
  wall(" right", 0.5 * depth, -0.5 * (width + thickness), depth + thickness, thickness);
  wall(" end", depth, 0.0, thickness, width);
}

// Two platforms with nothing between them.
void read_gap(const Item& item) {
  CourseFields& f = item.fields;
  const Stand stand = read_stand(f);
  const double gap = f.number("gap_m", 0.3, 0.01, 100.0),
               height = f.number("height_m", 0.2, 0.01, 10.0),
               length = f.number("length_m", 2.0, 0.05, 100.0),
               width = f.number("width_m", 1.5, 0.05, 100.0);
  const Material material = item.material(Surface::kConcrete);
  if (!f.good()) return;
  const double apart = 0.5 * (gap + length);
  for (const double forward : {-apart, apart}) {
    add_box(item.builder,
            {item.name + (forward < 0.0 ? " near side" : " far side"), stand.place(forward, 0.0),
             stand.yaw, 0.0, 0.0, Vector3d(length, width, height), 0.0, material});
  }
}

void read_post(const Item& item) {
  CourseFields& f = item.fields;
  Solid post;
  const Vector2d at = f.place("at_m");
  const double radius = f.number("radius_m", 0.05, 1e-3, 50.0),
               height = f.number("height_m", 1.0, 1e-3, 100.0);
  post.name = item.name;
  post.shape = Solid::Shape::kCylinder;
  post.material = item.material(Surface::kPlanks);
  if (!f.good()) return;
  const double ground = item.builder.height(at), foot = std::min(0.3, height);
  post.half_m = Vector3d(radius, radius, 0.5 * (height + foot));
  post.T_world_solid.translation() << at, ground + 0.5 * (height - foot);
  item.builder.world.solids.push_back(std::move(post));
  item.builder.taken.push_back({at, radius});
}

void read_person(const Item& item) {
  CourseFields& f = item.fields;
  Person person;
  person.name = item.name;
  person.path_m = f.places("path_m", 2);
  person.speed_m_per_s = f.number("speed_m_per_s", person.speed_m_per_s, 0.0, 10.0);
  person.height_m = f.number("height_m", person.height_m, 0.5, 2.5);
  person.ahead_s = f.number("ahead_s", 0.0, 0.0, 1e5);
  for (const Vector2d& place : person.path_m) {
    if (std::isnan(ground_height(item.builder.world, place))) {
      f.refuse("path_m", ErrorCode::kBadValue, "it leaves the ground",
               extent_text(item.builder.world));
    }
  }
  person.clothes = item.material(Surface::kCloth);
  // No two people are dressed alike.
  for (int i = 0; i < 3; ++i) {
    person.clothes.albedo(i) = static_cast<float>(0.05 + 0.5 * item.stream.uniform());
  }
  if (f.good()) item.builder.world.people.push_back(std::move(person));
}

struct Kind {
  const char* name;
  void (*read)(const Item& item);
};

const std::vector<Kind>& kinds() {
  static const std::vector<Kind> kKinds = {
      {"box", read_box},
      {"stairs", read_stairs},
      {"pallet", read_pallet},
      {"stepping_stones", read_stepping_stones},
      {"kerb", [](const Item& item) { read_wall(item, 0.12, 0.3, Surface::kConcrete); }},
      {"wall", [](const Item& item) { read_wall(item, 1.5, 0.2, Surface::kConcrete); }},
      {"fence", [](const Item& item) { read_wall(item, 1.1, 0.04, Surface::kPlanks); }},
      {"cul_de_sac", read_cul_de_sac},
      {"gap", read_gap},
      {"post", read_post},
      {"person", read_person},
  };
  return kKinds;
}

}  // namespace

void add_box(CourseBuilder& builder, const BoxSpec& box) {
  Solid solid;
  solid.name = box.name;
  solid.material = box.material;
  solid.T_world_solid.linear() =
      rotation_from_yaw_pitch_roll(box.yaw_rad, box.pitch_rad, box.roll_rad);
  const double ground = builder.height(box.at_m);
  double bottom = ground + box.lift_m;
  const double top = bottom + box.size_m.z();
  if (box.lift_m == 0.0) {
    for (const double x : {-0.5, 0.5}) {
      for (const double y : {-0.5, 0.5}) {
        const Vector3d corner =
            solid.T_world_solid.linear() * Vector3d(x * box.size_m.x(), y * box.size_m.y(), 0.0);
        bottom = std::min(bottom, builder.height(box.at_m + corner.head<2>()) - corner.z());
      }
    }
  }
  solid.half_m = 0.5 * Vector3d(box.size_m.x(), box.size_m.y(), top - bottom);
  solid.T_world_solid.translation() << box.at_m, 0.0;
  solid.T_world_solid.translation().z() = top;
  solid.T_world_solid.translation() -=
      solid.T_world_solid.linear() * Vector3d(0, 0, solid.half_m.z());
  builder.world.solids.push_back(std::move(solid));
  builder.taken.push_back({box.at_m, 0.5 * box.size_m.head<2>().norm()});
}

namespace {

// What was added since `first` stands on the ground with its middle.
Status check_on_ground(const Field& field, std::size_t first, const World& world) {
  for (std::size_t i = first; i < world.solids.size(); ++i) {
    const Vector2d middle = world.solids[i].T_world_solid.translation().head<2>();
    if (!std::isnan(ground_height(world, middle))) continue;
    return field.error(
        ErrorCode::kBadValue,
        fmt::format("it is off the ground, at [{:.6g}, {:.6g}]", middle.x(), middle.y()),
        extent_text(world));
  }
  return {};
}

}  // namespace

Status read_object(const Field& item, CourseBuilder& builder) {
  const auto entries = item.entries();
  if (!entries) return forward(entries);
  if (entries->size() != 1) {
    return item.error(ErrorCode::kBadFormat,
                      fmt::format("{} kinds of object in one item", entries->size()),
                      "Write one kind an item: '- pallet: {at_m: [3, 0]}'");
  }
  const auto& [kind, field] = entries->front();
  const std::size_t first = builder.world.solids.size();
  Random stream = builder.random.stream(field.path());
  const std::string name = fmt::format("{} (line {})", field.path(), field.line());
  for (const Kind& known : kinds()) {
    if (kind != known.name) continue;
    CourseFields fields(field);
    known.read({fields, name, stream, builder});
    if (Status s = fields.done(); !s) return s;
    return check_on_ground(field, first, builder.world);
  }
  const auto grown = read_growth(kind, field, name, stream, builder);
  if (!grown) return forward(grown);
  if (*grown) return {};
  std::vector<std::string> names = growth_kinds();
  for (const Kind& known : kinds()) names.emplace_back(known.name);
  return item.allow_only(names);
}

}  // namespace tread::internal
