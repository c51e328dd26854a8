#include "lab/chart/ledger.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <sideray/sideray.hpp>

namespace sideray::lab {
namespace {

using scenes::Image;

constexpr std::array<const char*, 3> colours{"R", "G", "B"};

// Refers to the stored colours of one picture.
struct Rgb {
  std::array<const std::vector<float>*, 3> planes{};
  double at(size_t pixel, size_t colour) const { return double{(*planes[colour])[pixel]}; }
  bool is_finite(size_t pixel) const {
    return std::all_of(planes.begin(), planes.end(),
                       [&](const std::vector<float>* plane) { return std::isfinite((*plane)[pixel]); });
  }
};

Rgb rgb_of(const Image& image, const Image& reference, const std::string& name) {
  if (image.width != reference.width || image.height != reference.height)
    throw Error(SIDERAY_INVALID_ARGUMENT,
                fmt::format("ledger: {} is {}x{}, the reference {}x{}; give pictures of one size", name, image.width,
                            image.height, reference.width, reference.height));
  Rgb rgb;
  for (size_t c = 0; c < 3; ++c) {
    const scenes::Plane* plane = image.find(colours[c]);
    if (!plane || plane->values.size() != size_t{image.width} * image.height)
      throw Error(SIDERAY_INVALID_ARGUMENT,
                  fmt::format("ledger: {} has no channel {}; give pictures with R, G and B", name, colours[c]));
    rgb.planes[c] = &plane->values;
  }
  return rgb;
}

// Accumulates one term.
struct Sum {
  LedgerTerm* term;
  double along = 0, weighted = 0, plain = 0, absolute = 0;

  void add(size_t at, double value, double total, double reference) {
    term->rgb[at] = static_cast<float>(value);
    along += value * total;
    weighted += value * total / (reference * reference + 0.01);
    plain += value;
    absolute += std::abs(value);
  }
  void finish(double squares, size_t values) {
    const double count = static_cast<double>(std::max<size_t>(values, 1));
    if (squares > 0) term->share = along / squares;
    term->relmse = weighted / count;
    term->mean = plain / count;
    term->mean_absolute = absolute / count;
  }
};

std::vector<Rgb> all_rgb(std::span<const LedgerPicture> pictures, const Image& reference) {
  std::vector<Rgb> list;
  for (const LedgerPicture& picture : pictures) list.push_back(rgb_of(picture.image, reference, picture.name));
  return list;
}

// Halfs and their differences are exact in doubles, and so is the sum of the terms.
struct Summation {
  Rgb picture, reference;
  std::vector<Rgb> without, chain;
  Sum total, interaction;
  std::vector<Sum> effects, residuals;
  std::span<const uint8_t> apart;  // 1 for pixels whose last residual is "visibility"
  size_t references;

  bool is_finite(size_t pixel) const {
    const auto finite = [&](const Rgb& rgb) { return rgb.is_finite(pixel); };
    return finite(picture) && finite(reference) && std::all_of(without.begin(), without.end(), finite) &&
           std::all_of(chain.begin(), chain.end(), finite);
  }

  void add(size_t pixel, size_t colour) {
    const size_t at = 3 * pixel + colour;
    const double shown = picture.at(pixel, colour), truth = reference.at(pixel, colour), error = shown - truth;
    double left = error;
    const auto part = [&](Sum& sum, double value) {
      sum.add(at, value, error, truth);
      left -= value;
    };
    for (size_t i = 0; i < without.size(); ++i) part(effects[i], shown - without[i].at(pixel, colour));
    for (size_t i = 0; i < chain.size(); ++i) {
      const double next = i + 1 < chain.size() ? chain[i + 1].at(pixel, colour) : truth;
      const bool is_apart = !apart.empty() && i + 1 + references == chain.size() && apart[pixel] != 0;
      part(is_apart ? residuals.back() : residuals[i], chain[i].at(pixel, colour) - next);
    }
    interaction.add(at, left, error, truth);
    total.add(at, error, error, truth);
  }

  void finish(size_t values) {
    const double squares = total.along;
    for (std::vector<Sum>* sums : {&effects, &residuals})
      for (Sum& sum : *sums) sum.finish(squares, values);
    interaction.finish(squares, values);
    total.finish(squares, values);
  }
};

double sum_of(const LedgerTerm& term, size_t pixel) {
  return double{term.rgb[3 * pixel]} + double{term.rgb[3 * pixel + 1]} + double{term.rgb[3 * pixel + 2]};
}

}  // namespace

Ledger make_ledger(const Image& picture, std::span<const LedgerPicture> without, std::span<const LedgerPicture> chain,
                   const Image& reference, std::span<const uint8_t> apart, size_t references) {
  const size_t pixels = size_t{reference.width} * reference.height;
  const auto term = [&](const std::string& name) {
    return LedgerTerm{name, std::vector<float>(3 * pixels), {}, 0, 0, 0};
  };
  Ledger ledger{reference.width, reference.height, term("total"), {}, term("interaction"), {}, 0};
  for (const LedgerPicture& one : without) ledger.effects.push_back(term(one.name));
  for (const LedgerPicture& one : chain) ledger.residuals.push_back(term(one.name));
  if (!apart.empty()) ledger.residuals.push_back(term("visibility"));
  Summation sums{rgb_of(picture, reference, "the picture"),
                 rgb_of(reference, reference, "the reference"),
                 all_rgb(without, reference),
                 all_rgb(chain, reference),
                 {&ledger.total},
                 {&ledger.interaction},
                 {},
                 {},
                 apart,
                 references};
  for (LedgerTerm& effect : ledger.effects) sums.effects.push_back({&effect});
  for (LedgerTerm& residual : ledger.residuals) sums.residuals.push_back({&residual});
  for (size_t pixel = 0; pixel < pixels; ++pixel) {
    if (!sums.is_finite(pixel)) {
      ++ledger.nonfinite;
      continue;
    }
    for (size_t colour = 0; colour < 3; ++colour) sums.add(pixel, colour);
  }
  sums.finish(3 * pixels);
  return ledger;
}

std::vector<const LedgerTerm*> parts(const Ledger& ledger) {
  std::vector<const LedgerTerm*> list;
  for (const LedgerTerm& effect : ledger.effects) list.push_back(&effect);
  list.push_back(&ledger.interaction);
  for (const LedgerTerm& residual : ledger.residuals) list.push_back(&residual);
  return list;
}

Json to_json(const LedgerTerm& term) {
  Json json = {{"name", term.name}};
  if (term.share) json["share"] = *term.share;
  json["relmse"] = term.relmse;
  json["mean"] = term.mean;
  json["mean_absolute"] = term.mean_absolute;
  return json;
}

Image layers_of(const Ledger& ledger) {
  Image image{ledger.width, ledger.height, {}, true};
  const auto add = [&](const LedgerTerm& term, const std::string& prefix) {
    for (size_t c = 0; c < 3; ++c) {
      scenes::Plane plane{prefix + term.name + "." + colours[c], scenes::Plane::Type::single, {}, {}};
      plane.values.reserve(term.rgb.size() / 3);
      for (size_t i = c; i < term.rgb.size(); i += 3) plane.values.push_back(term.rgb[i]);
      image.planes.push_back(std::move(plane));
    }
  };
  add(ledger.total, "");
  for (const LedgerTerm& effect : ledger.effects) add(effect, "");
  add(ledger.interaction, "");
  for (const LedgerTerm& residual : ledger.residuals) add(residual, "residual.");
  return image;
}

std::vector<uint8_t> signed_colours(const LedgerTerm& term, double largest) {
  constexpr std::array<double, 3> above{178, 24, 43}, below{33, 102, 172};
  std::vector<uint8_t> rgb;
  rgb.reserve(term.rgb.size());
  for (size_t pixel = 0; pixel < term.rgb.size() / 3; ++pixel) {
    const double value = sum_of(term, pixel);
    const double part = largest > 0 ? std::min(std::abs(value) / largest, 1.0) : 0.0;
    for (size_t c = 0; c < 3; ++c)
      rgb.push_back(static_cast<uint8_t>(std::lround(255.0 + part * ((value > 0 ? above : below)[c] - 255.0))));
  }
  return rgb;
}

double largest_shown(const Ledger& ledger) {
  std::vector<double> sizes(ledger.total.rgb.size() / 3);
  if (sizes.empty()) return 0;
  for (size_t i = 0; i < sizes.size(); ++i) sizes[i] = std::abs(sum_of(ledger.total, i));
  const auto at = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() * 99 / 100);
  std::nth_element(sizes.begin(), at, sizes.end());
  // If less than a hundredth of the pixels is wrong, their largest value is shown.
  return *at > 0 ? *at : *std::max_element(sizes.begin(), sizes.end());
}

}  // namespace sideray::lab
