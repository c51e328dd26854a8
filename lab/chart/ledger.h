// Splits the error of a picture over the shortcuts taken for it (docs/ledger.md). Plain memory; any thread.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lab/chart/chart_row.h"
#include "scenes/images/images.h"

namespace sideray::lab {

struct LedgerPicture {
  std::string name;
  scenes::Image image;
};

// Holds a part of the error, in linear radiance. The values of all terms add up to those of the total, except
// `mean_absolute`.
struct LedgerTerm {
  std::string name;
  std::vector<float> rgb;       // R, G, B interleaved, top row first
  std::optional<double> share;  // <term, total> / <total, total>; empty where there is no error to share
  double relmse = 0;            // mean of term * total / (reference^2 + 0.01)
  double mean = 0, mean_absolute = 0;
};

struct Ledger {
  uint32_t width = 0, height = 0;
  LedgerTerm total;                 // the picture minus the reference
  std::vector<LedgerTerm> effects;  // the picture minus the one without the shortcut
  LedgerTerm interaction;           // total - effects - residuals
  std::vector<LedgerTerm> residuals;
  uint64_t nonfinite = 0;  // pixels with such values in any picture; every term is 0 there
};

// `without` has a picture for each shortcut, with that one switched off. `chain` starts with the picture without any
// shortcut and goes on towards the reference; the residual of a name is the picture of that name minus the next. The
// last `references` pictures of the chain are references themselves, with less light. In pixels that `apart` marks, the
// residual of the last picture before these counts as a separate one, "visibility", at the end; an empty `apart` marks
// none. Throws Error where sizes differ or an image lacks R, G or B.
Ledger make_ledger(const scenes::Image& picture, std::span<const LedgerPicture> without,
                   std::span<const LedgerPicture> chain, const scenes::Image& reference,
                   std::span<const uint8_t> apart = {}, size_t references = 0);

// Returns effects, interaction and residuals, which add up to the total.
std::vector<const LedgerTerm*> parts(const Ledger& ledger);

// Returns {"name", "share", "relmse", "mean", "mean_absolute"}.
Json to_json(const LedgerTerm& term);

// Returns all terms as channels NAME.R, NAME.G, NAME.B, in 32 bits; residuals as residual.NAME.R.
scenes::Image layers_of(const Ledger& ledger);

// Returns 8-bit RGB of the sum of a term's channels: white at 0, red above, blue below, saturated at +-`largest`
// (largest_shown()).
std::vector<uint8_t> signed_colours(const LedgerTerm& term, double largest);
// Returns the 99th percentile of the total's magnitude.
double largest_shown(const Ledger& ledger);

}  // namespace sideray::lab
