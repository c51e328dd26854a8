// Adds MuJoCo's backdrop to a picture: a sky that does not light the scene, or nothing in place of the environment that
// does; and the haze around the horizon of infinite planes.
#include <algorithm>
#include <array>
#include <cmath>
#include <thread>
#include <tuple>
#include <vector>

#include "python/native/native.h"

namespace sideray::python {
namespace {

using Vec3 = std::array<float, 3>;

// The axes that s and t follow on one face of OpenGL's cubes (+X, -X, +Y, -Y, +Z, -Z), and their signs.
struct Face {
  size_t s, t;
  float s_sign, t_sign;
};
constexpr std::array<Face, 6> cube_faces = {
    {{2, 1, -1, -1}, {2, 1, 1, -1}, {0, 2, 1, 1}, {0, 2, 1, -1}, {0, 1, 1, -1}, {0, 1, -1, -1}}};

float linear_of_srgb(float v) {
  return v <= 0.04045f ? v / 12.92f : static_cast<float>(std::pow((double{v} + 0.055) / 1.055, 2.4));
}

// The faces of a sky, (6, side, side, channels). MuJoCo's world has z up, the cube y.
class Sky {
 public:
  Sky(const Array<uint8_t>& faces, bool srgb) : texels_(faces.data()), srgb_(srgb) {
    require_shape(faces, {6, faces.ndim() > 1 ? faces.shape(1) : -1, faces.ndim() > 1 ? faces.shape(1) : -1, -1}, "faces");
    side_ = static_cast<size_t>(faces.shape(1));
    channels_ = static_cast<size_t>(faces.shape(3));
    if (side_ < 1 || channels_ < 3) throw Error(SIDERAY_INVALID_ARGUMENT, "faces: give texels of three channels or more");
  }

  // Returns the colour in a direction of any length.
  Vec3 look_up(const Vec3& world) const {
    const Vec3 d = {world[0], world[2], -world[1]};
    size_t axis = 0;
    for (size_t k = 1; k < 3; ++k)
      if (std::abs(d[k]) > std::abs(d[axis])) axis = k;
    const size_t number = 2 * axis + (d[axis] < 0 ? 1 : 0);
    const Face& face = cube_faces[number];
    const float half = 0.5f / std::max(std::abs(d[axis]), 1e-30f);
    return bilinear(number, face.s_sign * d[face.s] * half + 0.5f, face.t_sign * d[face.t] * half + 0.5f);
  }

 private:
  Vec3 bilinear(size_t face, float s, float t) const {
    const auto last = static_cast<float>(side_ - 1);
    const float x = std::clamp(s * static_cast<float>(side_) - 0.5f, 0.0f, last);
    const float y = std::clamp(t * static_cast<float>(side_) - 0.5f, 0.0f, last);
    const auto x0 = static_cast<size_t>(x), y0 = static_cast<size_t>(y);
    const size_t x1 = std::min(x0 + 1, side_ - 1), y1 = std::min(y0 + 1, side_ - 1);
    const float u = x - static_cast<float>(x0), v = y - static_cast<float>(y0);
    const uint8_t *a = texel(face, x0, y0), *b = texel(face, x1, y0), *c = texel(face, x0, y1), *e = texel(face, x1, y1);
    Vec3 color;
    for (size_t k = 0; k < 3; ++k) {
      const auto at = [k](const uint8_t* texel) { return static_cast<float>(texel[k]); };
      color[k] = ((at(a) * (1 - u) + at(b) * u) * (1 - v) + (at(c) * (1 - u) + at(e) * u) * v) * (1.0f / 255.0f);
      if (srgb_) color[k] = linear_of_srgb(color[k]);
    }
    return color;
  }
  const uint8_t* texel(size_t face, size_t x, size_t y) const {
    return texels_ + ((face * side_ + y) * side_ + x) * channels_;
  }

  const uint8_t* texels_;
  bool srgb_;
  size_t side_ = 0, channels_ = 0;
};

Vec3 vector_of(const Array<double>& array, const char* what) {
  require_shape(array, {3}, what);
  return {static_cast<float>(array.data()[0]), static_cast<float>(array.data()[1]), static_cast<float>(array.data()[2])};
}

// MuJoCo's haze: infinite planes fade into a colour, and that fades into the sky at the horizon. Measured in its
// pictures, it is two strips around the point below the eye: one from the plane, at distance (1 - share) * `end`, to
// the full colour at `end`; the other from there up to no colour at the eye's height, at (1 + share) * `end`. The first
// strip's inner edge lies below the plane by as much as its distance is scaled by 1 + share. The plane is not visible
// beyond `end`.
struct Haze {
  Array<uint32_t> surfaces;   // of each pixel
  Array<uint8_t> is_endless;  // by surface id: the background (0) and infinite planes
  Vec3 color, up;             // up: the plane's normal, unit
  float height, end, share;   // height: of the eye above the plane

  bool is_at(py::ssize_t pixel) const {
    const uint32_t surface = surfaces.data()[pixel];
    return surface < static_cast<size_t>(is_endless.size()) && is_endless.data()[surface] != 0;
  }
  // Returns a direction's descent for each step along the plane, relative to that of the strips' common edge.
  float slope(const Vec3& d) const {
    const float down = -(d[0] * up[0] + d[1] * up[1] + d[2] * up[2]);
    const float squared = d[0] * d[0] + d[1] * d[1] + d[2] * d[2] - down * down;
    return down * end / (height * std::sqrt(std::max(squared, 1e-20f)));
  }
  // Returns the share of the haze in a direction's colour: linear along a strip, in perspective.
  float share_at(float slope) const {
    if (slope <= 0.0f) return 0.0f;
    if (slope < 1.0f) return slope * (1.0f + share) / (1.0f + slope * share);
    const float left = (1.0f + share) * (1.0f - (1.0f - share) * slope);  // to the inner edge
    return left <= 0.0f ? 0.0f : left / (left + slope - 1.0f);
  }
};

Haze haze_of(const py::dict& fields, py::ssize_t pixels) {
  const auto number = [&](const char* name) { return fields[name].cast<float>(); };
  Haze haze{fields["surfaces"].cast<Array<uint32_t>>(), fields["is_endless"].cast<Array<uint8_t>>(),
            vector_of(fields["color"].cast<Array<double>>(), "color"), vector_of(fields["up"].cast<Array<double>>(), "up"),
            number("height"), number("end"), number("share")};
  if (haze.surfaces.size() != pixels) throw Error(SIDERAY_INVALID_ARGUMENT, "haze: surfaces: give one of each pixel");
  return haze;
}

// Calls work(first, end) for ranges of rows, on no more threads than the picture is worth.
template <typename Work>
void by_rows(py::ssize_t height, py::ssize_t width, py::ssize_t threads, const Work& work) {
  constexpr py::ssize_t pixels_worth_a_thread = 32768;
  const py::ssize_t parts = std::clamp(height * width / pixels_worth_a_thread, py::ssize_t{1}, std::max(threads, py::ssize_t{1}));
  std::vector<std::jthread> others;
  for (py::ssize_t part = 1; part < parts; ++part)
    others.emplace_back([=, &work] { work(part * height / parts, (part + 1) * height / parts); });
  work(py::ssize_t{0}, height / parts);
}

// Quantizes a number from 0 to 1 linearly, in 256 steps.
uint8_t byte_of(float value) { return static_cast<uint8_t>(std::clamp(value, 0.0f, 1.0f) * 255.0f + 0.5f); }

// Holds what pixels show that no object hides: a colour, the faces of a sky, how often the sky is added to the colour, and
// whether its texels are sRGB.
using Backdrop = std::tuple<Array<double>, std::optional<Array<uint8_t>>, double, bool>;
// A pixel looks along corner + column * across + row * down.
using Directions = std::tuple<Array<double>, Array<double>, Array<double>>;

// Puts a backdrop behind a picture.
class PictureOverBackdrop {
 public:
  // `planes`: R, G, B, A.
  PictureOverBackdrop(const std::vector<Array<float>>& planes, const Backdrop& backdrop, const Directions& directions,
                      const std::optional<py::dict>& haze_fields)
      : planes_(planes),
        corner_(vector_of(std::get<0>(directions), "corner")),
        across_(vector_of(std::get<1>(directions), "across")),
        down_(vector_of(std::get<2>(directions), "down")) {
    const auto& [added, faces, sky_share, srgb] = backdrop;
    added_ = vector_of(added, "added");
    sky_share_ = static_cast<float>(sky_share);
    if (planes.size() != 4) throw Error(SIDERAY_INVALID_ARGUMENT, "planes: give R, G, B and A");
    for (const Array<float>& plane : planes) require_shape(plane, {height(), width()}, "planes");
    if (faces && (sky_share != 0.0 || haze_fields)) sky_.emplace(*faces, srgb);
    if (haze_fields) haze_ = haze_of(*haze_fields, height() * width());
    for (size_t k = 0; k < 4; ++k) rgba_[k] = planes[k].data();
  }
  py::ssize_t height() const { return planes_[0].shape(0); }
  py::ssize_t width() const { return planes_[0].shape(1); }

  Vec3 color(py::ssize_t x, py::ssize_t y) const {
    const py::ssize_t pixel = y * width() + x;
    const float clear = 1.0f - rgba_[3][pixel];
    Vec3 missing = added_;
    if (clear > 0.0f && sky_ && sky_share_ != 0.0f) {
      const Vec3 seen = sky_->look_up(direction(x, y));
      for (size_t k = 0; k < 3; ++k) missing[k] += sky_share_ * seen[k];
    }
    Vec3 color;
    for (size_t k = 0; k < 3; ++k) color[k] = rgba_[k][pixel] + (clear > 0.0f ? clear * missing[k] : 0.0f);
    if (haze_ && haze_->is_at(pixel)) blur(direction(x, y), haze_->surfaces.data()[pixel] != 0, color);
    return color;
  }

 private:
  Vec3 direction(py::ssize_t x, py::ssize_t y) const {
    Vec3 d;
    for (size_t k = 0; k < 3; ++k)
      d[k] = corner_[k] + static_cast<float>(x) * across_[k] + static_cast<float>(y) * down_[k];
    return d;
  }
  void blur(const Vec3& d, bool is_surface, Vec3& color) const {
    const float slope = haze_->slope(d), part = haze_->share_at(slope);
    if (is_surface && slope < 1.0f && sky_) color = sky_->look_up(d);
    for (size_t k = 0; k < 3; ++k) color[k] += part * (haze_->color[k] - color[k]);
  }

  const std::vector<Array<float>>& planes_;
  std::array<const float*, 4> rgba_;
  const Vec3 corner_, across_, down_;
  Vec3 added_;
  float sky_share_;
  std::optional<Sky> sky_;
  std::optional<Haze> haze_;
};

// Returns (height, width, 3), float32, or uint8 with as_bytes. haze: the fields of Haze.
py::array with_backdrop(const std::vector<Array<float>>& planes, const Backdrop& backdrop, const Directions& directions,
                        py::ssize_t threads, const std::optional<py::dict>& haze, bool as_bytes) {
  const PictureOverBackdrop picture(planes, backdrop, directions, haze);
  const py::ssize_t height = picture.height(), width = picture.width();
  const std::vector<py::ssize_t> shape{height, width, 3};
  py::array result = as_bytes ? py::array(py::array_t<uint8_t>(shape)) : py::array(py::array_t<float>(shape));
  void* const pixels = result.mutable_data();
  py::gil_scoped_release released;
  by_rows(height, width, threads, [&](py::ssize_t first, py::ssize_t end) {
    for (py::ssize_t y = first; y < end; ++y)
      for (py::ssize_t x = 0, i = y * width; x < width; ++x, ++i) {
        const Vec3 color = picture.color(x, y);
        if (as_bytes)
          std::ranges::transform(color, static_cast<uint8_t*>(pixels) + 3 * i, byte_of);
        else
          std::ranges::copy(color, static_cast<float*>(pixels) + 3 * i);
      }
  });
  return result;
}

}  // namespace

void define_backdrop(py::module_& module) {
  module.def("with_backdrop", with_backdrop, py::arg("planes"), py::arg("backdrop"), py::arg("directions"),
             py::arg("threads"), py::arg("haze"), py::arg("as_bytes"));
}

}  // namespace sideray::python
