// Depth images of keyframes and what they look like, kept so that the surface can be made anew when
// the path is corrected. Depths are rounded to a quarter of their noise (more coarsely where the
// range asks for more than 65535 such steps), their differences along a row take a byte or two
// each; colours are JPEG. Memory first, then an unnamed temporary file, each with a cap that is
// never passed.
#pragma once

#include <cstdint>
#include <cstdio>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "tread/core/image.hpp"
#include "tread/slam/depth_noise.hpp"

namespace tread {

struct StoredKeyframe {
  Image<float> depth;  // metres, NaN where unknown
  Image<Rgb> rgb;      // empty, or of the size of depth
  Image<std::uint8_t> grey;
};

class KeyframeStore {
 public:
  // Depths up to farthest_m are kept. Where no file can be had or written, memory has to do.
  KeyframeStore(const DepthNoise& noise, double farthest_m, std::size_t memory_bytes,
                std::size_t file_bytes);

  // False, and nothing is kept, if there is no room left or the id is there already. Of colour and
  // grey, either may be empty; both of other sizes than depth are left out.
  bool put(std::int64_t id, ImageView<const float> depth, ImageView<const Rgb> rgb,
           ImageView<const std::uint8_t> grey);
  // False if there is none of that id, or the file cannot be read back.
  [[nodiscard]] bool get(std::int64_t id, StoredKeyframe& keyframe) const;
  void remove(std::int64_t id);
  void clear();

  [[nodiscard]] std::size_t size() const { return records_.size(); }
  // At most what the store was made with.
  [[nodiscard]] std::size_t memory_bytes() const { return memory_.size() * kPageBytes; }
  [[nodiscard]] std::size_t file_bytes() const { return file_pages_ * kPageBytes; }

  static constexpr std::size_t kPageBytes = 8192;

 private:
  using Page = std::vector<std::uint8_t>;
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  struct Record {
    std::vector<std::size_t> pages;
    std::size_t bytes = 0;
    std::size_t depth_bytes = 0;  // then the colour
    int width = 0, height = 0;
    bool coloured = false;
  };
  [[nodiscard]] bool write_pages(std::span<const std::uint8_t> bytes, Record& record);
  [[nodiscard]] bool write_page(std::size_t page, std::span<const std::uint8_t> bytes);
  [[nodiscard]] bool read_pages(const Record& record, std::vector<std::uint8_t>& bytes) const;
  void encode_depth(ImageView<const float> depth, std::vector<std::uint8_t>& bytes) const;
  [[nodiscard]] bool decode_depth(std::span<const std::uint8_t> bytes, Image<float>& depth) const;

  double root_ = 0.0, scale_ = 1.0;  // code = scale atan(root z), or scale z where root is 0
  std::vector<float> depth_of_code_;
  std::size_t most_memory_pages_, most_file_pages_;
  std::unique_ptr<std::FILE, Close> file_;
  std::vector<Page> memory_;
  std::size_t file_pages_ = 0;     // the file has had
  std::vector<std::size_t> free_;  // a heap, the lowest page first: memory before the file
  std::map<std::int64_t, Record> records_;
};

}  // namespace tread
