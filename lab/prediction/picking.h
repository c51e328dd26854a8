// Picks one of several configurations by a bound on time or error, with as few measurements as the choice needs.
// Plain memory; any thread may call it.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace sideray::lab {

struct CostBounds {
  std::optional<double> most_ms, most_error;
  bool any() const { return most_ms || most_error; }
};

// Holds the measurements of a candidate's reduced frame.
struct Look {
  double ms = 0;
  std::optional<double> error;  // empty: unknown, so that no bound on it holds
};

struct Candidate {
  size_t drawing = 0, shadows = 0;  // equal numbers are the same way to draw or to shadow
  size_t kind = 0;                  // the times of one kind grow alike with the picture's size
  std::optional<Look> look;         // empty until next_pick() asks for it, as for the next two
  std::optional<double> ms;         // predicted time of the whole frame
  std::optional<double> drawn_ms;   // measured time of the whole frame
};

enum class PickStep {
  look,    // measure the candidate's look, then call again
  time,    // predict its ms, then call again; its look is known
  draw,    // measure its drawn_ms, then call again; its predicted ms holds the bound
  picked,  // this candidate is picked
  failed   // no candidate holds the bounds; this one comes nearest
};

struct Pick {
  PickStep step;
  size_t candidate;
};

// Picks a candidate. With a bound on the error it is the cheapest that holds the bound. With a bound on the time alone
// it is the cheapest of the candidates whose error is within 2 % of the least error that the time allows. With both
// bounds the candidate picked by its error must hold the time too. Of equals the first is picked. A picked candidate
// has `look` and `ms`. With a bound on the time it also has `drawn_ms`, which holds the bound. Where `drawn_ms` misses
// the bound, all predictions are corrected by the same factor, and another candidate is picked (correction()); after
// `most_corrections` it is the fastest. Most candidates that are not picked are not measured:
// - Every way to draw is measured with the first candidate's shadows, and every way to shadow with its drawing. The
//   effects of both on the first candidate are added up for a candidate that combines them, until it may be picked.
// - The time of a reduced frame can rule a candidate out: time grows with the picture's size by much the same factor
//   within a kind, and by a less certain one across kinds.
// `candidates` must not be empty.
constexpr size_t most_corrections = 3;
Pick next_pick(std::span<const Candidate> candidates, const CostBounds& bounds);

// Holds the correction of predicted times by whole frames that were measured.
struct Correction {
  double scale = 1;  // factor on predicted times, at least 1
  size_t count = 0;  // measured frames that missed the bound, each followed by another pick
};
Correction correction(std::span<const Candidate> candidates, const CostBounds& bounds);

// Returns a candidate's look, or the one expected by the rules above. Empty where neither is known yet.
std::optional<Look> expected_look(std::span<const Candidate> candidates, size_t candidate);

}  // namespace sideray::lab
