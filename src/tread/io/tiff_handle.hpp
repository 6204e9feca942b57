// A TIFF file open in libtiff whose messages go into an Error and not to stderr, and which knows
// the tags of GeoTIFF and GDAL. Nothing global is changed, as libgeotiff's own XTIFFOpen would.
// For the sources of io; of libtiff it shows one name.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "tread/core/result.hpp"

struct tiff;

namespace tread {

// Tags of GeoTIFF 1.1 and of GDAL.
inline constexpr std::uint32_t kTagPixelScale = 33550;
inline constexpr std::uint32_t kTagTiePoints = 33922;
inline constexpr std::uint32_t kTagTransformation = 34264;
inline constexpr std::uint32_t kTagGeoKeys = 34735;
inline constexpr std::uint32_t kTagGeoDoubles = 34736;
inline constexpr std::uint32_t kTagGeoTexts = 34737;
inline constexpr std::uint32_t kTagNoData = 42113;

class TiffHandle {
 public:
  // Creates the file; `where` is its name in messages. `large` chooses BigTIFF, beyond 4 GB.
  [[nodiscard]] static Result<TiffHandle> create(const std::filesystem::path& path,
                                                 const std::string& where, bool large);
  // Opens a regular file and reads its first directory. Where a part of that could not be read,
  // has_error() says so.
  [[nodiscard]] static Result<TiffHandle> open(const std::filesystem::path& path);

  [[nodiscard]] tiff* get() const { return tiff_.get(); }
  [[nodiscard]] const std::string& where() const { return where_; }
  [[nodiscard]] std::size_t file_bytes() const { return file_bytes_; }

  [[nodiscard]] bool has_error() const;

  // The values of a tag that libtiff itself does not know; empty if it is not there or of another
  // type.
  [[nodiscard]] std::vector<double> doubles(std::uint32_t tag) const;
  [[nodiscard]] std::vector<std::uint16_t> shorts(std::uint32_t tag) const;
  [[nodiscard]] std::string text(std::uint32_t tag) const;

  // libtiff's first message as an error of this file, or `otherwise` if there was none.
  [[nodiscard]] tl::unexpected<Error> error(ErrorCode code, const std::string& otherwise,
                                            const std::string& remedy) const;
  // Writes what is left and closes; only then is it known whether everything was written.
  [[nodiscard]] Status finish_writing();

 private:
  struct Close {
    void operator()(tiff* handle) const;
  };
  TiffHandle() = default;
  [[nodiscard]] bool open_as(const std::filesystem::path& path, const char* mode);

  std::string where_;
  std::string opened_;  // the path given to libtiff, which may be a temporary one
  std::size_t file_bytes_ = 0;
  std::unique_ptr<std::string> first_error_;  // on the heap: libtiff holds its address
  std::unique_ptr<tiff, Close> tiff_;
};

}  // namespace tread
