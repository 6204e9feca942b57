#include "tread/sim/camera_view.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "tread/core/parallel.hpp"
#include "tread/sim/shading.hpp"

namespace tread {
namespace {

constexpr int kTile = 16;  // pixels each way
constexpr int kBlock = 4;  // pixels each way of the sixteen that are traced as one
static_assert(kTile * kTile == RayBatch::kMost);

// The pixel of a tile that a place in its batch stands for.
struct InTile {
  int x, y;
};
InTile in_tile(int i) {
  constexpr int kAcross = kTile / kBlock, kRays = kBlock * kBlock;
  const int block = i / kRays, in = i % kRays;
  return {block % kAcross * kBlock + in % kBlock, block / kAcross * kBlock + in / kBlock};
}

// Where in its exposure and in its pixel a sample is, 0 to 1 and -0.5 to 0.5. The places are those
// of a sequence that fills the square evenly however far it is followed (Roberts 2018), so that
// each part of the exposure sees the whole pixel.
struct Sample {
  double time = 0.5, du = 0.0, dv = 0.0;
};
Sample sample_of(int index, int samples) {
  if (samples == 1) return {};
  const auto place = [index](double step) {
    const double x = 0.5 + step * index;
    return x - std::floor(x) - 0.5;
  };
  return {(index + 0.5) / samples, place(0.7548776662466927), place(0.5698402909980532)};
}

// T_world_camera of every row of the image, at a time within its exposure; one for all if all rows
// are exposed at once.
std::vector<Isometry3d> row_poses(const CameraShot& shot, int rows, double time) {
  const double span = shot.exposure_s + shot.readout_s;
  const Eigen::Matrix3d R_start = shot.T_world_start.linear();
  const Eigen::Vector3d turn = so3_log(R_start.transpose() * shot.T_world_end.linear());
  const Eigen::Vector3d way = shot.T_world_end.translation() - shot.T_world_start.translation();
  const bool rolling = shot.readout_s > 0.0 && rows > 1;
  std::vector<Isometry3d> poses(rolling ? static_cast<std::size_t>(rows) : 1U, shot.T_world_start);
  for (std::size_t v = 0; v < poses.size(); ++v) {
    const double opens = rolling ? shot.readout_s * static_cast<double>(v) / (rows - 1) : 0.0;
    const double share = span > 0.0 ? (opens + shot.exposure_s * time) / span : 0.5;
    poses[v].linear() = R_start * so3_exp(share * turn);
    poses[v].translation() += share * way;
  }
  return poses;
}

Status check(const CameraRays& rays, const CameraShot& shot, const RenderOptions& options) {
  if (Status sound = check_options(options); !sound) return sound;
  if (rays.pixels.empty()) {
    return fail(ErrorCode::kBadArgument, "the camera has no pixels", "rays",
                "Make them with make_camera_rays()");
  }
  if (!is_rigid(shot.T_world_start) || !is_rigid(shot.T_world_end)) {
    return fail(ErrorCode::kBadValue, "the pose of the camera is not a rigid motion", "shot",
                "Give an orthonormal right-handed rotation and finite metres");
  }
  if (!(shot.exposure_s >= 0.0) || !(shot.readout_s >= 0.0) ||
      !std::isfinite(shot.exposure_s + shot.readout_s)) {
    return fail(ErrorCode::kBadValue, "exposure and readout are no times", "shot",
                "Give seconds of at least 0");
  }
  return {};
}

class Renderer {
 public:
  Renderer(const Scene& scene, const CameraRays& rays, const RenderOptions& options,
           CameraView& view)
      : scene_(scene), rays_(rays), options_(options), view_(view) {}

  // One sample of each pixel: its share of the light is added to what is there.
  void add_light(const std::vector<Isometry3d>& poses, const Sample& sample, bool first,
                 const Context& context) const {
    each_tile(poses, sample, context,
              [&](int x0, int y0, const RayBatch& batch, const SurfaceBatch& points) {
                SurfaceBatch::Row<float> lit;
                lit.fill(1.0F);
                if (options_.shadows) scene_.light(points, lit);
                LightBatch light;
                shade(scene_, batch, points, lit, options_.colour, light);
                const float share = 1.0F / static_cast<float>(options_.samples);
                for (int i = 0; i < RayBatch::kMost; ++i) {
                  const InTile at = in_tile(i);
                  const int x = x0 + at.x, y = y0 + at.y;
                  if (x >= view_.depth.width || y >= view_.depth.height) continue;
                  const auto from = static_cast<std::size_t>(i);
                  float& grey = view_.grey(x, y);
                  grey = (first ? 0.0F : grey) + share * light.grey[from];
                  if (!options_.colour) continue;
                  LightRgb& to = view_.colour(x, y);
                  if (first) to = {};
                  to.r += share * light.colour[0][from];
                  to.g += share * light.colour[1][from];
                  to.b += share * light.colour[2][from];
                }
                if (options_.samples == 1) put_depth(x0, y0, points);
              });
  }

  void add_depth(const std::vector<Isometry3d>& poses, const Context& context) const {
    each_tile(poses, {}, context, [&](int x0, int y0, const RayBatch&, const SurfaceBatch& points) {
      put_depth(x0, y0, points);
    });
  }

 private:
  template <class Body>
  void each_tile(const std::vector<Isometry3d>& poses, const Sample& sample, const Context& context,
                 const Body& body) const {
    const int across = (view_.depth.width + kTile - 1) / kTile,
              down = (view_.depth.height + kTile - 1) / kTile;
    constexpr int kGrain = 4;
    parallel_chunks(context, 0, across * down, kGrain, [&](int first, int last) {
      RayBatch batch;
      SurfaceBatch points;
      for (int tile = first; tile < last; ++tile) {
        const int x0 = tile % across * kTile, y0 = tile / across * kTile;
        aim(poses, sample, x0, y0, batch);
        scene_.cast(batch, points);
        body(x0, y0, batch, points);
      }
    });
  }

  void aim(const std::vector<Isometry3d>& poses, const Sample& sample, int x0, int y0,
           RayBatch& batch) const {
    batch.count = RayBatch::kMost;
    const bool centre = sample.du == 0.0 && sample.dv == 0.0;
    std::array<std::array<double, RayBatch::kMost>, 3> bearing;
    for (int i = 0; i < RayBatch::kMost; ++i) {
      const InTile at = in_tile(i);
      const auto to = static_cast<std::size_t>(i);
      // Beyond the border of the image: a pixel of it that is not cast again.
      const int x = std::min(x0 + at.x, rays_.pixels.width - 1),
                y = std::min(y0 + at.y, rays_.pixels.height - 1);
      const PixelRay& ray = rays_.pixels(x, y);
      const bool inside = x == x0 + at.x && y == y0 + at.y;
      batch.spread_rad[to] = inside ? ray.spread_rad : std::numeric_limits<float>::quiet_NaN();
      bearing[0][to] = ray.x;
      bearing[1][to] = ray.y;
      bearing[2][to] = ray.z;
      if (centre || !(ray.spread_rad >= 0.0F)) continue;
      const Eigen::Vector3d beside = rays_.beside(x, y, sample.du, sample.dv);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        bearing[axis][to] = beside(static_cast<Eigen::Index>(axis));
      }
    }
    if (poses.size() == 1) {
      turn(poses.front(), bearing, batch);
    } else {
      turn_rows(poses, y0, bearing, batch);
    }
  }

  static void turn(const Isometry3d& T, const std::array<std::array<double, RayBatch::kMost>, 3>& b,
                   RayBatch& batch) {
    for (int axis = 0; axis < 3; ++axis) {
      const double x = T.linear()(axis, 0), y = T.linear()(axis, 1), z = T.linear()(axis, 2);
      auto& direction = batch.direction[static_cast<std::size_t>(axis)];
      for (std::size_t i = 0; i < RayBatch::kMost; ++i) {
        direction[i] = x * b[0][i] + y * b[1][i] + z * b[2][i];
      }
      batch.origin[static_cast<std::size_t>(axis)].fill(T.translation()(axis));
    }
  }
  static void turn_rows(const std::vector<Isometry3d>& poses, int y0,
                        const std::array<std::array<double, RayBatch::kMost>, 3>& b,
                        RayBatch& batch) {
    for (std::size_t i = 0; i < RayBatch::kMost; ++i) {
      const auto row = static_cast<std::size_t>(y0 + in_tile(static_cast<int>(i)).y);
      const Isometry3d& T = poses[std::min(row, poses.size() - 1)];
      const Eigen::Vector3d direction = T.linear() * Eigen::Vector3d(b[0][i], b[1][i], b[2][i]);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        batch.origin[axis][i] = T.translation()(static_cast<Eigen::Index>(axis));
        batch.direction[axis][i] = direction(static_cast<Eigen::Index>(axis));
      }
    }
  }

  void put_depth(int x0, int y0, const SurfaceBatch& points) const {
    for (int i = 0; i < RayBatch::kMost; ++i) {
      const InTile at = in_tile(i);
      const int x = x0 + at.x, y = y0 + at.y;
      if (x >= view_.depth.width || y >= view_.depth.height) continue;
      const double depth = points.distance_m[static_cast<std::size_t>(i)] * rays_.pixels(x, y).z;
      view_.depth(x, y) =
          depth > 0.0 ? static_cast<float>(depth) : std::numeric_limits<float>::quiet_NaN();
    }
  }

  const Scene& scene_;
  const CameraRays& rays_;
  const RenderOptions& options_;
  CameraView& view_;
};

}  // namespace

OptionSet describe(RenderOptions& options) {
  OptionSet set;
  set.add("light", options.light, "else depth only");
  set.add("colour", options.colour, "red, green and blue beside grey");
  set.add("shadows", options.shadows, "of the sun");
  set.add("samples", options.samples, "of a pixel; 8 and more for motion blur", 1, 256);
  return set;
}

Status render(const Scene& scene, const CameraRays& rays, const CameraShot& shot,
              const RenderOptions& options, CameraView& view, const Context& context) {
  const ScopedTimer timer(context, "sim/render");
  if (Status sound = check(rays, shot, options); !sound) return sound;
  const int width = rays.pixels.width, height = rays.pixels.height;
  view.depth.resize(width, height);
  view.grey.resize(options.light ? width : 0, options.light ? height : 0);
  const bool colour = options.light && options.colour;
  view.colour.resize(colour ? width : 0, colour ? height : 0);
  const Renderer renderer(scene, rays, options, view);
  if (!options.light || options.samples > 1) {
    renderer.add_depth(row_poses(shot, height, 0.5), context);
  }
  for (int i = 0; options.light && i < options.samples; ++i) {
    const Sample sample = sample_of(i, options.samples);
    renderer.add_light(row_poses(shot, height, sample.time), sample, i == 0, context);
  }
  return {};
}

}  // namespace tread
