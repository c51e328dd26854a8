// Picks a configuration by a bound on time or error, with as few measurements as possible. Plain memory; any thread may
// call it.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace sideray::lab {

struct CostBounds {
  std::optional<double> most_ms, most_error;
  bool any() const { return most_ms || most_error; }
};

// Holds the results of a candidate's reduced frame.
struct Look {
  double ms = 0;
  std::optional<double> error;  // empty: unknown, and no bound on the error holds
};

struct Candidate {
  size_t drawing = 0, shadows = 0;  // number of its way of drawing and of shadows; equal numbers are equal ways
  size_t kind = 0;                  // candidates of one kind grow alike with the picture's size
  std::optional<Look> look;         // empty until requested, like the next two
  std::optional<double> ms;         // predicted time of the full frame
  std::optional<double> drawn_ms;   // measured time of the full frame
};

enum class PickStep {
  look,    // measure the candidate's `look`, then call again
  time,    // predict its `ms`, then call again; its `look` is known
  draw,    // measure its `drawn_ms`, then call again; its predicted `ms` is within the bound
  picked,  // this candidate is the result
  failed   // no candidate is within the bounds; this one is nearest
};

struct Pick {
  PickStep step;
  size_t candidate;
};

// Returns the next step of picking a candidate. With a bound on the error, the result is the cheapest candidate within
// it. Without one, it is the most accurate within the bound on time, or the cheapest whose error is within 2 % of that.
// With both bounds, the candidate picked by the error must be within the bound on time too. Of equals the first wins. A
// picked candidate has a `look` and a time; with a bound on time, its full frame has been drawn and is within that
// bound. If the full frame misses the bound, all predictions are scaled by the same factor and another candidate is
// picked (see correction()); the last of `most_corrections` is the fastest candidate. Other candidates are measured
// only as far as needed:
// - Every way of drawing is looked at with the first candidate's shadows, and every way of shadows with its drawing.
//   The effect of a combination is taken as the sum of its two effects until it may be the result.
// - A reduced frame's time rules candidates out: cost grows with picture size by about the same factor within a kind,
//   and less surely across kinds.
// `candidates` must not be empty.
constexpr size_t most_corrections = 3;
Pick next_pick(std::span<const Candidate> candidates, const CostBounds& bounds);

// Corrects predictions by frames that were drawn in full.
struct Correction {
  double scale = 1;  // factor on predicted times, at least 1
  size_t count = 0;  // frames that missed the bound, each of which made the choice start again
};
Correction correction(std::span<const Candidate> candidates, const CostBounds& bounds);

// Returns a candidate's `look` as known, or as expected by the rule above. Empty if neither is known yet.
std::optional<Look> expected_look(std::span<const Candidate> candidates, size_t candidate);

}  // namespace sideray::lab
