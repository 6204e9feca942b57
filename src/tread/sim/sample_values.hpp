// What faults do to the values of a sample, one function a kind of sample.
#pragma once

#include <cstdint>

#include "tread/geometry/samples.hpp"

namespace tread {

// All but the stamp.
template <class Sample>
void copy_values(const Sample& from, Sample& into) {
  const std::int64_t stamp_ns = into.stamp_ns;
  into = from;
  into.stamp_ns = stamp_ns;
}
// The images; name, pose and samples of the IMU are not of the camera.
void copy_values(const StereoFrame& from, StereoFrame& into);

// Clips each value to `share` of its range, which is that of `full_scale` both ways; a range of 0
// is not known and clips nothing. Rates and accelerations; currents; velocities, torques and
// forces; pixels, whose range is always 255.
void clip_values(ImuSample& sample, const ImuSample& full_scale, double share);
void clip_values(WheelSample& sample, const WheelSample& full_scale, double share);
void clip_values(LegSample& sample, const LegSample& full_scale, double share);
void clip_values(StereoFrame& frame, const StereoFrame& full_scale, double share);
// Of these nothing is clipped; check_faults refuses to ask for it.
inline void clip_values(GnssFix&, const GnssFix&, double) {}
inline void clip_values(HeadState&, const HeadState&, double) {}
inline void clip_values(BumpEvent&, const BumpEvent&, double) {}

}  // namespace tread
