#include "tread/slam/extract_mesh.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <unordered_map>
#include <vector>

namespace tread {
namespace {

// Corner i of a cube is at (i & 1, i >> 1 & 1, i >> 2 & 1). An edge is named by its axis and the
// corner it starts at: 4 * axis + the two other coordinates.
constexpr int kEdges = 12;

constexpr int edge_between(int a, int b) {
  const int axis = std::countr_zero(static_cast<unsigned>(a ^ b));
  const int start = a & b;
  const int u = start >> (axis + 1) % 3 & 1, v = start >> (axis + 2) % 3 & 1;
  return 4 * axis + 2 * u + v;
}

struct EdgeEnds {
  int from, to;
};
constexpr EdgeEnds ends_of(int edge) {
  const int axis = edge / 4, u = edge >> 1 & 1, v = edge & 1;
  const int from = u << (axis + 1) % 3 | v << (axis + 2) % 3;
  return {from, from | 1 << axis};
}

// Which edges the triangles of a cube lie on, by which corners are inside (negative).
using Triangles = std::vector<std::array<std::int8_t, 3>>;

// The surface cuts each face of the cube in segments, one for each run of inside corners around the
// face; those of neighbouring faces meet on edges and close to polygons. Both cubes at a face see
// the same runs, so that their surfaces meet.
Triangles triangles_of(int inside) {
  // Corners of the faces, counter-clockwise seen from outside.
  constexpr int kFaces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  std::array<int, kEdges> next;
  next.fill(-1);
  for (const auto& face : kFaces) {
    for (int i = 0; i < 4; ++i) {
      const int outside = face[i], first = face[(i + 1) % 4];
      const bool run_begins = (inside >> outside & 1) == 0 && (inside >> first & 1) != 0;
      if (!run_begins) continue;
      int j = (i + 1) % 4;
      while ((inside >> face[(j + 1) % 4] & 1) != 0) j = (j + 1) % 4;
      next[static_cast<std::size_t>(edge_between(face[j], face[(j + 1) % 4]))] =
          edge_between(outside, first);
    }
  }
  Triangles triangles;
  std::array<bool, kEdges> done{};
  for (int start = 0; start < kEdges; ++start) {
    if (next[static_cast<std::size_t>(start)] < 0 || done[static_cast<std::size_t>(start)])
      continue;
    std::vector<std::int8_t> loop;
    for (int e = start; !done[static_cast<std::size_t>(e)]; e = next[static_cast<std::size_t>(e)]) {
      done[static_cast<std::size_t>(e)] = true;
      loop.push_back(static_cast<std::int8_t>(e));
    }
    for (std::size_t i = 1; i + 1 < loop.size(); ++i) {
      triangles.push_back({loop[0], loop[i + 1], loop[i]});
    }
  }
  return triangles;
}

const std::array<Triangles, 256>& all_triangles() {
  static const std::array<Triangles, 256> table = [] {
    std::array<Triangles, 256> made;
    for (int i = 0; i < 256; ++i) made[static_cast<std::size_t>(i)] = triangles_of(i);
    return made;
  }();
  return table;
}

constexpr int kSide = kBlockSide + 1;  // with the first layer of the blocks behind
constexpr int kCorners = kSide * kSide * kSide;

constexpr int corner_at(int x, int y, int z) {
  return (z * kSide + y) * kSide + x;
}

// A block with the voxels behind its border.
struct Brick {
  std::int16_t distance[kCorners];
  std::uint8_t weight[kCorners];
  Rgb colour[kCorners];
};

void load(const VoxelVolume& volume, const BlockPlace& place, Brick& brick, BlockVoxels& voxels) {
  std::fill(std::begin(brick.weight), std::end(brick.weight), std::uint8_t{0});
  for (int part = 0; part < 8; ++part) {
    const int dx = part & 1, dy = part >> 1 & 1, dz = part >> 2;
    if (!volume.read(place + BlockPlace(dx, dy, dz), voxels)) continue;
    const auto count = [](int d) { return d == 0 ? kBlockSide : 1; };
    for (int z = 0; z < count(dz); ++z) {
      for (int y = 0; y < count(dy); ++y) {
        for (int x = 0; x < count(dx); ++x) {
          const int to = corner_at(x + dx * kBlockSide, y + dy * kBlockSide, z + dz * kBlockSide);
          const std::size_t from = VolumeView::voxel_of(0, x, y, z);
          brick.distance[to] = voxels.distance[from];
          brick.weight[to] = voxels.weight[from];
          brick.colour[to] = voxels.colour[from];
        }
      }
    }
  }
}

struct EdgePlace {
  std::int32_t x, y, z, axis;
  [[nodiscard]] bool operator==(const EdgePlace&) const = default;
};
struct EdgeHash {
  std::size_t operator()(const EdgePlace& e) const {
    return BlockPlaceHash()({e.x, e.y, e.z}) * 4 + static_cast<std::size_t>(e.axis);
  }
};

class Mesher {
 public:
  Mesher(const VoxelVolume& volume, const MeshOptions& options)
      : volume_(volume), options_(options), voxel_m_(volume.view().voxel_m) {}

  Mesh run() {
    for (const BlockPlace& place : volume_.all_blocks()) {
      load(volume_, place, brick_, voxels_);
      std::fill(std::begin(vertex_), std::end(vertex_), -1);
      first_ = place * kBlockSide;
      for (int z = 0; z < kBlockSide; ++z) {
        for (int y = 0; y < kBlockSide; ++y) {
          for (int x = 0; x < kBlockSide; ++x) add_cube(x, y, z);
        }
      }
    }
    return std::move(mesh_);
  }

 private:
  void add_cube(int x, int y, int z) {
    int inside = 0;
    for (int i = 0; i < 8; ++i) {
      const int at = corner_at(x + (i & 1), y + (i >> 1 & 1), z + (i >> 2));
      if (brick_.weight[at] < options_.least_weight) return;
      inside |= (brick_.distance[at] < 0 ? 1 : 0) << i;
    }
    for (const auto& triangle : all_triangles()[static_cast<std::size_t>(inside)]) {
      std::array<std::int32_t, 3> corners;
      for (std::size_t k = 0; k < 3; ++k) corners[k] = vertex_on(x, y, z, triangle[k]);
      mesh_.triangles.push_back(corners);
    }
  }

  // Index of the vertex on an edge of the cube; made the first time.
  std::int32_t vertex_on(int x, int y, int z, int edge) {
    const EdgeEnds ends = ends_of(edge);
    const int axis = edge / 4;
    const int ax = x + (ends.from & 1), ay = y + (ends.from >> 1 & 1), az = z + (ends.from >> 2);
    const int a = corner_at(ax, ay, az);
    const int b = corner_at(x + (ends.to & 1), y + (ends.to >> 1 & 1), z + (ends.to >> 2));
    std::int32_t& local = vertex_[3 * a + axis];
    if (local >= 0) return local;
    const auto on_border = [](int i) { return i == 0 || i == kBlockSide; };
    const bool shared = (axis != 0 && on_border(ax)) || (axis != 1 && on_border(ay)) ||
                        (axis != 2 && on_border(az));
    if (!shared) return local = make_vertex(ax, ay, az, axis, a, b);
    const auto [at, fresh] =
        shared_.try_emplace(EdgePlace{first_.x() + ax, first_.y() + ay, first_.z() + az, axis}, -1);
    if (fresh) at->second = make_vertex(ax, ay, az, axis, a, b);
    return local = at->second;
  }

  std::int32_t make_vertex(int x, int y, int z, int axis, int a, int b) {
    const auto from = static_cast<float>(brick_.distance[a]),
               to = static_cast<float>(brick_.distance[b]);
    const float share = from / (from - to);  // of different sign
    Eigen::Vector3f p = (first_ + BlockPlace(x, y, z)).cast<float>();
    p[axis] += share;
    mesh_.vertices.emplace_back(p * voxel_m_);
    const Rgb &near = brick_.colour[a], &far = brick_.colour[b];
    const auto mix = [share](std::uint8_t u, std::uint8_t v) {
      const auto first = static_cast<float>(u), last = static_cast<float>(v);
      return static_cast<std::uint8_t>(first + (last - first) * share + 0.5F);
    };
    // A voxel off the surface may never have got a colour.
    const bool near_known = !(near == Rgb{}), far_known = !(far == Rgb{});
    const Rgb mixed{mix(near.r, far.r), mix(near.g, far.g), mix(near.b, far.b)};
    mesh_.colours.push_back(near_known && far_known ? mixed : near_known ? near : far);
    return static_cast<std::int32_t>(mesh_.vertices.size()) - 1;
  }

  const VoxelVolume& volume_;
  const MeshOptions& options_;
  float voxel_m_;
  Brick brick_;
  BlockVoxels voxels_;
  std::int32_t vertex_[3 * kCorners];  // by corner and axis of the edge that starts there
  BlockPlace first_ = BlockPlace::Zero();
  std::unordered_map<EdgePlace, std::int32_t, EdgeHash> shared_;
  Mesh mesh_;
};

}  // namespace

OptionSet describe(MeshOptions& options) {
  OptionSet set;
  set.add("least_weight", options.least_weight, "voxels that were seen less are left out", 1, 255);
  return set;
}

Mesh extract_mesh(const VoxelVolume& volume, const MeshOptions& options) {
  return Mesher(volume, options).run();
}

}  // namespace tread
