#include "tread/sim/random.hpp"

#include <cmath>
#include <numbers>

namespace tread {
namespace {

// Keys of streams and the numbers in them must not be of one series: stream(n) of a seed would
// begin where the seed's own numbers go on.
constexpr std::uint64_t kStreams = 0x6a09e667f3bcc909ULL;

}  // namespace

Random Random::stream(std::uint64_t number) const {
  return Random(mix(mix(key_ ^ kStreams) + number * kStep));
}

Random Random::stream(std::string_view name) const {
  std::uint64_t hash = 0xcbf29ce484222325ULL;  // FNV-1a
  for (const char c : name) {
    hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  }
  return stream(hash);
}

double Random::normal() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_;
  }
  const double radius = std::sqrt(2.0 * exponential());
  const double angle = 2.0 * std::numbers::pi * uniform();
  spare_ = radius * std::sin(angle);
  has_spare_ = true;
  return radius * std::cos(angle);
}

double Random::exponential() {
  return -std::log1p(-uniform());  // of 0 < 1 - x <= 1
}

}  // namespace tread
