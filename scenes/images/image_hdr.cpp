#include <array>
#include <charconv>
#include <cmath>
#include <string_view>

#include "scenes/base/files.h"
#include "scenes/images/image_codecs.h"

// Reads Radiance files by our own code: the format is small, and stb_image 2.27 loops forever on a file that ends
// inside a run. G. Ward, "Real Pixels", Graphics Gems II, 1991, and the run lengths of Radiance's color.c.
namespace sideray::scenes {
namespace {

using Rgbe = std::array<uint8_t, 4>;

class HdrReader {
 public:
  HdrReader(std::span<const uint8_t> bytes, const std::string& what) : bytes_(bytes), what_(what) {}

  Image read() {
    read_header();
    Image image{.width = width_, .height = height_, .planes = {}};
    static constexpr const char* names[] = {"R", "G", "B"};
    for (const char* name : names) {
      image.planes.push_back({.name = name, .type = Plane::Type::single, .values = {}, .uint_values = {}});
      image.planes.back().values.resize(size_t{width_} * height_);
    }
    std::vector<Rgbe> row(width_);
    for (uint32_t y = 0; y < height_; ++y) {
      read_row(row);
      for (uint32_t x = 0; x < width_; ++x) {
        const float scale = row[x][3] == 0 ? 0.0f : std::ldexp(1.0f, row[x][3] - 136);
        for (size_t c = 0; c < 3; ++c) {
          image.planes[c].values[size_t{y} * width_ + x] = static_cast<float>(row[x][c]) * scale;
        }
      }
    }
    return image;
  }

 private:
  [[noreturn]] void refuse_damaged() const { refuse("cannot read {}: a row is damaged; write the file again", what_); }

  uint8_t next() {
    if (position_ == bytes_.size()) refuse("cannot read {}: the file ends too early; write the file again", what_);
    return bytes_[position_++];
  }

  std::string next_line() {
    constexpr size_t longest_line = 4096;
    std::string line;
    for (char c = static_cast<char>(next()); c != '\n'; c = static_cast<char>(next())) {
      if (line.size() == longest_line) refuse_damaged();
      line += c;
    }
    return line;
  }

  void read_header() {
    const std::string magic = next_line();
    if (magic != "#?RADIANCE" && magic != "#?RGBE") {
      refuse("cannot read {}: it is not a Radiance .hdr file; check what wrote it", what_);
    }
    for (std::string line = next_line(); !line.empty(); line = next_line()) {
      if (line.starts_with("FORMAT=") && line != "FORMAT=32-bit_rle_rgbe") {
        refuse("cannot read {}: its format is {}; convert it to 32-bit_rle_rgbe", what_, line.substr(7));
      }
    }
    const std::string size = next_line();
    const size_t middle = size.find(" +X ");
    if (!size.starts_with("-Y ") || middle == std::string::npos) {
      refuse("cannot read {}: its rows run as \"{}\"; convert it to -Y +X", what_, size);
    }
    height_ = number(std::string_view(size).substr(3, middle - 3));
    width_ = number(std::string_view(size).substr(middle + 4));
    check_image_size(width_, height_, what_);
    check_image_values(3, width_, height_, what_);
  }

  uint32_t number(std::string_view text) const {
    uint32_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size()) {
      refuse("cannot read {}: \"{}\" is not a size; write the file again", what_, text);
    }
    return value;
  }

  void read_row(std::vector<Rgbe>& row) {
    constexpr uint32_t shortest_run_width = 8, longest_run_width = 32767;
    Rgbe first;
    for (uint8_t& byte : first) byte = next();
    const bool runs = first[0] == 2 && first[1] == 2 && first[2] < 128;
    if (width_ < shortest_run_width || width_ > longest_run_width || !runs) {
      read_flat(row, first);
      return;
    }
    if (first[2] * 256u + first[3] != width_) refuse_damaged();
    for (size_t c = 0; c < 4; ++c) read_runs(row, c);
  }

  void read_flat(std::vector<Rgbe>& row, const Rgbe& first) {
    row[0] = first;
    for (uint32_t x = 1; x < width_; ++x) {
      for (uint8_t& byte : row[x]) byte = next();
    }
  }

  void read_runs(std::vector<Rgbe>& row, size_t c) {
    for (uint32_t x = 0; x < width_;) {
      const uint32_t code = next();
      const bool repeat = code > 128;
      const uint32_t count = repeat ? code - 128 : code;
      if (count == 0 || count > width_ - x) refuse_damaged();
      const uint8_t value = repeat ? next() : uint8_t{0};
      for (uint32_t i = 0; i < count; ++i) row[x++][c] = repeat ? value : next();
    }
  }

  std::span<const uint8_t> bytes_;
  const std::string& what_;
  size_t position_ = 0;
  uint32_t width_ = 0, height_ = 0;
};

}  // namespace

Image decode_hdr(std::span<const uint8_t> bytes, const std::string& what) {
  return HdrReader(bytes, what).read();
}

}  // namespace sideray::scenes
