// `tread info` of text files: waypoints, trajectories, times, maps for Nav2, reports.
#pragma once

#include <filesystem>
#include <optional>

#include "command.hpp"

namespace tread {

// What the file is, by its first lines; nothing if it is none of these kinds.
[[nodiscard]] std::optional<Status> info_text(const std::filesystem::path& path, Output& output);

// "kind: rest", and the kind for --json.
void say_kind(const std::string& kind, const std::string& rest, Output& output);

}  // namespace tread
