// Small parts of HTML files.
#pragma once

#include <string>
#include <string_view>

namespace tread {

// Text for use between tags and inside quoted attributes. Control characters, which HTML does not
// allow, become U+FFFD.
[[nodiscard]] std::string escape_html(std::string_view text);

// RFC 4648, with padding.
[[nodiscard]] std::string encode_base64(std::string_view bytes);

}  // namespace tread
