// Results of operations that the outside world can make fail: files, configurations, sensors.
// A bug is an assertion and the quality of an estimate is a field of the estimate; neither is here.
#pragma once

#include <new>
#include <stdexcept>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>

namespace tread {

enum class ErrorCode {
  kBadArgument,  // the caller asked for something that cannot be (sizes that differ, an even
                 // window)
  kNotFound,     // a file, folder, key or layer is missing
  kUnreadable,   // it is there, but reading stopped: truncated, corrupt, no permission
  kBadFormat,    // it was read, but it is not what was expected: wrong size, type, syntax
  kBadValue,     // a value outside its range
  kWriteFailed,  // the disk is full, the folder does not exist, no permission
  kUnsupported,  // valid, but not handled here
  kTooLarge,     // it would take more memory than there is or than the options allow
  kInterrupted,  // the user ended the work before it was done
};

// What was wrong, where (file, line, field), and what the reader of the message can do about it.
struct Error {
  ErrorCode code = ErrorCode::kBadArgument;
  std::string what;
  std::string where;
  std::string remedy;

  // "rig.yaml: left.fx: focal length is 0. Write the focal length in pixels."
  [[nodiscard]] std::string message() const {
    const auto ended = [](const std::string& text) {
      return !text.empty() && (text.back() == '.' || text.back() == '?' || text.back() == '!');
    };
    std::string text = where.empty() ? what : where + ": " + what;
    if (!remedy.empty()) text += (ended(text) ? " " : ". ") + remedy;
    if (!ended(text)) text += '.';
    return text;
  }
};

template <class T>
using Result = tl::expected<T, Error>;
using Status = tl::expected<void, Error>;

// return fail(ErrorCode::kNotFound, "no such file", path, "Check the name");
[[nodiscard]] inline tl::unexpected<Error> fail(ErrorCode code, std::string what, std::string where,
                                                std::string remedy) {
  return tl::unexpected<Error>(Error{code, std::move(what), std::move(where), std::move(remedy)});
}

// Hands the error of one result on as the error of another: if (!x) return forward(x);
template <class T>
[[nodiscard]] tl::unexpected<Error> forward(const Result<T>& result) {
  return tl::unexpected<Error>(result.error());
}

// Runs a body that gives a Result; memory that runs out within becomes an error like any other.
//   return with_memory_checked(path, "Save a smaller map", [&] { return load(path); });
template <class Body>
[[nodiscard]] auto with_memory_checked(std::string_view where, std::string_view remedy,
                                       const Body& body) -> decltype(body()) {
  try {
    return body();
  } catch (const std::bad_alloc&) {
  } catch (const std::length_error&) {  // a container asked for more than can be counted
  }
  return fail(ErrorCode::kTooLarge, "there is not enough memory for it", std::string(where),
              std::string(remedy));
}

}  // namespace tread
