#include "tread/core/timer.hpp"

#include <algorithm>

namespace tread {

void Timings::add(std::string_view path, double elapsed_ms) {
  auto found = entries_.find(path);
  if (found == entries_.end()) found = entries_.emplace(std::string(path), Entry{}).first;
  Entry& entry = found->second;
  ++entry.calls;
  entry.total_ms += elapsed_ms;
  entry.max_ms = std::max(entry.max_ms, elapsed_ms);
}

}  // namespace tread
