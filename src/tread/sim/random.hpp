// Random numbers of the simulation: the same on every machine, whatever the order in which parts
// of it ask. Number n of a stream is a hash of the stream's key and n (SplitMix64: Steele, Lea,
// Flood 2014, with Stafford's mix 13), so that nothing is carried along but a count. The
// distributions are our own, as those of <random> differ between libraries; normal() and
// exponential() go through libm, whose last bit may differ between machines.
#pragma once

#include <cstdint>
#include <string_view>

namespace tread {

class Random {
 public:
  explicit Random(std::uint64_t seed) : key_(seed) {}

  // A stream of its own, by name or number: depends on the seed and the names on the way to it, not
  // on what was drawn before. Each sensor, and each purpose in it, has one, so that one that draws
  // more does not change the others.
  [[nodiscard]] Random stream(std::string_view name) const;
  [[nodiscard]] Random stream(std::uint64_t number) const;

  [[nodiscard]] std::uint64_t bits64() { return mix(key_ + ++count_ * kStep); }
  [[nodiscard]] std::uint32_t bits() { return static_cast<std::uint32_t>(bits64() >> 32); }
  // 0 <= x < 1, in steps of 2^-53.
  [[nodiscard]] double uniform() { return static_cast<double>(bits64() >> 11) * 0x1p-53; }
  [[nodiscard]] double uniform(double low, double high) { return low + (high - low) * uniform(); }
  // Mean 0, standard deviation 1 (Box, Muller 1958); at most 8.6 away from 0. About 20 ns.
  [[nodiscard]] double normal();
  // Mean 1: the time until something that happens once in a unit of time.
  [[nodiscard]] double exponential();

 private:
  static constexpr std::uint64_t kStep = 0x9e3779b97f4a7c15ULL;
  [[nodiscard]] static constexpr std::uint64_t mix(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
  }

  std::uint64_t key_;
  std::uint64_t count_ = 0;
  double spare_ = 0.0;  // Box and Muller make two numbers at a time
  bool has_spare_ = false;
};

}  // namespace tread
