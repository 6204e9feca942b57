// Images: an owner with 64-byte aligned rows, and a view that borrows pixels from anybody.
// Pixel (x, y): x to the right, y down, (0, 0) is the centre of the top left pixel.
#pragma once

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <type_traits>

namespace tread {

// Borrowed pixels. `stride` is the distance between rows in pixels and may exceed the width.
// Wraps any row-major buffer, a cv::Mat for example, without copying:
//   ImageView<const uint8_t>{mat.data, mat.cols, mat.rows, static_cast<ptrdiff_t>(mat.step1())}
template <class T>
struct ImageView {
  T* data = nullptr;
  int width = 0;
  int height = 0;
  std::ptrdiff_t stride = 0;

  [[nodiscard]] bool empty() const { return width <= 0 || height <= 0; }
  [[nodiscard]] T* row(int y) const { return data + y * stride; }
  [[nodiscard]] T& operator()(int x, int y) const {
    assert(x >= 0 && x < width && y >= 0 && y < height);
    return data[y * stride + x];
  }
  // A view of mutable pixels is also a view of constant ones.
  operator ImageView<const T>() const  // NOLINT(google-explicit-constructor)
      requires(!std::is_const_v<T>) {
    return {data, width, height, stride};
  }
};

template <class A, class B>
[[nodiscard]] bool same_size(const A& a, const B& b) {
  return a.width == b.width && a.height == b.height;
}

// Owned pixels; rows start on 64-byte boundaries. Copies are deep.
template <class T>
class Image {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  int width = 0;
  int height = 0;
  std::ptrdiff_t stride = 0;

  Image() = default;
  Image(int width_px, int height_px, T fill = T{}) {
    resize(width_px, height_px);
    std::fill(data_.get(), data_.get() + size(), fill);
  }
  Image(const Image& other) { *this = other; }
  Image(Image&& other) noexcept { swap(other); }
  Image& operator=(const Image& other) {
    if (this == &other) return *this;
    resize(other.width, other.height);
    std::copy(other.data_.get(), other.data_.get() + size(), data_.get());
    return *this;
  }
  Image& operator=(Image&& other) noexcept {
    swap(other);
    return *this;
  }
  ~Image() = default;

  // Keeps the memory when it is large enough; the pixels are then unspecified.
  void resize(int width_px, int height_px) {
    assert(width_px >= 0 && height_px >= 0);
    constexpr std::ptrdiff_t kAlign = std::max<std::ptrdiff_t>(1, 64 / sizeof(T));
    const std::ptrdiff_t new_stride = (width_px + kAlign - 1) / kAlign * kAlign;
    const std::size_t needed = static_cast<std::size_t>(new_stride * height_px);
    if (needed > capacity_) {
      data_.reset(static_cast<T*>(::operator new(needed * sizeof(T), kAlignment)));
      capacity_ = needed;
      std::fill(data_.get(), data_.get() + needed, T{});
    }
    width = width_px;
    height = height_px;
    stride = new_stride;
  }

  [[nodiscard]] bool empty() const { return width <= 0 || height <= 0; }
  [[nodiscard]] T* row(int y) { return data_.get() + y * stride; }
  [[nodiscard]] const T* row(int y) const { return data_.get() + y * stride; }
  [[nodiscard]] T& operator()(int x, int y) {
    assert(x >= 0 && x < width && y >= 0 && y < height);
    return data_.get()[y * stride + x];
  }
  [[nodiscard]] const T& operator()(int x, int y) const {
    assert(x >= 0 && x < width && y >= 0 && y < height);
    return data_.get()[y * stride + x];
  }
  [[nodiscard]] ImageView<T> view() { return {data_.get(), width, height, stride}; }
  [[nodiscard]] ImageView<const T> view() const { return {data_.get(), width, height, stride}; }
  operator ImageView<T>() { return view(); }              // NOLINT(google-explicit-constructor)
  operator ImageView<const T>() const { return view(); }  // NOLINT(google-explicit-constructor)

  [[nodiscard]] bool operator==(const Image& other) const {
    if (!same_size(*this, other)) return false;
    for (int y = 0; y < height; ++y) {
      if (!std::equal(row(y), row(y) + width, other.row(y))) return false;
    }
    return true;
  }

 private:
  static constexpr std::align_val_t kAlignment{64};
  struct Free {
    void operator()(T* p) const { ::operator delete(p, kAlignment); }
  };
  [[nodiscard]] std::size_t size() const { return static_cast<std::size_t>(stride * height); }
  void swap(Image& other) noexcept {
    std::swap(width, other.width);
    std::swap(height, other.height);
    std::swap(stride, other.stride);
    std::swap(capacity_, other.capacity_);
    std::swap(data_, other.data_);
  }

  std::size_t capacity_ = 0;
  std::unique_ptr<T[], Free> data_;
};

// Colour pixels are three bytes in the order red, green, blue.
struct Rgb {
  std::uint8_t r = 0, g = 0, b = 0;
  [[nodiscard]] bool operator==(const Rgb&) const = default;
};

}  // namespace tread
