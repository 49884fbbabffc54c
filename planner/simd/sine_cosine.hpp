#pragma once
/// Sines and cosines of several angles at once.

namespace hecaton::planner {

/// Fills sine[i] and cosine[i] for angle[i] [rad], i < count. All three arrays have room for the next multiple of four
/// and are used up to there. Within 2 units of the last place of 1 for angles up to a
/// million; the same to the last bit on every machine, which the C library does not promise.
void sine_cosine(const double* angle, int count, double* sine, double* cosine);

using SineCosine = void (*)(const double* angle, int count, double* sine, double* cosine);

namespace baseline {
void sine_cosine(const double* angle, int count, double* sine, double* cosine);
}
namespace avx2 {
void sine_cosine(const double* angle, int count, double* sine, double* cosine);
}

}  // namespace hecaton::planner
