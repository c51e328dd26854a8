#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfTestFile.h>
#include <half.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>
#include <set>

#include "scenes/base/files.h"
#include "scenes/base/limits.h"
#include "scenes/images/image_codecs.h"

namespace sideray::scenes {
namespace {

// Writes to memory: with a file, OutputFile's destructor would hide a failed write of the line offsets.
class MemoryStream : public Imf::OStream {
 public:
  explicit MemoryStream(const char* name) : OStream(name) {}
  void write(const char bytes[], int count) override {
    const size_t end = position_ + static_cast<size_t>(count);
    if (end > bytes_.size()) bytes_.resize(end);
    std::copy(bytes, bytes + count, bytes_.begin() + static_cast<std::ptrdiff_t>(position_));
    position_ = end;
  }
  uint64_t tellp() override { return position_; }
  void seekp(uint64_t position) override { position_ = position; }
  uint64_t size() const { return bytes_.size(); }
  int32_t number_at(uint64_t position) const {
    int32_t number = 0;
    std::memcpy(&number, bytes_.data() + position, sizeof(number));  // little-endian, as the file
    return number;
  }
  const std::vector<uint8_t>& bytes() const { return bytes_; }

 private:
  std::vector<uint8_t> bytes_;
  uint64_t position_ = 0;
};

struct Window {
  Imath::Box2i box;
  uint64_t width, height;
};

Window checked_window(const Imath::Box2i& box, const std::string& path) {
  const int64_t width = int64_t{box.max.x} - box.min.x + 1, height = int64_t{box.max.y} - box.min.y + 1;
  check_image_size(static_cast<uint64_t>(std::max<int64_t>(width, 0)),
                   static_cast<uint64_t>(std::max<int64_t>(height, 0)), path);
  return {box, static_cast<uint64_t>(width), static_cast<uint64_t>(height)};
}

Plane plane_for(const char* name, const Imf::Channel& channel, const Window& data, const std::string& path) {
  if (channel.xSampling != 1 || channel.ySampling != 1) {
    refuse("cannot read {}: channel {} is subsampled; convert the picture to RGB", path, name);
  }
  Plane plane{.name = name, .type = Plane::Type::half, .values = {}, .uint_values = {}};
  if (channel.type == Imf::UINT) plane.type = Plane::Type::uint;
  if (channel.type == Imf::FLOAT) plane.type = Plane::Type::single;
  const size_t pixels = data.width * data.height;
  if (plane.type == Plane::Type::uint)
    plane.uint_values.resize(pixels);
  else
    plane.values.resize(pixels);
  return plane;
}

// Moves pixels from the data window to the display window; pixels without data become 0.
template <typename T>
std::vector<T> moved_to_display(const std::vector<T>& from, const Window& data, const Window& display) {
  std::vector<T> to(display.width * display.height, T{0});
  const Imath::Box2i both(
      Imath::V2i(std::max(data.box.min.x, display.box.min.x), std::max(data.box.min.y, display.box.min.y)),
      Imath::V2i(std::min(data.box.max.x, display.box.max.x), std::min(data.box.max.y, display.box.max.y)));
  if (both.isEmpty()) return to;
  const auto index = [&](const Window& window, int x, int y) {
    return static_cast<std::ptrdiff_t>(static_cast<uint64_t>(int64_t{y} - window.box.min.y) * window.width +
                                       static_cast<uint64_t>(int64_t{x} - window.box.min.x));
  };
  for (int y = both.min.y; y <= both.max.y; ++y) {
    const auto row = from.begin() + index(data, both.min.x, y);
    std::copy(row, row + (both.max.x - both.min.x + 1), to.begin() + index(display, both.min.x, y));
  }
  return to;
}

Image read_planes(const std::string& path) {
  Imf::InputFile file(path.c_str());
  if (!file.isComplete()) refuse("cannot read {}: the file is incomplete; write the file again", path);
  const Window data = checked_window(file.header().dataWindow(), path);
  const Window display = checked_window(file.header().displayWindow(), path);
  const Imf::ChannelList& channels = file.header().channels();
  uint64_t channel_count = 0;
  for (auto channel = channels.begin(); channel != channels.end(); ++channel) ++channel_count;
  check_image_values(channel_count, data.width, data.height, path);
  check_image_values(channel_count, display.width, display.height, path);
  Image image{
      .width = static_cast<uint32_t>(display.width), .height = static_cast<uint32_t>(display.height), .planes = {}};
  image.planes.reserve(channel_count);
  Imf::FrameBuffer frame;
  for (auto channel = channels.begin(); channel != channels.end(); ++channel) {
    Plane& plane = image.planes.emplace_back(plane_for(channel.name(), channel.channel(), data, path));
    const bool is_uint = plane.type == Plane::Type::uint;
    const void* values = is_uint ? static_cast<const void*>(plane.uint_values.data()) : plane.values.data();
    frame.insert(channel.name(), Imf::Slice::Make(is_uint ? Imf::UINT : Imf::FLOAT, values, data.box));
  }
  file.setFrameBuffer(frame);
  file.readPixels(data.box.min.y, data.box.max.y);
  if (data.box != display.box) {
    for (Plane& plane : image.planes) {
      if (plane.type == Plane::Type::uint)
        plane.uint_values = moved_to_display(plane.uint_values, data, display);
      else
        plane.values = moved_to_display(plane.values, data, display);
    }
  }
  return image;
}

// Clamps to the largest half, since viewers turn infinities into black or NaN.
half clamped_half(float value) {
  return std::isnan(value) ? half::qNan() : half(std::clamp(value, -65504.0f, 65504.0f));
}

void check_planes(const std::string& path, const Image& image) {
  const size_t pixels = size_t{image.width} * image.height;
  std::set<std::string> names;
  if (pixels == 0 || image.planes.empty()) refuse("cannot write {}: the picture is empty; give it planes", path);
  for (const Plane& plane : image.planes) {
    const size_t count = plane.type == Plane::Type::uint ? plane.uint_values.size() : plane.values.size();
    if (count != pixels || !names.insert(plane.name).second || plane.name.empty() || plane.name.size() > 255) {
      refuse("cannot write {}: plane \"{}\" has {} of {} values, or a name that is taken; fix the plane", path,
             plane.name, count, pixels);
    }
  }
}

// Returns whether no block of rows is missing: where zlib finds no memory, OpenEXR 3.1 skips blocks silently. A block
// is the number of its first row, the number of its bytes, and the bytes.
bool has_all_blocks(const MemoryStream& stream, uint64_t position, uint32_t rows) {
  constexpr uint64_t before_bytes = 2 * sizeof(int32_t);
  constexpr uint32_t rows_of_block = 16;  // of ZIP_COMPRESSION
  for (uint32_t row = 0; row < rows; row += rows_of_block) {
    if (position + before_bytes > stream.size()) return false;
    const int32_t bytes = stream.number_at(position + sizeof(int32_t));
    if (bytes <= 0) return false;
    position += before_bytes + static_cast<uint64_t>(bytes);
  }
  return position == stream.size();
}

void encode_exr(MemoryStream& stream, const Image& image) {
  Imf::Header header(static_cast<int>(image.width), static_cast<int>(image.height));
  header.compression() = Imf::ZIP_COMPRESSION;
  Imf::FrameBuffer frame;
  std::vector<std::vector<half>> halves;
  halves.reserve(image.planes.size());
  for (const Plane& plane : image.planes) {
    Imf::PixelType type = Imf::FLOAT;
    const void* values = plane.values.data();
    if (plane.type == Plane::Type::uint) {
      type = Imf::UINT;
      values = plane.uint_values.data();
    } else if (plane.type == Plane::Type::half) {
      type = Imf::HALF;
      std::vector<half>& converted = halves.emplace_back(plane.values.size());
      std::transform(plane.values.begin(), plane.values.end(), converted.begin(), clamped_half);
      values = converted.data();
    }
    header.channels().insert(plane.name, Imf::Channel(type));
    frame.insert(plane.name, Imf::Slice::Make(type, values, header.dataWindow()));
  }
  Imf::OutputFile file(stream, header);
  file.setFrameBuffer(frame);
  const uint64_t first_block = stream.tellp();
  file.writePixels(static_cast<int>(image.height));
  if (!has_all_blocks(stream, first_block, image.height)) throw std::bad_alloc();
}

// Returns OpenEXR's message without its own "Cannot read image file "path".", which our line already says.
std::string reason(const std::exception& error) {
  std::string text = error.what();
  std::replace(text.begin(), text.end(), '\n', ' ');
  if (const size_t end = text.find("\". "); text.starts_with("Cannot ") && end != std::string::npos) {
    text.erase(0, end + 3);
  }
  while (!text.empty() && (text.back() == '.' || text.back() == ' ')) text.pop_back();
  return text;
}

}  // namespace

Image read_exr(const std::string& path) {
  // Our own reader comes first, for our usual messages about missing files, folders and pipes.
  read_file(path, limits::picture_file_bytes);
  bool tiled = false, deep = false, multi_part = false;
  if (!Imf::isOpenExrFile(path.c_str(), tiled, deep, multi_part)) {
    refuse("cannot read {}: it is not an OpenEXR file; check what wrote it", path);
  }
  if (deep) refuse("cannot read {}: it holds deep data; flatten it first", path);
  try {
    return read_planes(path);
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    refuse("cannot read {}: it does not fit into memory; use a smaller picture", path);
  } catch (const std::exception& error) {
    refuse("cannot read {}: {}; write the file again", path, reason(error));
  }
}

void write_exr(const std::string& path, const Image& image) {
  check_planes(path, image);
  MemoryStream stream(path.c_str());
  try {
    encode_exr(stream, image);
  } catch (const std::bad_alloc&) {
    refuse("cannot write {}: it does not fit into memory; make the picture smaller", path);
  } catch (const std::exception& error) {
    refuse("cannot write {}: {}; make the picture smaller", path, reason(error));
  }
  write_file(path, stream.bytes());
}

}  // namespace sideray::scenes
