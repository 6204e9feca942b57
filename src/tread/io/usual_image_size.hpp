// The size of a drive's images, where its calibration does not name one.
#pragma once

#include <filesystem>
#include <vector>

#include "tread/core/result.hpp"
#include "tread/geometry/camera.hpp"

namespace tread {

// The size that most images have, of up to nine frames spread over the drive: one odd image shall
// not speak for the others. Each frame names its images, or none. If none of those nine can be
// read, the size of the first frame that can; if there is none, the error of the first.
[[nodiscard]] Result<ImageSize> usual_image_size(
    const std::vector<std::vector<std::filesystem::path>>& frames);

}  // namespace tread
