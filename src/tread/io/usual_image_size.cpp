#include "tread/io/usual_image_size.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "tread/io/image_file.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;

// Votes of images for a size; of equally many the one that came first.
class SizeVotes {
 public:
  void add(ImageSize size) {
    const auto known = std::find_if(votes_.begin(), votes_.end(),
                                    [size](const auto& vote) { return vote.first == size; });
    if (known == votes_.end()) {
      votes_.emplace_back(size, 1);
    } else {
      ++known->second;
    }
  }
  [[nodiscard]] std::optional<ImageSize> most() const {
    const auto found =
        std::max_element(votes_.begin(), votes_.end(),
                         [](const auto& a, const auto& b) { return a.second < b.second; });
    return found == votes_.end() ? std::nullopt : std::optional(found->first);
  }

 private:
  std::vector<std::pair<ImageSize, int>> votes_;
};

}  // namespace

Result<ImageSize> usual_image_size(const std::vector<std::vector<fs::path>>& frames) {
  constexpr std::size_t kAsked = 9;
  const std::size_t count = frames.size();
  SizeVotes votes;
  for (std::size_t i = 0; i < std::min(kAsked, count); ++i) {
    for (const fs::path& path : frames[count <= kAsked ? i : i * (count - 1) / (kAsked - 1)]) {
      if (const auto size = read_image_size(path)) votes.add(*size);
    }
  }
  if (const auto most = votes.most()) return *most;
  std::optional<Error> first;
  for (const std::vector<fs::path>& images : frames) {
    if (images.empty()) continue;
    const auto size = read_image_size(images.front());
    if (size) return *size;
    if (!first) first = size.error();
  }
  if (first) return tl::unexpected<Error>(*first);
  return fail(ErrorCode::kNotFound, "there are no images", "", "Give a folder with images");
}

}  // namespace tread
