#include "open_pairs.hpp"

#include "tread/sim/named_courses.hpp"
#include "tread/sim/simulated_source.hpp"

namespace tread {
namespace {

constexpr std::string_view kSimulated = "sim:";

}  // namespace

bool is_simulated(const std::string& source) {
  return source.starts_with(kSimulated);
}

Result<std::unique_ptr<StereoSource>> open_pairs(const std::string& source,
                                                 const SourceOptions& options,
                                                 const Context& context) {
  if (!is_simulated(source)) return open_stereo_source(source, options);
  if (!options.rig.empty() || !options.poses.empty()) {
    return fail(ErrorCode::kBadArgument, "a simulated course brings its own cameras and poses",
                source, "Leave --rig and --poses out");
  }
  const auto course = find_course(source.substr(kSimulated.size()));
  if (!course) return forward(course);
  return open_simulated_source(*course, rover_setup(), {}, context);
}

}  // namespace tread
