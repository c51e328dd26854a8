// Picks one of several configurations by a bound on time or error, with no more measurements than the choice needs.
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

// Holds what a reduced frame shows of a candidate.
struct Look {
  double ms = 0;
  std::optional<double> error;  // empty: it is unknown, and no bound on it holds
};

struct Candidate {
  size_t drawing = 0, shadows = 0;  // number of the way of either: equal numbers are the same way
  size_t kind = 0;                  // candidates whose frames grow alike with the picture are of one kind
  std::optional<Look> look;         // empty until it is requested, as the next
  std::optional<double> ms;         // foretold time of the whole frame
  std::optional<double> drawn_ms;   // the same, measured: the frame was drawn whole
};

enum class PickStep {
  look,    // look at the candidate, then call again
  time,    // foretell its ms, then call again; it has been looked at
  draw,    // measure its drawn_ms, then call again; its ms is foretold to hold the bound
  picked,  // this candidate is picked
  failed   // no candidate holds; this one comes nearest
};

struct Pick {
  PickStep step;
  size_t candidate;
};

// Picks a candidate. With a bound on the error that is the cheapest that holds it; without one it is the most accurate
// that holds the time, or the cheapest of those whose error is within 2 % of that. With both bounds the candidate
// picked by the error has to hold the time too. Of equals the first is picked. A picked candidate has been looked at
// and timed. With a bound on the time its frame has been drawn whole too, and holds that bound. Where it misses it,
// everything that was foretold is taken to be missed by the same factor, and another one is picked (see correction());
// the last of `most_corrections` is the fastest candidate. Candidates that are not picked may be neither looked at nor
// timed:
// - Every way of drawing is looked at with the first candidate's shadows, and every way of shadows with its drawing. A
//   candidate that combines two others is taken to change the first as both of them do, until it may be the one.
// - A reduced frame's time tells which candidates need no other: a picture's cost grows with its size by much the same
//   factor within a kind, and less surely so across kinds.
// `candidates` must not be empty.
constexpr size_t most_corrections = 3;
Pick next_pick(std::span<const Candidate> candidates, const CostBounds& bounds);

// Holds what frames that were drawn whole say of what was foretold.
struct Correction {
  double scale = 1;  // foretold times count as so many times as long; at least 1
  size_t count = 0;  // frames that missed the bound: so often it was chosen anew
};
Correction correction(std::span<const Candidate> candidates, const CostBounds& bounds);

// Returns what is known of a candidate, or expected as described above. Empty where neither is known yet.
std::optional<Look> expected_look(std::span<const Candidate> candidates, size_t candidate);

}  // namespace sideray::lab
