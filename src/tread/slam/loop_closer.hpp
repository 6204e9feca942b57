// Internal to slam: places seen again, and the path that they correct. Keyframes are the poses of a
// graph; each is remembered by its corners and its depth image. A keyframe that shows a place not
// seen lately is fitted to it, by corners, then by depth; where the path says otherwise, the graph
// is brought into agreement and the surface is made anew from the depth images.
//
// Keyframes are kept only where there is none yet, so that memory goes with the places seen, not
// with time.
#pragma once

#include <map>
#include <memory>
#include <optional>

#include "tread/slam/compare_views.hpp"
#include "tread/slam/frame_path.hpp"
#include "tread/slam/integrate.hpp"
#include "tread/slam/keyframe_store.hpp"
#include "tread/slam/loop_options.hpp"

namespace tread {

// What the rest of DepthSlam does with a keyframe, and what it takes of that.
struct LoopSetup {
  LoopOptions loop;
  DepthNoise noise;
  AlignOptions align;
  double voxel_m = 0.01;
  double farthest_m = 5.0;
  double near_way = 0.07;  // part of the mean depth: so near to each other one keyframe will do
  double near_rad = 0.12;
};

struct LoopFrame {
  const AlignFrame& frame;    // with its image
  ImageView<const Rgb> rgb;   // empty, of the size of the depth at hand, or of twice that
  Isometry3d T_world_camera;  // as tracked
};

class LoopCloser {
 public:
  explicit LoopCloser(const LoopSetup& setup) : setup_(setup), places_(setup.loop.places) {}

  // Every frame that was not lost, before keyframe(); `covariance` is of its motion.
  void follow(const Isometry3d& T_world_camera, const Matrix6d& covariance);
  // The frame followed last is a keyframe. The pose to go on from, if a loop was closed by it: all
  // poses have moved then.
  std::optional<Isometry3d> keyframe(const LoopFrame& in, const Context& context);
  // The frame followed last takes part in the map; after keyframe().
  void map(std::int64_t stamp_ns);

  struct Found {
    std::int64_t place = 0;
    Isometry3d T_world_camera = Isometry3d::Identity();
  };
  // Where a lost camera may be. As strict as for loops.
  [[nodiscard]] std::optional<Found> find(const LoopFrame& in, const Context& context) const;
  // A lost camera was found there, by this place (of find(), or the one of anchor()); instead of
  // follow().
  void go_on_from(std::int64_t place, const Isometry3d& T_world_camera, const Matrix6d& covariance);

  // The keyframe that poses hang on now; FramePath::kWorld before the first.
  [[nodiscard]] std::int64_t anchor() const { return reference_; }
  // What the loop closed last moved an anchor by, from the left; of one that is no longer there,
  // the one before it.
  [[nodiscard]] Isometry3d correction_of(std::int64_t anchor) const;

  // Fuses all keyframes into an empty volume whose window is centred as far ahead of the camera.
  void fuse_all(const Pinhole& camera, double ahead_m, const IntegrateOptions& options,
                VoxelVolume& volume, Integrator& integrator, const Context& context) const;

  [[nodiscard]] Trajectory trajectory() const;
  [[nodiscard]] int loops() const { return loops_; }
  [[nodiscard]] std::size_t size() const { return graph_.nodes().size(); }
  [[nodiscard]] std::size_t bytes() const;

 private:
  struct Node {
    std::int64_t last_seen = 0;  // keyframe count
    int frames = 0;              // that were mapped from here on
  };
  struct Seen {
    std::int64_t place = 0;
    ViewPose pose;
  };
  [[nodiscard]] bool is_near(const Isometry3d& T_here, double mean_depth_m) const;
  [[nodiscard]] bool lately(std::int64_t id) const;
  [[nodiscard]] std::optional<std::int64_t> near_and_lately(const Isometry3d& T_world_camera,
                                                            double mean_depth_m) const;
  // `depth`: of what shows `view`; images are not compared but by corners.
  [[nodiscard]] std::optional<Seen> compare(const AlignFrame& depth, const PlaceView& view,
                                            std::int64_t place, const Isometry3d& guess,
                                            const Context& context) const;
  [[nodiscard]] bool read_levels(std::int64_t place, const Pinhole& camera,
                                 std::array<DepthLevel, 3>& levels, const Context& context) const;
  [[nodiscard]] std::optional<Seen> see_again(const LoopFrame& in, const PlaceView& view,
                                              const Context& context) const;
  std::optional<std::int64_t> add_node(const LoopFrame& in, const PlaceView& view);
  [[nodiscard]] PoseEdge odometry_to(std::int64_t id) const;
  [[nodiscard]] PoseEdge loop_to(std::int64_t id, const Seen& seen, double mean_depth_m) const;
  // `last`: from where on back the path is measured again.
  bool close(const PoseEdge& loop, std::int64_t last, const Context& context);
  bool close_to_place(const LoopFrame& in, const PlaceView& view, const Seen& seen,
                      const Context& context);
  void measure_again(std::int64_t last, PoseGraph& graph, const Context& context) const;
  [[nodiscard]] std::int64_t existing(std::int64_t anchor) const;
  void refer_to(std::int64_t id, const Isometry3d& T_id_camera);
  void thin_out();
  [[nodiscard]] double shift_of(const Isometry3d& T, double mean_depth_m) const;

  LoopSetup setup_;
  PlaceMemory places_;
  PoseGraph graph_;
  std::unique_ptr<KeyframeStore> store_;  // made for the first keyframe
  std::map<std::int64_t, Node> nodes_;
  std::map<std::int64_t, Isometry3d> corrections_;  // by the loop closed last
  FramePath path_;
  std::int64_t reference_ = FramePath::kWorld;
  bool bridge_ = false;  // the way from the reference was not followed, but found
  Isometry3d T_world_ = Isometry3d::Identity();           // of the last frame
  Isometry3d T_reference_here_ = Isometry3d::Identity();  // as followed since
  Matrix6d covariance_ = Matrix6d::Zero();                // of that
  double way_m_ = 0.0, turn_rad_ = 0.0;
  bool followed_ = false;
  double mean_depth_m_ = 1.0;
  std::int64_t count_ = 0, next_id_ = 0;
  int loops_ = 0;
};

}  // namespace tread
