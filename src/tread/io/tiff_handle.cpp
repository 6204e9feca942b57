#include "tread/io/tiff_handle.hpp"

#include <fmt/format.h>
#include <tiffio.h>

#include <algorithm>
#include <array>
#include <cstdarg>
#include <cstdio>
#include <system_error>

namespace tread {
namespace {

namespace fs = std::filesystem;

int keep_first_error(TIFF* /*handle*/, void* first_error, const char* /*module*/,
                     const char* format, va_list arguments) {
  auto& text = *static_cast<std::string*>(first_error);
  if (text.empty()) {
    std::array<char, 300> printed{};
    std::vsnprintf(printed.data(), printed.size(), format, arguments);
    text = printed.data();
    while (!text.empty() && (text.back() == '.' || text.back() == '\n')) text.pop_back();
  }
  return 1;  // handled: libtiff prints nothing
}

// libtiff warns of harmless things, as tags it does not know, and of files that are cut off or
// whose strips do not fit the picture, of which it then guesses. Those are errors here.
int sort_warning(TIFF* handle, void* first_error, const char* module, const char* format,
                 va_list arguments) {
  const std::string_view text(format);
  const bool is_error = text.find("IO error") != std::string_view::npos ||
                        text.find("Bogus") != std::string_view::npos;
  return is_error ? keep_first_error(handle, first_error, module, format, arguments) : 1;
}

// For this file only. The kinds of count are those that libgeotiff expects.
void register_tags(TIFF* handle) {
  const auto field = [](std::uint32_t tag, TIFFDataType type, unsigned char passes_count,
                        const char* name) {
    return TIFFFieldInfo{tag, TIFF_VARIABLE, TIFF_VARIABLE,          type, FIELD_CUSTOM,
                         1,   passes_count,  const_cast<char*>(name)};  // libtiff only reads it
  };
  const std::array<TIFFFieldInfo, 7> fields = {
      {field(kTagPixelScale, TIFF_DOUBLE, 1, "GeoPixelScale"),
       field(kTagTiePoints, TIFF_DOUBLE, 1, "GeoTiePoints"),
       field(kTagTransformation, TIFF_DOUBLE, 1, "GeoTransformationMatrix"),
       field(kTagGeoKeys, TIFF_SHORT, 1, "GeoKeyDirectory"),
       field(kTagGeoDoubles, TIFF_DOUBLE, 1, "GeoDoubleParams"),
       field(kTagGeoTexts, TIFF_ASCII, 0, "GeoASCIIParams"),
       field(kTagNoData, TIFF_ASCII, 0, "GDALNoDataValue")}};
  TIFFMergeFieldInfo(handle, fields.data(), static_cast<std::uint32_t>(fields.size()));
}

// The values of a tag as libtiff holds them: it reads tags it does not know as arrays.
template <class T>
std::vector<T> values_of(TIFF* handle, std::uint32_t tag, TIFFDataType type) {
  const TIFFField* field = TIFFFindField(handle, tag, TIFF_ANY);
  if (field == nullptr || TIFFFieldDataType(field) != type) return {};
  const void* data = nullptr;
  std::size_t count = 0;
  if (TIFFFieldPassCount(field) == 0) {
    // Registered by somebody else in this process as a plain text.
    if (type != TIFF_ASCII || TIFFGetField(handle, tag, &data) == 0) return {};
    count = std::string_view(static_cast<const char*>(data)).size();
  } else if (TIFFFieldReadCount(field) == TIFF_VARIABLE2) {
    std::uint32_t wide = 0;
    if (TIFFGetField(handle, tag, &wide, &data) == 0) return {};
    count = wide;
  } else {
    std::uint16_t narrow = 0;
    if (TIFFGetField(handle, tag, &narrow, &data) == 0) return {};
    count = narrow;
  }
  const T* first = static_cast<const T*>(data);
  return first == nullptr ? std::vector<T>{} : std::vector<T>(first, first + count);
}

}  // namespace

bool TiffHandle::has_error() const {
  return !first_error_->empty();
}

void TiffHandle::Close::operator()(tiff* handle) const {
  TIFFClose(handle);
}

bool TiffHandle::open_as(const fs::path& path, const char* mode) {
  first_error_ = std::make_unique<std::string>();
  opened_ = path.string();
  const std::unique_ptr<TIFFOpenOptions, decltype(&TIFFOpenOptionsFree)> options(
      TIFFOpenOptionsAlloc(), &TIFFOpenOptionsFree);
  TIFFOpenOptionsSetErrorHandlerExtR(options.get(), keep_first_error, first_error_.get());
  TIFFOpenOptionsSetWarningHandlerExtR(options.get(), sort_warning, first_error_.get());
  // What libtiff takes for itself: tables and packed strips, which are parts of the file.
  constexpr std::size_t kLeast = std::size_t{1} << 26;
  TIFFOpenOptionsSetMaxSingleMemAlloc(
      options.get(), static_cast<tmsize_t>(std::max(kLeast, file_bytes_ + kLeast)));
  tiff_.reset(TIFFOpenExt(path.c_str(), mode, options.get()));
  return tiff_ != nullptr;
}

Result<TiffHandle> TiffHandle::create(const fs::path& path, const std::string& where, bool large) {
  TiffHandle handle;
  handle.where_ = where;
  if (!handle.open_as(path, large ? "w8" : "w")) {
    return handle.error(ErrorCode::kWriteFailed, "cannot be created",
                        "Check that the folder exists, is writable and has space");
  }
  register_tags(handle.get());
  return handle;
}

Result<TiffHandle> TiffHandle::open(const fs::path& path) {
  TiffHandle handle;
  handle.where_ = path.string();
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) {
    return handle.error(ErrorCode::kNotFound, "no such file", "Check the name");
  }
  if (!fs::is_regular_file(status)) {
    return handle.error(ErrorCode::kUnreadable, "this is not a regular file",
                        "Give the name of a file");
  }
  handle.file_bytes_ = static_cast<std::size_t>(fs::file_size(path, error));
  // m: not mapped into memory, where a file that shrinks while it is read ends the process.
  if (error || !handle.open_as(path, "rm")) {
    return handle.error(ErrorCode::kUnreadable, "cannot be opened",
                        "Check that this is a TIFF file and is complete");
  }
  return handle;
}

std::vector<double> TiffHandle::doubles(std::uint32_t tag) const {
  return values_of<double>(get(), tag, TIFF_DOUBLE);
}

std::vector<std::uint16_t> TiffHandle::shorts(std::uint32_t tag) const {
  return values_of<std::uint16_t>(get(), tag, TIFF_SHORT);
}

std::string TiffHandle::text(std::uint32_t tag) const {
  const std::vector<char> bytes = values_of<char>(get(), tag, TIFF_ASCII);
  return {bytes.begin(), std::find(bytes.begin(), bytes.end(), '\0')};
}

tl::unexpected<Error> TiffHandle::error(ErrorCode code, const std::string& otherwise,
                                        const std::string& remedy) const {
  std::string reason = first_error_ == nullptr ? std::string() : *first_error_;
  // libtiff begins with the name of the file, which the message has already.
  if (reason.starts_with(opened_ + ": ")) reason.erase(0, opened_.size() + 2);
  return fail(code, reason.empty() ? otherwise : fmt::format("{} ({})", otherwise, reason), where_,
              remedy);
}

Status TiffHandle::finish_writing() {
  const bool flushed = TIFFFlush(get()) != 0;
  tiff_.reset();
  if (flushed && first_error_->empty()) return {};
  return error(ErrorCode::kWriteFailed, "cannot be written",
               "Check that the folder is writable and has space");
}

}  // namespace tread
