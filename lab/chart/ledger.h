// Splits the error of a picture over its shortcuts (docs/ledger.md). Plain memory; any thread.
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

// A part of the error, in linear radiance. All values except `mean_absolute` add up over terms to those of the total.
struct LedgerTerm {
  std::string name;
  std::vector<float> rgb;       // R, G, B interleaved, top row first
  std::optional<double> share;  // <term, total> / <total, total>; empty if there is no error
  double relmse = 0;            // mean of term * total / (reference^2 + 0.01)
  double mean = 0, mean_absolute = 0;
};

struct Ledger {
  uint32_t width = 0, height = 0;
  LedgerTerm total;                 // the picture minus the reference
  std::vector<LedgerTerm> effects;  // one a shortcut: the picture minus the one without it
  LedgerTerm interaction;           // total - effects - residuals
  std::vector<LedgerTerm> residuals;
  uint64_t nonfinite = 0;  // pixels not finite in some picture; they are 0 in every term
};

// Computes the terms. `without`: one picture for each shortcut, with only that one switched off. `chain`: the picture
// with all of them switched off, and further pictures towards the reference; the residual of a name is the step from
// its picture to the next. The last `references` pictures of the chain are references with less light. `apart` marks
// pixels in which the step of the last picture that is not a reference counts as a separate residual, "visibility", at
// the end; empty: none. Throws Error if sizes differ or an image lacks R, G or B.
Ledger make_ledger(const scenes::Image& picture, std::span<const LedgerPicture> without,
                   std::span<const LedgerPicture> chain, const scenes::Image& reference,
                   std::span<const uint8_t> apart = {}, size_t references = 0);

// Returns the terms that add up to the total: effects, interaction, residuals.
std::vector<const LedgerTerm*> parts(const Ledger& ledger);

// Returns {"name", "share", "relmse", "mean", "mean_absolute"}.
Json to_json(const LedgerTerm& term);

// Returns all terms as channels NAME.R, NAME.G, NAME.B of 32 bits; residuals as residual.NAME.R.
scenes::Image layers_of(const Ledger& ledger);

// Returns 8-bit RGB for the sum of a term's channels: white at 0, red above, blue below, saturated at +-`largest` (see
// largest_shown).
std::vector<uint8_t> signed_colours(const LedgerTerm& term, double largest);
// Returns the value that 99 of 100 pixels of the total stay below.
double largest_shown(const Ledger& ledger);

}  // namespace sideray::lab
