#include "tread/io/append_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

namespace tread::internal {
namespace {

constexpr std::size_t kBuffer = std::size_t{1} << 16;

tl::unexpected<Error> cannot_write(const std::string& where, int error_number) {
  const std::string reason = std::error_code(error_number, std::generic_category()).message();
  return fail(ErrorCode::kWriteFailed, fmt::format("cannot write: {}", reason), where,
              "Check that the folder is writable and has space");
}

}  // namespace

Result<AppendFile> AppendFile::create(const std::filesystem::path& path, std::string where) {
  const int descriptor =
      ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, mode_t{0666});
  if (descriptor < 0) return cannot_write(where, errno);
  return AppendFile(descriptor, std::move(where));
}

AppendFile::AppendFile(AppendFile&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)),
      where_(std::move(other.where_)),
      buffer_(std::move(other.buffer_)) {}

AppendFile::~AppendFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Status AppendFile::append(std::string_view bytes) {
  buffer_ += bytes;
  return buffer_.size() < kBuffer ? Status{} : flush();
}

Status AppendFile::flush() {
  std::string_view left = buffer_;
  while (!left.empty()) {
    const ssize_t count = ::write(descriptor_, left.data(), left.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return cannot_write(where_, errno);
    left.remove_prefix(static_cast<std::size_t>(count));
  }
  buffer_.clear();
  return {};
}

Status AppendFile::close() {
  if (Status flushed = flush(); !flushed) return flushed;
  // A network drive may say only now that it is full.
  if (::close(std::exchange(descriptor_, -1)) != 0) return cannot_write(where_, errno);
  return {};
}

Status put_whole_file(const std::filesystem::path& path, std::string where,
                      std::string_view bytes) {
  auto file = AppendFile::create(path, std::move(where));
  if (!file) return forward(file);
  if (Status done = file->append(bytes); !done) return done;
  return file->close();
}

}  // namespace tread::internal
