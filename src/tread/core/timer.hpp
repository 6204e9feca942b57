// Where the time goes: every stage opens one scoped timer named by its path, "stereo/match".
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

namespace tread {

// Times by stage. Not for use by two threads at once: a stage is timed by the thread that calls it.
class Timings {
 public:
  struct Entry {
    std::int64_t calls = 0;
    double total_ms = 0.0;
    double max_ms = 0.0;
    [[nodiscard]] double mean_ms() const {
      return calls == 0 ? 0.0 : total_ms / static_cast<double>(calls);
    }
  };
  void add(std::string_view path, double elapsed_ms);
  [[nodiscard]] const std::map<std::string, Entry, std::less<>>& entries() const {
    return entries_;
  }
  void clear() { entries_.clear(); }

 private:
  std::map<std::string, Entry, std::less<>> entries_;
};

// What every stage is handed besides its input and its options: how many threads it may use (the
// result does not depend on it) and where it reports its time (nowhere if null).
struct Context {
  int threads = 1;
  Timings* timings = nullptr;
};

// ScopedTimer timer(context, "terrain/derivative");
class ScopedTimer {
 public:
  ScopedTimer(const Context& context, std::string_view path)
      : timings_(context.timings), path_(path), start_(std::chrono::steady_clock::now()) {}
  ~ScopedTimer() {
    if (timings_ == nullptr) return;
    const auto elapsed = std::chrono::steady_clock::now() - start_;
    timings_->add(path_, std::chrono::duration<double, std::milli>(elapsed).count());
  }
  ScopedTimer(const ScopedTimer&) = delete;
  ScopedTimer& operator=(const ScopedTimer&) = delete;

 private:
  Timings* timings_;
  std::string_view path_;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace tread
