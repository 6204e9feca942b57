// Paper R's map building, from a pair of images to the cost map, as one object: Fig. 2.
//   images -> rectify -> disparity -> depth -> points -> level -> local height -> local derivative
//   -> global terrain, derivative, explored -> changed cells -> cost
#pragma once

#include <optional>
#include <string>

#include "tread/geometry/rectification.hpp"
#include "tread/geometry/samples.hpp"
#include "tread/pipeline/pose_gate.hpp"
#include "tread/stereo/depth.hpp"
#include "tread/stereo/stereo_matcher.hpp"
#include "tread/terrain/cost_map.hpp"
#include "tread/terrain/global_map.hpp"
#include "tread/terrain/local_map.hpp"

namespace tread {

struct RoverMapOptions {
  PoseGateOptions pose;
  StereoOptions stereo;
  int shrink = 1;  // match images shrunk by this factor: faster, and better where all is blurred
  bool auto_num_disparities = true;  // widen the search to what the first frame needs
  DepthOptions depth{0.8, 6.0};      // paper R: 6 m
  // See farther than depth.max_depth_m where the rig can: as far as a quarter of a pixel is one
  // cell of the map. On paper R's camera (0.12 m baseline, 1024 px wide) that is 6.2 m with its
  // lenses of 3.8 mm and would be 5.1 m with those of 2.5 mm; the paper says 6 m.
  bool extend_range = true;
  // Weigh the points of a cell by how sure their matches are (stereo/uncertainty.hpp).
  bool weigh_points = false;
  LocalMapOptions local;
  GlobalMapOptions global;  // max_map_mib bounds the grid of costs too
  CostOptions cost;
};
[[nodiscard]] OptionSet describe(RoverMapOptions& options);

// What became of one frame on its way; valid until the next one.
struct RoverFrame {
  ImageView<const std::uint8_t> left;  // rectified
  ImageView<const Disparity> disparity;
  ImageView<const float> depth;                        // metres
  const PointCloud* cloud = nullptr;                   // rectified left optical axes
  Isometry3d T_level_points = Isometry3d::Identity();  // from those into the levelled frame
  const Grid<float>* height = nullptr;                 // local, levelled
  const Grid<float>* derivative = nullptr;             // local
  LevelPose pose;
  std::size_t changed_cells = 0;
  // Set if the maps began anew with this frame, and why: the frames before it stood at another
  // place, and were too few to be believed (see PoseGate).
  std::optional<Error> began_anew;
};

class RoverMapper {
 public:
  // Fails if the rig or an option is not sound. A rig without mount is taken as level and at the
  // height of its pose's origin (T_body_left = optical axes at the body's origin).
  [[nodiscard]] static Result<RoverMapper> make(const StereoRig& rig,
                                                const RoverMapOptions& options);

  // Takes one frame into the maps. It must have the rig's image size and a pose (T_world_left) that
  // is a rigid motion and within reach of the frames before it (see PoseGate); otherwise an error
  // that names the frame, and the maps stay as they were. So also where the map would grow beyond
  // global.max_map_mib, and where memory runs out.
  [[nodiscard]] Result<RoverFrame> add(const StereoFrame& frame, const Context& context = {});

  [[nodiscard]] const GlobalMap& ground() const { return ground_; }
  [[nodiscard]] const CostMap& cost() const { return cost_; }
  [[nodiscard]] CostMap& cost() { return cost_; }
  // Frames refused because of where their poses are.
  [[nodiscard]] std::size_t refused_poses() const { return refused_poses_; }
  [[nodiscard]] const RectifiedRig& rig() const { return rig_; }
  [[nodiscard]] bool takes_rectified_images() const { return !rectification_; }
  // With what was set from the rig and the first frame.
  [[nodiscard]] const RoverMapOptions& options() const { return options_; }
  // All layers: height, derivative, explored, cost. Fails only where there is less memory than
  // global.max_map_mib allows.
  [[nodiscard]] Result<MapLayers> layers() const;

 private:
  RoverMapper(const StereoRig& rig, const RoverMapOptions& options);
  [[nodiscard]] static Result<RoverMapper> make_mapper(const StereoRig& full_rig,
                                                       const RoverMapOptions& options);
  [[nodiscard]] Status check_frame(const StereoFrame& frame) const;
  [[nodiscard]] Status check_pose(const StereoFrame& frame, const Isometry3d& T_world_body);
  [[nodiscard]] Result<RoverFrame> take(const StereoFrame& frame, const Context& context);
  void rectify(const StereoFrame& frame, const Context& context);
  [[nodiscard]] Status choose_range(const Context& context);

  RoverMapOptions options_;
  RectifiedRig rig_;
  ImageSize size_;
  std::optional<Rectification> rectification_;         // empty if images come rectified
  Isometry3d T_body_points_ = Isometry3d::Identity();  // rectified left optical axes into body
  Isometry3d T_left_body_ = Isometry3d::Identity();
  bool range_chosen_ = false;

  StereoMatcher matcher_;
  PoseGate gate_;
  std::size_t refused_poses_ = 0;
  std::optional<Error> began_anew_;  // not yet told with a frame
  LocalMapBuilder local_;
  GlobalMap ground_;
  CostMap cost_;

  Image<std::uint8_t> small_left_;
  Image<std::uint8_t> small_right_;
  Image<std::uint8_t> left_;
  Image<std::uint8_t> right_;
  Image<float> depth_;
  PointCloud cloud_;
  std::vector<float> sigma_m_;  // of its points, if they are weighed
  Grid<float> known_heights_;
  Grid<float> derivative_;
};

}  // namespace tread
