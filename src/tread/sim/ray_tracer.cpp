#include "tread/sim/ray_tracer.hpp"

#include <embree3/rtcore.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

namespace tread {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Where a line is inside a convex body, in lengths of its direction.
struct Inside {
  double enter = -kInfinity, leave = kInfinity;
  bool enters_by_side = true, leaves_by_side = true;  // not by a flat end

  void cut(double low, double high, bool side) {
    if (low > enter) {
      enter = low;
      enters_by_side = side;
    }
    if (high < leave) {
      leave = high;
      leaves_by_side = side;
    }
  }
  void cut_away() { leave = -kInfinity; }
};

// |o + t d| < 1. The product of the roots gives the one that would cancel.
void cut_unit_ball(const Eigen::Vector3d& o, const Eigen::Vector3d& d, Inside& inside) {
  const double a = d.squaredNorm(), b = o.dot(d), c = o.squaredNorm() - 1.0;
  if (a < 1e-18) {
    if (c > 0.0) inside.cut_away();
    return;
  }
  // |o x d|^2 = |o|^2 |d|^2 - (o d)^2 without the cancellation of far away origins.
  const double discriminant = a - o.cross(d).squaredNorm();
  if (discriminant < 0.0) return inside.cut_away();
  const double q = -(b + std::copysign(std::sqrt(discriminant), b));
  const double first = q / a, second = q != 0.0 ? c / q : 0.0;
  inside.cut(std::min(first, second), std::max(first, second), true);
}

// |z| < 1
void cut_slab(double o, double d, Inside& inside) {
  if (d == 0.0) {
    if (std::abs(o) > 1.0) inside.cut_away();
    return;
  }
  const double first = (-1.0 - o) / d, second = (1.0 - o) / d;
  inside.cut(std::min(first, second), std::max(first, second), false);
}

void bounds_of(const RTCBoundsFunctionArguments* args) {
  const RoundShape& shape = static_cast<const RoundShape*>(args->geometryUserPtr)[args->primID];
  const Eigen::Matrix3d sides = shape.R_scene_shape * shape.half_m.asDiagonal();
  Eigen::Vector3d reach;
  for (int i = 0; i < 3; ++i) {
    reach(i) = shape.cylinder ? sides.row(i).head<2>().norm() + std::abs(sides(i, 2))
                              : sides.row(i).norm();
  }
  // Rounded outwards: rays are in single precision.
  reach += 1e-6 * (reach + shape.centre.cwiseAbs());
  const Eigen::Vector3f low = (shape.centre - reach).cast<float>(),
                        high = (shape.centre + reach).cast<float>();
  *args->bounds_o = {low.x(), low.y(), low.z(), 0.0F, high.x(), high.y(), high.z(), 0.0F};
}

std::optional<RoundHit> meet(const RoundShape& shape, RTCRayN* ray, unsigned n, unsigned i) {
  const Eigen::Vector3f o(RTCRayN_org_x(ray, n, i), RTCRayN_org_y(ray, n, i),
                          RTCRayN_org_z(ray, n, i));
  const Eigen::Vector3f d(RTCRayN_dir_x(ray, n, i), RTCRayN_dir_y(ray, n, i),
                          RTCRayN_dir_z(ray, n, i));
  const auto hit = intersect(shape, o.cast<double>(), d.cast<double>(),
                             static_cast<double>(RTCRayN_tnear(ray, n, i)));
  return hit && hit->distance < static_cast<double>(RTCRayN_tfar(ray, n, i)) ? hit : std::nullopt;
}

void intersect_rounds(const RTCIntersectFunctionNArguments* args) {
  const RoundShape& shape = static_cast<const RoundShape*>(args->geometryUserPtr)[args->primID];
  RTCRayN* ray = RTCRayHitN_RayN(args->rayhit, args->N);
  RTCHitN* hits = RTCRayHitN_HitN(args->rayhit, args->N);
  for (unsigned i = 0; i < args->N; ++i) {
    if (args->valid[i] == 0) continue;
    const auto hit = meet(shape, ray, args->N, i);
    if (!hit) continue;
    RTCRayN_tfar(ray, args->N, i) = static_cast<float>(hit->distance);
    RTCHitN_primID(hits, args->N, i) = args->primID;
    RTCHitN_geomID(hits, args->N, i) = args->geomID;
    RTCHitN_instID(hits, args->N, i, 0) = RTC_INVALID_GEOMETRY_ID;
  }
}

void occlude_rounds(const RTCOccludedFunctionNArguments* args) {
  const RoundShape& shape = static_cast<const RoundShape*>(args->geometryUserPtr)[args->primID];
  for (unsigned i = 0; i < args->N; ++i) {
    if (args->valid[i] == 0 || !meet(shape, args->ray, args->N, i)) continue;
    RTCRayN_tfar(args->ray, args->N, i) = -std::numeric_limits<float>::infinity();
  }
}

template <class Row>
void copy_row(void* to, const Row& from) {
  std::memcpy(to, from.data(), sizeof(Row));
}

// The layout of Embree's packets.
void fill(const RayBlock& rays, std::uint32_t mask, RTCRay16& out) {
  copy_row(out.org_x, rays.origin[0]);
  copy_row(out.org_y, rays.origin[1]);
  copy_row(out.org_z, rays.origin[2]);
  copy_row(out.tnear, rays.nearest);
  copy_row(out.dir_x, rays.direction[0]);
  copy_row(out.dir_y, rays.direction[1]);
  copy_row(out.dir_z, rays.direction[2]);
  copy_row(out.tfar, rays.distance);
  std::fill_n(out.time, RayBlock::kRays, 0.0F);
  std::fill_n(out.mask, RayBlock::kRays, mask);
  std::fill_n(out.id, RayBlock::kRays, 0U);
  std::fill_n(out.flags, RayBlock::kRays, 0U);
}

// Neighbouring pixels: Embree then follows the packet as one, three times as fast.
RTCIntersectContext coherent() {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  return context;
}

}  // namespace

std::optional<RoundHit> intersect(const RoundShape& shape, const Eigen::Vector3d& origin,
                                  const Eigen::Vector3d& direction, double nearest) {
  const Eigen::Vector3d scale = shape.half_m.cwiseInverse();
  Eigen::Vector3d o = scale.cwiseProduct(shape.R_scene_shape.transpose() * (origin - shape.centre)),
                  d = scale.cwiseProduct(shape.R_scene_shape.transpose() * direction);
  Inside inside;
  if (shape.cylinder) {
    cut_unit_ball({o.x(), o.y(), 0.0}, {d.x(), d.y(), 0.0}, inside);
    cut_slab(o.z(), d.z(), inside);
  } else {
    cut_unit_ball(o, d, inside);
  }
  if (!(inside.enter <= inside.leave)) return std::nullopt;
  const bool enters = inside.enter > nearest;
  const double t = enters ? inside.enter : inside.leave;
  if (!(t > nearest) || !std::isfinite(t)) return std::nullopt;
  Eigen::Vector3d normal = o + t * d;
  if (shape.cylinder) {
    const bool side = enters ? inside.enters_by_side : inside.leaves_by_side;
    normal =
        side ? Eigen::Vector3d(normal.x(), normal.y(), 0.0) : Eigen::Vector3d(0.0, 0.0, normal.z());
  }
  return RoundHit{t, (shape.R_scene_shape * scale.cwiseProduct(normal)).normalized()};
}

struct RayTracer::Embree {
  RTCDevice device = rtcNewDevice(nullptr);
  RTCScene scenes[2] = {nullptr, nullptr};
  std::vector<std::unique_ptr<std::vector<RoundShape>>> rounds[2];  // where Embree looks for them
  bool empty[2] = {true, true};
  bool out_of_memory = false;

  Embree() {
    clear(kStill);
    clear(kMoving);
  }
  ~Embree() {
    for (RTCScene scene : scenes) {
      if (scene != nullptr) rtcReleaseScene(scene);
    }
    if (device != nullptr) rtcReleaseDevice(device);
  }
  Embree(const Embree&) = delete;
  Embree& operator=(const Embree&) = delete;

  void clear(Layer layer) {
    if (scenes[layer] != nullptr) rtcReleaseScene(scenes[layer]);
    rounds[layer].clear();
    empty[layer] = true;
    scenes[layer] = device != nullptr ? rtcNewScene(device) : nullptr;
    if (scenes[layer] == nullptr) return;
    // Robust: no ray slips between two triangles.
    rtcSetSceneFlags(scenes[layer], RTC_SCENE_FLAG_ROBUST);
  }
  void attach(Layer layer, std::uint32_t id, std::uint32_t mask, RTCGeometry geometry) {
    rtcSetGeometryMask(geometry, mask);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scenes[layer], geometry, id);
    rtcReleaseGeometry(geometry);
    empty[layer] = false;
  }
  void add_mesh(Layer layer, std::uint32_t id, std::uint32_t mask, const Vertices& vertices,
                const std::vector<std::array<std::uint32_t, 4>>& quads) {
    if (quads.empty() || scenes[layer] == nullptr) return;
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_QUAD);
    void* corners = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                            sizeof(vertices[0]), vertices.size());
    void* indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4,
                                            sizeof(quads[0]), quads.size());
    if (corners == nullptr || indices == nullptr) {
      out_of_memory = true;
      rtcReleaseGeometry(geometry);
      return;
    }
    std::memcpy(corners, vertices.data(), vertices.size() * sizeof(vertices[0]));
    std::memcpy(indices, quads.data(), quads.size() * sizeof(quads[0]));
    attach(layer, id, mask, geometry);
  }
};

RayTracer::RayTracer() : embree_(std::make_unique<Embree>()) {}
RayTracer::~RayTracer() = default;
RayTracer::RayTracer(RayTracer&&) noexcept = default;
RayTracer& RayTracer::operator=(RayTracer&&) noexcept = default;

void RayTracer::add_quads(Layer layer, std::uint32_t id, std::uint32_t mask,
                          const Vertices& vertices,
                          const std::vector<std::array<std::uint32_t, 4>>& quads) {
  embree_->add_mesh(layer, id, mask, vertices, quads);
}

void RayTracer::add_triangles(Layer layer, std::uint32_t id, std::uint32_t mask,
                              const Vertices& vertices,
                              const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  // As quadrilaterals without a second half: Embree keeps a tree for each kind of shape, and rays
  // would have to go through one more.
  std::vector<std::array<std::uint32_t, 4>> quads;
  quads.reserve(triangles.size());
  for (const auto& [a, b, c] : triangles) quads.push_back({a, b, c, c});
  embree_->add_mesh(layer, id, mask, vertices, quads);
}

void RayTracer::add_rounds(Layer layer, std::uint32_t id, std::uint32_t mask,
                           std::vector<RoundShape> shapes) {
  if (shapes.empty() || embree_->scenes[layer] == nullptr) return;
  auto& kept = embree_->rounds[layer].emplace_back(
      std::make_unique<std::vector<RoundShape>>(std::move(shapes)));
  RTCGeometry geometry = rtcNewGeometry(embree_->device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(kept->size()));
  rtcSetGeometryUserData(geometry, kept->data());
  rtcSetGeometryBoundsFunction(geometry, bounds_of, nullptr);
  rtcSetGeometryIntersectFunction(geometry, intersect_rounds);
  rtcSetGeometryOccludedFunction(geometry, occlude_rounds);
  embree_->attach(layer, id, mask, geometry);
}

Status RayTracer::commit(Layer layer) {
  if (embree_->scenes[layer] != nullptr && !embree_->out_of_memory) {
    rtcCommitScene(embree_->scenes[layer]);
    if (rtcGetDeviceError(embree_->device) == RTC_ERROR_NONE) return {};
  }
  return fail(ErrorCode::kTooLarge, "there is not enough memory to cast rays at it", "world",
              "Make the ground smaller or coarser, or leave out foliage");
}

void RayTracer::clear(Layer layer) {
  embree_->clear(layer);
}

void RayTracer::cast(RayBlock& rays, std::uint32_t mask) const {
  alignas(64) RTCRayHit16 packet;
  fill(rays, mask, packet.ray);
  std::fill_n(packet.hit.geomID, RayBlock::kRays, RTC_INVALID_GEOMETRY_ID);
  for (const Layer layer : {kStill, kMoving}) {
    if (embree_->empty[layer]) continue;
    RTCIntersectContext context = coherent();
    rtcIntersect16(rays.on.data(), embree_->scenes[layer], &context, &packet);
  }
  std::memcpy(rays.id.data(), packet.hit.geomID, sizeof(rays.id));
  std::memcpy(rays.part.data(), packet.hit.primID, sizeof(rays.part));
  std::memcpy(rays.distance.data(), packet.ray.tfar, sizeof(rays.distance));
}

void RayTracer::test(RayBlock& rays, std::uint32_t mask) const {
  alignas(64) RTCRay16 packet;
  fill(rays, mask, packet);
  for (const Layer layer : {kStill, kMoving}) {
    if (embree_->empty[layer]) continue;
    RTCIntersectContext context = coherent();
    rtcOccluded16(rays.on.data(), embree_->scenes[layer], &context, &packet);
  }
  for (std::size_t i = 0; i < RayBlock::kRays; ++i) {
    rays.id[i] = packet.tfar[i] < 0.0F ? 0U : RayBlock::kMissed;
  }
}

}  // namespace tread
