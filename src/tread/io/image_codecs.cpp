// Both libraries report errors by a function that must not return. It jumps back (setjmp), so the
// functions between hold nothing that would need a destructor.
#include "tread/io/image_codecs.hpp"

#include <fmt/format.h>
#include <png.h>

#include <algorithm>
#include <array>
#include <bit>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <vector>

// libjpeg's headers need size_t and FILE from above.
#include <jerror.h>
#include <jpeglib.h>

namespace tread {
namespace {

using Message = std::array<char, JMSG_LENGTH_MAX>;

Status not_decoded(const Message& why, const std::string& where) {
  return fail(ErrorCode::kUnreadable,
              fmt::format("the picture is damaged and cannot be decoded ({})", why.data()), where,
              "Copy or record it again");
}

void keep(const char* text, Message& message) {
  std::snprintf(message.data(), message.size(), "%s", text);
}

struct PngReading {
  std::string_view rest;  // bytes not yet read
  Message message{};
  std::jmp_buf back{};
};

[[noreturn]] void png_failed(png_structp png, png_const_charp text) {
  auto& reading = *static_cast<PngReading*>(png_get_error_ptr(png));
  keep(text, reading.message);
  std::longjmp(reading.back, 1);
}

void png_warned(png_structp /*png*/, png_const_charp /*text*/) {}

void png_next(png_structp png, png_bytep out, png_size_t count) {
  auto& reading = *static_cast<PngReading*>(png_get_io_ptr(png));
  if (count > reading.rest.size()) png_error(png, "the data ends too early");
  std::memcpy(out, reading.rest.data(), count);
  reading.rest.remove_prefix(count);
}

// False where libpng gave up.
bool read_png(png_structp png, png_infop info, const ImageHeader& header, png_bytepp rows,
              PngReading& reading) {
  if (setjmp(reading.back) != 0) return false;
  png_set_read_fn(png, &reading, png_next);
  png_set_user_limits(png, 0x7fffffff, 0x7fffffff);  // the header was checked against the file
  png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
  png_read_info(png, info);
  const int type = png_get_color_type(png, info);
  if (type == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(png);
  if (type == PNG_COLOR_TYPE_GRAY) png_set_expand_gray_1_2_4_to_8(png);
  png_set_strip_alpha(png);
  png_set_bgr(png);
  if (std::endian::native == std::endian::little) png_set_swap(png);
  png_set_interlace_handling(png);
  png_read_update_info(png, info);
  const std::size_t channels = header.colour ? 3 : 1;
  const std::size_t row_bytes =
      channels * static_cast<std::size_t>(header.width) * static_cast<std::size_t>(header.bits / 8);
  if (png_get_rowbytes(png, info) != row_bytes) png_error(png, "unexpected length of a row");
  png_read_image(png, rows);
  png_read_end(png, nullptr);
  return true;
}

struct JpegReading {
  jpeg_error_mgr manager{};  // the first member: libjpeg holds its address
  Message message{};
  bool damaged = false;
  std::jmp_buf back{};
};

void jpeg_text(j_common_ptr jpeg, JpegReading& reading) {
  if (reading.damaged) return;  // the first message tells most
  reading.damaged = true;
  jpeg->err->format_message(jpeg, reading.message.data());
}

[[noreturn]] void jpeg_failed(j_common_ptr jpeg) {
  auto& reading = *reinterpret_cast<JpegReading*>(jpeg->err);
  jpeg_text(jpeg, reading);
  std::longjmp(reading.back, 1);
}

// Of the warnings those after which libjpeg makes pixels up; the others, as bytes between segments,
// are harmless.
void jpeg_warned(j_common_ptr jpeg, int level) {
  if (level >= 0) return;
  constexpr std::array<int, 4> kDamage = {JWRN_HIT_MARKER, JWRN_HUFF_BAD_CODE, JWRN_JPEG_EOF,
                                          JWRN_MUST_RESYNC};
  const bool made_up =
      std::find(kDamage.begin(), kDamage.end(), jpeg->err->msg_code) != kDamage.end();
  if (made_up) jpeg_text(jpeg, *reinterpret_cast<JpegReading*>(jpeg->err));
}

void jpeg_silent(j_common_ptr /*jpeg*/) {}

// False where libjpeg gave up or had to make pixels up.
bool read_jpeg(jpeg_decompress_struct& jpeg, std::string_view bytes, const ImageHeader& header,
               PixelRows rows, JpegReading& reading) {
  if (setjmp(reading.back) != 0) return false;
  jpeg_create_decompress(&jpeg);
  jpeg_mem_src(&jpeg, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  jpeg_read_header(&jpeg, TRUE);
  jpeg.out_color_space = header.colour ? JCS_EXT_BGR : JCS_GRAYSCALE;
  jpeg_start_decompress(&jpeg);
  if (jpeg.output_width != static_cast<JDIMENSION>(header.width) ||
      jpeg.output_height != static_cast<JDIMENSION>(header.height)) {
    keep("its size differs from its header", reading.message);
    return false;
  }
  while (jpeg.output_scanline < jpeg.output_height) {
    JSAMPROW row = rows.data + jpeg.output_scanline * rows.stride_bytes;
    jpeg_read_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_decompress(&jpeg);
  return !reading.damaged;
}

}  // namespace

Status decode_png(std::string_view bytes, const ImageHeader& header, const std::string& where,
                  PixelRows rows) {
  std::vector<png_bytep> starts(static_cast<std::size_t>(header.height));
  for (std::size_t y = 0; y < starts.size(); ++y) starts[y] = rows.data + y * rows.stride_bytes;
  PngReading reading;
  reading.rest = bytes;
  keep("out of memory", reading.message);
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &reading, png_failed, png_warned);
  png_infop info = png == nullptr ? nullptr : png_create_info_struct(png);
  const bool read = info != nullptr && read_png(png, info, header, starts.data(), reading);
  if (png != nullptr) png_destroy_read_struct(&png, &info, nullptr);
  return read ? Status{} : not_decoded(reading.message, where);
}

Status decode_jpeg(std::string_view bytes, const ImageHeader& header, const std::string& where,
                   PixelRows rows) {
  JpegReading reading;
  jpeg_decompress_struct jpeg{};
  jpeg.err = jpeg_std_error(&reading.manager);
  reading.manager.error_exit = jpeg_failed;
  reading.manager.emit_message = jpeg_warned;
  reading.manager.output_message = jpeg_silent;
  const bool read = read_jpeg(jpeg, bytes, header, rows, reading);
  jpeg_destroy_decompress(&jpeg);
  return read ? Status{} : not_decoded(reading.message, where);
}

}  // namespace tread
