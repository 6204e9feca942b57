// Disparity and depth of a rectified pair, and how much of it is known.
//   depth_of_a_pair left.png right.png rig.yaml
#include <iostream>

#include "tread/io/image_file.hpp"
#include "tread/io/raster_file.hpp"
#include "tread/io/rig_file.hpp"
#include "tread/stereo/depth.hpp"
#include "tread/stereo/stereo_matcher.hpp"

namespace {

int complain(const tread::Error& error) {
  std::cerr << error.message() << '\n';
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::cerr << "usage: depth_of_a_pair LEFT RIGHT RIG\n";
    return 2;
  }
  const auto left = tread::read_grey(argv[1]);
  if (!left) return complain(left.error());
  const auto right = tread::read_grey(argv[2]);
  if (!right) return complain(right.error());
  const auto rig = tread::read_rig(argv[3], {left->width, left->height});
  if (!rig) return complain(rig.error());
  const auto rectified = tread::rectified_rig(*rig);  // see make_rectification for other rigs
  if (!rectified) return complain(rectified.error());

  tread::StereoMatcher matcher;
  const auto disparity = matcher.match(*left, *right, {});
  if (!disparity) return complain(disparity.error());
  tread::Image<float> depth;
  tread::depth_image(*disparity, *rectified, {0.0, 100.0}, depth);

  std::cout << 100.0 * tread::disparity_density(*disparity) << " % of the pixels have a depth\n";
  const tread::Status written = tread::write_tiff("depth.tif", depth);
  return written ? 0 : complain(written.error());
}
