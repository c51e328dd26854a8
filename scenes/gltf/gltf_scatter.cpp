#include <algorithm>
#include <cmath>

#include "elementary/functions.h"
#include "scenes/gltf/gltf.h"

// Reads KHR_materials_volume_scatter. Light scattered inside a body is shown as diffuse reflection and transmission of
// its surface, as strong as those of a slab of the material's thickness.
namespace sideray::scenes::gltf {
namespace {

constexpr const char* scatter_extension = "KHR_materials_volume_scatter";

// Holds the shares of diffuse light that a slab reflects and transmits (Kubelka and Munk 1931). `albedo` is the
// reflectance of an infinite slab, `depth` the scattering coefficient times the thickness.
struct Slab {
  double back, through;
};
Slab slab_of(double albedo, double depth) {
  if (!(albedo > 0.0)) return {0.0, 0.0};
  const double limited = std::min(albedo, 0.9999);
  const double a = 0.5 * (1.0 / limited + limited), b = 0.5 * (1.0 / limited - limited);
  const double e = elementary::exp(-b * depth), sum = a * (1.0 - e * e) + b * (1.0 + e * e);
  return {(1.0 - e * e) / sum, 2.0 * b * e / sum};
}

// Returns the single-scattering albedo for a multiple-scattering albedo (Kulla and Conty 2017).
double single_albedo(double multiple) {
  const double s =
      4.09712 + 4.20863 * multiple - std::sqrt(9.59217 + 41.6808 * multiple + 17.7126 * multiple * multiple);
  return std::clamp(1.0 - s * s, 0.0, 1.0);
}

// Holds the shares of the light on a surface that are reflected, transmitted diffusely, and transmitted straight.
struct Shares {
  glm::dvec3 back, through, straight;
};

Shares shares_of(const Scattering& scattering, const sideray_material_desc& d) {
  Shares shares{};
  const double thickness = double{d.thickness}, enters = double{d.transmission};
  const double diffuse = 1.0 - enters, passes = double{d.diffuse_transmission};
  for (int c = 0; c < 3; ++c) {
    const double color = std::max(double{d.attenuation_color[c]}, 1e-6);
    const double extinction = -elementary::log(color) / double{d.attenuation_distance};
    const double unscattered = elementary::exp(-extinction * thickness);
    const double albedo = scattering.color[c];
    // The coefficient of the flux model is 3/4 of that of radiance, without the forward scattered part.
    const double scatters = 0.75 * single_albedo(albedo) * (1.0 - scattering.anisotropy) * extinction;
    const Slab slab = slab_of(albedo, scatters * thickness);
    const double base = double{d.base_color[c]}, behind = double{d.diffuse_transmission_color[c]};
    shares.back[c] = diffuse * (1.0 - passes) * base + (enters * base + diffuse * passes * behind) * slab.back;
    shares.through[c] =
        enters * base * std::max(slab.through - unscattered, 0.0) + diffuse * passes * behind * slab.through;
    shares.straight[c] = enters * base * unscattered;
  }
  return shares;
}

double most_of(const glm::dvec3& v) {
  return std::max({v.x, v.y, v.z});
}

float clamped(double value) {
  return static_cast<float>(std::clamp(value, 0.0, 1.0));
}

// Sets the material's properties so that it shows these shares.
void show(const Shares& shares, sideray_material_desc& d) {
  constexpr double least_shown = 1.0 / 255.0;
  const double straight = most_of(shares.straight), back = most_of(shares.back), through = most_of(shares.through);
  const double transmission = straight < least_shown ? 0.0 : std::min(straight, 1.0);
  const double passes = through > 0.0 ? through / (through + back) : 0.0;
  const double diffuse = std::max(1.0 - transmission, 1e-6);
  d.transmission = clamped(transmission);
  d.diffuse_transmission = clamped(passes);
  for (int c = 0; c < 3; ++c) {
    d.base_color[c] = passes < 1.0 ? clamped(shares.back[c] / (diffuse * (1.0 - passes))) : 0.0f;
    d.diffuse_transmission_color[c] = passes > 0.0 ? clamped(shares.through[c] / (diffuse * passes)) : 1.0f;
    const double tint = transmission * std::max(double{d.base_color[c]}, 1e-6);
    d.attenuation_color[c] = transmission > 0.0 ? clamped(shares.straight[c] / tint) : 1.0f;
  }
  d.attenuation_distance = transmission > 0.0 ? d.thickness : std::numeric_limits<float>::infinity();
}

}  // namespace

std::optional<Scattering> read_scattering(const File& file, const tinygltf::Material& source, const std::string& user,
                                          Content& content) {
  const tinygltf::Value* e = extension(source.extensions, scatter_extension);
  if (e == nullptr) return std::nullopt;
  if (e->Has("multiscatterColorTexture"))
    content.warnings.push_back(fmt::format("{}: its multiscatterColorTexture is not read; give the mean of "
                                           "its colours as multiscatterColorFactor", user));
  // Early drafts, and files of that time, call it multiscatterColor.
  const char* key = e->Has("multiscatterColorFactor") ? "multiscatterColorFactor" : "multiscatterColor";
  const std::vector<double> color = numbers(file, *e, key, {0, 0, 0});
  Scattering scattering{{color[0], color[1], color[2]}, number(file, *e, "scatterAnisotropy", 0.0)};
  if (std::any_of(color.begin(), color.end(), [](double c) { return c < 0.0 || c > 1.0; }))
    refuse("cannot read {}: {} of {} is outside 0 to 1; correct it", file.path, key, user);
  if (!(std::abs(scattering.anisotropy) < 1.0))
    refuse("cannot read {}: scatterAnisotropy of {} is {}, outside -1 to 1; correct it", file.path, user,
           scattering.anisotropy);
  return scattering;
}

void show_scattering(const std::map<uint32_t, Scattering>& scattering, std::span<const ScaledMaterial> scaled,
                     Content& content) {
  size_t shown = 0;
  const auto approximate = [&](const Scattering& s, uint32_t material) {
    sideray_material_desc& d = content.materials[material].desc;
    if (!(d.thickness > 0.0f) || !std::isfinite(d.attenuation_distance)) return;
    show(shares_of(s, d), d);
    ++shown;
  };
  for (const ScaledMaterial& s : scaled)
    if (const auto found = scattering.find(s.source); found != scattering.end()) approximate(found->second, s.material);
  if (shown > 0)
    content.warnings.push_back(fmt::format(
        "{}: what {} material{} scatter{} inside is shown as diffuse light of the surface", scatter_extension, shown,
        shown == 1 ? "" : "s", shown == 1 ? "s" : ""));
  else if (!scattering.empty())
    content.warnings.push_back(fmt::format("{}: without KHR_materials_volume of a thickness and an attenuation nothing "
                                           "scatters",
                                           scatter_extension));
}

}  // namespace sideray::scenes::gltf
