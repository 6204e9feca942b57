#include "tread/slam/depth_slam.hpp"

namespace tread {

OptionSet describe(SlamOptions& options) {
  OptionSet set;
  set.add_group("volume", describe(options.volume));
  set.add_group("integrate", describe(options.integrate));
  set.add_group("align", describe(options.align));
  set.add_group("noise", describe(options.noise));
  set.add("window_ahead_m", options.window_ahead_m,
          "where the middle of the volume's window is, ahead of the camera, m", 0.0, 100.0);
  set.add("turn_first", options.turn_first, "start from the turn that fits the images best");
  set.add("speed_sigma_m_per_s", options.speed_sigma_m_per_s,
          "how far the motion may differ from going on as before, m/s", 1e-3, 100.0);
  set.add("turn_sigma_rad_per_s", options.turn_sigma_rad_per_s, "and the turn, rad/s", 1e-3, 100.0);
  set.add("least_matched", options.least_matched,
          "lost if a smaller part of the frame meets the surface", 0.0, 1.0);
  set.add("largest_rms", options.largest_rms, "lost if residuals are larger, in sigma", 0.1, 1e3);
  set.add("least_matched_again", options.least_matched_again,
          "the same after it was lost, to be believed", 0.0, 1.0);
  set.add("largest_rms_again", options.largest_rms_again, "and of residuals", 0.1, 1e3);
  set.add("largest_grey_again", options.largest_grey_again,
          "and of the mean difference of intensities", 0.1, 255.0);
  set.add("key_matched", options.key_matched,
          "a new keyframe if a smaller part of the old one is in view", 0.0, 1.0);
  set.add("key_turn_deg", options.key_turn_deg, "or after a turn of so much, degrees", 0.0, 180.0);
  set.add("key_way", options.key_way, "or after so much way, part of the mean depth", 0.0, 10.0);
  set.add("least_intensity_share", options.least_intensity_share,
          "of the weight of intensities that is left where depth says otherwise", 0.0, 1.0);
  set.add("photo_points", options.photo_points, "points of a keyframe, at most", 100, 1'000'000);
  set.add_group("loop", describe(options.loop));
  return set;
}

const char* name_of(TrackStatus status) {
  switch (status) {
    case TrackStatus::kFirst:
      return "first";
    case TrackStatus::kTracked:
      return "tracked";
    case TrackStatus::kHeld:
      return "held";
    case TrackStatus::kUnobservable:
      return "unobservable";
    case TrackStatus::kLost:
      return "lost";
  }
  return "";
}

}  // namespace tread
