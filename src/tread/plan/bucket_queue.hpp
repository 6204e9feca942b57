// The open list of a best-first search: a ring of buckets by cost. Within a bucket the last entry
// pushed comes first, until order() is called; from then on the bucket in use is a heap and entries
// come in exact order of their estimates. Made for searches in which no entry is pushed with a cost
// below the one last taken, nor further above it than the ring spans; others land in the nearest
// bucket, which may take them out of order but loses none.
// Cost: O(1) a push and a pop, once ordered O(log of the entries of one bucket).
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tread {

struct QueueEntry {
  double estimate = 0.0;
  std::int32_t x = 0;
  std::int32_t y = 0;
};

class BucketQueue {
 public:
  // All finite. Buckets of `width`, wider if more than kMostBuckets were needed to hold entries
  // that lie up to `span` apart; the first entry is expected at `base`.
  BucketQueue(double base, double width, double span) : base_(base) {
    width_ = std::max(width, span / (kMostBuckets - 3));
    per_width_ = 1.0 / width_;
    buckets_.resize(std::bit_ceil(static_cast<std::size_t>(span * per_width_) + 3));
    mask_ = static_cast<std::int64_t>(buckets_.size()) - 1;
  }

  void push(const QueueEntry& entry) {
    const double place = std::clamp((entry.estimate - base_) * per_width_, 0.0, kFarthest);
    const std::int64_t step =
        std::clamp<std::int64_t>(static_cast<std::int64_t>(place) - current_, 0, mask_);
    std::vector<QueueEntry>& bucket = bucket_at(current_ + step);
    bucket.push_back(entry);
    if (ordered_ && step == 0) std::push_heap(bucket.begin(), bucket.end(), after);
    ++size_;
  }

  // The queue must not be empty.
  [[nodiscard]] QueueEntry pop() {
    if (bucket_at(current_).empty()) {
      while (bucket_at(current_).empty()) ++current_;
      if (ordered_) order();
    }
    std::vector<QueueEntry>& bucket = bucket_at(current_);
    if (ordered_) std::pop_heap(bucket.begin(), bucket.end(), after);
    const QueueEntry entry = bucket.back();
    bucket.pop_back();
    --size_;
    return entry;
  }
  [[nodiscard]] bool empty() const { return size_ == 0; }

  void order() {
    ordered_ = true;
    std::make_heap(bucket_at(current_).begin(), bucket_at(current_).end(), after);
  }
  [[nodiscard]] bool ordered() const { return ordered_; }
  [[nodiscard]] double width() const { return width_; }

 private:
  static constexpr int kMostBuckets = 4096;
  static constexpr double kFarthest = 1e18;  // still a whole number of 64 bits

  [[nodiscard]] std::vector<QueueEntry>& bucket_at(std::int64_t place) {
    return buckets_[static_cast<std::size_t>(place & mask_)];
  }

  // By place where estimates are equal: their order must not hang on the library's heap.
  [[nodiscard]] static bool after(const QueueEntry& a, const QueueEntry& b) {
    if (a.estimate != b.estimate) return a.estimate > b.estimate;
    return a.y != b.y ? a.y > b.y : a.x > b.x;
  }

  double base_;
  double width_ = 1.0;
  double per_width_ = 1.0;
  std::vector<std::vector<QueueEntry>> buckets_;
  std::int64_t mask_ = 0;
  std::int64_t current_ = 0;  // counts on for ever; the bucket is current_ modulo the ring
  std::size_t size_ = 0;
  bool ordered_ = false;
};

}  // namespace tread
