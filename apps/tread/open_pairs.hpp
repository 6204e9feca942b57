// Sources of pairs, as the commands name them.
#pragma once

#include <memory>
#include <string>

#include "tread/core/timer.hpp"
#include "tread/io/source.hpp"

namespace tread {

// "sim:COURSE": a rover that is carried over a course, simulated as frames are asked for.
[[nodiscard]] bool is_simulated(const std::string& source);

// A folder, or a simulated course.
[[nodiscard]] Result<std::unique_ptr<StereoSource>> open_pairs(const std::string& source,
                                                               const SourceOptions& options,
                                                               const Context& context);

}  // namespace tread
