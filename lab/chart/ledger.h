// The error of a picture split over the shortcuts taken for it (docs/ledger.md). Plain memory; any thread.
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

// A part of the error, in linear radiance. What all terms say, but for `mean_absolute`, adds up to what the total says.
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
  uint64_t nonfinite = 0;  // pixels of any picture; they are 0 in every term
};

// `without`: one picture a shortcut, with that one switched off. `chain`: the picture with all of them switched off,
// and from there on towards the reference; the residual of a name goes from the picture of that name to the next. The last
// `references` of them are references themselves, of less light. In pixels marked in `apart` the residual of the last one
// that is none is one of its own, named "visibility", at the end; empty: none are. Throws Error where sizes differ or an
// image lacks R, G or B.
Ledger make_ledger(const scenes::Image& picture, std::span<const LedgerPicture> without,
                   std::span<const LedgerPicture> chain, const scenes::Image& reference,
                   std::span<const uint8_t> apart = {}, size_t references = 0);

// Effects, interaction, residuals: what adds up to the total.
std::vector<const LedgerTerm*> parts(const Ledger& ledger);

// {"name", "share", "relmse", "mean", "mean_absolute"}
Json to_json(const LedgerTerm& term);

// All terms as channels NAME.R, NAME.G, NAME.B, in 32 bits; residuals as residual.NAME.R.
scenes::Image layers_of(const Ledger& ledger);

// 8-bit RGB of the sum of a term's channels: white 0, red above it, blue below, full at +-`largest` (see
// largest_shown).
std::vector<uint8_t> signed_colours(const LedgerTerm& term, double largest);
// What 99 of 100 pixels of the total stay below.
double largest_shown(const Ledger& ledger);

}  // namespace sideray::lab
