#pragma once
/// Sines and cosines of several angles at once.

namespace hecaton::planner {

/// Fills sine[i] and cosine[i] for angle[i] [rad], i < count. Precondition: all arrays hold the next multiple of four
/// elements. The error is at most 2 units in the last place of 1 for angles up to 10⁶. Results are bit-identical on
/// every machine, unlike those of the C library. Thread-safe.
void sine_cosine(const double* angle, int count, double* sine, double* cosine);

// One compilation for each instruction set; sine_cosine() selects one at run time.
namespace baseline {
void sine_cosine(const double* angle, int count, double* sine, double* cosine);
}
namespace avx2 {
void sine_cosine(const double* angle, int count, double* sine, double* cosine);
}

}  // namespace hecaton::planner
