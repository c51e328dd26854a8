#include <png.h>

#include <csetjmp>
#include <cstdio>
#include <cstring>

#include "scenes/base/files.h"
#include "scenes/images/image_codecs.h"

// libpng reports errors by longjmp. No function below that calls setjmp holds an object with a destructor; all owners
// are in the callers.
namespace sideray::scenes {
namespace {

struct Session {
  png_structp png = nullptr;
  png_infop info = nullptr;
  bool writing = false;
  char message[160] = "out of memory";
  std::span<const uint8_t> input;
  size_t position = 0;
  std::vector<uint8_t>* output = nullptr;
  const Budget* budget = nullptr;

  explicit Session(bool to_write);
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  ~Session() { writing ? png_destroy_write_struct(&png, &info) : png_destroy_read_struct(&png, &info, nullptr); }
};

void on_error(png_structp png, png_const_charp text) {
  auto* session = static_cast<Session*>(png_get_error_ptr(png));
  std::snprintf(session->message, sizeof(session->message), "%s", text);
  png_longjmp(png, 1);
}

void on_warning(png_structp, png_const_charp) {}

void on_read(png_structp png, png_bytep bytes, size_t count) {
  auto* session = static_cast<Session*>(png_get_io_ptr(png));
  if (count > session->input.size() - session->position) png_error(png, "the file ends too early");
  std::memcpy(bytes, session->input.data() + session->position, count);
  session->position += count;
}

void on_write(png_structp png, png_bytep bytes, size_t count) {
  auto* session = static_cast<Session*>(png_get_io_ptr(png));
  bool stored = true;
  // No exception may pass through libpng's frames.
  try {
    session->output->insert(session->output->end(), bytes, bytes + count);
  } catch (...) {
    stored = false;
  }
  if (!stored) png_error(png, "out of memory");
}

void on_flush(png_structp) {}

// Checks the time after each row, because a few kilobytes can hold gigabytes of rows.
void on_row(png_structp png, png_uint_32, int) {
  const auto* session = static_cast<Session*>(png_get_error_ptr(png));
  if (session->budget != nullptr && session->budget->is_late()) png_error(png, "late");
}

Session::Session(bool to_write) : writing(to_write) {
  png = to_write ? png_create_write_struct(PNG_LIBPNG_VER_STRING, this, on_error, on_warning)
                 : png_create_read_struct(PNG_LIBPNG_VER_STRING, this, on_error, on_warning);
  if (png != nullptr) info = png_create_info_struct(png);
}

bool read_header(Session& session) {
  if (session.info == nullptr || setjmp(png_jmpbuf(session.png)) != 0) return false;
  png_set_read_fn(session.png, &session, on_read);
  png_set_user_limits(session.png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
  png_read_info(session.png, session.info);
  return true;
}

enum class Samples { as_stored, rgba8 };

bool set_up_transforms(Session& session, Samples samples) {
  if (setjmp(png_jmpbuf(session.png)) != 0) return false;
  png_set_expand(session.png);
  png_set_gray_to_rgb(session.png);
  if (samples == Samples::rgba8) {
    png_set_scale_16(session.png);
    png_set_add_alpha(session.png, 0xff, PNG_FILLER_AFTER);
  } else {
    png_set_swap(session.png);
  }
  png_set_interlace_handling(session.png);
  png_set_read_status_fn(session.png, on_row);
  png_read_update_info(session.png, session.info);
  return true;
}

bool read_rows(Session& session, png_bytep* rows) {
  if (setjmp(png_jmpbuf(session.png)) != 0) return false;
  png_read_image(session.png, rows);
  png_read_end(session.png, nullptr);
  return true;
}

bool write_rows(Session& session, uint32_t width, uint32_t height, uint32_t channels, png_bytep* rows) {
  if (session.info == nullptr || setjmp(png_jmpbuf(session.png)) != 0) return false;
  png_set_write_fn(session.png, &session, on_write, on_flush);
  png_set_IHDR(session.png, session.info, width, height, 8, channels == 4 ? PNG_COLOR_TYPE_RGBA : PNG_COLOR_TYPE_RGB,
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(session.png, session.info);
  png_write_image(session.png, rows);
  png_write_end(session.png, session.info);
  return true;
}

std::vector<png_bytep> row_pointers(uint8_t* samples, uint32_t height, size_t row_bytes) {
  std::vector<png_bytep> rows(height);
  for (uint32_t y = 0; y < height; ++y) rows[y] = samples + y * row_bytes;
  return rows;
}

}  // namespace

bool is_png(std::span<const uint8_t> bytes) {
  return bytes.size() >= 8 && png_sig_cmp(bytes.data(), 0, 8) == 0;
}

namespace {

// Reads up to the first row of a picture whose size is within the limits.
void begin_reading(Session& session, std::span<const uint8_t> bytes, const std::string& what) {
  if (!is_png(bytes)) refuse("cannot read {}: it is not a PNG file; check what wrote it", what);
  session.input = bytes;
  if (!read_header(session)) refuse("cannot read {}: {}; write the file again", what, session.message);
  check_image_size(png_get_image_width(session.png, session.info), png_get_image_height(session.png, session.info),
                   what);
}

// Reads all rows in the wanted format.
std::vector<uint8_t> read_samples(Session& session, Samples wanted, const std::string& what) {
  if (!set_up_transforms(session, wanted)) refuse("cannot read {}: {}; write the file again", what, session.message);
  const size_t row_bytes = png_get_rowbytes(session.png, session.info);
  const uint32_t height = png_get_image_height(session.png, session.info);
  std::vector<uint8_t> samples(row_bytes * height);
  std::vector<png_bytep> rows = row_pointers(samples.data(), height, row_bytes);
  const bool is_whole = read_rows(session, rows.data());
  if (session.budget != nullptr) session.budget->check_time(what);
  if (!is_whole) refuse("cannot read {}: {}; write the file again", what, session.message);
  return samples;
}

}  // namespace

PngPixels decode_png(std::span<const uint8_t> bytes, const std::string& what) {
  Session session(false);
  begin_reading(session, bytes, what);
  const uint32_t width = png_get_image_width(session.png, session.info);
  const uint32_t height = png_get_image_height(session.png, session.info);
  check_image_values(4, width, height, what);
  PngPixels pixels;
  pixels.samples = read_samples(session, Samples::as_stored, what);
  pixels.width = width, pixels.height = height;
  pixels.channels = png_get_channels(session.png, session.info);
  pixels.bits = png_get_bit_depth(session.png, session.info);
  return pixels;
}

Decoded decode_png_texels(std::span<const uint8_t> bytes, const std::string& what, Budget* budget) {
  Session session(false);
  session.budget = budget;
  begin_reading(session, bytes, what);
  Decoded decoded{png_get_image_width(session.png, session.info), png_get_image_height(session.png, session.info), {}};
  take_texels(budget, decoded.width, decoded.height, 0, what);
  decoded.rgba = read_samples(session, Samples::rgba8, what);
  return decoded;
}

std::vector<uint8_t> encode_png(uint32_t width, uint32_t height, uint32_t channels, std::span<const uint8_t> pixels,
                                const std::string& what) {
  const size_t row_bytes = size_t{width} * channels;
  if (width == 0 || height == 0 || (channels != 3 && channels != 4) || pixels.size() != row_bytes * height) {
    refuse("cannot write {}: {} bytes are not a picture of {} x {} x {}; pass width * height * channels bytes", what,
           pixels.size(), width, height, channels);
  }
  std::vector<uint8_t> bytes;
  Session session(true);
  session.output = &bytes;
  // libpng does not change the rows that it writes; its interface lacks the const.
  std::vector<png_bytep> rows = row_pointers(const_cast<uint8_t*>(pixels.data()), height, row_bytes);
  if (!write_rows(session, width, height, channels, rows.data())) {
    refuse("cannot write {}: {}; make the picture smaller", what, session.message);
  }
  return bytes;
}

}  // namespace sideray::scenes
