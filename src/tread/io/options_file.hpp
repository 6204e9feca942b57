// Options from YAML: nested keys are the paths of the described fields.
//   stereo:
//     sad: {window_width_px: 15, num_disparities: 128}
//   cost:
//     knots: "0.04:1 0.16:20 0.64:100"
#pragma once

#include <filesystem>
#include <string>

#include "tread/core/options.hpp"
#include "tread/core/result.hpp"

namespace tread {

// Sets every field the file names, and settles the set; the others keep their values. An unknown
// key, a value out of range or of another kind is an error that names file, line and key, with the
// nearest known name; the fields before it are then already set.
[[nodiscard]] Status read_options(const std::filesystem::path& path, OptionSet& options);
[[nodiscard]] inline Status read_options(const std::filesystem::path& path, OptionSet&& options) {
  return read_options(path, options);
}

// All fields with their values, meanings and ranges as comments: what read_options reads back.
[[nodiscard]] std::string options_as_yaml(const OptionSet& options);

}  // namespace tread
