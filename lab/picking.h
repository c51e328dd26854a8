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

struct Candidate {
  std::optional<double> error;  // empty: it cannot be told, and no bound on it holds
  double small_ms = 0;          // of a reduced frame
  std::optional<double> ms;     // of the whole frame; empty until it is asked for
};

enum class PickStep {
  time,    // ask for ms of the candidate, then come again
  picked,  // it is the one
  failed   // none holds; this one comes nearest
};

struct Pick {
  PickStep step;
  size_t candidate;
};

// With a bound on the error the cheapest that holds it, else the most accurate that holds the time; with both the
// former has to hold the latter too. The first of equals. A reduced frame's time tells which candidates need no other:
// a picture's cost grows with its size by much the same factor whatever draws it. `candidates` must not be empty.
Pick next_pick(std::span<const Candidate> candidates, const CostBounds& bounds);

}  // namespace sideray::lab
