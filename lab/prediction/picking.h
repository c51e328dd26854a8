// Which of several configurations a bound on time or error picks, measured no further than the choice needs. Plain
// memory; any thread.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace sideray::lab {

struct CostBounds {
  std::optional<double> most_ms, most_error;
  bool any() const { return most_ms || most_error; }
};

// A reduced frame.
struct Look {
  double ms = 0;
  std::optional<double> error;  // empty: it cannot be told, and no bound on it holds
};

struct Candidate {
  size_t drawing = 0, shadows = 0;  // which way of either: equal numbers are the same way
  size_t kind = 0;                  // of those whose frames grow alike with the picture
  std::optional<Look> look;         // empty until it is asked for, as the next
  std::optional<double> ms;         // of the whole frame
};

enum class PickStep {
  look,    // ask for a look at the candidate, then come again
  time,    // the same for its ms; it has been looked at
  picked,  // it is the one
  failed   // none holds; this one comes nearest
};

struct Pick {
  PickStep step;
  size_t candidate;
};

// With a bound on the error the cheapest that holds it, else the most accurate that holds the time, or the cheapest of
// those whose error is within 2 % of that; with both the former has to hold the latter too. The first of equals. What
// is picked has been looked at and timed. Others may not:
// - Every way of drawing is looked at with the first candidate's shadows, and every way of shadows with its drawing. A
//   candidate that combines two others is taken to change the first as both of them do, until it may be the one.
// - A reduced frame's time tells which candidates need no other: a picture's cost grows with its size by much the same
//   factor within a kind, and less surely so across kinds.
// `candidates` must not be empty.
Pick next_pick(std::span<const Candidate> candidates, const CostBounds& bounds);

// What is known of each, or taken to be as above. Empty where neither can be told yet.
std::optional<Look> expected_look(std::span<const Candidate> candidates, size_t candidate);

}  // namespace sideray::lab
